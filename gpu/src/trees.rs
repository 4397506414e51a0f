//! What kernels do with Whitted's trees of rays: a round is `begin` → `generate` → `walks::find_hits` → `shade_ends`, `shade`, as
//! for paths (`paths.rs`), and then come lights (`lights.rs`). Nodes lie in slots, and those that wait in a stack: rounds take
//! the last ones, so that there are never many more than one tree is deep.

use crate::queue::{Places, Threads, read, write};
use crate::totals::Totals;
use crate::warp;
use core::mem::MaybeUninit;
use core::sync::atomic::{AtomicU64, Ordering};
use eosphor_core::device::{
    FRESH_NODE_ROWS, LIT_ROWS, LitPlace, NODE_CHILDREN, NODE_ROWS, NODE_STRIDE, PathLaunch, PathPlace, Row,
    TreeNode, in_ring, rows_of_fresh_node, rows_of_hit, rows_of_lit,
};
use eosphor_core::integrator::whitted::{
    LampLobe, LitPoint, branches_at, child_ray, depth_limit, ends_at, local_radiance, ray_behind, takes_light,
};
use eosphor_core::integrator::{PathRay, RayCounts, camera_ray, weight_at};
use eosphor_core::math::Vec3;
use eosphor_core::ray::Hit;
use eosphor_core::shading::SurfacePoint;
use eosphor_core::sums::ExactSum;
use eosphor_core::view::SceneView;

/// Puts all slots into the ring of free ones.
///
/// # Safety
///
/// The launch's `free` has room for all slots.
#[inline(always)]
pub(crate) unsafe fn prepare(launch: &PathLaunch) {
    let threads = Threads::here();
    let mut number = threads.number;
    while number < launch.slots {
        // SAFETY: below `slots`; each number is one thread's.
        unsafe { *launch.free.add(number as usize) = number };
        number += threads.all;
    }
}

/// Begins a round: one thread.
///
/// # Safety
///
/// The launch's `control` is there.
#[inline(always)]
pub(crate) unsafe fn begin(launch: &PathLaunch) {
    // SAFETY: there, and this is the only thread.
    unsafe { &mut *launch.control }.begin_round_of_trees(launch.room, launch.slots);
}

/// The first row of a slot.
///
/// # Safety
///
/// It is one of the launch's slots.
#[inline(always)]
unsafe fn slot_rows(launch: &PathLaunch, slot: u32) -> *mut Row {
    // SAFETY: inside of the slots.
    unsafe { launch.paths.add(slot as usize * NODE_STRIDE) }
}

/// Reads rows of a node that follow each other.
///
/// # Safety
///
/// They are there.
#[inline(always)]
unsafe fn read_rows<const N: usize>(rows: *const Row) -> [Row; N] {
    // SAFETY: as an array whose items are apart by one.
    unsafe { read::<N>(rows, 1, 0) }
}

/// Writes rows of a node that follow each other.
///
/// # Safety
///
/// They are there, and no other thread has them.
#[inline(always)]
unsafe fn write_rows<const N: usize>(rows: *mut Row, written: [Row; N]) {
    // SAFETY: as an array whose items are apart by one.
    unsafe { write::<N>(rows, 1, 0, written) }
}

/// A slot of the ring, so many from its first.
///
/// # Safety
///
/// The ring is there, and that one is in it.
#[inline(always)]
unsafe fn free_slot(launch: &PathLaunch, first: u32, number: u32) -> u32 {
    // SAFETY: inside of the ring.
    unsafe { *launch.free.add(in_ring(first + number, launch.slots) as usize) }
}

