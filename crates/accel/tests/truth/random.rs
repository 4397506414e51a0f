//! SplitMix64 (Steele et al. 2014): numbers for tests.

use crate::vector::*;

pub(crate) struct Random(pub(crate) u64);

impl Random {
    pub(crate) fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    pub(crate) fn below(&mut self, n: usize) -> usize {
        (self.bits() % n as u64) as usize
    }

    /// In [0, 1).
    pub(crate) fn unit(&mut self) -> f64 {
        (self.bits() >> 11) as f64 / (1u64 << 53) as f64
    }

    pub(crate) fn in_cube(&mut self) -> V {
        [self.unit(), self.unit(), self.unit()].map(|x| 2.0 * x - 1.0)
    }

    pub(crate) fn direction(&mut self) -> V {
        loop {
            let d = self.in_cube();
            if (1e-4..1.0).contains(&dot(d, d)) {
                return unit(d);
            }
        }
    }
}

/// Rays in all: `EOSPHOR_TEST_RAYS` may ask for more than the usual number.
pub(crate) fn rays(usual: u64) -> u64 {
    std::env::var("EOSPHOR_TEST_RAYS").map_or(usual, |n| n.parse::<f64>().expect("a number of rays") as u64)
}
