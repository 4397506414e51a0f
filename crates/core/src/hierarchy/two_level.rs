//! What all structures share: the world first, then what instances place, and the three queries over both.

use super::Work;
use super::bvh::{BvhNode, VisitLeaf, walk, walk_after};
use super::candidates::{Placement, PrimitivesView, trusted};
use super::far::{FarRay, is_far};
use super::moved::Moved;
use super::search::{Any, Closest, Next, Search};
use crate::intersect::{LocalRay, Slab};
use crate::math::Vec3;
use crate::out_of_line::IS_SMALL;
use crate::ray::{Hit, Ray, RayFilter};

/// A tree over the instances but the world.
#[derive(Clone, Copy, Debug)]
pub struct InstanceTreeView<'a> {
    /// Its nodes, perhaps among others.
    pub nodes: &'a [BvhNode],
    /// Number of the root.
    pub root: u32,
    /// Numbers of instances, in the order of the leaves.
    pub order: &'a [u32],
}

/// A structure that can search one geometry in its own space, and find the instances that a ray meets. All queries
/// follow from that.
pub(super) trait SearchScene {
    /// What is searched.
    fn primitives(&self) -> &PrimitivesView<'_>;

    /// Offers all hits in a geometry that can still matter; `true` ends the search.
    fn search_geometry(
        &self,
        geometry: u32,
        ray: &LocalRay,
        placement: &Placement,
        filter: &RayFilter,
        search: &mut impl Search,
    ) -> bool;

    /// Offers all hits in what instances place, and before these all in the world where its ray is given; `true` ends the search.
    fn search_instances(
        &self,
        world_ray: Option<&LocalRay>,
        ray: &Ray,
        filter: &RayFilter,
        search: &mut impl Search,
    ) -> bool;

    /// Searches what one instance places, if the ray meets its box; `true` ends the search. The world, 0, has none: its ray must
    /// be given then.
    #[inline(always)]
    fn search_instance(
        &self,
        number: u32,
        world_ray: Option<&LocalRay>,
        ray: &Ray,
        slab: &Slab,
        filter: &RayFilter,
        search: &mut impl Search,
    ) -> bool {
        let primitives = self.primitives();
        let entered = match world_ray {
            Some(world_ray) if number == 0 => Some((Placement::world(ray), *world_ray)),
            _ => primitives.enter_instance(number, ray, slab, [ray.t_min, search.t_max()]),
        };
        match entered {
            Some((placement, local)) => {
                let geometry = trusted(primitives.instances, number).geometry;
                self.search_geometry(geometry, &local, &placement, filter, search)
            }
            None => false,
        }
    }

    /// Whether the search goes on from the world, whose ray this is, to what instances place. A ray with numbers out of range hits
    /// nothing, though in an instance's own space they may be in range.
    #[inline(always)]
    fn goes_on(&self, world_ray: &LocalRay) -> bool {
        self.primitives().instances.len() > 1 && !world_ray.t_min.is_nan()
    }

    /// Searches everything.
    #[inline(always)]
    fn search(&self, ray: &Ray, filter: &RayFilter, search: &mut impl Search) {
        let primitives = self.primitives();
        let world_ray = LocalRay::of(ray, None, trusted(primitives.geometries, 0).extent);
        if IS_SMALL {
            self.search_instances(Some(&world_ray), ray, filter, search);
            return;
        }
        if self.search_geometry(0, &world_ray, &Placement::world(ray), filter, search) {
            return;
        }
        if self.goes_on(&world_ray) {
            self.search_instances(None, ray, filter, search);
        }
    }

    /// [`super::Tracer::closest_hit`].
    #[inline(always)]
    fn find_closest(&self, ray: &Ray, filter: &RayFilter) -> Hit {
        let mut search = Closest::new(ray.t_max, 0.0);
        self.search(ray, filter, &mut search);
        search.hit(self.primitives(), ray)
    }

    /// [`super::Tracer::occluded`].
    #[inline(always)]
    fn find_any(&self, ray: &Ray, filter: &RayFilter) -> bool {
        let mut search = Any::new(ray.t_max, 0.0);
        self.search(ray, filter, &mut search);
        search.found
    }

    /// [`super::Tracer::next_hit`].
    #[inline(always)]
    fn find_next(&self, ray: &Ray, filter: &RayFilter, after: &Hit) -> Hit {
        let mut search = Next::new(ray, after, 0.0);
        self.search(ray, filter, &mut search);
        search.hit(self.primitives(), ray)
    }

