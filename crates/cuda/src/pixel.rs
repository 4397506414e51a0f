//! What comes back of a pixel.

use eosphor_core::device::DevelopLaunch;
use eosphor_core::math::Vec3;
use eosphor_core::sums::ExactSum;

/// What comes back of a pixel: its colour, from all its samples, or the bytes of that, or the sum of some. Any bytes are one.
pub(crate) trait Pixel: Copy + Send + Sync {
    /// Whether it is a sum.
    const IS_SUM: bool;

    /// Whether it is developed, once kernels have made a colour of it.
    const IS_DEVELOPED: bool = false;

    /// Where so many pixels begin among a band's bytes on the device: behind what they are made of.
    fn offset_on_device(_pixels: usize) -> usize {
        0
    }

    /// Bytes that so many pixels take on the device, together with what they are made of.
    fn bytes_on_device(pixels: usize) -> usize {
        pixels * size_of::<Self>()
    }
}

impl Pixel for Vec3 {
    const IS_SUM: bool = false;
}

impl Pixel for ExactSum {
    const IS_SUM: bool = true;
}

/// Red, green and blue as they are shown.
pub(crate) type Rgb = [u8; 3];

impl Pixel for Rgb {
    const IS_SUM: bool = false;
    const IS_DEVELOPED: bool = true;

    fn offset_on_device(pixels: usize) -> usize {
        Vec3::bytes_on_device(pixels)
    }

    fn bytes_on_device(pixels: usize) -> usize {
        Rgb::offset_on_device(pixels) + DevelopLaunch::words(pixels as u32) * size_of::<u32>()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The bytes are words, which threads write whole.
    #[test]
    fn bytes_lie_behind_their_colours() {
        for pixels in [1, 4, 5, 1023] {
            let (offset, all) = (Rgb::offset_on_device(pixels), Rgb::bytes_on_device(pixels));
            assert!(offset == 12 * pixels && (3 * pixels..3 * pixels + 12).contains(&(all - offset)));
        }
        assert_eq!((Vec3::offset_on_device(7), Vec3::bytes_on_device(7)), (0, 84));
        assert_eq!((ExactSum::offset_on_device(7), ExactSum::bytes_on_device(7)), (0, 168));
    }
}
