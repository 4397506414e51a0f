//! Paths between two kernels: what queues hold of them, in rows of 16 bytes, and what kernels take that work on queues.
//!
//! Nothing is rounded on the way: a path that was written is the path that is read.

use super::launch::RayTotals;
use super::light_queue::LightQueue;
use crate::integrator::path::{LightRequest, PathState};
use crate::integrator::{MAX_DEPTH, PathRay, RayKind};
use crate::light::LightReceiver;
use crate::math::{Vec3, vec3};
use crate::ray::{Hit, PrimitiveId, Ray, RayFilter};
use crate::sums::ExactSum;
use crate::view::SceneCounts;

/// 16 bytes, which a thread reads or writes at once.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[repr(C, align(16))]
pub struct Row(pub [u32; 4]);

/// Rows of a path.
pub const PATH_ROWS: usize = 6;

/// Rows of what a path asks of a light.
pub const REQUEST_ROWS: usize = 4;

/// Rows of a hit: what a surface point is made of, and then which primitive it is on.
pub const HIT_ROWS: usize = 2;

/// The sample that a path belongs to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PathPlace {
    /// The pixel: its number in the band, row by row.
    pub pixel: u32,
    /// The number of the sample.
    pub sample: u32,
}

#[inline(always)]
pub(super) fn row(v: Vec3, last: u32) -> Row {
    Row([v.x.to_bits(), v.y.to_bits(), v.z.to_bits(), last])
}

#[inline(always)]
pub(super) fn vector(Row([x, y, z, _]): Row) -> Vec3 {
    vec3(f32::from_bits(x), f32::from_bits(y), f32::from_bits(z))
}

#[inline(always)]
pub(super) fn last(row: Row) -> u32 {
    row.0[3]
}

/// Bits of a path's counts: its kind, its bounces, and then the holes that it has come through.
const KIND_BITS: u32 = 2;
const DEPTH_BITS: u32 = 8;

/// A path in rows. The first three have its ray.
#[inline(always)]
pub fn rows_of_path(path: &PathState, place: PathPlace) -> [Row; PATH_ROWS] {
    let [first, second, third, fourth] = rows_of_ray(&path.ray);
    let (position, normal) = (row(path.left.position, place.pixel), row(path.left.normal, place.sample));
    [first, second, third, fourth, position, normal]
}

/// Rows of a ray with its place in a tree of rays. A query reads the first three.
pub(super) const RAY_ROWS: usize = 4;

/// A ray in rows.
#[inline(always)]
pub(super) fn rows_of_ray(ray: &PathRay) -> [Row; RAY_ROWS] {
    let counts = ray.kind as u32 | ray.depth << KIND_BITS | ray.holes << (KIND_BITS + DEPTH_BITS);
    [
        row(ray.origin, counts),
        row(ray.direction, ray.inside),
        Row([ray.start.instance, ray.start.primitive, ray.path, ray.lobe_density.to_bits()]),
        row(ray.weight, ray.travelled.to_bits()),
    ]
}

/// The ray that was written as [`rows_of_ray`].
#[inline(always)]
pub(super) fn ray_of_rows([first, second, third, fourth]: [Row; RAY_ROWS]) -> PathRay {
    let Row([instance, primitive, path, density]) = third;
    let counts = last(first);
    PathRay {
        origin: vector(first),
        path,
        direction: vector(second),
        depth: counts >> KIND_BITS & ((1 << DEPTH_BITS) - 1),
        weight: vector(fourth),
        kind: match counts & ((1 << KIND_BITS) - 1) {
            0 => RayKind::Camera,
            1 => RayKind::Reflected,
            2 => RayKind::Refracted,
            _ => RayKind::Glossy,
        },
        start: PrimitiveId { instance, primitive },
        inside: last(second),
        holes: counts >> (KIND_BITS + DEPTH_BITS),
        travelled: f32::from_bits(last(fourth)),
        lobe_density: f32::from_bits(density),
    }
}

/// Whether a path, of which these are the first rows, is in no body.
#[inline(always)]
pub fn is_outside([_, second, Row([_, _, path, _])]: &[Row; 3]) -> bool {
    (last(*second) | path) == 0
}

