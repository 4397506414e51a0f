//! The octree, traversed in the parameters of the ray (Revelles, Ureña and Lastra 2000, "An efficient parametric
//! algorithm for octree traversal"), front to back.
//!
//! As in the paper, no box is tested: a node is known by where the ray passes its three middle planes, and those of a
//! child follow by adding a quarter of the node's size. Directions towards lower coordinates are mirrored, which is an
//! exclusive or on octant numbers. The paper finds the first octant and then steps from one to the next through a table;
//! here the octants that the ray passes are found at once, by comparing the three middle planes with each other and with
//! the ends of the interval. Along a ray that goes towards higher coordinates, octants come in the order of their
//! numbers, so there is nothing to sort; and where planes are met at the same time, within rounding, all octants around
//! are visited, where a step from one to the next would have to choose.

use super::packet::Packet;
use super::{MAX_OCTREE_DEPTH, OctreeView};
use crate::hierarchy::candidates::{Placement, PrimitivesView, trusted};
use crate::hierarchy::cell_ray::{CellRay, in_time};
use crate::hierarchy::references::{Mailbox, References};
use crate::hierarchy::search::{Any, Search};
use crate::hierarchy::two_level::SearchScene;
use crate::hierarchy::{ShadowBatch, Stack, Tracer, Work};
use crate::intersect::LocalRay;
use crate::math::{Vec3, fma, max, min, vec3};
use crate::ray::{Hit, Ray, RayFilter};

/// Traverses an [`OctreeView`] front to back, up to the best hit.
#[derive(Clone, Copy, Debug)]
pub struct OctreeParametricTracer<'a, C> {
    /// The tree.
    tree: OctreeView<'a>,
    /// Told what is done: nodes are those entered, inner ones and leaves.
    pub work: C,
}

/// An inner node and its octants still to be visited, in mirrored numbers.
#[derive(Clone, Copy)]
struct Frame {
    node: u32,
    /// Bits 0 to 7: octants. From bit 8: the node's depth.
    octants: u32,
    /// Where the ray passes the middle planes; NaN where that is not known.
    middle: Vec3,
    enter: f32,
    leave: f32,
}

/// Octants in the second half of an axis, as bits.
const SECOND: Axes = Axes { x: 0xF0, y: 0xCC, z: 0xAA };
/// Octants in the first half of an axis, as bits.
const FIRST: Axes = Axes { x: 0x0F, y: 0x33, z: 0x55 };

struct Axes {
    x: u32,
    y: u32,
    z: u32,
}

/// The octants that the ray passes between `enter` and `leave`. `earliest` and `latest` are where it passes the middle
/// planes, before and after rounding. An octant's interval starts at the latest of its planes of entry and ends at the
/// first of its planes of exit, so each pair of planes rules out the octants between them that would be empty. Unknown
/// planes, NaN, rule out nothing.
#[inline(always)]
fn octants_passed(earliest: &Vec3, latest: &Vec3, enter: f32, leave: f32) -> u32 {
    let (n, f) = (earliest, latest);
    let out = |is_out: bool, octants: u32| if is_out { octants } else { 0 };
    let mut none = out(n.x > leave, SECOND.x) | out(f.x < enter, FIRST.x);
    none |= out(n.y > leave, SECOND.y) | out(f.y < enter, FIRST.y);
    none |= out(n.z > leave, SECOND.z) | out(f.z < enter, FIRST.z);
    none |= out(n.x > f.y, SECOND.x & FIRST.y) | out(n.x > f.z, SECOND.x & FIRST.z);
    none |= out(n.y > f.x, SECOND.y & FIRST.x) | out(n.y > f.z, SECOND.y & FIRST.z);
    none |= out(n.z > f.x, SECOND.z & FIRST.x) | out(n.z > f.y, SECOND.z & FIRST.y);
    !none & 0xFF
}

/// Bits of octants, each moved to its mirrored number.
#[inline(always)]
fn mirrored(mut octants: u32, mirror: u32) -> u32 {
    if mirror & 1 != 0 {
        octants = (octants & 0x55) << 1 | (octants & 0xAA) >> 1;
    }
    if mirror & 2 != 0 {
        octants = (octants & 0x33) << 2 | (octants & 0xCC) >> 2;
    }
    if mirror & 4 != 0 {
        octants = (octants & 0x0F) << 4 | (octants & 0xF0) >> 4;
    }
    octants
}

impl<'a, C: Work> OctreeParametricTracer<'a, C> {
    /// Over trees whose numbers hold together.
    ///
    /// # Safety
    /// The view is [closed](crate::hierarchy#closed-views).
    #[inline(always)]
    pub unsafe fn new(tree: OctreeView<'a>, work: C) -> Self {
        OctreeParametricTracer { tree, work }
    }
}

