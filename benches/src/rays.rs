//! Closest hits, through the hierarchies of eight and of two children.

use crate::{Case, LEVEL, ball};
use eosphor_accel::{
    BatchTracer, BuildOptions, Bvh, Bvh8, Bvh8Tracer, Coherence, Filters, Hit, IgnoreWork, Ray, RayFilter,
    Tracer,
};

/// The 8-wide hierarchy and rays to trace through it.
struct Eight {
    bvh: Bvh8,
    rays: Vec<Ray>,
}

impl Eight {
    fn new(rays: Vec<Ray>) -> Eight {
        Eight { bvh: Bvh8::build(&ball::scene().geometry(), &BuildOptions::default()), rays }
    }

    fn tracer(&self) -> Bvh8Tracer<'_> {
        self.bvh.tracer_at(LEVEL).expect("a CPU with AVX2")
    }

    fn batch(&self, coherence: Coherence) -> usize {
        let mut hits = vec![Hit::miss(f32::INFINITY); self.rays.len()];
        self.tracer().closest_hits(&self.rays, Filters::Shared(&RayFilter::ALL), coherence, &mut hits);
        hits.iter().filter(|hit| is_hit(hit)).count()
    }
}

fn is_hit(hit: &Hit) -> bool {
    hit.t < f32::INFINITY
}

fn one_by_one(tracer: &impl Tracer, rays: &[Ray]) -> usize {
    rays.iter().filter(|ray| is_hit(&tracer.closest_hit(ray, &RayFilter::ALL))).count()
}

/// A batch of camera rays, whose way the tracer chooses by itself.
pub struct EightCamera(Eight);

impl Case for EightCamera {
    const AT_LEAST: usize = 1200;

    fn new() -> EightCamera {
        EightCamera(Eight::new(ball::camera_rays()))
    }

    fn run(&self) -> usize {
        self.0.batch(Coherence::Auto)
    }
}

/// A batch of scattered rays, whose way the tracer chooses by itself.
pub struct EightScattered(Eight);

impl Case for EightScattered {
    const AT_LEAST: usize = 1000;

    fn new() -> EightScattered {
        EightScattered(Eight::new(ball::scattered_rays()))
    }

    fn run(&self) -> usize {
        self.0.batch(Coherence::Auto)
    }
}

/// Scattered rays, one after the other.
pub struct EightSingle(Eight);

impl Case for EightSingle {
    const AT_LEAST: usize = 1000;

    fn new() -> EightSingle {
        EightSingle(Eight::new(ball::scattered_rays()))
    }

    fn run(&self) -> usize {
        one_by_one(&self.0.tracer(), &self.0.rays)
    }
}

/// Scattered rays through the hierarchy of two children, one after the other, compiled for any CPU: fused multiply-adds are
/// calls of the C library. [`crate::PictureScalar`] has the same walk for AVX2.
pub struct TwoSingle {
    bvh: Bvh,
    rays: Vec<Ray>,
}

impl Case for TwoSingle {
    const AT_LEAST: usize = 1000;

    fn new() -> TwoSingle {
        let bvh = Bvh::build(&ball::scene().geometry(), &BuildOptions::default());
        TwoSingle { bvh, rays: ball::scattered_rays() }
    }

    fn run(&self) -> usize {
        one_by_one(&self.bvh.tracer(IgnoreWork), &self.rays)
    }
}
