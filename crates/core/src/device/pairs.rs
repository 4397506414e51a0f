//! The hierarchy as GPUs read it: the boxes of two children in one node of 64 bytes (Aila and Laine 2009), instances and
//! primitives by links of 32 bits.
//!
//! A box is its centre and half its size, so that its entry and its exit are one fused multiply-add each, without telling
//! near planes from far ones. It is larger than the node's by what rounding can bring about for rays that start within
//! [`Root::reach`]; for others `Space::slack` is added as they go, and those from far away start from the box of the tree.
//!
//! What is not certain in single precision would need a function that every walk keeps registers for. So it is put aside
//! (`deferred.rs`) until the walk is over.

use super::warp::Warp;
use crate::geometry::Bounds;
use crate::hierarchy::candidates::{Placement, PrimitivesView, trusted};
use crate::hierarchy::far::FarRay;
use crate::hierarchy::moved::Moved;
use crate::hierarchy::search::Search;
use crate::hierarchy::{MAX_BVH_DEPTH, Stack};
use crate::intersect::{LocalRay, Slab, sphere_bounds};
use crate::math::{Vec3, fma, max, min};
use crate::ray::{Ray, RayFilter};

/// What boxes are padded by, over the coordinates of the box and of the ray's origin: more than the rounding errors of the
/// test, which are some 5 times 2^-24 of that.
pub const PAIR_SLACK: f32 = 1.0 / 1_048_576.0;

/// Two children.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C, align(64))]
pub struct BvhPair {
    /// Middle of the first one's box,
    pub center0: Vec3,
    /// and what it leads to.
    pub link0: Link,
    /// Half the size of its box.
    pub half0: Vec3,
    /// Nothing.
    pub unused: [u32; 2],
    /// Middle of the second one's box.
    pub center1: Vec3,
    /// Half the size of its box,
    pub half1: Vec3,
    /// and what it leads to.
    pub link1: Link,
}

