//! Pictures whose values are known in closed form: scene model → `SceneData` → `CpuBackend` → film.

mod camera;
mod enclosures;
mod environment;
mod glass;
mod glossy;
mod lights;
pub(crate) mod many_lights;
mod mirrors;
mod models;
mod nested;
mod paths;
mod regressions;
mod shading_normals;
mod shadows;
mod support;
mod surfaces;
mod units;
mod winding;
