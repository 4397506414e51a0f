//! Lights: those of the scene, then every triangle that shines. Here light becomes what surfaces answer: [`answered`].

use super::SceneData;
use super::light_tree::{self, LightTreeArrays, Plan};
use super::normals;
use super::note::Note;
use crate::model::{Light as ModelLight, LightSelection, LightUnits, RenderSettings, Scene};
use eosphor_core::geometry::{Geometry, Instance, Sphere, TriangleShading};
use eosphor_core::light::Light;
use eosphor_core::material::{Material, NONE};
use eosphor_core::math::{Vec3, elementary64, vec3};
use eosphor_core::sampling::{point_2d, triangle_point};
use eosphor_core::settings::Integrator;
use eosphor_core::shading::emission_texel;
use eosphor_core::view::SceneView;

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

/// Primitives that shine, geometry after geometry: looked for once, however often geometries are placed.
#[derive(Clone)]
pub(super) struct Emitters {
    /// Of each geometry, numbers there: of triangles, then of spheres.
    shining: Vec<Vec<u32>>,
    integrator: Integrator,
}

/// To Whitted's integrator textured emitters are seen but are no lights: what they shine differs from point to point.
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
    /// Of the scene's own lights and those that shine by themselves, each of which has got one sample. `view` has the arrays of
    /// the frame; `alike` is a scene whose tree is of such settings: it is taken if the lights are the same.
    pub(super) fn new(
        mut lights: Vec<Light>,
        shining: Vec<Light>,
        settings: &RenderSettings,
        view: &SceneView,
        alike: Option<&SceneData>,
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
        let tree = if let Some(data) = alike.filter(|data| data.lights == lights) {
            LightTreeArrays { nodes: data.light_nodes.clone(), places: data.light_places.clone() }
        } else if selection == LightSelection::All {
            LightTreeArrays::default()
        } else {
            light_tree::build(&lights, &plan, |light| texel_share(view, light))
        };
        LightArrays { lights, tree }
    }
}

impl Emitters {
    pub(super) fn new(
        geometries: &[Geometry],
        triangle_shading: &[TriangleShading],
        sphere_materials: &[u32],
        materials: &[Material],
        integrator: Integrator,
    ) -> Emitters {
        let shining = |geometry: &Geometry| -> Vec<u32> {
            let material = |&number: &u32| match number.checked_sub(geometry.triangle_count) {
                None => triangle_shading[(geometry.first_triangle + number) as usize].material,
                Some(sphere) => sphere_materials[(geometry.first_sphere + sphere) as usize],
            };
            let shines = |number: &u32| shines(&materials[material(number) as usize], integrator);
            (0..primitives(geometry, integrator)).filter(shines).collect()
        };
        Emitters { shining: geometries.iter().map(shining).collect(), integrator }
    }

    pub(super) fn is_empty(&self) -> bool {
        self.shining.iter().all(Vec::is_empty)
    }

    /// Whether an instance of a geometry from this number on shines.
    pub(super) fn shine_from(&self, first_geometry: usize, view: &SceneView) -> bool {
        let shining = |instance: &Instance| match instance.material {
            NONE => !self.shining[instance.geometry as usize].is_empty(),
            material => shines(&view.materials[material as usize], self.integrator),
        };
        view.instances.iter().filter(|i| i.geometry as usize >= first_geometry).any(shining)
    }

    /// One light for each placed primitive that shines and has an area: those of the world first, then those of each instance.
    pub(super) fn lights(
        &self,
        settings: &RenderSettings,
        view: &SceneView,
        instances: &[Instance],
    ) -> Vec<Light> {
        let mut lights = Vec::new();
        for (number, instance) in instances.iter().enumerate() {
            self.add_lights(number as u32, instance, settings, view, &mut lights);
        }
        lights
    }

    fn add_lights(
        &self,
        number: u32,
        instance: &Instance,
        settings: &RenderSettings,
        view: &SceneView,
        lights: &mut Vec<Light>,
    ) {
        let geometry = &view.geometries[instance.geometry as usize];
        let all: Vec<u32>;
        let primitives = match instance.material {
            NONE => &self.shining[instance.geometry as usize],
            material if shines(&view.materials[material as usize], self.integrator) => {
                all = (0..primitives(geometry, self.integrator)).collect();
                &all
            }
            _ => return,
        };
        for &primitive in primitives {
            let placed = Placed { instance, number, primitive };
            lights.extend(match primitive.checked_sub(geometry.triangle_count) {
                None => triangle(&placed, (geometry.first_triangle + primitive) as usize, settings, view),
                Some(sphere_number) => {
                    sphere(&placed, (geometry.first_sphere + sphere_number) as usize, settings, view)
                }
            });
        }
    }
}

