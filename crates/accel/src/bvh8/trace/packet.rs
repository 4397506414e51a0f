//! Sixteen rays at a time.
//!
//! Rays of one octant walk together: a node's eight boxes are first tested against the interval that holds all rays, the
//! ones that pass against each ray (Wald et al. 2001, "Interactive Rendering with Coherent Ray Tracing"; Boulos et al.
//! 2006, "Geometric and Arithmetic Culling Methods for Entire Ray Packets"). Where only a few rays are left in a
//! subtree, they go on alone.

use super::lanes::{ConfirmedV, RayV, TriangleV};
use super::single;
use super::walk::{ANY, Found, NEXT, Query, STACK};
use crate::bvh8::{Bvh8, Child, EMPTY, INSTANCE, LEAF, PLACE, SPHERE};
use crate::simd::{Float, Kernel, Mask, Simd, Vec3V, along, cross, each, splat3};
use eosphor_core::geometry::Sphere;
use eosphor_core::hierarchy::ShadowBatch;
use eosphor_core::intersect::{LocalRay, PackedTriangle, SLAB_SLACK, intersect_sphere};
use eosphor_core::math::{Vec3, vec3};
use eosphor_core::ray::{Hit, PrimitiveId, Ray, RayFilter};
use std::mem::MaybeUninit;

type MaskOf<S> = <<S as Simd>::F16 as Float>::Mask;

/// Sixteen rays in world space and what they have found.
pub(super) struct Packet<S: Simd> {
    pub(super) origin: Vec3V<S::F16>,
    pub(super) direction: Vec3V<S::F16>,
    pub(super) t_min: S::F16,
    /// Largest `t` that counts: the best hit's. For [`ANY`], minus infinity where there is a hit.
    pub(super) t_max: S::F16,
    pub(super) u: S::F16,
    pub(super) v: S::F16,
    /// The best hit's, as bits.
    pub(super) primitive: S::F16,
    pub(super) instance: S::F16,
}

/// What the rays leave out.
pub(super) struct LaneFilters<S: Simd> {
    /// Bits of the triangles' numbers and instances.
    start: [S::F16; 2],
    target: [S::F16; 2],
    /// Lanes that see no backs.
    cull: MaskOf<S>,
}

impl<S: Simd> LaneFilters<S> {
    /// The same for all lanes.
    #[inline(always)]
    pub(super) fn shared(filter: &RayFilter) -> LaneFilters<S> {
        let splat = |bits: u32| S::F16::splat(f32::from_bits(bits));
        let (start, target) = (filter.start, filter.target);
        LaneFilters {
            start: [splat(start.primitive), splat(start.instance)],
            target: [splat(target.primitive), splat(target.instance)],
            cull: MaskOf::<S>::from_bits(if filter.cull_back_faces { 0xffff } else { 0 }),
        }
    }

    /// The lanes of `mask` that see a triangle which they meet with this determinant.
    #[inline(always)]
    fn apply(&self, mask: MaskOf<S>, instance: u32, primitive: u32, determinant: S::F16) -> MaskOf<S> {
        let (i, p) = (S::F16::splat(f32::from_bits(instance)), S::F16::splat(f32::from_bits(primitive)));
        let start = self.start[0].same_bits(p).and(self.start[1].same_bits(i));
        let target = self.target[0].same_bits(p).and(self.target[1].same_bits(i));
        // The front is where the ray goes against the normal; minus 0 counts as that.
        let back = determinant.sign().same_bits(S::F16::splat(0.0)).and(self.cull);
        mask.without(start.or(target).or(back))
    }

