//! Cameras.

use super::enumeration::{Enumeration, Terms, listed};
use serde::Deserialize;

/// A camera is one of two projections; its node places it.
#[derive(Debug, Deserialize)]
pub struct Camera {
    pub name: Option<String>,
    #[serde(rename = "type", deserialize_with = "listed")]
    pub camera_type: Option<CameraType>,
    pub perspective: Option<Perspective>,
    pub orthographic: Option<Orthographic>,
}

/// A perspective projection. The aspect ratio is the picture's, and rays have no clipping planes.
#[derive(Debug, Deserialize)]
pub struct Perspective {
    /// The vertical field of view, in radians.
    pub yfov: f32,
}

/// An orthographic projection. Its width follows from the aspect ratio of the picture.
#[derive(Debug, Deserialize)]
pub struct Orthographic {
    /// Half the height of what is seen.
    pub ymag: f32,
}

/// Which projection of a camera counts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CameraType {
    Perspective,
    Orthographic,
}

impl Enumeration for CameraType {
    const TERMS: Terms<CameraType> =
        Terms::Names(&[("perspective", CameraType::Perspective), ("orthographic", CameraType::Orthographic)]);
}
