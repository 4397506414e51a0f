//! Rendering for the Eosphor ray tracer: backends, film, developing and statistics. Pictures' files are `eosphor-picture`'s.
//!
//! The way of the data: `SceneData` → [`Backend::prepare`] → [`PreparedScene::render_rows`] → [`Film`] (linear) →
//! [`Developed`] (bytes); or, where bytes are all that is wanted, [`PreparedScene::render_developed`] → [`Developed`].

mod backend;
mod bands;
mod cpu;
mod develop;
mod features;
mod film;
mod picked_rows;
mod ray_sets;
mod sample_sums;
mod scene_hierarchy;
mod shaped_scenes;
mod statistics;

pub use backend::{
    Backend, BackendError, Fallback, PreparedRegion, PreparedScene, Progress, Region, RenderControl,
    Rendered, RenderedBytes, Sampled, StageWork, check_rows, check_samples,
};
pub use bands::Bands;
pub use cpu::{CameraSpeed, CpuBackend, CpuOptions, FeaturePass, Scheduler};
pub use develop::{DevelopSettings, Developed};
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
pub use scene_hierarchy::{build_hierarchy, check_scene, geometry_of, options_by_work};
pub use shaped_scenes::{ShapedScene, ShapedScenes};
pub use statistics::{QueryTimes, RayStatistics};
