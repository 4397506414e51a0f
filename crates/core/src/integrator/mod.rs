//! Integrators: how the rays of a sample find what a pixel shows. What all of them share is here: rays with their weight
//! ([`PathRay`]), rays from the camera ([`camera_ray`]), what lies between two points ([`transmittance`]), and what a pixel shows
//! first ([`pixel_features`]).
//!
//! Each has a room of its own: [`whitted`], with mirrors and glass as sharp as lights are, and [`path`], where light bounces from
//! everything. [`crate::settings::Integrator`] says which one a picture takes. Schedulers call an integrator's stages; none owns
//! shading. What a ray finds is multiplied by the ray's weight and added to an exact sum ([`crate::sums::ExactSum`]), so the order
//! does not matter in which schedulers get there.

mod camera_ray;
mod coverage;
mod features;
pub mod path;
mod path_ray;
mod ray_counts;
mod samples;
mod transmittance;
pub mod whitted;

pub use camera_ray::{CameraRayLanes, camera_ray, pixel_key};
pub use coverage::{is_worth_tracing, ray_through_hole, weight_at};
pub use features::{PixelFeatures, pixel_features};
pub use path_ray::{PathRay, RayKind};
pub use ray_counts::RayCounts;
pub use samples::{
    Follow, Path, Samples, Whitted, pixel_color, render_pixel, render_samples, render_samples_by,
};
pub use transmittance::{
    Crossing, Crossings, ShadowFilter, through_crossings, transmittance, transmittance_beyond,
};

/// The largest number of bounces. Whitted's stack has a level for every one.
pub const MAX_DEPTH: u32 = 64;
