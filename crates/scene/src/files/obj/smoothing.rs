//! Smoothing groups → normals.

use super::chunk::Smoothing;
use crate::files::face_ranges::Polygon;
use crate::model::{Mesh, NO_INDEX, Triangle};
use eosphor_core::math::{Vec3, sqrt64, vec3};

/// Adds normals to corners that have none, where the file uses smoothing groups: at a corner, the sum of the area
/// vectors of all faces of its group around the same vertex; the triangle's own where it is in no group. Files that
/// only switch smoothing off, as many exporters do unasked, and those that do not speak of it are left to the crease
/// angle of the render settings.
///
/// Sums are in double precision and in the order of the faces, since normals reach pixels.
pub(super) fn add_normals(smoothing: &[Smoothing], polygons: &[Polygon], mesh: &mut Mesh) {
    let lacks = |t: &Triangle| t.normals.contains(&NO_INDEX);
    if smoothing.iter().all(|s| s.group == 0) || !mesh.triangles.iter().any(lacks) {
        return;
    }
    // Each corner adds one normal at most.
    if mesh.normals.len() + 3 * mesh.triangles.len() >= NO_INDEX as usize {
        return;
    }
    let groups = groups_of_triangles(smoothing, mesh.triangles.len());
    add_smooth(&groups, &Faces::new(polygons, mesh), mesh);
    add_flat(mesh);
}

/// The faces that triangles come from: a polygon weighs by its area, however it was cut.
struct Faces {
    /// Of each triangle, the first triangle of its face.
    first: Vec<u32>,
    /// The area vectors of faces, at their first triangles.
    areas: Vec<[f64; 3]>,
}

impl Faces {
    fn new(polygons: &[Polygon], mesh: &Mesh) -> Faces {
        let mut first: Vec<u32> = (0..mesh.triangles.len() as u32).collect();
        let mut areas: Vec<[f64; 3]> =
            mesh.triangles.iter().map(|t| area_vector(&mesh.positions, t)).collect();
        for polygon in polygons {
            let start = polygon.first_triangle as usize;
            let triangles = start..start + polygon.triangles as usize;
            areas[start] = areas[triangles.clone()].iter().fold([0.0; 3], |s, &a| sum(s, a));
            first[triangles].fill(polygon.first_triangle);
        }
        Faces { first, areas }
    }

    /// The sum of the area vectors of the faces of these corners, each face once. Corners of a face are neighbours.
    fn sum(&self, corners: &[u32]) -> [f64; 3] {
        let face = |corner: u32| self.first[corner as usize / 3];
        let by_face = corners.chunk_by(|&a, &b| face(a) == face(b));
        by_face.fold([0.0; 3], |s, corners| sum(s, self.areas[face(corners[0]) as usize]))
    }
}

