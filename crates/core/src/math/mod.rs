//! Vectors, transforms and elementary functions with the same bits on every target.

mod affine;
pub mod elementary;
pub mod elementary64;
mod float;
mod lanes;
mod vec3;

pub use affine::Affine;
pub use float::*;
pub use lanes::Vec3Lanes;
pub use vec3::{Vec3, vec3};
