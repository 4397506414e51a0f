//! Whitted's ray tracing in stages: `camera_ray` → trace → `SurfacePoint::new` → local terms, light, child rays.
//!
//! Schedulers call the stages; none owns shading. [`radiance`] is the reference: one loop with a fixed stack. What a
//! ray finds is multiplied by the ray's weight and added to an exact sum ([`ExactSum`]), so it does not matter in
//! which order schedulers get there.

mod arrival;
mod camera_ray;
mod children;
mod direct_light;
mod exact_sum;
mod features;
mod light_lanes;
mod lobe_light;
mod local;
mod path_ray;
mod radiance;
mod receiver;
mod transmittance;

pub use arrival::{branches_at, depth_limit, ray_behind, weight_at};
pub use camera_ray::camera_ray;
pub use children::{branch_count, child_ray};
pub use direct_light::{FEW, Gathered, direct_light, gather};
pub use direct_light::{answer, highlight, is_lit_from_behind, light_key, point_key, shadow_filter};
pub use exact_sum::{ExactSum, MAX_RADIANCE, RESOLUTION};
pub use features::{PixelFeatures, pixel_features};
pub use light_lanes::LightLanes;
pub use lobe_light::{LampLobe, takes_light};
pub use local::{is_lit, local_radiance};
pub use path_ray::{PathRay, RayKind};
pub use radiance::{MAX_DEPTH, RayCounts, Samples, pixel_color, radiance, render_pixel, render_samples};
pub use receiver::{Receiver, Receivers, shadow_origin, side_sign};
pub use transmittance::transmittance;
