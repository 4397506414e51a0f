//! What kernels do with paths in queues: a round is `begin` → `generate` → `walks::find_hits` → `shade` → `walks::see` →
//! `walks::cross`, and at the end of a pass comes `settle`. All but the first go through as many items as the queues have,
//! however many threads there are.

use crate::queue::{Places, Threads, read, write};
use crate::totals::Totals;
use core::mem::MaybeUninit;
use core::sync::atomic::{AtomicU64, Ordering};
use eosphor_core::device::{
    HIT_ROWS, PATH_ROWS, PathControl, PathLaunch, PathPlace, REQUEST_ROWS, Row, hit_of_rows, is_outside,
    path_of_rows, query_of_request, request_of_rows, rows_of_hit, rows_of_path, rows_of_request,
};
use eosphor_core::integrator::path::{
    Bounce, BounceLanes, LightRequest, NumbersByKey, PathState, bounce_at_surface, bounce_matte,
    is_matte_outside, surroundings,
};
use eosphor_core::integrator::{RayCounts, camera_ray, pixel_color};
use eosphor_core::math::Vec3;
use eosphor_core::ray::{Hit, Ray, RayFilter};
use eosphor_core::sums::ExactSum;
use eosphor_core::view::SceneView;

/// Begins a round: one thread.
///
/// # Safety
///
/// The launch's `control` is there.
#[inline(always)]
pub(crate) unsafe fn begin(launch: &PathLaunch) {
    // SAFETY: there, and this is the only thread.
    unsafe { &mut *launch.control }.begin_round(launch.room);
}

/// Puts paths from the camera behind those that go on.
///
/// # Safety
///
/// The launch's arrays have room for `room` paths, as [`PathLaunch`] says, and its `control` is there.
#[inline(always)]
pub(crate) unsafe fn generate(view: &SceneView, launch: &PathLaunch) {
    // SAFETY: no thread of this kernel writes it.
    let control: PathControl = unsafe { *launch.control };
    let width = view.settings.width;
    let count = control.paths - control.first_new;
    let threads = Threads::here();
    let mut number = threads.number;
    while number < count {
        let (x, y, sample) = launch.sample(width, control.first_sample + number);
        let path = PathState::new(camera_ray(view, x, launch.first_row + y, sample));
        let place = PathPlace { pixel: y * width + x, sample };
        // SAFETY: below `room`, by `begin_round`; each number is one thread's.
        unsafe {
            write(launch.paths, launch.room, control.first_new + number, rows_of_path(&path, place));
        }
        number += threads.all;
    }
}

/// Notes what a path has hit. Says whether it has left the scene or met what is matte.
///
/// # Safety
///
/// As for [`generate`]; the number is one of a path, which this thread alone has.
#[inline(always)]
pub(crate) unsafe fn note_hit(
    view: &SceneView,
    launch: &PathLaunch,
    number: u32,
    rows: &[Row; 3],
    hit: &Hit,
) -> bool {
    // SAFETY: by this function's contract.
    unsafe { write::<HIT_ROWS>(launch.hits, launch.room, number, rows_of_hit(hit)) };
    hit.is_miss() || is_outside(rows) && is_matte_outside(view, hit)
}

/// Shades what the paths have hit: adds what they find, asks of lights, and writes the paths that go on. If `MATTE`, those that
/// have left the scene or met what is matte, else the others.
///
/// # Safety
///
/// As for [`generate`]; `sums` are there for the band's pixels, and `totals` are.
#[inline(always)]
pub(crate) unsafe fn shade<const MATTE: bool>(view: &SceneView, launch: &PathLaunch) {
    // SAFETY: no thread of this kernel writes this part of it.
    let sorted = unsafe { (*launch.control).sorted };
    let count = if MATTE { sorted as u32 } else { (sorted >> 32) as u32 };
    let room = launch.room;
    let threads = Threads::here();
    let mut counts = RayCounts::default();
    let mut first = threads.first_of_warp();
    while first < count {
        let place_in_list = first + threads.lane();
        first += threads.all;
        let (mut request, mut next) = (MaybeUninit::uninit(), MaybeUninit::uninit());
        let mut step =
            Step { launch, pixel: 0, request: &mut request, next: &mut next, asks: false, goes_on: false };
        let mut place = PathPlace { pixel: 0, sample: 0 };
        if place_in_list < count {
            // SAFETY: below `room`, as all numbers in the lists are.
            let (rows, hit) = unsafe {
                let in_list = if MATTE { place_in_list } else { room - 1 - place_in_list };
                let number = *launch.sorted.add(in_list as usize);
                let rows = read::<PATH_ROWS>(launch.paths, room, number);
                (rows, hit_of_rows(read::<HIT_ROWS>(launch.hits, room, number)))
            };
            let (path, own) = path_of_rows(&rows);
            place = own;
            step.pixel = place.pixel;
            counts.count(path.ray.kind);
            let pixel = launch.pixel(view.settings.width, place);
            let numbers = NumbersByKey::new(view.settings, &path.ray, pixel);
            if !MATTE {
                // Misses are in the other list.
                bounce_at_surface(view, &path, &hit, &numbers, &mut step);
            } else if hit.is_miss() {
                step.add(surroundings(view, &path.ray));
            } else {
                bounce_matte::<1, _>(view, 1, |_| (&path, &hit), &numbers, &mut step);
            }
        }
        counts.shadow += step.asks as u64;
        // SAFETY: the control is there, and this part of it is touched by additions like this alone.
        let places = unsafe {
            Places::take(&raw mut (*launch.control).appended, threads.lane(), [step.goes_on, step.asks])
        };
        // SAFETY: a path has one next path and asks once, so there are at most `room`; each place is one thread's. What there
        // is was written.
        unsafe {
            if places.has(0) {
                write(launch.next, room, places.at(0), rows_of_path(next.assume_init_ref(), place));
            }
            if places.has(1) {
                let rows = rows_of_request(request.assume_init_ref(), place.pixel);
                write(launch.requests, room, places.at(1), rows);
            }
        }
    }
    // SAFETY: the totals are there.
    unsafe { Totals::new(launch.totals) }.add(&counts, threads.lane());
}

