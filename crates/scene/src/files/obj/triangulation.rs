//! Polygons → triangles.
//!
//! Readers make a fan of every face. Here the fans of concave faces are replaced by ears (Meisters 1975, "Polygons have
//! ears"). Either way n corners give n - 2 triangles.
//!
//! Both rest on one fact. However a polygon is cut by diagonals, the windings of its triangles about any point add up
//! to the polygon's own. So if no triangle turns against a simple polygon, together they cover its inside once and
//! nothing else.

use super::chunk::{Corner, corner, triangle};
use crate::files::face_ranges::Polygon;
use crate::model::Triangle;
use eosphor_core::math::Vec3;
use rayon::prelude::*;

/// Faces of more corners stay fans: cutting ears takes time by the square of their number.
const MAX_CORNERS: usize = 4096;

/// Corners that are looked at for each corner of a polygon before it is given up. Most polygons need fewer than they
/// have corners; without a bound, files made for it would take time by the cube of that number.
const MAX_LOOKS: usize = 8192;

/// Polygons that a thread takes at once.
const BLOCK: usize = 1024;

/// Replaces the fans of polygons that a fan does not cover.
pub(super) fn triangulate(polygons: &[Polygon], positions: &[Vec3], triangles: &mut [Triangle]) {
    // Polygons are in the order of their triangles: blocks of them own runs of triangles.
    let mut blocks = Vec::with_capacity(polygons.len() / BLOCK + 1);
    let (mut rest, mut start) = (triangles, 0);
    for block in polygons.chunks(BLOCK) {
        let last = block[block.len() - 1];
        let end = (last.first_triangle + last.triangles) as usize;
        let (run, after) = rest.split_at_mut(end - start);
        blocks.push((block, run, start));
        (rest, start) = (after, end);
    }
    blocks.into_par_iter().for_each(|(block, run, start)| {
        let mut cutter = Cutter::default();
        for polygon in block {
            let first = polygon.first_triangle as usize - start;
            cutter.cut(&mut run[first..first + polygon.triangles as usize], positions);
        }
    });
}

/// A point of the plane that a polygon is seen in.
type Point = [f64; 2];

/// Twice the area of a triangle, positive where it runs counter-clockwise.
fn area([a, b, c]: [Point; 3]) -> f64 {
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
}

/// Scratch for one polygon at a time.
#[derive(Default)]
struct Cutter {
    corners: Vec<Corner>,
    /// Seen so that the polygon runs counter-clockwise.
    points: Vec<Point>,
    /// The corners that are left, as a ring.
    next: Vec<u32>,
    previous: Vec<u32>,
    /// Corners where the ring does not turn left; only these can keep another from being an ear.
    reflex: Vec<bool>,
    ears: Vec<[u32; 3]>,
    /// How many corners may still be looked at.
    looks: usize,
}

impl Cutter {
    /// Replaces the triangles of a fan where ears do better.
    fn cut(&mut self, fan: &mut [Triangle], positions: &[Vec3]) {
        if fan.len() + 2 > MAX_CORNERS {
            return;
        }
        self.corners.clear();
        self.corners.extend([corner(&fan[0], 0), corner(&fan[0], 1)]);
        self.corners.extend(fan.iter().map(|t| corner(t, 2)));
        if !self.project(positions) || self.is_fan() || !self.cut_ears() {
            return;
        }
        let material = fan[0].material;
        for (t, ear) in fan.iter_mut().zip(&self.ears) {
            *t = triangle(ear.map(|i| self.corners[i as usize]), material);
        }
    }

    /// Sees the polygon along the axis that it faces most; false where it has no area.
    fn project(&mut self, positions: &[Vec3]) -> bool {
        let double = |c: &Corner| {
            let p = positions[c.position as usize];
            [f64::from(p.x), f64::from(p.y), f64::from(p.z)]
        };
        // Taken from the first corner, small polygons far from the origin keep their digits.
        let origin = double(&self.corners[0]);
        let local = |c: &Corner| {
            let p = double(c);
            [p[0] - origin[0], p[1] - origin[1], p[2] - origin[2]]
        };
        // Newell's normal: sums the edges' cross products.
        let mut normal = [0.0; 3];
        let mut a = local(&self.corners[self.corners.len() - 1]);
        for c in &self.corners {
            let b = local(c);
            for (axis, n) in normal.iter_mut().enumerate() {
                let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
                *n += a[u] * b[v] - a[v] * b[u];
            }
            a = b;
        }
        let largest = |best: usize, axis| {
            if normal[axis] * normal[axis] > normal[best] * normal[best] { axis } else { best }
        };
        let axis = [1, 2].into_iter().fold(0, largest);
        let (u, v) = match normal[axis] {
            n if n > 0.0 => ((axis + 1) % 3, (axis + 2) % 3),
            n if n < 0.0 => ((axis + 2) % 3, (axis + 1) % 3),
            _ => return false,
        };
        self.points.clear();
        self.points.extend(self.corners.iter().map(|c| {
            let p = local(c);
            [p[u], p[v]]
        }));
        true
    }

