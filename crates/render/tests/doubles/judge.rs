//! Pictures beside those of double precision.

use super::picture::Picture;
use crate::vector::*;
use eosphor_core::math::Vec3;
use eosphor_render::{Accel, Backend, CpuBackend, CpuOptions, RenderControl};
use eosphor_scene::{Scene, SceneData};
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};

/// Linear colours.
pub(crate) fn render(data: &SceneData, accel: Accel) -> Vec<Vec3> {
    let options = CpuOptions { accel, threads: Some(2), ..CpuOptions::default() };
    let prepared = CpuBackend::new(options).unwrap().prepare(Arc::new(data.clone())).unwrap();
    let cancel = AtomicBool::new(false);
    let control = RenderControl { on_progress: &|_| {}, cancel: &cancel, count_work: false, frame: None };
    prepared.render(&control).unwrap().film.pixels
}

pub(crate) fn flatten(scene: &Scene) -> SceneData {
    SceneData::flatten(scene).unwrap().0
}

/// How far a picture is from another.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Difference {
    /// The share of the pixels that are off by more than a tolerance.
    pub(crate) off: f64,
    /// Mean of the largest differences of all others.
    pub(crate) mean: f64,
}

impl Difference {
    pub(crate) fn of(picture: &[V], truth: &[V], tolerance: f64) -> Difference {
        assert_eq!(picture.len(), truth.len());
        // Not a number is off.
        let differences: Vec<f64> = picture
            .iter()
            .zip(truth)
            .map(|(a, b)| if a.iter().all(|x| x.is_finite()) { largest(sub(*a, *b)) } else { f64::INFINITY })
            .collect();
        let (near, off): (Vec<f64>, Vec<f64>) = differences.into_iter().partition(|d| *d <= tolerance);
        Difference {
            off: off.len() as f64 / truth.len() as f64,
            mean: near.iter().sum::<f64>() / near.len().max(1) as f64,
        }
    }
}

/// Renders a scene here and in double precision. Its picture has so many levels of grey at least: pictures of nothing would
/// agree.
pub(crate) fn judge(scene: &Scene, tolerance: f64, levels: usize) -> Difference {
    let sheet = std::env::var_os("EOSPHOR_TEST_SHEET");
    let mut scene = scene.clone();
    if sheet.is_some() {
        scene.settings.size = [256, 192];
    }
    let data = flatten(&scene);
    let truth = Picture::new(&scene, &data).pixels();
    let mut grey: Vec<i64> = truth.iter().map(|p| (p[1] * 64.0) as i64).collect();
    grey.sort_unstable();
    grey.dedup();
    assert!(grey.len() >= levels, "the picture has only {} levels", grey.len());
    let got: Vec<V> = render(&data, Accel::Bvh8).into_iter().map(double).collect();
    if let Some(folder) = sheet {
        write_beside(Path::new(&folder), &got, &truth, scene.settings.size[0] as usize);
    }
    Difference::of(&got, &truth, tolerance)
}

/// Writes a picture, the truth, and ten times their difference, for the eye; files are numbered in the order of the tests.
fn write_beside(folder: &Path, got: &[V], truth: &[V], width: usize) {
    static WRITTEN: AtomicU32 = AtomicU32::new(0);
    let number = WRITTEN.fetch_add(1, Ordering::Relaxed);
    let mut file = format!("P6\n{} {}\n255\n", 3 * width, got.len() / width).into_bytes();
    for (got, truth) in got.chunks(width).zip(truth.chunks(width)) {
        let off = got.iter().zip(truth).map(|(a, b)| sub(*a, *b).map(|x| (10.0 * x).abs()));
        let row = got.iter().chain(truth).copied().chain(off);
        // A gamma of 2 is near enough to the display's.
        file.extend(row.flat_map(|p| p.map(|x| (255.0 * x.clamp(0.0, 1.0).sqrt()) as u8)));
    }
    std::fs::write(folder.join(format!("{number:04}.ppm")), file).unwrap();
}
