//! What a ray does at the surface that it found.

use super::{Media, Numbers, PathPoint, PathState, limited, power_share};
use crate::integrator::coverage::MAX_HOLES;
use crate::integrator::{PathRay, RayKind};
use crate::light::light_of_primitive;
use crate::math::{Vec3, max, min};
use crate::ray::PrimitiveId;
use crate::shading::left_by_body;
use crate::sums::MAX_RADIANCE;
use crate::view::{SceneView, item};

/// What becomes of a ray at a surface.
#[derive(Clone, Copy, Debug)]
pub enum Arrival {
    /// Nothing more.
    Ended,
    /// It goes on behind the surface, as if that were not there, with this weight.
    Passed(Vec3),
    /// It is scattered: what follows is multiplied by this weight.
    Met(Vec3),
}

/// The least chance of going on that paths are given by roulette.
const LEAST_CHANCE: f32 = 0.05;

/// What the ray brings from the point, at distance `t`, and what becomes of it.
#[inline(always)]
pub fn arrive<N: Numbers>(
    view: &SceneView,
    point: &PathPoint,
    path: &PathState,
    t: f32,
    numbers: &N,
) -> (Vec3, Arrival) {
    let (settings, ray) = (view.settings, &path.ray);
    let material = &point.material_values;
    // Limited, so that no product becomes infinite: infinity times 0 would be NaN.
    // The body that the ray is in; or else, seen from behind, the one that it must have started in.
    let within = Media::of(ray).material().or(if point.front { None } else { Some(point.material) });
    let weight = match within {
        Some(material) => ray.weight * left_by_body(view, material, t),
        None => ray.weight,
    };
    let weight = weight.min(Vec3::splat(MAX_RADIANCE));
    let behind = straight_share(point);
    let chance = min(behind.max_component(), 1.0);
    let is_by_chance = (chance > 0.0) | (ray.depth >= settings.roulette_depth);
    let [pass, survival] = if is_by_chance { numbers.arrival() } else { [0.0; 2] };
    if (chance > 0.0) & (pass < chance) {
        let is_too_many = ray.holes >= MAX_HOLES;
        let passed = Arrival::Passed(weight * behind * (1.0 / chance));
        return (Vec3::ZERO, if is_too_many { Arrival::Ended } else { passed });
    }
    let mut weight = if chance > 0.0 { weight * (point.coverage / (1.0 - chance)) } else { weight };
    let mut found = Vec3::ZERO;
    if material.emission.max_component() > 0.0 {
        let lamp = (point.id, point.material, point.front);
        let share = lamp_share(view, lamp, path, ray.travelled + t);
        found = limited(settings, ray.depth > 1, weight * material.emission * share);
    }
    if ray.depth >= settings.roulette_depth {
        weight = after_roulette(weight, survival);
    }
    (found, if weight.max_component() > 0.0 { Arrival::Met(weight) } else { Arrival::Ended })
}

/// The weight of a path where a number decides whether it goes on: 0 where it does not.
#[inline(always)]
pub(super) fn after_roulette(weight: Vec3, number: f32) -> Vec3 {
    let chance = min(max(weight.max_component(), LEAST_CHANCE), 1.0);
    if number >= chance { Vec3::ZERO } else { weight * (1.0 / chance) }
}

/// What goes straight on at a point, per channel, without meeting the surface.
#[inline(always)]
pub(super) fn straight_share(point: &PathPoint) -> Vec3 {
    point.material_values.through * point.coverage + Vec3::splat(1.0 - point.coverage)
}

/// The ray behind a surface that it passes at distance `t`. It is no bounce, and what it meets was found by the lobe before.
#[inline(always)]
pub(super) fn ray_behind(point: &PathPoint, ray: &PathRay, weight: Vec3, t: f32) -> PathRay {
    ray_from(point.offset_origin(ray.direction), point.id, ray, weight, t)
}

/// The same from a place behind a primitive.
#[inline(always)]
pub(super) fn ray_from(origin: Vec3, start: PrimitiveId, ray: &PathRay, weight: Vec3, t: f32) -> PathRay {
    PathRay {
        origin,
        weight,
        kind: RayKind::Refracted,
        start,
        holes: ray.holes + 1,
        travelled: ray.travelled + t,
        ..*ray
    }
}

/// The share of the radiance of what shines (a primitive, its material, and whether the ray met its front) that counts where a ray
/// of a lobe found it this far from where the lobe is. All counts of what no light sample finds: what has holes, spheres from
/// within, and what was met from the camera, a mirror or glass.
#[inline(always)]
pub(super) fn lamp_share(
    view: &SceneView,
    (id, material, front): (PrimitiveId, u32, bool),
    path: &PathState,
    distance: f32,
) -> f32 {
    let ray = &path.ray;
    let geometry = item(view.geometries, item(view.instances, id.instance).geometry);
    let material = item(view.materials, material);
    let is_triangle = id.primitive < geometry.triangle_count;
    if is_triangle & !front & material.is_lamp_of_paths() & !material.shines_to_both_sides() {
        return 0.0;
    }
    if !(ray.lobe_density > 0.0) {
        return 1.0;
    }
    let Some(number) = light_of_primitive(view.lights, id) else { return 1.0 };
    let Some(light) = view.lights.get(number as usize) else { return 1.0 };
    let density = light.pdf_li(path.left.position, ray.direction, distance);
    let chance = view.light_tree().chance(&path.left, number) * (1.0 - view.environment.chance);
    power_share(ray.lobe_density, density * chance)
}
