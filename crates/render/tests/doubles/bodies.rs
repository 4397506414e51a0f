//! Scenes of small bodies, made at any size and anywhere.

use crate::shapes::Closed;
use crate::vector::*;
use eosphor_core::math::Vec3;
use eosphor_core::settings::{LightingModel, ShadowMode};
use eosphor_scene::{
    Camera, Instance, Light, Material, MaterialKind, Mesh, NO_INDEX, NormalMode, PixelSampling,
    RenderSettings, Scene, Sphere, Transform, Triangle,
};

/// Takes what is said in units of a body into a scene: scaled, turned, moved and rounded to single precision.
pub(crate) struct Bodies {
    pub(crate) scene: Scene,
    scale: f64,
    axes: [V; 3],
    shift: V,
}

impl Bodies {
    /// One sample in the middle of each pixel, and nothing cut off.
    pub(crate) fn new(scale: f64, shift: V) -> Bodies {
        let settings = RenderSettings {
            size: [64, 48],
            pixel_sampling: PixelSampling::Center,
            energy_threshold: 0.0,
            lighting: LightingModel::Lambert,
            shadows: ShadowMode::Opaque,
            normals: NormalMode::Flat,
            max_distance: Some(scale as f32),
            // So that lamps of any size of scene are within the range of colours.
            light_falloff: false,
            background: single([0.25, 0.35, 0.5]),
            depth: 6,
            ..RenderSettings::default()
        };
        let axes = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        Bodies { scene: Scene { settings, ..Scene::default() }, scale, axes, shift }
    }

    /// The same about other axes: three unit vectors.
    pub(crate) fn turned(scale: f64, shift: V, axes: [V; 3]) -> Bodies {
        Bodies { axes, ..Bodies::new(scale, shift) }
    }

    pub(crate) fn direction(&self, d: V) -> V {
        let [x, y, z] = self.axes;
        along(along(scaled(x, d[0]), y, d[1]), z, d[2])
    }

    pub(crate) fn point(&self, p: V) -> V {
        along(self.shift, self.direction(p), self.scale)
    }

    pub(crate) fn material(&mut self, kind: MaterialKind) -> u32 {
        self.scene.materials.push(Material::new(format!("m{}", self.scene.materials.len()), kind));
        self.scene.materials.len() as u32 - 1
    }

    pub(crate) fn matte(&mut self, r: f32, g: f32, b: f32) -> u32 {
        self.material(MaterialKind::Matte { color: Vec3::from([r, g, b]) })
    }

    pub(crate) fn mirror(&mut self) -> u32 {
        self.material(MaterialKind::Mirror { reflectance: Vec3::splat(0.9) })
    }

    pub(crate) fn glass(&mut self, ior: f32) -> u32 {
        self.material(MaterialKind::Dielectric { ior, tint: Vec3::from([0.9, 1.0, 0.95]) })
    }

    pub(crate) fn sphere(&mut self, center: V, radius: f64, material: u32) {
        let center = single(self.point(center));
        self.scene.spheres.push(Sphere { center, radius: (radius * self.scale) as f32, material });
    }

    /// A mesh of its own, of triangles of these points; returns its number.
    pub(crate) fn mesh(&mut self, points: &[Vec3], triangles: &[[usize; 3]], material: u32) -> u32 {
        let corners = |t: &[usize; 3]| t.map(|v| v as u32);
        let none = [NO_INDEX; 3];
        self.scene.meshes.push(Mesh {
            name: format!("mesh {}", self.scene.meshes.len()),
            positions: points.to_vec(),
            triangles: triangles
                .iter()
                .map(|t| Triangle { positions: corners(t), normals: none, uvs: none, material })
                .collect(),
            ..Mesh::default()
        });
        self.scene.meshes.len() as u32 - 1
    }

    /// A closed mesh, scaled and moved.
    pub(crate) fn closed(&mut self, shape: &Closed, size: f64, at: V, material: u32) {
        let points: Vec<Vec3> =
            shape.positions.iter().map(|p| single(self.point(along(at, *p, size)))).collect();
        let mesh = self.mesh(&points, &shape.triangles, material);
        self.scene.instances.push(Instance::new(mesh, Transform::default()));
    }

    /// A quadrangle: two triangles, counter-clockwise from its front.
    pub(crate) fn quad(&mut self, corners: [V; 4], material: u32) {
        let points = corners.map(|p| single(self.point(p)));
        let mesh = self.mesh(&points, &[[0, 1, 2], [0, 2, 3]], material);
        self.scene.instances.push(Instance::new(mesh, Transform::default()));
    }

    /// Tiles of two materials from -`half` to `half` at height `y`, `count` in a row.
    pub(crate) fn tiles(&mut self, half: f64, y: f64, count: usize, materials: [u32; 2]) {
        for k in 0..count * count {
            let side = 2.0 * half / count as f64;
            let (x, z) = ((k % count) as f64 * side - half, (k / count) as f64 * side - half);
            let corners = [[x, y, z], [x, y, z + side], [x + side, y, z + side], [x + side, y, z]];
            self.quad(corners, materials[(k % count + k / count) % 2]);
        }
    }

    /// A point light that gives this irradiance at any distance.
    pub(crate) fn lamp(&mut self, position: V, irradiance: f64) {
        let position = single(self.point(position));
        self.scene.lights.push(Light::Point { position, color: Vec3::splat(irradiance as f32) });
    }

    /// Light that goes along a direction.
    pub(crate) fn sun(&mut self, direction: V, irradiance: f64) {
        let direction = single(self.direction(direction));
        self.scene.lights.push(Light::Directional { direction, color: Vec3::splat(irradiance as f32) });
    }

    /// Looks from one point to another.
    pub(crate) fn camera(&mut self, from: V, to: V, fov_x_degrees: f32) {
        self.scene.camera = Some(Camera {
            position: single(self.point(from)),
            direction: single(self.direction(sub(to, from))),
            up: single(self.direction([0.0, 1.0, 0.0])),
            fov_x_degrees,
            ..Camera::default()
        });
    }
}
