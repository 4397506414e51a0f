//! What kernels make of a pixel.

use eosphor_core::math::Vec3;
use eosphor_core::sums::ExactSum;

/// What kernels make of a pixel: its colour, from all its samples, or the sum of some. Any bytes are one.
pub(crate) trait Pixel: Copy + Send + Sync {
    /// Whether it is a sum.
    const IS_SUM: bool;
}

impl Pixel for Vec3 {
    const IS_SUM: bool = false;
}

impl Pixel for ExactSum {
    const IS_SUM: bool = true;
}
