//! What happens at a surface point: its normals and material, the light that reaches it, and where rays go on.

mod emission_texel;
mod evaluated_material;
mod hit_point;
mod material_texels;
mod material_values;
mod normal_map;
mod path_material;
mod point_lanes;
mod surface;

pub use emission_texel::emission_texel;
pub use evaluated_material::EvaluatedMaterial;
pub use material_texels::MaterialTexels;
pub use material_values::MaterialValues;
pub use normal_map::normal_map;
pub use path_material::{LEAST_IOR, PathMaterial};
pub use point_lanes::{FoundSphere, FoundTriangle, PointLanes, WorldPrimitive};
pub use surface::{SurfacePoint, left_by_body};
