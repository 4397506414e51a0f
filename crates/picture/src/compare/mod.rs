//! Comparing two pictures: identical, or where and by how much they differ.

mod difference;
mod flip;
mod pixels;

pub use difference::{CompareError, Comparison, FirstDifference, compare, difference_image};
