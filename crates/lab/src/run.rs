//! Runs an experiment: blocks of fresh processes, until enough of them were undisturbed.

use crate::experiment::{Experiment, Measure, Variant};
use crate::plan::{Slot, block_order};
use crate::process::{Measured, allowed_cores, measure};
use crate::records::{Outcome, Record, Records, RecordsError, RecordsFile};
use std::ffi::OsString;
use std::sync::atomic::{AtomicBool, Ordering};

/// The least number of undisturbed blocks that anything is claimed of.
pub const CLAIM_BLOCKS: u32 = 6;

/// How a run goes.
#[derive(Clone, Debug)]
pub struct RunOptions {
    /// Undisturbed blocks that are wanted; fewer than [`CLAIM_BLOCKS`] claim nothing.
    pub blocks: u32,
    /// The program that measures: this one.
    pub program: OsString,
    /// Whether there is a GPU for variants that need one.
    pub has_gpu: bool,
}

/// What a run reports before each process.
#[derive(Clone, Copy, Debug)]
pub struct RunProgress<'a> {
    /// The block, from 0.
    pub block: u32,
    /// Undisturbed blocks so far, of those that are wanted.
    pub undisturbed: [u32; 2],
    /// What runs now.
    pub variant: &'a str,
}

/// Runs what is missing of a run. Each process is in the file when it has ended. Blocks that other work has disturbed are run again,
/// as many as were wanted at most; both are kept. Whether all was run: `cancel` ends it after the process that runs.
///
/// # Errors
///
/// What the file of the run says. Processes that fail are part of the run.
pub fn run(
    file: &mut RecordsFile,
    options: &RunOptions,
    cancel: &AtomicBool,
    on_progress: &dyn Fn(RunProgress),
) -> Result<bool, RecordsError> {
    let experiment = file.records.header.experiment.clone();
    let seed = file.records.header.seed;
    let runs_here: Vec<bool> =
        experiment.variants.iter().map(|variant| options.has_gpu || !variant.needs_gpu).collect();
    let mut cores = allowed_cores();
    cores.truncate(experiment.cores.unwrap_or(usize::MAX));
    let mut block = 0;
    while undisturbed_blocks(&file.records, block) < options.blocks && block < 2 * options.blocks {
        for slot in block_order(&experiment, &runs_here, seed, block) {
            if file.records.has(block, slot) {
                continue;
            }
            if cancel.load(Ordering::Relaxed) {
                return Ok(false);
            }
            let variant = &experiment.variants[match slot {
                Slot::Variant(number) => number,
                Slot::BaseAgain => experiment.variant(&experiment.base).unwrap_or_default(),
            }];
            let undisturbed = [undisturbed_blocks(&file.records, block), options.blocks];
            on_progress(RunProgress { block, undisturbed, variant: &variant.name });
            let measured = run_variant(&experiment, variant, options, &cores);
            // A signal to all processes of a terminal ends the one that measures, too: that is no failure of it.
            if measured.is_err() && cancel.load(Ordering::Relaxed) {
                return Ok(false);
            }
            let outcome = measured.map_or_else(Outcome::Failed, Outcome::Measured);
            file.add(Record::new(&experiment, block, slot, outcome))?;
        }
        block += 1;
    }
    Ok(true)
}

/// Blocks below this one that no other work has disturbed.
fn undisturbed_blocks(records: &Records, end: u32) -> u32 {
    (0..end).filter(|&block| !records.is_disturbed(block)).count() as u32
}

/// A fresh process of a variant.
fn run_variant(
    experiment: &Experiment,
    variant: &Variant,
    options: &RunOptions,
    cores: &[usize],
) -> Result<Measured, String> {
    let mut arguments: Vec<String> = Vec::new();
    let program = match &variant.program {
        Some(program) => OsString::from(program),
        None => {
            let what = match experiment.measures {
                Measure::Picture => "render",
                Measure::Rays => "rays",
            };
            arguments.extend(
                ["bench", what, "--lines", "--repeats", &experiment.repeats.to_string()].map(String::from),
            );
            options.program.clone()
        }
    };
    arguments.extend(experiment.held.iter().chain(&variant.arguments).cloned());
    measure(&program, &arguments, cores)
}
