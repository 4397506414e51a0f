//! Pictures beside those of double precision.

use crate::picture::Picture;
use crate::vector::*;
use eosphor_core::math::Vec3;
use eosphor_render::{Accel, Backend, CpuBackend, CpuOptions, RenderControl};
use eosphor_scene::{Scene, SceneData};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

/// Linear colours.
pub(crate) fn render(data: &SceneData, accel: Accel) -> Vec<Vec3> {
    let options = CpuOptions { accel, threads: Some(2), ..CpuOptions::default() };
    let prepared = CpuBackend::new(options).unwrap().prepare(Arc::new(data.clone())).unwrap();
    let cancel = AtomicBool::new(false);
    let control = RenderControl { on_progress: &|_| {}, cancel: &cancel, count_work: false, moment: None };
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
    let data = flatten(scene);
    let truth = Picture::new(scene, &data).pixels();
    let mut grey: Vec<i64> = truth.iter().map(|p| (p[1] * 64.0) as i64).collect();
    grey.sort_unstable();
    grey.dedup();
    assert!(grey.len() >= levels, "the picture has only {} levels", grey.len());
    let got: Vec<V> = render(&data, Accel::Bvh8).into_iter().map(double).collect();
    Difference::of(&got, &truth, tolerance)
}
