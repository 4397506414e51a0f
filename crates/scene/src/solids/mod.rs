//! Platonic solids, built as PLATO builds them (`crates/scene/src/files/reference_systems/README.md`): mirrors that one can see
//! through, dark ribs along the edges with lights on their inner side, and corners that stay open.

mod body;
mod gallery;
#[cfg(test)]
mod gallery_tests;
mod parquet;
mod shell;
mod solid;
#[cfg(test)]
mod tests;

pub use body::{Body, BodyLighting, MAX_LIGHTS_PER_EDGE};
pub(crate) use body::{FACE_DIFFUSE, PLATO_POWER, SHININESS};
pub(crate) use gallery::gallery;
pub(crate) use parquet::{PARQUET, parquet};
pub use solid::{Solid, UnknownSolid};
