//! Whether a scene is a room: from where rays are stopped by walls that face them.

use super::surfaces::{Box3, Surfaces, area_vector};
use crate::double::{Vec3d, add, cross, dot, length, scale, sub};

/// Places that are looked at along each axis.
const N: usize = 5;

/// The first of them, in spacings from the side of the box; not half of one, so that few rays meet edges.
const FIRST: f64 = 0.517;

/// A room fills at least this many of the N³ places.
const LEAST_PLACES: usize = 25;

/// Of the slanting rays, at least this many of 20 are stopped: a room may have doors.
const LEAST_STOPPED: usize = 18;

/// What a scene shows from within.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Room {
    /// A closed room, to be seen from here.
    Closed { eye: Vec3d, look_at: Vec3d },
    /// Open to one side only, which is this one.
    Open { axis: usize, is_up: bool },
}

/// What a ray along an axis meets first.
#[derive(Clone, Copy)]
struct Wall {
    distance: f64,
    faces_it: bool,
}

const NOTHING: Wall = Wall { distance: f64::INFINITY, faces_it: false };

impl Wall {
    fn stops(&self) -> bool {
        self.distance < f64::INFINITY && self.faces_it
    }
}

/// A place, by numbers along the axes, and what is around it: down and up each axis.
struct Place {
    numbers: [usize; 3],
    point: Vec3d,
    walls: [[Wall; 2]; 3],
}

impl Place {
    fn clearance(&self) -> f64 {
        self.walls.iter().flatten().map(|w| w.distance).fold(f64::INFINITY, f64::min)
    }

    fn is_central(&self) -> bool {
        self.numbers.iter().all(|n| (1..N - 1).contains(n))
    }

    fn open_sides(&self) -> usize {
        self.walls.iter().flatten().filter(|w| !w.stops()).count()
    }
}

impl Room {
    pub(super) fn find(surfaces: &Surfaces, all: &Box3) -> Option<Room> {
        if all.size().iter().any(|&side| side.is_nan() || side <= 0.0) {
            return None;
        }
        let places = places(surfaces, all);
        let closed: Vec<&Place> = places.iter().filter(|p| p.open_sides() == 0).collect();
        let mut middles: Vec<&Place> = closed.iter().copied().filter(|p| p.is_central()).collect();
        if closed.len() >= LEAST_PLACES && !middles.is_empty() {
            // Those with most room around them; the order of equal ones stays.
            middles.sort_by(|a, b| b.clearance().total_cmp(&a.clearance()));
            middles.truncate(3);
            let rays: Vec<(Vec3d, Vec3d)> =
                middles.iter().flat_map(|m| slanting().map(|d| (m.point, d))).collect();
            let stopped = meets(surfaces, &rays, f64::INFINITY);
            let is_closed =
                |n: &usize| stopped[n * 20..(n + 1) * 20].iter().filter(|s| **s).count() >= LEAST_STOPPED;
            if let Some(n) = (0..middles.len()).find(is_closed) {
                let (eye, look_at) = view(surfaces, middles[n], &closed, length(all.size()));
                return Some(Room::Closed { eye, look_at });
            }
        }
        open_side(&places)
    }
}

/// The side to which most places are open, where they are open to that alone.
fn open_side(places: &[Place]) -> Option<Room> {
    let mut counts = [[0; 2]; 3];
    for place in places.iter().filter(|p| p.open_sides() == 1) {
        for axis in 0..3 {
            for up in 0..2 {
                counts[axis][up] += usize::from(!place.walls[axis][up].stops());
            }
        }
    }
    let sides = [(2, 1), (0, 1), (0, 0), (2, 0), (1, 1)];
    let (axis, up) = sides.into_iter().find(|&(axis, up)| counts[axis][up] >= 2 * LEAST_PLACES)?;
    Some(Room::Open { axis, is_up: up == 1 })
}

/// Far from the middle, at its height, with nothing between.
fn view(surfaces: &Surfaces, middle: &Place, closed: &[&Place], diagonal: f64) -> (Vec3d, Vec3d) {
    let enough = middle.clearance().min(0.03 * diagonal);
    let height = middle.numbers[1];
    let suits = |p: &&&Place| {
        p.numbers != middle.numbers
            && p.clearance() >= enough
            && (height..=height + 1).contains(&p.numbers[1])
    };
    let from: Vec<&Place> = closed.iter().filter(suits).copied().collect();
    let rays: Vec<_> = from.iter().map(|p| (p.point, sub(middle.point, p.point))).collect();
    let blocked = meets(surfaces, &rays, 1.0);
    let mut best: Option<(f64, Vec3d)> = None;
    for (place, _) in from.iter().zip(&blocked).filter(|(_, blocked)| !**blocked) {
        let distance = length(sub(middle.point, place.point));
        if best.is_none_or(|(farthest, _)| distance > farthest) {
            best = Some((distance, place.point));
        }
    }
    if let Some((_, eye)) = best {
        return (eye, middle.point);
    }
    // From the middle along the longest way.
    let mut longest = (0.0, [0.0, 0.0, -1.0]);
    for axis in [2, 0] {
        for up in 0..2 {
            let distance = middle.walls[axis][up].distance;
            if distance > longest.0 {
                let mut way = [0.0; 3];
                way[axis] = if up == 1 { distance } else { -distance };
                longest = (distance, way);
            }
        }
    }
    (middle.point, add(middle.point, scale(longest.1, 0.5)))
}

