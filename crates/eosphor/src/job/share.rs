//! A share of a still, for jobs that know nothing of each other.

use std::ops::Range;

/// A share of a still, for jobs that know nothing of each other. [`crate::job::merge`] makes the picture of all of them.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Share {
    /// Every n-th band of rows: number `number`, from 1, of `count`. The file is `OUT.1-of-2.share`.
    Rows {
        /// Which share, from 1.
        number: u32,
        /// How many there are, at most 500.
        count: u32,
    },
    /// Some samples of each pixel, by number. The file is `OUT.0-64.sums`.
    Samples(Range<u32>),
}
