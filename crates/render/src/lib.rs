//! Rendering for the Eosphor ray tracer: backends, film, developing, image files and comparison.
//!
//! The way of the data: `SceneData` → [`Backend::prepare`] → [`PreparedScene::render`] → [`Film`] (linear) →
//! [`output::Developed`] (bytes) → file.

mod backend;
pub mod compare;
mod film;
pub mod output;
mod statistics;

pub use backend::cpu::{Accel, CpuBackend, CpuOptions, SimdLevel};
pub use backend::{Backend, BackendError, PreparedScene, Progress, RenderControl, Rendered};
pub use film::Film;
pub use statistics::{BuildStatistics, RayStatistics};
