//! Shadow rays of one origin, together through an octree: nodes and triangles are read once for all of them.
//!
//! Cells are found as in `parametric.rs`: no box is tested, an octant's interval is its parent's, cut where the ray passes
//! the middle planes. Octants come in any order, since any hit will do. A step is a short loop over arrays, free of
//! branches, which compilers turn into SIMD code. A cell is visited if any ray passes it, and what it holds is tested for
//! all rays: a hit does not depend on the cell in which it was found, so this changes no answer.

use super::{MAX_OCTREE_DEPTH, OctreeNode, OctreeView};
use crate::geometry::Bounds;
use crate::hierarchy::candidates::{Placement, trusted};
use crate::hierarchy::cell_ray::{CellRay, in_time};
use crate::hierarchy::references::{Mailbox, SPHERE_REFERENCE};
use crate::hierarchy::search::Any;
use crate::hierarchy::{ShadowBatch, Stack};
use crate::intersect::{LocalRay, PackedTriangle};
use crate::math::{Vec3, fma, max, min, vec3};
use crate::ray::{PrimitiveId, Ray, RayFilter};

/// A number of each ray.
type Lanes<const W: usize> = [f32; W];

/// Rays on their way. Those that are not, or not any more, have a `t_max` below everything.
pub(super) struct Packet<'a, const W: usize> {
    rays: &'a ShadowBatch<W>,
    filter: &'a RayFilter,
    local: [LocalRay; W],
    /// One over the direction along each axis.
    inverse: [Lanes<W>; 3],
    /// Of each axis, the lower and the upper half of a cell.
    halves: [[Half<W>; 2]; 3],
    length: Lanes<W>,
    t_max: Lanes<W>,
    /// The interval of each ray within the root.
    enter: Lanes<W>,
    leave: Lanes<W>,
    hidden: [bool; W],
}

/// One side of the middle planes across an axis: what [`CellRay`] holds for the plane, if a ray enters there, and if it
/// leaves; infinite otherwise.
#[derive(Clone, Copy)]
struct Half<const W: usize> {
    near_offset: Lanes<W>,
    far_offset: Lanes<W>,
}

impl<const W: usize> Half<W> {
    #[inline(always)]
    fn set(&mut self, lane: usize, near_offset: f32, far_offset: f32) {
        (self.near_offset[lane], self.far_offset[lane]) = (near_offset, far_offset);
    }

    /// What of an interval is on this side. Unknown planes, NaN, change nothing.
    #[inline(always)]
    fn cut(&self, enter: f32, leave: f32, plane: f32, inverse: f32, lane: usize) -> (f32, f32) {
        let (near, far) =
            (fma(plane, inverse, self.near_offset[lane]), fma(plane, inverse, self.far_offset[lane]));
        (max(near, enter), min(far, leave))
    }
}

/// An inner node and its octants still to be visited, as bits.
#[derive(Clone, Copy)]
struct Frame<const W: usize> {
    node: u32,
    octants: u32,
    center: Vec3,
    quarter: Vec3,
    /// The interval of each ray within the cell; empty where it does not pass.
    enter: Lanes<W>,
    leave: Lanes<W>,
}

impl<const W: usize> Frame<W> {
    /// Centre of an octant's cell.
    #[inline(always)]
    fn center_of(&self, octant: u32) -> Vec3 {
        let step = |bit: u32, quarter: f32| if octant & bit != 0 { quarter } else { -quarter };
        self.center + vec3(step(4, self.quarter.x), step(2, self.quarter.y), step(1, self.quarter.z))
    }
}

impl<'a, const W: usize> Packet<'a, W> {
    /// No rays yet.
    #[inline(always)]
    pub(super) fn new(rays: &'a ShadowBatch<W>, filter: &'a RayFilter) -> Self {
        let (none, nowhere) = ([0.0; W], LocalRay::new(&Ray::new(Vec3::ZERO, Vec3::ZERO), 0.0));
        Packet {
            rays,
            filter,
            local: [nowhere; W],
            inverse: [none; 3],
            halves: [[Half { near_offset: none, far_offset: none }; 2]; 3],
            length: none,
            t_max: [f32::NEG_INFINITY; W],
            enter: [f32::INFINITY; W],
            leave: [f32::NEG_INFINITY; W],
            hidden: [false; W],
        }
    }

    /// Takes a ray along. `false` where its numbers are too large for cells: it has to go alone.
    #[inline(always)]
    pub(super) fn take(&mut self, lane: usize, bounds: &Bounds, extent: f32) -> bool {
        let ray = self.rays.ray(lane);
        let local = LocalRay::new(&ray, extent);
        let cells = CellRay::new(&local, bounds);
        if !cells.slack.is_finite() | local.t_min.is_nan() {
            return false;
        }
        let Some((enter, leave)) = cells.enter(bounds, local.t_min, ray.t_max) else { return true };
        for axis in 0..3 {
            self.inverse[axis][lane] = cells.inverse[axis];
            let is_backwards = cells.inverse[axis] < 0.0;
            let [first, second] = [is_backwards as usize, !is_backwards as usize];
            // What a plane at 0 is to it.
            let (near, far) = (cells.earliest(axis, 0.0), cells.latest(axis, 0.0));
            self.halves[axis][first].set(lane, f32::NEG_INFINITY, far);
            self.halves[axis][second].set(lane, near, f32::INFINITY);
        }
        self.local[lane] = local;
        self.length[lane] = local.length;
        (self.t_max[lane], self.enter[lane], self.leave[lane]) = (ray.t_max, enter, leave);
        true
    }