/// What a query must know of a path, from its first rows: the ray, and what it leaves out; `culls` is what the scene's settings say
/// of back faces.
#[inline(always)]
pub fn query_of_rows([first, second, third]: [Row; 3], culls: bool) -> (Ray, RayFilter) {
    let ray = Ray { origin: vector(first), t_min: 0.0, direction: vector(second), t_max: f32::INFINITY };
    let Row([instance, primitive, ..]) = third;
    let filter = RayFilter {
        start: PrimitiveId { instance, primitive },
        target: PrimitiveId::NONE,
        cull_back_faces: culls & (last(second) == 0),
    };
    (ray, filter)
}

/// The path that was written as [`rows_of_path`].
#[inline(always)]
pub fn path_of_rows(rows: &[Row; PATH_ROWS]) -> (PathState, PathPlace) {
    let [first, second, third, fourth, position, normal] = *rows;
    let ray = ray_of_rows([first, second, third, fourth]);
    let left = LightReceiver { position: vector(position), normal: vector(normal) };
    (PathState { ray, left }, PathPlace { pixel: last(position), sample: last(normal) })
}

/// A hit in rows.
#[inline(always)]
pub fn rows_of_hit(hit: &Hit) -> [Row; HIT_ROWS] {
    [Row([hit.t, hit.t_rest, hit.u, hit.v].map(f32::to_bits)), Row([hit.id.instance, hit.id.primitive, 0, 0])]
}

/// The hit that was written as [`rows_of_hit`].
#[inline(always)]
pub fn hit_of_rows([numbers, Row([instance, primitive, ..])]: [Row; HIT_ROWS]) -> Hit {
    let [t, t_rest, u, v] = numbers.0.map(f32::from_bits);
    Hit { t, t_rest, u, v, id: PrimitiveId { instance, primitive } }
}

/// What a path asks of a light, in rows, for a pixel.
#[inline(always)]
pub fn rows_of_request(request: &LightRequest, pixel: u32) -> [Row; REQUEST_ROWS] {
    let LightRequest { ray, filter, contribution } = request;
    [
        row(ray.origin, ray.t_max.to_bits()),
        row(ray.direction, pixel),
        Row([filter.start.instance, filter.start.primitive, filter.target.instance, filter.target.primitive]),
        row(*contribution, 0),
    ]
}

/// What a query must know of a request that was written as [`rows_of_request`], from its first rows.
#[inline(always)]
pub fn query_of_request(
    [origin, direction, Row([start, of_start, target, of_target])]: [Row; 3],
) -> (Ray, RayFilter) {
    let t_max = f32::from_bits(last(origin));
    let ray = Ray { origin: vector(origin), t_min: 0.0, direction: vector(direction), t_max };
    let filter = RayFilter {
        start: PrimitiveId { instance: start, primitive: of_start },
        target: PrimitiveId { instance: target, primitive: of_target },
        cull_back_faces: false,
    };
    (ray, filter)
}

/// What was written as [`rows_of_request`], and the pixel.
#[inline(always)]
pub fn request_of_rows(&[origin, direction, ids, contribution]: &[Row; REQUEST_ROWS]) -> (LightRequest, u32) {
    let (ray, filter) = query_of_request([origin, direction, ids]);
    (LightRequest { ray, filter, contribution: vector(contribution) }, last(direction))
}

/// How far a band's paths are. Kernels keep it: the host looks at it now and then.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[repr(C)]
pub struct PathControl {
    /// What the round has appended: in the lower half paths for the next one, in the upper half what is asked of lights.
    pub appended: u64,
    /// Likewise, how many paths of the round have left the scene or met what is matte, and how many have met something else.
    pub sorted: u64,
    /// Of trees: how many rays of the round have left the scene.
    pub missed: u64,
    /// Shadow rays of the round that have something in their way: how many are listed to be looked at again.
    pub hidden: u64,
    /// Paths of this round.
    pub paths: u32,
    /// Those from here on begin in it.
    pub first_new: u32,
    /// The sample that the first of them takes, among all of the pass.
    pub first_sample: u32,
    /// Samples that no path has taken yet.
    pub samples_left: u32,
    /// Samples of the pass.
    pub samples: u32,
    /// Rounds that had paths.
    pub rounds: u32,
    /// Of trees: how many nodes wait below those of this round.
    pub waiting: u32,
    /// Of trees: where in the ring of free slots the next one is, and where one that becomes free goes.
    pub first_free: u32,
    /// See [`PathControl::first_free`].
    pub end_free: u32,
    /// Of trees: where the slots of those that begin in this round are in the ring.
    pub new_slots: u32,
}

