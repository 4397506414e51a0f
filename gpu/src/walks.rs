//! What kernels over a structure do whose walks are the same for paths (`paths.rs`) and for Whitted's trees (`trees.rs`,
//! `lights.rs`): the launch says which of the two its queues hold. So each structure has its walks once.

use crate::lights;
use crate::paths;
use crate::queue::{Places, Threads, read};
use crate::totals::Totals;
use crate::trees;
use crate::warp;
use crate::watch::Watching;
use eosphor_core::device::{PathLaunch, query_of_rows, was_traced};
use eosphor_core::hierarchy::Tracer;
use eosphor_core::integrator::path::Straight;
use eosphor_core::integrator::{Crossing, Crossings, ShadowFilter, through_crossings};
use eosphor_core::material::Material;
use eosphor_core::ray::{Hit, Ray};
use eosphor_core::settings::ShadowMode;
use eosphor_core::view::SceneView;

/// Finds what rays hit, and lists by that, from the first on, paths that have left the scene or met what is matte, and nodes whose
/// rays end at a surface; others from the last on.
///
/// # Safety
///
/// As for `paths::generate`, or `trees::generate`; `totals` are there.
#[inline(always)]
pub(crate) unsafe fn find_hits<T: Tracer>(
    view: &SceneView,
    tracer: &T,
    launch: &PathLaunch,
    watching: &impl Watching,
) {
    let is_of_trees = launch.is_of_trees();
    // SAFETY: no thread of this kernel writes this part of it.
    let (count, waiting) = unsafe { ((*launch.control).paths, (*launch.control).waiting) };
    let threads = Threads::here();
    let mut first = threads.first_of_warp();
    while first < count {
        let mut item = first + threads.lane();
        first += threads.all;
        let (mut lists, mut is_miss) = ([false; 2], false);
        if item < count {
            // SAFETY: one of this round, and this thread's alone.
            unsafe {
                let mut is_traced = false;
                let rows;
                if is_of_trees {
                    (item, rows) = trees::asked(launch, waiting, item);
                    is_traced = was_traced(&rows[0]);
                } else {
                    rows = read::<3>(launch.paths, launch.room, item);
                }
                let mut is_first = false;
                if !is_traced {
                    let (ray, filter) = query_of_rows(rows, view.settings.cull_back_faces);
                    let hit = tracer.closest_hit(&ray, &filter);
                    if is_of_trees {
                        is_miss = hit.is_miss();
                        is_first = trees::note_hit(view, launch, item, &hit);
                    } else {
                        is_first = paths::note_hit(view, launch, item, &rows, &hit);
                    }
                }
                lists = [is_first & !is_miss, !is_first];
            }
        }
        // SAFETY: the control is there, and this part of it is touched by additions like this alone; each item is in one list, so
        // the two do not meet, and each place is one thread's.
        unsafe {
            if is_of_trees {
                trees::free_missed(launch, threads.lane(), item, is_miss);
            }
            let places = Places::take(&raw mut (*launch.control).sorted, threads.lane(), lists);
            if places.has(0) {
                *launch.sorted.add(places.at(0) as usize) = item;
            }
            if places.has(1) {
                *launch.sorted.add((launch.room - 1 - places.at(1)) as usize) = item;
            }
        }
    }
    // SAFETY: the totals are there.
    watching.add_to(&unsafe { Totals::new(launch.totals) }, threads.lane());
}

