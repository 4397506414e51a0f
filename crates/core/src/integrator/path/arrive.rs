//! What a ray does at the surface that it found.

use super::{Numbers, PathPoint, limited, power_share};
use crate::geometry::Instance;
use crate::integrator::coverage::MAX_HOLES;
use crate::integrator::{PathRay, RayKind};
use crate::math::{Vec3, max, min};
use crate::ray::PrimitiveId;
use crate::sums::MAX_RADIANCE;
use crate::view::{SceneView, item};

/// What becomes of a ray at a surface.
#[derive(Clone, Copy, Debug)]
pub enum Arrival {
    /// Nothing more.
    Ended,
    /// It goes on behind the surface, as if that were not there.
    Passed(PathRay),
    /// It is scattered: this is it, with the weight that what follows is multiplied by.
    Met(PathRay),
}

/// The least chance of going on that paths are given by roulette.
const LEAST_CHANCE: f32 = 0.05;

/// What the ray brings from the point, at distance `t`, and what becomes of it.
#[inline(always)]
pub fn arrive(
    view: &SceneView,
    point: &PathPoint,
    ray: &PathRay,
    t: f32,
    numbers: &Numbers,
) -> (Vec3, Arrival) {
    let settings = view.settings;
    let material = &point.material_values;
    // Limited, so that no product becomes infinite: infinity times 0 would be NaN.
    let weight = if point.front { ray.weight } else { ray.weight * point.left_by_body(view, t) };
    let weight = weight.min(Vec3::splat(MAX_RADIANCE));
    let [pass, survival] = numbers.arrival();
    let behind = straight_share(point);
    let chance = min(behind.max_component(), 1.0);
    if (chance > 0.0) & (pass < chance) {
        if ray.holes >= MAX_HOLES {
            return (Vec3::ZERO, Arrival::Ended);
        }
        let weight = weight * behind * (1.0 / chance);
        return (Vec3::ZERO, Arrival::Passed(ray_behind(point, ray, weight, t)));
    }
    let weight = if chance > 0.0 { weight * (point.coverage / (1.0 - chance)) } else { weight };
    let mut found = Vec3::ZERO;
    if material.emission.max_component() > 0.0 {
        let share = lamp_share(view, point, ray, ray.travelled + t);
        found = limited(settings, ray.depth > 1, weight * material.emission * share);
    }
    let mut weight = weight;
    if ray.depth >= settings.roulette_depth {
        let chance = min(max(weight.max_component(), LEAST_CHANCE), 1.0);
        if survival >= chance {
            return (found, Arrival::Ended);
        }
        weight = weight * (1.0 / chance);
    }
    if weight.max_component() > 0.0 {
        (found, Arrival::Met(PathRay { weight, ..*ray }))
    } else {
        (found, Arrival::Ended)
    }
}

/// What goes straight on at a point, per channel, without meeting the surface.
#[inline(always)]
pub(super) fn straight_share(point: &PathPoint) -> Vec3 {
    point.material_values.through * point.coverage + Vec3::splat(1.0 - point.coverage)
}

/// The ray behind a surface that it passes at distance `t`. It is no bounce, and what it meets was found by the lobe before.
#[inline(always)]
pub(super) fn ray_behind(point: &PathPoint, ray: &PathRay, weight: Vec3, t: f32) -> PathRay {
    PathRay {
        origin: point.offset_origin(ray.direction),
        weight,
        kind: RayKind::Refracted,
        start: point.id,
        holes: ray.holes + 1,
        travelled: ray.travelled + t,
        ..*ray
    }
}

/// The share of the radiance of what shines that counts where a ray of a lobe found it this far from where the lobe is. Lamps shine
/// to their front. All counts of what no light sample finds: spheres, what is textured or has holes, and what was met straight from
/// the camera, a mirror or glass.
#[inline(always)]
fn lamp_share(view: &SceneView, point: &PathPoint, ray: &PathRay, distance: f32) -> f32 {
    let instance = item(view.instances, point.id.instance);
    let geometry = item(view.geometries, instance.geometry);
    let is_lamp = item(view.materials, point.material).is_lamp_of_paths();
    if !is_lamp | (point.id.primitive >= geometry.triangle_count) {
        return 1.0;
    }
    if !point.front {
        return 0.0;
    }
    if !(ray.lobe_density > 0.0) | view.lights.is_empty() {
        return 1.0;
    }
    let corners = item(view.triangles, geometry.first_triangle + point.id.primitive);
    let facing = facing_area(corners, instance, point.id, ray.direction);
    if !(facing > 0.0) {
        return 1.0;
    }
    let chances = view.lights.len() as f32 / (1.0 - view.environment.chance);
    let density = distance * distance / (facing * chances);
    power_share(ray.lobe_density, density)
}

/// The area of a triangle as a direction sees it.
#[inline(always)]
fn facing_area(corners: &[Vec3; 3], instance: &Instance, id: PrimitiveId, direction: Vec3) -> f32 {
    let [mut a, mut b, mut c] = *corners;
    if id.instance != 0 {
        let map = &instance.world_from_object;
        (a, b, c) = (map.point(a), map.point(b), map.point(c));
    }
    ((b - a).cross(c - a).dot(direction) * 0.5).abs()
}
