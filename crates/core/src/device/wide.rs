//! A hierarchy with eight children a node, their boxes in 8 bits a plane (Ylitie et al. 2017, "Efficient incoherent ray
//! traversal on GPUs through compressed wide BVHs"): 96 bytes for what takes seven pairs of 64.
//!
//! Unlike theirs, a node names each child by a [`Link`], so that leaves may lie anywhere; and what is put aside is the
//! node with the children that are left of it, in the order in which a ray of this octant meets them.

use super::pairs::{Link, Outcome, Root, Space, Target};
use super::warp::Warp;
use crate::hierarchy::candidates::{PrimitivesView, trusted};
use crate::hierarchy::search::Search;
use crate::hierarchy::{MAX_BVH_DEPTH, Stack};
use crate::intersect::Slab;
use crate::math::{Vec3, fma, max, min};
use crate::ray::{Ray, RayFilter};

/// A node of the tree: up to eight children, their boxes in a grid of 8 bits an axis.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C, align(32))]
pub struct WideNode {
    /// The least corner of the grid that boxes are in,
    pub origin: Vec3,
    /// and along each axis the exponent of its step, as floats have it, x in the lowest byte. In the highest one a bit for
    /// each child that there is.
    pub exponents: u32,
    /// For each axis the first planes of the children, then the last ones: bytes, the first child's lowest.
    pub planes: [[[u32; 2]; 2]; 3],
    /// What they lead to. Children stand where rays of most octants meet them in the order of their number xor the octant.
    pub links: [Link; 8],
}

/// The rows of a node that are read when it is visited: all but the links.
struct Boxes {
    origin: Vec3,
    exponents: u32,
    planes: [[[u32; 2]; 2]; 3],
}

impl WideNode {
    /// The most nodes of all trees: their numbers stand beside 8 bits.
    pub const MOST: usize = 1 << 24;

    #[cfg(target_arch = "nvptx64")]
    #[inline(always)]
    fn boxes(&self) -> Boxes {
        let mut rows = [[0u32; 4]; 4];
        let mut k = 0;
        while k < 4 {
            // SAFETY: reads four of the six quarters of what is borrowed; nodes lie in global memory, which nothing changes.
            unsafe {
                let row = (self as *const WideNode).cast::<[u32; 4]>().add(k);
                let (a, b, c, d);
                core::arch::asm!(
                    "ld.global.nc.v4.u32 {{{0}, {1}, {2}, {3}}}, [{4}];",
                    out(reg32) a, out(reg32) b, out(reg32) c, out(reg32) d, in(reg64) row,
                    options(pure, readonly, nostack, preserves_flags)
                );
                rows[k] = [a, b, c, d];
            }
            k += 1;
        }
        let [[x, y, z, exponents], px, py, pz] = rows;
        let planes = |[a, b, c, d]: [u32; 4]| [[a, b], [c, d]];
        Boxes {
            origin: Vec3 { x: f32::from_bits(x), y: f32::from_bits(y), z: f32::from_bits(z) },
            exponents,
            planes: [planes(px), planes(py), planes(pz)],
        }
    }

    #[cfg(not(target_arch = "nvptx64"))]
    #[inline(always)]
    fn boxes(&self) -> Boxes {
        Boxes { origin: self.origin, exponents: self.exponents, planes: self.planes }
    }
}

/// Trees of wide nodes. Each has at least one.
#[derive(Clone, Copy, Debug)]
pub struct WideView<'a> {
    /// Nodes of all trees.
    pub nodes: &'a [WideNode],
    /// For each geometry, the number of its root.
    pub roots: &'a [Root<u32>],
    /// The root of the tree over the instances but the world.
    pub instance_root: u32,
    /// Primitives, in the order of the leaves.
    pub primitives: PrimitivesView<'a>,
}

/// A node a level of two trees, and the ends.
const ROOM: usize = 2 * (MAX_BVH_DEPTH + 8) + 4;

/// StackStorage for a walk's stack.
pub(super) type StackStorage = crate::hierarchy::stack::StackStorage<Rest, ROOM>;

/// What is left of a node: its number above 8 bits, of which those are set whose children are still to be visited. Without
/// any it is one of the ends.
#[derive(Clone, Copy, PartialEq, Eq)]
#[repr(transparent)]
pub(super) struct Rest(u32);

impl Rest {
    /// The end.
    const DONE: Rest = Rest(0);
    /// The world begins again.
    const WORLD: Rest = Rest(1 << 8);
    /// The tree over the instances.
    const INSTANCES: Rest = Rest(2 << 8);
    /// The world's tree.
    const ROOT: Rest = Rest(3 << 8);

