//! What surrounds the scene.

use super::{limited, power_share};
use crate::environment::{PicturePlace, PlaceLanes};
use crate::integrator::PathRay;
use crate::math::{Vec3, Vec3Lanes};
use crate::view::SceneView;

/// What a ray brings that leaves the scene: the environment, or the background, which is light from all around where there is none;
/// and that of the ambient term. All are radiance. Of what light samples find, too, the ray's share counts.
#[inline(always)]
pub fn surroundings(view: &SceneView, ray: &PathRay) -> Vec3 {
    let place = view.environment.place(ray.direction);
    surroundings_at(view, ray, &place)
}

/// [`surroundings`] of `count` rays: `ray(lane)` gives that of each of W lanes, of which those after the first `count` may repeat
/// others; `found` is told of each.
#[inline(always)]
pub fn surroundings_lanes<'a, const W: usize>(
    view: &SceneView,
    count: usize,
    ray: impl Fn(usize) -> &'a PathRay,
    mut found: impl FnMut(usize, Vec3),
) {
    let environment = view.environment;
    let mut direction = Vec3Lanes::<W>::ZERO;
    for lane in 0..W {
        direction.set(lane, ray(lane).direction);
    }
    let places = PlaceLanes::new(environment, &direction);
    if environment.is_there() {
        for lane in 0..count {
            environment.prefetch_radiance(&view.textures(), &places.get(lane));
            environment.prefetch_density(view.environment_table, &places.get(lane));
        }
    }
    for lane in 0..count {
        found(lane, surroundings_at(view, ray(lane), &places.get(lane)));
    }
}

/// What a ray finds whose direction lies at this place of the environment.
#[inline(always)]
fn surroundings_at(view: &SceneView, ray: &PathRay, place: &PicturePlace) -> Vec3 {
    let (settings, environment) = (view.settings, view.environment);
    let mut radiance = settings.background;
    // Straight from the camera, through holes too.
    let is_looked_at = ray.depth == 0;
    if environment.is_there() & (environment.is_seen | !is_looked_at) {
        radiance = environment.radiance_at(&view.textures(), place);
        if (ray.lobe_density > 0.0) & (environment.chance > 0.0) {
            let density = environment.chance * environment.density_at(view.environment_table, place);
            radiance = radiance * power_share(ray.lobe_density, density);
        }
    }
    radiance += Vec3::splat(settings.ambient);
    limited(settings, ray.depth > 1, ray.weight * radiance)
}

/// The radiance of the environment in those of several lanes that are wanted.
#[inline(always)]
pub(super) fn radiance_lanes<const W: usize>(
    view: &SceneView,
    direction: &Vec3Lanes<W>,
    is_wanted: &[bool; W],
) -> Vec3Lanes<W> {
    let (environment, textures) = (view.environment, view.textures());
    let places = PlaceLanes::new(environment, direction);
    for lane in 0..W {
        if is_wanted[lane] {
            environment.prefetch_radiance(&textures, &places.get(lane));
        }
    }
    let mut radiance = Vec3Lanes::ZERO;
    for lane in 0..W {
        if is_wanted[lane] {
            radiance.set(lane, environment.radiance_at(&textures, &places.get(lane)));
        }
    }
    radiance
}
