//! Scene → SceneData: the flat arrays that devices read.
//!
//! Everything here reaches pixels, so it keeps the picture contract: only `eosphor-core`'s arithmetic and correctly
//! rounded `+ - * /` and square roots, in serial and fixed order.

mod camera;
mod check;
mod geometry;
mod lights;
mod materials;
mod moment;
mod normals;
mod note;
mod settings;
mod textures;
mod view;

#[cfg(test)]
mod tests;

use crate::error::SceneError;
use crate::model::Scene;
use eosphor_core::geometry::{Geometry, Instance, Sphere, TriangleExtra, TriangleShading};
use eosphor_core::texture::Texture;
use eosphor_core::{camera::Camera, light::Light, material::Material, math::Vec3, settings::Settings};

pub use moment::{Moment, Moments};
pub use note::Note;

/// What machines read: plain arrays with indices instead of pointers. Hierarchies are built over it (`eosphor-accel`)
/// and devices take it as it is.
#[derive(Clone, Debug)]
pub struct SceneData {
    /// Vertices of all triangles, geometry after geometry.
    pub triangles: Vec<[Vec3; 3]>,
    /// All spheres, geometry after geometry.
    pub spheres: Vec<Sphere>,
    /// Ranges of the above; number 0 is the world.
    pub geometries: Vec<Geometry>,
    /// Placed geometries; number 0 is the world itself.
    pub instances: Vec<Instance>,
    /// For each triangle.
    pub triangle_shading: Vec<TriangleShading>,
    /// Vertex colours and second texture coordinates of the triangles that have them.
    pub triangle_extras: Vec<TriangleExtra>,
    /// For each sphere, the number of its material.
    pub sphere_materials: Vec<u32>,
    /// Materials, composed.
    pub materials: Vec<Material>,
    /// Headers of the textures.
    pub textures: Vec<Texture>,
    /// Words of the texels of all textures.
    pub texture_words: Vec<u32>,
    /// Linear value of each sRGB byte.
    pub srgb_decode: [f32; 256],
    /// Lights, the emissive triangles last.
    pub lights: Vec<Light>,
    /// The camera.
    pub camera: Camera,
    /// Settings that reach a pixel.
    pub settings: Settings,
}

impl SceneData {
    /// Makes the arrays of a scene. The notes say what the scene left open and what was done about it.
    ///
    /// A mesh that is placed more than once and has more than 256 triangles becomes a geometry of its own with
    /// instances; everything else is baked into the world, geometry 0, in the order of the scene's instances, then
    /// parallelograms, then spheres. Nothing but the scene decides this.
    ///
    /// # Errors
    /// Whatever [`Scene::validate`] finds; transforms that cannot be inverted; a camera that spans no view; more
    /// primitives or texels than 32-bit numbers count.
    pub fn flatten(scene: &Scene) -> Result<(SceneData, Vec<Note>), SceneError> {
        scene.validate()?;
        let mut notes = Vec::new();

        let materials: Vec<Material> =
            scene.materials.iter().map(|m| materials::compose(m, scene.settings.composition)).collect();
        let mut geometry = geometry::build(scene)?;
        view::order_corners(
            &mut geometry.triangles,
            &mut geometry.triangle_shading,
            &mut geometry.triangle_extras,
        );
        let textures = textures::build(scene)?;

        let world = geometry.world_bounds();
        let (camera, headlight) = camera::build(scene, &world, &mut notes)?;
        let mut lights = lights::explicit(scene, 0);
        lights.extend(lights::emissive_triangles(scene, &geometry, &materials, &mut notes));
        let mut settings = settings::build(&scene.settings, &camera, &world);
        if let Some(light) = headlight.filter(|_| lights.is_empty() && settings::needs_light(&scene.settings))
        {
            notes.push(Note::Headlight { position: camera.eye.into() });
            lights.push(light);
            settings.light_falloff = false;
        }

        let data = SceneData {
            triangles: geometry.triangles,
            spheres: geometry.spheres,
            geometries: geometry.geometries,
            instances: geometry.instances,
            triangle_shading: geometry.triangle_shading,
            triangle_extras: geometry.triangle_extras,
            sphere_materials: geometry.sphere_materials,
            materials,
            textures: textures.headers,
            texture_words: textures.words,
            srgb_decode: textures::srgb_decode(),
            lights,
            camera,
            settings,
        };
        Ok((data, notes))
    }
}
