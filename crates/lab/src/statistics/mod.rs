//! What may be said of numbers that were measured: medians, intervals, ratios of pairs, several claims at once.

mod bootstrap;
mod holm;
mod paired;
mod quantile;
mod random;
mod slope;
mod student;
mod unpaired;

pub use bootstrap::median_interval;
pub use holm::holm;
pub use paired::{PairedRatio, paired_ratio};
pub use quantile::{median, quantile};
pub use random::CountedRandom;
pub use slope::{Slope, log_log_slope};
pub use student::{two_sided_p, two_sided_t};
pub use unpaired::{UnpairedRatio, unpaired_ratio};