fn sum(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

fn groups_of_triangles(smoothing: &[Smoothing], triangles: usize) -> Vec<u32> {
    let mut groups = Vec::with_capacity(triangles);
    let mut group = 0;
    for s in smoothing {
        groups.resize(s.first_triangle as usize, group);
        group = s.group;
    }
    groups.resize(triangles, group);
    groups
}

/// Gives a normal to each vertex of each group.
fn add_smooth(groups: &[u32], faces: &Faces, mesh: &mut Mesh) {
    let Mesh { positions, normals, triangles, .. } = mesh;
    let (starts, mut corners) = corners_around(groups, positions.len(), triangles);
    let group_of = |corner: u32| groups[corner as usize / 3];
    for bounds in starts.windows(2) {
        let around = &mut corners[bounds[0] as usize..bounds[1] as usize];
        // The order within a group stays that of the triangles.
        around.sort_by_key(|&corner| group_of(corner));
        for corners in around.chunk_by(|&a, &b| group_of(a) == group_of(b)) {
            let mut lacking = corners.to_vec();
            lacking.retain(|&c| triangles[c as usize / 3].normals[c as usize % 3] == NO_INDEX);
            let Some(normal) = unit(faces.sum(corners)).filter(|_| !lacking.is_empty()) else { continue };
            for c in lacking {
                triangles[c as usize / 3].normals[c as usize % 3] = normals.len() as u32;
            }
            normals.push(normal);
        }
    }
}

/// Lists the corners around each vertex that are in a group, in the order of the triangles, as one array with starts. A
/// corner's number is three times its triangle's and its place there.
fn corners_around(groups: &[u32], vertices: usize, triangles: &[Triangle]) -> (Vec<u32>, Vec<u32>) {
    let corners = || {
        let smooth = triangles.iter().enumerate().filter(|(i, _)| groups[*i] != 0);
        smooth.flat_map(|(i, t)| (0..3).map(move |place| (3 * i as u32 + place, t.positions[place as usize])))
    };
    let mut starts = vec![0; vertices + 1];
    for (_, vertex) in corners() {
        starts[vertex as usize + 1] += 1;
    }
    for vertex in 0..vertices {
        starts[vertex + 1] += starts[vertex];
    }
    let mut next = starts.clone();
    let mut around = vec![0; starts[vertices] as usize];
    for (corner, vertex) in corners() {
        let place = &mut next[vertex as usize];
        around[*place as usize] = corner;
        *place += 1;
    }
    (starts, around)
}

/// Gives triangles their own normal where a corner still has none.
fn add_flat(mesh: &mut Mesh) {
    let Mesh { positions, normals, triangles, .. } = mesh;
    for t in triangles.iter_mut().filter(|t| t.normals.contains(&NO_INDEX)) {
        let Some(normal) = unit(area_vector(positions, t)) else { continue };
        // The halves of a quad mostly share theirs.
        if normals.last() != Some(&normal) {
            normals.push(normal);
        }
        let number = normals.len() as u32 - 1;
        t.normals.iter_mut().filter(|n| **n == NO_INDEX).for_each(|n| *n = number);
    }
}

/// Edges' cross product, twice the area long.
fn area_vector(positions: &[Vec3], t: &Triangle) -> [f64; 3] {
    let [a, b, c] = t.positions.map(|p| {
        let p = positions[p as usize];
        [f64::from(p.x), f64::from(p.y), f64::from(p.z)]
    });
    let e = [b[0] - a[0], b[1] - a[1], b[2] - a[2]];
    let f = [c[0] - a[0], c[1] - a[1], c[2] - a[2]];
    [e[1] * f[2] - e[2] * f[1], e[2] * f[0] - e[0] * f[2], e[0] * f[1] - e[1] * f[0]]
}

fn unit([x, y, z]: [f64; 3]) -> Option<Vec3> {
    let length = sqrt64(x * x + y * y + z * z);
    let single = |x: f64| (x / length) as f32;
    (length > 0.0 && length.is_finite()).then(|| vec3(single(x), single(y), single(z)))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two unit squares of two triangles each that share the edge along z: one in the plane y = 0 facing down, one in
    /// the plane x = 0 facing left.
    fn corner_of_a_box(smoothing: &[(u32, u32)]) -> Mesh {
        let positions = vec![
            vec3(0.0, 0.0, 0.0),
            vec3(0.0, 0.0, 1.0),
            vec3(1.0, 0.0, 0.0),
            vec3(1.0, 0.0, 1.0),
            vec3(0.0, 1.0, 0.0),
            vec3(0.0, 1.0, 1.0),
        ];
        let triangle =
            |positions| Triangle { positions, normals: [NO_INDEX; 3], uvs: [NO_INDEX; 3], material: 0 };
        let triangles = [[0, 2, 3], [0, 3, 1], [0, 1, 5], [0, 5, 4]].map(triangle).to_vec();
        let mut mesh = Mesh { positions, triangles, ..Mesh::default() };
        let smoothing: Vec<Smoothing> =
            smoothing.iter().map(|&(first_triangle, group)| Smoothing { first_triangle, group }).collect();
        add_normals(&smoothing, &[], &mut mesh);
        mesh
    }

    fn normals(mesh: &Mesh, triangle: usize) -> [Vec3; 3] {
        mesh.triangles[triangle].normals.map(|n| mesh.normals[n as usize])
    }

    const DOWN: Vec3 = vec3(0.0, -1.0, 0.0);
    const LEFT: Vec3 = vec3(-1.0, 0.0, 0.0);

    #[test]
    fn one_group_is_smooth_over_its_edge() {
        let mesh = corner_of_a_box(&[(0, 1)]);
        let half = std::f32::consts::FRAC_1_SQRT_2;
        // Both triangles of both squares meet in vertex 0, one of the first and one of the second in vertex 1.
        assert_eq!(normals(&mesh, 0), [vec3(-half, -half, 0.0), DOWN, DOWN]);
        assert_eq!(normals(&mesh, 2), [vec3(-half, -half, 0.0), vec3(-half, -half, 0.0), LEFT]);
        assert_eq!(mesh.normals.len(), 6);
    }

    #[test]
    fn groups_and_faces_without_keep_to_themselves() {
        for smoothing in [&[(0, 1), (2, 2)][..], &[(0, 1), (2, 0)], &[(2, 7)]] {
            let mesh = corner_of_a_box(smoothing);
            for t in 0..4 {
                assert_eq!(normals(&mesh, t), [if t < 2 { DOWN } else { LEFT }; 3], "{smoothing:?}");
            }
        }
    }

    #[test]
    fn normals_weigh_by_area_and_those_of_the_file_stay() {
        let mut mesh = corner_of_a_box(&[]);
        mesh.positions[4] = vec3(0.0, 3.0, 0.0);
        mesh.normals.push(vec3(0.0, 0.0, 5.0));
        mesh.triangles[0].normals[1] = 0;
        add_normals(&[Smoothing { first_triangle: 0, group: 1 }], &[], &mut mesh);
        // Areas around vertex 0: 1 and 1 down, 1 and 3 to the left.
        let length = 20f64.sqrt();
        assert_eq!(normals(&mesh, 0)[0], vec3((-4.0 / length) as f32, (-2.0 / length) as f32, 0.0));
        assert_eq!(normals(&mesh, 0)[1], vec3(0.0, 0.0, 5.0));
    }

    #[test]
    fn quads_weigh_the_same_however_they_are_cut() {
        let mut mesh = corner_of_a_box(&[]);
        let quads = [0, 2].map(|first_triangle| Polygon { first_triangle, triangles: 2 });
        add_normals(&[Smoothing { first_triangle: 0, group: 1 }], &quads, &mut mesh);
        let half = std::f32::consts::FRAC_1_SQRT_2;
        assert_eq!(normals(&mesh, 1)[2], vec3(-half, -half, 0.0));
        // Cut the other way, both triangles of the first square are around vertex 1, and one of the second.
        mesh = corner_of_a_box(&[]);
        (mesh.triangles[0].positions, mesh.triangles[1].positions) = ([0, 2, 1], [1, 2, 3]);
        add_normals(&[Smoothing { first_triangle: 0, group: 1 }], &quads, &mut mesh);
        assert_eq!(normals(&mesh, 1)[0], vec3(-half, -half, 0.0));
    }

    #[test]
    fn files_that_do_not_smooth_are_left_alone() {
        for smoothing in [&[][..], &[(0, 0)]] {
            let mesh = corner_of_a_box(smoothing);
            assert!(mesh.normals.is_empty() && mesh.triangles.iter().all(|t| t.normals == [NO_INDEX; 3]));
        }
        // A triangle without area has no normal.
        let mut mesh = corner_of_a_box(&[]);
        mesh.triangles.push(Triangle { positions: [0; 3], ..mesh.triangles[0] });
        add_normals(&[Smoothing { first_triangle: 4, group: 1 }], &[], &mut mesh);
        assert_eq!(mesh.triangles[4].normals, [NO_INDEX; 3]);
    }
}
