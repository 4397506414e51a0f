//! Random worlds that are hard on cells, and rays that are hard on hits.

use crate::support::{Random, World, affine};
use eosphor_core::geometry::Sphere;
use eosphor_core::math::{Affine, Vec3, vec3};
use eosphor_core::ray::Ray;

/// What the triangles of a world are like.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Kind {
    Soup,
    /// Corners on few planes: flat, coplanar, equal and degenerate things abound, and they lie between cells.
    OnPlanes,
    /// A tessellated square, flat across one axis.
    Flat,
    Slivers,
    /// Many times the same.
    Coincident,
    SpheresOnly,
    Mixed,
}

pub(crate) const KINDS: [Kind; 7] =
    [Kind::Soup, Kind::OnPlanes, Kind::Flat, Kind::Slivers, Kind::Coincident, Kind::SpheresOnly, Kind::Mixed];

/// Of a kind, about `count` primitives in the cube from -1 to 1.
pub(crate) fn primitives(kind: Kind, count: usize, random: &mut Random) -> (Vec<[Vec3; 3]>, Vec<Sphere>) {
    let mut triangles = Vec::new();
    let mut spheres = Vec::new();
    match kind {
        Kind::Soup => {
            let size = [0.05, 0.3, 1.5][random.below(3)];
            for _ in 0..count {
                let at = random.in_cube();
                triangles.push([0, 1, 2].map(|_| at + random.in_cube() * size));
            }
        }
        Kind::OnPlanes => {
            triangles.extend((0..count).map(|_| [0, 1, 2].map(|_| on_planes(random))));
        }
        Kind::Flat => {
            let n = ((count / 2) as f64).sqrt().max(1.0) as usize;
            let (axis, height) = (random.below(3), random.in_cube().x);
            let at = |i: usize, j: usize| {
                let [u, v] = [i, j].map(|k| k as f32 * 2.0 / n as f32 - 1.0);
                match axis {
                    0 => vec3(height, u, v),
                    1 => vec3(u, height, v),
                    _ => vec3(u, v, height),
                }
            };
            for (i, j) in (0..n).flat_map(|i| (0..n).map(move |j| (i, j))) {
                let corners = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
                triangles.push([corners[0], corners[1], corners[2]]);
                triangles.push([corners[0], corners[2], corners[3]]);
            }
        }
        Kind::Slivers => {
            for _ in 0..count {
                let (a, b, part) = (random.in_cube(), random.in_cube(), random.unit() as f32);
                let off = random.in_cube() * 10f32.powi(-2 - random.below(6) as i32);
                triangles.push([a, b, a + (b - a) * part + off]);
            }
        }
        Kind::Coincident => {
            let kinds: Vec<_> = (0..3).map(|_| [0, 1, 2].map(|_| random.in_cube())).collect();
            triangles.extend((0..count).map(|i| kinds[i * i % 3]));
            triangles.push([0, 1, 2].map(|_| on_planes(random)));
        }
        Kind::SpheresOnly => {
            for _ in 0..count {
                let radius = 10f32.powf(random.unit() as f32 * 3.0 - 3.0);
                spheres.push(Sphere { center: random.in_cube(), radius });
            }
        }
        Kind::Mixed => {
            for kind in [Kind::Soup, Kind::OnPlanes, Kind::Slivers, Kind::SpheresOnly] {
                let (t, s) = primitives(kind, count / 4, random);
                triangles.extend(t);
                spheres.extend(s);
            }
        }
    }
    (triangles, spheres)
}

/// A point with coordinates that are multiples of a quarter, where halving the unit cube puts planes.
fn on_planes(random: &mut Random) -> Vec3 {
    let mut part = || (random.below(9) as f32 - 4.0) * 0.25;
    vec3(part(), part(), part())
}

/// Scale, rotation and place of an instance.
pub(crate) fn placement(random: &mut Random) -> Affine {
    let mut scale = || [1.0, -1.0, 0.01, 0.4, 2.5][random.below(5)];
    let scale = vec3(scale(), scale(), scale());
    let mut angle = || [0.0, std::f64::consts::FRAC_PI_2, random.unit() * 6.0][random.below(3)];
    let angles = [angle(), angle(), angle()];
    affine(scale, angles, if random.below(2) == 0 { on_planes(random) } else { random.in_cube() })
}

/// A ray at a world in the cube about `offset`, `scale` times as large.
pub(crate) fn ray(world: &World, random: &mut Random, scale: f32, offset: Vec3) -> Ray {
    let put = |p: Vec3| p * scale + offset;
    let corners = match world.triangles.len() {
        0 => [0, 1, 2].map(|_| put(random.in_cube())),
        n => world.triangles[random.below(n)],
    };
    let [a, b, c] = [corners[0], corners[1], corners[2]];
    let (u, v) = (random.unit() as f32, random.unit() as f32);
    let on_edge = a + (b - a) * [0.5, u][random.below(2)];
    let inside = on_edge + (c - on_edge) * v;
    let axis = axis(random);
    let origin = match random.below(4) {
        0 => put(random.in_cube()),
        1 => put(on_planes(random)),
        2 => put(random.in_cube() * 3.0),
        _ => put(random.direction() * 10f32.powf(random.unit() as f32 * 4.0)),
    };
    let towards = |from: Vec3, to: Vec3| (to - from).normalize_or(vec3(0.0, -0.0, 1.0));
    let far = random.unit() as f32 * 3.0;
    let (origin, direction) = match random.below(13) {
        0 => (origin, random.direction()),
        1 => (origin, axis),
        2 => (origin, towards(origin, corners[random.below(3)])),
        3 => (origin, towards(origin, a + (b - a) * 0.5)),
        4 => (origin, towards(origin, on_edge)),
        5 => (origin, towards(origin, inside)),
        // In the triangle's plane, from outside and along an edge.
        6 => (a + (a - inside) * far, towards(a, inside)),
        7 => (a + (a - b) * far, towards(a, b)),
        // From the surface, and from a corner.
        8 => (inside, random.direction()),
        9 => (b, axis),
        // Along an axis, exactly at a corner or an edge.
        10 => (on_edge - axis * (far * scale), axis),
        // Along planes between cells, and nearly so.
        11 => (put(on_planes(random)), towards(on_planes(random), on_planes(random))),
        _ => (put(on_planes(random)), (axis + random.direction() * 1e-7).normalize()),
    };
    let t_max = if random.below(4) == 0 { far * scale } else { f32::INFINITY };
    let t_min = if random.below(8) == 0 { u * scale } else { 0.0 };
    Ray { origin, t_min, direction, t_max }
}

/// Along an axis, with zeros of both signs.
fn axis(random: &mut Random) -> Vec3 {
    let zero = || [0.0, -0.0];
    let (a, b) = (zero()[random.below(2)], zero()[random.below(2)]);
    let one = [1.0, -1.0][random.below(2)];
    [vec3(one, a, b), vec3(a, one, b), vec3(a, b, one)][random.below(3)]
}
