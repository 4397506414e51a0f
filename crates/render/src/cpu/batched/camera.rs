//! The order of camera rays.

use super::super::tile::Tile;
use super::Path;
use eosphor_core::integrator::CameraRayLanes;
use eosphor_core::view::SceneView;
use std::ops::Range;

/// Side of the blocks of pixels whose rays follow each other: 16 rays, as many as a packet takes.
const BLOCK: u32 = 4;

/// Rays of a block.
const RAYS: usize = (BLOCK * BLOCK) as usize;

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

    /// Gives up to `limit` rays to `add` (a block's rays of one sample stay together); returns whether there was any.
    #[inline(always)]
    pub(in super::super) fn take(
        &mut self,
        view: &SceneView,
        limit: usize,
        mut add: impl FnMut(Path),
    ) -> bool {
        let mut taken = 0;
        while self.block[1] < self.tile.height && taken + RAYS <= limit {
            let (mut x, mut y, mut count) = ([0; RAYS], [0; RAYS], 0);
            for dy in self.block[1]..(self.block[1] + BLOCK).min(self.tile.height) {
                for dx in self.block[0]..(self.block[0] + BLOCK).min(self.tile.width) {
                    (x[count], y[count]) = (self.tile.x + dx, self.tile.y + dy);
                    count += 1;
                }
            }
            let sample = self.sample;
            let rays = CameraRayLanes::<RAYS>::new(view, &x, &y, &[sample; RAYS]);
            for lane in 0..count {
                add(Path { ray: rays.get(lane), x: x[lane], y: y[lane], sample });
            }
            taken += count;
            self.advance();
        }
        taken > 0
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
