//! The laboratory of the Eosphor ray tracer: experiments about speed whose results can be trusted.
//!
//! The unit of repetition is a fresh process. An [`Experiment`] has variants; a block runs each of them once, in a random order, and
//! the base twice, so that the noise is measured and not assumed. What is said of a run ([`compare`]) are medians over processes with
//! intervals, ratios of the same block, and claims that are corrected for their number. Times of different answers are not compared,
//! and nothing is claimed of blocks in which other work was seen on the cores.
//!
//! The way: [`Experiment`] → [`run`] → [`RecordsFile`] (a line for each process; a run that was ended goes on) → [`compare`] →
//! [`markdown`].
#![warn(missing_docs)]
#![forbid(unsafe_code)]

mod builtin;
mod comparison;
mod experiment;
mod load;
mod machine;
mod plan;
mod process;
mod quantity;
mod records;
mod report;
mod run;
pub mod statistics;

pub use builtin::builtin_experiments;
pub use comparison::{Comparison, TOO_FEW, UNSTABLE, VariantResult, Verdict, compare};
pub use experiment::{Experiment, InvalidExperiment, Measure, Variant};
pub use load::Load;
pub use machine::Machine;
pub use plan::{Slot, block_order};
pub use process::{Measured, allowed_cores, measure};
pub use quantity::{Quantity, read_quantities};
pub use records::{Header, Outcome, Record, Records, RecordsError, RecordsFile};
pub use report::markdown;
pub use run::{CLAIM_BLOCKS, RunOptions, RunProgress, run};
