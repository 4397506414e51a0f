//! Bands of rows: how pictures of any size are rendered in little memory.

use std::ops::Range;

/// Tiles of most sides fit into bands of a multiple of this.
const TILE: u32 = 16;

/// The rows of a picture, some at a time from the top.
#[derive(Clone, Debug)]
pub struct Bands {
    next: u32,
    height: u32,
    rows: u32,
}

impl Bands {
    /// Pixels of a band, where the choice is free. Pictures of ordinary sizes are one band.
    pub const PIXELS: u32 = 1 << 23;

    /// Bands of at most this many rows; 0 counts as 1.
    pub fn of_rows(height: u32, rows: u32) -> Bands {
        Bands { next: 0, height, rows: rows.max(1) }
    }

    /// Divides a picture into as few bands as possible of about `pixels` pixels each, all about as high.
    pub fn of_pixels(width: u32, height: u32, pixels: u32) -> Bands {
        let bands = (width as u64 * height as u64).div_ceil(pixels.max(1) as u64).max(1);
        let rows = (height as u64).div_ceil(bands) as u32;
        // Whole tiles, where that is not much more.
        Bands::of_rows(height, if rows > TILE { rows.next_multiple_of(TILE) } else { rows })
    }

    /// Rows of a band; the last one may have fewer.
    pub fn rows(&self) -> u32 {
        self.rows.min(self.height)
    }
}

impl Iterator for Bands {
    type Item = Range<u32>;

    fn next(&mut self) -> Option<Range<u32>> {
        let start = self.next;
        self.next += self.rows.min(self.height - start);
        (start < self.height).then_some(start..self.next)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bands_are_the_rows() {
        for (height, rows) in [(1, 1), (7, 3), (9, 3), (5, 100), (65_535, 128), (3, 0)] {
            let all: Vec<u32> = Bands::of_rows(height, rows).flatten().collect();
            assert_eq!(all, (0..height).collect::<Vec<u32>>());
        }
        assert_eq!(Bands::of_rows(0, 5).count(), 0);
        assert_eq!(Bands::of_pixels(65_535, 65_535, Bands::PIXELS).rows(), 128);
        assert_eq!(Bands::of_pixels(1920, 1080, Bands::PIXELS).count(), 1);
        assert_eq!(Bands::of_pixels(4096, 2160, Bands::PIXELS).map(|rows| rows.len()).max(), Some(1088));
        assert_eq!(Bands::of_pixels(65_535, 2, 1).count(), 2);
        assert_eq!(Bands::of_pixels(0, 0, 0).count(), 0);
    }
}
