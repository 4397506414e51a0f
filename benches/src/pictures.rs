//! A small picture of the Cornell box, on one thread.

use crate::{Case, LEVEL};
use eosphor_render::{Accel, Backend, CpuBackend, CpuOptions, PreparedScene, RenderControl, Scheduler};
use eosphor_scene::{LoadOptions, SceneData, load};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

/// Width and height in pixels.
const SIZE: [u32; 2] = [32, 26];

struct Picture(Box<dyn PreparedScene>);

impl Picture {
    fn new(accel: Accel, scheduler: Scheduler) -> Picture {
        let mut scene = load("builtin:cornell", &LoadOptions::default()).expect("it is built in").scene;
        scene.settings.size = SIZE;
        scene.settings.samples = 1;
        let (data, _) = SceneData::flatten(&scene).expect("the box is a scene");
        let options =
            CpuOptions { threads: Some(1), accel, simd: Some(LEVEL), scheduler, ..CpuOptions::default() };
        let backend = CpuBackend::new(options).expect("a CPU with AVX2");
        Picture(backend.prepare(Arc::new(data)).expect("the box is a scene"))
    }

    /// Rays.
    fn render(&self) -> usize {
        let cancel = AtomicBool::new(false);
        let control = RenderControl { on_progress: &|_| {}, cancel: &cancel, count_work: false, frame: None };
        self.0.render(&control).expect("the rows are in the picture").statistics.total_rays() as usize
    }
}

/// Many rays at a time, through the hierarchy of eight children.
pub struct PictureBatched(Picture);

impl Case for PictureBatched {
    const AT_LEAST: usize = 1000;

    fn new() -> PictureBatched {
        PictureBatched(Picture::new(Accel::Bvh8, Scheduler::Batched))
    }

    fn run(&self) -> usize {
        self.0.render()
    }
}

/// Pixel after pixel, through the hierarchy of two children.
pub struct PictureScalar(Picture);

impl Case for PictureScalar {
    const AT_LEAST: usize = 1000;

    fn new() -> PictureScalar {
        PictureScalar(Picture::new(Accel::Bvh, Scheduler::Scalar))
    }

    fn run(&self) -> usize {
        self.0.render()
    }
}
