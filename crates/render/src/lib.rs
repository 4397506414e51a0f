//! Rendering for the Eosphor ray tracer: backends, film, developing, image files and comparison.
//!
//! The way of the data: `SceneData` → [`Backend::prepare`] → [`PreparedScene::render`] → [`Film`] (linear) →
//! [`output::Developed`] (bytes) → file.

mod backend;
pub mod compare;
mod film;
mod hierarchy;
pub mod output;
mod statistics;

pub use backend::cpu::{CpuBackend, CpuOptions, SimdLevel};
pub use backend::{Backend, BackendError, PreparedScene, Progress, RenderControl, Rendered, check_scene};
pub use eosphor_accel::HierarchyStatistics;
pub use film::Film;
pub use hierarchy::{Accel, Hierarchy};
pub use statistics::RayStatistics;
