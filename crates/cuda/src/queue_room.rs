//! A device's room for queues.

use crate::light_room::{LightRays, PointRays, WARP};
use cudarc::driver::{CudaSlice, CudaStream, DevicePtr, DriverError, result};
use eosphor_core::device::{
    HIT_ROWS, LIT_ROWS, LightQueue, NODE_STRIDE, PATH_ROWS, PROGRESS_ROWS, PathControl, REQUEST_ROWS, Row,
};
use eosphor_core::integrator::MAX_DEPTH;
use eosphor_core::settings::{Integrator, Settings, ShadowMode};
use eosphor_core::sums::ExactSum;
use std::ops::RangeInclusive;
use std::ptr::null_mut;
use std::sync::Arc;

/// Rows of 16 bytes that a path takes: its own of this round and of the next, of its hit, and of what it asks of a light.
const ROWS: usize = 2 * PATH_ROWS + HIT_ROWS + REQUEST_ROWS;

/// Bytes that a path takes in a queue, its number in order of what it has met included.
const PATH_BYTES: u64 = (ROWS * size_of::<Row>() + size_of::<u32>()) as u64;

/// Slots for nodes of trees that there are for each that a round takes. With three a round may take as many as there is room for
/// even where each leaves three.
const SLOTS: u64 = 4;

/// Bytes that each node of a round takes: those of its slots, of their numbers in the stack and in the ring of free ones, of what
/// it asks for light, and of its number in the list of those that are shaded.
const NODE_BYTES: u64 = SLOTS * (NODE_STRIDE * size_of::<Row>() + 2 * size_of::<u32>()) as u64
    + (LIT_ROWS * size_of::<Row>() + size_of::<u32>()) as u64;

/// What queues hold.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Queued {
    /// Paths: of each one ray at a time.
    Paths,
    /// Nodes of Whitted's trees of rays.
    Trees,
}

impl Queued {
    /// What the integrator of these settings asks for.
    pub(crate) fn of(settings: &Settings) -> Queued {
        match settings.integrator {
            Integrator::Path => Queued::Paths,
            Integrator::Whitted => Queued::Trees,
        }
    }

    /// Bytes that each item of a round takes.
    fn bytes(self) -> u64 {
        match self {
            Queued::Paths => PATH_BYTES,
            Queued::Trees => NODE_BYTES,
        }
    }

    /// Samples of a pixel whose sum cannot wrap. Trees see to that themselves.
    pub(crate) fn samples_of_pass(self, depth: u32) -> u32 {
        match self {
            Queued::Paths => samples_of_pass(depth),
            Queued::Trees => u32::MAX,
        }
    }
}

/// How many paths of a round may be asked for.
pub(crate) const PATHS: RangeInclusive<u32> = 1 << 12..=1 << 24;

/// How many there are of path tracing at most where none are asked for. Each kernel of a round ends with some of the device idle,
/// so large rounds are faster; larger ones than this are not (docs/gpu-speed.md).
const USUAL_PATHS: u32 = 1 << 23;

/// With more than so many, a queue takes at most an eighth of the memory that there is for it: eight times as many paths are only a
/// seventh faster.
const MANY_PATHS: u32 = 1 << 20;
const PART_OF_MANY: u64 = 8;

/// The fewest: what a device of several thousand lanes needs to have something to do.
const FEWEST_PATHS: u32 = 1 << 14;

/// Samples of a pixel whose sum cannot wrap: at each bounce a path adds what it finds and what a light gives, and at its end what
/// surrounds the scene, each at most a 65,536th of what a sum holds.
fn samples_of_pass(depth: u32) -> u32 {
    65_535 / (2 * depth.min(MAX_DEPTH) + 3)
}

/// How large queues are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct QueueSize {
    pub(crate) of: Queued,
    /// Paths of a round.
    pub(crate) paths: u32,
    /// Pixels of a band.
    pub(crate) pixels: usize,
    /// Whether samples are taken in more than one pass.
    pub(crate) has_passes: bool,
    /// The queue of shadow rays, of trees.
    pub(crate) light_rays: Option<LightRays>,
}

