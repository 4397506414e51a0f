//! Shading normals at the corners of triangles: the file's, flat or generated.

use crate::model::{Mesh, NO_INDEX, NormalMode, Triangle};
use crate::positions::merge_positions;
use eosphor_core::math::{Vec3, elementary64, sqrt64, vec3};

/// The normal of triangles that have none: they have no area and are never hit.
pub(super) const HARMLESS: Vec3 = vec3(0.0, 0.0, 1.0);

/// Positions with more triangles around them than this get generated normals only where none of them makes a crease;
/// otherwise each keeps its own. It bounds the work on files that were made to take for ever.
const MAX_CREASED: usize = 4096;

type Vec3d = [f64; 3];

/// The unit vector of nothing.
const NO_UNIT: Vec3d = [f64::NAN; 3];

fn double(v: Vec3) -> Vec3d {
    [v.x as f64, v.y as f64, v.z as f64]
}

fn dot(a: Vec3d, b: Vec3d) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// Edges' cross product, twice the area long, in double precision: no triangle within the range of coordinates
/// underflows or overflows.
pub(super) fn area_vector([a, b, c]: &[Vec3; 3]) -> Vec3d {
    let (a, b, c) = (double(*a), double(*b), double(*c));
    let e = [b[0] - a[0], b[1] - a[1], b[2] - a[2]];
    let f = [c[0] - a[0], c[1] - a[1], c[2] - a[2]];
    [e[1] * f[2] - e[2] * f[1], e[2] * f[0] - e[0] * f[2], e[0] * f[1] - e[1] * f[0]]
}

/// The length of a vector.
pub(super) fn length(v: Vec3d) -> f64 {
    sqrt64(dot(v, v))
}

fn unit_double(v: Vec3d) -> Option<Vec3d> {
    let len = length(v);
    (len > 0.0 && len.is_finite()).then(|| [v[0] / len, v[1] / len, v[2] / len])
}

fn single(v: Vec3d) -> Vec3 {
    vec3(v[0] as f32, v[1] as f32, v[2] as f32)
}

/// The unit normal of a triangle on the side from which it runs counter-clockwise; `None` where it has no area.
pub(super) fn of_triangle(vertices: &[Vec3; 3]) -> Option<Vec3> {
    unit_double(area_vector(vertices)).map(single)
}

/// Unit normals at the corners of the triangles of a mesh, in its own space; not in flat mode, where the placed triangles decide.
pub(super) struct CornerNormals<'a> {
    mesh: &'a Mesh,
    /// Whether those of the file are taken.
    takes_given: bool,
    generated: Option<Generator>,
}

impl CornerNormals<'_> {
    pub(super) fn new(mesh: &Mesh, mode: NormalMode, crease_degrees: f32) -> CornerNormals<'_> {
        let lacks = |t: &Triangle| t.normals.contains(&NO_INDEX);
        let generate = match mode {
            NormalMode::Generated => true,
            NormalMode::Auto => mesh.triangles.iter().any(lacks),
            NormalMode::Smooth | NormalMode::Flat => false,
        };
        let generated = generate.then(|| Generator::new(mesh, crease_degrees));
        CornerNormals { mesh, takes_given: mode != NormalMode::Generated, generated }
    }

    /// Those of triangle number `i`, which is `t`.
    pub(super) fn of_triangle(&self, i: usize, t: &Triangle) -> [Vec3; 3] {
        let flat = || of_triangle(&vertices(self.mesh, t)).unwrap_or(HARMLESS);
        [0, 1, 2].map(|corner| {
            let given = t.normals[corner];
            if self.takes_given && given != NO_INDEX {
                return normalized(self.mesh.normals[given as usize]).unwrap_or_else(flat);
            }
            self.generated.as_ref().and_then(|g| g.normal(i, t.positions[corner])).unwrap_or_else(flat)
        })
    }
}

fn vertices(mesh: &Mesh, t: &Triangle) -> [Vec3; 3] {
    t.positions.map(|p| mesh.positions[p as usize])
}

/// A normal of a file, whatever its length; `None` for the null vector.
fn normalized(n: Vec3) -> Option<Vec3> {
    unit_double(double(n)).map(single)
}

