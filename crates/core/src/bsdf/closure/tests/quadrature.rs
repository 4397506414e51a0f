//! Integrals over the sphere of functions of a direction, in double precision.

use super::*;

/// A part of the sphere: of the angles of its directions to the normal, and of their turn about it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Cell {
    angle: [f64; 2],
    turn: [f64; 2],
}

/// Nodes and weights of Gauss and Legendre on -1 to 1.
const NODES: [(f64, f64); 5] = [
    (-0.906_179_845_938_664, 0.236_926_885_056_189_1),
    (-0.538_469_310_105_683_1, 0.478_628_670_499_366_5),
    (0.0, 0.568_888_888_888_888_9),
    (0.538_469_310_105_683_1, 0.478_628_670_499_366_5),
    (0.906_179_845_938_664, 0.236_926_885_056_189_1),
];

/// A cell is not halved more often than this.
const DEEPEST: u32 = 40;

fn halves([a, b]: [f64; 2]) -> [[f64; 2]; 2] {
    [[a, 0.5 * (a + b)], [0.5 * (a + b), b]]
}

impl Cell {
    /// The sphere in so many rows and columns. An even number of rows has a border at the horizon.
    pub(super) fn grid(rows: usize, columns: usize) -> Vec<Cell> {
        let part = |i: usize, count: usize, most: f64| [i, i + 1].map(|k| most * k as f64 / count as f64);
        let cell = |k: usize| Cell {
            angle: part(k / columns, rows, std::f64::consts::PI),
            turn: part(k % columns, columns, std::f64::consts::TAU),
        };
        (0..rows * columns).map(cell).collect()
    }

    fn halves_of_angle(self) -> [Cell; 2] {
        halves(self.angle).map(|angle| Cell { angle, ..self })
    }

    fn halves_of_turn(self) -> [Cell; 2] {
        halves(self.turn).map(|turn| Cell { turn, ..self })
    }

    pub(super) fn quarters(self) -> [Cell; 4] {
        let [upper, lower] = self.halves_of_angle().map(Cell::halves_of_turn);
        [upper[0], upper[1], lower[0], lower[1]]
    }

    pub(super) fn contains(&self, d: Vec3) -> bool {
        let (x, y, z) = (f64::from(d.x), f64::from(d.y), f64::from(d.z));
        let turn = y.atan2(x).rem_euclid(std::f64::consts::TAU);
        let is_in = |x: f64, [a, b]: [f64; 2], end: f64| x >= a && (x < b || b >= end);
        is_in(x.hypot(y).atan2(z), self.angle, std::f64::consts::PI)
            && is_in(turn, self.turn, std::f64::consts::TAU)
    }

    /// By one rule for all of the cell.
    fn rough(&self, f: &impl Fn(Vec3) -> f64) -> f64 {
        let at = |[a, b]: [f64; 2], x: f64| 0.5 * ((a + b) + (b - a) * x);
        let turns = NODES.map(|(x, weight)| (at(self.turn, x).sin_cos(), weight));
        let mut sum = 0.0;
        for (x, weight) in NODES {
            let (sine, z) = at(self.angle, x).sin_cos();
            for ((s, c), weight_of_turn) in turns {
                let d = vec3((sine * c) as f32, (sine * s) as f32, z as f32);
                sum += sine * weight * weight_of_turn * f(d);
            }
        }
        0.25 * (self.angle[1] - self.angle[0]) * (self.turn[1] - self.turn[0]) * sum
    }

    /// The integral of `f`; parts are halved until that makes no difference of `error` any more.
    pub(super) fn integral(&self, f: &impl Fn(Vec3) -> f64, error: f64) -> f64 {
        self.refined(f, self.rough(f), error, DEEPEST)
    }

    /// Halved the way that makes more difference.
    fn refined(&self, f: &impl Fn(Vec3) -> f64, rough: f64, error: f64, left: u32) -> f64 {
        let estimated = |cells: [Cell; 2]| cells.map(|cell| (cell, cell.rough(f)));
        let ways = [estimated(self.halves_of_angle()), estimated(self.halves_of_turn())];
        let [by_angle, by_turn] = [0, 1].map(|way: usize| (ways[way][0].1 + ways[way][1].1 - rough).abs());
        let way = ways[usize::from(by_turn > by_angle)];
        if left == 0 || by_angle.max(by_turn) < error {
            return way[0].1 + way[1].1;
        }
        way.iter().map(|(cell, part)| cell.refined(f, *part, error, left - 1)).sum()
    }
}

#[test]
fn quadrature_gives_what_is_known() {
    let whole = |f: &dyn Fn(Vec3) -> f64| -> f64 {
        Cell::grid(2, 2).iter().map(|cell| cell.integral(&f, 1e-8)).sum()
    };
    let pi = std::f64::consts::PI;
    let upper_cosine = whole(&|d| f64::from(d.z).max(0.0));
    assert!((upper_cosine - pi).abs() < 1e-6, "{upper_cosine}");
    // A cap whose edge no cell follows, about an axis of its own: 2 pi (1 - cos).
    let axis = viewer(0.3);
    let cap = whole(&|d| if d.dot(axis) > 0.9 { 1.0 } else { 0.0 });
    assert!((cap - 0.2 * pi).abs() < 1e-4, "{cap}");
    assert!(Cell::grid(4, 8).iter().filter(|cell| cell.contains(axis)).count() == 1);
}
