//! The order of camera rays.

use super::super::tile::Tile;
use super::Path;
use eosphor_core::integrator::camera_ray;
use eosphor_core::view::SceneView;
use std::ops::Range;

/// Side of the blocks of pixels whose rays follow each other: 16 rays, as many as a packet takes.
const BLOCK: u32 = 4;

/// Gives a tile's camera rays, block of pixels after block of pixels; in a block sample after sample.
pub(in super::super) struct CameraRays {
    tile: Tile,
    samples: Range<u32>,
    /// Upper left corner of the block that is next, from that of the tile.
    block: [u32; 2],
    /// The sample that is next.
    sample: u32,
}

impl CameraRays {
    #[inline(always)]
    pub(in super::super) fn new(tile: Tile, samples: Range<u32>) -> CameraRays {
        let sample = samples.start;
        CameraRays { tile, samples, block: [0, 0], sample }
    }

    /// Appends up to `limit` rays (a block's rays of one sample stay together); returns whether there was any.
    #[inline(always)]
    pub(in super::super) fn take(&mut self, view: &SceneView, limit: usize, paths: &mut Vec<Path>) -> bool {
        let before = paths.len();
        while self.block[1] < self.tile.height && paths.len() + (BLOCK * BLOCK) as usize <= before + limit {
            let sample = self.sample;
            for dy in self.block[1]..(self.block[1] + BLOCK).min(self.tile.height) {
                for dx in self.block[0]..(self.block[0] + BLOCK).min(self.tile.width) {
                    let (x, y) = (self.tile.x + dx, self.tile.y + dy);
                    paths.push(Path { ray: camera_ray(view, x, y, sample), x, y, sample });
                }
            }
            self.advance();
        }
        paths.len() > before
    }

    #[inline(always)]
    fn advance(&mut self) {
        self.sample += 1;
        if self.sample < self.samples.end {
            return;
        }
        self.sample = self.samples.start;
        self.block[0] += BLOCK;
        if self.block[0] >= self.tile.width {
            self.block = [0, self.block[1] + BLOCK];
        }
    }
}