    #[inline(always)]
    pub(super) fn new(filters: &[&RayFilter; 16]) -> LaneFilters<S> {
        let mut bits = [[0u32; 16]; 4];
        let mut cull = 0;
        let mut lane = 0;
        while lane < 16 {
            let f = filters[lane];
            bits[0][lane] = f.start.primitive;
            bits[1][lane] = f.start.instance;
            bits[2][lane] = f.target.primitive;
            bits[3][lane] = f.target.instance;
            cull |= (f.cull_back_faces as u32) << lane;
            lane += 1;
        }
        // SAFETY: sixteen numbers of 32 bits are sixteen floats.
        unsafe {
            LaneFilters {
                start: [S::F16::load(bits[0].as_ptr().cast()), S::F16::load(bits[1].as_ptr().cast())],
                target: [S::F16::load(bits[2].as_ptr().cast()), S::F16::load(bits[3].as_ptr().cast())],
                cull: MaskOf::<S>::from_bits(cull),
            }
        }
    }
}

/// A walk of the packet in the space of one instance.
struct Leg<'a, S: Simd> {
    ray: RayV<S::F16>,
    extent: f32,
    instance: u32,
    /// Where the rays are in the instance's world box; for the world itself, everywhere.
    world_interval: Option<(S::F16, S::F16)>,
    filters: Option<&'a LaneFilters<S>>,
}

/// Bounds of the rays of a group, for boxes: `plane * scale + offset` is no later than any ray enters, no earlier than
/// any leaves.
struct Interval<S: Simd> {
    near_scale: Vec3V<S::F8>,
    near_offset: Vec3V<S::F8>,
    far_scale: Vec3V<S::F8>,
    far_offset: Vec3V<S::F8>,
    t_min: S::F8,
}

/// The interval is widened by this times the extent of geometry and rays: over the slack that each ray's own test has,
/// and the rounding of both.
const INTERVAL_SLACK: f32 = 4.0 * SLAB_SLACK;

impl<S: Simd> Interval<S> {
    /// Of rays that all go into one octant and whose `t_min` is not below 0: what lies behind an origin then fails by
    /// its sign, whatever the bounds make of it.
    #[inline(always)]
    fn new(ray: &RayV<S::F16>, extent: f32, group: MaskOf<S>, octant: usize) -> Interval<S> {
        let zero = S::F8::splat(0.0);
        let none = [zero, zero, zero];
        let mut interval =
            Interval { near_scale: none, near_offset: none, far_scale: none, far_offset: none, t_min: zero };
        let mut low = [0.0; 3];
        let mut high = [0.0; 3];
        let mut reach = extent;
        let mut k = 0;
        while k < 3 {
            let origin = ray.origin[k];
            low[k] = origin.smallest(group);
            // Most groups start at one point.
            let same = group.without(origin.le(S::F16::splat(low[k])));
            high[k] = if same.any() { origin.largest(group) } else { low[k] };
            reach = reach.max(low[k].abs()).max(high[k].abs());
            k += 1;
        }
        k = 0;
        while k < 3 {
            let inverse = ray.slab.inverse[k];
            let (i0, i1) = (inverse.smallest(group), inverse.largest(group));
            let backward = octant >> k & 1 == 1;
            let (near, near_origin) = if backward { (i1, low[k]) } else { (i0, high[k]) };
            let (far, far_origin) = if backward { (i0, high[k]) } else { (i1, low[k]) };
            let slack = INTERVAL_SLACK * reach * i0.abs().max(i1.abs());
            interval.near_scale[k] = S::F8::splat(near);
            interval.near_offset[k] = S::F8::splat(-(near * near_origin) - slack);
            interval.far_scale[k] = S::F8::splat(far);
            interval.far_offset[k] = S::F8::splat(slack - far * far_origin);
            k += 1;
        }
        interval
    }
}

impl<S: Simd> Packet<S> {
    /// From sixteen rays.
    ///
    /// # Safety
    /// The pointers point to rays, and the CPU has the instruction set.
    #[inline(always)]
    pub(super) unsafe fn load(rays: &[*const f32; 16]) -> Packet<S> {
        // SAFETY: a ray is eight floats.
        let [ox, oy, oz, t_min, dx, dy, dz, t_max] = unsafe { S::transpose16(rays) };
        let none = S::F16::splat(f32::from_bits(u32::MAX));
        let zero = S::F16::splat(0.0);
        Packet {
            origin: [ox, oy, oz],
            direction: [dx, dy, dz],
            t_min,
            t_max,
            u: zero,
            v: zero,
            primitive: none,
            instance: none,
        }
    }

