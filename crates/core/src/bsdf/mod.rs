//! How surfaces reflect and transmit: a closed set of lobes ([`Lobe`]), Fresnel factors, and the directions of mirrors and
//! refraction. Functions of directions alone; what a material says at a point is `shading`'s.

mod albedo;
mod blinn_phong;
mod closure;
mod cosine_power;
mod delta;
mod directions;
mod eon;
mod fresnel;
mod ggx;
mod glass_tables;
mod lambert;
mod layer;
mod lobe;
mod matte;
mod mirror_tables;
mod mixture;
mod phong;
mod rough_base;
mod schlick;
mod turned_tables;

pub use albedo::large_tables;
pub use blinn_phong::BlinnPhong;
pub use closure::{Closure, SMOOTH, ScatterSample, Scattered};
pub use cosine_power::CosinePower;
pub use delta::Delta;
pub use directions::{Refracted, mirror_above, reflect, refract, through_surface, turned_up};
pub use eon::Eon;
pub use fresnel::{fresnel_exact, fresnel_factor, fresnel_schlick, reflectance_at_normal_incidence};
pub use ggx::Ggx;
pub use lambert::Lambert;
pub use lobe::Lobe;
pub use matte::Matte;
pub use mixture::Mixture;
pub use phong::Phong;
