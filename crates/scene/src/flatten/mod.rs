//! Scene → SceneData: the flat arrays that devices read.
//!
//! Everything here reaches pixels, so it keeps the picture contract: only `eosphor-core`'s arithmetic and correctly
//! rounded `+ - * /` and square roots, in serial and fixed order.

mod bodies;
mod camera;
mod check;
mod environment;
mod frame_state;
mod framing;
mod geometry;
mod light_tree;
mod lights;
mod materials;
mod normals;
mod note;
mod places;
mod settings;
mod shapes;
mod textures;
mod turntable;
mod view;

#[cfg(test)]
mod path_tests;
#[cfg(test)]
mod tests;

use crate::error::{Problem, SceneError};
use crate::model::Scene;
use eosphor_core::environment::Environment;
use eosphor_core::geometry::{Geometry, Instance, Sphere, TriangleExtra, TriangleShading};
use eosphor_core::light::{Light, LightNode};
use eosphor_core::settings::{Integrator, Settings};
use eosphor_core::texture::Texture;
use eosphor_core::{camera::Camera, material::Material, math::Vec3};
use lights::LightArrays;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

pub use frame_state::{FrameBounds, FrameState, FrameStates, Places};
pub use framing::{LeftOut, View};
pub use note::Note;
pub use shapes::{ShapedArrays, Shapes};

/// What machines read: plain arrays with indices instead of pointers. Hierarchies are built over it (`eosphor-accel`)
/// and devices take it as it is. For other processes of the same program it can be written and read by serde.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct SceneData {
    /// Vertices of all triangles, geometry after geometry.
    pub triangles: Vec<[Vec3; 3]>,
    /// All spheres, geometry after geometry.
    pub spheres: Vec<Sphere>,
    /// Ranges of the above; number 0 is the world.
    pub geometries: Vec<Geometry>,
    /// Placed geometries; number 0 is the world itself.
    pub instances: Vec<Instance>,
    /// Whether frames of the animation have instances elsewhere, or of other extents.
    pub instances_move: bool,
    /// How many geometries, the last ones, have other shapes in other frames ([`Shapes`]).
    pub deforming_geometries: u32,
    /// Normals, texture coordinates and material of each triangle.
    pub triangle_shading: Vec<TriangleShading>,
    /// Vertex colours and second texture coordinates of the triangles that have them.
    pub triangle_extras: Vec<TriangleExtra>,
    /// The number of the material of each sphere.
    pub sphere_materials: Vec<u32>,
    /// Materials, with reflection and transmission composed.
    pub materials: Vec<Material>,
    /// Headers of the textures.
    pub textures: Vec<Texture>,
    /// Words of the texels of all textures; the scene's own, where it was loaded.
    #[serde(with = "textures::words_of_its_own")]
    pub texture_words: Arc<Vec<u32>>,
    /// Linear value of each sRGB byte.
    #[serde(skip, default = "textures::srgb_decode")]
    pub srgb_decode: [f32; 256],
    /// Lights, the emissive triangles last.
    pub lights: Vec<Light>,
    /// The tree by which lights are chosen; empty where all of them are sampled.
    pub light_nodes: Vec<LightNode>,
    /// Of each light, its place among the leaves of that; as many as lights, or none.
    pub light_places: Vec<u32>,
    /// What surrounds the scene.
    pub environment: Environment,
    /// Its cells by how bright they are.
    pub environment_table: Vec<u32>,
    /// The camera.
    pub camera: Camera,
    /// The settings that pixels depend on.
    pub settings: Settings,
}

/// What only path tracing has.
fn check_for_whitted(scene: &Scene) -> Result<(), Problem> {
    let rough = scene.materials.iter().find(|material| material.diffuse_roughness > 0.0);
    let what = match rough {
        _ if scene.environment.is_some() => "environment".to_string(),
        Some(material) => format!("material \"{}\", diffuse-roughness", material.name),
        None => return Ok(()),
    };
    Err(Problem::new(what, "the integrator whitted has none; use the integrator path, or leave it out"))
}

