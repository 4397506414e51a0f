//! What happens at a surface point: its normals and material, the light that reaches it, and where rays go on.

mod evaluated_material;
mod hit_point;
mod normal_map;
mod surface;

pub use evaluated_material::{EvaluatedMaterial, MaterialTexels};
pub use normal_map::normal_map;
pub use surface::SurfacePoint;