    /// From rays that start at one point.
    #[inline(always)]
    pub(super) fn from_one_point(batch: &ShadowBatch<16>) -> Packet<S> {
        let none = S::F16::splat(f32::from_bits(u32::MAX));
        let zero = S::F16::splat(0.0);
        // SAFETY: sixteen floats each.
        unsafe {
            Packet {
                origin: splat3(batch.origin),
                direction: [
                    S::F16::load(batch.x.as_ptr()),
                    S::F16::load(batch.y.as_ptr()),
                    S::F16::load(batch.z.as_ptr()),
                ],
                t_min: zero,
                t_max: S::F16::load(batch.t_max.as_ptr()),
                u: zero,
                v: zero,
                primitive: none,
                instance: none,
            }
        }
    }

    /// Traces the lanes of `active`. Where at most `alone` rays are left in a subtree, they go on alone.
    ///
    /// # Safety
    /// The CPU has the instruction set.
    #[inline(always)]
    pub(super) unsafe fn trace<const QUERY: Query>(
        &mut self,
        bvh: &Bvh8,
        active: u32,
        lane_filters: Option<&LaneFilters<S>>,
        filters: &[&RayFilter; 16],
        alone: u32,
    ) {
        debug_assert!(QUERY != NEXT);
        let zero = S::F16::splat(0.0);
        let active = MaskOf::<S>::from_bits(active);
        if QUERY == ANY {
            // That end marks rays with a hit. One that comes with it has none, as with any end that is no number.
            let marked = self.t_max.same_bits(S::F16::splat(f32::NEG_INFINITY));
            self.t_max = S::F16::splat(f32::NAN).or_else(marked, self.t_max);
        }
        let extent = bvh.geometries[0].extent;
        let leg = Leg {
            ray: RayV::new(self.origin, self.direction, self.t_min, extent),
            extent,
            instance: 0,
            world_interval: None,
            filters: lane_filters,
        };
        let together = active.and(zero.le(leg.ray.t_min)).and(leg.ray.t_min.le(self.t_max));
        // SAFETY: the caller's.
        unsafe {
            self.walk_octants::<QUERY, false>(bvh, bvh.roots[0], &leg, together, filters, alone);
            if bvh.instance_root != EMPTY {
                self.walk_octants::<QUERY, true>(bvh, bvh.instance_root, &leg, together, filters, alone);
            }
        }
        // What starts before its origin: the bounds of a group do not hold there.
        let rest = active.and(leg.ray.t_min.lt(zero)).bits();
        if rest != 0 {
            // SAFETY: the caller's.
            unsafe {
                self.go_on_alone::<QUERY, false>(bvh, bvh.roots[0], &leg, rest, filters);
                if bvh.instance_root != EMPTY {
                    self.go_on_alone::<QUERY, true>(bvh, bvh.instance_root, &leg, rest, filters);
                }
            }
        }
    }

    /// Walks for each octant that rays go into.
    #[inline(always)]
    unsafe fn walk_octants<const QUERY: Query, const INSTANCES: bool>(
        &mut self,
        bvh: &Bvh8,
        root: Child,
        leg: &Leg<S>,
        active: MaskOf<S>,
        filters: &[&RayFilter; 16],
        alone: u32,
    ) {
        let zero = S::F16::splat(0.0);
        let backward = each!(k => leg.ray.slab.inverse[k].lt(zero).bits());
        let mut left = active.bits();
        if root == EMPTY {
            return;
        }
        while left != 0 {
            let lane = left.trailing_zeros();
            let (mut group, mut octant, mut k) = (left, 0, 0);
            while k < 3 {
                if backward[k] >> lane & 1 == 1 {
                    group &= backward[k];
                    octant |= 1 << k;
                } else {
                    group &= !backward[k];
                }
                k += 1;
            }
            left &= !group;
            let group = MaskOf::<S>::from_bits(group);
            let walk =
                Walk::<S, QUERY, INSTANCES> { packet: self, bvh, root, leg, group, octant, filters, alone };
            // SAFETY: the caller's.
            unsafe { S::run(walk) };
        }
    }

