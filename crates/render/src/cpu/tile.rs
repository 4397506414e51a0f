//! Tiles: the pieces of a picture that threads take.

use crate::Region;

/// A part of a picture cut into tiles of at most `side` by `side` pixels, counted row after row.
#[derive(Clone, Copy, Debug)]
pub(super) struct Tiling {
    region: Region,
    side: u32,
}

/// Sides of tiles, from the largest: batches of rays want large ones, many threads small ones.
const SIDES: [u32; 3] = [32, 16, 8];

/// Tiles that each thread should have, so that none waits long for the last.
const TILES_A_THREAD: u32 = 8;

impl Tiling {
    /// With tiles of `side`, or else of a side that gives each thread enough of them.
    pub(super) fn for_threads(region: Region, side: Option<u32>, threads: usize) -> Tiling {
        let enough = TILES_A_THREAD.saturating_mul(threads as u32);
        let gives_enough = |side: &u32| Tiling::new(region, *side).len() >= enough;
        let chosen = || SIDES.into_iter().find(gives_enough).unwrap_or(SIDES[SIDES.len() - 1]);
        Tiling::new(region, side.unwrap_or_else(chosen))
    }

    pub(super) fn new(region: Region, side: u32) -> Tiling {
        Tiling { region, side }
    }

    /// Pixels of which threads have enough tiles, and not of the smallest.
    pub(super) fn fewest_pixels(threads: usize) -> u64 {
        u64::from(TILES_A_THREAD) * threads as u64 * u64::from(SIDES[1] * SIDES[1])
    }

    fn columns(&self) -> u32 {
        self.region.width.div_ceil(self.side)
    }

    /// How many tiles there are. Sides of at most 65,535 pixels keep it below 2^32 even for tiles of one pixel.
    pub(super) fn len(&self) -> u32 {
        self.columns() * self.region.height.div_ceil(self.side)
    }

    /// One of them.
    pub(super) fn tile(&self, number: u32) -> Tile {
        let x = (number % self.columns()) * self.side;
        let y = (number / self.columns()) * self.side;
        let Region { x: left, y: top, width, height } = self.region;
        let (width, height) = (self.side.min(width - x), self.side.min(height - y));
        Tile { x: left + x, y: top + y, width, height }
    }
}

/// A rectangle of pixels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Tile {
    pub(super) x: u32,
    pub(super) y: u32,
    pub(super) width: u32,
    pub(super) height: u32,
}

impl Tile {
    /// Pixels in it.
    pub(super) fn pixels(&self) -> u64 {
        self.width as u64 * self.height as u64
    }

    /// The number of one of its pixels, row after row.
    #[inline(always)]
    pub(super) fn index_of(&self, x: u32, y: u32) -> usize {
        ((y - self.y) * self.width + (x - self.x)) as usize
    }

    /// Column and row of each pixel of the tile, row after row.
    pub(super) fn places(self) -> impl Iterator<Item = (u32, u32)> {
        let tile = self;
        (0..tile.height).flat_map(move |dy| (0..tile.width).map(move |dx| (tile.x + dx, tile.y + dy)))
    }

    /// Puts its pixels, row after row, into those of a region that it is part of.
    pub(super) fn copy_to<T: Copy>(&self, pixels: &[T], places: &mut [T], region: &Region) {
        self.put_to(pixels, places, region, |pixel| *pixel);
    }

    /// The same with what each pixel is turned into.
    pub(super) fn put_to<T, U>(
        &self,
        pixels: &[T],
        places: &mut [U],
        region: &Region,
        turn: impl Fn(&T) -> U,
    ) {
        for (dy, row) in pixels.chunks_exact(self.width as usize).enumerate() {
            let (x, y) = ((self.x - region.x) as usize, (self.y - region.y) as usize + dy);
            let start = y * region.width as usize + x;
            let places = &mut places[start..start + row.len()];
            places.iter_mut().zip(row).for_each(|(place, pixel)| *place = turn(pixel));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sides_by_threads() {
        let side = |width, height, side, threads| {
            Tiling::for_threads(Region::whole((width, height)), side, threads).side
        };
        assert_eq!(side(1920, 1080, None, 2), 32);
        assert_eq!(side(800, 800, None, 128), 16);
        assert_eq!(side(100, 100, None, 64), 8);
        assert_eq!(side(100, 100, Some(77), 64), 77);
    }

    #[test]
    fn tiles_cover_every_pixel_once() {
        for (width, height, side) in [(1, 1u32, 16), (17, 5, 4), (64, 64, 64), (100, 33, 7), (5, 300, 1)] {
            let mut seen = vec![0; (width * height) as usize];
            let (all, left) = (Region::whole((width, height)), width.div_ceil(3));
            let columns = [(0, left), (left, width - left)].into_iter().filter(|(_, width)| *width > 0);
            let columns = columns.map(|(x, width)| Region { x, width, ..all });
            let rows = [0..height.div_ceil(3), height.div_ceil(3)..height];
            for region in columns.flat_map(|columns| rows.clone().map(|rows| columns.rows(&rows))) {
                let tiling = Tiling::new(region, side);
                for (x, y) in (0..tiling.len()).map(|n| tiling.tile(n)).flat_map(|t| t.places()) {
                    seen[(y * width + x) as usize] += 1;
                }
            }
            assert!(seen.iter().all(|&n| n == 1), "{width}x{height} in tiles of {side}");
        }
    }
}
