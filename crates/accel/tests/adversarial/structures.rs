//! Every structure over a scene, and every query of every way through it.

use crate::Numbers;
use eosphor_accel::{
    BatchTracer, BuildOptions, Builder, Bvh, Bvh8, BvhPairs, BvhWide, Coherence, Exhaustive, Filters, Grid,
    GridOptions, Hit, IgnoreWork, KdTree, KdTreeOptions, Octree, OctreeOptions, PrimitiveId, Ray, RayFilter,
    SceneGeometry, SimdLevel, Tracer, Vec3, vec3,
};

/// How structures are built.
#[derive(Clone, Copy)]
pub(crate) struct Options {
    pub(crate) bvh: BuildOptions,
    pub(crate) octree: OctreeOptions,
    pub(crate) grid: GridOptions,
    pub(crate) kdtree: KdTreeOptions,
}

impl Options {
    pub(crate) fn of(builder: Builder) -> Options {
        Options {
            bvh: BuildOptions::of(builder),
            octree: OctreeOptions::default(),
            grid: GridOptions::default(),
            kdtree: KdTreeOptions::default(),
        }
    }
}

/// All builders of bounding volume hierarchies.
pub(crate) const BUILDERS: [Builder; 6] = Builder::ALL;

/// Some rays of every kind: from within and from far away, along axes, and with numbers of any bits.
pub(crate) fn rays(count: usize, extent: f32, numbers: &mut Numbers) -> Vec<Ray> {
    (0..count)
        .map(|k| {
            let mut point = |scale: f32| vec3(numbers.unit(), numbers.unit(), numbers.unit()) * scale;
            let (origin, direction) = (point(extent), point(1.0));
            match k % 5 {
                0 => Ray::new(origin, direction),
                1 => Ray::new(origin * 1e6, -origin * (1.0 / origin.length())),
                2 => Ray { t_max: 0.5 * extent, ..Ray::new(origin, vec3(0.0, -1.0, 0.0)) },
                3 => Ray::new(Vec3::ZERO, Vec3::ZERO),
                _ => {
                    let mut any = || vec3(numbers.any(), numbers.any(), numbers.any());
                    let (origin, direction) = (any(), any());
                    Ray { origin, t_min: numbers.any(), direction, t_max: numbers.any() }
                }
            }
        })
        .collect()
}

/// Builds everything there is, and asks everything.
pub(crate) fn ask_everything(scene: &SceneGeometry, options: &Options, rays: &[Ray]) {
    ask(&Exhaustive::new(scene).tracer(IgnoreWork), rays);
    let bvh = Bvh::build(scene, &options.bvh);
    ask(&bvh.tracer(IgnoreWork), rays);
    if let Some(pairs) = BvhPairs::new(&bvh) {
        ask(&pairs.tracer(&bvh), rays);
        ask(&pairs.tracer_in_step(&bvh), rays);
        ask(&pairs.far_tracer(&bvh), rays);
        if let Some(wide) = BvhWide::new(&pairs) {
            ask(&wide.tracer(&bvh), rays);
        }
    }
    let octree = Octree::build(scene, &options.octree);
    ask(&octree.tracer(IgnoreWork), rays);
    ask(&octree.parametric_tracer(IgnoreWork), rays);
    ask(&Grid::build(scene, &options.grid).tracer(IgnoreWork), rays);
    ask(&KdTree::build(scene, &options.kdtree).tracer(IgnoreWork), rays);
    let bvh8 = Bvh8::build(scene, &options.bvh);
    for tracer in SimdLevel::available().filter_map(|level| bvh8.tracer_at(level)) {
        ask(&tracer, rays);
        for coherence in [Coherence::Auto, Coherence::Coherent, Coherence::Incoherent] {
            let filters = Filters::Shared(&RayFilter::ALL);
            let mut hits = vec![Hit::miss(0.0); rays.len()];
            tracer.closest_hits(rays, filters, coherence, &mut hits);
            tracer.occluded_rays(rays, filters, coherence, &mut vec![false; rays.len()]);
            tracer.next_hits(rays, filters, coherence, &mut hits);
        }
    }
}

/// Asks every query of one ray.
pub(crate) fn ask(tracer: &impl Tracer, rays: &[Ray]) {
    let nowhere = PrimitiveId { instance: u32::MAX, primitive: u32::MAX };
    let filter = RayFilter { start: nowhere, target: nowhere, cull_back_faces: true };
    for ray in rays {
        let hit = tracer.closest_hit(ray, &RayFilter::ALL);
        tracer.occluded(ray, &filter);
        tracer.next_hit(ray, &RayFilter::ALL, &hit);
        // Hits that nobody found.
        for id in [nowhere, PrimitiveId { instance: 0, primitive: u32::MAX - 1 }] {
            for t in [0.0, f32::NAN, f32::INFINITY, hit.t] {
                tracer.next_hit(ray, &filter, &Hit { t, t_rest: f32::NAN, u: t, v: t, id });
            }
        }
    }
}