    /// Visits the leaves that a group of rays enters, roughly from near to far.
    #[inline(always)]
    #[allow(clippy::too_many_arguments)]
    unsafe fn walk<const QUERY: Query, const INSTANCES: bool>(
        &mut self,
        bvh: &Bvh8,
        root: Child,
        leg: &Leg<S>,
        group: MaskOf<S>,
        octant: usize,
        filters: &[&RayFilter; 16],
        alone: u32,
    ) {
        let boxes_extent = if INSTANCES { bvh.instances_extent } else { leg.extent };
        let interval = Interval::<S>::new(&leg.ray, boxes_extent, group, octant);
        let nowhere = S::F16::splat(f32::NEG_INFINITY);
        // Not even at infinity.
        let never = S::F16::splat(f32::NAN);
        let slab = &leg.ray.slab;
        let near_planes = each!(k => 2 * k + (octant >> k & 1));
        let mut children = MaybeUninit::<[Child; STACK]>::uninit();
        let mut nears = MaybeUninit::<[S::F16; STACK]>::uninit();
        let (children, nears) = (children.as_mut_ptr().cast::<Child>(), nears.as_mut_ptr().cast::<S::F16>());
        let mut count = 0usize;
        let mut at = root;
        // Where each ray enters the node; NaN where it does not.
        let mut near = leg.ray.t_min.or_else(group, never);
        let mut latest = S::F8::splat(self.t_max.or_else(group, nowhere).largest(group));
        loop {
            let active = near.le(self.t_max);
            let bits = active.bits();
            if bits.count_ones() <= alone {
                if bits != 0 {
                    // SAFETY: the caller's.
                    unsafe { self.go_on_alone::<QUERY, INSTANCES>(bvh, at, leg, bits, filters) };
                    if QUERY == ANY && !nowhere.lt(self.t_max).and(group).any() {
                        return;
                    }
                    latest = S::F8::splat(self.t_max.largest(group));
                }
            } else if at & LEAF == 0 {
                // SAFETY: inner nodes are numbers that the builder made; the stack has room by its length.
                unsafe {
                    let node = bvh.nodes.get_unchecked(at as usize);
                    let planes = node.planes.as_ptr();
                    let (ns, no) = (&interval.near_scale, &interval.near_offset);
                    let (fs, fo) = (&interval.far_scale, &interval.far_offset);
                    let [x0, y0, z0] =
                        each!(k => S::F8::load(planes.add(near_planes[k]).cast()).fma(ns[k], no[k]));
                    let [x1, y1, z1] =
                        each!(k => S::F8::load(planes.add(near_planes[k] ^ 1).cast()).fma(fs[k], fo[k]));
                    let first = x0.max(y0).max(z0.max(interval.t_min));
                    let last = x1.min(y1).min(z1.min(latest));
                    let order = *node.orders.get_unchecked(octant);
                    let lanes = S::order8(order);
                    let mut entered = S::permute8(first, lanes).le(S::permute8(last, lanes)).bits();
                    debug_assert!(count + 8 <= STACK);
                    while entered != 0 {
                        let place = entered.trailing_zeros();
                        entered &= entered - 1;
                        let slot = (order >> (3 * place) & 7) as usize;
                        let box_planes = planes.cast::<f32>().add(slot);
                        let [x0, y0, z0] = each!(k => S::F16::splat(*box_planes.add(8 * near_planes[k]))
                            .fma(slab.inverse[k], slab.near_offset[k]));
                        let [x1, y1, z1] = each!(k => S::F16::splat(*box_planes.add(8 * (near_planes[k] ^ 1)))
                            .fma(slab.inverse[k], slab.far_offset[k]));
                        let child_near = x0.max(y0).max(z0.max(leg.ray.t_min));
                        let child_far = x1.min(y1).min(z1.min(self.t_max));
                        let enters = child_near.le(child_far).and(active);
                        if enters.any() {
                            *children.add(count) = *node.children.get_unchecked(slot);
                            nears.add(count).write(child_near.or_else(enters, never));
                            count += 1;
                        }
                    }
                }
            } else {
                // SAFETY: the caller's.
                let changed = unsafe {
                    if INSTANCES {
                        self.visit_instance::<QUERY>(bvh, at & PLACE, leg, active, filters, alone)
                    } else if at & SPHERE != 0 {
                        self.test_sphere::<QUERY>(bvh, (at & PLACE) as usize, leg, bits)
                    } else {
                        self.test_block::<QUERY>(bvh, (at & PLACE) as usize, leg, active)
                    }
                };
                if changed {
                    if QUERY == ANY && !nowhere.lt(self.t_max).and(group).any() {
                        return;
                    }
                    latest = S::F8::splat(self.t_max.largest(group));
                }
            }
            if count == 0 {
                return;
            }
            count -= 1;
            // SAFETY: below the count, the stack has been written.
            unsafe {
                at = *children.add(count);
                near = nears.add(count).read();
            }
        }
    }

