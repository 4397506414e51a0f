//! Some rows of a picture, as far as they are done.

use eosphor_render::{Film, SampleSums};
use std::ops::Range;

/// Some rows of a picture, of whose pixels the first samples are done.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Strip {
    /// Rows of the picture.
    pub rows: Range<u32>,
    /// How many samples of each pixel are done.
    pub samples: u32,
    /// The sums of those samples, one for each pixel.
    pub sums: SampleSums,
}

impl Strip {
    /// Rows of a picture of this width, with no sample.
    pub fn new(width: u32, rows: Range<u32>) -> Strip {
        Strip { sums: SampleSums::new(width, rows.end - rows.start), rows, samples: 0 }
    }

    /// The number of pixels of the strip.
    pub fn pixels(&self) -> u64 {
        self.sums.sums.len() as u64
    }

    /// Adds the next samples.
    ///
    /// # Panics
    ///
    /// Where these are other pixels, or do not come next.
    pub fn add(&mut self, samples: Range<u32>, sums: SampleSums) {
        assert_eq!(samples.start, self.samples, "the samples that come next");
        match self.samples {
            0 => {
                assert_eq!((self.sums.width, self.sums.height), (sums.width, sums.height), "the same pixels");
                self.sums = sums;
            }
            _ => self.sums.add(&sums),
        }
        self.samples = samples.end;
    }

    /// What is done of some of its rows, counted from its first one, as a picture; black without samples.
    ///
    /// # Panics
    ///
    /// Where it has no such rows.
    pub fn film(&self, rows: Range<u32>) -> Film {
        self.sums.film_of(rows, self.samples.max(1))
    }
}
