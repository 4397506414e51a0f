//! The backend: hierarchies are built on the CPU, pictures rendered in bands of rows on one or more devices.

use crate::bands::{BandHeight, Rows, rays_per_pixel};
use crate::device::{Device, devices};
use crate::launch::Launcher;
use crate::options::{CudaOptions, Traversal};
use crate::scene::DeviceScene;
use crate::structure::{Structure, kernel};
use eosphor_accel::Builder;
use eosphor_render::{
    Accel, Backend, BackendError, Film, Hierarchy, HierarchyStatistics, PreparedScene, Progress,
    RayStatistics, RenderControl, Rendered, check_rows, check_scene,
};
use eosphor_scene::SceneData;
use std::ops::Range;
use std::sync::atomic::Ordering;
use std::sync::{Arc, Mutex};
use std::time::Instant;

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
        let structure = Structure::new(&hierarchy, self.traversal)?;
        let kernel = kernel(self.accel, scene.instances.len() > 1)?;
        let film_pixels = largest_band(scene.settings.width, scene.settings.height) as u64;
        let upload =
            |device: &Device| DeviceScene::upload(device, kernel, &scene.view(), &structure, film_pixels);
        Ok(Box::new(PreparedCuda {
            scenes: self.devices.iter().map(upload).collect::<Result<_, _>>()?,
            devices: self.devices.clone(),
            block_size: self.block_size,
            rays_per_pixel: rays_per_pixel(&scene.view(), self.accel),
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
        let rows = Rows::new(rows);
        std::thread::scope(|scope| {
            let (rows, picture) = (&rows, &picture);
            let start =
                |(device, scene)| scope.spawn(move || self.render_on(device, scene, rows, picture, control));
            let workers: Vec<_> = self.devices.iter().zip(&self.scenes).map(start).collect();
            workers.into_iter().try_for_each(|worker| match worker.join() {
                Ok(result) => result,
                Err(panic) => std::panic::resume_unwind(panic),
            })
        })?;
        let picture = picture.into_inner().unwrap_or_else(|poisoned| poisoned.into_inner());
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
    /// Takes rows until there are none left.
    fn render_on(
        &self,
        device: &Device,
        scene: &DeviceScene,
        rows: &Rows,
        picture: &Mutex<Picture>,
        control: &RenderControl,
    ) -> Result<(), BackendError> {
        let width = self.width as usize;
        let mut band_height = BandHeight::new(self.width, self.rays_per_pixel);
        let fail = |error| device.failure("rendering", error);
        let mut launcher =
            Launcher::new(device, scene, self.block_size, largest_band(self.width, self.height))
                .map_err(fail)?;
        let mut colors = Vec::new();
        while !control.cancel.load(Ordering::Relaxed) {
            let Some(band) = rows.take(band_height.rows()) else { break };
            let start = Instant::now();
            colors.resize(band.len() * width, eosphor_core::math::Vec3::ZERO);
            let statistics = launcher.render_rows(band.start, &mut colors).map_err(fail)?;
            band_height.learn(band.len() as u32, start.elapsed().as_secs_f64());
            let progress = {
                let mut guard = picture.lock().unwrap_or_else(|poisoned| poisoned.into_inner());
                let picture = &mut *guard;
                let start = (band.start - picture.first_row) as usize * width;
                picture.film.pixels[start..][..colors.len()].copy_from_slice(&colors);
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
        Ok(())
    }
}
