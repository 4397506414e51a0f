//! What gets from a light to a surface.

use super::{LightRequest, PathPoint, ScatterPoint, arrive::straight_share};
use crate::hierarchy::Tracer;
use crate::integrator::transmittance::{CrossedShare, Crossing, Crossings, through_crossings};
use crate::material::Material;
use crate::math::Vec3;
use crate::out_of_line::out_of_line_on_gpus;
use crate::ray::{Hit, Ray};
use crate::settings::ShadowMode;
use crate::shading::PathMaterial;
use crate::view::SceneView;

/// The share of light that gets through, per channel: through holes and thin clear glass, straight on. What refracts lets none
/// through, since paths find that light by themselves.
#[inline(always)]
pub fn visibility<T: Tracer>(view: &SceneView, tracer: &T, request: &LightRequest) -> Vec3 {
    if tracer.occluded(&request.ray, &request.filter) { through(view, tracer, request) } else { Vec3::ONE }
}

/// The same where something is known to be in the way.
#[inline(always)]
pub fn through<T: Tracer>(view: &SceneView, tracer: &T, request: &LightRequest) -> Vec3 {
    // Scenes in which nothing is straight to pass say so.
    if view.settings.shadow_mode != ShadowMode::Coloured {
        return Vec3::ZERO;
    }
    through_crossings(view, tracer, Straight, &request.ray, &request.filter)
}

/// What a surface lets through as if it were not there.
#[derive(Clone, Copy, Debug)]
pub struct Straight;

impl CrossedShare for Straight {
    type Material = PathMaterial;

    #[inline(always)]
    fn share(point: &PathPoint) -> Vec3 {
        let at = ScatterPoint::new(point);
        straight_share(point) + at.mixture.straight() * point.coverage
    }
}

impl Crossing for Straight {
    /// What is straight to pass says no material by itself.
    #[inline(always)]
    fn stops_all(self, _: &Material) -> bool {
        false
    }

    #[inline(always)]
    fn cross(self, before: &Crossings, view: &SceneView, ray: &Ray, hit: &Hit) -> Crossings {
        cross_straight(before, view, ray, hit)
    }
}

out_of_line_on_gpus! {
    fn cross_straight(before: &Crossings, view: &SceneView, ray: &Ray, hit: &Hit) -> Crossings {
        before.crossed::<Straight>(view, ray, hit)
    }
}
