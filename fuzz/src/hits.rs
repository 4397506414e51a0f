//! Small worlds and rays from bytes, and every structure over them.

use crate::support::World;
use eosphor_accel::{
    BatchTracer, BuildOptions, Builder, Bvh, Bvh8, Coherence, Exhaustive, Filters, Grid, GridOptions, KdTree,
    KdTreeOptions, Octree, OctreeOptions, SceneGeometry, SimdLevel,
};
use eosphor_core::geometry::{Instance, Sphere};
use eosphor_core::hierarchy::{IgnoreWork, Tracer};
use eosphor_core::math::{Affine, Vec3, vec3};
use eosphor_core::ray::{Hit, PrimitiveId, Ray, RayFilter};

/// Bytes taken one after the other; zeros when there are no more.
struct Bytes<'a> {
    left: &'a [u8],
    /// Numbers of worlds are no larger than this.
    largest: f32,
}

impl Bytes<'_> {
    fn byte(&mut self) -> u8 {
        let (first, rest) = self.left.split_first().unwrap_or((&0, &[]));
        self.left = rest;
        *first
    }

    /// Any bits.
    fn raw(&mut self) -> f32 {
        f32::from_le_bytes([0; 4].map(|_: u8| self.byte()))
    }

    /// Mostly tame: a multiple of a sixteenth, or one next to it; now and then any finite number in range.
    fn number(&mut self) -> f32 {
        let byte = self.byte();
        match byte {
            0..=199 => (byte as f32 - 100.0) / 16.0,
            200..=219 => ((byte as f32 - 210.0) / 16.0).next_up(),
            220..=229 => 10f32.powi((byte as i32 - 225) * 3),
            _ => {
                let x = self.raw();
                if x.is_finite() { x.clamp(-self.largest, self.largest) } else { 0.0 }
            }
        }
    }

    fn point(&mut self) -> Vec3 {
        vec3(self.number(), self.number(), self.number())
    }

    fn triangles(&mut self, most: u8) -> Vec<[Vec3; 3]> {
        let count = self.byte() % (most + 1);
        let mut all: Vec<[Vec3; 3]> = Vec::new();
        for _ in 0..count {
            // Again and again the corners of the last one.
            let last = all.last().copied().unwrap_or_default();
            let kind = self.byte();
            let mut corner = |k: usize| if kind >> k & 1 == 0 { self.point() } else { last[k] };
            all.push([corner(0), corner(1), corner(2)]);
        }
        all
    }

    fn spheres(&mut self, most: u8) -> Vec<Sphere> {
        let count = self.byte() % (most + 1);
        (0..count)
            .map(|_| Sphere { center: self.point(), radius: self.number().abs().max(f32::MIN_POSITIVE) })
            .collect()
    }

    fn world(&mut self) -> World {
        let (triangles, spheres) = (self.triangles(40), self.spheres(6));
        let mut world = World::new(triangles, spheres);
        for _ in 0..self.byte() % 3 {
            let (triangles, spheres) = (self.triangles(12), self.spheres(3));
            let geometry = world.add_geometry(&triangles, &spheres);
            for _ in 0..self.byte() % 4 {
                let columns = [self.point(), self.point(), self.point()];
                world.add_instance(geometry, Affine { columns, translation: self.point() });
            }
        }
        // Flattening refuses what is placed beyond where rays are traced.
        let fits = |i: &Instance| SceneGeometry::of_instances(std::slice::from_ref(i)).is_ok();
        let world_itself = world.instances.remove(0);
        world.instances.retain(fits);
        world.instances.insert(0, world_itself);
        world
    }

    fn ray(&mut self) -> Ray {
        let kind = self.byte();
        let origin = self.point();
        let to = self.point();
        let direction = match kind & 3 {
            0 => to - origin,
            1 => (to - origin).normalize_or(vec3(0.0, -0.0, 1.0)),
            2 => to,
            _ => vec3(self.raw(), self.raw(), self.raw()),
        };
        let t_min = if kind & 4 == 0 { 0.0 } else { self.raw() };
        let t_max = if kind & 8 == 0 { f32::INFINITY } else { self.raw() };
        Ray { origin, t_min, direction, t_max }
    }

    fn filter(&mut self) -> RayFilter {
        let kind = self.byte();
        let mut id = |bit: u8| {
            if kind & bit == 0 {
                return PrimitiveId::NONE;
            }
            PrimitiveId { instance: (self.byte() % 4) as u32, primitive: (self.byte() % 40) as u32 }
        };
        RayFilter { start: id(1), target: id(2), cull_back_faces: kind & 4 != 0 }
    }
}

/// Every structure over a world.
struct Structures {
    exhaustive: Exhaustive,
    bvhs: Vec<Bvh>,
    bvh8s: Vec<Bvh8>,
    octree: Octree,
    grid: Grid,
    kdtree: KdTree,
}

