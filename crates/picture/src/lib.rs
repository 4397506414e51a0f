//! Pictures for the Eosphor ray tracer: picture and video files, comparing; sequences and checkpoints on disk.
//!
//! The way of the data: [`eosphor_render::Film`] (linear) → [`output::Developed`] (bytes) → [`output::PictureWriter`] → file.

pub mod compare;
mod cost;
pub mod frames;
mod locked_file;
pub mod output;
mod process;
mod scene_hash;
pub mod still;

pub use cost::CostMap;
pub use scene_hash::scene_hash;
