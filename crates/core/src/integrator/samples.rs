//! The samples of a pixel: from the camera's rays to an exact sum. Here is said which integrator follows a ray.

use super::{PathRay, RayCounts, camera_ray, path, whitted};
use crate::hierarchy::Tracer;
use crate::math::Vec3;
use crate::settings::Integrator;
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

/// Some samples of a pixel: a part of its sum, by the integrator that the settings name.
#[inline(always)]
pub fn render_samples<T: Tracer, const W: usize>(
    view: &SceneView,
    tracer: &T,
    pixel: (u32, u32),
    samples: Samples,
    counts: &mut RayCounts,
) -> ExactSum {
    match view.settings.integrator {
        Integrator::Whitted => render_samples_by::<T, Whitted<W>>(view, tracer, pixel, samples, counts),
        Integrator::Path => render_samples_by::<T, Path>(view, tracer, pixel, samples, counts),
    }
}

/// Follows rays from the camera: what an integrator is to those who know which one they want.
pub trait Follow {
    /// Adds what a ray finds, and everything that follows from it, for sample `sample` of pixel (x, y).
    fn radiance<T: Tracer>(
        view: &SceneView,
        tracer: &T,
        ray: PathRay,
        place: (u32, u32, u32),
        sum: &mut ExactSum,
        counts: &mut RayCounts,
    );
}

/// Whitted's, with so many shadow rays at a time.
pub struct Whitted<const W: usize>;

impl<const W: usize> Follow for Whitted<W> {
    #[inline(always)]
    fn radiance<T: Tracer>(
        view: &SceneView,
        tracer: &T,
        ray: PathRay,
        place: (u32, u32, u32),
        sum: &mut ExactSum,
        counts: &mut RayCounts,
    ) {
        whitted::radiance::<T, W>(view, tracer, ray, place, sum, counts);
    }
}

/// Path tracing.
pub struct Path;

impl Follow for Path {
    #[inline(always)]
    fn radiance<T: Tracer>(
        view: &SceneView,
        tracer: &T,
        ray: PathRay,
        place: (u32, u32, u32),
        sum: &mut ExactSum,
        counts: &mut RayCounts,
    ) {
        path::radiance(view, tracer, ray, place, sum, counts);
    }
}

/// Some samples of a pixel by an integrator.
#[inline(always)]
pub fn render_samples_by<T: Tracer, F: Follow>(
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
        F::radiance(view, tracer, ray, (x, y, sample), &mut sum, counts);
        sample += samples.step;
    }
    sum
}

/// The colour of a pixel, from its sum.
#[inline(always)]
pub fn pixel_color(view: &SceneView, sum: &ExactSum) -> Vec3 {
    sum.mean(view.settings.samples)
}