/// Begins trees with rays from the camera.
///
/// # Safety
///
/// The launch's arrays have room as [`PathLaunch`] says, and its `control` is there.
#[inline(always)]
pub(crate) unsafe fn generate(view: &SceneView, launch: &PathLaunch) {
    // SAFETY: no thread of this kernel writes it.
    let control = unsafe { &*launch.control };
    let width = view.settings.width;
    let count = control.samples - control.samples_left - control.first_sample;
    let threads = Threads::here();
    let mut counts = RayCounts::default();
    let mut first = threads.first_of_warp();
    while first < count {
        let number = first + threads.lane();
        first += threads.all;
        if number < count {
            let (x, y, sample) = launch.sample(width, control.first_sample + number);
            let ray = camera_ray(view, x, launch.first_row + y, sample);
            let place = PathPlace { pixel: y * width + x, sample };
            counts.camera += 1;
            // SAFETY: there is room, by `begin_round_of_trees`; each number is one thread's.
            unsafe {
                let slot = free_slot(launch, control.new_slots, number);
                *launch.stack.add((control.first_new + number) as usize) = slot;
                write_rows(slot_rows(launch, slot), rows_of_fresh_node(&ray, place, TreeNode::FRESH));
            }
        }
    }
    // SAFETY: the totals are there.
    unsafe { Totals::new(launch.totals) }.add(&counts, threads.lane());
}

/// The slot of a node of this round, and the rows that a query reads of it.
///
/// # Safety
///
/// As for [`generate`]; there are more nodes in this round.
#[inline(always)]
pub(crate) unsafe fn asked(launch: &PathLaunch, waiting: u32, number: u32) -> (u32, [Row; 3]) {
    // SAFETY: inside of the stack, whose slots are those of nodes.
    unsafe {
        let slot = *launch.stack.add((waiting + number) as usize);
        (slot, read_rows::<3>(slot_rows(launch, slot)))
    }
}

/// Notes what a node's ray has hit; where that is nothing, what surrounds the scene is added. Says whether the ray ends there.
///
/// # Safety
///
/// As for [`generate`]; the slot is one of a node, which this thread alone has.
#[inline(always)]
pub(crate) unsafe fn note_hit(view: &SceneView, launch: &PathLaunch, slot: u32, hit: &Hit) -> bool {
    // SAFETY: by this function's contract; the pixel is one of the band.
    unsafe {
        let node = slot_rows(launch, slot);
        if hit.is_miss() {
            let [Row([x, y, z, _]), Row([pixel, ..])] = read_rows::<2>(node.add(3));
            let weight = Vec3 { x: f32::from_bits(x), y: f32::from_bits(y), z: f32::from_bits(z) };
            add_saturating(launch, pixel, weight * view.settings.background);
            return true;
        }
        write_rows(node.add(FRESH_NODE_ROWS), rows_of_hit(hit));
    }
    launch.lists_ends != 0 && ends_at(view, hit)
}

/// Frees the slots of nodes whose rays have left the scene.
///
/// # Safety
///
/// As for [`note_hit`]. All threads of a warp come here.
#[inline(always)]
pub(crate) unsafe fn free_missed(launch: &PathLaunch, lane: u32, slot: u32, is_miss: bool) {
    // SAFETY: the control is there, and this part of it is touched by additions like this alone; each place is one thread's, and
    // there are no more than nodes.
    unsafe {
        let control = launch.control;
        let places = Places::take(&raw mut (*control).missed, lane, [is_miss, false]);
        if places.has(0) {
            // From the end, since those that are shaded begin at the first.
            let at = in_ring((*control).end_free + ((*control).paths - 1 - places.at(0)), launch.slots);
            *launch.free.add(at as usize) = slot;
        }
    }
}

/// The number-th node of the list of those whose rays end, or of the other one. Its slot becomes free if `is_one`.
///
/// # Safety
///
/// As for [`generate`]; the list has so many.
#[inline(always)]
unsafe fn take_node<const ENDS: bool>(launch: &PathLaunch, number: u32, is_one: bool) -> TreeNode {
    // SAFETY: what the lists name are slots of nodes; each node of the round is in one of them or has left the scene, so each is
    // freed once.
    unsafe {
        let (in_list, freed) = match ENDS {
            true => (number, number),
            false => (launch.room - 1 - number, (*launch.control).sorted as u32 + number),
        };
        let slot = *launch.sorted.add(in_list as usize);
        if is_one {
            *launch.free.add(in_ring((*launch.control).end_free + freed, launch.slots) as usize) = slot;
        }
        TreeNode::of_rows(&read_rows::<NODE_ROWS>(slot_rows(launch, slot)))
    }
}

