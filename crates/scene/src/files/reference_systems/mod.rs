//! The systems that Eosphor was first measured against: EOS, PG1 and PLATO's course. README.md says who they are and what is
//! kept from each.

pub(super) mod course;
pub(super) mod pg1;
mod presets;

pub(super) use presets::pg1_camera;
pub use presets::{Preset, UnknownPreset, course_settings};
