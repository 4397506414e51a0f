//! The surface where a field of numbers is 0, as a closed mesh: marching tetrahedra over a grid.

use crate::model::{Mesh, NO_INDEX, Triangle};
use eosphor_core::math::Vec3;
use std::collections::HashMap;

/// Vertices stay this share of an edge of the grid from its ends, so that no triangle is without area.
const APART: f32 = 0.05;

/// Corners of a cube, each a sum of the axes of its bits (x 1, y 2, z 4), of six tetrahedra of the same handedness that fill it.
/// They share the diagonal from corner 0 to corner 7, so those of neighbouring cubes meet in whole sides.
const TETRAHEDRA: [[u32; 4]; 6] =
    [[0, 1, 3, 7], [0, 5, 1, 7], [0, 3, 2, 7], [0, 2, 6, 7], [0, 4, 5, 7], [0, 6, 4, 7]];

/// The grid that a field is looked at on.
pub(super) struct Grid {
    /// Its lowest corner.
    pub(super) corner: Vec3,
    /// Length of the edges of its cubes.
    pub(super) edge: f32,
    /// Cubes along x, y and z.
    pub(super) cubes: [u32; 3],
}

impl Grid {
    fn corners(&self, axis: usize) -> u32 {
        self.cubes[axis] + 1
    }

    fn number(&self, [x, y, z]: [u32; 3]) -> u32 {
        (z * self.corners(1) + y) * self.corners(0) + x
    }

    fn point(&self, number: u32) -> Vec3 {
        let (x, rest) = (number % self.corners(0), number / self.corners(0));
        let (y, z) = (rest % self.corners(1), rest / self.corners(1));
        self.corner + Vec3::from([x, y, z].map(|steps| steps as f32)) * self.edge
    }
}

/// The surface of what has a field below 0. The grid has to be larger than that. Seen from outside, triangles are
/// counter-clockwise.
pub(super) fn surface(name: &str, grid: &Grid, field: impl Fn(Vec3) -> f32, material: u32) -> Mesh {
    let count = grid.corners(0) * grid.corners(1) * grid.corners(2);
    let values: Vec<f32> = (0..count).map(|number| field(grid.point(number))).collect();
    let mut march = March { grid, values: &values, vertices: HashMap::new(), positions: Vec::new() };
    let mut triangles = Vec::new();
    for z in 0..grid.cubes[2] {
        for y in 0..grid.cubes[1] {
            for x in 0..grid.cubes[0] {
                let corner = |bits: u32| grid.number([x + (bits & 1), y + (bits >> 1 & 1), z + (bits >> 2)]);
                for tetrahedron in TETRAHEDRA {
                    march.tetrahedron(tetrahedron.map(corner), &mut triangles);
                }
            }
        }
    }
    let positions = march.positions;
    // Where the field grows fastest.
    let step = grid.edge * 0.5;
    let normal = |&p: &Vec3| {
        let slope = |axis: [f32; 3]| field(p + Vec3::from(axis) * step) - field(p - Vec3::from(axis) * step);
        Vec3::from([slope([1.0, 0.0, 0.0]), slope([0.0, 1.0, 0.0]), slope([0.0, 0.0, 1.0])])
    };
    let normals = positions.iter().map(normal).collect();
    let triangle = |corners| Triangle { positions: corners, normals: corners, uvs: [NO_INDEX; 3], material };
    let triangles = triangles.into_iter().map(triangle).collect();
    Mesh { name: name.into(), positions, normals, triangles, ..Mesh::default() }
}

struct March<'a> {
    grid: &'a Grid,
    values: &'a [f32],
    /// By the corners of the edge that they are on.
    vertices: HashMap<(u32, u32), u32>,
    positions: Vec<Vec3>,
}

impl March<'_> {
    /// Adds the triangles of a tetrahedron whose last corner is on the left of the others: one around a corner that is alone
    /// inside or outside, two between pairs of corners.
    fn tetrahedron(&mut self, corners: [u32; 4], triangles: &mut Vec<[u32; 3]>) {
        let inside = corners.map(|corner| self.values[corner as usize] < 0.0);
        let bits = inside.iter().rev().fold(0, |bits, &inside| bits << 1 | usize::from(inside));
        // Even orders of the corners keep the handedness: the ones inside first, or, where three are, the one outside.
        let order = match bits {
            0b0001 | 0b1110 => [0, 1, 2, 3],
            0b0010 | 0b1101 => [1, 0, 3, 2],
            0b0100 | 0b1011 => [2, 3, 0, 1],
            0b1000 | 0b0111 => [3, 2, 1, 0],
            0b0011 => [0, 1, 2, 3],
            0b0101 => [0, 2, 3, 1],
            0b1001 => [0, 3, 1, 2],
            0b0110 => [1, 2, 0, 3],
            0b1010 => [1, 3, 2, 0],
            0b1100 => [2, 3, 0, 1],
            _ => return,
        };
        let [i, j, k, l] = order.map(|number: usize| corners[number]);
        match bits.count_ones() {
            2 => {
                let quad = [self.vertex(i, k), self.vertex(i, l), self.vertex(j, l), self.vertex(j, k)];
                triangles.extend([[quad[0], quad[1], quad[2]], [quad[0], quad[2], quad[3]]]);
            }
            1 => triangles.push([self.vertex(i, j), self.vertex(i, k), self.vertex(i, l)]),
            _ => triangles.push([self.vertex(i, j), self.vertex(i, l), self.vertex(i, k)]),
        }
    }

    /// The vertex on an edge of the grid, the same for all that share it.
    fn vertex(&mut self, a: u32, b: u32) -> u32 {
        let (a, b) = (a.min(b), a.max(b));
        *self.vertices.entry((a, b)).or_insert_with(|| {
            let (at_a, at_b) = (self.values[a as usize], self.values[b as usize]);
            let along = (at_a / (at_a - at_b)).clamp(APART, 1.0 - APART);
            let (from, to) = (self.grid.point(a), self.grid.point(b));
            self.positions.push(from + (to - from) * along);
            self.positions.len() as u32 - 1
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use eosphor_core::math::vec3;

    fn ball() -> Mesh {
        let grid = Grid { corner: Vec3::splat(-1.2), edge: 0.1, cubes: [24; 3] };
        surface("ball", &grid, |p| p.length() - 1.0, 0)
    }

    #[test]
    fn every_edge_has_two_triangles_that_run_along_it_in_turn() {
        let mut edges = HashMap::new();
        for triangle in ball().triangles {
            let [a, b, c] = triangle.positions;
            for edge in [(a, b), (b, c), (c, a)] {
                assert!(edges.insert(edge, ()).is_none(), "{edge:?} twice");
            }
        }
        assert!(edges.len() > 3000 && edges.keys().all(|&(a, b)| edges.contains_key(&(b, a))));
    }

    #[test]
    fn it_is_the_ball() {
        let mesh = ball();
        let mut volume = 0.0;
        for triangle in &mesh.triangles {
            let [a, b, c] = triangle.positions.map(|number| mesh.positions[number as usize]);
            volume += a.cross(b).dot(c) / 6.0;
        }
        // Positive: seen from outside they are counter-clockwise.
        assert!((volume / (4.0 / 3.0 * std::f32::consts::PI) - 1.0).abs() < 0.02, "{volume}");
        for (position, normal) in mesh.positions.iter().zip(&mesh.normals) {
            assert!((position.length() - 1.0).abs() < 0.01);
            assert!(normal.normalize_or(vec3(0.0, 0.0, 1.0)).dot(position.normalize()) > 0.999);
        }
    }
}