    /// [`super::Tracer::hit_after`]: one search for both.
    #[inline(always)]
    fn find_after(&self, ray: &Ray, filter: &RayFilter, after: Option<&Hit>) -> Hit {
        let mut search = match after {
            Some(after) => Next::new(ray, after, 0.0),
            None => Next::from_start(ray),
        };
        self.search(ray, filter, &mut search);
        match after {
            Some(_) => search.hit(self.primitives(), ray),
            None => search.closest(self.primitives(), ray),
        }
    }
}

/// Makes a `Name<'_, C: Work>` that is a [`SearchScene`] a `Tracer`.
macro_rules! answer_queries {
    ($tracer:ident) => {
        impl<C: Work> Tracer for $tracer<'_, C> {
            #[inline(always)]
            fn closest_hit(&self, ray: &Ray, filter: &RayFilter) -> Hit {
                self.find_closest(ray, filter)
            }

            #[inline(always)]
            fn occluded(&self, ray: &Ray, filter: &RayFilter) -> bool {
                self.find_any(ray, filter)
            }

            #[inline(always)]
            fn next_hit(&self, ray: &Ray, filter: &RayFilter, after: &Hit) -> Hit {
                self.find_next(ray, filter, after)
            }

            #[inline(always)]
            fn hit_after(&self, ray: &Ray, filter: &RayFilter, after: Option<&Hit>) -> Hit {
                self.find_after(ray, filter, after)
            }
        }
    };
}
pub(super) use answer_queries;

/// A leaf that stands for the world.
const WORLD: BvhNode = BvhNode { min: Vec3::ZERO, first: u32::MAX - 1, max: Vec3::ZERO, count: 1 };

/// Leaves of instances.
struct InstanceLeaves<'a, T> {
    scene: &'a T,
    order: &'a [u32],
    world_ray: Option<&'a LocalRay>,
    ray: &'a Ray,
    slab: Slab,
    filter: &'a RayFilter,
}

impl<T: SearchScene> VisitLeaf for InstanceLeaves<'_, T> {
    #[inline(always)]
    fn visit(&mut self, leaf: &BvhNode, search: &mut impl Search) -> bool {
        let mut k = leaf.first;
        while k < leaf.first + (leaf.count & !BvhNode::SPHERES) {
            let is_world = self.world_ray.is_some() && leaf.first == WORLD.first;
            let number = if is_world { 0 } else { *trusted(self.order, k) };
            let (world_ray, ray) = (self.world_ray, self.ray);
            if self.scene.search_instance(number, world_ray, ray, &self.slab, self.filter, search.whole()) {
                return true;
            }
            k += 1;
        }
        false
    }
}

impl InstanceTreeView<'_> {
    /// [`SearchScene::search_instances`] by a walk through this tree.
    #[inline(always)]
    pub(super) fn search(
        &self,
        scene: &impl SearchScene,
        work: &impl Work,
        world_ray: Option<&LocalRay>,
        ray: &Ray,
        filter: &RayFilter,
        search: &mut impl Search,
    ) -> bool {
        let slab = scene.primitives().world_slab(ray);
        let mut leaves = InstanceLeaves { scene, order: self.order, world_ray, ray, slab, filter };
        let mut goes_on = world_ray.is_none_or(|world_ray| scene.goes_on(world_ray));
        let (mut slab, mut t_min, mut from) = (slab, ray.t_min, None);
        if goes_on {
            let bounds = trusted(self.nodes, self.root).bounds();
            let is_far = is_far(ray.origin, bounds.extent());
            if !is_far & !IS_SMALL {
                return walk(self.nodes, self.root, &slab, ray.t_min, work, search, &mut leaves);
            }
            if is_far {
                match FarRay::to_instances(ray, &bounds) {
                    Some(far) => (slab, t_min, from) = (far.ray.slab, far.ray.t_min, Some(far.from)),
                    None => goes_on = false,
                }
            }
        }
        let mut search = Moved::perhaps(search, from);
        let world = if world_ray.is_some() { Some(&WORLD) } else { None };
        let tree = (self.nodes, if goes_on { Some(self.root) } else { None });
        walk_after(world, tree, &slab, t_min, work, &mut search, &mut leaves)
    }
}