impl QueueSize {
    /// For pictures of these settings, in bands whose pixels take at most so many bytes, where there are so many bytes for a queue.
    /// It has room for as many paths as are asked for, or for fewer, where there is not so much memory or no use for them.
    /// `light_rays` are the shadow rays of a point that Whitted's integrator has.
    pub(crate) fn new(
        settings: &Settings,
        band_bytes: u64,
        asked: Option<u32>,
        light_rays: PointRays,
        bytes: u64,
    ) -> QueueSize {
        let of = Queued::of(settings);
        let light_rays = (of == Queued::Trees).then_some(light_rays);
        let size = QueueSize { of, paths: 0, pixels: 0, has_passes: false, light_rays: None };
        let size = size.for_bands(band_bytes as usize, settings.samples, settings.max_depth);
        let samples = size.pixels as u64 * u64::from(settings.samples);
        let is_coloured = settings.shadow_mode == ShadowMode::Coloured;
        let up_to = |most: u32| {
            let paths = samples.max(FEWEST_PATHS.into()).min(most.into()) as u32 / WARP * WARP;
            QueueSize {
                paths,
                light_rays: light_rays.map(|rays| LightRays::new(rays, is_coloured, paths)),
                ..size
            }
        };
        if let Some(asked) = asked {
            return up_to(asked).within(bytes);
        }
        let points = light_rays.map_or(MANY_PATHS, |rays| LightRays::points(rays.all));
        let few = up_to(points.min(MANY_PATHS)).within(bytes);
        if size.of == Queued::Trees {
            return few;
        }
        let many = up_to(USUAL_PATHS).within(bytes / PART_OF_MANY);
        if many.paths > few.paths { many } else { few }
    }

    /// With as many paths, for bands whose pixels take at most so many bytes and so many samples.
    pub(crate) fn for_bands(self, band_bytes: usize, samples: u32, depth: u32) -> QueueSize {
        QueueSize {
            pixels: band_bytes / size_of::<ExactSum>(),
            has_passes: samples > self.of.samples_of_pass(depth),
            ..self
        }
    }

    /// With as many shadow rays, for frames whose shadows have colours or not.
    pub(crate) fn for_shadows(self, is_coloured: bool) -> QueueSize {
        QueueSize { light_rays: self.light_rays.map(|rays| LightRays { is_coloured, ..rays }), ..self }
    }

    /// With fewer paths, where these take more than so many bytes, and with fewer shadow rays where there are few paths; never with
    /// fewer than the fewest.
    fn within(mut self, bytes: u64) -> QueueSize {
        while self.bytes() > bytes {
            match &mut self.light_rays {
                _ if self.paths > FEWEST_PATHS => {
                    self.paths = (self.paths / 2 / WARP * WARP).max(FEWEST_PATHS);
                }
                Some(rays) if rays.window > 1 => rays.window /= 2,
                _ => break,
            }
        }
        self
    }

    /// What a queue of this size takes.
    pub(crate) fn bytes(&self) -> u64 {
        let light_bytes = self.light_rays.map_or(0, |rays| rays.bytes());
        u64::from(self.paths) * (self.of.bytes() + light_bytes) + self.sum_bytes()
    }

    /// Whether what needs `other` finds its room here.
    pub(crate) fn suits(&self, other: &QueueSize) -> bool {
        self.of == other.of
            && self.paths >= other.paths
            && self.pixels >= other.pixels
            && (self.has_passes || !other.has_passes)
            && self.light_rays == other.light_rays
    }

    /// Bytes that the sums of a band take.
    fn sum_bytes(&self) -> u64 {
        self.pixels as u64 * size_of::<ExactSum>() as u64 * (1 + u64::from(self.has_passes))
    }
}

/// Paths of a band, and what they add up to.
pub(crate) struct QueueRoom {
    size: QueueSize,
    rows: CudaSlice<u64>,
    /// [`PathControl`].
    control: CudaSlice<u64>,
    /// [`ExactSum`] for each pixel, of a pass.
    sums: CudaSlice<u64>,
    /// Likewise, of the passes before.
    before: Option<CudaSlice<u64>>,
    /// The ring of free slots was made.
    pub(crate) is_prepared: bool,
}

