//! Rays whose exact line meets a given point of a mesh: all numbers are multiples of powers of two with few bits, and
//! whether a ray is exact is found by integers.

use crate::random::Random;
use crate::shapes::Closed;
use crate::vector::*;
use eosphor_accel::{Ray, Vec3, vec3};

/// A point or a direction in integers.
pub(crate) type Exact = [i128; 3];

fn minus(a: Exact, b: Exact) -> Exact {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

fn crossed(a: Exact, b: Exact) -> Exact {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

fn dotted(a: Exact, b: Exact) -> i128 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// Directions are integers over 2^`DIRECTION_BITS`.
const DIRECTION_BITS: u32 = 40;

/// A closed mesh whose vertices are multiples of 8 between -128 and 128.
pub(crate) struct Mesh {
    pub(crate) name: &'static str,
    pub(crate) vertices: Vec<Exact>,
    pub(crate) triangles: Vec<[usize; 3]>,
    /// Triangles at each vertex.
    around: Vec<Vec<usize>>,
    /// What is seen of it from the front is seen from outside.
    is_convex: bool,
}

impl Mesh {
    pub(crate) fn new(shape: &Closed) -> Mesh {
        let vertices = shape.positions.iter().map(|p| p.map(|x| 8 * (16.0 * x).round() as i128)).collect();
        let mut around = vec![Vec::new(); shape.positions.len()];
        for (number, triangle) in shape.triangles.iter().enumerate() {
            triangle.iter().for_each(|&v| around[v].push(number));
        }
        let is_convex = matches!(shape.name, "cube" | "blade");
        Mesh { name: shape.name, vertices, triangles: shape.triangles.clone(), around, is_convex }
    }

    pub(crate) fn corners(&self) -> Vec<[Vec3; 3]> {
        let point = |v: usize| single(self.vertices[v].map(|x| x as f64));
        self.triangles.iter().map(|t| t.map(point)).collect()
    }

    /// Twice the area of a triangle as a vector, times a direction: negative where it is seen from outside.
    fn facing(&self, triangle: usize, d: Exact) -> i128 {
        let [a, b, c] = self.triangles[triangle].map(|v| self.vertices[v]);
        dotted(crossed(minus(b, a), minus(c, a)), d)
    }

    /// A ray from outside that meets a vertex or a point of an edge, and the triangles there, all of which it crosses in the
    /// same way; how far `t` runs to it. `None` where the dice give none.
    pub(crate) fn aim(&self, random: &mut Random, far: bool) -> Option<Aimed> {
        let [a, b, c] = self.triangles[random.below(self.triangles.len())];
        let (target, there) = if random.below(3) == 0 {
            (self.vertices[a], self.around[a].clone())
        } else {
            let (from, to) = if random.below(2) == 0 { (a, b) } else { (b, c) };
            let eighths = random.below(7) as i128 + 1;
            let way = minus(self.vertices[to], self.vertices[from]);
            // Edges are multiples of 8 long along the axes.
            let target = [0, 1, 2].map(|i| self.vertices[from][i] + way[i] / 8 * eighths);
            (target, self.around[from].iter().copied().filter(|t| self.around[to].contains(t)).collect())
        };
        let (direction, t_bits) = direction(random, far);
        let seen = there.iter().map(|&t| self.facing(t, direction).signum());
        // Crossing it from outside: each of them is seen from its front.
        if there.len() < 2 || !seen.into_iter().all(|sign| sign < 0) {
            return None;
        }
        // The origin, in units of 2^-DIRECTION_BITS: the target less 2^t_bits of the direction.
        let origin = [0, 1, 2].map(|i| (target[i] << DIRECTION_BITS) - (direction[i] << t_bits));
        let origin = exact(origin, DIRECTION_BITS)?;
        let direction = exact(direction, DIRECTION_BITS)?;
        // Outside the mesh, which lies within 256 of 0.
        let outside = self.is_convex || length(double(origin)) > 256.0;
        outside.then_some(Aimed { ray: Ray::new(origin, direction), t: 2f32.powi(t_bits as i32), there })
    }

    /// Whether the exact line meets a triangle from its front. Its edges may be missed by [`WIDENED`]; one that is seen from
    /// behind may be touched at its edges.
    pub(crate) fn is_met(&self, triangle: usize, ray: &Ray) -> bool {
        let scale = |x: f32| (x as f64 * 2f64.powi(DIRECTION_BITS as i32)) as i128;
        let [o, d] = [ray.origin, ray.direction].map(|p| [scale(p.x), scale(p.y), scale(p.z)]);
        let d = reduced(d);
        let facing = self.facing(triangle, d);
        // How far within an edge the line passes: its moment about the edge over both lengths, in units of the origin.
        let within = |a: Exact, b: Exact| {
            let edge = reduced(minus(b, a));
            let moment = dotted(crossed(minus(a, o), edge), d) as f64 * facing.signum() as f64;
            moment / (length(edge.map(|x| x as f64)) * length(d.map(|x| x as f64)))
        };
        let [a, b, c] = self.triangles[triangle].map(|v| self.vertices[v].map(|x| x << DIRECTION_BITS));
        let least = within(a, b).min(within(b, c)).min(within(c, a)) / 2f64.powi(DIRECTION_BITS as i32);
        facing != 0 && least >= -WIDENED && (facing < 0 || least <= WIDENED)
    }
}

/// Triangles may be a little larger than they are, so that neighbours overlap: by 2^-20 of the mesh.
const WIDENED: f64 = 128.0 / 1_048_576.0;

/// A direction, and the power of two of `t` at which its ray meets the target.
fn direction(random: &mut Random, far: bool) -> (Exact, u32) {
    let one = 1i128 << DIRECTION_BITS;
    let few = |random: &mut Random, n: usize| random.below(2 * n + 1) as i128 - n as i128;
    if !far {
        // From 0.9 to 30 radii, at any angle.
        return ([0; 3].map(|_| few(random, 15) * (one >> 4)), 8 + random.below(5) as u32);
    }
    // From 10^3 to 2 10^6 radii (of 128): along axes and diagonals, tilted by as little as fits.
    let t_bits = 17 + random.below(12) as u32;
    let axis = random.below(3);
    let direction = [0, 1, 2].map(|i| {
        let tilt = few(random, 64) * (one >> t_bits);
        if i == axis || random.below(4) == 0 { one * (1 - 2 * random.below(2) as i128) } else { tilt }
    });
    (direction, t_bits)
}

/// Without the trailing zeros that all numbers share.
fn reduced(v: Exact) -> Exact {
    let zeros = v.iter().map(|x| x.trailing_zeros()).min().unwrap_or(0).min(120);
    v.map(|x| x >> zeros)
}

/// A vector of integers over 2^bits, if single precision holds it.
fn exact(v: Exact, bits: u32) -> Option<Vec3> {
    let [x, y, z] = v.map(|x| (x as f64 / 2f64.powi(bits as i32)) as f32);
    let back = [x, y, z].map(|x| (x as f64 * 2f64.powi(bits as i32)) as i128);
    (back == v).then_some(vec3(x, y, z))
}

pub(crate) struct Aimed {
    pub(crate) ray: Ray,
    /// Where it meets the target, exactly.
    pub(crate) t: f32,
    /// The triangles at the target.
    pub(crate) there: Vec<usize>,
}
