//! What reaches into a cell. In double precision: corners of cells are sums of halves, and exact.

use eosphor_core::geometry::Bounds;
use eosphor_core::intersect::PackedTriangle;
use eosphor_core::math::Vec3;

/// A cell by its centre and half its size.
#[derive(Clone, Copy, Debug)]
pub(super) struct Cell {
    pub(super) center: [f64; 3],
    pub(super) half: [f64; 3],
}

fn wide(v: Vec3) -> [f64; 3] {
    [v.x as f64, v.y as f64, v.z as f64]
}

impl Cell {
    pub(super) fn of(bounds: &Bounds) -> Cell {
        let (low, high) = (wide(bounds.min), wide(bounds.max));
        Cell {
            center: [0, 1, 2].map(|k| (low[k] + high[k]) * 0.5),
            half: [0, 1, 2].map(|k| (high[k] - low[k]) * 0.5),
        }
    }

    /// Octant 4 x + 2 y + z.
    pub(super) fn octant(&self, octant: usize) -> Cell {
        let half = self.half.map(|h| h * 0.5);
        let is_upper = [octant & 4 != 0, octant & 2 != 0, octant & 1 != 0];
        let center =
            [0, 1, 2].map(|k| if is_upper[k] { self.center[k] + half[k] } else { self.center[k] - half[k] });
        Cell { center, half }
    }
}

/// Whether a box and a cell have a point in common; their sides belong to them.
pub(super) fn box_overlaps(bounds: &Bounds, cell: &Cell) -> bool {
    let (low, high) = (wide(bounds.min), wide(bounds.max));
    (0..3).all(|k| low[k] <= cell.center[k] + cell.half[k] && high[k] >= cell.center[k] - cell.half[k])
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// Whether a triangle reaches into a cell that is grown by `padding`, by the ten separating axes that the boxes do not
/// already answer for (Akenine-Möller 2001, "Fast 3D triangle-box overlap testing").
pub(super) fn triangle_overlaps(triangle: &PackedTriangle, padding: f64, cell: &Cell) -> bool {
    let vertices = [triangle.v0, triangle.v1, triangle.v2].map(|v| {
        let v = wide(v);
        [0, 1, 2].map(|k| v[k] - cell.center[k])
    });
    let edge = |k: usize| [0, 1, 2].map(|axis| vertices[k][axis] - vertices[0][axis]);
    let (e1, e2) = (edge(1), edge(2));
    let half = cell.half.map(|h| h + padding);
    let apart = |axis: [f64; 3]| {
        let [a, b, c] = vertices.map(|v| dot(axis, v));
        let reach = half[0] * axis[0].abs() + half[1] * axis[1].abs() + half[2] * axis[2].abs();
        a.min(b).min(c) > reach || a.max(b).max(c) < -reach
    };
    let edges = [e1, e2, [0, 1, 2].map(|k| e2[k] - e1[k])];
    let units = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    !apart(cross(e1, e2)) && edges.iter().all(|&edge| units.iter().all(|&unit| !apart(cross(unit, edge))))
}