    /// Tests up to four triangles; whether any ray has a new hit.
    #[inline(always)]
    unsafe fn test_block<const QUERY: Query>(
        &mut self,
        bvh: &Bvh8,
        number: usize,
        leg: &Leg<S>,
        active: MaskOf<S>,
    ) -> bool {
        debug_assert!(number & INSTANCE as usize == 0);
        // SAFETY: leaves name blocks that the builder made.
        let block = unsafe { bvh.blocks.get_unchecked(number) };
        let e1 = each!(k => S::F4::from_array(&block.e1[k]));
        let e2 = each!(k => S::F4::from_array(&block.e2[k]));
        let normals = cross(&e1, &e2);
        let normals = each!(k => normals[k].to_array());
        // Unused lanes come last.
        let used = block.count::<S>();
        let mut changed = false;
        let mut lane = 0;
        while lane < used {
            let triangle = TriangleV {
                v0: each!(k => S::F16::splat(block.v0[k][lane])),
                e1: each!(k => S::F16::splat(block.e1[k][lane])),
                e2: each!(k => S::F16::splat(block.e2[k][lane])),
                normal: each!(k => S::F16::splat(normals[k][lane])),
                length1: S::F16::splat(block.length1[lane]),
                length2: S::F16::splat(block.length2[lane]),
            };
            let edges = triangle.test_edges(&leg.ray);
            if edges.candidates.and(active).any() {
                let primitive = block.primitive[lane];
                let mut mask = triangle.in_window(&leg.ray, &edges, self.t_max).and(active);
                if let Some(filters) = leg.filters {
                    mask = filters.apply(mask, leg.instance, primitive, edges.determinant);
                }
                if mask.any() {
                    let mut hits = triangle.confirm(&leg.ray, &edges, mask);
                    if hits.unsure.any() {
                        // SAFETY: the caller's.
                        unsafe { S::run(Decide { leg, triangle: &block.get(lane), hits: &mut hits }) };
                    }
                    changed |= self.offer::<QUERY>(&hits.counts, leg, primitive, (hits.t, hits.u, hits.v));
                }
            }
            lane += 1;
        }
        changed
    }

