//! The backend: hierarchies are built on the CPU, pictures rendered in bands of rows on one or more devices.

use crate::bands::{BandHeight, Rows, sharing};
use crate::develop_launch::Developer;
use crate::device::{Device, devices};
use crate::launch::{Launched, Launcher};
use crate::options::CudaOptions;
use crate::pixel::{Pixel, Rgb};
use crate::ray_count::rays_per_sample;
use crate::scene::{DeviceScene, Kernels, ShapedFrame};
use crate::scheduler::GpuScheduler;
use crate::stages::Stages;
use crate::structure::{Structure, kernels};
use crate::traversal::Traversal;
use eosphor_core::develop::Development;
use eosphor_core::math::Vec3;
use eosphor_core::sums::ExactSum;
use eosphor_render::{
    Accel, Backend, BackendError, DevelopSettings, Developed, Film, Hierarchy, HierarchyOptions,
    HierarchyStatistics, PreparedScene, Progress, RayStatistics, RenderControl, Rendered, RenderedBytes,
    SampleSums, Sampled, ShapedScenes, StageWork, build_hierarchy, check_rows, check_samples, check_scene,
    options_by_work,
};
use eosphor_scene::SceneData;
use std::ops::Range;
use std::sync::atomic::Ordering;
use std::sync::{Arc, Mutex, PoisonError};

/// Renders on NVIDIA GPUs.
pub struct CudaBackend {
    devices: Arc<Vec<Device>>,
    accel: Accel,
    options: HierarchyOptions,
    block_size: u32,
    traversal: Traversal,
    paths: Option<u32>,
    scheduler: GpuScheduler,
    count_work: bool,
}

impl CudaBackend {
    /// Opens the devices. When the first scene is prepared with a new version, structure or driver, that takes seconds: the
    /// driver compiles the kernel, and keeps it.
    ///
    /// # Errors
    ///
    /// [`CudaOptions::check`]'s, and [`BackendError::Unavailable`] where there is no driver, or a device is not there or
    /// too old.
    pub fn new(options: CudaOptions) -> Result<CudaBackend, BackendError> {
        options.check()?;
        let found = devices()?;
        let open = |&ordinal: &usize| match found.get(ordinal) {
            Some(info) => Device::open(info, options.memory_bytes),
            None => Err(BackendError::Unavailable(format!(
                "there is no device cuda:{ordinal}: there {}",
                match found.len() {
                    1 => "is only cuda:0".to_string(),
                    n => format!("are cuda:0 to cuda:{}", n - 1),
                }
            ))),
        };
        let devices = options.devices.iter().map(open).collect::<Result<_, _>>()?;
        Ok(CudaBackend {
            devices: Arc::new(devices),
            accel: options.accel,
            options: options.hierarchy,
            block_size: options.block_size,
            traversal: options.traversal,
            paths: options.paths,
            scheduler: options.scheduler,
            count_work: options.count_work,
        })
    }
}

impl Backend for CudaBackend {
    fn describe(&self) -> String {
        let names: Vec<&str> = self.devices.iter().map(|device| device.name.as_str()).collect();
        format!("CUDA, {}", names.join(", "))
    }

