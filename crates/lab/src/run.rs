//! Runs an experiment: blocks of fresh processes, until enough of them were undisturbed.

use crate::experiment::{Experiment, Measure, Variant};
use crate::plan::{Slot, block_order};
use crate::process::{Ended, allowed_cores, run_process};
use crate::quantity::{MILLISECONDS, Quantity, read_quantities};
use crate::records::{Measured, Outcome, Record, Records, RecordsError, RecordsFile};
use std::ffi::OsString;
use std::fs::{self, File};
use std::path::{Path, PathBuf};
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
    /// The experiment.
    pub experiment: &'a str,
    /// The block, from 0.
    pub block: u32,
    /// Undisturbed blocks so far, of those that are wanted.
    pub undisturbed: [u32; 2],
    /// What runs now.
    pub variant: &'a str,
}

/// Why a run could not go on.
#[derive(Debug, thiserror::Error)]
pub enum RunError {
    /// Its file.
    #[error(transparent)]
    Records(#[from] RecordsError),
    /// What the processes read could not be made.
    #[error("the preparation of experiment \"{experiment}\" failed: {problem}")]
    Prepare {
        /// The experiment.
        experiment: String,
        /// What went wrong.
        problem: String,
    },
}

/// Runs what is missing of a run. Whether all was run: `cancel` ends it after the process that runs.
///
/// # Errors
///
/// As [`Run::next_block`].
pub fn run(
    file: &mut RecordsFile,
    options: &RunOptions,
    cancel: &AtomicBool,
    on_progress: &dyn Fn(RunProgress),
) -> Result<bool, RunError> {
    let mut run = Run::new(file, options);
    loop {
        match run.next_block(cancel, on_progress)? {
            Step::Block => {}
            Step::Whole => return Ok(true),
            Step::Cancelled => return Ok(false),
        }
    }
}

/// A run that goes on block by block, so that several can be taken by turns: blocks that are minutes apart see more of what a
/// machine does over an hour than blocks in a row, and their intervals say so.
pub struct Run<'a> {
    file: &'a mut RecordsFile,
    options: &'a RunOptions,
    runs_here: Vec<bool>,
    cores: Vec<usize>,
    place: Option<Place>,
    /// That runs next.
    block: u32,
}

/// What came of a call for a block.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Step {
    /// It has run; there may be more.
    Block,
    /// Nothing was missing.
    Whole,
    /// It was cancelled; what has run is in the file.
    Cancelled,
}

impl<'a> Run<'a> {
    /// Goes on with the run of this file.
    pub fn new(file: &'a mut RecordsFile, options: &'a RunOptions) -> Run<'a> {
        let experiment = &file.records.header.experiment;
        let runs_here =
            experiment.variants.iter().map(|variant| options.has_gpu || !variant.needs_gpu).collect();
        let mut cores = allowed_cores();
        cores.truncate(experiment.cores.unwrap_or(usize::MAX));
        Run { file, options, runs_here, cores, place: None, block: 0 }
    }

    /// What has run.
    pub fn records(&self) -> &Records {
        &self.file.records
    }

    /// Runs what is missing of the next block. Each process is in the file when it has ended. Blocks that other work has disturbed
    /// are run again, as many as were wanted at most; both are kept. `cancel` ends it after the process that runs.
    ///
    /// # Errors
    ///
    /// What the file of the run says, and a preparation that failed. Processes that fail are part of the run.
    pub fn next_block(
        &mut self,
        cancel: &AtomicBool,
        on_progress: &dyn Fn(RunProgress),
    ) -> Result<Step, RunError> {
        let (options, block) = (self.options, self.block);
        let undisturbed = undisturbed_blocks(&self.file.records, block);
        if undisturbed >= options.blocks || block >= 2 * options.blocks {
            // What was prepared is not needed any more.
            self.place = None;
            return Ok(Step::Whole);
        }
        let experiment = self.file.records.header.experiment.clone();
        for slot in block_order(&experiment, &self.runs_here, self.file.records.header.seed, block) {
            if self.file.records.has(block, slot) {
                continue;
            }
            if cancel.load(Ordering::Relaxed) {
                return Ok(Step::Cancelled);
            }
            if self.place.is_none() {
                let problem = |problem| RunError::Prepare { experiment: experiment.name.clone(), problem };
                self.place = Some(Place::prepare(&experiment, options, self.file).map_err(problem)?);
            }
            let Some(place) = &self.place else { unreachable!("it was just made") };
            let variant = &experiment.variants[match slot {
                Slot::Variant(number) => number,
                Slot::BaseAgain => experiment.variant(&experiment.base).unwrap_or_default(),
            }];
            let undisturbed = [undisturbed, options.blocks];
            on_progress(RunProgress {
                experiment: &experiment.name,
                block,
                undisturbed,
                variant: &variant.name,
            });
            let measured = run_variant(&experiment, variant, block, options, place, &self.cores);
            // A signal to all processes of a terminal ends the one that measures, too: that is no failure of it.
            if measured.is_err() && cancel.load(Ordering::Relaxed) {
                return Ok(Step::Cancelled);
            }
            let outcome = measured.map_or_else(Outcome::Failed, Outcome::Measured);
            self.file.add(Record::new(&experiment, block, slot, outcome))?;
        }
        self.block += 1;
        Ok(Step::Block)
    }
}

