//! The camera of scenes that have none. It depends on the scene alone: plain double precision, in serial.
//!
//! A closed room is seen from within, one that is open to a side from there. Of everything else the largest sides are seen
//! from above their front. Front is +z or +x, up is +y. Grounds, backdrops and what is lost far away are in the picture
//! where they happen to be; nothing is framed for them.
//!
//! The side is chosen by the first frame of an animation. The distance is such that all frames are in the picture.

mod motion;
mod room;
mod subject;
mod surfaces;
#[cfg(test)]
mod tests;

pub(super) use motion::Motion;
pub(super) use surfaces::Surfaces;

use crate::double::{Vec3d, add, cross, dot, length, scale, single, sub, unit};
use crate::model::Camera;
use eosphor_core::math::sqrt64;
use room::Room;
use std::fmt;
use subject::{Part, Subject};
use surfaces::{Box3, area_vector};

/// Room around what is framed.
const MARGIN: f64 = 1.06;

/// The horizontal field of view in rooms.
const ROOM_FOV_DEGREES: f32 = 75.0;

/// Surfaces that cover less of the picture are looked at from close by.
const LEAST_COVERAGE: f64 = 3e-4;

/// A scene that is a smaller share of the way that it moves along is seen in the first frame alone.
const LEAST_OF_MOTION: f64 = 1.0 / 32.0;

/// What the camera of a scene without one shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum View {
    /// The scene from outside: the middle of the largest sides, from above or not.
    Outside {
        /// From which side, as people say it.
        side: &'static str,
    },
    /// A closed room from within.
    Inside,
    /// A room that is open to one side, from there.
    OpenSide,
    /// The largest triangle, since the whole would be too thin to be seen.
    CloseUp,
}

impl fmt::Display for View {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            View::Outside { side } => write!(f, "seen from {side}"),
            View::Inside => f.write_str("inside the closed room"),
            View::OpenSide => f.write_str("looking in through the open side"),
            View::CloseUp => {
                f.write_str("close to the largest triangle, as the whole is too thin to be seen")
            }
        }
    }
}

/// What a chosen camera leaves out of view.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct LeftOut {
    /// Flat grounds, ceilings and backdrops.
    pub sheets: u32,
    /// Spheres that are grounds or skies.
    pub skies: u32,
    /// Whether something lies far away from the rest.
    pub far: bool,
}

impl fmt::Display for LeftOut {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let count = |n: u32, name: &str| match n {
            0 => None,
            1 => Some(format!("1 {name}")),
            _ => Some(format!("{n} {name}s")),
        };
        let parts = [
            count(self.sheets, "ground or backdrop"),
            count(self.skies, "sphere around it"),
            self.far.then(|| "what is far from the rest".to_owned()),
        ];
        match parts.into_iter().flatten().collect::<Vec<_>>() {
            parts if parts.is_empty() => Ok(()),
            parts => write!(f, "; not framed: {}", parts.join(", ")),
        }
    }
}

/// A camera and what is to be said about it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Framing {
    pub(super) camera: Camera,
    pub(super) view: View,
    pub(super) left_out: LeftOut,
    /// How many frames of an animation it shows.
    pub(super) frames: u32,
}

/// The way from a subject to its camera.
#[derive(Clone, Copy)]
struct Side {
    to_eye: Vec3d,
    name: &'static str,
}

/// Half the picture's sides on the plane at distance 1.
#[derive(Clone, Copy)]
pub(super) struct HalfSides {
    pub(super) width: f64,
    pub(super) height: f64,
}

/// The camera of a scene. `half` is that of the default field of view.
pub(super) fn frame(surfaces: &Surfaces, motion: &Motion, half: HalfSides) -> Framing {
    let everything = Subject::default();
    let all = everything.bounds(surfaces);
    let room = Room::find(surfaces, &all);
    if let Some(Room::Closed { eye, look_at }) = room {
        let camera = Camera { fov_x_degrees: ROOM_FOV_DEGREES, ..looking(eye, look_at) };
        return Framing { camera, view: View::Inside, left_out: LeftOut::default(), frames: 1 };
    }
    if let Some(Room::Open { axis, is_up }) = room {
        let mut to_eye = [0.0; 3];
        to_eye[axis] = if is_up { 1.0 } else { -1.0 };
        if axis == 1 {
            to_eye[2] = 0.6;
        }
        let (moved, frames) = moved(motion, &everything, surfaces);
        let (eye, look_at) = fit(&everything, surfaces, &moved, unit(to_eye), half);
        let camera = looking(eye, look_at);
        return Framing { camera, view: View::OpenSide, left_out: LeftOut::default(), frames };
    }
    let subject = Subject::find(surfaces);
    let left_out = LeftOut {
        sheets: subject.sheets.len() as u32,
        skies: subject.skies.len() as u32,
        far: subject.within.is_some(),
    };
    let (moved, frames) = moved(motion, &subject, surfaces);
    let still = outside(&subject, surfaces, &[], half);
    if let Some((eye, look_at)) = close_up(&subject, surfaces, still.0, half) {
        return Framing { camera: looking(eye, look_at), view: View::CloseUp, left_out, frames: 1 };
    }
    let (eye, look_at, side) =
        if moved.is_empty() { still } else { outside(&subject, surfaces, &moved, half) };
    Framing { camera: looking(eye, look_at), view: View::Outside { side: side.name }, left_out, frames }
}