    /// Takes hits that count where they are the best; whether there are such.
    #[inline(always)]
    fn offer<const QUERY: Query>(
        &mut self,
        counts: &MaskOf<S>,
        leg: &Leg<S>,
        primitive: u32,
        (t, u, v): (S::F16, S::F16, S::F16),
    ) -> bool {
        let mut counts = *counts;
        if let Some((near, far)) = leg.world_interval {
            counts = counts.and(near.le(far.min(t)));
        }
        if QUERY == ANY {
            let hidden = counts.and(t.le(self.t_max));
            self.t_max = S::F16::splat(f32::NEG_INFINITY).or_else(hidden, self.t_max);
            return hidden.any();
        }
        let (instance_v, primitive_v) =
            (S::F16::splat(f32::from_bits(leg.instance)), S::F16::splat(f32::from_bits(primitive)));
        let mut better = counts.and(t.lt(self.t_max));
        let ties = counts.and(t.le(self.t_max)).without(better);
        if ties.any() {
            let same = instance_v.same_bits(self.instance).and(primitive_v.bits_below(self.primitive));
            better = better.or(ties.and(instance_v.bits_below(self.instance).or(same)));
        }
        self.t_max = t.or_else(better, self.t_max);
        self.u = u.or_else(better, self.u);
        self.v = v.or_else(better, self.v);
        self.primitive = primitive_v.or_else(better, self.primitive);
        self.instance = instance_v.or_else(better, self.instance);
        better.any()
    }

    /// Tests a sphere; whether any ray has a new hit.
    #[inline(always)]
    unsafe fn test_sphere<const QUERY: Query>(
        &mut self,
        bvh: &Bvh8,
        number: usize,
        leg: &Leg<S>,
        lanes: u32,
    ) -> bool {
        // SAFETY: the caller's.
        let roots = unsafe { S::run(SphereTest { leg, sphere: &bvh.spheres[number], lanes }) };
        let zero = S::F16::splat(0.0);
        let (mut changed, mut root) = (false, 0);
        while root < 2 {
            // SAFETY: sixteen floats.
            let t = unsafe { S::F16::load(roots[root].as_ptr()) };
            // Roots that are not hits are NaN.
            let counts = t.le(t).and(MaskOf::<S>::from_bits(lanes));
            changed |= self.offer::<QUERY>(&counts, leg, bvh.sphere_primitives[number], (t, zero, zero));
            root += 1;
        }
        changed
    }

    /// Searches what an instance places.
    #[inline(always)]
    unsafe fn visit_instance<const QUERY: Query>(
        &mut self,
        bvh: &Bvh8,
        number: u32,
        world: &Leg<S>,
        active: MaskOf<S>,
        filters: &[&RayFilter; 16],
        alone: u32,
    ) -> bool {
        let instance = &bvh.instances[number as usize];
        let low = splat3(instance.world_bounds.min);
        let high = splat3(instance.world_bounds.max);
        let (near, far) = world.ray.slab.interval(&low, &high, world.ray.t_min);
        let active = active.and(near.le(far.min(self.t_max)));
        if !active.any() {
            return false;
        }
        let map = &instance.object_from_world;
        let c = each!(k => splat3::<S::F16>(map.columns[k]));
        let (o, d) = (&self.origin, &self.direction);
        let from = along(&splat3(map.translation), &c[0], o[0]);
        let origin = along(&along(&from, &c[1], o[1]), &c[2], o[2]);
        let from = each!(k => c[0][k].mul(d[0]));
        let direction = along(&along(&from, &c[1], d[1]), &c[2], d[2]);
        let extent = bvh.geometries[instance.geometry as usize].extent;
        let leg = Leg {
            ray: RayV::new(origin, direction, self.t_min, extent),
            extent,
            instance: number,
            world_interval: Some((near, far)),
            filters: world.filters,
        };
        let active = active.and(S::F16::splat(0.0).le(leg.ray.t_min));
        let root = bvh.roots[instance.geometry as usize];
        // SAFETY: the caller's.
        unsafe { self.walk_octants::<QUERY, false>(bvh, root, &leg, active, filters, alone) };
        true
    }

    /// Goes on with some lanes one by one, from a node of the leg's tree.
    #[inline(always)]
    unsafe fn go_on_alone<const QUERY: Query, const INSTANCES: bool>(
        &mut self,
        bvh: &Bvh8,
        at: Child,
        leg: &Leg<S>,
        lanes: u32,
        filters: &[&RayFilter; 16],
    ) {
        let alone = Alone::<S, QUERY, INSTANCES> { packet: self, bvh, at, leg, lanes, filters };
        // SAFETY: the caller's.
        unsafe { S::run(alone) };
    }
}