/// Finds which lights are seen. Shadow rays that have something in their way are listed where light may come through.
///
/// # Safety
///
/// As for `paths::shade`, or `lights::ask`, which has made the rays; `totals` are there.
#[inline(always)]
pub(crate) unsafe fn see<T: Tracer>(
    view: &SceneView,
    tracer: &T,
    launch: &PathLaunch,
    watching: &impl Watching,
) {
    let is_of_trees = launch.is_of_trees();
    if is_of_trees & (view.settings.shadow_mode == ShadowMode::None) {
        return;
    }
    let is_coloured = !launch.hidden.is_null();
    // SAFETY: no thread of this kernel writes this part of it.
    let mut count = unsafe { ((*launch.control).appended >> 32) as u32 };
    if is_of_trees {
        count = launch.lights.rays(count);
    }
    let threads = Threads::here();
    let mut first = threads.first_of_warp();
    while first < count {
        let index = first + threads.lane();
        first += threads.all;
        // Or else the compiler makes a loop with a walk of its own for each of the two.
        let is_of_trees = warp::unknown(is_of_trees);
        let mut is_hidden = false;
        if index < count {
            // SAFETY: a ray of the queue, and this thread's alone.
            unsafe {
                let query = if is_of_trees {
                    lights::query(view, launch, index)
                } else {
                    Some(paths::light_query(launch, index))
                };
                if let Some((ray, filter)) = query {
                    is_hidden = tracer.occluded(&ray, &filter);
                    if warp::unknown(is_of_trees) {
                        lights::note_seen(launch, index, is_hidden);
                    } else if !is_hidden {
                        paths::add_light(launch, index);
                    }
                }
            }
        }
        if is_coloured {
            let control = launch.control;
            // SAFETY: the control is there, and this part of it is touched by additions like this alone; each place is one
            // thread's, and there are no more than rays.
            unsafe {
                let places = Places::take(&raw mut (*control).hidden, threads.lane(), [is_hidden, false]);
                if places.has(0) {
                    *launch.hidden.add(places.at(0) as usize) = index;
                }
            }
        }
    }
    // SAFETY: the totals are there.
    watching.add_to(&unsafe { Totals::new(launch.totals) }, threads.lane());
}

/// Finds what of light comes through what is in the way of shadow rays.
///
/// # Safety
///
/// As for [`see`], which has listed the rays in `hidden`.
#[inline(always)]
pub(crate) unsafe fn cross<T: Tracer>(
    view: &SceneView,
    tracer: &T,
    launch: &PathLaunch,
    watching: &impl Watching,
) {
    let crossing = CrossingOf { trees: launch.is_of_trees() };
    // SAFETY: no thread of this kernel writes it.
    let count = unsafe { (*launch.control).hidden } as u32;
    let threads = Threads::here();
    let mut place = threads.number;
    while place < count {
        let is_of_trees = warp::unknown(crossing.trees);
        // SAFETY: what is listed are rays of the queue; each is one thread's.
        unsafe {
            let index = *launch.hidden.add(place as usize);
            let query = if is_of_trees {
                lights::query(view, launch, index)
            } else {
                Some(paths::light_query(launch, index))
            };
            if let Some((ray, filter)) = query {
                let through = through_crossings(view, tracer, crossing, &ray, &filter);
                if warp::unknown(is_of_trees) {
                    lights::note_through(launch, index, through);
                } else {
                    paths::add_light_through(launch, index, through);
                }
            }
        }
        place += threads.all;
    }
    // SAFETY: the totals are there.
    watching.add_to(&unsafe { Totals::new(launch.totals) }, threads.lane());
}

/// How surfaces are crossed: one loop from hit to hit for both.
#[derive(Clone, Copy)]
struct CrossingOf {
    trees: bool,
}

impl Crossing for CrossingOf {
    #[inline(always)]
    fn stops_all(self, material: &Material) -> bool {
        if warp::unknown(self.trees) {
            ShadowFilter.stops_all(material)
        } else {
            Straight.stops_all(material)
        }
    }

    #[inline(always)]
    fn cross(self, before: &Crossings, view: &SceneView, ray: &Ray, hit: &Hit) -> Crossings {
        if warp::unknown(self.trees) {
            ShadowFilter.cross(before, view, ray, hit)
        } else {
            Straight.cross(before, view, ray, hit)
        }
    }
}