    /// Whether the fan covers the polygon: none of its triangles runs clockwise.
    fn is_fan(&self) -> bool {
        let first = self.points[0];
        self.points[1..].windows(2).all(|pair| area([first, pair[0], pair[1]]) >= 0.0)
    }

    /// Cuts ears until one triangle is left; false where there comes a polygon without ears, as crossing edges make it.
    fn cut_ears(&mut self) -> bool {
        let n = self.points.len() as u32;
        self.next.clear();
        self.next.extend((1..n).chain([0]));
        self.previous.clear();
        self.previous.extend([n - 1].into_iter().chain(0..n - 1));
        self.reflex.clear();
        self.reflex.resize(n as usize, false);
        for i in 0..n {
            self.reflex[i as usize] = self.turn(i) <= 0.0;
        }
        self.ears.clear();
        self.looks = MAX_LOOKS * self.points.len();
        let (mut tip, mut left, mut tried) = (0, n, 0);
        // Corners on straight edges give triangles without area: they are taken when there is nothing else.
        let mut allow_flat = false;
        while left > 3 {
            if self.looks == 0 {
                return false;
            }
            if self.is_ear(tip, allow_flat) {
                let (before, after) = (self.previous[tip as usize], self.next[tip as usize]);
                self.ears.push([before, tip, after]);
                self.next[before as usize] = after;
                self.previous[after as usize] = before;
                self.reflex[tip as usize] = false;
                for i in [before, after] {
                    self.reflex[i as usize] = self.turn(i) <= 0.0;
                }
                // Going on behind the cut keeps the ears from gathering round one corner.
                (tip, left, tried, allow_flat) = (after, left - 1, 0, false);
            } else {
                tried += 1;
                if tried == left {
                    if allow_flat {
                        return false;
                    }
                    (tried, allow_flat) = (0, true);
                }
            }
            tip = self.next[tip as usize];
        }
        let last = self.ring_triangle(tip);
        self.ears.push(last);
        area(last.map(|i| self.points[i as usize])) >= 0.0
    }

    fn ring_triangle(&self, tip: u32) -> [u32; 3] {
        [self.previous[tip as usize], tip, self.next[tip as usize]]
    }

    /// Twice the area of the triangle of a corner and its neighbours; positive where the ring turns left.
    fn turn(&self, tip: u32) -> f64 {
        area(self.ring_triangle(tip).map(|i| self.points[i as usize]))
    }

