//! The laboratory of the Eosphor ray tracer: experiments about speed whose results can be trusted.
//!
//! The unit of repetition is a fresh process. An [`Experiment`] has variants; a block runs each of them once, in a random order,
//! and the base twice, so that the noise is measured and not assumed. What is said of a run ([`compare`]) are medians over
//! processes with intervals, ratios of the same block, and claims that are corrected for their number. Times of different answers
//! are not compared, and nothing is claimed of blocks in which other work was seen on the cores.
//!
//! The way: [`Experiment`] → [`run`] → [`RecordsFile`] (a line for each process; a run that was ended goes on) → [`compare`] →
//! [`write_report`], or [`markdown`] alone. [`compare_runs`] is for two versions or machines.
#![warn(missing_docs)]
#![forbid(unsafe_code)]

mod builtin;
mod comparison;
mod experiment;
mod load;
mod machine;
mod pictures;
mod plan;
mod process;
mod program;
mod quantity;
mod records;
mod report;
mod run;
pub mod statistics;
mod stopwatch;
mod two_runs;

pub use builtin::builtin_experiments;
pub use comparison::{QUICK, QuantityComparison, TOO_FEW, UNSTABLE, VariantResult, Verdict, compare};
pub use experiment::{
    Axis, Clock, Experiment, InvalidExperiment, Measure, Published, Quick, Shown, Variant, experiment_schema,
};
pub use load::Load;
pub use machine::{Gpu, Machine};
pub use pictures::{make_pictures, read_pictures};
pub use plan::{Slot, block_order};
pub use process::allowed_cores;
pub use program::{Program, hash_of_program};
pub use quantity::{MILLISECONDS, Quantity, read_quantities};
pub use records::{Header, Measured, Outcome, Record, Records, RecordsError, RecordsFile};
pub use report::{ReportError, ReportPicture, changes_markdown, markdown, readme_table, write_report};
pub use run::{CLAIM_BLOCKS, Run, RunError, RunOptions, RunProgress, Step, run};
pub use stopwatch::{Stopwatch, Times};
pub use two_runs::{Change, compare_runs};
