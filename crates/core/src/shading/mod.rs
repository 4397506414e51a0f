//! What happens at a surface point: its normals and material, the light that reaches it, and where rays go on.

mod appearance;
mod directions;
mod fresnel;
mod hit_point;
mod light_sample;
mod lobe;
mod normal_map;
mod surface;

pub use appearance::{Appearance, MaterialTexels};
pub use directions::{Refracted, mirror_above, reflect, refract, through_surface, turned_up};
pub use fresnel::{fresnel_exact, fresnel_factor, fresnel_schlick, reflectance_at_normal_incidence};
pub use light_sample::{LightSample, emitted, sample_light, triangle_sample};
pub use lobe::{lobe_density, specular_lobe};
pub use normal_map::normal_map;
pub use surface::SurfacePoint;
