//! The hare: an organic model to try things on, a closed mesh of some ten thousand triangles that is made from code.

mod surface;

use crate::model::Transform;
use crate::model::{
    Camera, Instance, Light, Material, MaterialKind, Mesh, Parallelogram, RenderSettings, Scene,
};
use eosphor_core::math::{Vec3, vec3};
use surface::{Grid, surface};

/// How far parts grow into each other.
const BLEND: f32 = 0.09;

/// A rounded rod.
struct Part {
    from: Vec3,
    to: Vec3,
    /// At both ends.
    radius: [f32; 2],
}

impl Part {
    /// About the distance from it; below 0 inside.
    fn distance(&self, p: Vec3) -> f32 {
        let (rod, own) = (self.to - self.from, p - self.from);
        let along = (own.dot(rod) / rod.length_squared()).clamp(0.0, 1.0);
        (own - rod * along).length() - (self.radius[0] + (self.radius[1] - self.radius[0]) * along)
    }
}

/// It sits on y = 0 and looks along z; 1.8 units high.
fn parts() -> Vec<Part> {
    let part = |from: [f32; 3], to: [f32; 3], radius| Part { from: from.into(), to: to.into(), radius };
    let mut parts = vec![
        // Trunk, neck, head, muzzle, tail.
        part([0.0, 0.4, -0.2], [0.0, 0.62, 0.12], [0.38, 0.27]),
        part([0.0, 0.66, 0.14], [0.0, 0.95, 0.24], [0.2, 0.17]),
        part([0.0, 1.02, 0.22], [0.0, 1.0, 0.32], [0.22, 0.21]),
        part([0.0, 0.95, 0.42], [0.0, 0.91, 0.52], [0.13, 0.09]),
        part([0.0, 0.3, -0.58], [0.0, 0.36, -0.63], [0.12, 0.11]),
    ];
    for side in [-1.0, 1.0] {
        let mut pair = |from: [f32; 3], to: [f32; 3], radius| {
            parts.push(part([side * from[0], from[1], from[2]], [side * to[0], to[1], to[2]], radius));
        };
        // Thigh, hind foot, foreleg, paw, cheek, ear.
        pair([0.22, 0.34, -0.22], [0.28, 0.22, 0.02], [0.25, 0.17]);
        pair([0.28, 0.08, -0.1], [0.29, 0.07, 0.3], [0.08, 0.075]);
        pair([0.13, 0.5, 0.24], [0.11, 0.1, 0.34], [0.11, 0.065]);
        pair([0.11, 0.065, 0.34], [0.11, 0.06, 0.43], [0.065, 0.055]);
        pair([0.1, 0.92, 0.4], [0.06, 0.91, 0.46], [0.1, 0.09]);
        pair([0.09, 1.18, 0.16], [0.19, 1.52, 0.02], [0.055, 0.085]);
        pair([0.19, 1.52, 0.02], [0.23, 1.74, -0.04], [0.085, 0.03]);
    }
    parts
}

/// All parts, grown together.
fn field(parts: &[Part], p: Vec3) -> f32 {
    parts.iter().map(|part| part.distance(p)).fold(f32::INFINITY, |a, b| {
        // Far parts do not count, and infinity does not mix.
        if (a - b).abs() >= BLEND {
            return a.min(b);
        }
        let share = 0.5 + 0.5 * (b - a) / BLEND;
        b + (a - b) * share - BLEND * share * (1.0 - share)
    })
}

/// The mesh alone.
fn mesh(material: u32) -> Mesh {
    let parts = parts();
    let grid = Grid { corner: vec3(-0.62, -0.06, -0.82), edge: 0.02, cubes: [62, 94, 72] };
    surface("hare", &grid, |p| field(&parts, p), material)
}

/// The hare on a floor, in daylight.
pub(crate) fn hare() -> Scene {
    let material = |name: &str, color| Material::new(name, MaterialKind::Matte { color });
    let mut scene = Scene {
        materials: vec![material("clay", vec3(0.62, 0.42, 0.28)), material("floor", vec3(0.55, 0.58, 0.56))],
        ..Scene::default()
    };
    scene.meshes.push(mesh(0));
    scene.instances.push(Instance::new(0, Transform::default()));
    let (edge_u, edge_v) = (vec3(24.0, 0.0, 0.0), vec3(0.0, 0.0, -24.0));
    scene.parallelograms.push(Parallelogram { corner: vec3(-12.0, 0.0, 12.0), edge_u, edge_v, material: 1 });
    scene.lights = vec![
        Light::Directional { direction: vec3(-0.6, -1.0, -0.7), color: vec3(3.0, 2.8, 2.5) },
        Light::Point { position: vec3(-3.0, 2.5, 2.0), color: vec3(4.0, 5.0, 7.0) },
    ];
    scene.camera = Some(Camera {
        position: vec3(1.9, 1.25, 3.3),
        look_at: Some(vec3(0.0, 0.85, -0.05)),
        fov_x_degrees: 40.0,
        ..Camera::default()
    });
    scene.settings = RenderSettings {
        size: [640, 640],
        samples: 8,
        ambient: 0.3,
        background: vec3(0.45, 0.55, 0.68),
        ..RenderSettings::default()
    };
    scene
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::HashSet;

    #[test]
    fn it_is_closed_and_of_one_piece() {
        let mesh = mesh(0);
        assert!((50_000..200_000).contains(&mesh.triangles.len()), "{} triangles", mesh.triangles.len());
        let mut edges = HashSet::new();
        for triangle in &mesh.triangles {
            let [a, b, c] = triangle.positions;
            assert!([(a, b), (b, c), (c, a)].into_iter().all(|edge| edges.insert(edge)));
        }
        assert!(edges.iter().all(|&(a, b)| edges.contains(&(b, a))));
        // Vertices - edges + triangles is 2 for a surface without handles.
        let (vertices, triangles) = (mesh.positions.len() as i64, mesh.triangles.len() as i64);
        let pieces = (vertices - edges.len() as i64 / 2 + triangles) / 2;
        assert!(pieces <= 1, "{pieces} pieces");
    }

    /// The same numbers on every machine: no function is called whose last bits differ.
    #[test]
    fn it_is_the_same_everywhere() {
        let mesh = mesh(0);
        let sum = mesh.positions.iter().flat_map(|&p| <[f32; 3]>::from(p));
        let sum = sum.fold(0u32, |sum, x| sum.rotate_left(5) ^ x.to_bits());
        assert_eq!((mesh.triangles.len(), sum), (101_716, 2_662_333_020));
    }
}