/// What a node asks of lights, and what it gives where it asks for nothing.
struct Lighting {
    asks: bool,
    lit: MaybeUninit<[Row; LIT_ROWS]>,
}

impl Lighting {
    const NONE: Lighting = Lighting { asks: false, lit: MaybeUninit::uninit() };

    /// Adds what a point gives by itself, here or with its light. The point shows by this share.
    ///
    /// # Safety
    ///
    /// As for [`shade`].
    #[inline(always)]
    unsafe fn begin(
        &mut self,
        view: &SceneView,
        launch: &PathLaunch,
        point: &SurfacePoint,
        (ray, t, there): (&PathRay, f32, f32),
        place: PathPlace,
    ) {
        let found = local_radiance(view, point, ray, t);
        let weight = ray.weight * there;
        if view.settings.lighting_model.is_lit() & !view.lights.is_empty() {
            let lobe = LampLobe::new(view, point, ray, depth_limit(view.settings));
            if takes_light(point, &lobe) {
                self.asks = true;
                let at = LitPlace { place, path: ray.path, found, weight };
                self.lit.write(rows_of_lit(&LitPoint::new(point, &lobe), &at));
            }
        }
        if !self.asks {
            // SAFETY: the pixel is one of the band.
            unsafe { add_saturating(launch, place.pixel, weight * found) };
        }
    }
}

/// Shades what rays have hit that end there.
///
/// # Safety
///
/// As for [`shade`].
#[inline(always)]
pub(crate) unsafe fn shade_ends(view: &SceneView, launch: &PathLaunch) {
    // SAFETY: no thread of this kernel writes this part of it.
    let count = unsafe { (*launch.control).sorted as u32 };
    let threads = Threads::here();
    let mut first = threads.first_of_warp();
    while first < count {
        let number = first + threads.lane();
        first += threads.all;
        let mut lighting = Lighting::NONE;
        if number < count {
            // SAFETY: the list has so many; the pixel is one of the band.
            unsafe {
                let TreeNode { mut ray, place, hit, .. } = take_node::<true>(launch, number, true);
                let point = SurfacePoint::new(view, &ray.ray(), &hit);
                ray.weight = weight_at(view, &point, &ray, hit.t);
                lighting.begin(view, launch, &point, (&ray, hit.t, 1.0), place);
            }
        }
        let asked = [false, lighting.asks];
        // SAFETY: the control is there, and this part of it is touched by additions like this alone; there is room, and each
        // place is one thread's. What there is was written.
        unsafe {
            let places = Places::take(&raw mut (*launch.control).appended, threads.lane(), asked);
            if places.has(1) {
                write(launch.requests, launch.room, places.at(1), *lighting.lit.assume_init_ref());
            }
        }
    }
}