    fn prepare(&self, scene: Arc<SceneData>) -> Result<Box<dyn PreparedScene>, BackendError> {
        check_scene(&scene)?;
        // What is counted is the way of one ray through the tree that CPUs have.
        let options = match self.accel == Accel::Bvh && !self.count_work {
            true => options_by_work(self.options, &scene, SAMPLES_WORTH_CUTTING),
            false => self.options,
        };
        let hierarchy = Arc::new(build_hierarchy(self.accel, &options, &scene)?);
        let moving = if scene.instances_move { scene.instances.len() } else { 0 };
        let structure = match self.count_work {
            true => Structure::for_counting(&hierarchy),
            false => Structure::new(&hierarchy, self.traversal, moving)?,
        };
        let (placed, integrator) = (scene.instances.len() > 1, scene.settings.integrator);
        let names = kernels(self.accel, self.traversal, placed, self.count_work, integrator, self.scheduler)?;
        let band_bytes = largest_band(scene.settings.width, scene.settings.height) as u64;
        let view = scene.view();
        let kernels = (names, self.block_size, self.paths);
        let upload =
            |device: &Device| DeviceScene::upload(device, kernels, &view, &structure, moving, band_bytes);
        Ok(Box::new(PreparedCuda {
            scenes: self.devices.iter().map(upload).collect::<Result<_, _>>()?,
            devices: self.devices.clone(),
            block_size: self.block_size,
            count_work: self.count_work,
            rays_per_sample: rays_per_sample(&scene.view(), self.accel),
            samples: scene.settings.samples,
            statistics: hierarchy.statistics(),
            width: scene.settings.width,
            height: scene.settings.height,
            shaped: (scene.deforming_geometries > 0).then(|| Shaped {
                scenes: ShapedScenes::new(Arc::clone(&scene), Arc::clone(&hierarchy), self.options),
                scene: Arc::clone(&scene),
                traversal: self.traversal,
            }),
        }))
    }
}

/// Bytes of the largest band that a picture is rendered in.
fn largest_band(width: u32, rows: u32) -> usize {
    fn bytes<T: Pixel>(width: u32, rows: u32) -> usize {
        T::bytes_on_device(width as usize * BandHeight::most::<T>(width).min(rows) as usize)
    }
    bytes::<Vec3>(width, rows).max(bytes::<ExactSum>(width, rows)).max(bytes::<Rgb>(width, rows))
}

/// For so many samples of path tracing a triangle, cutting triangles pays, though it is the CPU that does it: an H100 takes an
/// eighth less time for sponza under a sky (437 and 385 ms with 16 samples at 1920 x 1080), and 16 cores take 25 ms more to build.
const SAMPLES_WORTH_CUTTING: u64 = 256;

/// How many times the threads that a device runs at a time its share of some rows should have, so that the end of it costs
/// little.
const FILLINGS: u64 = 4;

struct PreparedCuda {
    /// One for each device.
    scenes: Vec<DeviceScene>,
    devices: Arc<Vec<Device>>,
    block_size: u32,
    /// The kernels are those that count.
    count_work: bool,
    /// A guess.
    rays_per_sample: f64,
    samples: u32,
    statistics: HierarchyStatistics,
    width: u32,
    height: u32,
    /// For scenes with meshes whose vertices move.
    shaped: Option<Shaped>,
}

/// What frames need in which vertices of meshes are elsewhere.
struct Shaped {
    scene: Arc<SceneData>,
    scenes: ShapedScenes,
    traversal: Traversal,
}

impl PreparedScene for PreparedCuda {
    fn hierarchy_statistics(&self) -> HierarchyStatistics {
        self.statistics.clone()
    }

    /// `None`: it lives on the devices.
    fn hierarchy(&self) -> Option<Arc<Hierarchy>> {
        None
    }

    fn size(&self) -> (u32, u32) {
        (self.width, self.height)
    }

    fn samples(&self) -> u32 {
        self.samples
    }

    /// As if each thread had a pixel of its own, though threads may share them.
    fn pixels_at_a_time(&self) -> u64 {
        let threads = |device: &Device| device.threads_at_a_time().unwrap_or(0);
        FILLINGS * self.devices.iter().map(threads).sum::<u64>()
    }

    fn render_rows(&self, rows: Range<u32>, control: &RenderControl) -> Result<Rendered, BackendError> {
        let (width, height) = control.size_of(self);
        check_rows(&rows, height)?;
        let mut film = Film::new(width, rows.end - rows.start);
        let samples = 0..control.samples_of(self);
        let (complete, statistics) =
            self.run((rows, samples), Wanted::default(), control, &mut film.pixels)?;
        Ok(Rendered { film, complete, statistics })
    }

    fn sample_rows(
        &self,
        rows: Range<u32>,
        samples: Range<u32>,
        control: &RenderControl,
    ) -> Result<Sampled, BackendError> {
        let (width, height) = control.size_of(self);
        check_rows(&rows, height)?;
        check_samples(&samples, control.samples_of(self))?;
        let mut sums = SampleSums::new(width, rows.end - rows.start);
        let (complete, statistics) = self.run((rows, samples), Wanted::default(), control, &mut sums.sums)?;
        Ok(Sampled { sums, complete, statistics })
    }

