//! The backend: hierarchies are built on the CPU, pictures rendered in bands of rows on one or more devices.

use crate::bands::{BandHeight, Rows, rays_per_pixel, sharing};
use crate::device::{Device, devices};
use crate::launch::{Launched, Launcher};
use crate::options::{CudaOptions, Traversal};
use crate::scene::DeviceScene;
use crate::structure::{Structure, kernel};
use eosphor_accel::Builder;
use eosphor_core::math::Vec3;
use eosphor_render::{
    Accel, Backend, BackendError, Film, Hierarchy, HierarchyStatistics, PreparedScene, Progress,
    RayStatistics, RenderControl, Rendered, check_rows, check_scene,
};
use eosphor_scene::SceneData;
use std::ops::Range;
use std::sync::atomic::Ordering;
use std::sync::{Arc, Mutex, PoisonError};

/// Renders on NVIDIA GPUs.
pub struct CudaBackend {
    devices: Arc<Vec<Device>>,
    accel: Accel,
    builder: Builder,
    block_size: u32,
    traversal: Traversal,
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
            Some(info) => Device::open(info),
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
            builder: options.builder,
            block_size: options.block_size,
            traversal: options.traversal,
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
        let hierarchy = Hierarchy::build(self.accel, self.builder, &scene);
        let moving = if scene.instances_move { scene.instances.len() } else { 0 };
        let structure = Structure::new(&hierarchy, self.traversal, moving)?;
        let kernel = kernel(self.accel, self.traversal, scene.instances.len() > 1)?;
        let film_pixels = largest_band(scene.settings.width, scene.settings.height) as u64;
        let view = scene.view();
        let upload =
            |device: &Device| DeviceScene::upload(device, kernel, &view, &structure, moving, film_pixels);
        Ok(Box::new(PreparedCuda {
            scenes: self.devices.iter().map(upload).collect::<Result<_, _>>()?,
            devices: self.devices.clone(),
            block_size: self.block_size,
            rays_per_pixel: rays_per_pixel(&scene.view(), self.accel),
            sharing: sharing(scene.settings.samples),
            statistics: hierarchy.statistics(),
            width: scene.settings.width,
            height: scene.settings.height,
        }))
    }
}

/// Pixels of the largest band that a picture is rendered in.
fn largest_band(width: u32, rows: u32) -> usize {
    width as usize * BandHeight::most(width).min(rows) as usize
}

struct PreparedCuda {
    /// One for each device.
    scenes: Vec<DeviceScene>,
    devices: Arc<Vec<Device>>,
    block_size: u32,
    /// A guess.
    rays_per_pixel: f64,
    /// How many threads share the samples of a pixel, as a power of two.
    sharing: u32,
    statistics: HierarchyStatistics,
    width: u32,
    height: u32,
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

    /// Work ([`RenderControl::count_work`]) is not counted on this backend.
    fn render_rows(&self, rows: Range<u32>, control: &RenderControl) -> Result<Rendered, BackendError> {
        check_rows(&rows, self.height)?;
        let picture = Mutex::new(Picture {
            first_row: rows.start,
            film: Film::new(self.width, rows.end - rows.start),
            statistics: RayStatistics::default(),
            pixels_done: 0,
        });
        let pixels = FilmRows::new(&mut picture.lock().unwrap_or_else(PoisonError::into_inner));
        let rows = Rows::new(rows, self.devices.len() as u32);
        std::thread::scope(|scope| {
            let (rows, picture, pixels) = (&rows, &picture, &pixels);
            let start = |(device, scene)| {
                scope.spawn(move || self.render_on(device, scene, rows, pixels, picture, control))
            };
            let workers: Vec<_> = self.devices.iter().zip(&self.scenes).map(start).collect();
            workers.into_iter().try_for_each(|worker| match worker.join() {
                Ok(result) => result,
                Err(panic) => std::panic::resume_unwind(panic),
            })
        })?;
        let picture = picture.into_inner().unwrap_or_else(PoisonError::into_inner);
        let complete = picture.pixels_done == picture.film.pixels.len() as u64;
        Ok(Rendered { film: picture.film, complete, statistics: picture.statistics })
    }
}

