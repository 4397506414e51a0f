//! What the camera rays of each pixel find first, and how much work that was.

use eosphor_core::integrator::PixelFeatures;

/// Features of some rows of a picture, top row first.
#[derive(Clone, Debug, PartialEq)]
pub struct FeatureRows {
    /// Pixels a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// `width * height` pixels, row after row from the top.
    pub pixels: Vec<PixelFeatures>,
    /// For each pixel the work on its camera rays.
    pub work: Vec<CameraWork>,
}

impl FeatureRows {
    /// Rows that show nothing.
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
    /// Ray-primitive tests.
    pub tests: u32,
}
