//! Four balls of many shining triangles over plates, made from code: every triangle is a lamp.

use crate::model::{
    Camera, Instance, Material, MaterialKind, Mesh, Mtl, NO_INDEX, RenderSettings, Scene, Transform, Triangle,
};
use eosphor_core::math::{Vec3, elementary64, vec3};
use std::f64::consts::PI;

/// Bands of a ball, of which the first and the last end in a pole, and pieces around: 2,900 triangles.
const BANDS: u32 = 30;
const PIECES: u32 = 50;

fn triangle(positions: [u32; 3], material: u32) -> Triangle {
    Triangle { positions, normals: [NO_INDEX; 3], uvs: [NO_INDEX; 3], material }
}

/// Adds two triangles.
fn add_quad(mesh: &mut Mesh, corners: [Vec3; 4], material: u32) {
    let first = mesh.positions.len() as u32;
    mesh.positions.extend(corners);
    mesh.triangles.push(triangle([first, first + 1, first + 2], material));
    mesh.triangles.push(triangle([first, first + 2, first + 3], material));
}

/// Adds a ball whose triangles face outwards.
fn add_ball(mesh: &mut Mesh, center: Vec3, radius: f32, material: u32) {
    let first = mesh.positions.len() as u32;
    let point = |band: u32, piece: u32| {
        let (sine, cosine) = elementary64::sin_cos(PI * f64::from(band) / f64::from(BANDS));
        let (z, x) = elementary64::sin_cos(2.0 * PI * f64::from(piece) / f64::from(PIECES));
        center + vec3((sine * x) as f32, cosine as f32, (sine * z) as f32) * radius
    };
    mesh.positions.push(center + vec3(0.0, radius, 0.0));
    mesh.positions.extend((1..BANDS).flat_map(|band| (0..PIECES).map(move |piece| point(band, piece))));
    mesh.positions.push(center - vec3(0.0, radius, 0.0));
    let number = |band: u32, piece: u32| match band {
        0 => first,
        BANDS => first + 1 + (BANDS - 1) * PIECES,
        _ => first + 1 + (band - 1) * PIECES + piece % PIECES,
    };
    for band in 0..BANDS {
        for piece in 0..PIECES {
            let [a, b] = [number(band, piece), number(band, piece + 1)];
            let [c, d] = [number(band + 1, piece), number(band + 1, piece + 1)];
            // At a pole one of the two has no area.
            if band > 0 {
                mesh.triangles.push(triangle([a, b, d], material));
            }
            if band < BANDS - 1 {
                mesh.triangles.push(triangle([a, d, c], material));
            }
        }
    }
}

/// The scene.
pub(crate) fn lamps() -> Scene {
    let matte = MaterialKind::Matte { color: Vec3::splat(0.6) };
    let plate = Mtl { Kd: vec3(0.3, 0.35, 0.4), Ks: Vec3::splat(0.3), Ns: 80.0, ..Mtl::default() };
    let lamp = MaterialKind::Emissive { radiance: vec3(4.0, 3.6, 3.0) };
    let mut mesh = Mesh { name: "lamps".into(), ..Mesh::default() };
    let at = |x, y, z| vec3(x, y, z);
    add_quad(&mut mesh, [at(-8.0, 0.0, 8.0), at(8.0, 0.0, 8.0), at(8.0, 0.0, -8.0), at(-8.0, 0.0, -8.0)], 0);
    for k in 0..4 {
        let k = k as f32;
        let ([low, high], [near, far]) = ([0.4 + 0.5 * k, 0.6 + 0.6 * k], [2.0 - 1.2 * k, 1.2 - 1.2 * k]);
        let corners = [at(-4.0, low, near), at(4.0, low, near), at(4.0, high, far), at(-4.0, high, far)];
        add_quad(&mut mesh, corners, 1);
    }
    for k in 0..4 {
        add_ball(&mut mesh, at(-3.0 + 2.0 * k as f32, 3.2, -1.0), 0.15 + 0.12 * k as f32, 2);
    }
    Scene {
        materials: vec![
            Material::new("floor", matte),
            Material::new("plate", MaterialKind::Mtl(plate)),
            Material::new("lamp", lamp),
        ],
        meshes: vec![mesh],
        instances: vec![Instance::new(0, Transform::default())],
        camera: Some(Camera {
            position: at(0.0, 3.0, 9.0),
            look_at: Some(at(0.0, 1.2, 0.0)),
            fov_x_degrees: 60.0,
            ..Camera::default()
        }),
        settings: RenderSettings { size: [960, 540], samples: 4, ..RenderSettings::default() },
        ..Scene::default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The balls are closed, and their triangles face outwards: their volume is nearly that of spheres.
    #[test]
    fn balls_are_round() {
        let mut mesh = Mesh::default();
        let (center, radius) = (vec3(1.0, -2.0, 3.0), 0.5);
        add_ball(&mut mesh, center, radius, 0);
        assert_eq!(mesh.triangles.len(), 2900);
        let corner = |index: u32| mesh.positions[index as usize] - center;
        let volume: f32 = mesh
            .triangles
            .iter()
            .map(|triangle| {
                let [a, b, c] = triangle.positions.map(corner);
                a.dot(b.cross(c)) / 6.0
            })
            .sum();
        let sphere = 4.0 / 3.0 * std::f32::consts::PI * radius.powi(3);
        assert!(volume < sphere && volume > 0.99 * sphere, "{volume} {sphere}");
    }
}