/// A primitive of an instance.
struct Placed<'a> {
    instance: &'a Instance,
    /// Of the instance.
    number: u32,
    /// In the instance's geometry.
    primitive: u32,
}

impl Placed<'_> {
    /// The material that it has there, where `own` is that of the geometry.
    fn material<'d>(&self, own: u32, view: &SceneView<'d>) -> &'d Material {
        let instance = self.instance.material;
        &view.materials[if instance == NONE { own } else { instance } as usize]
    }
}

/// A triangle that shines, the `i`th of all; `None` where it has no area.
fn triangle(placed: &Placed, i: usize, settings: &RenderSettings, view: &SceneView) -> Option<Light> {
    let Placed { instance, number, primitive } = *placed;
    let material = placed.material(view.triangle_shading[i].material, view);
    let mut vertices = view.triangles[i];
    let mut is_turned = false;
    if number > 0 {
        vertices = vertices.map(|v| instance.world_from_object.point(v));
        if instance.world_from_object.determinant() < 0.0 {
            // Where a texture tells corners apart, they keep their order.
            is_turned = material.emission_texture != NONE;
            if !is_turned {
                vertices.swap(1, 2);
            }
        }
    }
    let area = (normals::length(normals::area_vector(&vertices)) * 0.5) as f32;
    let normal = normals::of_triangle(&vertices).filter(|_| area > 0.0 && area.is_finite())?;
    let [v0, v1, v2] = vertices;
    Some(Light::Triangle {
        v0,
        e1: v1 - v0,
        e2: v2 - v0,
        normal: if is_turned { -normal } else { normal },
        area,
        color: answered(material.emission, settings.light_units),
        texture: material.emission_texture,
        is_two_sided: settings.integrator == Integrator::Path && material.shines_to_both_sides(),
        samples: 1,
        instance: number,
        primitive,
    })
}

/// How much the scale of an instance may differ between directions for its spheres to be lights.
const ROUND: f64 = 1e-5;

/// A sphere that shines, the `i`th of all; `None` where an instance makes it an ellipsoid: that is only seen.
fn sphere(placed: &Placed, i: usize, settings: &RenderSettings, view: &SceneView) -> Option<Light> {
    let Placed { instance, number, primitive } = *placed;
    let material = placed.material(view.sphere_materials[i], view);
    let Sphere { mut center, mut radius } = view.spheres[i];
    if number > 0 {
        let map = &instance.world_from_object;
        let [x, y, z] = map.columns.map(|c| [c.x, c.y, c.z].map(f64::from));
        let dot = |a: [f64; 3], b: [f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
        let squared = dot(x, x);
        let is_off = |value: f64, wanted: f64| (value - wanted).abs() > ROUND * squared;
        if is_off(dot(y, y), squared) || is_off(dot(z, z), squared) {
            return None;
        }
        if is_off(dot(x, y), 0.0) || is_off(dot(y, z), 0.0) || is_off(dot(z, x), 0.0) {
            return None;
        }
        (center, radius) = (map.point(center), (f64::from(radius) * squared.sqrt()) as f32);
    }
    let color = answered(material.emission, settings.light_units);
    let is_usual = radius > 0.0 && radius.is_finite();
    is_usual.then_some(Light::Sphere { center, radius, color, instance: number, primitive })
}

/// Primitives that may be lights: spheres are to paths alone.
fn primitives(geometry: &Geometry, integrator: Integrator) -> u32 {
    match integrator {
        Integrator::Whitted => geometry.triangle_count,
        Integrator::Path => geometry.triangle_count + geometry.sphere_count,
    }
}

/// How bright the texture of a lamp is on average, over 1. No lamp is left out because the places that are read are dark.
fn texel_share(view: &SceneView, light: &Light) -> f64 {
    const READS: u32 = 16;
    const LEAST: f64 = 1.0 / 256.0;
    let Light::Triangle { texture, .. } = *light else { return 1.0 };
    if texture == NONE {
        return 1.0;
    }
    let read = |number: u32| {
        let place = triangle_point(point_2d(number, 0));
        let color = emission_texel(view, light.primitive(), texture, place);
        (f64::from(color.x) + f64::from(color.y) + f64::from(color.z)) / 3.0
    };
    let mean = (0..READS).map(read).sum::<f64>() / f64::from(READS);
    if mean.is_finite() { mean.max(LEAST) } else { 1.0 }
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