    fn stages(&self, control: &RenderControl) -> Result<Vec<StageWork>, BackendError> {
        let (width, height) = control.size_of(self);
        check_rows(&(0..height), height)?;
        let (mut film, stages) = (Film::new(width, height), Stages::default());
        let wanted = Wanted { stages: Some(&stages), ..Wanted::default() };
        self.run((0..height, 0..control.samples_of(self)), wanted, control, &mut film.pixels)?;
        Ok(stages.into_all())
    }

    fn render_developed(
        &self,
        develop: &DevelopSettings,
        control: &RenderControl,
    ) -> Result<RenderedBytes, BackendError> {
        let (width, height) = control.size_of(self);
        check_rows(&(0..height), height)?;
        let mut picture = Developed::black(width, height);
        let (pixels, _) = picture.rgb.as_chunks_mut::<3>();
        let all = (0..height, 0..control.samples_of(self));
        let wanted = Wanted { development: Some(develop.development()), ..Wanted::default() };
        let (complete, statistics) = self.run(all, wanted, control, pixels)?;
        Ok(RenderedBytes::of_bytes(picture, complete, statistics))
    }
}

/// How far the devices are together.
#[derive(Default)]
struct Done {
    statistics: RayStatistics,
    pixels: u64,
}

/// What is wanted beside colours or sums.
#[derive(Clone, Copy, Default)]
struct Wanted<'a> {
    /// How colours are developed, where bytes are wanted.
    development: Option<Development>,
    /// Where it is noted what kernels take.
    stages: Option<&'a Stages>,
}

/// What the devices do.
struct Task<'a, T> {
    /// Width and height of the picture.
    size: (u32, u32),
    rows: Rows,
    samples: Range<u32>,
    pixels: PixelRows<T>,
    wanted: Wanted<'a>,
    pixels_total: u64,
    done: Mutex<Done>,
    control: &'a RenderControl<'a>,
    /// Where vertices of meshes are elsewhere than in the prepared scene.
    shaped: Option<ShapedFrame<'a>>,
}

impl PreparedCuda {
    /// Renders rows with some samples on all devices. Whether they came to the end.
    fn run<T: Pixel>(
        &self,
        (rows, samples): (Range<u32>, Range<u32>),
        wanted: Wanted,
        control: &RenderControl,
        pixels: &mut [T],
    ) -> Result<(bool, RayStatistics), BackendError> {
        if control.count_work && !self.count_work {
            let message = "work is to be counted: CudaOptions::count_work must be set for that";
            return Err(BackendError::Failed(message.into()));
        }
        let pixels_total = pixels.len() as u64;
        let size = control.size_of(self);
        // Once for all devices.
        let own = match &self.shaped {
            Some(shaped) => shaped.scenes.of_frame(control.frame)?.map(|own| (shaped, own)),
            None => None,
        };
        let frame = own
            .as_ref()
            .map(|(shaped, own)| ShapedFrame::new(&shaped.scene, own, shaped.traversal, self.count_work));
        let task = Task {
            shaped: frame.transpose()?,
            size,
            pixels: PixelRows::new(pixels, rows.start, size.0),
            rows: Rows::new(rows, self.devices.len() as u32),
            samples,
            wanted,
            pixels_total,
            done: Mutex::default(),
            control,
        };
        std::thread::scope(|scope| {
            let task = &task;
            let start = |(device, scene)| scope.spawn(move || self.run_on(device, scene, task));
            let workers: Vec<_> = self.devices.iter().zip(&self.scenes).map(start).collect();
            workers.into_iter().try_for_each(|worker| match worker.join() {
                Ok(result) => result,
                Err(panic) => std::panic::resume_unwind(panic),
            })
        })?;
        let done = task.done.into_inner().unwrap_or_else(PoisonError::into_inner);
        Ok((done.pixels == pixels_total, done.statistics))
    }

