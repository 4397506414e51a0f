//! Lights: those of the scene, then every triangle that shines.

use super::geometry::Flat;
use super::normals;
use super::note::Note;
use crate::model::{Light as ModelLight, Scene};
use eosphor_core::geometry::Geometry;
use eosphor_core::light::Light;
use eosphor_core::material::{Material, NONE};
use eosphor_core::math::{Vec3, elementary64, vec3};

/// More emissive triangles than this are worth a note.
const MANY: u32 = 256;

/// The scene's own lights in a frame, in its order.
pub(super) fn explicit(scene: &Scene, frame: u32) -> Vec<Light> {
    scene.lights_at(frame).iter().map(light).collect()
}

fn light(light: &ModelLight) -> Light {
    let unit = |d: Vec3| d.normalize_or(vec3(0.0, -1.0, 0.0));
    match *light {
        ModelLight::Point { position, color } => Light::Point { position, intensity: color },
        ModelLight::Directional { direction, color } => {
            Light::Directional { to_light: -unit(direction), irradiance: color }
        }
        ModelLight::Spot { position, direction, inner_degrees, outer_degrees, color } => Light::Spot {
            position,
            axis: unit(direction),
            intensity: color,
            cos_inner: cos_degrees(inner_degrees),
            cos_outer: cos_degrees(outer_degrees),
        },
    }
}

fn cos_degrees(degrees: f32) -> f32 {
    elementary64::cos(f64::from(degrees) * (std::f64::consts::PI / 180.0)) as f32
}

/// One light for each placed triangle that shines and has an area: those of the world first, then those of each
/// instance. Spheres that shine are only seen.
pub(super) fn emissive_triangles(
    scene: &Scene,
    flat: &Flat,
    materials: &[Material],
    notes: &mut Vec<Note>,
) -> Vec<Light> {
    // Textured emitters are seen but light nothing: what they shine differs from point to point.
    let shines = |m: u32| {
        let material = &materials[m as usize];
        material.emission.max_component() > 0.0 && material.emission_texture == NONE
    };
    let samples = scene.settings.light_samples;
    let mut lights = Vec::new();
    // Geometries are looked through once, however often they are placed.
    let shining_triangles = |geometry: &Geometry| -> Vec<u32> {
        let material = |k: u32| flat.triangle_shading[(geometry.first_triangle + k) as usize].material;
        (0..geometry.triangle_count).filter(|&k| shines(material(k))).collect()
    };
    let shining: Vec<Vec<u32>> = flat.geometries.iter().map(shining_triangles).collect();
    for (number, instance) in flat.instances.iter().enumerate() {
        let geometry = &flat.geometries[instance.geometry as usize];
        let mirrored = instance.world_from_object.determinant() < 0.0;
        let all: Vec<u32>;
        let primitives = match instance.material {
            NONE => &shining[instance.geometry as usize],
            material if shines(material) => {
                all = (0..geometry.triangle_count).collect();
                &all
            }
            _ => continue,
        };
        for &primitive in primitives {
            let i = (geometry.first_triangle + primitive) as usize;
            let material = match instance.material {
                NONE => flat.triangle_shading[i].material,
                material => material,
            };
            let mut vertices = flat.triangles[i];
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
            let radiance = materials[material as usize].emission;
            let instance = number as u32;
            lights.push(Light::Triangle {
                v0,
                e1: v1 - v0,
                e2: v2 - v0,
                normal,
                area,
                radiance,
                samples,
                instance,
                primitive,
            });
        }
    }
    let count = lights.len() as u32;
    if count > MANY {
        notes.push(Note::ManyLights { count, rays: u64::from(count) * u64::from(samples) });
    }
    let spheres = flat.sphere_materials.iter().filter(|&&m| shines(m)).count() as u32;
    if spheres > 0 {
        notes.push(Note::EmissiveSpheres { count: spheres });
    }
    lights
}