impl BvhPair {
    /// All of it. (Where only a link is needed in the end, GPUs would read that when it is needed, which is late.)
    #[cfg(target_arch = "nvptx64")]
    #[inline(always)]
    fn read(&self) -> BvhPair {
        let mut rows = [[0u32; 4]; 4];
        let mut k = 0;
        while k < 4 {
            // SAFETY: reads a quarter of what is borrowed; pairs lie in global memory, which nothing changes.
            unsafe {
                let row = (self as *const BvhPair).cast::<[u32; 4]>().add(k);
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
        // SAFETY: a pair is four rows of plain numbers.
        unsafe { core::mem::transmute::<[[u32; 4]; 4], BvhPair>(rows) }
    }

    /// All of it.
    #[cfg(not(target_arch = "nvptx64"))]
    #[inline(always)]
    fn read(&self) -> BvhPair {
        *self
    }
}

/// What a child is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(transparent)]
pub struct Link(u32);

/// Set in links to anything but pairs.
const NO_PAIR: u32 = 1 << 31;
/// Set in links to anything but pairs and triangles.
const SPECIAL: u32 = 0b11 << 30;
const SPHERE: u32 = SPECIAL;
const INSTANCE: u32 = SPECIAL | 0b01 << 28;
const NUMBER: u32 = (1 << 28) - 1;
/// The number of the first triangle; above it, how many less one.
const TRIANGLE: u32 = (1 << 27) - 1;

impl Link {
    /// Nothing.
    pub const NOTHING: Link = Link(SPECIAL | 0b10 << 28);
    /// The world begins again.
    const WORLD: Link = Link(SPECIAL | 0b10 << 28 | 1);
    /// The end.
    const DONE: Link = Link(SPECIAL | 0b11 << 28);

    /// The most triangles of a leaf.
    pub const MOST_TRIANGLES: u32 = 8;
    /// Numbers of triangles are below this.
    pub const TRIANGLES_END: u32 = 1 << 27;
    /// Numbers of spheres and instances are below this.
    pub const NUMBERS_END: u32 = 1 << 28;

    /// To a pair, by its number.
    pub fn pair(number: u32) -> Link {
        debug_assert!(number < NO_PAIR);
        Link(number)
    }

    /// To triangles.
    pub fn triangles(first: u32, count: u32) -> Link {
        debug_assert!(first < Link::TRIANGLES_END && (1..=Link::MOST_TRIANGLES).contains(&count));
        Link(NO_PAIR | (count - 1) << 27 | first)
    }

    /// To a sphere.
    pub fn sphere(number: u32) -> Link {
        debug_assert!(number < Link::NUMBERS_END);
        Link(SPHERE | number)
    }

    /// To an instance.
    pub fn instance(number: u32) -> Link {
        debug_assert!(number < Link::NUMBERS_END);
        Link(INSTANCE | number)
    }

    /// As kernels take it.
    pub fn bits(self) -> u32 {
        self.0
    }

    #[inline(always)]
    fn is_pair(self) -> bool {
        self.0 & NO_PAIR == 0
    }

    #[inline(always)]
    fn is_sphere(self) -> bool {
        self.0 & !NUMBER == SPHERE
    }

    /// Of a link to triangles, the first one and how many.
    #[inline(always)]
    fn range(self) -> (u32, u32) {
        (self.0 & TRIANGLE, (self.0 >> 27 & 7) + 1)
    }

    #[inline(always)]
    fn is_triangles(self) -> bool {
        self.0 & SPECIAL == NO_PAIR
    }

    /// What it leads to.
    #[inline(always)]
    pub fn target(self) -> Target {
        if self.is_pair() {
            return Target::Node(self.0);
        }
        if self.is_triangles() {
            let (first, count) = self.range();
            return Target::Triangles(first, count);
        }
        match self.0 & !NUMBER {
            SPHERE => Target::Sphere(self.0 & NUMBER),
            INSTANCE => Target::Instance(self.0 & NUMBER),
            _ => Target::Nothing,
        }
    }
}

/// What a [`Link`] leads to, by its number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Target {
    /// A node.
    Node(u32),
    /// Triangles: the first one, and how many.
    Triangles(u32, u32),
    /// A sphere.
    Sphere(u32),
    /// An instance.
    Instance(u32),
    /// Nothing.
    Nothing,
}

/// A geometry's tree, by what it begins with: a link or a node's number.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C)]
pub struct Root<N> {
    /// What it begins with.
    pub first: N,
    /// Its boxes are large enough for rays that start within this of 0 along each axis. No larger than most of what is
    /// inside needs, so that boxes there are not swollen by what lies far away.
    pub reach: f32,
}

/// Trees of pairs.
#[derive(Clone, Copy, Debug)]
pub struct PairView<'a> {
    /// Pairs of all trees.
    pub pairs: &'a [BvhPair],
    /// For each geometry, its tree.
    pub roots: &'a [Root<Link>],
    /// The tree over the instances but the world, with boxes for the same rays as the world's tree.
    pub instance_root: Link,
    /// How threads of a warp walk.
    pub warp_mode: WarpMode,
    /// Primitives, in the order of the leaves.
    pub primitives: PrimitivesView<'a>,
}

impl PairView<'_> {
    /// The box around what a link leads to.
    fn bounds_of(&self, link: Link) -> Bounds {
        let around = |center: Vec3, half: Vec3| Bounds { min: center - half, max: center + half };
        match link.target() {
            Target::Node(number) => {
                let pair = trusted(self.pairs, number);
                around(pair.center0, pair.half0).union(&around(pair.center1, pair.half1))
            }
            Target::Triangles(first, count) => {
                let mut bounds = Bounds::EMPTY;
                let mut k = first;
                while k < first + count {
                    bounds = bounds.union(&trusted(self.primitives.triangles, k).bounds());
                    k += 1;
                }
                bounds
            }
            Target::Sphere(number) => sphere_bounds(trusted(self.primitives.spheres, number)),
            Target::Instance(number) => trusted(self.primitives.instances, number).world_bounds,
            Target::Nothing => Bounds::EMPTY,
        }
    }
}

/// Whether the threads of a warp walk through the tree together, each for its own ray. It changes no hit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(transparent)]
pub struct WarpMode(u32);

impl WarpMode {
    /// Together where their rays start in one point and go the same way along every axis.
    pub const AUTO: WarpMode = WarpMode(0);
    /// Each thread for itself.
    pub const INDEPENDENT: WarpMode = WarpMode(1);
    /// All of a warp go where any of them has to, by vote (EOS's algorithm). Instances are entered alone.
    pub const VOTING: WarpMode = WarpMode(2);

    /// As kernels take it.
    pub fn bits(self) -> u32 {
        self.0
    }
}

/// From this many extents of a box on, an origin is well outside.
const OUTSIDE: f32 = 2.0;