/// A grid of places, with the walls around each.
fn places(surfaces: &Surfaces, all: &Box3) -> Vec<Place> {
    let size = all.size();
    let at = |k: usize, n: usize| all.min[k] + size[k] * ((n as f64 + FIRST) / N as f64);
    let number = |n: usize| [n % N, n / N % N, n / N / N];
    let place = |n: usize| {
        let numbers = number(n);
        Place { numbers, point: [0, 1, 2].map(|k| at(k, numbers[k])), walls: [[NOTHING; 2]; 3] }
    };
    let mut places: Vec<Place> = (0..N * N * N).map(place).collect();
    surfaces.each_triangle(|t| {
        let mut bounds = Box3::EMPTY;
        t.iter().for_each(|&p| bounds.include(p));
        let normal = area_vector(t);
        for axis in (0..3).filter(|&k| normal[k] != 0.0) {
            let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
            let within = |k: usize, n: usize| (bounds.min[k]..=bounds.max[k]).contains(&at(k, n));
            for i in (0..N).filter(|&i| within(u, i)) {
                for j in (0..N).filter(|&j| within(v, j)) {
                    let (x, y) = (at(u, i), at(v, j));
                    if !covers(t, u, v, x, y) {
                        continue;
                    }
                    // Where the line meets the plane.
                    let across = normal[u] * (x - t[0][u]) + normal[v] * (y - t[0][v]);
                    let height = t[0][axis] - across / normal[axis];
                    for l in 0..N {
                        let mut numbers = [0; 3];
                        (numbers[axis], numbers[u], numbers[v]) = (l, i, j);
                        let walls = &mut places[numbers[0] + N * (numbers[1] + N * numbers[2])].walls[axis];
                        let distance = height - at(axis, l);
                        let up = usize::from(distance > 0.0);
                        if distance.abs() < walls[up].distance {
                            let faces_it = (normal[axis] < 0.0) == (up == 1);
                            walls[up] = Wall { distance: distance.abs(), faces_it };
                        }
                    }
                }
            }
        }
    });
    places
}

/// Whether a triangle covers a point, seen along the third axis.
fn covers(t: &[Vec3d; 3], u: usize, v: usize, x: f64, y: f64) -> bool {
    let edge = |a: Vec3d, b: Vec3d| (b[u] - a[u]) * (y - a[v]) - (b[v] - a[v]) * (x - a[u]);
    let e = [edge(t[0], t[1]), edge(t[1], t[2]), edge(t[2], t[0])];
    e.iter().all(|&e| e >= 0.0) || e.iter().all(|&e| e <= 0.0)
}

/// Towards the edges and corners of a cube.
fn slanting() -> [Vec3d; 20] {
    let mut all = [[0.0; 3]; 20];
    let mut count = 0;
    for n in 0..27 {
        let way = [n % 3, n / 3 % 3, n / 9].map(|x| f64::from(x) - 1.0);
        if dot(way, way) > 1.5 {
            // Not quite along the diagonals, where meshes have their edges.
            all[count] = [way[0] * 1.013, way[1] * 0.991, way[2]];
            count += 1;
        }
    }
    all
}

/// Which rays (origin and direction) meet anything before `end`, counted in directions.
fn meets(surfaces: &Surfaces, rays: &[(Vec3d, Vec3d)], end: f64) -> Vec<bool> {
    let mut met = vec![false; rays.len()];
    surfaces.each_triangle(|t| {
        let (e1, e2) = (sub(t[1], t[0]), sub(t[2], t[0]));
        for (&(origin, way), met) in rays.iter().zip(&mut met).filter(|(_, met)| !**met) {
            let p = cross(way, e2);
            let determinant = dot(e1, p);
            let s = sub(origin, t[0]);
            let u = dot(s, p) / determinant;
            // Nearly all end here.
            if !(0.0..=1.0).contains(&u) {
                continue;
            }
            let q = cross(s, e1);
            let (v, d) = (dot(way, q) / determinant, dot(e2, q) / determinant);
            *met = v >= 0.0 && u + v <= 1.0 && d > 0.0 && d < end;
        }
    });
    met
}