/// What one surface gave.
struct Step<'a> {
    launch: &'a PathLaunch,
    pixel: u32,
    request: &'a mut MaybeUninit<LightRequest>,
    next: &'a mut MaybeUninit<PathState>,
    asks: bool,
    goes_on: bool,
}

impl Bounce for Step<'_> {
    #[inline(always)]
    fn add(&mut self, found: Vec3) {
        // SAFETY: the pixel is one of the band.
        unsafe { add(self.launch, self.pixel, found) };
    }

    #[inline(always)]
    fn ask(&mut self, request: LightRequest) {
        self.request.write(request);
        self.asks = true;
    }

    #[inline(always)]
    fn go_on(&mut self, next: PathState) {
        self.next.write(next);
        self.goes_on = true;
    }
}

impl BounceLanes for Step<'_> {
    type Lane<'a>
        = OneLane<'a, Self>
    where
        Self: 'a;

    #[inline(always)]
    fn lane(&mut self, _: usize) -> OneLane<'_, Self> {
        OneLane(self)
    }
}

/// The only lane there is.
struct OneLane<'a, B>(&'a mut B);

impl<B: Bounce> Bounce for OneLane<'_, B> {
    #[inline(always)]
    fn add(&mut self, found: Vec3) {
        self.0.add(found);
    }

    #[inline(always)]
    fn ask(&mut self, request: LightRequest) {
        self.0.ask(request);
    }

    #[inline(always)]
    fn go_on(&mut self, next: PathState) {
        self.0.go_on(next);
    }
}

/// Adds a contribution to a pixel of the pass. A pass has so few samples that no sum wraps.
///
/// # Safety
///
/// The pixel has a sum.
#[inline(always)]
unsafe fn add(launch: &PathLaunch, pixel: u32, found: Vec3) {
    let mut own = ExactSum::default();
    own.add(found);
    let mut channel = 0;
    while channel < 3 {
        if own.units[channel] > 0 {
            // SAFETY: it is there, and touched by additions like this alone.
            unsafe {
                let sum = &raw mut (*launch.sums.add(pixel as usize)).units[channel];
                AtomicU64::from_ptr(sum).fetch_add(own.units[channel], Ordering::Relaxed);
            }
        }
        channel += 1;
    }
}

/// The shadow ray of a request.
///
/// # Safety
///
/// As for [`shade`], which has made the request.
#[inline(always)]
pub(crate) unsafe fn light_query(launch: &PathLaunch, number: u32) -> (Ray, RayFilter) {
    // SAFETY: below `room`, since paths ask once.
    query_of_request(unsafe { read::<3>(launch.requests, launch.room, number) })
}

/// Adds what a light gives that is seen.
///
/// # Safety
///
/// As for [`light_query`].
#[inline(always)]
pub(crate) unsafe fn add_light(launch: &PathLaunch, number: u32) {
    // SAFETY: by this function's contract; the pixel is one of the band.
    unsafe {
        let (request, pixel) = request_of_rows(&read::<REQUEST_ROWS>(launch.requests, launch.room, number));
        add(launch, pixel, request.contribution);
    }
}

/// Adds what comes of a light through what is in the way.
///
/// # Safety
///
/// As for [`light_query`].
#[inline(always)]
pub(crate) unsafe fn add_light_through(launch: &PathLaunch, number: u32, through: Vec3) {
    // SAFETY: by this function's contract; the pixel is one of the band.
    unsafe {
        let (request, pixel) = request_of_rows(&read::<REQUEST_ROWS>(launch.requests, launch.room, number));
        add(launch, pixel, request.contribution * through);
    }
}

/// Makes of the pass's sums what is wanted of the band's pixels, and leaves them empty for the next pass.
///
/// # Safety
///
/// The band's pixels have sums, and colours or the sums before where these are not null.
#[inline(always)]
pub(crate) unsafe fn settle(view: &SceneView, launch: &PathLaunch) {
    let pixels = (launch.end_row - launch.first_row) * view.settings.width;
    let threads = Threads::here();
    let mut number = threads.number;
    while number < pixels {
        let pixel = number as usize;
        // SAFETY: a pixel of the band, which this thread alone has.
        unsafe {
            let mut sum = *launch.sums.add(pixel);
            if !launch.before.is_null() {
                sum.merge(&*launch.before.add(pixel));
                *launch.before.add(pixel) = sum;
                *launch.sums.add(pixel) = ExactSum::default();
            }
            if !launch.film.is_null() {
                *launch.film.add(pixel) = pixel_color(view, &sum);
            }
        }
        number += threads.all;
    }
}