const CONTROL_WORDS: usize = size_of::<PathControl>() / size_of::<u64>();
const SUM_WORDS: usize = size_of::<ExactSum>() / size_of::<u64>();

impl QueueRoom {
    pub(crate) fn new(stream: &Arc<CudaStream>, size: QueueSize) -> Result<QueueRoom, DriverError> {
        let item_bytes = size.of.bytes() + size.light_rays.map_or(0, |rays| rays.bytes());
        let rows = (u64::from(size.paths) * item_bytes).div_ceil(size_of::<u64>() as u64) as usize;
        // SAFETY: kernels write what they read; sums are emptied by `clear`.
        let words = |count| unsafe { stream.alloc::<u64>(count) };
        let before = if size.has_passes { Some(words(size.pixels * SUM_WORDS)?) } else { None };
        Ok(QueueRoom {
            size,
            rows: words(rows)?,
            control: words(CONTROL_WORDS)?,
            sums: words(size.pixels * SUM_WORDS)?,
            before,
            is_prepared: false,
        })
    }

    pub(crate) fn size(&self) -> QueueSize {
        self.size
    }

    /// Empties the sums of all passes.
    pub(crate) fn clear(&mut self, stream: &Arc<CudaStream>) -> Result<(), DriverError> {
        stream.memset_zeros(&mut self.sums)?;
        self.before.as_mut().map_or(Ok(()), |before| stream.memset_zeros(before))
    }

    /// Begins a pass of so many samples. Gives back how far that is.
    pub(crate) fn begin(
        &mut self,
        stream: &Arc<CudaStream>,
        samples: u32,
    ) -> Result<PathControl, DriverError> {
        let control = PathControl { samples, samples_left: samples, ..PathControl::default() };
        // SAFETY: both are plain numbers of as many bytes.
        let words: [u64; CONTROL_WORDS] = unsafe { std::mem::transmute(control) };
        stream.memcpy_htod(&words, &mut self.control)?;
        Ok(control)
    }

    /// How far the pass is, once all that was launched is done.
    pub(crate) fn control(&self, stream: &Arc<CudaStream>) -> Result<PathControl, DriverError> {
        // SAFETY: it is there.
        unsafe { control_at(stream, self.control.device_ptr(stream).0) }
    }

    /// Where everything is on the device. By turns the paths of a round lie in one array or in another: `is_odd` says which.
    pub(crate) fn addresses(&self, stream: &Arc<CudaStream>, is_odd: bool) -> QueueAddresses {
        let first = self.rows.device_ptr(stream).0 as *mut Row;
        // Addresses of the device.
        let at = |rows: usize| first.wrapping_add(rows * self.size.paths as usize);
        let before = self.before.as_ref().map_or(0, |before| before.device_ptr(stream).0);
        let none = QueueAddresses {
            paths: first,
            next: null_mut(),
            hits: null_mut(),
            requests: null_mut(),
            sorted: null_mut(),
            hidden: null_mut(),
            stack: null_mut(),
            free: null_mut(),
            lights: LightQueue::NONE,
            slots: 0,
            control: self.control.device_ptr(stream).0 as *mut PathControl,
            sums: self.sums.device_ptr(stream).0 as *mut ExactSum,
            before: before as *mut ExactSum,
        };
        match self.size.of {
            Queued::Paths => {
                let (own, next) = if is_odd { (PATH_ROWS, 0) } else { (0, PATH_ROWS) };
                QueueAddresses {
                    paths: at(own),
                    next: at(next),
                    hits: at(2 * PATH_ROWS),
                    requests: at(2 * PATH_ROWS + HIT_ROWS),
                    sorted: at(ROWS).cast(),
                    // Paths are shaded by then.
                    hidden: at(ROWS).cast(),
                    ..none
                }
            }
            Queued::Trees => {
                let slots = SLOTS as usize * self.size.paths as usize;
                let requests = SLOTS as usize * NODE_STRIDE;
                let sorted: *mut u32 = at(requests + LIT_ROWS).cast();
                let stack = sorted.wrapping_add(self.size.paths as usize);
                let free = stack.wrapping_add(slots);
                let after = free.wrapping_add(slots).cast();
                let (lights, hidden) = match self.size.light_rays {
                    Some(rays) => light_queue(rays, self.size.paths, after),
                    None => (LightQueue::NONE, null_mut()),
                };
                QueueAddresses {
                    requests: at(requests),
                    sorted,
                    hidden,
                    stack,
                    free,
                    lights,
                    slots: slots as u32,
                    ..none
                }
            }
        }
    }
}

