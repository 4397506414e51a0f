//! Closed meshes, counter-clockwise from outside.

use crate::vector::*;
use std::collections::HashMap;

pub(crate) struct Closed {
    pub(crate) name: &'static str,
    pub(crate) positions: Vec<V>,
    pub(crate) triangles: Vec<[usize; 3]>,
}

impl Closed {
    /// Moved and scaled.
    pub(crate) fn mapped(mut self, map: impl Fn(V) -> V) -> Closed {
        self.positions.iter_mut().for_each(|p| *p = map(*p));
        self
    }

    pub(crate) fn corners(&self) -> impl Iterator<Item = [V; 3]> {
        self.triangles.iter().map(|t| t.map(|v| self.positions[v]))
    }
}

/// Of radius 1.
pub(crate) fn icosphere(levels: u32) -> Closed {
    let g = (1.0 + 5f64.sqrt()) / 2.0;
    let mut positions: Vec<V> = Vec::new();
    for (a, b) in [(1.0, g), (-1.0, g), (1.0, -g), (-1.0, -g)] {
        positions.extend([[0.0, a, b], [a, b, 0.0], [b, 0.0, a]].map(unit));
    }
    let edge = 2.0 / (1.0 + g * g).sqrt();
    let near = |i: usize, j: usize| length(sub(positions[i], positions[j])) < edge * 1.01;
    let mut triangles = Vec::new();
    for i in 0..12 {
        for j in (i + 1..12).filter(|&j| near(i, j)) {
            for k in (j + 1..12).filter(|&k| near(i, k) && near(j, k)) {
                let [a, b, c] = [i, j, k].map(|v| positions[v]);
                let outward = dot(cross(sub(b, a), sub(c, a)), a) > 0.0;
                triangles.push(if outward { [i, j, k] } else { [i, k, j] });
            }
        }
    }
    for _ in 0..levels {
        let mut middles = HashMap::new();
        let mut middle = |a: usize, b: usize| {
            *middles.entry((a.min(b), a.max(b))).or_insert_with(|| {
                positions.push(unit(add(positions[a], positions[b])));
                positions.len() - 1
            })
        };
        triangles = triangles
            .iter()
            .flat_map(|&[a, b, c]| {
                let [ab, bc, ca] = [(a, b), (b, c), (c, a)].map(|(x, y)| middle(x, y));
                [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
            })
            .collect();
    }
    Closed { name: "icosphere", positions, triangles }
}

/// About the y axis, of radius 0.7 to the middle of a tube of 0.3.
pub(crate) fn torus(around: usize, across: usize) -> Closed {
    let turn = |k: usize, n: usize| k as f64 / n as f64 * std::f64::consts::TAU;
    let point = |i: usize, j: usize| {
        let (p, q) = (turn(i, around), turn(j, across));
        let ring = 0.7 + 0.3 * q.cos();
        [ring * p.cos(), 0.3 * q.sin(), -ring * p.sin()]
    };
    let positions = (0..around * across).map(|k| point(k / across, k % across)).collect();
    let quad = |k: usize| {
        let at = |i: usize, j: usize| (k / across + i) % around * across + (k % across + j) % across;
        [[at(0, 0), at(1, 0), at(1, 1)], [at(0, 0), at(1, 1), at(0, 1)]]
    };
    Closed { name: "torus", positions, triangles: (0..around * across).flat_map(quad).collect() }
}

/// From -1 to 1.
pub(crate) fn cube() -> Closed {
    let sign = |i: usize, bit: usize| if i & bit == 0 { -1.0 } else { 1.0 };
    let positions = (0..8).map(|i| [sign(i, 1), sign(i, 2), sign(i, 4)]).collect();
    let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let triangles = quads.iter().flat_map(|q| [[q[0], q[1], q[2]], [q[0], q[2], q[3]]]).collect();
    Closed { name: "cube", positions, triangles }
}

/// A cube that is stretched into long thin triangles.
pub(crate) fn blade() -> Closed {
    Closed { name: "blade", ..cube().mapped(|p| [p[0], p[1] / 128.0, p[2] / 4.0]) }
}