/// Blocks below this one that no other work has disturbed.
fn undisturbed_blocks(records: &Records, end: u32) -> u32 {
    (0..end).filter(|&block| !records.is_disturbed(block)).count() as u32
}

/// Where processes read what was prepared, and write: a folder beside the file of the run.
struct Place {
    folder: PathBuf,
}

impl Place {
    fn prepare(experiment: &Experiment, options: &RunOptions, file: &RecordsFile) -> Result<Place, String> {
        let mut name = file.path().as_os_str().to_owned();
        name.push(".work");
        let place = Place { folder: name.into() };
        let cannot = |error: std::io::Error| format!("{}: {error}", place.folder.display());
        // What a run that was killed has left; nobody else has this file of a run.
        if place.folder.exists() {
            fs::remove_dir_all(&place.folder).map_err(cannot)?;
        }
        fs::create_dir_all(place.folder.join("data")).map_err(cannot)?;
        if !experiment.prepare.is_empty() {
            let mut words = vec![options.program.clone()];
            words.extend(experiment.prepare.iter().map(|word| place.filled(word, 0)));
            run_process(&words, None, &[])?;
        }
        Ok(place)
    }

    /// A word with the places that its braces stand for.
    fn filled(&self, word: &str, block: u32) -> OsString {
        let path = |name: &str| self.folder.join(name).to_string_lossy().into_owned();
        let filled = word.replace("{data}", &path("data")).replace("{out}", &path("out"));
        filled.replace("{block}", &block.to_string()).into()
    }
}

impl Drop for Place {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.folder);
    }
}

/// A fresh process of a variant.
fn run_variant(
    experiment: &Experiment,
    variant: &Variant,
    block: u32,
    options: &RunOptions,
    place: &Place,
    cores: &[usize],
) -> Result<Measured, String> {
    let repeats = experiment.repetitions().to_string();
    let mut words: Vec<OsString> = variant.launcher.iter().map(OsString::from).collect();
    words.push(variant.program.as_ref().map_or_else(|| options.program.clone(), OsString::from));
    if variant.program.is_none() {
        let bench: &[&str] = match experiment.measures {
            Measure::Picture => &["bench", "render", "--lines", "--repeats", &repeats],
            Measure::Rays => &["bench", "rays", "--lines", "--repeats", &repeats],
            Measure::Noise => &["bench", "noise", "--lines", "--repeats", &repeats],
            Measure::Process => &[],
        };
        words.extend(bench.iter().map(OsString::from));
        words.extend(experiment.held.iter().map(|word| place.filled(word, block)));
    }
    words.extend(variant.arguments.iter().map(|word| place.filled(word, block)));
    let out = place.folder.join("out");
    let cannot = |error: std::io::Error| format!("its folder for output: {error}");
    fs::create_dir(&out).map_err(cannot)?;
    let measured = run_process(&words, experiment.input.as_deref(), cores).and_then(|ended| {
        let quantities = match experiment.measures {
            Measure::Process => vec![whole_process(&ended, &out).map_err(cannot)?],
            _ => read_quantities(&ended.output)?,
        };
        let Ended { wall_seconds, cpu_seconds, load, .. } = ended;
        Ok(Measured { quantities, wall_seconds, cpu_seconds, load })
    });
    fs::remove_dir_all(&out).map_err(cannot)?;
    measured
}

/// The time of a process as a whole; its answer are the files that it wrote.
fn whole_process(ended: &Ended, out: &Path) -> Result<Quantity, std::io::Error> {
    let mut paths: Vec<_> =
        fs::read_dir(out)?.map(|entry| Ok(entry?.path())).collect::<Result<_, std::io::Error>>()?;
    paths.sort();
    let mut hasher = blake3::Hasher::new();
    for path in &paths {
        let name = path.file_name().unwrap_or_default().as_encoded_bytes();
        hasher.update(&(name.len() as u64).to_le_bytes()).update(name);
        hasher.update(&fs::metadata(path)?.len().to_le_bytes());
        hasher.update_reader(File::open(path)?)?;
    }
    let hash = hasher.finalize().to_hex();
    Ok(Quantity {
        quantity: "whole process".into(),
        unit: MILLISECONDS.into(),
        values: vec![ended.wall_seconds * 1e3],
        cpu: if ended.cpu_seconds > 0.0 { vec![ended.cpu_seconds * 1e3] } else { Vec::new() },
        answer: (!paths.is_empty()).then(|| hash[..16].to_owned()),
        ..Quantity::default()
    })
}