    /// Which rays something is in the way of.
    #[inline(always)]
    pub(super) fn search(mut self, tree: &OctreeView, bounds: &Bounds, root: u32) -> [bool; W] {
        let half = (bounds.max - bounds.min) * 0.5;
        let mut mailbox = Mailbox::new();
        let mut storage = Stack::<Frame<W>, MAX_OCTREE_DEPTH>::storage();
        let mut stack = Stack::new(&mut storage);
        let (mut number, mut center, mut quarter) = (root, bounds.min + half, half * 0.5);
        let (mut enter, mut leave) = (self.enter, self.leave);
        loop {
            let node = trusted(tree.nodes, number);
            if node.is_inner() {
                let octants = node.octants_or_count & 0xFF;
                // SAFETY: one frame a level of inner nodes, and builders keep trees at most MAX_OCTREE_DEPTH deep.
                unsafe { stack.push(Frame { node: number, octants, center, quarter, enter, leave }) };
            } else {
                self.search_leaf(tree, node, &mut mailbox);
            }
            // The next octant that a ray passes in time.
            loop {
                let Some(frame) = stack.top_mut() else { return self.hidden };
                if frame.octants == 0 {
                    stack.pop();
                    continue;
                }
                let octant = frame.octants.trailing_zeros();
                frame.octants &= frame.octants - 1;
                let any;
                (enter, leave, any) = self.within(frame, octant);
                if any {
                    (center, quarter) = (frame.center_of(octant), frame.quarter * 0.5);
                    number = trusted(tree.nodes, frame.node).child(octant);
                    break;
                }
            }
        }
    }

    /// The rays' intervals within an octant, and whether any ray passes it in time.
    #[inline(always)]
    fn within(&self, frame: &Frame<W>, octant: u32) -> (Lanes<W>, Lanes<W>, bool) {
        let half = |axis: usize| &self.halves[axis][(octant & (4 >> axis) != 0) as usize];
        let (x, y, z) = (half(0), half(1), half(2));
        let (mut enter, mut leave, mut any) = ([0.0; W], [0.0; W], false);
        for lane in 0..W {
            let (mut e, mut l) = (frame.enter[lane], frame.leave[lane]);
            (e, l) = x.cut(e, l, frame.center.x, self.inverse[0][lane], lane);
            (e, l) = y.cut(e, l, frame.center.y, self.inverse[1][lane], lane);
            (e, l) = z.cut(e, l, frame.center.z, self.inverse[2][lane], lane);
            (enter[lane], leave[lane]) = (e, l);
            any |= (e <= l) & in_time(e, self.t_max[lane]);
        }
        (enter, leave, any)
    }

    /// Tests what a leaf holds, for all rays that are on their way.
    #[inline(always)]
    fn search_leaf(&mut self, tree: &OctreeView, leaf: &OctreeNode, mailbox: &mut Mailbox) {
        let mut k = leaf.first;
        while k < leaf.first + leaf.octants_or_count {
            let reference = *trusted(tree.references, k);
            k += 1;
            if mailbox.has(reference) {
                continue;
            }
            let candidates = if reference & SPHERE_REFERENCE != 0 {
                self.on_their_way()
            } else {
                let triangle = trusted(tree.primitives.triangles, reference);
                if self.filter.skips(PrimitiveId { instance: 0, primitive: triangle.primitive }) {
                    continue;
                }
                self.candidates(triangle)
            };
            if candidates == [false; W] {
                continue;
            }
            for lane in 0..W {
                if candidates[lane] {
                    self.test(tree, reference, lane);
                }
            }
        }
    }

    /// The rays that are still to be answered.
    #[inline(always)]
    fn on_their_way(&self) -> [bool; W] {
        self.t_max.map(|t_max| t_max > f32::NEG_INFINITY)
    }

    /// Those among them that pass the first step of the triangle test.
    #[inline(always)]
    fn candidates(&self, triangle: &PackedTriangle) -> [bool; W] {
        let mut candidates = self.on_their_way();
        for lane in 0..W {
            let direction = vec3(self.rays.x[lane], self.rays.y[lane], self.rays.z[lane]);
            let length = self.length[lane];
            // The first step reads no more of the ray than this.
            let ray = LocalRay { origin: self.rays.origin, direction, length, ..self.local[0] };
            let step = triangle.first_step(&ray);
            candidates[lane] &= step.may_meet & !(self.filter.cull_back_faces & !step.meets_front);
        }
        candidates
    }

    /// Tests a primitive for one ray, which ends there if it is hit.
    #[inline(always)]
    fn test(&mut self, tree: &OctreeView, reference: u32, lane: usize) {
        let world_ray = self.rays.ray(lane);
        let (p, ray, world) = (&tree.primitives, &self.local[lane], &Placement::world(&world_ray));
        let mut search = Any::new(self.t_max[lane], 0.0);
        if reference & SPHERE_REFERENCE == 0 {
            p.search_triangles(reference, 1, ray, world, self.filter, &mut search);
        } else {
            p.search_spheres(reference & !SPHERE_REFERENCE, 1, ray, world, &mut search);
        }
        if search.found {
            self.hidden[lane] = true;
            self.t_max[lane] = f32::NEG_INFINITY;
        }
    }
}