/// The corners of what moves in other frames, and how many frames there are. None where what is seen in the first frame would be
/// too small among them.
fn moved(motion: &Motion, subject: &Subject, surfaces: &Surfaces) -> (Vec<Vec3d>, u32) {
    let points = motion.points(subject);
    let longest = |bounds: Box3| bounds.size().into_iter().fold(0.0, f64::max);
    let mut all = subject.bounds(surfaces);
    let first = longest(all);
    points.iter().for_each(|&p| all.include(p));
    match first > 0.0 && first < LEAST_OF_MOTION * longest(all) {
        true => (Vec::new(), 1),
        false => (points, motion.frames),
    }
}

fn looking(eye: Vec3d, look_at: Vec3d) -> Camera {
    // Both are rounded: the way from the one to the other is kept instead of a point, where that would be lost.
    let direction = single(unit(sub(look_at, eye)));
    Camera { position: single(eye), direction, ..Camera::default() }
}

/// Of the sides that suit the first from which enough is seen.
fn outside(subject: &Subject, surfaces: &Surfaces, moved: &[Vec3d], half: HalfSides) -> (Vec3d, Vec3d, Side) {
    let sides = sides(subject, surfaces);
    let views: Vec<_> =
        sides.iter().map(|&side| (fit(subject, surfaces, moved, side.to_eye, half), side)).collect();
    let middle = subject.bounds(surfaces).center();
    let mut areas = vec![0.0; views.len()];
    subject.each(surfaces, |part| match part {
        Part::Triangle(t) => {
            let normal = area_vector(t);
            for (area, side) in areas.iter_mut().zip(&sides) {
                *area += 0.5 * dot(normal, side.to_eye).abs();
            }
        }
        Part::Sphere(_, r) => areas.iter_mut().for_each(|area| *area += std::f64::consts::PI * r * r),
    });
    let clear: Vec<bool> = views.iter().map(|((eye, _), _)| subject.is_seen(middle, *eye)).collect();
    let any_clear = clear.iter().any(|&c| c);
    let suits = |n: &usize| clear[*n] || !any_clear;
    let most = (0..views.len()).filter(suits).map(|n| areas[n]).fold(0.0, f64::max);
    let chosen = (0..views.len()).filter(suits).find(|&n| areas[n] >= 0.5 * most).unwrap_or(0);
    let ((eye, look_at), side) = views[chosen];
    (eye, look_at, side)
}

/// Ways to the camera, the best first.
fn sides(subject: &Subject, surfaces: &Surfaces) -> Vec<Side> {
    let size = subject.bounds(surfaces).size();
    // Along each axis: how much the surfaces face up it and either way.
    let (mut facing, mut across) = ([0.0; 3], [0.0; 3]);
    subject.each(surfaces, |part| {
        if let Part::Triangle(t) = part {
            let normal = area_vector(t);
            (0..3).for_each(|k| facing[k] += normal[k]);
            (0..3).for_each(|k| across[k] += normal[k].abs());
        }
    });
    // Reliefs and single triangles have a front; closed bodies have none.
    let sign = |axis: usize| if facing[axis] < -0.5 * across[axis] { -1.0 } else { 1.0 };
    let front = if size[0] >= 0.6 * size[2] { 2 } else { 0 };
    let flipped = sign(front);
    let (other, is_z) = (2 - front, front == 2);
    let ways = [(front, flipped), (other, sign(other)), (front, -flipped), (other, -sign(other))];
    let depth = |axis: usize| size[axis] / size[1].max(size[2 - axis]).max(f64::MIN_POSITIVE);
    let height = size[1] / size[0].max(size[2]).max(f64::MIN_POSITIVE);
    let mut sides = Vec::new();
    for (axis, sign) in ways {
        // Plates are seen straight, bodies turned a little; what lies flat from further above.
        let body = ((depth(axis) - 0.12) / 0.3).clamp(0.0, 1.0);
        let lying = ((0.35 - height) / 0.3).clamp(0.0, 1.0);
        let up = 0.36 * body + 0.75 * lying * body;
        let way = |turn: f64, up: f64| {
            let mut way = [0.0, up, 0.0];
            (way[axis], way[2 - axis]) = (sign, turn * if is_z { 1.0 } else { -sign });
            unit(way)
        };
        let name = |up: f64| match (axis, sign > 0.0, up > 0.0) {
            (2, true, true) => "above the front (+z)",
            (2, true, false) => "the front (+z)",
            (2, false, true) => "above the back (-z)",
            (2, false, false) => "the back (-z)",
            (_, true, true) => "above the right (+x)",
            (_, true, false) => "the right (+x)",
            (_, false, true) => "above the left (-x)",
            (_, false, false) => "the left (-x)",
        };
        let below = "below";
        sides.push(Side { to_eye: way(0.32 * body, up), name: name(up) });
        sides.push(Side { to_eye: way(0.32 * body, 1.1), name: name(1.1) });
        sides.push(Side { to_eye: way(0.0, 0.0), name: name(0.0) });
        sides.push(Side { to_eye: way(0.32 * body, -0.36), name: below });
        sides.push(Side { to_eye: way(0.32 * body, -1.1), name: below });
    }
    // A steeper or another side comes after all sides from which one looks by itself.
    sides.sort_by_key(|side| side.name == "below");
    sides
}