impl SceneData {
    /// Makes the arrays of a scene. The notes say what the scene left open and what was done about it.
    ///
    /// A mesh that moves, whose vertices move, or that is placed more than once and has more than 256 triangles, becomes a
    /// geometry of its own with
    /// instances; everything else is baked into the world, geometry 0, in the order of the scene's instances, then
    /// parallelograms, then spheres. Nothing but the scene decides this. What moves is where it is in the scene's frame
    /// ([`Scene::frame`]); meshes whose vertices move are the last geometries.
    ///
    /// # Errors
    /// Whatever [`Scene::validate`] finds; transforms that cannot be inverted; a camera that spans no view; more
    /// primitives or texels than 32-bit numbers count.
    pub fn flatten(scene: &Scene) -> Result<(SceneData, Vec<Note>), SceneError> {
        scene.validate()?;
        let mut notes = Vec::new();
        if scene.origin != [0.0; 3] {
            notes.push(Note::FarOrigin { origin: scene.origin });
        }

        let mut materials: Vec<Material> =
            scene.materials.iter().map(|m| materials::compose(m, scene.settings.composition)).collect();
        let geometry = geometry::build(scene, scene.frame)?;
        if scene.settings.integrator == Integrator::Path {
            bodies::mark(&mut materials, &geometry);
        }
        if scene.settings.integrator != Integrator::Path {
            check_for_whitted(scene)?;
        }
        let textures = textures::build(scene)?;
        let srgb_decode = textures::srgb_decode();
        let (environment, environment_table) = environment::build(scene, &textures, &srgb_decode);

        let world = places::world_bounds(&geometry.bounds, &geometry.instances);
        let (camera, headlight) = camera::build(scene, &geometry, &world, &mut notes)?;
        let settings = settings::build(&scene.settings, &camera, &world);
        let mut data = SceneData {
            triangles: geometry.triangles,
            spheres: geometry.spheres,
            geometries: geometry.geometries,
            instances: geometry.instances,
            instances_move: scene.has_moving_instances() || geometry.deforming > 0,
            deforming_geometries: geometry.deforming,
            triangle_shading: geometry.triangle_shading,
            triangle_extras: geometry.triangle_extras,
            sphere_materials: geometry.sphere_materials,
            materials,
            textures: textures.headers,
            texture_words: textures.words,
            srgb_decode,
            lights: lights::explicit(scene, scene.frame),
            light_nodes: Vec::new(),
            light_places: Vec::new(),
            environment,
            environment_table,
            camera,
            settings,
        };
        let emitters = data.emitters();
        let shining = emitters.lights(&scene.settings, &data.view(), &data.instances);
        if scene.settings.integrator == Integrator::Whitted {
            let selection = lights::selection(&scene.settings, shining.len());
            lights::notes(&shining, selection, scene.settings.light_samples, &data, &mut notes);
        }
        let own = std::mem::take(&mut data.lights);
        let LightArrays { lights, tree } =
            LightArrays::new(own, shining, &scene.settings, &data.view(), None);
        (data.lights, data.light_nodes, data.light_places) = (lights, tree.nodes, tree.places);
        // What moves may shine in another frame, though it has no area in this one.
        let may_shine = data.instances_move && !emitters.is_empty();
        let is_dark = data.lights.is_empty() && !may_shine && settings::needs_light(&scene.settings);
        if scene.settings.integrator == Integrator::Path {
            if data.environment.chance > 0.0 {
                data.environment.chance = environment::chance(!data.lights.is_empty() || may_shine);
            }
            if scene.environment.is_some() && data.environment.chance == 0.0 {
                notes.push(Note::DarkEnvironment);
            }
            data.settings.shadow_mode = settings::shadows_of_paths(&data.materials);
            // What shines without being a light is found all the same.
            let shines = data.materials.iter().any(|m| m.emission.max_component() > 0.0);
            let added = settings::surroundings(&scene.settings);
            let is_dark = is_dark && !shines && scene.environment.is_none();
            if let Some(radiance) = added.filter(|_| is_dark && scene.settings.headlight) {
                notes.push(Note::Surroundings { radiance: radiance.x });
                data.settings.background = radiance;
            }
            return Ok((data, notes));
        }
        if let Some(light) = headlight.filter(|_| is_dark && scene.settings.headlight) {
            notes.push(Note::Headlight { position: scene.point_in_file(camera.eye) });
            data.lights.push(light);
            data.settings.light_falloff = false;
        }
        Ok((data, notes))
    }

    fn emitters(&self) -> lights::Emitters {
        let integrator = self.settings.integrator;
        let (shading, spheres) = (&self.triangle_shading, &self.sphere_materials);
        lights::Emitters::new(&self.geometries, shading, spheres, &self.materials, integrator)
    }
}
