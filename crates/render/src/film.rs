//! The film: linear colours, before developing.

use eosphor_core::math::Vec3;

/// A picture in linear RGB, top row first.
#[derive(Clone, Debug, PartialEq)]
pub struct Film {
    /// Pixels a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// `width * height` colours, row after row from the top.
    pub pixels: Vec<Vec3>,
}

impl Film {
    /// A black film.
    pub fn new(width: u32, height: u32) -> Film {
        Film { width, height, pixels: vec![Vec3::ZERO; width as usize * height as usize] }
    }
}