impl Structures {
    fn new(world: &World, max_leaf_primitives: u32, traversal_cost: f32) -> Structures {
        let scene = world.geometry();
        let options =
            Builder::ALL.map(|b| BuildOptions { max_leaf_primitives, traversal_cost, ..BuildOptions::of(b) });
        let octree = OctreeOptions { max_leaf_primitives, max_depth: 6, ..OctreeOptions::default() };
        Structures {
            exhaustive: Exhaustive::new(&scene),
            bvhs: options.iter().map(|o| Bvh::build(&scene, o)).collect(),
            bvh8s: options.iter().map(|o| Bvh8::build(&scene, o)).collect(),
            octree: Octree::build(&scene, &octree),
            grid: Grid::build(&scene, &GridOptions::default()),
            kdtree: KdTree::build(&scene, &KdTreeOptions { traversal_cost, ..KdTreeOptions::default() }),
        }
    }
}

/// Builds everything over a world of any finite numbers.
pub fn build(bytes: &[u8]) {
    let mut bytes = Bytes { left: bytes, largest: f32::MAX };
    let (leaf, cost) = (bytes.byte().max(1) as u32, bytes.byte() as f32 / 32.0);
    let world = bytes.world();
    // What lies beyond where rays are traced is refused.
    if !world.is_in_range() {
        return;
    }
    let structures = Structures::new(&world, leaf, cost);
    for bvh in &structures.bvhs {
        let statistics = bvh.statistics();
        assert!((statistics.max_leaf_depth as usize) < eosphor_core::hierarchy::MAX_BVH_DEPTH);
    }
    assert!(structures.bvh8s.iter().all(|bvh8| !bvh8.statistics().structure.is_empty()));
    let others =
        [structures.octree.statistics(), structures.grid.statistics(), structures.kdtree.statistics()];
    let count = world.triangles.len() + world.spheres.len();
    assert!(others.iter().all(|s| s.primitives as usize == count));
}

fn bits(h: &Hit) -> (u32, u32, u32, PrimitiveId) {
    (h.t.to_bits(), h.u.to_bits(), h.v.to_bits(), h.id)
}

/// Compares every structure with none.
pub fn traverse(bytes: &[u8]) {
    let mut bytes = Bytes { left: bytes, largest: 1e12 };
    let (leaf, cost) = (bytes.byte().max(1) as u32, bytes.byte() as f32 / 32.0);
    let world = bytes.world();
    let structures = Structures::new(&world, leaf, cost);
    let count = 1 + bytes.byte() as usize % 24;
    let rays: Vec<Ray> = (0..count).map(|_| bytes.ray()).collect();
    let filters: Vec<RayFilter> = (0..count).map(|_| bytes.filter()).collect();
    let reference = structures.exhaustive.tracer(IgnoreWork);
    for k in 0..count {
        let (ray, filter) = (&rays[k], &filters[k]);
        let expected = all_queries(&reference, ray, filter);
        let same = |name: &str, (hit, next, hidden): (Hit, Hit, bool)| {
            let equal =
                bits(&hit) == bits(&expected.0) && bits(&next) == bits(&expected.1) && hidden == expected.2;
            assert!(equal, "{name}: {hit:?} {next:?} {hidden} instead of {expected:?} for {:?}", rays[k]);
        };
        for bvh in &structures.bvhs {
            same("bvh", all_queries(&bvh.tracer(IgnoreWork), ray, filter));
        }
        let octree = &structures.octree;
        same("octree", all_queries(&octree.tracer(IgnoreWork), ray, filter));
        same("parametric", all_queries(&octree.parametric_tracer(IgnoreWork), ray, filter));
        same("grid", all_queries(&structures.grid.tracer(IgnoreWork), ray, filter));
        same("kd-tree", all_queries(&structures.kdtree.tracer(IgnoreWork), ray, filter));
    }
    for tracer in
        SimdLevel::available().flat_map(|l| structures.bvh8s.iter().filter_map(move |b| b.tracer_at(l)))
    {
        for coherence in [Coherence::Auto, Coherence::Coherent, Coherence::Incoherent] {
            let mut hits = vec![Hit::miss(0.0); count];
            let mut hidden = vec![false; count];
            tracer.closest_hits(&rays, Filters::Each(&filters), coherence, &mut hits);
            tracer.occluded_rays(&rays, Filters::Each(&filters), coherence, &mut hidden);
            let mut next = hits.clone();
            tracer.next_hits(&rays, Filters::Each(&filters), coherence, &mut next);
            for k in 0..count {
                let expected = all_queries(&reference, &rays[k], &filters[k]);
                let equal = bits(&hits[k]) == bits(&expected.0)
                    && bits(&next[k]) == bits(&expected.1)
                    && hidden[k] == expected.2;
                let (hit, ray) = (&hits[k], &rays[k]);
                assert!(
                    equal,
                    "bvh8 {coherence:?}: {hit:?} {} instead of {expected:?} for {ray:?}",
                    hidden[k]
                );
            }
        }
    }
}

/// The closest hit, the one after it, and whether there is any.
fn all_queries(tracer: &impl Tracer, ray: &Ray, filter: &RayFilter) -> (Hit, Hit, bool) {
    let closest = tracer.closest_hit(ray, filter);
    (closest, tracer.next_hit(ray, filter, &closest), tracer.occluded(ray, filter))
}
