//! Pictures by way of queues: rounds of launches, until all paths of a band, or nodes of its trees, have ended.

use crate::device::Kernel;
use crate::launch_buffers::Band;
use crate::pixel::Pixel;
use crate::queue_room::{QueueAddresses, QueueRoom, Queued};
use crate::stages::{Stage, Stages};
use cudarc::driver::{CudaStream, DevicePtr, DeviceRepr, DriverError, LaunchConfig, PushKernelArg};
use eosphor_core::device::{LightQueue, PathControl, PathLaunch, RayTotals};
use eosphor_core::math::Vec3;
use eosphor_core::sums::ExactSum;
use eosphor_core::view::SceneCounts;
use std::ops::Range;
use std::ptr::null_mut;
use std::sync::Arc;

/// Kernels that work on queues, over a structure.
pub(crate) struct QueueKernels {
    pub(crate) of: Queued,
    /// Makes the ring of free slots, where there is one.
    pub(crate) prepare: Option<Kernel>,
    pub(crate) begin: Kernel,
    pub(crate) generate: Kernel,
    pub(crate) find_hits: Kernel,
    pub(crate) shading: Vec<ShadeKernel>,
    /// Nodes of trees whose rays end at a surface are listed apart, for the first of these.
    pub(crate) lists_ends: bool,
    /// Finds which lights are seen.
    pub(crate) see_lights: Kernel,
    /// The name of what finds out what comes through surfaces that are in the way: it is loaded where shadows have colours.
    pub(crate) crossed: &'static str,
    /// What makes shadow rays and what adds up their light, of trees.
    pub(crate) lighting: Option<[Kernel; 2]>,
    pub(crate) settle: Kernel,
}

/// What a frame says of the rays in queues.
#[derive(Clone)]
pub(crate) struct FrameKind {
    /// Bounces that paths may have.
    pub(crate) depth: u32,
    /// How many shadow rays a point has at most.
    pub(crate) light_rays: u32,
    /// Whether anything casts a shadow on what trees of rays find.
    pub(crate) has_shadows: bool,
    /// Finds what comes through surfaces that are in the way; `None` where shadows have no colour.
    pub(crate) cross: Option<Kernel>,
}

/// A kernel that shades.
pub(crate) struct ShadeKernel {
    pub(crate) kernel: Kernel,
    /// Which of the lists it goes through.
    pub(crate) list: Stage,
    /// Blocks of a launch: as many as run at a time.
    pub(crate) blocks: u32,
}

/// Names of kernels that every structure shares.
pub(crate) struct SharedNames {
    pub(crate) prepare: Option<&'static str>,
    pub(crate) begin: &'static str,
    pub(crate) generate: &'static str,
    /// Of trees those of nodes whose rays end, and of the others.
    pub(crate) shading: &'static [&'static str],
    /// What makes shadow rays and adds up their light, of trees.
    pub(crate) lighting: Option<[&'static str; 2]>,
    pub(crate) settle: &'static str,
}

impl SharedNames {
    pub(crate) fn of(queued: Queued) -> SharedNames {
        match queued {
            Queued::Paths => SharedNames {
                prepare: None,
                begin: "paths_begin",
                generate: "paths_generate",
                shading: &["paths_shade_matte", "paths_shade"],
                lighting: None,
                settle: "paths_settle",
            },
            Queued::Trees => SharedNames {
                prepare: Some("trees_prepare"),
                begin: "trees_begin",
                generate: "trees_generate",
                shading: &["trees_shade_ends", "trees_shade"],
                lighting: Some(["trees_ask", "trees_sum"]),
                settle: "paths_settle",
            },
        }
    }
}

/// Rounds that are launched at a time, at most. With shadow rays in several windows there are fewer, since each is launched.
const MOST_ROUNDS: u32 = 256;

/// Rounds that are launched at a time to end the last paths.
const LAST_ROUNDS: u32 = 12;

/// A band whose paths are under way.
pub(crate) struct QueuedBand {
    /// Samples that no pass has begun with.
    left: Range<u32>,
    /// The samples of this pass.
    pass: Range<u32>,
    is_odd: bool,
}

/// What all launches of a band share.
pub(crate) struct QueueLauncher<'a> {
    pub(crate) kernels: &'a QueueKernels,
    /// What kernels take before the launch, and where the scene's arrays begin in it.
    pub(crate) values: &'a [u64],
    pub(crate) scene_values: usize,
    pub(crate) counts: SceneCounts,
    pub(crate) frame: &'a FrameKind,
    pub(crate) width: u32,
    pub(crate) rows: Range<u32>,
    pub(crate) block_size: u32,
    /// Where it is noted what each launch takes, if that is wanted.
    pub(crate) stages: Option<&'a Stages>,
}

