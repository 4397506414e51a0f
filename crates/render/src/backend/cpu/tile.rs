//! Tiles: the pieces of a picture that threads take.

use crate::Film;
use eosphor_core::math::Vec3;

/// A rectangle of pixels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Tile {
    pub(super) x: u32,
    pub(super) y: u32,
    pub(super) width: u32,
    pub(super) height: u32,
}

impl Tile {
    /// Tiles of at most `side` by `side` pixels over a picture, row after row.
    pub(super) fn cover(width: u32, height: u32, side: u32) -> Vec<Tile> {
        let starts = |length: u32| (0..length).step_by(side as usize);
        starts(height)
            .flat_map(|y| {
                starts(width).map(move |x| Tile {
                    x,
                    y,
                    width: side.min(width - x),
                    height: side.min(height - y),
                })
            })
            .collect()
    }

    /// Pixels in it.
    pub(super) fn pixels(&self) -> u64 {
        self.width as u64 * self.height as u64
    }

    /// Its pixels' places, row after row.
    pub(super) fn places(&self) -> impl Iterator<Item = (u32, u32)> {
        let tile = *self;
        (0..tile.height).flat_map(move |dy| (0..tile.width).map(move |dx| (tile.x + dx, tile.y + dy)))
    }

    /// Puts its colours, row after row, into the film.
    pub(super) fn copy_to(&self, colors: &[Vec3], film: &mut Film) {
        for (dy, row) in colors.chunks_exact(self.width as usize).enumerate() {
            let start = (self.y as usize + dy) * film.width as usize + self.x as usize;
            film.pixels[start..start + row.len()].copy_from_slice(row);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tiles_cover_every_pixel_once() {
        for (width, height, side) in [(1, 1, 16), (17, 5, 4), (64, 64, 64), (100, 33, 7), (5, 300, 1)] {
            let mut seen = vec![0; (width * height) as usize];
            for (x, y) in Tile::cover(width, height, side).iter().flat_map(Tile::places) {
                seen[(y * width + x) as usize] += 1;
            }
            assert!(seen.iter().all(|&n| n == 1), "{width}x{height} in tiles of {side}");
        }
    }
}