/// A link a level of two trees, whose leaves may have been split further, and the ends.
const ROOM: usize = 2 * (MAX_BVH_DEPTH + 8) + 4;

/// The ray as a walk goes on with it.
pub(super) struct Space<'a> {
    pub(super) placement: Placement<'a>,
    pub(super) ray: LocalRay,
    /// Minus the origin over the direction.
    pub(super) offset: Vec3,
    /// The sizes of the inverse direction's components.
    pub(super) steps: Vec3,
    /// What halves of boxes are too small by.
    pub(super) slack: f32,
    /// The point that the walk measures from, as a `t` of the world ray.
    pub(super) from: f64,
}

impl<'a> Space<'a> {
    #[inline(always)]
    pub(super) fn new(placement: Placement<'a>, ray: LocalRay, reach: f32) -> Space<'a> {
        let inverse = ray.slab.inverse;
        let largest = ray.origin.abs().max_component();
        let slack = if largest <= reach { 0.0 } else { PAIR_SLACK * largest };
        Space { placement, ray, offset: -(ray.origin * inverse), steps: inverse.abs(), slack, from: 0.0 }
    }

    #[inline(always)]
    pub(super) fn world(primitives: &PrimitivesView, reach: f32, world_ray: &'a Ray) -> Space<'a> {
        let ray = LocalRay::of(world_ray, None, trusted(primitives.geometries, 0).extent);
        Space::new(Placement::world(world_ray), ray, reach)
    }

    /// The same from where the ray enters a box, if it starts well outside it and beyond the reach; `None` where it passes it by.
    /// `far_ray` is told the box.
    #[inline(always)]
    pub(super) fn seen_from_box(
        self,
        bounds: &Bounds,
        reach: f32,
        far_ray: impl FnOnce(&Ray, &Bounds) -> Option<FarRay>,
    ) -> Option<Space<'a>> {
        // With numbers out of range, in this space perhaps alone: nothing is hit there.
        if self.ray.t_min.is_nan() {
            return None;
        }
        let (largest, extent) = (self.ray.origin.abs().max_component(), bounds.extent());
        if !((largest > OUTSIDE * extent) & (extent > 0.0) & (largest > reach)) {
            return Some(self);
        }
        let FarRay { ray, from, slack } = far_ray(self.placement.world_ray, bounds)?;
        let space = Space::new(self.placement, ray, reach);
        Some(Space { from, slack: space.slack + slack, ..space })
    }

    /// The signs of the direction, x lowest.
    #[inline(always)]
    pub(super) fn octant(&self) -> u32 {
        let i = self.ray.slab.inverse;
        let sign = |x: f32, bit: u32| (x.to_bits() >> 31) << bit;
        sign(i.x, 0) | sign(i.y, 1) | sign(i.z, 2)
    }

    /// Where the ray enters and leaves a box.
    #[inline(always)]
    fn interval(&self, center: Vec3, half: Vec3) -> (f32, f32) {
        let (i, o, s) = (self.ray.slab.inverse, self.offset, self.steps);
        let (x, y, z) = (fma(center.x, i.x, o.x), fma(center.y, i.y, o.y), fma(center.z, i.z, o.z));
        let (h, t_min) = (half, self.ray.t_min);
        let near = max(max(fma(-h.x, s.x, x), fma(-h.y, s.y, y)), max(fma(-h.z, s.z, z), t_min));
        let far = min(min(fma(h.x, s.x, x), fma(h.y, s.y, y)), fma(h.z, s.z, z));
        (near, far)
    }
}

/// The same number, which is not looked up again where registers are scarce: the compiler of GPUs puts what leaves need into
/// memory, and would read it from there at every node. (Adding 0 is no identity: it changes -0, where that makes no difference.)
#[inline(always)]
fn in_register(t: f32) -> f32 {
    t + 0.0
}

/// Which children of a pair a ray enters, and where.
struct Crossing {
    enters0: bool,
    enters1: bool,
    near0: f32,
    near1: f32,
}

/// Where a walk keeps its stack.
pub(super) type StackStorage = crate::hierarchy::stack::StackStorage<Link, ROOM>;

/// How a walk came to its end.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Outcome {
    /// Everything was searched, or the search had enough.
    Over,
    /// The ray starts too far away for the boxes as they are: it takes a walk for rays from anywhere.
    Far,
}

