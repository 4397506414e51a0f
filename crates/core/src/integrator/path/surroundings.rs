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
    let environment = view.environment;
    let place = environment.place(ray.direction);
    let mut of_environment = Vec3::ZERO;
    if finds_environment(view, ray) {
        of_environment = environment.radiance_at(&view.textures(), &place);
    }
    surroundings_at(view, ray, &place, of_environment)
}

/// Whether there is an environment, which rays straight from the camera, through holes too, may be not to see.
#[inline(always)]
fn finds_environment(view: &SceneView, ray: &PathRay) -> bool {
    view.environment.is_there() & (view.environment.is_seen | (ray.depth > 0))
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
    let mut radiance = Vec3Lanes::ZERO;
    if environment.is_there() {
        let mut is_wanted = [false; W];
        for lane in 0..count {
            is_wanted[lane] = true;
            environment.prefetch_density(view.environment_table, &places.get(lane));
        }
        radiance = environment.radiance_lanes(&view.textures(), &places, &is_wanted);
    }
    for lane in 0..count {
        found(lane, surroundings_at(view, ray(lane), &places.get(lane), radiance.get(lane)));
    }
}

/// What a ray finds whose direction lies at this place of the environment, which has that radiance there.
#[inline(always)]
fn surroundings_at(view: &SceneView, ray: &PathRay, place: &PicturePlace, of_environment: Vec3) -> Vec3 {
    let (settings, environment) = (view.settings, view.environment);
    let mut radiance = settings.background;
    if finds_environment(view, ray) {
        radiance = of_environment;
        if (ray.lobe_density > 0.0) & (environment.chance > 0.0) {
            let density = environment.chance * environment.density_at(view.environment_table, place);
            radiance = radiance * power_share(ray.lobe_density, density);
        }
    }
    radiance += Vec3::splat(settings.ambient);
    limited(settings, ray.depth > 1, ray.weight * radiance)
}
