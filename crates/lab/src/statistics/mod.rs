//! What may be said of numbers that were measured: medians, intervals, ratios of pairs, several claims at once.

mod bootstrap;
mod holm;
mod paired;
mod quantile;
mod random;
mod student;

pub use bootstrap::median_interval;
pub use holm::holm;
pub use paired::{PairedRatio, paired_ratio};
pub use quantile::{median, quantile};
pub use random::CountedRandom;
pub use student::{two_sided_p, two_sided_t};