impl PathControl {
    /// Begins a round with what the last one has left, in a queue with room for so many paths.
    #[inline(always)]
    pub fn begin_round(&mut self, room: u32) {
        let survivors = self.appended as u32;
        let free = room - survivors;
        let new = if free < self.samples_left { free } else { self.samples_left };
        (self.appended, self.sorted, self.missed, self.hidden) = (0, 0, 0, 0);
        self.first_sample = self.samples - self.samples_left;
        self.samples_left -= new;
        self.first_new = survivors;
        self.paths = survivors + new;
        self.rounds += (self.paths > 0) as u32;
    }

    /// Likewise, where nodes of trees wait in a stack: a round takes as many as there is room for, from its top. `slots` is how
    /// many there are of all that wait.
    #[inline(always)]
    pub fn begin_round_of_trees(&mut self, room: u32, slots: u32) {
        let appended = self.appended as u32;
        self.end_free = in_ring(self.end_free + self.paths, slots);
        self.first_free = in_ring(self.first_free + appended, slots);
        let survivors = self.waiting + appended;
        let wanted = room.saturating_sub(survivors);
        let new = if wanted < self.samples_left { wanted } else { self.samples_left };
        (self.appended, self.sorted, self.missed, self.hidden) = (0, 0, 0, 0);
        self.first_sample = self.samples - self.samples_left;
        self.samples_left -= new;
        (self.first_new, self.new_slots) = (survivors, self.first_free);
        self.first_free = in_ring(self.first_free + new, slots);
        let all = survivors + new;
        let free = slots - all;
        // What a node leaves takes up to so many slots, and its own is free for the next round only: others write that in this one.
        // When room gets scarce, one is taken at a time: then there waits no more than a tree is deep.
        let most = free.saturating_sub(RESERVE) / NODE_CHILDREN;
        let mut paths = if all < room { all } else { room };
        paths = if paths < most { paths } else { most };
        if paths == 0 && all > 0 {
            paths = 1;
        }
        self.paths = paths;
        self.waiting = all - paths;
        self.rounds += (paths > 0) as u32;
    }

    /// Whether all paths have ended.
    pub fn is_done(&self) -> bool {
        self.appended as u32 == 0 && self.samples_left == 0 && self.waiting == 0
    }
}

/// What a node of a tree of rays leaves in a round, at most: two rays that go on, and one through its holes or what is left of
/// itself.
pub const NODE_CHILDREN: u32 = 3;

/// Slots for a tree whose nodes are taken one at a time.
const RESERVE: u32 = (NODE_CHILDREN - 1) * (MAX_DEPTH + 2) + 1;

/// A place in a ring of so many, from one that is less than twice as far.
#[inline(always)]
pub fn in_ring(place: u32, slots: u32) -> u32 {
    if place >= slots { place - slots } else { place }
}

