//! Sums of samples: what a film is made of, before the mean is taken.

use crate::Film;
use eosphor_core::sums::ExactSum;
use std::mem::ManuallyDrop;

/// Exact sums of some samples of each pixel of some rows, top row first.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SampleSums {
    /// Pixels per row.
    pub width: u32,
    /// Number of rows.
    pub height: u32,
    /// `width * height` sums, row after row from the top.
    pub sums: Vec<ExactSum>,
}

impl SampleSums {
    /// Sums of no samples, for this width and height in pixels.
    pub fn new(width: u32, height: u32) -> SampleSums {
        SampleSums { width, height, sums: no_sums(width as usize * height as usize) }
    }

    /// Adds those of other samples of the same pixels.
    ///
    /// # Panics
    ///
    /// Where they are of another size.
    pub fn add(&mut self, other: &SampleSums) {
        assert_eq!((self.width, self.height), (other.width, other.height), "sums of the same pixels");
        self.sums.iter_mut().zip(&other.sums).for_each(|(sum, other)| sum.merge(other));
    }

    /// The mean of so many samples, which these are the sums of.
    pub fn film(&self, samples: u32) -> Film {
        let mut film = Film::new(self.width, self.height);
        film.pixels.iter_mut().zip(&self.sums).for_each(|(pixel, sum)| *pixel = sum.mean(samples));
        film
    }
}

/// So many sums of nothing, in memory that is zero when the system gives it: nothing is written until something is added.
fn no_sums(count: usize) -> Vec<ExactSum> {
    let mut zeros = ManuallyDrop::new(vec![[0u64; 3]; count]);
    // SAFETY: same layout: `ExactSum` is `repr(C)` and holds such an array alone; pointer, length and
    // capacity are those of a vector that is not used any more.
    unsafe { Vec::from_raw_parts(zeros.as_mut_ptr().cast(), count, zeros.capacity()) }
}