/// The nearest camera in this direction that sees all of the subject and these points, and what it looks at.
///
/// With X to the right, Y up and Z towards the camera, a point is in the picture where |X - eye X| <= width (eye Z - Z),
/// and the same for Y. So the eye's X and Z follow from the largest X + width Z and -X + width Z.
fn fit(
    subject: &Subject,
    surfaces: &Surfaces,
    moved: &[Vec3d],
    to_eye: Vec3d,
    half: HalfSides,
) -> (Vec3d, Vec3d) {
    let right = unit(cross([0.0, 1.0, 0.0], to_eye));
    let up = cross(to_eye, right);
    let (w, h) = (half.width / MARGIN, half.height / MARGIN);
    let origin = subject.bounds(surfaces);
    let origin = if origin.is_empty() { [0.0; 3] } else { origin.center() };
    let (sphere_w, sphere_h) = (sqrt64(1.0 + w * w), sqrt64(1.0 + h * h));
    let mut most = [f64::NEG_INFINITY; 4];
    let mut nearest = f64::NEG_INFINITY;
    let mut take = |p: Vec3d, radius: f64| {
        let p = sub(p, origin);
        let (x, y, z) = (dot(p, right), dot(p, up), dot(p, to_eye));
        let bounds = [
            x + w * z + radius * sphere_w,
            -x + w * z + radius * sphere_w,
            y + h * z + radius * sphere_h,
            -y + h * z + radius * sphere_h,
        ];
        (0..4).for_each(|k| most[k] = most[k].max(bounds[k]));
        nearest = nearest.max(z + radius);
    };
    subject.each(surfaces, |part| match part {
        Part::Triangle(t) => t.iter().for_each(|&p| take(p, 0.0)),
        Part::Sphere(center, radius) => take(center, radius),
    });
    moved.iter().for_each(|&p| take(p, 0.0));
    if nearest == f64::NEG_INFINITY {
        return (scale(to_eye, 1.0), origin);
    }
    let mut z = (0.5 * (most[0] + most[1]) / w).max(0.5 * (most[2] + most[3]) / h);
    // What has no size, or none that single precision knows here, is looked at from some way off.
    let least = origin.iter().fold(0.0f64, |m, x| m.max(x.abs())) * 1e-6;
    if z - nearest <= least {
        z = nearest + if least > 0.0 { least } else { 1.0 };
    }
    let (x, y) = (0.5 * (most[0] - most[1]), 0.5 * (most[2] - most[3]));
    let axis = add(origin, add(scale(right, x), scale(up, y)));
    (add(axis, scale(to_eye, z)), axis)
}

/// Where the surfaces are too thin to be seen from `eye`: a camera before the largest triangle.
fn close_up(subject: &Subject, surfaces: &Surfaces, eye: Vec3d, half: HalfSides) -> Option<(Vec3d, Vec3d)> {
    let mut largest: Option<(f64, [Vec3d; 3])> = None;
    let mut covered = 0.0;
    subject.each(surfaces, |part| match part {
        Part::Triangle(t) => {
            let (normal, way) = (area_vector(t), sub(eye, t[0]));
            let distance_squared = dot(way, way);
            covered += 0.5 * dot(normal, way).abs() / (distance_squared * sqrt64(distance_squared));
            let area = length(normal);
            if largest.is_none_or(|(most, _)| area > most) {
                largest = Some((area, *t));
            }
        }
        Part::Sphere(c, r) => covered += r * r / dot(sub(eye, c), sub(eye, c)),
    });
    let (area, t) = largest?;
    if covered >= LEAST_COVERAGE * 4.0 * half.width * half.height {
        return None;
    }
    let longest = (0..3).map(|k| length(sub(t[(k + 1) % 3], t[k]))).fold(0.0, f64::max);
    let middle = scale(add(t[0], add(t[1], t[2])), 1.0 / 3.0);
    // Its height is a sixth of the picture's, or what single precision can tell apart.
    let height = (area / longest).max(middle.iter().fold(0.0f64, |m, x| m.max(x.abs())) * 1e-5);
    let mut to_eye = unit(area_vector(&t));
    if dot(to_eye, sub(eye, middle)) < 0.0 {
        to_eye = scale(to_eye, -1.0);
    }
    // The camera's up is +y.
    if to_eye[1].abs() > 0.99 {
        to_eye = unit(add(to_eye, [0.0, 0.0, 0.3]));
    }
    Some((add(middle, scale(to_eye, 3.0 * height / half.height)), middle))
}
