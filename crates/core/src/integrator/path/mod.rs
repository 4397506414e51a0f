//! Path tracing in stages: `camera_ray` → trace → arrive → light → scatter, and again. One ray goes on from each surface.
//!
//! | stage | file | gives |
//! |---|---|---|
//! | what a ray brings that leaves the scene | `surroundings.rs` | a contribution |
//! | what a ray does at the surface that it found | `arrive.rs` | emission; whether it goes on, and with which weight |
//! | a light, chosen by what it may give and sampled | `light.rs` | a shadow ray and what it brings |
//! | where the path goes on | `scatter.rs` | the next ray |
//! | which bodies a ray is in, one inside another | `media.rs` | indices of refraction, what light loses on its way |
//!
//! [`bounce`] puts the stages of one ray together; [`radiance`] is the reference scheduler: a loop over it, without a stack. Each
//! contribution is added by itself to the exact sum, and a stage reads nothing but its arguments, so any order gives the same bits.
//! Random numbers belong to (pixel, bounces, surfaces passed, decision), not to the history of a path (`numbers.rs`).
//!
//! Lamps are found in two ways, as samples of lights and by rays of lobes that meet them. Each way has its share by the power
//! heuristic (Veach 1997, "Robust Monte Carlo methods for light transport simulation", 9.2.4), of a ratio of densities
//! ([`power_share`]), so that nothing overflows.

mod arrive;
mod bounce;
mod light;
mod light_lanes;
mod matte_lanes;
mod media;
mod numbers;
mod radiance;
mod scatter;
mod surroundings;
mod visibility;

pub use arrive::{Arrival, arrive};
pub use bounce::{Bounce, BounceLanes, bounce, bounce_at_surface, bounce_lanes};
pub use light::{LightRequest, sample_light};
pub use matte_lanes::{bounce_matte, is_matte_outside, is_matte_triangle};
pub use media::Media;
pub use numbers::{NumberLanes, Numbers, NumbersByKey, NumbersInLane, NumbersOfLanes};
pub use radiance::radiance;
pub use scatter::scatter;
pub use surroundings::{surroundings, surroundings_lanes};
pub use visibility::{Straight, through, visibility};

use crate::bsdf::Mixture;
use crate::integrator::PathRay;
use crate::light::LightReceiver;
use crate::math::{Vec3, vec3};
use crate::sampling::orthonormal_basis;
use crate::settings::Settings;
use crate::shading::{PathMaterial, SurfacePoint};

/// A surface point, as path tracing sees it.
pub type PathPoint = SurfacePoint<PathMaterial>;

/// A path on its way: all that its next surface must know.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct PathState {
    /// The ray.
    pub ray: PathRay,
    /// The surface that a lobe sent it from, which lights were chosen for.
    pub left: LightReceiver,
}

impl PathState {
    /// From a camera.
    #[inline(always)]
    pub fn new(ray: PathRay) -> PathState {
        PathState { ray, left: LightReceiver { position: ray.origin, normal: Vec3::ZERO } }
    }
}

/// Lobes of a point and the frame that their directions are in: z is the shading normal, on the viewer's side.
pub struct ScatterPoint {
    /// The lobes, towards the viewer.
    pub mixture: Mixture,
    axes: [Vec3; 3],
}

/// The least cosine between shading normal and viewer. A normal that is turned further away is bent back.
const LEAST_COSINE: f32 = 1.0 / 256.0;

impl ScatterPoint {
    /// Of a point.
    #[inline(always)]
    pub fn new(point: &PathPoint) -> ScatterPoint {
        let axes = frame(point.normal, point.to_viewer, point.geometric_normal);
        let mut to_viewer = in_frame(&axes, point.to_viewer);
        // Where the geometric normal is as level as that.
        to_viewer.z = if to_viewer.z > 0.0 { to_viewer.z } else { LEAST_COSINE };
        ScatterPoint { mixture: point.material_values.closure(point.front).towards(to_viewer), axes }
    }

    /// The point as lights see it: from both sides where light gets through.
    #[inline(always)]
    pub fn receiver(&self, point: &PathPoint) -> LightReceiver {
        let normal = if self.mixture.has_glass() { Vec3::ZERO } else { self.axes[2] };
        LightReceiver { position: point.position, normal }
    }

    /// A direction of the world, in the frame.
    #[inline(always)]
    pub fn to_frame(&self, d: Vec3) -> Vec3 {
        in_frame(&self.axes, d)
    }

    /// A direction of the frame, in the world.
    #[inline(always)]
    pub fn to_world(&self, d: Vec3) -> Vec3 {
        out_of_frame(&self.axes, d)
    }
}

/// Axes whose z is the shading normal, bent back where it is turned too far from the viewer.
#[inline(always)]
fn frame(normal: Vec3, to_viewer: Vec3, geometric_normal: Vec3) -> [Vec3; 3] {
    let cos = normal.dot(to_viewer);
    let bent = normal.plus_scaled(to_viewer, LEAST_COSINE - cos).normalize_or(geometric_normal);
    let normal = if cos < LEAST_COSINE { bent } else { normal };
    let (x, y) = orthonormal_basis(normal);
    [x, y, normal]
}

#[inline(always)]
fn out_of_frame(&[x, y, z]: &[Vec3; 3], d: Vec3) -> Vec3 {
    (z * d.z).plus_scaled(x, d.x).plus_scaled(y, d.y).normalize_or(z)
}

#[inline(always)]
fn in_frame(axes: &[Vec3; 3], d: Vec3) -> Vec3 {
    vec3(d.dot(axes[0]), d.dot(axes[1]), d.dot(axes[2]))
}

/// The share of a way that finds light with density `own`, where another finds it with density `other`, by the power heuristic.
/// Densities are not negative; a way that cannot find it has none.
#[inline(always)]
pub fn power_share(own: f32, other: f32) -> f32 {
    if !(own > 0.0) {
        return 0.0;
    }
    let ratio = other / own;
    1.0 / (1.0 + ratio * ratio)
}

/// What light that has met surfaces before this one of the path's first is cut to: as bright as that, of its hue.
#[inline(always)]
fn limited(settings: &Settings, is_indirect: bool, color: Vec3) -> Vec3 {
    let most = color.max_component();
    if is_indirect & (most > settings.clamp_indirect) {
        color * (settings.clamp_indirect / most)
    } else {
        color
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shares_add_up_to_one() {
        for (a, b) in [(1.0, 1.0), (1e30, 1e-30), (1e-38, 3e38), (2.5, 0.0), (f32::INFINITY, 1.0)] {
            assert_eq!(power_share(a, b) + power_share(b, a), 1.0, "{a} {b}");
        }
        assert!((power_share(3.0, 4.0) - 9.0 / 25.0).abs() < 1e-7);
        assert_eq!(power_share(0.0, 0.0), 0.0);
    }
}