/// A walk through the world and, with `PLACED`, through what instances place in it. With `ANYWHERE` for rays that start
/// anywhere.
pub(super) struct Walk<'a, 's, const ANYWHERE: bool, const PLACED: bool> {
    space: Space<'a>,
    /// The point that the search measures from, as a `t` of the world ray.
    from: f64,
    next: Link,
    stack: Stack<'s, Link, ROOM>,
}

impl<'a, 's, const ANYWHERE: bool, const PLACED: bool> Walk<'a, 's, ANYWHERE, PLACED> {
    /// At the beginning.
    #[inline(always)]
    pub(super) fn new(view: &PairView, world_ray: &'a Ray, storage: &'s mut StackStorage) -> Self {
        let mut stack = Stack::new(storage);
        // SAFETY: closed views: the depth of trees fits the stack, whose bound counts these marks.
        unsafe {
            stack.push(Link::DONE);
            if PLACED {
                stack.push(view.instance_root);
            }
        }
        let root = trusted(view.roots, 0);
        let space = Space::world(&view.primitives, root.reach, world_ray);
        let mut walk = Walk { space, from: 0.0, next: root.first, stack };
        if ANYWHERE {
            match walk.world_from_box(view) {
                Some(space) => (walk.from, walk.space) = (space.from, space),
                // Past everything: nothing to search.
                None => walk.space.ray.t_min = f32::NAN,
            }
        }
        walk
    }

    /// The point that the search must measure from, as a `t` of the world ray.
    #[inline(always)]
    pub(super) fn from(&self) -> f64 {
        self.from
    }

