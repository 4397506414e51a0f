//! The keys of PG1's configuration.

use eosphor_core::math::Vec3;
use serde::Deserialize;

/// A whole file. Every key but the scene's file may be missing.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Config {
    pub(super) seed: Option<u32>,
    #[serde(default)]
    pub(super) obj_loader: ObjLoader,
    pub(super) renderer: Renderer,
    pub(super) output: Option<Output>,
    pub(super) scene: SceneEntry,
}

#[derive(Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub(super) struct ObjLoader {
    pub(super) triangulate: Option<bool>,
    /// The folder of the model.
    pub(super) basepath: Option<String>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Renderer {
    pub(super) render_mode: Option<RenderMode>,
    pub(super) max_depth: Option<u32>,
    pub(super) samples_per_triangle: Option<u32>,
    pub(super) render_type: Option<RenderType>,
    pub(super) max_distance: Option<f32>,
    pub(super) shading_type: Option<ShadingType>,
    pub(super) cull_backfaces: Option<bool>,
    pub(super) background_color: Option<Vec3>,
    /// The misspelling is PG1's own.
    #[serde(alias = "accelerated_data_structure")]
    pub(super) acceleratied_data_structure: Option<DataStructure>,
    pub(super) output: Option<Output>,
}

#[derive(Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(super) enum RenderMode {
    Cpu,
    Gpu,
}

#[derive(Clone, Copy, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(super) enum RenderType {
    Distance,
    Diffusion,
    Phong,
    BlinnPhong,
}

#[derive(Clone, Copy, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(super) enum ShadingType {
    Flat,
    Smooth,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct DataStructure {
    pub(super) name: StructureName,
    #[serde(rename = "max_triangles_per_BB")]
    pub(super) max_triangles: Option<u32>,
    pub(super) max_depth: Option<u32>,
}

#[derive(Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(super) enum StructureName {
    None,
    Octree,
    /// The misspelling is PG1's own.
    #[serde(alias = "octee_parametric")]
    OctreeParametric,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Output {
    pub(super) filename: Option<String>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct SceneEntry {
    pub(super) source_file: String,
    pub(super) camera: Option<CameraEntry>,
    #[serde(default)]
    pub(super) point_lights: Vec<PointLight>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct CameraEntry {
    pub(super) pos: Option<[f64; 3]>,
    pub(super) up: Option<Vec3>,
    /// The way the camera looks.
    pub(super) dir: Option<Vec3>,
    /// Horizontal field of view in radians.
    pub(super) fov: Option<f64>,
    pub(super) width: Option<u32>,
    pub(super) height: Option<u32>,
    pub(super) samples_per_pixel: Option<u32>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct PointLight {
    pub(super) pos: [f64; 3],
    pub(super) color: Vec3,
}