/// The walk of a group: a function of its own, which keeps the code small.
struct Walk<'a, 'b, S: Simd, const QUERY: Query, const INSTANCES: bool> {
    packet: &'a mut Packet<S>,
    bvh: &'a Bvh8,
    root: Child,
    leg: &'a Leg<'b, S>,
    group: MaskOf<S>,
    octant: usize,
    filters: &'a [&'a RayFilter; 16],
    alone: u32,
}

impl<S: Simd, const QUERY: Query, const INSTANCES: bool> Kernel for Walk<'_, '_, S, QUERY, INSTANCES> {
    type Output = ();

    #[inline(always)]
    unsafe fn run<X: Simd>(self) {
        // SAFETY: the caller's.
        unsafe {
            self.packet.walk::<QUERY, INSTANCES>(
                self.bvh,
                self.root,
                self.leg,
                self.group,
                self.octant,
                self.filters,
                self.alone,
            );
        }
    }
}

/// Rays for which double precision decides, one by one: a function of its own, since it is rare and large.
struct Decide<'a, 'b, S: Simd> {
    leg: &'a Leg<'b, S>,
    triangle: &'a PackedTriangle,
    hits: &'a mut ConfirmedV<S::F16>,
}

impl<S: Simd> Kernel for Decide<'_, '_, S> {
    type Output = ();

    #[inline(always)]
    unsafe fn run<X: Simd>(self) {
        let Decide { leg, triangle, hits } = self;
        let (origin, direction) = (arrays::<S>(&leg.ray.origin), arrays::<S>(&leg.ray.direction));
        let t_min = leg.ray.t_min.to_array();
        let (mut t, mut u, mut v) = (hits.t.to_array(), hits.u.to_array(), hits.v.to_array());
        let mut counts = hits.counts.bits();
        let mut lanes = hits.unsure.bits();
        while lanes != 0 {
            let lane = lanes.trailing_zeros() as usize & 15;
            lanes &= lanes - 1;
            let (o, d) = (lane_of(&origin, lane), lane_of(&direction, lane));
            let ray = LocalRay::new(o, d, t_min.as_ref()[lane], leg.extent);
            let hit = triangle.confirm_in_double(&ray);
            counts |= (hit.counts(&ray) as u32) << lane;
            t.as_mut()[lane] = hit.t;
            u.as_mut()[lane] = hit.u;
            v.as_mut()[lane] = hit.v;
        }
        hits.counts = MaskOf::<S>::from_bits(counts);
        hits.t = S::F16::from_array(&t);
        hits.u = S::F16::from_array(&u);
        hits.v = S::F16::from_array(&v);
    }
}

/// Lanes that go on one by one: a function of its own, since it is rare and large.
struct Alone<'a, 'b, S: Simd, const QUERY: Query, const INSTANCES: bool> {
    packet: &'a mut Packet<S>,
    bvh: &'a Bvh8,
    at: Child,
    leg: &'a Leg<'b, S>,
    lanes: u32,
    filters: &'a [&'a RayFilter; 16],
}

impl<S: Simd, const QUERY: Query, const INSTANCES: bool> Kernel for Alone<'_, '_, S, QUERY, INSTANCES> {
    type Output = ();