/// Generates normals: at a corner, the sum of the area vectors of all triangles around the same position whose planes
/// meet this triangle's at no more than the crease angle.
struct Generator {
    areas: Vec<Vec3d>,
    /// Those of unit length; NaN where there is no area.
    units: Vec<Vec3d>,
    /// The number of the position of each vertex: vertices with equal coordinates share one.
    position_of_vertex: Vec<u32>,
    /// Where the triangles around each position begin in `around`; one more entry than positions.
    starts: Vec<usize>,
    /// Triangles around positions, ascending.
    around: Vec<u32>,
    /// For each position, the common sum where all its triangles are smooth to each other.
    smooth: Vec<Option<Vec3>>,
    min_cosine: f64,
}

impl Generator {
    fn new(mesh: &Mesh, crease_degrees: f32) -> Generator {
        let radians = f64::from(crease_degrees) * (std::f64::consts::PI / 180.0);
        // Neighbours in one plane count as smooth even with a crease angle of 0, whatever their normals' rounding.
        let min_cosine = elementary64::cos(radians) - 1e-9;
        let (position_of_vertex, positions) = merge_positions(&mesh.positions);
        let (starts, around) = triangles_around(mesh, &position_of_vertex, positions);
        let areas: Vec<Vec3d> = mesh.triangles.iter().map(|t| area_vector(&vertices(mesh, t))).collect();
        let units = areas.iter().map(|&a| unit_double(a).unwrap_or(NO_UNIT)).collect();
        let smooth = vec![None; positions];
        let mut generator =
            Generator { areas, units, position_of_vertex, starts, around, smooth, min_cosine };
        let half = elementary64::cos(radians * 0.5);
        generator.smooth = (0..positions).map(|p| generator.common_normal(p, half)).collect();
        generator
    }

    fn around(&self, position: usize) -> &[u32] {
        &self.around[self.starts[position]..self.starts[position + 1]]
    }

    /// The normal that all corners at a position share, where all triangles lie within half the crease angle of the
    /// first: then any two are within the whole. It spares positions with thousands of triangles the square of it.
    fn common_normal(&self, position: usize, half_cosine: f64) -> Option<Vec3> {
        let around = self.around(position);
        let first = around.iter().map(|&t| self.units[t as usize]).find(|unit| !unit[0].is_nan())?;
        let close = |&t: &u32| {
            let cosine = dot(self.units[t as usize], first);
            cosine.is_nan() || cosine >= half_cosine
        };
        if !around.iter().all(close) {
            return None;
        }
        unit_double(self.sum(around.iter().copied())).map(single)
    }

    fn sum(&self, triangles: impl Iterator<Item = u32>) -> Vec3d {
        triangles.fold([0.0; 3], |s, t| {
            let a = self.areas[t as usize];
            [s[0] + a[0], s[1] + a[1], s[2] + a[2]]
        })
    }

    /// The normal of a triangle at one of its vertices; `None` where the triangle has no area.
    fn normal(&self, triangle: usize, vertex: u32) -> Option<Vec3> {
        let own = self.units[triangle];
        if own[0].is_nan() {
            return None;
        }
        let position = self.position_of_vertex[vertex as usize] as usize;
        if let Some(common) = self.smooth[position] {
            return Some(common);
        }
        if self.around(position).len() > MAX_CREASED {
            return None;
        }
        // Not those without area.
        let smooth = |&t: &u32| t as usize == triangle || dot(self.units[t as usize], own) >= self.min_cosine;
        unit_double(self.sum(self.around(position).iter().copied().filter(smooth))).map(single)
    }
}

/// Lists the triangles around each position, ascending, as one array with starts.
fn triangles_around(mesh: &Mesh, position_of_vertex: &[u32], positions: usize) -> (Vec<usize>, Vec<u32>) {
    let corners = || {
        let of = |t: &Triangle| t.positions.map(|v| position_of_vertex[v as usize] as usize);
        mesh.triangles.iter().enumerate().flat_map(move |(i, t)| of(t).map(|p| (i as u32, p)))
    };
    let mut starts = vec![0usize; positions + 1];
    for (_, p) in corners() {
        starts[p + 1] += 1;
    }
    for p in 0..positions {
        starts[p + 1] += starts[p];
    }
    let mut next = starts.clone();
    let mut around = vec![0; mesh.triangles.len() * 3];
    for (triangle, p) in corners() {
        around[next[p]] = triangle;
        next[p] += 1;
    }
    (starts, around)
}
