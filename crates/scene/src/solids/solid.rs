//! The five solids: vertices, faces, edges and dihedral angles.

use crate::double::{Vec3d, cross, dot, scale, sub};
use eosphor_core::math::sqrt64;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::fmt;
use std::str::FromStr;

/// A Platonic solid. Its vertices lie on the unit sphere about the origin; z is up.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
#[schemars(rename = "SolidShape", description = "A Platonic solid. z is up.")]
#[allow(missing_docs, reason = "the names say it")]
pub enum Solid {
    Tetrahedron,
    Cube,
    Octahedron,
    Dodecahedron,
    Icosahedron,
}

/// No solid has this name.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "there is no Platonic solid \"{0}\"; there are tetrahedron, cube, octahedron, dodecahedron and icosahedron"
)]
pub struct UnknownSolid(pub String);

impl Solid {
    /// All five, by the number of their faces.
    pub const ALL: [Solid; 5] =
        [Solid::Tetrahedron, Solid::Cube, Solid::Octahedron, Solid::Dodecahedron, Solid::Icosahedron];

    /// The name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Solid::Tetrahedron => "tetrahedron",
            Solid::Cube => "cube",
            Solid::Octahedron => "octahedron",
            Solid::Dodecahedron => "dodecahedron",
            Solid::Icosahedron => "icosahedron",
        }
    }

    /// How many faces and edges there are; the vertices follow by Euler's formula.
    pub fn faces_and_edges(self) -> [usize; 2] {
        match self {
            Solid::Tetrahedron => [4, 6],
            Solid::Cube => [6, 12],
            Solid::Octahedron => [8, 12],
            Solid::Dodecahedron => [12, 30],
            Solid::Icosahedron => [20, 30],
        }
    }

    /// Triangles of a [`super::Body`] of this shape with that many lights an edge: each face is a fan, each rib two
    /// triangles, each light one.
    pub fn triangle_count(self, lights_per_edge: u32) -> usize {
        let [faces, edges] = self.faces_and_edges();
        let corners = 2 * edges;
        corners - 2 * faces + edges * (2 + lights_per_edge as usize)
    }

    /// The cosine of the angle between neighbouring faces, inside.
    pub fn cos_dihedral(self) -> f64 {
        match self {
            Solid::Tetrahedron => 1.0 / 3.0,
            Solid::Cube => 0.0,
            Solid::Octahedron => -1.0 / 3.0,
            Solid::Dodecahedron => -1.0 / sqrt64(5.0),
            Solid::Icosahedron => -sqrt64(5.0) / 3.0,
        }
    }

    /// The solid whose vertices are this one's face normals. The tetrahedron's is itself upside down.
    fn dual(self) -> Solid {
        match self {
            Solid::Tetrahedron => Solid::Tetrahedron,
            Solid::Cube => Solid::Octahedron,
            Solid::Octahedron => Solid::Cube,
            Solid::Dodecahedron => Solid::Icosahedron,
            Solid::Icosahedron => Solid::Dodecahedron,
        }
    }

    /// Vertices at distance 1 from the middle. The tetrahedron stands on a face, the octahedron on a vertex, the others
    /// have the planes of the axes for planes of symmetry.
    pub(super) fn vertices(self) -> Vec<Vec3d> {
        let golden = (1.0 + sqrt64(5.0)) / 2.0;
        let third = 1.0 / sqrt64(3.0);
        match self {
            Solid::Tetrahedron => {
                let (r, x) = (sqrt64(8.0) / 3.0, sqrt64(2.0) / 3.0);
                let (y, z) = (sqrt64(2.0 / 3.0), -1.0 / 3.0);
                vec![[0.0, 0.0, 1.0], [r, 0.0, z], [-x, y, z], [-x, -y, z]]
            }
            Solid::Cube => signs([third; 3]),
            Solid::Octahedron => cyclic([1.0, 0.0, 0.0]),
            Solid::Dodecahedron => {
                let mut vertices = signs([third; 3]);
                vertices.extend(cyclic([0.0, third / golden, third * golden]));
                vertices
            }
            Solid::Icosahedron => {
                let length = sqrt64(1.0 + golden * golden);
                cyclic([1.0 / length, 0.0, golden / length])
            }
        }
    }

    /// Unit normals of the faces, outward.
    pub(super) fn normals(self) -> Vec<Vec3d> {
        let sign = if self == Solid::Tetrahedron { -1.0 } else { 1.0 };
        self.dual().vertices().into_iter().map(|v| scale(v, sign)).collect()
    }

    /// The vertices around each face, counter-clockwise seen from outside; in the order of [`Solid::normals`].
    pub(super) fn faces(self) -> Vec<Vec<usize>> {
        let vertices = self.vertices();
        self.normals().into_iter().map(|normal| around(&vertices, normal)).collect()
    }

    /// The two vertices of each edge, and the face to its left (around which it runs from the first to the second, seen
    /// from outside) and the one to its right.
    pub(super) fn edges(self) -> Vec<Edge> {
        let faces = self.faces();
        let sides = |face: usize| {
            let corners = &faces[face];
            (0..corners.len()).map(move |i| [corners[i], corners[(i + 1) % corners.len()]])
        };
        let mut edges = Vec::new();
        for left in 0..faces.len() {
            for vertices in sides(left) {
                let [a, b] = vertices;
                // Each edge is found from both sides; the one from the lower vertex counts.
                let right = (0..faces.len()).find(|&other| sides(other).any(|side| side == [b, a]));
                if let (Some(right), true) = (right, a < b) {
                    edges.push(Edge { vertices, left, right });
                }
            }
        }
        edges
    }
}

