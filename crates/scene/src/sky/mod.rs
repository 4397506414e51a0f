//! A clear sky: what the model says of it, the picture of it, and where the sun stands at a time.

mod angles;
mod hosek_wilkie;
mod picture;
#[cfg(test)]
mod picture_tests;
mod sun_position;

pub(crate) use picture::{DiskOfSun, PICTURE_ROWS, SkyPicture, WIDTH};
pub use sun_position::{SunPosition, sun_position};
