//! How surfaces reflect and transmit: Fresnel factors, the directions of mirrors and refraction, and highlights. Functions of
//! directions alone; what a material says at a point is `shading`'s.

mod directions;
mod fresnel;
mod highlight;

pub use directions::{Refracted, mirror_above, reflect, refract, through_surface, turned_up};
pub use fresnel::{fresnel_exact, fresnel_factor, fresnel_schlick, reflectance_at_normal_incidence};
pub use highlight::{lobe_density, specular_lobe};