    /// The world, from where the ray enters what is there.
    #[inline(always)]
    fn world_from_box(&self, view: &PairView) -> Option<Space<'a>> {
        let root = trusted(view.roots, 0);
        let space = Space::world(&view.primitives, root.reach, self.space.placement.world_ray);
        if space.ray.t_min.is_nan() {
            return None;
        }
        let mut bounds = view.bounds_of(root.first);
        if PLACED {
            bounds = bounds.union(&view.bounds_of(view.instance_root));
        }
        space.seen_from_box(&bounds, root.reach, |ray, bounds| {
            let to_instances = PLACED && view.primitives.instances.len() > 1;
            if to_instances { FarRay::to_instances(ray, bounds) } else { FarRay::new(ray, None, bounds) }
        })
    }

    /// The search, from where the space that the walk is in measures.
    #[inline(always)]
    fn moved<'m, S: Search>(&self, search: &'m mut S) -> Moved<'m, S> {
        let from = self.space.from;
        // Only instances are looked at from elsewhere than the world.
        Moved::on(search, if PLACED { from - self.from } else { 0.0 }, from.abs())
    }

    /// [`Search::t_max`], from where the space that the walk is in measures.
    #[inline(always)]
    fn t_max<S: Search>(&self, search: &mut S) -> f32 {
        if ANYWHERE { self.moved(search).t_max() } else { search.t_max() }
    }

    /// Searches a leaf of triangles; `true` ends the search.
    #[inline(always)]
    fn search_triangles<S: Search>(&self, view: &PairView, filter: &RayFilter, search: &mut S) -> bool {
        let (first, count) = self.next.range();
        let (primitives, Space { placement, ray, .. }) = (&view.primitives, &self.space);
        if ANYWHERE {
            let mut search = self.moved(search);
            primitives.search_triangles(first, count, ray, placement, filter, &mut search)
        } else {
            primitives.search_triangles(first, count, ray, placement, filter, search)
        }
    }

    /// Searches a leaf of one sphere; `true` ends the search.
    #[inline(always)]
    fn search_sphere(&self, view: &PairView, search: &mut impl Search) -> bool {
        let Space { placement, ray, .. } = &self.space;
        view.primitives.search_spheres(self.next.0 & NUMBER, 1, ray, placement, search)
    }

    /// Visits the leaves that the ray enters, the nearer child first. A node is left out only when the ray enters it
    /// beyond the best hit, never at equality: there a tie may wait.
    ///
    /// Inner nodes are passed in a loop of their own ("while-while" in Aila and Laine 2009), so that threads of a warp meet
    /// again at leaves.
    #[inline(always)]
    pub(super) fn run(&mut self, view: &PairView, filter: &RayFilter, search: &mut impl Search) -> Outcome {
        // Numbers out of range: such a ray hits nothing.
        if self.space.ray.t_min.is_nan() {
            return Outcome::Over;
        }
        if !ANYWHERE && self.space.slack > 0.0 {
            return Outcome::Far;
        }
        loop {
            let t_max = in_register(self.t_max(search));
            while self.next.is_pair() {
                self.pass(&trusted(view.pairs, self.next.0).read(), t_max);
            }
            if self.next.is_triangles() {
                if self.search_triangles(view, filter, search) {
                    return Outcome::Over;
                }
            } else if let Some(outcome) = self.enter(view, search) {
                return outcome;
            }
            if !self.next.is_pair() {
                self.next = self.pop();
            }
        }
    }

    /// [`Walk::run`] where the threads of a warp wait for each other after every node and leaf: otherwise they drift apart, and
    /// meet again at the end.
    #[inline(always)]
    pub(super) fn run_in_step(
        &mut self,
        view: &PairView,
        filter: &RayFilter,
        search: &mut impl Search,
        warp: Warp,
    ) -> Outcome {
        let mut outcome = None;
        if self.space.ray.t_min.is_nan() {
            outcome = Some(Outcome::Over);
        } else if !ANYWHERE && self.space.slack > 0.0 {
            outcome = Some(Outcome::Far);
        }
        loop {
            if outcome.is_none() {
                outcome = self.step(view, filter, search);
            }
            if warp.count(outcome.is_none()) == 0 {
                return outcome.unwrap_or(Outcome::Over);
            }
        }
    }

    /// Past a pair or a leaf. Where that ends the walk, how.
    #[inline(always)]
    fn step(&mut self, view: &PairView, filter: &RayFilter, search: &mut impl Search) -> Option<Outcome> {
        if self.next.is_pair() {
            let t_max = self.t_max(search);
            self.pass(&trusted(view.pairs, self.next.0).read(), t_max);
            return None;
        }
        if self.next.is_triangles() {
            if self.search_triangles(view, filter, search) {
                return Some(Outcome::Over);
            }
        } else if let Some(outcome) = self.enter(view, search) {
            return Some(outcome);
        }
        if !self.next.is_pair() {
            self.next = self.pop();
        }
        None
    }

    /// Whether to walk together with the threads that are here. Only the world is walked through so.
    #[inline(always)]
    pub(super) fn goes_along(&self, warp_mode: WarpMode, warp: Warp) -> bool {
        if PLACED || warp_mode == WarpMode::INDEPENDENT {
            return false;
        }
        if warp_mode == WarpMode::VOTING {
            return true;
        }
        let o = self.space.placement.world_ray.origin;
        let octant = self.space.octant();
        let [x, y, z, ways] = [o.x.to_bits(), o.y.to_bits(), o.z.to_bits(), octant].map(|n| warp.agrees(n));
        x & y & z & ways
    }

    /// [`Walk::run`] with all threads of a warp at the same node: they go where any of them has to, first to the child that is
    /// nearer for most. Nodes are read once, and no thread waits for others' stacks.
    #[inline(always)]
    pub(super) fn run_together(
        &mut self,
        view: &PairView,
        filter: &RayFilter,
        search: &mut impl Search,
        warp: Warp,
    ) -> Outcome {
        let is_far = !ANYWHERE && self.space.slack > 0.0;
        let mut is_over = self.space.ray.t_min.is_nan() | is_far;
        loop {
            let t_max = in_register(self.t_max(search));
            while self.next.is_pair() {
                let pair = trusted(view.pairs, self.next.0).read();
                let crossing = self.cross(&pair, t_max);
                let (enters0, enters1) = (crossing.enters0 & !is_over, crossing.enters1 & !is_over);
                let (any0, any1) = (warp.count(enters0) > 0, warp.count(enters1) > 0);
                if any0 & any1 {
                    let second_first = enters1 & (!enters0 | (crossing.near1 < crossing.near0));
                    let first_first = enters0 & !second_first;
                    self.fork(&pair, warp.count(second_first) > warp.count(first_first));
                } else if any0 | any1 {
                    self.next = if any0 { pair.link0 } else { pair.link1 };
                } else {
                    self.next = self.pop();
                }
            }
            if self.next == Link::DONE {
                break;
            }
            if !is_over {
                is_over = if self.next.is_triangles() {
                    self.search_triangles(view, filter, search)
                } else {
                    self.next.is_sphere() && self.search_sphere(view, search)
                };
            }
            self.next = self.pop();
            if warp.count(!is_over) == 0 {
                break;
            }
        }
        if is_far { Outcome::Far } else { Outcome::Over }
    }

    /// Which children the ray enters, and where.
    #[inline(always)]
    fn cross(&self, pair: &BvhPair, t_max: f32) -> Crossing {
        let (mut half0, mut half1) = (pair.half0, pair.half1);
        if ANYWHERE {
            let slack = Vec3::splat(self.space.slack);
            (half0, half1) = (half0 + slack, half1 + slack);
        }
        let (near0, far0) = self.space.interval(pair.center0, half0);
        let (near1, far1) = self.space.interval(pair.center1, half1);
        let (enters0, enters1) = (Slab::passes(near0, far0, t_max), Slab::passes(near1, far1, t_max));
        Crossing { enters0, enters1, near0, near1 }
    }

    /// From a pair to its nearer child, or to what was put aside.
    #[inline(always)]
    fn pass(&mut self, pair: &BvhPair, t_max: f32) {
        let Crossing { enters0, enters1, near0, near1 } = self.cross(pair, t_max);
        if enters0 & enters1 {
            self.fork(pair, near1 < near0);
        } else if enters0 | enters1 {
            self.next = if enters0 { pair.link0 } else { pair.link1 };
        } else {
            self.next = self.pop();
        }
    }

    /// Puts one child aside.
    #[inline(always)]
    fn fork(&mut self, pair: &BvhPair, second_first: bool) {
        let (nearer, farther) =
            if second_first { (pair.link1, pair.link0) } else { (pair.link0, pair.link1) };
        // SAFETY: a walk puts aside one link a level, and no tree has more than MAX_BVH_DEPTH of them. The world's tree is
        // done with before the two others begin.
        unsafe { self.stack.push(farther) };
        self.next = nearer;
    }

    /// What was put aside last. (That it may lie beyond the best hit by now is found out when its children are tested: to
    /// keep where the ray enters would double the stack, which is what fills a GPU's first cache.)
    #[inline(always)]
    fn pop(&mut self) -> Link {
        // SAFETY: below everything lies the end, after which nothing is taken.
        unsafe { self.stack.pop_unchecked() }
    }

    /// Neither pairs nor triangles. Where that ends the walk, how.
    #[inline(always)]
    fn enter(&mut self, view: &PairView, search: &mut impl Search) -> Option<Outcome> {
        let (kind, number) = (self.next.0 & !NUMBER, self.next.0 & NUMBER);
        let world_ray = self.space.placement.world_ray;
        if self.next.is_sphere() {
            return self.search_sphere(view, search).then_some(Outcome::Over);
        }
        if PLACED && kind == INSTANCE {
            let mut slab = view.primitives.world_slab(world_ray);
            let mut t_min = world_ray.t_min;
            if ANYWHERE {
                // Instances are entered from the world.
                (slab, t_min) = (self.space.ray.slab, self.space.ray.t_min);
            }
            let ends = [t_min, self.t_max(search)];
            let (placement, ray) = view.primitives.enter_instance(number, world_ray, &slab, ends)?;
            let instance = trusted(view.primitives.instances, number);
            let root = trusted(view.roots, instance.geometry);
            let mut space = Space::new(placement, ray, root.reach);
            if ANYWHERE {
                let map = Some(&instance.object_from_world);
                let bounds = view.bounds_of(root.first);
                space =
                    space.seen_from_box(&bounds, root.reach, |ray, bounds| FarRay::new(ray, map, bounds))?;
            }
            self.space = space;
            if !ANYWHERE && self.space.slack > 0.0 {
                return Some(Outcome::Far);
            }
            // SAFETY: closed views: the depth of trees fits the stack, whose bound counts this mark.
            unsafe { self.stack.push(Link::WORLD) };
            self.next = root.first;
            // A tree that is a leaf is visited from there like any other.
            if !self.next.is_pair() {
                // SAFETY: closed views: the depth of trees fits the stack, and this leaf is the only item of its instance.
                unsafe { self.stack.push(self.next) };
            }
        } else if PLACED && self.next == Link::WORLD {
            let root = trusted(view.roots, 0);
            self.space = Space::world(&view.primitives, root.reach, world_ray);
            if ANYWHERE && let Some(space) = self.world_from_box(view) {
                self.space = space;
            }
        } else if self.next == Link::DONE {
            return Some(Outcome::Over);
        }
        None
    }
}
