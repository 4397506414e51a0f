//! What kernels do with shadow rays of Whitted's trees: `ask` → `walks::see` → `walks::cross`, where light comes through
//! surfaces, → `sum`, as often as points have more rays than there is room for. A thread has a ray, so that all do the same.

use crate::queue::{Threads, read, write};
use crate::totals::Totals;
use crate::trees::add_saturating;
use eosphor_core::device::{
    LIT_ROWS, NO_LIGHT, PROGRESS_ROWS, PathLaunch, Row, light_of_word, light_word, lit_of_rows,
    progress_of_rows, row_of_vector, rows_of_progress, vector_of_row,
};
use eosphor_core::integrator::RayCounts;
use eosphor_core::integrator::whitted::{LightProgress, LightSample, add_light, light_query, light_ray};
use eosphor_core::math::Vec3;
use eosphor_core::ray::{PrimitiveId, Ray, RayFilter};
use eosphor_core::settings::ShadowMode;
use eosphor_core::view::SceneView;

/// How many points are lit.
///
/// # Safety
///
/// The launch's `control` is there, and no thread of this kernel writes this part of it.
#[inline(always)]
unsafe fn points(launch: &PathLaunch) -> u32 {
    // SAFETY: by this function's contract.
    unsafe { ((*launch.control).appended >> 32) as u32 }
}

/// Makes the shadow rays of points.
///
/// # Safety
///
/// As for `trees::shade`; the arrays of `lights` have room for the rays of `room` points.
#[inline(always)]
pub(crate) unsafe fn ask(view: &SceneView, launch: &PathLaunch) {
    let lights = &launch.lights;
    let casts = view.settings.shadow_mode != ShadowMode::None;
    // SAFETY: no thread of this kernel writes it.
    let points = unsafe { points(launch) };
    let threads = Threads::here();
    if threads.number == 0 {
        // SAFETY: the control is there, and no other thread of this kernel touches this part of it.
        unsafe { (*launch.control).hidden = 0 };
    }
    let mut counts = RayCounts::default();
    let (mut index, count) = (threads.number, lights.rays(points));
    while index < count {
        let (number, of_window) = lights.point(index);
        let of_point = lights.first + of_window;
        let (mut word, mut weights) = (NO_LIGHT, [0.0; 2]);
        if number < points && of_point < lights.all {
            // SAFETY: below `room`, since nodes ask once.
            let (point, at) = lit_of_rows(&unsafe { read::<LIT_ROWS>(launch.requests, launch.room, number) });
            let pixel = launch.pixel(view.settings.width, at.place);
            if let Some(ray) = light_ray(view, &point, at.path, pixel, of_point) {
                word = light_word(ray.light, ray.side);
                weights = [ray.diffuse, ray.specular];
                counts.shadow += casts as u64;
                // SAFETY: there is room; each ray is one thread's.
                unsafe { *lights.directions.add(index as usize) = row_of_vector(ray.direction, ray.t_max) };
            }
        }
        // SAFETY: there is room; each ray is one thread's.
        unsafe {
            *lights.lights.add(index as usize) = word;
            *lights.weights.add(index as usize) = weights;
        }
        index += threads.all;
    }
    // SAFETY: the totals are there.
    unsafe { Totals::new(launch.totals) }.add(&counts, threads.lane());
}

/// The query of a shadow ray; `None` where there is no such ray. (A loop that takes what to do with it as a closure does not
/// compile to one function.)
///
/// # Safety
///
/// As for [`ask`], which has made the ray.
#[inline(always)]
pub(crate) unsafe fn query(view: &SceneView, launch: &PathLaunch, index: u32) -> Option<(Ray, RayFilter)> {
    let lights = &launch.lights;
    // SAFETY: a ray of the queue, whose point is below `room`.
    unsafe {
        let word = *lights.lights.add(index as usize);
        if word == NO_LIGHT {
            return None;
        }
        let number = lights.point(index).0 as usize;
        let direction = vector_of_row(*lights.directions.add(index as usize));
        // As `rows_of_lit` has them.
        let row = |k: usize| *launch.requests.add(k * launch.room as usize + number);
        let ((position, offset), (above, _)) = (vector_of_row(row(0)), vector_of_row(row(1)));
        let (Row([.., instance]), Row([.., primitive])) = (row(4), row(5));
        let from = PrimitiveId { instance, primitive };
        light_query(view, (position, offset, above), from, light_of_word(word), direction)
    }
}

/// Notes whether something is in the way of a shadow ray. Through what it is, if light comes through, `walks::cross` finds out.
///
/// # Safety
///
/// As for [`ask`], which has made the ray.
#[inline(always)]
pub(crate) unsafe fn note_seen(launch: &PathLaunch, index: u32, is_hidden: bool) {
    let lights = &launch.lights;
    // SAFETY: a ray of the queue; each is one thread's.
    unsafe {
        if lights.through.is_null() {
            if is_hidden {
                *lights.weights.add(index as usize) = [0.0; 2];
            }
        } else if !is_hidden {
            *lights.through.add(index as usize) = row_of_vector(Vec3::ONE, 0.0);
        }
    }
}

/// Notes what gets through what is in the way of a shadow ray.
///
/// # Safety
///
/// As for [`ask`], which has made the ray; `through` is there.
#[inline(always)]
pub(crate) unsafe fn note_through(launch: &PathLaunch, index: u32, through: Vec3) {
    // SAFETY: a ray of the queue; each is one thread's.
    unsafe { *launch.lights.through.add(index as usize) = row_of_vector(through, 0.0) };
}

/// Adds up what lights give to points, and in the end adds that to pixels.
///
/// # Safety
///
/// As for [`ask`], whose rays `walks::see` and `walks::cross` have traced.
#[inline(always)]
pub(crate) unsafe fn sum(view: &SceneView, launch: &PathLaunch) {
    let lights = &launch.lights;
    let end = lights.first + lights.window;
    let end = if end < lights.all { end } else { lights.all };
    // SAFETY: no thread of this kernel writes it.
    let count = unsafe { points(launch) };
    let threads = Threads::here();
    let mut number = threads.number;
    while number < count {
        // SAFETY: below `room`, since nodes ask once.
        let (point, at) = lit_of_rows(&unsafe { read::<LIT_ROWS>(launch.requests, launch.room, number) });
        let mut progress = LightProgress::default();
        if lights.first > 0 {
            // SAFETY: below `room`; the window before has written it.
            let rows = unsafe { read::<PROGRESS_ROWS>(lights.progress, launch.room, number) };
            progress = progress_of_rows(rows);
        }
        let sample = |of_point: u32| {
            let index = lights.ray(number, of_point - lights.first) as usize;
            // SAFETY: a ray of the queue, which `ask` has made.
            unsafe {
                let [diffuse, specular] = *lights.weights.add(index);
                let word = *lights.lights.add(index);
                let light = if word == NO_LIGHT { None } else { Some(light_of_word(word).0) };
                let mut through = Vec3::ONE;
                if !lights.through.is_null() && light.is_some() {
                    through = vector_of_row(*lights.through.add(index)).0;
                }
                LightSample { light, through, diffuse, specular }
            }
        };
        add_light(view, &point, (lights.first, end), &mut progress, sample);
        // SAFETY: the pixel is one of the band; each point is one thread's.
        unsafe {
            if end < lights.all {
                write(lights.progress, launch.room, number, rows_of_progress(&progress));
            } else {
                let mut found = at.found;
                found += progress.sum;
                add_saturating(launch, at.place.pixel, at.weight * found);
            }
        }
        number += threads.all;
    }
}