/// The last parameter of every kernel that works on paths in queues.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct PathLaunch {
    /// How many items the scene's arrays have.
    pub counts: SceneCounts,
    /// Paths that are traced in a round: [`PATH_ROWS`] arrays of `room` rows each. Of trees: slots of nodes,
    /// [`NODE_STRIDE`](super::NODE_STRIDE) rows each.
    pub paths: *mut Row,
    /// Likewise: the paths of the next round.
    pub next: *mut Row,
    /// What the paths hit: [`HIT_ROWS`] arrays. Nodes of trees have their own rows for it.
    pub hits: *mut Row,
    /// What they ask of lights: [`REQUEST_ROWS`] arrays; of trees [`LIT_ROWS`](super::LIT_ROWS).
    pub requests: *mut Row,
    /// Numbers of paths by what they have met: from the first on those that are shaded as matte, from the last on the others. Of
    /// trees: slots of nodes, from the first on those whose rays end.
    pub sorted: *mut u32,
    /// Numbers of shadow rays that have something in their way; null where nothing comes through.
    pub hidden: *mut u32,
    /// How far it is.
    pub control: *mut PathControl,
    /// What the pass's samples add up to, for each pixel of the band.
    pub sums: *mut ExactSum,
    /// The sums of the passes before; null in the only one.
    pub before: *mut ExactSum,
    /// The colours of the band's pixels are written here at the end; null where sums are wanted.
    pub film: *mut Vec3,
    /// Rays are counted here.
    pub totals: *mut RayTotals,
    /// Of trees: slots of the nodes that wait, the next one last.
    pub stack: *mut u32,
    /// Of trees: a ring of slots that are free.
    pub free: *mut u32,
    /// Of trees: shadow rays.
    pub lights: LightQueue,
    /// Of trees: how many slots there are. Of paths 0.
    pub slots: u32,
    /// Of trees: not 0 where there are materials on which rays end. Nodes that meet them are listed apart.
    pub lists_ends: u32,
    /// Paths that there is room for.
    pub room: u32,
    /// The first row of the band.
    pub first_row: u32,
    /// The row after its last.
    pub end_row: u32,
    /// The first sample of the pass, of each pixel.
    pub first_sample: u32,
    /// The sample after the last.
    pub end_sample: u32,
}

/// Rows of pixels whose samples are taken together.
const STRIP_ROWS: u32 = 4;

/// Threads of a warp.
const WARP: u32 = 32;

impl PathLaunch {
    /// Whether queues hold nodes of Whitted's trees.
    #[inline(always)]
    pub fn is_of_trees(&self) -> bool {
        self.slots > 0
    }

    /// Column, row of the picture and sample of a place, in pictures of this width.
    #[inline(always)]
    pub fn pixel(&self, width: u32, place: PathPlace) -> (u32, u32, u32) {
        let width = width.max(1);
        let row = place.pixel / width;
        (place.pixel - row * width, self.first_row + row, place.sample)
    }