/// The control at an address of the device, once all that was launched is done.
///
/// # Safety
///
/// It is there.
pub(crate) unsafe fn control_at(stream: &Arc<CudaStream>, address: u64) -> Result<PathControl, DriverError> {
    let mut words = [0u64; CONTROL_WORDS];
    stream.context().bind_to_thread()?;
    // SAFETY: so many words are there, and here until the copy is made; the context is this thread's.
    unsafe { result::memcpy_dtoh_async(&mut words, address, stream.cu_stream()) }?;
    stream.synchronize()?;
    // SAFETY: both are plain numbers of as many bytes.
    Ok(unsafe { std::mem::transmute::<[u64; CONTROL_WORDS], PathControl>(words) })
}

/// Where shadow rays of so many points are, from an address on, and where those are listed that have something in their way.
fn light_queue(rays: LightRays, points: u32, first: *mut Row) -> (LightQueue, *mut u32) {
    let LightRays { window, is_coloured, group_bits } = rays;
    let (points, rays) = (points as usize, points as usize * window as usize);
    // What is larger comes first, so that all are aligned.
    let progress = first;
    let directions = progress.wrapping_add(PROGRESS_ROWS * points);
    let through = directions.wrapping_add(rays);
    let weights: *mut [f32; 2] = through.wrapping_add(if is_coloured { rays } else { 0 }).cast();
    let lights: *mut u32 = weights.wrapping_add(rays).cast();
    let (through, hidden) = match is_coloured {
        true => (through, lights.wrapping_add(rays)),
        false => (null_mut(), null_mut()),
    };
    let queue =
        LightQueue { directions, lights, weights, through, progress, first: 0, window, all: 0, group_bits };
    (queue, hidden)
}

/// What [`PathLaunch`] says of a queue.
///
/// [`PathLaunch`]: eosphor_core::device::PathLaunch
pub(crate) struct QueueAddresses {
    pub(crate) paths: *mut Row,
    pub(crate) next: *mut Row,
    pub(crate) hits: *mut Row,
    pub(crate) requests: *mut Row,
    pub(crate) sorted: *mut u32,
    pub(crate) hidden: *mut u32,
    pub(crate) stack: *mut u32,
    pub(crate) free: *mut u32,
    pub(crate) lights: LightQueue,
    pub(crate) slots: u32,
    pub(crate) control: *mut PathControl,
    pub(crate) sums: *mut ExactSum,
    pub(crate) before: *mut ExactSum,
}

#[cfg(test)]
mod tests {
    use super::*;
    use eosphor_scene::{LoadOptions, SceneData, load};

    fn settings(samples: u32) -> Settings {
        let scene = load("builtin:cornell", &LoadOptions::default()).unwrap().scene;
        let integrator = Integrator::Path;
        Settings { samples, integrator, max_depth: 8, ..SceneData::flatten(&scene).unwrap().0.settings }
    }

    const RAYS: PointRays = PointRays { all: 1, share_lights: false };