impl QueueLauncher<'_> {
    /// Starts to render the band.
    pub(crate) fn start<T: Pixel>(
        &self,
        samples: Range<u32>,
        band: &mut Band,
    ) -> Result<QueuedBand, DriverError> {
        let stream = Arc::clone(&band.stream);
        assert!(self.pixels() as usize <= queue(band).size().pixels, "the band is larger than its sums");
        queue(band).clear(&stream)?;
        if T::IS_SUM {
            // Passes are merged where they are wanted.
            stream.memset_zeros(&mut band.pixels)?;
        }
        let first = samples.start;
        let mut paths = QueuedBand { left: samples, pass: first..first, is_odd: false };
        self.begin_pass::<T>(&mut paths, band)?;
        Ok(paths)
    }

    /// Waits until all its paths have ended.
    pub(crate) fn finish<T: Pixel>(
        &self,
        paths: &mut QueuedBand,
        band: &mut Band,
    ) -> Result<(), DriverError> {
        let stream = Arc::clone(&band.stream);
        loop {
            let control = queue(band).control(&stream)?;
            if !control.is_done() {
                let rounds = self.rounds(&control, queue(band));
                self.run_rounds::<T>(paths, band, rounds)?;
                continue;
            }
            let launch = self.launch::<T>(paths, band, &stream);
            self.start_kernel(
                &stream,
                (&self.kernels.settle, Stage::Settle),
                &launch,
                Shape::For(self.pixels()),
            )?;
            if paths.left.is_empty() {
                return Ok(());
            }
            self.begin_pass::<T>(paths, band)?;
        }
    }

    fn pixels(&self) -> u32 {
        self.rows.len() as u32 * self.width
    }

    fn begin_pass<T: Pixel>(&self, paths: &mut QueuedBand, band: &mut Band) -> Result<(), DriverError> {
        let stream = Arc::clone(&band.stream);
        // Numbers of samples are of 32 bits.
        let most =
            (u32::MAX / self.pixels().max(1)).min(self.kernels.of.samples_of_pass(self.frame.depth)).max(1);
        let end = paths.left.end.min(paths.left.start.saturating_add(most));
        paths.pass = paths.left.start..end;
        paths.left.start = end;
        let samples = paths.pass.len() as u32 * self.pixels();
        if let (Some(prepare), false) = (&self.kernels.prepare, queue(band).is_prepared) {
            let launch = self.launch::<T>(paths, band, &stream);
            self.start_alone(&stream, (prepare, Stage::Prepare), &launch, launch.slots)?;
            queue(band).is_prepared = true;
        }
        let control = queue(band).begin(&stream, samples)?;
        let rounds = self.rounds(&control, queue(band));
        self.run_rounds::<T>(paths, band, rounds)
    }

    /// How many rounds there may be at least.
    fn rounds(&self, control: &PathControl, queue: &QueueRoom) -> u32 {
        let last = self.frame.depth.saturating_add(1).min(LAST_ROUNDS);
        let taken = u64::from(control.samples - control.samples_left);
        // As fast as until now; at first as fast as can be.
        let full = match taken {
            0 => u64::from(control.samples_left / queue.size().paths),
            taken => u64::from(control.samples_left) * u64::from(control.rounds) / taken,
        };
        let windows = queue.size().light_rays.map_or(1, |rays| rays.windows(self.frame.light_rays));
        (full as u32 + last).min((MOST_ROUNDS / windows).max(1))
    }

    fn run_rounds<T: Pixel>(
        &self,
        paths: &mut QueuedBand,
        band: &mut Band,
        rounds: u32,
    ) -> Result<(), DriverError> {
        let stream = Arc::clone(&band.stream);
        let room = queue(band).size().paths;
        for _ in 0..rounds {
            let launch = self.launch::<T>(paths, band, &stream);
            let QueueKernels { begin, generate, find_hits, shading, lighting, .. } = self.kernels;
            self.start_alone(&stream, (begin, Stage::Begin), &launch, 1)?;
            self.start_kernel(&stream, (generate, Stage::Generate), &launch, Shape::For(room))?;
            self.start_kernel(&stream, (find_hits, Stage::FindHits), &launch, Shape::Traced(room))?;
            for ShadeKernel { kernel, list, blocks } in shading {
                self.start_kernel(&stream, (kernel, *list), &launch, Shape::Blocks(*blocks))?;
            }
            match lighting {
                None => self.trace_light(&stream, &launch, room)?,
                Some([ask, sum]) => {
                    let (all, window) = (self.frame.light_rays, launch.lights.window);
                    for first in (0..all.max(1)).step_by(window as usize) {
                        let lights = LightQueue { first, all, ..launch.lights };
                        let launch = PathLaunch { lights, ..launch };
                        let rays = room * lights.window;
                        self.start_kernel(&stream, (ask, Stage::Ask), &launch, Shape::For(rays))?;
                        self.trace_light(&stream, &launch, rays)?;
                        self.start_kernel(&stream, (sum, Stage::Sum), &launch, Shape::For(room))?;
                    }
                }
            }
            paths.is_odd = !paths.is_odd;
        }
        Ok(())
    }

    /// Traces as many shadow rays, at most.
    fn trace_light(
        &self,
        stream: &Arc<CudaStream>,
        launch: &PathLaunch,
        rays: u32,
    ) -> Result<(), DriverError> {
        if self.kernels.of == Queued::Trees && !self.frame.has_shadows {
            return Ok(());
        }
        self.start_kernel(stream, (&self.kernels.see_lights, Stage::See), launch, Shape::Traced(rays))?;
        match &self.frame.cross {
            Some(cross) => self.start_kernel(stream, (cross, Stage::Cross), launch, Shape::Traced(rays)),
            None => Ok(()),
        }
    }

    fn launch<T: Pixel>(&self, paths: &QueuedBand, band: &mut Band, stream: &Arc<CudaStream>) -> PathLaunch {
        let pixels = band.pixels.device_ptr(stream).0;
        let totals = band.totals.device_ptr(stream).0 as *mut RayTotals;
        let queue = queue(band);
        let addresses = queue.addresses(stream, paths.is_odd);
        let QueueAddresses { paths: own, next, hits, requests, sorted, stack, free, slots, .. } = addresses;
        let QueueAddresses { control, sums, before, lights, hidden, .. } = addresses;
        let hidden = if self.frame.cross.is_some() { hidden } else { null_mut() };
        // Sums are merged where they are wanted; colours are made of them at the end.
        let (before, film) =
            if T::IS_SUM { (pixels as *mut ExactSum, null_mut()) } else { (before, pixels as *mut Vec3) };
        PathLaunch {
            counts: self.counts,
            paths: own,
            next,
            hits,
            requests,
            sorted,
            hidden,
            stack,
            free,
            lights,
            slots,
            lists_ends: self.kernels.lists_ends.into(),
            control,
            sums,
            before,
            film,
            totals,
            room: queue.size().paths,
            first_row: self.rows.start,
            end_row: self.rows.end,
            first_sample: paths.pass.start,
            end_sample: paths.pass.end,
        }
    }

    /// A kernel that takes the launch alone.
    fn start_alone(
        &self,
        stream: &Arc<CudaStream>,
        (kernel, stage): (&Kernel, Stage),
        launch: &PathLaunch,
        threads: u32,
    ) -> Result<(), DriverError> {
        let mut builder = stream.launch_builder(&kernel.function);
        let argument = Argument(*launch);
        builder.arg(&argument);
        let block = threads.min(self.block_size);
        let shape = LaunchConfig {
            grid_dim: (threads.div_ceil(block), 1, 1),
            block_dim: (block, 1, 1),
            shared_mem_bytes: 0,
        };
        // SAFETY: the kernel takes a launch, which is as its type says.
        self.noting(stream, (kernel, stage), launch, || unsafe { builder.launch(shape) }.map(drop))
    }

    fn start_kernel(
        &self,
        stream: &Arc<CudaStream>,
        (kernel, stage): (&Kernel, Stage),
        launch: &PathLaunch,
        shape: Shape,
    ) -> Result<(), DriverError> {
        let argument = Argument(*launch);
        let mut builder = stream.launch_builder(&kernel.function);
        let values = match shape {
            Shape::Traced(_) => self.values,
            _ => &self.values[self.scene_values..],
        };
        for value in values {
            builder.arg(value);
        }
        builder.arg(&argument);
        let blocks = match shape {
            Shape::Blocks(blocks) => blocks,
            Shape::For(items) | Shape::Traced(items) => items.div_ceil(self.block_size),
        };
        let shape = LaunchConfig {
            grid_dim: (blocks.max(1), 1, 1),
            block_dim: (self.block_size, 1, 1),
            shared_mem_bytes: 0,
        };
        // SAFETY: the parameters are those of the kernel, in its order (a test compares them); the arrays are those of a SceneData
        // and a hierarchy over it, whose indices are in range; the queue has the room that the launch says.
        self.noting(stream, (kernel, stage), launch, || unsafe { builder.launch(shape) }.map(drop))
    }

    /// Starts a kernel. Waits for it and notes what it took, where that is wanted.
    fn noting(
        &self,
        stream: &Arc<CudaStream>,
        (kernel, stage): (&Kernel, Stage),
        launch: &PathLaunch,
        start: impl FnOnce() -> Result<(), DriverError>,
    ) -> Result<(), DriverError> {
        let Some(stages) = self.stages else { return start() };
        stages.measure((kernel.name, stage, self.kernels.of), stream, (launch, self.pixels()), start)
    }
}

/// Which kernel it is, and how many threads it gets.
#[derive(Clone, Copy)]
enum Shape {
    /// One that traces no ray: a thread an item.
    For(u32),
    /// One that traces rays: a thread an item.
    Traced(u32),
    /// One that traces no ray, of so many blocks.
    Blocks(u32),
}

fn queue(band: &mut Band) -> &mut QueueRoom {
    band.paths.as_mut().expect("kernels of paths come with queues")
}

/// A [`PathLaunch`] as an argument of a kernel. Its pointers are the device's.
#[repr(transparent)]
struct Argument(PathLaunch);

// SAFETY: the kernel declares the same `repr(C)` type.
unsafe impl DeviceRepr for Argument {}
