//! Whitted's ray tracing in stages: `camera_ray` → trace → `SurfacePoint::new` → local terms, light, child rays.
//!
//! [`radiance`] is the reference scheduler: one loop with a fixed stack.

mod arrival;
mod children;
mod direct_light;
mod lamp_draw;
mod light_lanes;
mod light_rays;
mod lit_point;
mod lobe_light;
mod local;
mod radiance;
mod receiver;

pub use arrival::{branches_at, depth_limit, ends_at, ray_behind};
pub use children::{Children, GlossyLanes, branch_count, child_ray};
pub use direct_light::{LightSums, direct_light, gather};
pub use direct_light::{highlight, is_lit_from_behind, light_key, point_key, shade_direct, shadow_filter};
pub use lamp_draw::{are_lamps_drawn, draw_lamp, drawn_lamp, lights_alone};
pub use lamp_draw::{choose_lamps, choose_lamps_from, ways_to_lamps};
pub use light_lanes::LightLanes;
pub use light_rays::{LightProgress, LightRay, LightSample, add_light, light_query, light_ray};
pub use light_rays::{light_rays_of_point, light_samples_of_side};
pub use lit_point::LitPoint;
pub use lobe_light::{LampLobe, takes_light};
pub use local::local_radiance;
pub use radiance::radiance;
pub use receiver::{Receiver, Receivers, shadow_origin, side_sign};
