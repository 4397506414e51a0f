//! OpenEXR: linear floats of 32 or 16 bits, and layers of what camera rays find first.

mod channels;
mod encoder;
mod read;

pub(super) use channels::Channel;
pub use channels::Layer;
pub(super) use encoder::{ExrEncoder, Layout};
pub(super) use read::read;
