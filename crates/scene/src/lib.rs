//! Scenes for the Eosphor ray tracer: the model that people write, the files it is read from, and the flat arrays
//! that devices read.
//!
//! The way of the data: a file ([`load`]) → [`Scene`] (what people write) → [`SceneData`] (what machines read, made by
//! [`SceneData::flatten`]).
//!
//! ```
//! use eosphor_scene::{LoadOptions, SceneData, load};
//!
//! let loaded = load("builtin:cornell", &LoadOptions::default())?;
//! let (data, notes) = SceneData::flatten(&loaded.scene)?;
//! assert_eq!(data.triangles.len(), 2188);
//! assert_eq!(data.lights.len(), 2);
//! assert!(loaded.warnings.is_empty() && notes.is_empty());
//! # Ok::<(), eosphor_scene::SceneError>(())
//! ```

#![cfg_attr(not(feature = "files"), allow(dead_code, unused_imports, reason = "the readers use it"))]

mod double;
mod error;
#[cfg(feature = "files")]
mod files;
mod flatten;
mod hare;
mod hills;
mod lamps;
mod model;
mod positions;
mod sky;
mod snippet;
mod solids;
mod studio;

pub use error::{Place, Problem, SceneError, Warning};
#[cfg(feature = "files")]
pub use files::{
    BUILTINS, Builtin, CannotSave, ConfigKey, CourseBody, CourseFloor, CourseInput, CourseLight, CourseLines,
    CourseOptions, CoursePattern, KeyUse, LoadOptions, LoadedScene, MAX_COURSE_LIGHTS, PicturePixels, Preset,
    READ_FORMATS, SceneRequests, UnknownPreset, WrongCoursePattern, broken_picture, config_keys,
    course_settings, load, load_from_memory, load_image, near_name, read_data, read_hdr, read_jpeg, read_png,
    read_ppm, scene_over_base, scene_reference, scene_requests, scene_schema,
};
pub use flatten::{
    FrameBounds, FrameState, FrameStates, LeftOut, Note, Places, SceneData, ShapedArrays, Shapes, View,
};
pub use model::*;
pub use sky::{SunPosition, sun_position};
pub use snippet::Snippet;
pub use solids::{Body, BodyLighting, MAX_LIGHTS_PER_EDGE, Solid, UnknownSolid};