    #[test]
    fn queues_have_room_for_what_is_of_use_and_fits() {
        // A million pixels.
        let band = size_of::<ExactSum>() as u64 * 1_000_000;
        let paths =
            |samples, asked, bytes| QueueSize::new(&settings(samples), band, asked, RAYS, bytes).paths;
        assert_eq!(paths(64, None, 40 << 30), 1 << 23);
        assert_eq!(paths(1, None, 40 << 30), 1_000_000);
        assert_eq!(paths(64, Some(4096), 40 << 30), 4096);
        assert_eq!(paths(64, Some(1 << 24), 40 << 30), 1 << 24);
        assert_eq!(paths(1, Some(1 << 24), 40 << 30), 1_000_000);
        // Cards of 24, 8 and 2 GB: a queue has half of what is free.
        assert_eq!(paths(64, None, 11 << 30), 1 << 22);
        assert_eq!(paths(64, None, 3 << 30), 1 << 20);
        assert_eq!(paths(64, None, 700 << 20), 1 << 20);
        assert_eq!(paths(64, None, 200 << 20), 1 << 19);
        assert_eq!(paths(64, Some(1 << 23), 3 << 30), 1 << 23);
        assert_eq!(paths(64, Some(1 << 24), 3 << 30), 1 << 23);
        assert_eq!(paths(64, None, 0), FEWEST_PATHS);
        let trees = |asked, bytes| {
            let settings = Settings { integrator: Integrator::Whitted, ..settings(64) };
            QueueSize::new(&settings, band, asked, RAYS, bytes)
        };
        assert_eq!(
            trees(None, 40 << 30),
            QueueSize {
                of: Queued::Trees,
                paths: 1 << 20,
                pixels: 1_000_000,
                has_passes: false,
                light_rays: Some(LightRays { window: 1, is_coloured: true, group_bits: 5 })
            }
        );
        assert_eq!(trees(None, 700 << 20).paths, 1 << 19);
        assert_eq!(trees(Some(1 << 23), 40 << 30).paths, 1 << 23);
        for bytes in [200 << 20, 700 << 20, 3 << 30, 11 << 30, 40 << 30] {
            for asked in [None, Some(1 << 24)] {
                assert!(QueueSize::new(&settings(64), band, asked, RAYS, bytes).bytes() <= bytes);
                assert!(trees(asked, bytes).bytes() <= bytes);
            }
        }
    }

    #[test]
    fn shadow_rays_end_where_their_room_does() {
        for (is_coloured, window, points) in [(false, 1, 32), (true, 1, 32), (true, 7, 96), (false, 100, 64)]
        {
            let rays = LightRays { window, is_coloured, group_bits: 5 };
            let first = std::ptr::without_provenance_mut::<Row>(1 << 20);
            let (queue, hidden) = light_queue(rays, points, first);
            let all = points * window;
            let end = if is_coloured {
                hidden.wrapping_add(all as usize)
            } else {
                queue.lights.wrapping_add(all as usize)
            };
            assert_eq!((end.addr() - first.addr()) as u64, rays.bytes() * u64::from(points));
            assert_eq!((queue.through.is_null(), hidden.is_null()), (!is_coloured, !is_coloured));
            assert!(
                queue.through.is_aligned() && queue.directions.is_aligned() && queue.weights.is_aligned()
            );
        }
    }

    #[test]
    fn shadow_rays_have_room_for_a_round() {
        let band = size_of::<ExactSum>() as u64 * 1_000_000;
        let settings = Settings { integrator: Integrator::Whitted, ..settings(64) };
        let size = |all, asked| {
            let rays = PointRays { all, share_lights: true };
            let size = QueueSize::new(&settings, band, asked, rays, 40 << 30);
            (size.paths, size.light_rays.expect("they have").window)
        };
        // All of a point at a time, unless it has very many.
        assert_eq!(size(1, None), (1 << 20, 1));
        assert_eq!(size(100, None), (83_872, 100));
        assert_eq!(size(5000, None), (1 << 15, 256));
        assert_eq!(size(100, Some(4096)), (4096, 100));
        // What `very_many_shadow_rays` of the identity tests renders by.
        assert_eq!(size(1500, Some(1 << 14)), (1 << 14, 512));
        assert_eq!(size(100, Some(1 << 24)), (1 << 24, 1));
        assert_eq!(size(0, None), (1 << 20, 1));
        // Groups of points are whole, however little memory there is.
        for mebibytes in 0..200 {
            let rays = PointRays { all: 100, share_lights: false };
            let size = QueueSize::new(&settings, band, None, rays, mebibytes << 20);
            assert!(size.paths.is_multiple_of(32) && size.light_rays.expect("they have").group_bits == 5);
            assert!(size.bytes() <= (mebibytes << 20).max(band + (16 << 20)), "{size:?}");
        }
    }
}