/// What the devices fill together.
struct Picture {
    /// The picture's row that is the film's first.
    first_row: u32,
    film: Film,
    statistics: RayStatistics,
    pixels_done: u64,
}

impl PreparedCuda {
    /// Takes rows until there are none left. While one band travels back, the next is rendered.
    fn render_on(
        &self,
        device: &Device,
        scene: &DeviceScene,
        rows: &Rows,
        pixels: &FilmRows,
        picture: &Mutex<Picture>,
        control: &RenderControl,
    ) -> Result<(), BackendError> {
        let fail = |error| device.failure("rendering", error);
        let mut room = scene.take_room(device, largest_band(self.width, self.height)).map_err(fail)?;
        let parameters = &scene.at(device, control.moment).map_err(fail)?;
        let (block_size, sharing) = (self.block_size, self.sharing);
        let mut launcher = Launcher { scene, parameters, block_size, sharing, room: &mut room };
        let pixels_at_a_time = device.threads_at_a_time().map_err(fail)? as u32 >> self.sharing;
        let mut band_height = BandHeight::new(self.width, self.rays_per_pixel, pixels_at_a_time);
        let mut flying: Option<Launched> = None;
        for number in 0.. {
            let cancelled = control.cancel.load(Ordering::Relaxed);
            let next = if cancelled { None } else { rows.take(&band_height) };
            let launch = |rows| launcher.launch(rows, number % 2).map_err(fail);
            let launched = next.map(launch).transpose()?;
            let more = launched.is_some();
            if let Some(band) = std::mem::replace(&mut flying, launched) {
                // SAFETY: `rows` has handed out each row once.
                let colors = unsafe { pixels.rows(&band.rows) };
                let (statistics, seconds) = launcher.finish(&band, colors).map_err(fail)?;
                band_height.learn(band.rows.len() as u32, seconds);
                let progress = {
                    let mut picture = picture.lock().unwrap_or_else(PoisonError::into_inner);
                    picture.statistics += statistics;
                    picture.pixels_done += colors.len() as u64;
                    Progress {
                        pixels_done: picture.pixels_done,
                        pixels_total: picture.film.pixels.len() as u64,
                        rays: picture.statistics.total_rays(),
                    }
                };
                (control.on_progress)(progress);
            }
            if !more {
                break;
            }
        }
        scene.give_back(room);
        Ok(())
    }
}

/// The film's pixels, for several devices that fill different rows.
struct FilmRows {
    pixels: *mut Vec3,
    /// The picture's row that is the film's first.
    first_row: u32,
    width: usize,
    length: usize,
}

// SAFETY: whoever takes rows sees to it that nobody else does.
unsafe impl Sync for FilmRows {}

impl FilmRows {
    fn new(picture: &mut Picture) -> FilmRows {
        FilmRows {
            pixels: picture.film.pixels.as_mut_ptr(),
            first_row: picture.first_row,
            width: picture.film.width as usize,
            length: picture.film.pixels.len(),
        }
    }

    /// Some rows of the picture.
    ///
    /// # Safety
    ///
    /// The film is there, and nobody else has any of these rows.
    #[allow(clippy::mut_from_ref, reason = "that is what it is for")]
    unsafe fn rows(&self, rows: &Range<u32>) -> &mut [Vec3] {
        let first = (rows.start - self.first_row) as usize * self.width;
        let length = rows.len() * self.width;
        assert!(first + length <= self.length, "rows of the film");
        // SAFETY: they are in the film, and the caller's alone.
        unsafe { std::slice::from_raw_parts_mut(self.pixels.add(first), length) }
    }
}
