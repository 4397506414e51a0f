//! Hills: a landscape of as many triangles as are asked for, made from code, to see how times grow.

use crate::model::{
    Camera, Instance, Light, Material, MaterialKind, Mesh, NO_INDEX, RenderSettings, Scene, Transform,
    Triangle,
};
use eosphor_core::math::{Vec3, vec3};
use std::ops::RangeInclusive;

/// How many triangles there may be.
pub(crate) const COUNTS: RangeInclusive<u32> = 2..=50_000_000;

/// How many there are where none are asked for.
pub(crate) const DEFAULT_COUNT: u32 = 100_000;

/// The side of the square that the hills stand on.
const SIDE: f32 = 12.0;
/// Cells of the coarsest noise along a side, and the height of that.
const CELLS: f32 = 5.0;
const HEIGHT: f32 = 1.6;
/// Each octave is twice as fine and half as high.
const OCTAVES: u32 = 9;

/// A number from 0 to 1 for a corner of a cell of the noise.
fn corner(octave: u32, x: u32, z: u32) -> f32 {
    let mut bits =
        octave.wrapping_mul(0x9e37_79b9) ^ x.wrapping_mul(0x85eb_ca6b) ^ z.wrapping_mul(0xc2b2_ae35);
    bits = (bits ^ (bits >> 16)).wrapping_mul(0x7feb_352d);
    bits = (bits ^ (bits >> 15)).wrapping_mul(0x846c_a68b);
    ((bits ^ (bits >> 16)) >> 8) as f32 / 16_777_216.0
}

/// Smooth between the corners of the cells (value noise), summed over octaves.
fn height(u: f32, v: f32) -> f32 {
    let (mut sum, mut cells, mut high) = (0.0, CELLS, HEIGHT);
    for octave in 0..OCTAVES {
        let (x, z) = (u * cells, v * cells);
        let (column, row) = (x.floor(), z.floor());
        let smooth = |t: f32| t * t * (3.0 - 2.0 * t);
        let (s, t) = (smooth(x - column), smooth(z - row));
        let at = |dx: u32, dz: u32| corner(octave, column as u32 + dx, row as u32 + dz);
        let near = at(0, 0) + (at(1, 0) - at(0, 0)) * s;
        let far = at(0, 1) + (at(1, 1) - at(0, 1)) * s;
        sum += high * (near + (far - near) * t);
        (cells, high) = (2.0 * cells, 0.5 * high);
    }
    sum
}

/// A square of `cells` times `cells` pieces of two triangles each.
fn mesh(cells: u32, material: u32) -> Mesh {
    let point = |column: u32, row: u32| {
        let (u, v) = (column as f32 / cells as f32, row as f32 / cells as f32);
        vec3((u - 0.5) * SIDE, height(u, v), (v - 0.5) * SIDE)
    };
    let lines = || 0..=cells;
    let positions: Vec<Vec3> =
        lines().flat_map(|row| lines().map(move |column| point(column, row))).collect();
    let number = |column: u32, row: u32| row * (cells + 1) + column;
    let pieces = (0..cells).flat_map(|row| (0..cells).map(move |column| (column, row)));
    let triangles = pieces.flat_map(|(column, row)| {
        let [a, b] = [number(column, row), number(column + 1, row)];
        let [c, d] = [number(column, row + 1), number(column + 1, row + 1)];
        let triangle =
            |positions| Triangle { positions, normals: [NO_INDEX; 3], uvs: [NO_INDEX; 3], material };
        [triangle([a, c, b]), triangle([b, c, d])]
    });
    let triangles = triangles.collect();
    Mesh { name: "hills".into(), positions, triangles, ..Mesh::default() }
}

/// Hills under a sun, of the square number of pieces that is nearest to half the triangles asked for.
pub(crate) fn hills(count: u32) -> Scene {
    let cells = ((f64::from(count) / 2.0).sqrt().round() as u32).max(1);
    let matte = MaterialKind::Matte { color: vec3(0.45, 0.5, 0.3) };
    let mut scene = Scene { materials: vec![Material::new("grass", matte)], ..Scene::default() };
    scene.meshes.push(mesh(cells, 0));
    scene.instances.push(Instance::new(0, Transform::default()));
    scene.lights = vec![Light::Directional { direction: vec3(-0.8, -0.7, 0.4), color: vec3(3.0, 2.8, 2.5) }];
    scene.camera = Some(Camera {
        position: vec3(0.0, 4.6, 7.4),
        look_at: Some(vec3(0.0, 1.0, 0.0)),
        fov_x_degrees: 60.0,
        ..Camera::default()
    });
    scene.settings = RenderSettings {
        size: [640, 480],
        samples: 4,
        ambient: 0.3,
        background: vec3(0.5, 0.62, 0.8),
        ..RenderSettings::default()
    };
    scene
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn there_are_about_as_many_triangles_as_are_asked_for() {
        for (asked, made) in [(2, 2), (8, 8), (326, 338), (100_000, 100_352)] {
            assert_eq!(hills(asked).meshes[0].triangles.len(), made);
        }
    }

    /// More triangles show the same hills more finely.
    #[test]
    fn points_of_fewer_triangles_are_points_of_more() {
        let [few, many] = [mesh(8, 0), mesh(32, 0)];
        assert!(few.positions.iter().all(|point| many.positions.contains(point)));
    }

    #[test]
    fn all_face_upwards() {
        let mesh = mesh(20, 0);
        let corner = |index: u32| mesh.positions[index as usize];
        for triangle in &mesh.triangles {
            let [a, b, c] = triangle.positions.map(corner);
            assert!((b - a).cross(c - a).y > 0.0);
        }
    }
}