    /// Takes rows until there are none left. While one band travels back, the next is rendered.
    fn run_on<T: Pixel>(
        &self,
        device: &Device,
        scene: &DeviceScene,
        task: &Task<T>,
    ) -> Result<(), BackendError> {
        let fail = |error| device.failure("rendering", error);
        let control = task.control;
        let (width, height) = task.size;
        let samples = task.samples.clone();
        let band_bytes = largest_band(width, height);
        let parameters = &scene.at(device, control.frame, task.shaped.as_ref())?;
        let mut room = scene.take_room(device, parameters, band_bytes, samples.len() as u32).map_err(fail)?;
        let block_size = self.block_size;
        let sharing = sharing(samples.len() as u32);
        let rays_per_pixel = self.rays_per_sample * samples.len() as f64;
        let developer = task
            .wanted
            .development
            .map(|development| Developer::new(device, block_size, development))
            .transpose()?;
        let developer = developer.as_ref();
        let mut launcher = Launcher {
            scene,
            parameters,
            width,
            block_size,
            samples,
            sharing,
            developer,
            stages: task.wanted.stages,
            room: &mut room,
        };
        let pixels_at_a_time = device.threads_at_a_time().map_err(fail)? as u32 >> sharing;
        // Paths in queues need sums, whatever is wanted of them.
        let mut band_height = match scene.kernels {
            Kernels::Whole(_) => BandHeight::new::<T>(width, rays_per_pixel, pixels_at_a_time),
            Kernels::Queues(_) => BandHeight::new::<ExactSum>(width, rays_per_pixel, pixels_at_a_time),
        };
        let mut flying: Option<Launched> = None;
        for number in 0.. {
            let cancelled = control.cancel.load(Ordering::Relaxed);
            let next = if cancelled { None } else { task.rows.take(&band_height) };
            let launch = |rows| launcher.launch::<T>(rows, number % 2).map_err(fail);
            let launched = next.map(launch).transpose()?;
            let more = launched.is_some();
            if let Some(mut band) = std::mem::replace(&mut flying, launched) {
                // SAFETY: each row was handed out once.
                let pixels = unsafe { task.pixels.rows(&band.rows) };
                let (statistics, seconds) = launcher.finish(&mut band, pixels).map_err(fail)?;
                band_height.learn(band.rows.len() as u32, seconds);
                let progress = {
                    let mut done = task.done.lock().unwrap_or_else(PoisonError::into_inner);
                    done.statistics += statistics;
                    done.pixels += pixels.len() as u64;
                    Progress {
                        pixels_done: done.pixels,
                        pixels_total: task.pixels_total,
                        rays: done.statistics.total_rays(),
                    }
                };
                (control.on_progress)(progress);
            }
            if !more {
                break;
            }
        }
        room.give_back();
        Ok(())
    }
}

/// Rows of pixels, for several devices that fill different ones.
struct PixelRows<T> {
    pixels: *mut T,
    /// The picture's row that is the first of them.
    first_row: u32,
    width: usize,
    length: usize,
}

// SAFETY: whoever takes rows sees to it that nobody else does.
unsafe impl<T: Send> Sync for PixelRows<T> {}

impl<T> PixelRows<T> {
    fn new(pixels: &mut [T], first_row: u32, width: u32) -> PixelRows<T> {
        PixelRows { length: pixels.len(), pixels: pixels.as_mut_ptr(), first_row, width: width as usize }
    }

    /// Some rows of the picture.
    ///
    /// # Safety
    ///
    /// The pixels are there, and nobody else has any of these rows.
    #[allow(clippy::mut_from_ref, reason = "that is what it is for")]
    unsafe fn rows(&self, rows: &Range<u32>) -> &mut [T] {
        let first = (rows.start - self.first_row) as usize * self.width;
        let length = rows.len() * self.width;
        assert!(first + length <= self.length, "rows of the picture");
        // SAFETY: the assertion keeps them inside; rows are handed out once, so nobody else has these.
        unsafe { std::slice::from_raw_parts_mut(self.pixels.add(first), length) }
    }
}
