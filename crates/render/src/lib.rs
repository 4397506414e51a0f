//! Rendering for the Eosphor ray tracer: backends, film, developing, image files and comparison.
//!
//! The way of the data: `SceneData` → [`Backend::prepare`] → [`PreparedScene::render_rows`] → [`Film`] (linear) →
//! [`output::Developed`] (bytes) → [`output::PictureWriter`] → file.

mod backend;
mod bands;
pub mod compare;
mod cost;
mod cpu;
mod features;
mod film;
pub mod frames;
pub mod output;
mod picked_rows;
mod process;
mod ray_sets;
mod sample_sums;
mod scene_hash;
mod scene_hierarchy;
mod statistics;
pub mod still;

pub use backend::{
    Backend, BackendError, Fallback, PreparedRegion, PreparedScene, Progress, Region, RenderControl,
    Rendered, Sampled, check_rows, check_samples,
};
pub use bands::Bands;
pub use cost::CostMap;
pub use cpu::{CameraSpeed, CpuBackend, CpuOptions, FeaturePass, Scheduler};
pub use eosphor_accel::{
    Accel, Builder, Hierarchy, HierarchyOption, HierarchyOptions, HierarchyStatistics, MisfitKind,
    OptionMisfit, Quality, SahCosts, SimdLevel,
};
pub use eosphor_core::integrator::PixelFeatures;
pub use features::{CameraWork, FeatureRows};
pub use film::Film;
pub use picked_rows::{PickedRows, PreparedRows};
pub use ray_sets::RaySets;
pub use sample_sums::SampleSums;
pub use scene_hash::scene_hash;
pub use scene_hierarchy::{build_hierarchy, check_scene, geometry_of};
pub use statistics::{QueryTimes, RayStatistics};