    /// Whether the corner's triangle can be cut off. Corners in the same place as one of its three do not hinder: rings
    /// around holes touch themselves.
    fn is_ear(&mut self, tip: u32, allow_flat: bool) -> bool {
        if self.reflex[tip as usize] {
            return allow_flat && self.turn(tip) == 0.0;
        }
        let [before, _, after] = self.ring_triangle(tip);
        let [a, b, c] = self.ring_triangle(tip).map(|i| self.points[i as usize]);
        let mut i = self.next[after as usize];
        while i != before {
            self.looks = self.looks.saturating_sub(1);
            if self.reflex[i as usize] {
                let p = self.points[i as usize];
                let is_inside = area([a, b, p]) >= 0.0 && area([b, c, p]) >= 0.0 && area([c, a, p]) >= 0.0;
                if is_inside && p != a && p != b && p != c {
                    return false;
                }
            }
            i = self.next[i as usize];
        }
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use eosphor_core::math::vec3;
    use proptest::prelude::*;

    /// Triangulates one polygon, whose corners are numbered.
    fn triangles(positions: &[Vec3]) -> Vec<[u32; 3]> {
        let c = |position: usize| Corner { position: position as u32, uv: 0, normal: 0 };
        let mut fan: Vec<Triangle> =
            (2..positions.len()).map(|i| triangle([c(0), c(i - 1), c(i)], 7)).collect();
        let polygon = Polygon { first_triangle: 0, triangles: fan.len() as u32 };
        triangulate(&[polygon], positions, &mut fan);
        assert!(fan.iter().all(|t| t.material == 7));
        fan.iter().map(|t| t.positions).collect()
    }

    /// Twice the areas along z.
    fn areas(positions: &[Vec3], triangles: &[[u32; 3]]) -> Vec<f64> {
        let flat = |i: u32| [f64::from(positions[i as usize].x), f64::from(positions[i as usize].y)];
        triangles.iter().map(|t| area(t.map(flat))).collect()
    }

    fn flat(points: &[[i32; 2]]) -> Vec<Vec3> {
        points.iter().map(|p| vec3(p[0] as f32, p[1] as f32, 0.0)).collect()
    }

    #[test]
    fn convex_polygons_stay_fans() {
        let square = flat(&[[0, 0], [1, 0], [1, 1], [0, 1]]);
        assert_eq!(triangles(&square), [[0, 1, 2], [0, 2, 3]]);
        let clockwise: Vec<Vec3> = square.iter().rev().copied().collect();
        assert_eq!(triangles(&clockwise), [[0, 1, 2], [0, 2, 3]]);
    }

    #[test]
    fn a_concave_quad_is_cut_at_its_dent() {
        // An arrow head whose dent is corner 1: the fan's first triangle would turn against it.
        let arrow = flat(&[[4, 0], [0, 1], [-4, 0], [0, 4]]);
        assert_eq!(triangles(&arrow), [[3, 0, 1], [1, 2, 3]]);
    }

    #[test]
    fn a_ring_around_a_hole_is_covered_once() {
        // A square with a square hole, joined by a bridge that is walked twice.
        let ring = flat(&[[0, 0], [6, 0], [6, 6], [0, 6], [0, 0], [2, 2], [2, 4], [4, 4], [4, 2], [2, 2]]);
        let cut = triangles(&ring);
        let areas = areas(&ring, &cut);
        assert_eq!(cut.len(), 8);
        assert!(areas.iter().all(|&a| a >= 0.0), "{areas:?}");
        assert_eq!(areas.iter().sum::<f64>(), 2.0 * (36.0 - 4.0));
    }

    #[test]
    fn hopeless_polygons_stay_fans() {
        let fan = |n: u32| (2..n).map(|i| [0, i - 1, i]).collect::<Vec<_>>();
        // No area; a bow tie of unequal loops, whose smaller loop turns the other way; too many corners.
        assert_eq!(triangles(&flat(&[[0, 0], [1, 0], [2, 0], [3, 0]])), fan(4));
        assert_eq!(triangles(&flat(&[[0, 0]; 5])), fan(5));
        assert_eq!(triangles(&flat(&[[0, 0], [3, 3], [3, 0], [0, 1]])).len(), 2);
        let comb: Vec<[i32; 2]> =
            (0..MAX_CORNERS as i32 + 1).map(|i| [i, i % 2]).chain([[5000, 9], [0, 9]]).collect();
        let comb = flat(&comb);
        assert_eq!(triangles(&comb), fan(comb.len() as u32));
    }

    #[test]
    fn large_polygons_are_cut_in_bounded_time() {
        // A comb: between its teeth, most corners that turn left are no ears.
        let teeth = 1000;
        let back = (0..teeth).rev().flat_map(|i| [[2 * i + 1, 100], [2 * i, 1]]);
        let comb: Vec<[i32; 2]> = [[0, 0], [2 * teeth, 0]].into_iter().chain(back).collect();
        let comb = flat(&comb);
        let areas = areas(&comb, &triangles(&comb));
        assert!(areas.iter().all(|&a| a >= 0.0));
        assert_eq!(areas.iter().sum::<f64>(), 201_999.0);
        // Points on a curve in a random order: there is nothing to be found, and the search ends.
        let tangle: Vec<[i32; 2]> = (0..4000).map(|i| i * 1571 % 4001).map(|i| [i, i * i % 4001]).collect();
        assert_eq!(triangles(&flat(&tangle)).len(), 3998);
    }

    /// A star-shaped polygon: corners at growing angles about a centre, at any distance. It is simple.
    fn star() -> impl Strategy<Value = Vec<Vec3>> {
        proptest::collection::vec(1..1000i32, 5..40).prop_map(|radii| {
            let n = radii.len() as f64;
            let at = |(i, &r): (usize, &i32)| {
                let angle = i as f64 / n * std::f64::consts::TAU;
                vec3((f64::from(r) * angle.cos()) as f32, (f64::from(r) * angle.sin()) as f32, 0.0)
            };
            radii.iter().enumerate().map(at).collect()
        })
    }

    proptest! {
        #[test]
        fn simple_polygons_are_covered_once(star in star(), turned in 0..3usize, shift in 0..40usize) {
            let n = star.len();
            let star: Vec<Vec3> = (0..n).map(|i| star[(i + shift) % n]).collect();
            let seen: Vec<Vec3> = star.iter().map(|p| match turned {
                0 => *p,
                1 => vec3(p.y, p.z, p.x),
                _ => vec3(p.z, p.x, p.y),
            }).collect();
            let cut = triangles(&seen);
            let areas = areas(&star, &cut);
            prop_assert_eq!(cut.len(), n - 2);
            prop_assert!(areas.iter().all(|&a| a >= 0.0), "{:?}", areas);
            let flat = |p: Vec3| [f64::from(p.x), f64::from(p.y)];
            let whole: f64 = (0..n).map(|i| area([[0.0; 2], flat(star[i]), flat(star[(i + 1) % n])])).sum();
            prop_assert!((areas.iter().sum::<f64>() - whole).abs() <= 1e-9 * whole, "{} {}", areas.iter().sum::<f64>(), whole);
        }
    }
}
