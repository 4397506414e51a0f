//! Lights: those of the scene, then every triangle that shines. Here light becomes what surfaces answer: [`answered`].

use super::SceneData;
use super::light_tree::{self, LightTreeArrays, Plan};
use super::normals;
use super::note::Note;
use crate::model::{Light as ModelLight, LightSelection, LightUnits, RenderSettings, Scene};
use eosphor_core::geometry::{Geometry, Instance, TriangleShading};
use eosphor_core::light::Light;
use eosphor_core::material::{Material, NONE};
use eosphor_core::math::{Vec3, elementary64, vec3};
use eosphor_core::settings::Integrator;

/// More emissive triangles than so many get a note.
const MAX_LIGHTS_WITHOUT_NOTE: u32 = 256;

/// The scene's own lights in a frame, in its order.
pub(super) fn explicit(scene: &Scene, frame: u32) -> Vec<Light> {
    let units = scene.settings.light_units;
    scene.lights_at(frame).iter().map(|l| light(l, units)).collect()
}

/// What surfaces answer light of this colour by, before their own: a Lambertian surface that reflects a share rho of what it
/// gets sends rho / pi of its irradiance into every direction. The division is done here, once, so that shading has no factor
/// for it, and highlights keep their ratio to what is scattered.
fn answered(color: Vec3, units: LightUnits) -> Vec3 {
    let over_pi = |x: f32| (f64::from(x) * std::f64::consts::FRAC_1_PI) as f32;
    match units {
        LightUnits::Physical => vec3(over_pi(color.x), over_pi(color.y), over_pi(color.z)),
        LightUnits::Plain => color,
    }
}

fn light(light: &ModelLight, units: LightUnits) -> Light {
    let unit = |d: Vec3| d.normalize_or(vec3(0.0, -1.0, 0.0));
    match *light {
        ModelLight::Point { position, color } => Light::Point { position, color: answered(color, units) },
        ModelLight::Directional { direction, color } => {
            Light::Directional { to_light: -unit(direction), color: answered(color, units) }
        }
        ModelLight::Spot { position, direction, inner_degrees, outer_degrees, color } => Light::Spot {
            position,
            axis: unit(direction),
            color: answered(color, units),
            cos_inner: cos_degrees(inner_degrees),
            cos_outer: cos_degrees(outer_degrees),
        },
    }
}

fn cos_degrees(degrees: f32) -> f32 {
    elementary64::cos(f64::from(degrees) * (std::f64::consts::PI / 180.0)) as f32
}

/// Triangles that shine, geometry after geometry: looked for once, however often geometries are placed.
#[derive(Clone)]
pub(super) struct Emitters {
    /// Of each geometry, numbers there.
    shining: Vec<Vec<u32>>,
    integrator: Integrator,
}

/// Textured emitters are seen but are no lights: what they shine differs from point to point.
fn shines(material: &Material, integrator: Integrator) -> bool {
    match integrator {
        Integrator::Whitted => material.emission.max_component() > 0.0 && material.emission_texture == NONE,
        Integrator::Path => material.is_lamp_of_paths(),
    }
}

/// More lamps than so many are not all sampled by Whitted's integrator, unless the scene says so.
const MAX_LAMPS_OF_ALL: usize = 64;

/// How lights are chosen where so many lamps shine.
pub(super) fn selection(settings: &RenderSettings, lamps: usize) -> LightSelection {
    settings.lights.unwrap_or(match settings.integrator {
        Integrator::Whitted if lamps <= MAX_LAMPS_OF_ALL => LightSelection::All,
        Integrator::Whitted | Integrator::Path => LightSelection::Tree,
    })
}

/// Points that are sampled on a lamp where it is sampled.
pub(super) fn samples(settings: &RenderSettings, selection: LightSelection) -> u32 {
    if selection == LightSelection::All { settings.light_samples } else { 1 }
}

/// All lights of a frame, and the tree over them.
#[derive(Clone, Debug)]
pub(super) struct LightArrays {
    pub(super) lights: Vec<Light>,
    pub(super) tree: LightTreeArrays,
}