/// Shades what the other rays have hit: adds what is found there, asks for light, and begins the rays that go on.
///
/// # Safety
///
/// As for [`generate`]; `sums` are there for the band's pixels, and `totals` are.
#[inline(always)]
pub(crate) unsafe fn shade(view: &SceneView, launch: &PathLaunch) {
    // SAFETY: no thread of this kernel writes these parts of it.
    let (count, waiting, first_free) = unsafe {
        let control = launch.control;
        (((*control).sorted >> 32) as u32, (*control).waiting, (*control).first_free)
    };
    let settings = view.settings;
    let max_depth = depth_limit(settings);
    let turns = warp::hidden(NODE_CHILDREN);
    let threads = Threads::here();
    let mut counts = RayCounts::default();
    let mut first = threads.first_of_warp();
    while first < count {
        let number = first + threads.lane();
        first += threads.all;
        let is_one = number < count;
        // Threads without a node of their own look at the last one and keep it to themselves, since votes need them.
        let number = if is_one { number } else { count - 1 };
        // SAFETY: below the list's length.
        let node = unsafe { take_node::<false>(launch, number, is_one) };
        let TreeNode { mut ray, place, hit, next_branch } = node;
        let at = launch.pixel(settings.width, place);
        let point = SurfacePoint::new(view, &ray.ray(), &hit);
        let there = point.coverage;
        let is_fresh = next_branch == TreeNode::FRESH;
        let mut next_branch = if is_fresh { 0 } else { next_branch };
        let mut lighting = Lighting::NONE;
        if is_fresh {
            ray.weight = weight_at(view, &point, &ray, hit.t);
            if is_one & (there > 0.0) {
                // SAFETY: the pixel is one of the band.
                unsafe { lighting.begin(view, launch, &point, (&ray, hit.t, there), place) };
            }
        }
        let branches = branches_at(&point, ray.depth, max_depth);
        let shown = PathRay { weight: ray.weight * there, ..ray };
        // What comes first waits longest: what is left of the node, or what lies behind its holes. Then come rays that go on.
        let mut turn = 0;
        while turn < turns {
            let mut child = MaybeUninit::uninit();
            let mut goes_on = false;
            if turn == 0 {
                if branches > next_branch + (NODE_CHILDREN - 1) {
                    child.write((ray, next_branch + (NODE_CHILDREN - 1)));
                    goes_on = is_one;
                } else if let Some(behind) = ray_behind(view, &point, &ray, hit.t) {
                    child.write((behind, TreeNode::FRESH));
                    goes_on = is_one;
                }
            } else {
                if next_branch < branches {
                    if let Some(next) = child_ray(view, &point, &shown, at, next_branch) {
                        child.write((next, TreeNode::FRESH));
                        goes_on = is_one;
                    }
                }
                next_branch += 1;
            }
            // SAFETY: the control is there, and this part of it is touched by additions like this alone.
            let appended = [goes_on, lighting.asks];
            let places =
                unsafe { Places::take(&raw mut (*launch.control).appended, threads.lane(), appended) };
            // SAFETY: there is room, by `begin_round_of_trees`; each place is one thread's. What there is was written.
            unsafe {
                if places.has(0) {
                    let (next, branch) = *child.assume_init_ref();
                    let slot = free_slot(launch, first_free, places.at(0));
                    *launch.stack.add((waiting + places.at(0)) as usize) = slot;
                    let rows = slot_rows(launch, slot);
                    if branch == TreeNode::FRESH {
                        write_rows(rows, rows_of_fresh_node(&next, place, branch));
                        counts.count(next.kind);
                    } else {
                        let left = TreeNode { ray: next, place, hit, next_branch: branch };
                        write_rows(rows, left.rows());
                    }
                }
                if places.has(1) {
                    write(launch.requests, launch.room, places.at(1), *lighting.lit.assume_init_ref());
                }
            }
            lighting.asks = false;
            turn += 1;
        }
    }
    // SAFETY: the totals are there.
    unsafe { Totals::new(launch.totals) }.add(&counts, threads.lane());
}

/// Adds a contribution to a pixel. Trees have no bound, so sums may be full: then they stay so. What would wrap is seen by whoever
/// made it so, and whoever adds to a full sum makes it so again.
///
/// # Safety
///
/// The pixel has a sum.
#[inline(always)]
pub(crate) unsafe fn add_saturating(launch: &PathLaunch, pixel: u32, found: Vec3) {
    let mut own = ExactSum::default();
    own.add(found);
    let mut channel = 0;
    while channel < 3 {
        let units = own.units[channel];
        if units > 0 {
            // SAFETY: it is there, and touched by additions like this alone.
            unsafe {
                let sum = AtomicU64::from_ptr(&raw mut (*launch.sums.add(pixel as usize)).units[channel]);
                let before = sum.fetch_add(units, Ordering::Relaxed);
                if before > u64::MAX - units {
                    sum.fetch_max(u64::MAX, Ordering::Relaxed);
                }
            }
        }
        channel += 1;
    }
}
