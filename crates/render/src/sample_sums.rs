//! Sums of samples: what a film is made of, before the mean is taken.

use crate::Film;
use eosphor_core::sums::ExactSum;
use std::mem::ManuallyDrop;
use std::ops::Range;

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

    /// The same of some rows alone.
    ///
    /// # Panics
    ///
    /// Where there are no such rows.
    pub fn film_of(&self, rows: Range<u32>, samples: u32) -> Film {
        let [first, end] = [rows.start, rows.end].map(|row| row as usize * self.width as usize);
        let pixels = self.sums[first..end].iter().map(|sum| sum.mean(samples)).collect();
        Film { width: self.width, height: rows.end - rows.start, pixels }
    }
}

/// So many sums of nothing, in memory that is zero when the system gives it: nothing is written until something is added.
fn no_sums(count: usize) -> Vec<ExactSum> {
    let mut zeros = ManuallyDrop::new(vec![[0u64; 3]; count]);
    // SAFETY: same layout: `ExactSum` is `repr(C)` and holds such an array alone; pointer, length and
    // capacity are those of a vector that is not used any more.
    unsafe { Vec::from_raw_parts(zeros.as_mut_ptr().cast(), count, zeros.capacity()) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use eosphor_core::math::vec3;

    #[test]
    fn rows_of_a_film_are_those_of_the_whole() {
        let mut sums = SampleSums::new(3, 5);
        sums.sums.iter_mut().zip(1..).for_each(|(sum, number)| sum.add(vec3(number as f32, 0.5, 0.0)));
        let whole = sums.film(2);
        for rows in [0..5, 0..2, 2..5, 4..4] {
            let some = sums.film_of(rows.clone(), 2);
            assert_eq!((some.width, some.height), (3, rows.end - rows.start));
            assert_eq!(some.pixels, whole.pixels[rows.start as usize * 3..rows.end as usize * 3]);
        }
    }
}