impl LightArrays {
    /// Of the scene's own lights and those that shine by themselves, each of which has got one sample. `known` has the tree of
    /// such settings, if its lights are the same.
    pub(super) fn new(
        mut lights: Vec<Light>,
        shining: Vec<Light>,
        settings: &RenderSettings,
        known: Option<&SceneData>,
    ) -> LightArrays {
        let selection = selection(settings, shining.len());
        lights.extend(shining);
        let count = samples(settings, selection);
        for light in &mut lights {
            if let Light::Triangle { samples, .. } = light {
                *samples = count;
            }
        }
        let plan = Plan { selection, lamps_only: settings.integrator == Integrator::Whitted };
        let tree = match known {
            Some(data) if data.lights == lights => {
                LightTreeArrays { nodes: data.light_nodes.clone(), places: data.light_places.clone() }
            }
            _ if selection == LightSelection::All => LightTreeArrays::default(),
            _ => light_tree::build(&lights, &plan),
        };
        LightArrays { lights, tree }
    }
}

impl Emitters {
    pub(super) fn new(
        geometries: &[Geometry],
        triangle_shading: &[TriangleShading],
        materials: &[Material],
        integrator: Integrator,
    ) -> Emitters {
        let shining = |geometry: &Geometry| -> Vec<u32> {
            let material = |k: u32| triangle_shading[(geometry.first_triangle + k) as usize].material;
            let shines = |k: &u32| shines(&materials[material(*k) as usize], integrator);
            (0..geometry.triangle_count).filter(shines).collect()
        };
        Emitters { shining: geometries.iter().map(shining).collect(), integrator }
    }

    pub(super) fn is_empty(&self) -> bool {
        self.shining.iter().all(Vec::is_empty)
    }

    /// One light for each placed triangle that shines and has an area: those of the world first, then those of each
    /// instance. Spheres that shine are only seen.
    pub(super) fn lights(
        &self,
        settings: &RenderSettings,
        data: &SceneData,
        instances: &[Instance],
    ) -> Vec<Light> {
        let mut lights = Vec::new();
        for (number, instance) in instances.iter().enumerate() {
            self.add_lights(number as u32, instance, settings, data, &mut lights);
        }
        lights
    }

    fn add_lights(
        &self,
        number: u32,
        instance: &Instance,
        settings: &RenderSettings,
        data: &SceneData,
        lights: &mut Vec<Light>,
    ) {
        let geometry = &data.geometries[instance.geometry as usize];
        let all: Vec<u32>;
        let primitives = match instance.material {
            NONE => &self.shining[instance.geometry as usize],
            material if shines(&data.materials[material as usize], self.integrator) => {
                all = (0..geometry.triangle_count).collect();
                &all
            }
            _ => return,
        };
        let mirrored = instance.world_from_object.determinant() < 0.0;
        for &primitive in primitives {
            let i = (geometry.first_triangle + primitive) as usize;
            let material = match instance.material {
                NONE => data.triangle_shading[i].material,
                material => material,
            };
            let mut vertices = data.triangles[i];
            if number > 0 {
                vertices = vertices.map(|v| instance.world_from_object.point(v));
                if mirrored {
                    vertices.swap(1, 2);
                }
            }
            let area = (normals::length(normals::area_vector(&vertices)) * 0.5) as f32;
            let Some(normal) = normals::of_triangle(&vertices).filter(|_| area > 0.0 && area.is_finite())
            else {
                continue;
            };
            let [v0, v1, v2] = vertices;
            let color = answered(data.materials[material as usize].emission, settings.light_units);
            let (samples, instance) = (1, number);
            lights.push(Light::Triangle {
                v0,
                e1: v1 - v0,
                e2: v2 - v0,
                normal,
                area,
                color,
                samples,
                instance,
                primitive,
            });
        }
    }
}

/// What is worth saying of the lights that shine by themselves, to Whitted's integrator.
pub(super) fn notes(
    shining: &[Light],
    selection: LightSelection,
    samples: u32,
    data: &SceneData,
    notes: &mut Vec<Note>,
) {
    let count = shining.len() as u32;
    if count > MAX_LIGHTS_WITHOUT_NOTE && selection == LightSelection::All {
        notes.push(Note::ManyLights { count, rays: u64::from(count) * u64::from(samples) });
    }
    let is_emitter = |m: &&u32| shines(&data.materials[**m as usize], Integrator::Whitted);
    let spheres = data.sphere_materials.iter().filter(is_emitter).count() as u32;
    if spheres > 0 {
        notes.push(Note::EmissiveSpheres { count: spheres });
    }
}
