//! The surface of a body with circumradius 1: faces moved outward, ribs between them, diodes behind the ribs.
//!
//! With `a` half a rib's width and `e` the angle between neighbouring normals (180 degrees less the dihedral angle),
//! faces move out along their normals by `a / sin(e/2)` and ribs along the directions of their edges' midpoints by
//! `a / tan(e/2)`. Then the long borders of a rib are the moved sides of its two faces, exactly: both are made from the
//! same corners here. The ribs end where the faces' corners are, so a hole stays at each vertex of the solid.

use super::solid::Solid;
use crate::double::{Vec3d, add, cross, scale, sub, unit};
use eosphor_core::math::sqrt64;

/// Half a rib's width.
pub(super) const RIB: f64 = 0.08;

/// From a diode's middle to its corners; less where there are so many that they would overlap.
pub(super) const DIODE: f64 = 0.04;

/// From a rib to its diodes: farther than rays start off surfaces, nearer than can be seen.
pub(super) const UNDER_RIB: f64 = 0.005;

/// Corners and how they are joined.
pub(super) struct Shell {
    /// The corners of the moved faces, face after face; ribs have no others.
    pub(super) corners: Vec<Vec3d>,
    /// Triangles of the faces, counter-clockwise seen from outside: a fan each.
    pub(super) faces: Vec<[u32; 3]>,
    /// Two triangles a rib, counter-clockwise seen from outside.
    pub(super) ribs: Vec<[u32; 3]>,
    /// Corners of each diode, counter-clockwise seen from the middle of the body.
    pub(super) diodes: Vec<[Vec3d; 3]>,
}

impl Shell {
    /// The surface with this many diodes an edge.
    pub(super) fn new(solid: Solid, diodes_per_edge: u32) -> Shell {
        let (vertices, normals) = (solid.vertices(), solid.normals());
        let half = half_exterior(solid);
        let out = RIB / half.sin;
        let mut shell =
            Shell { corners: Vec::new(), faces: Vec::new(), ribs: Vec::new(), diodes: Vec::new() };

        // Faces, and where each one's copy of a vertex is.
        let mut copies = Vec::new();
        for (corners, &normal) in solid.faces().into_iter().zip(&normals) {
            let first = shell.corners.len() as u32;
            shell.corners.extend(corners.iter().map(|&v| add(vertices[v], scale(normal, out))));
            let count = corners.len() as u32;
            shell.faces.extend((1..count.saturating_sub(1)).map(|i| [first, first + i, first + i + 1]));
            copies.push((first, corners));
        }
        let copy = |face: usize, vertex: usize| {
            let (first, corners) = &copies[face];
            first + corners.iter().position(|&v| v == vertex).unwrap_or(0) as u32
        };

        // Ribs and diodes.
        for edge in solid.edges() {
            let [a, b] = edge.vertices;
            let [la, lb] = [copy(edge.left, a), copy(edge.left, b)];
            let [ra, rb] = [copy(edge.right, a), copy(edge.right, b)];
            shell.ribs.extend([[la, ra, rb], [la, rb, lb]]);
            let out = scale(unit(add(vertices[a], vertices[b])), RIB * half.cos / half.sin - UNDER_RIB);
            let edge = [add(vertices[a], out), add(vertices[b], out)];
            shell.diodes.extend((1..=diodes_per_edge).map(|i| diode(edge, i, diodes_per_edge)));
        }
        shell
    }
}

/// Half the angle between the normals of neighbouring faces.
struct HalfAngle {
    sin: f64,
    cos: f64,
}

fn half_exterior(solid: Solid) -> HalfAngle {
    let cos_dihedral = solid.cos_dihedral();
    HalfAngle { sin: sqrt64((1.0 + cos_dihedral) * 0.5), cos: sqrt64((1.0 - cos_dihedral) * 0.5) }
}

/// Circumradius of a diode on an edge of this length with so many of them: no two overlap.
pub(super) fn diode_radius(edge_length: f64, count: u32) -> f64 {
    DIODE.min(0.5 * edge_length / (f64::from(count) + 1.0))
}

/// Number `i` of `count` diodes, from 1, along an edge: an equilateral triangle that faces the middle.
fn diode([a, b]: [Vec3d; 2], i: u32, count: u32) -> [Vec3d; 3] {
    let share = f64::from(i) / (f64::from(count) + 1.0);
    let way = sub(b, a);
    let middle = add(a, scale(way, share));
    let (along, outward) = (unit(way), unit(add(a, b)));
    let across = cross(outward, along);
    let radius = diode_radius(crate::double::length(way), count);
    let corner = |x: f64, y: f64| add(middle, add(scale(along, x * radius), scale(across, y * radius)));
    let x = sqrt64(3.0) / 2.0;
    // Clockwise seen along `outward` from without.
    [corner(0.0, 1.0), corner(x, -0.5), corner(-x, -0.5)]
}