    #[inline(always)]
    fn is_empty(self) -> bool {
        self.0 & 255 == 0
    }

    /// Takes the first child off.
    #[inline(always)]
    fn next(&mut self, octant: u32) -> (u32, usize) {
        let place = self.0.trailing_zeros();
        self.0 &= self.0 - 1;
        (self.0 >> 8, ((place ^ octant) & 7) as usize)
    }
}

/// A walk through the world and, with `PLACED`, through what instances place in it. With `ANYWHERE` for rays that start
/// anywhere.
pub(super) struct Walk<'a, 's, const ANYWHERE: bool, const PLACED: bool> {
    space: Space<'a>,
    /// The signs of the ray's direction.
    octant: u32,
    rest: Rest,
    stack: Stack<'s, Rest, ROOM>,
}

impl<'a, 's, const ANYWHERE: bool, const PLACED: bool> Walk<'a, 's, ANYWHERE, PLACED> {
    /// At the beginning.
    #[inline(always)]
    pub(super) fn new(view: &WideView, world_ray: &'a Ray, storage: &'s mut StackStorage) -> Self {
        let mut stack = Stack::new(storage);
        // SAFETY: closed views: the depth of trees fits the stack, whose bound counts these marks.
        unsafe {
            stack.push(Rest::DONE);
            if PLACED {
                stack.push(Rest::INSTANCES);
            }
            stack.push(Rest::ROOT);
        }
        let space = Space::world(&view.primitives, trusted(view.roots, 0).reach, world_ray);
        let octant = space.octant();
        Walk { space, octant, rest: Rest::DONE, stack }
    }

    /// Visits the leaves that the ray enters. With `IN_STEP` the threads of a warp wait for each other after every node and
    /// leaf: where they do not, they drift apart and seldom meet again.
    #[inline(always)]
    pub(super) fn run<const IN_STEP: bool>(
        &mut self,
        view: &WideView,
        filter: &RayFilter,
        search: &mut impl Search,
        warp: Warp,
    ) -> Outcome {
        let mut outcome = None;
        // Numbers out of range: such a ray hits nothing.
        if self.space.ray.t_min.is_nan() {
            outcome = Some(Outcome::Over);
        } else if self.is_far() {
            outcome = Some(Outcome::Far);
        }
        loop {
            if outcome.is_none() {
                outcome = self.step(view, filter, search);
            }
            let goes_on = if IN_STEP { warp.count(outcome.is_none()) > 0 } else { outcome.is_none() };
            if !goes_on {
                return outcome.unwrap_or(Outcome::Over);
            }
        }
    }

    #[inline(always)]
    fn is_far(&self) -> bool {
        !ANYWHERE && self.space.slack > 0.0
    }

    /// To the next child. Where that ends the walk, how.
    #[inline(always)]
    fn step(&mut self, view: &WideView, filter: &RayFilter, search: &mut impl Search) -> Option<Outcome> {
        if self.rest.is_empty() {
            // SAFETY: below everything lies the end, after which nothing is taken.
            self.rest = unsafe { self.stack.pop_unchecked() };
        }
        let node = if self.rest.is_empty() {
            if self.rest == Rest::DONE {
                return Some(Outcome::Over);
            }
            self.turn(view)
        } else {
            let (node, place) = self.rest.next(self.octant);
            match trusted(view.nodes, node).links[place].target() {
                Target::Node(node) => Some(node),
                Target::Instance(instance) if PLACED => self.enter(view, instance, search.t_max()),
                leaf => {
                    if self.search_leaf(view, leaf, filter, search) {
                        return Some(Outcome::Over);
                    }
                    None
                }
            }
        };
        if let Some(node) = node {
            // In the space of an instance, that may be so.
            if PLACED && self.is_far() {
                return Some(Outcome::Far);
            }
            self.visit(view, node, search.t_max());
        }
        None
    }

    /// Whether that ends the walk.
    #[inline(always)]
    fn search_leaf(
        &self,
        view: &WideView,
        leaf: Target,
        filter: &RayFilter,
        search: &mut impl Search,
    ) -> bool {
        let Space { placement, ray, .. } = &self.space;
        match leaf {
            Target::Triangles(first, count) => {
                view.primitives.search_triangles(first, count, ray, placement, filter, search)
            }
            Target::Sphere(sphere) => view.primitives.search_spheres(sphere, 1, ray, placement, search),
            _ => false,
        }
    }