/// An edge, by numbers of vertices and faces.
#[derive(Clone, Copy, Debug)]
pub(super) struct Edge {
    pub(super) vertices: [usize; 2],
    pub(super) left: usize,
    pub(super) right: usize,
}

/// The vertices of the face with this normal, counter-clockwise: each is followed by the one that has all others to the
/// left of the way to it.
fn around(vertices: &[Vec3d], normal: Vec3d) -> Vec<usize> {
    let highest = vertices.iter().map(|&v| dot(v, normal)).fold(-1.0, f64::max);
    let on_face: Vec<usize> =
        (0..vertices.len()).filter(|&i| dot(vertices[i], normal) > highest - 1e-6).collect();
    let follows = |from: usize, to: usize| {
        let way = sub(vertices[to], vertices[from]);
        let left = |i: usize| dot(cross(way, sub(vertices[i], vertices[from])), normal) > 0.0;
        to != from && on_face.iter().all(|&i| i == from || i == to || left(i))
    };
    let mut corners: Vec<usize> = on_face.first().copied().into_iter().collect();
    while let Some(next) = on_face.iter().copied().find(|&i| follows(corners[corners.len() - 1], i)) {
        if corners.contains(&next) {
            break;
        }
        corners.push(next);
    }
    corners
}

/// All combinations of signs of what is not 0.
fn signs(v: Vec3d) -> Vec<Vec3d> {
    let mut all = vec![v];
    for axis in 0..3 {
        if v[axis] != 0.0 {
            let negative: Vec<Vec3d> = all
                .iter()
                .map(|v| {
                    let mut v = *v;
                    v[axis] = -v[axis];
                    v
                })
                .collect();
            all.extend(negative);
        }
    }
    all
}

/// The same of the three cyclic permutations.
fn cyclic([x, y, z]: Vec3d) -> Vec<Vec3d> {
    [[x, y, z], [z, x, y], [y, z, x]].into_iter().flat_map(signs).collect()
}

impl fmt::Display for Solid {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl FromStr for Solid {
    type Err = UnknownSolid;
    fn from_str(name: &str) -> Result<Solid, UnknownSolid> {
        Solid::ALL.into_iter().find(|s| s.name() == name).ok_or_else(|| UnknownSolid(name.into()))
    }
}
