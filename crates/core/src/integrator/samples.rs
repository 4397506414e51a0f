//! The samples of a pixel: from the camera's rays to an exact sum. Here is said which integrator follows a ray.

use super::whitted::radiance;
use super::{RayCounts, camera_ray};
use crate::hierarchy::Tracer;
use crate::math::Vec3;
use crate::sums::ExactSum;
use crate::view::SceneView;

/// All samples of a pixel.
#[inline(always)]
pub fn render_pixel<T: Tracer, const W: usize>(
    view: &SceneView,
    tracer: &T,
    x: u32,
    y: u32,
    counts: &mut RayCounts,
) -> ExactSum {
    let samples = Samples { first: 0, end: view.settings.samples, step: 1 };
    render_samples::<T, W>(view, tracer, (x, y), samples, counts)
}

/// Some samples of a pixel: from the first on every `step`-th one before the end.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Samples {
    /// The number of the first one.
    pub first: u32,
    /// What all numbers are below.
    pub end: u32,
    /// From one to the next; at least 1.
    pub step: u32,
}

/// Some samples of a pixel: a part of its sum.
#[inline(always)]
pub fn render_samples<T: Tracer, const W: usize>(
    view: &SceneView,
    tracer: &T,
    (x, y): (u32, u32),
    samples: Samples,
    counts: &mut RayCounts,
) -> ExactSum {
    let mut sum = ExactSum::default();
    let mut sample = samples.first;
    while sample < samples.end {
        let ray = camera_ray(view, x, y, sample);
        radiance::<T, W>(view, tracer, ray, (x, y, sample), &mut sum, counts);
        sample += samples.step;
    }
    sum
}

/// The colour of a pixel, from its sum.
#[inline(always)]
pub fn pixel_color(view: &SceneView, sum: &ExactSum) -> Vec3 {
    sum.mean(view.settings.samples)
}