    /// At the beginning of a tree, whose root it gives, or where the world begins again.
    #[inline(always)]
    fn turn(&mut self, view: &WideView) -> Option<u32> {
        match self.rest {
            Rest::ROOT => Some(trusted(view.roots, 0).first),
            Rest::INSTANCES => Some(view.instance_root),
            _ => {
                self.go_on_in(Space::world(
                    &view.primitives,
                    trusted(view.roots, 0).reach,
                    self.space.placement.world_ray,
                ));
                self.rest = Rest::DONE;
                None
            }
        }
    }

    /// Goes into an instance, if the ray meets its box. Gives its root.
    #[inline(always)]
    fn enter(&mut self, view: &WideView, number: u32, t_max: f32) -> Option<u32> {
        let world_ray = self.space.placement.world_ray;
        let slab = view.primitives.world_slab(world_ray);
        let (placement, ray) =
            view.primitives.enter_instance(number, world_ray, &slab, [world_ray.t_min, t_max])?;
        let geometry = trusted(view.primitives.instances, number).geometry;
        // SAFETY: closed views: the depth of trees fits the stack, whose bound counts these marks.
        unsafe {
            if !self.rest.is_empty() {
                self.stack.push(self.rest);
            }
            self.stack.push(Rest::WORLD);
        }
        self.rest = Rest::DONE;
        let root = trusted(view.roots, geometry);
        self.go_on_in(Space::new(placement, ray, root.reach));
        Some(root.first)
    }

    #[inline(always)]
    fn go_on_in(&mut self, space: Space<'a>) {
        self.octant = space.octant();
        self.space = space;
    }

    /// Puts aside what is left, and finds out which children of a node the ray enters. A child is left out only when the ray
    /// enters it beyond the best hit, never at equality: there a tie may wait.
    #[inline(always)]
    fn visit(&mut self, view: &WideView, number: u32, t_max: f32) {
        if !self.rest.is_empty() {
            // SAFETY: a walk puts aside one node a level, and no tree has more than MAX_BVH_DEPTH of them. The world's tree is
            // done with before the two others begin.
            unsafe { self.stack.push(self.rest) };
        }
        let node = trusted(view.nodes, number).boxes();
        let (i, o, e) = (self.space.ray.slab.inverse, self.space.offset, node.exponents);
        // A step along the axis, and the grid's corner, in the ray's measure.
        let step = |shift: u32, inverse: f32| f32::from_bits((e >> shift & 255) << 23) * inverse;
        let steps = [step(0, i.x), step(8, i.y), step(16, i.z)];
        let corner =
            [fma(node.origin.x, i.x, o.x), fma(node.origin.y, i.y, o.y), fma(node.origin.z, i.z, o.z)];
        let s = self.space.steps;
        let slack = if ANYWHERE { [s.x, s.y, s.z].map(|s| s * self.space.slack) } else { [0.0; 3] };
        // Which planes are met first.
        let turned = |axis: usize, inverse: f32| {
            let [low, high] = node.planes[axis];
            if inverse < 0.0 { [high, low] } else { [low, high] }
        };
        let planes = [turned(0, i.x), turned(1, i.y), turned(2, i.z)];
        let mut entered = 0;
        let mut k = 0;
        while k < 8 {
            let at = |axis: usize, side: usize| {
                let byte = planes[axis][side][k / 4] >> (8 * (k % 4)) & 255;
                let t = fma(byte as f32, steps[axis], corner[axis]);
                match (ANYWHERE, side) {
                    (false, _) => t,
                    (true, 0) => t - slack[axis],
                    (true, _) => t + slack[axis],
                }
            };
            let near = max(max(at(0, 0), at(1, 0)), max(at(2, 0), self.space.ray.t_min));
            let far = min(min(at(0, 1), at(1, 1)), at(2, 1));
            entered |= (Slab::passes(near, far, t_max) as u32) << (k as u32 ^ self.octant);
            k += 1;
        }
        // Those that there are, in the order of the octant.
        let mut there = e >> 24;
        let swap = |bits: u32, by: u32, mask: u32| (bits & mask) << by | bits >> by & mask;
        there = if self.octant & 1 != 0 { swap(there, 1, 0x55) } else { there };
        there = if self.octant & 2 != 0 { swap(there, 2, 0x33) } else { there };
        there = if self.octant & 4 != 0 { swap(there, 4, 0x0f) } else { there };
        self.rest = Rest(number << 8 | entered & there);
    }
}