impl<C: Work> SearchScene for OctreeParametricTracer<'_, C> {
    #[inline(always)]
    fn primitives(&self) -> &PrimitivesView<'_> {
        &self.tree.primitives
    }

    #[inline(always)]
    fn search_geometry(
        &self,
        geometry: u32,
        ray: &LocalRay,
        placement: &Placement<'_>,
        filter: &RayFilter,
        search: &mut impl Search,
    ) -> bool {
        let tree = &self.tree;
        let root = trusted(tree.roots, geometry);
        if root.node == crate::material::NONE {
            return false;
        }
        let cells = CellRay::new(ray, &root.bounds);
        let Some((mut enter, mut leave)) = cells.enter(&root.bounds, ray.t_min, search.t_max()) else {
            return false;
        };
        let mirror = cells.backwards();
        let (low, high) = (root.bounds.min, root.bounds.max);
        let center = (low + high) * 0.5;
        let passes_center = |axis: usize| {
            let t = fma(center[axis], cells.inverse[axis], cells.offset[axis]);
            if t.is_finite() & cells.slack[axis].is_finite() { t } else { f32::NAN }
        };
        let mut middle = vec3(passes_center(0), passes_center(1), passes_center(2));
        // From a node's middle planes to those of its children, at depth 0.
        let quarter = ((high - low) * cells.inverse).abs() * 0.25;
        let slack = cells.slack;

        let mut references = References {
            primitives: &tree.primitives,
            references: tree.references,
            ray,
            placement,
            filter,
            work: &self.work,
            mailbox: Some(Mailbox::new()),
        };
        let mut storage = Stack::<Frame, MAX_OCTREE_DEPTH>::storage();
        let mut stack = Stack::new(&mut storage);
        let (mut number, mut depth) = (root.node, 0u32);
        loop {
            let node = trusted(tree.nodes, number);
            self.work.nodes(1);
            // A leaf has nothing left to visit.
            let mut frame = Frame { node: number, octants: 0, middle, enter, leave };
            let (mut earliest, mut latest) = (middle - slack, middle + slack);
            if node.is_inner() {
                let passed = octants_passed(&earliest, &latest, enter, leave);
                frame.octants = passed & mirrored(node.octants_or_count & 0xFF, mirror) | depth << 8;
            } else if references.search(node.first, node.octants_or_count, search) {
                return true;
            }
            // The next octant that the ray enters in time.
            loop {
                if frame.octants & 0xFF == 0 {
                    let Some(above) = stack.pop() else { return false };
                    frame = above;
                    (earliest, latest) = (frame.middle - slack, frame.middle + slack);
                }
                let octant = frame.octants.trailing_zeros();
                frame.octants &= frame.octants - 1;
                let (x, y, z) = (octant & 4 != 0, octant & 2 != 0, octant & 1 != 0);
                // Unknown planes, NaN, change nothing.
                (enter, leave) = (frame.enter, frame.leave);
                (enter, leave) =
                    if x { (max(earliest.x, enter), leave) } else { (enter, min(latest.x, leave)) };
                (enter, leave) =
                    if y { (max(earliest.y, enter), leave) } else { (enter, min(latest.y, leave)) };
                (enter, leave) =
                    if z { (max(earliest.z, enter), leave) } else { (enter, min(latest.z, leave)) };
                if !in_time(enter, search.t_max()) {
                    continue;
                }
                depth = (frame.octants >> 8) + 1;
                // A power of two, so the product is exact.
                let step = quarter * f32::from_bits((128 - depth) << 23);
                let towards = |second: bool, middle: f32, step: f32| {
                    if second { middle + step } else { middle - step }
                };
                middle.x = towards(x, frame.middle.x, step.x);
                middle.y = towards(y, frame.middle.y, step.y);
                middle.z = towards(z, frame.middle.z, step.z);
                number = trusted(tree.nodes, frame.node).child(octant ^ mirror);
                if frame.octants & 0xFF != 0 {
                    // SAFETY: one frame a level of inner nodes, and builders keep trees at most MAX_OCTREE_DEPTH deep.
                    unsafe { stack.push(frame) };
                }
                break;
            }
        }
    }

    #[inline(always)]
    fn search_instances(
        &self,
        world_ray: Option<&LocalRay>,
        ray: &Ray,
        filter: &RayFilter,
        search: &mut impl Search,
    ) -> bool {
        self.tree.instances.search(self, &self.work, world_ray, ray, filter, search)
    }
}

impl<C: Work> OctreeParametricTracer<'_, C> {
    #[inline(always)]
    fn hidden_by_instances(&self, ray: &Ray, filter: &RayFilter) -> bool {
        let mut search = Any::new(ray.t_max, 0.0);
        self.search_instances(None, ray, filter, &mut search);
        search.found
    }
}

impl<C: Work> Tracer for OctreeParametricTracer<'_, C> {
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

    /// Through the world rays go together, unless their numbers are too large or work is counted; through instances one by
    /// one.
    #[inline(always)]
    fn occluded_batch<const W: usize>(
        &self,
        batch: &ShadowBatch<W>,
        filter: &RayFilter,
        active: &[bool; W],
    ) -> [bool; W] {
        if W > 16 {
            return self.occluded_by_sixteens(batch, filter, active);
        }
        let (root, extent) =
            (trusted(self.tree.roots, 0), trusted(self.tree.primitives.geometries, 0).extent);
        let together = (W > 1) & !C::COUNTS & (root.node != crate::material::NONE);
        let mut hidden = [true; W];
        let mut packet = Packet::new(batch, filter);
        let mut goes_along = [false; W];
        for lane in 0..W {
            if active[lane] {
                goes_along[lane] = together && packet.take(lane, &root.bounds, extent);
                if !goes_along[lane] {
                    hidden[lane] = self.occluded(&batch.ray(lane), filter);
                }
            }
        }
        if together {
            let hidden_by_world = packet.search(&self.tree, &root.bounds, root.node);
            let has_instances = self.tree.primitives.instances.len() > 1;
            for lane in 0..W {
                if goes_along[lane] {
                    hidden[lane] = hidden_by_world[lane]
                        || has_instances && self.hidden_by_instances(&batch.ray(lane), filter);
                }
            }
        }
        hidden
    }
}