    #[inline(always)]
    unsafe fn run<X: Simd>(self) {
        let Alone { packet, bvh, at, leg, mut lanes, filters } = self;
        let (origin, direction) = (arrays::<S>(&leg.ray.origin), arrays::<S>(&leg.ray.direction));
        let t_min = packet.t_min.to_array();
        let mut t_max = packet.t_max.to_array();
        let (mut u, mut v) = (packet.u.to_array(), packet.v.to_array());
        let (mut primitive, mut instance) = (packet.primitive.to_array(), packet.instance.to_array());
        let world = leg.world_interval.map(|(near, far)| (near.to_array(), far.to_array()));
        while lanes != 0 {
            let lane = lanes.trailing_zeros() as usize & 15;
            lanes &= lanes - 1;
            let id = PrimitiveId {
                instance: instance.as_ref()[lane].to_bits(),
                primitive: primitive.as_ref()[lane].to_bits(),
            };
            let best = Hit { t: t_max.as_ref()[lane], u: u.as_ref()[lane], v: v.as_ref()[lane], id };
            let mut found = Found { best, ..Found::nothing(best.t) };
            let (o, d) = (lane_of(&origin, lane), lane_of(&direction, lane));
            let t_min = t_min.as_ref()[lane];
            // SAFETY: the caller's.
            unsafe {
                if INSTANCES {
                    let ray = Ray { origin: o, t_min, direction: d, t_max: best.t };
                    single::trace_instances::<S, QUERY>(bvh, at, &ray, filters[lane], &mut found);
                } else {
                    let world_interval = match &world {
                        Some((near, far)) => (near.as_ref()[lane], far.as_ref()[lane]),
                        None => (f32::NEG_INFINITY, f32::INFINITY),
                    };
                    let place = single::Place { instance: leg.instance, world_interval };
                    let ray = single::SingleRay::new::<S>(o, d, t_min, leg.extent);
                    single::search::<S, QUERY>(bvh, at, &ray, &place, filters[lane], &mut found);
                }
            }
            if QUERY == ANY {
                if found.any {
                    t_max.as_mut()[lane] = f32::NEG_INFINITY;
                }
                continue;
            }
            t_max.as_mut()[lane] = found.best.t;
            u.as_mut()[lane] = found.best.u;
            v.as_mut()[lane] = found.best.v;
            primitive.as_mut()[lane] = f32::from_bits(found.best.id.primitive);
            instance.as_mut()[lane] = f32::from_bits(found.best.id.instance);
        }
        packet.t_max = S::F16::from_array(&t_max);
        packet.u = S::F16::from_array(&u);
        packet.v = S::F16::from_array(&v);
        packet.primitive = S::F16::from_array(&primitive);
        packet.instance = S::F16::from_array(&instance);
    }
}

/// A sphere against the rays, one by one: a function of its own, since it is rare and large.
struct SphereTest<'a, 'b, S: Simd> {
    leg: &'a Leg<'b, S>,
    sphere: &'a Sphere,
    lanes: u32,
}

impl<S: Simd> Kernel for SphereTest<'_, '_, S> {
    type Output = [[f32; 16]; 2];

    #[inline(always)]
    unsafe fn run<X: Simd>(self) -> [[f32; 16]; 2] {
        let leg = self.leg;
        let (origin, direction) = (arrays::<S>(&leg.ray.origin), arrays::<S>(&leg.ray.direction));
        let t_min = leg.ray.t_min.to_array();
        let mut roots = [[f32::NAN; 16]; 2];
        let mut left = self.lanes;
        while left != 0 {
            let lane = left.trailing_zeros() as usize & 15;
            left &= left - 1;
            let (o, d) = (lane_of(&origin, lane), lane_of(&direction, lane));
            let ray = LocalRay::new(o, d, t_min.as_ref()[lane], leg.extent);
            [roots[0][lane], roots[1][lane]] = intersect_sphere(&ray, self.sphere);
        }
        roots
    }
}

type Array16<S> = <<S as Simd>::F16 as Float>::Array;

#[inline(always)]
fn arrays<S: Simd>(v: &Vec3V<S::F16>) -> [Array16<S>; 3] {
    each!(k => v[k].to_array())
}

#[inline(always)]
fn lane_of<A: AsRef<[f32]>>(v: &[A; 3], lane: usize) -> Vec3 {
    vec3(v[0].as_ref()[lane], v[1].as_ref()[lane], v[2].as_ref()[lane])
}
