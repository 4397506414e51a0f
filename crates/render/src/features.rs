//! What the camera rays of each pixel find first, and how much work that was.

use eosphor_core::integrator::PixelFeatures;

/// Features of some rows of a picture, top row first.
#[derive(Clone, Debug, PartialEq)]
pub struct FeatureRows {
    /// Pixels per row.
    pub width: u32,
    /// Number of rows.
    pub height: u32,
    /// `width * height` pixels, row after row from the top.
    pub pixels: Vec<PixelFeatures>,
    /// The work on the camera rays of each pixel, row after row from the top.
    pub work: Vec<CameraWork>,
}

impl FeatureRows {
    /// Rows whose pixels show nothing.
    pub fn new(width: u32, height: u32) -> FeatureRows {
        let pixels = width as usize * height as usize;
        FeatureRows {
            width,
            height,
            pixels: vec![PixelFeatures::NOTHING; pixels],
            work: vec![CameraWork::default(); pixels],
        }
    }
}

/// The work on the camera rays of a pixel. Other than all else here it depends on the hierarchy.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct CameraWork {
    /// Nodes of the hierarchy whose box was tested.
    pub nodes: u32,
    /// How many tests of a ray with a primitive there were.
    pub tests: u32,
}