    /// Which sample of which pixel is the `number`-th of the pass: (column, row of the band, sample). Those that follow each other
    /// are in one tile of 8 x 4 pixels, for as many samples as there are, so that a warp's rays begin close together.
    #[inline(always)]
    pub fn sample(&self, width: u32, number: u32) -> (u32, u32, u32) {
        let rows = self.end_row - self.first_row;
        let samples = self.end_sample - self.first_sample;
        let group = number / (WARP * samples).max(1);
        let within = number - group * (WARP * samples);
        // The last group has fewer pixels.
        let left = rows * width - group * WARP;
        let pixels = if left < WARP { left } else { WARP };
        let sample = within / pixels.max(1);
        let pixel = group * WARP + (within - sample * pixels);
        let strip = pixel / (STRIP_ROWS * width).max(1);
        let in_strip = pixel - strip * (STRIP_ROWS * width);
        let rows_left = rows - strip * STRIP_ROWS;
        let height = if rows_left < STRIP_ROWS { rows_left } else { STRIP_ROWS };
        let x = in_strip / height.max(1);
        (x, strip * STRIP_ROWS + (in_strip - x * height), self.first_sample + sample)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use core::ptr::null_mut;
    use std::collections::HashSet;

    fn launch(rows: u32, samples: u32) -> PathLaunch {
        PathLaunch {
            counts: SceneCounts::default(),
            paths: null_mut(),
            next: null_mut(),
            hits: null_mut(),
            requests: null_mut(),
            sorted: null_mut(),
            hidden: null_mut(),
            stack: null_mut(),
            free: null_mut(),
            lights: LightQueue::NONE,
            slots: 0,
            lists_ends: 0,
            control: null_mut(),
            sums: null_mut(),
            before: null_mut(),
            film: null_mut(),
            totals: null_mut(),
            room: 0,
            first_row: 7,
            end_row: 7 + rows,
            first_sample: 3,
            end_sample: 3 + samples,
        }
    }

    #[test]
    fn every_sample_of_every_pixel_is_taken_once() {
        for (width, rows, samples) in [(8, 4, 2), (1, 1, 1), (7, 5, 3), (33, 2, 5), (16, 9, 1), (3, 13, 4)] {
            let launch = launch(rows, samples);
            let all: HashSet<_> =
                (0..width * rows * samples).map(|number| launch.sample(width, number)).collect();
            assert_eq!(all.len() as u32, width * rows * samples);
            assert!(
                all.iter().all(|&(x, y, sample)| x < width && y < rows && (3..3 + samples).contains(&sample))
            );
        }
        let at = |pixel| launch(5, 1).pixel(7, PathPlace { pixel, sample: 4 });
        assert_eq!([at(0), at(6), at(7), at(34)], [(0, 7, 4), (6, 7, 4), (0, 8, 4), (6, 11, 4)]);
        let first: Vec<_> = (0..32).map(|number| launch(8, 2).sample(16, number)).collect();
        assert!(first.iter().all(|&(x, y, sample)| x < 8 && y < 4 && sample == 3));
    }

    #[test]
    fn paths_hits_and_requests_are_read_as_they_were_written() {
        let start = PrimitiveId { instance: 3, primitive: u32::MAX - 1 };
        for (kind, depth, holes) in [
            (RayKind::Camera, 0, 0),
            (RayKind::Reflected, 64, 4096),
            (RayKind::Refracted, 1, 7),
            (RayKind::Glossy, 9, 0),
        ] {
            let path = PathState {
                ray: PathRay {
                    origin: vec3(1.0, -0.0, 1e-40),
                    path: 0xffff_0003,
                    direction: vec3(0.6, 0.8, 0.0),
                    depth,
                    weight: vec3(1.5, 0.25, 1e30),
                    kind,
                    start,
                    inside: 0x0002_0001,
                    holes,
                    travelled: 12.5,
                    lobe_density: 1e20,
                },
                left: LightReceiver { position: vec3(4.0, 5.0, 6.0), normal: vec3(0.0, 0.0, -1.0) },
            };
            let place = PathPlace { pixel: 123, sample: 456 };
            let rows = rows_of_path(&path, place);
            let (read, read_place) = path_of_rows(&rows);
            assert_eq!((format!("{read:?}"), read_place), (format!("{path:?}"), place));
            let (ray, filter) = query_of_rows([rows[0], rows[1], rows[2]], true);
            assert_eq!(format!("{ray:?}"), format!("{:?}", path.ray.ray()));
            assert_eq!((filter.start, filter.cull_back_faces), (start, false));
        }
        let hit = Hit { t: 2.5, t_rest: -1e-9, u: 0.25, v: 0.5, id: start };
        assert_eq!(format!("{:?}", hit_of_rows(rows_of_hit(&hit))), format!("{hit:?}"));
        let request = LightRequest {
            ray: Ray {
                origin: vec3(1.0, 2.0, 3.0),
                t_min: 0.0,
                direction: vec3(0.0, 1.0, 0.0),
                t_max: f32::INFINITY,
            },
            filter: RayFilter { start, target: PrimitiveId::NONE, cull_back_faces: false },
            contribution: vec3(0.5, 0.0, 7.0),
        };
        let (read, pixel) = request_of_rows(&rows_of_request(&request, 99));
        assert_eq!((format!("{read:?}"), pixel), (format!("{request:?}"), 99));
    }

    #[test]
    fn rounds_take_every_sample_and_end() {
        let mut control = PathControl { samples: 1000, samples_left: 1000, ..Default::default() };
        let mut taken = 0;
        while !control.is_done() {
            control.begin_round(64);
            assert!(control.paths <= 64);
            assert_eq!(control.first_sample, taken);
            taken += control.paths - control.first_new;
            // Two thirds go on.
            control.appended = (control.paths * 2 / 3) as u64 | 5 << 32;
        }
        assert_eq!(taken, 1000);
    }
}
