//! The file of a run: what was measured, a line for each process, so that a run which was ended goes on.

use crate::experiment::{Experiment, Measure};
use crate::load::Load;
use crate::machine::Machine;
use crate::plan::Slot;
use crate::program::Program;
use crate::quantity::Quantity;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::fs::{File, OpenOptions};
use std::io::{Error, ErrorKind, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

/// Raised whenever lines of older files can no longer be read.
const FORMAT: u32 = 1;

/// The most bytes of a file.
const MAX_BYTES: u64 = 256 << 20;

/// What a run is: the first line of its file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub struct Header {
    format: u32,
    /// The program that is measured.
    pub program: Program,
    /// When the run began, in seconds since 1970.
    pub began: u64,
    /// Keys the orders of blocks.
    pub seed: u64,
    /// The experiment is run as `--quick` has it.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub is_quick: bool,
    /// The file that describes the experiment, as it was named; `None`: it comes with the program.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub source: Option<String>,
    /// Where it ran.
    pub machine: Machine,
    /// What was run.
    pub experiment: Experiment,
}

/// A process that has run: each line after the first.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub struct Record {
    /// The block.
    pub block: u32,
    /// The name of the variant.
    pub variant: String,
    /// It was the base, for the second time in its block.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub again: bool,
    /// What it measured, or why it did not.
    pub outcome: Outcome,
}

/// A process that has measured.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub struct Measured {
    /// What it printed.
    pub quantities: Vec<Quantity>,
    /// How long it ran, with all that it did besides.
    pub wall_seconds: f64,
    /// The time that it took of cores.
    pub cpu_seconds: f64,
    /// What else ran; where the system does not tell, nothing.
    pub load: Option<Load>,
}

/// What came of a process.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Outcome {
    /// Its measurements.
    Measured(Measured),
    /// Why there are none.
    Failed(String),
}

/// Why a file of a run cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum RecordsError {
    /// The system's reason.
    #[error("{}: {source}", path.display())]
    File {
        /// The file.
        path: PathBuf,
        /// The system's reason.
        source: Error,
    },
    /// It is no such file, or it was changed.
    #[error("{}:{line}: {problem}", path.display())]
    Line {
        /// The file.
        path: PathBuf,
        /// The line, from 1.
        line: usize,
        /// What is wrong with it.
        problem: String,
    },
    /// It holds another run.
    #[error("{}: it holds a run of another experiment, machine or program: move it away, or choose another folder", path.display())]
    Other {
        /// The file.
        path: PathBuf,
    },
}

/// A run, as far as it is.
#[derive(Clone, Debug, PartialEq)]
pub struct Records {
    /// What it is.
    pub header: Header,
    /// Processes in the order in which they ran.
    pub records: Vec<Record>,
}

impl Header {
    /// That of a run which begins now.
    pub fn new(
        experiment: &Experiment,
        is_quick: bool,
        machine: Machine,
        seed: u64,
        program: Program,
    ) -> Header {
        let experiment = if is_quick { experiment.quickly() } else { experiment.clone() };
        let now = std::time::SystemTime::now().duration_since(std::time::UNIX_EPOCH);
        let began = now.map_or(0, |since| since.as_secs());
        Header { format: FORMAT, program, began, seed, is_quick, source: None, machine, experiment }
    }

    /// Names machine and program in 8 digits: figures with the same ones were measured by the same program on the same machine.
    pub fn id(&self) -> String {
        let text = serde_json::to_vec(&(&self.machine, &self.program)).unwrap_or_default();
        blake3::hash(&text).to_hex()[..8].to_owned()
    }

    /// Whether a run with this header goes on with the lines of the other one.
    fn is_same_run(&self, other: &Header) -> bool {
        let when = |header: &Header| Header { began: 0, seed: 0, source: None, ..header.clone() };
        when(self) == when(other)
    }
}

impl Record {
    /// What ran in a place of a block.
    pub fn new(experiment: &Experiment, block: u32, slot: Slot, outcome: Outcome) -> Record {
        let (variant, again) = match slot {
            Slot::Variant(number) => (experiment.variants[number].name.clone(), false),
            Slot::BaseAgain => (experiment.base.clone(), true),
        };
        Record { block, variant, again, outcome }
    }
}

impl Records {
    /// Reads the file of a run. A last line that was not written to its end is left out.
    ///
    /// # Errors
    ///
    /// What the system says, or the first line that makes no sense.
    pub fn read(path: &Path) -> Result<Records, RecordsError> {
        let file = File::open(path).map_err(|source| RecordsError::File { path: path.into(), source })?;
        Ok(read_lines(path, file)?.0)
    }

    /// Whether this place of a block has run.
    pub fn has(&self, block: u32, slot: Slot) -> bool {
        let experiment = &self.header.experiment;
        let wanted = Record::new(experiment, block, slot, Outcome::Failed(String::new()));
        self.records.iter().any(|r| (r.block, &r.variant, r.again) == (block, &wanted.variant, wanted.again))
    }

    /// Whether other work was seen on the cores in a block, where that could change what is measured.
    pub fn is_disturbed(&self, block: u32) -> bool {
        if self.header.experiment.measures == Measure::Noise {
            return false;
        }
        let allowed = self.header.machine.allowed_cores.len().max(1);
        let cores = self.header.experiment.cores.map_or(allowed, |cores| cores.min(allowed));
        self.records.iter().filter(|record| record.block == block).any(|record| match &record.outcome {
            Outcome::Measured(measured) => measured.load.is_some_and(|load| load.disturbs(cores)),
            Outcome::Failed(_) => false,
        })
    }

    /// The measurements of a block, by variant, and of the base's second run.
    pub fn block(&self, block: u32) -> BTreeMap<(&str, bool), &Measured> {
        let of_block = self.records.iter().filter(|record| record.block == block);
        of_block
            .filter_map(|record| match &record.outcome {
                Outcome::Measured(measured) => Some(((record.variant.as_str(), record.again), measured)),
                Outcome::Failed(_) => None,
            })
            .collect()
    }
}

/// The records, and the bytes of their lines.
fn read_lines(path: &Path, mut file: File) -> Result<(Records, u64), RecordsError> {
    let failed = |source| RecordsError::File { path: path.into(), source };
    let mut bytes = Vec::new();
    (&mut file).take(MAX_BYTES + 1).read_to_end(&mut bytes).map_err(failed)?;
    if bytes.len() as u64 > MAX_BYTES {
        return Err(failed(Error::new(ErrorKind::FileTooLarge, "more than 256 MiB")));
    }
    let whole = bytes.iter().rposition(|&byte| byte == b'\n').map_or(0, |last| last + 1);
    let at = |line: usize, problem: String| RecordsError::Line { path: path.into(), line: line + 1, problem };
    let mut lines =
        bytes[..whole].split(|&byte| byte == b'\n').enumerate().filter(|(_, line)| !line.is_empty());
    let (_, first) = lines.next().ok_or_else(|| at(0, "it holds no run".into()))?;
    let header: Header = serde_json::from_slice(first).map_err(|error| at(0, format!("no run: {error}")))?;
    if header.format != FORMAT {
        return Err(at(0, format!("format {}: this version reads format {FORMAT}", header.format)));
    }
    header.experiment.check().map_err(|error| at(0, error.to_string()))?;
    let mut records = Vec::new();
    for (number, line) in lines {
        let record: Record =
            serde_json::from_slice(line).map_err(|error| at(number, format!("no record: {error}")))?;
        if header.experiment.variant(&record.variant).is_none() {
            return Err(at(number, format!("the experiment has no variant \"{}\"", record.variant)));
        }
        records.push(record);
    }
    Ok((Records { header, records }, whole as u64))
}

/// The file of a run that is being written.
pub struct RecordsFile {
    path: PathBuf,
    file: File,
    /// What it holds.
    pub records: Records,
}

impl RecordsFile {
    /// Opens the file to go on with its run, or begins it. Of a run that goes on, seed and beginning are those of the file.
    ///
    /// # Errors
    ///
    /// What the system says; a line that makes no sense; a run that is another one.
    pub fn open(path: &Path, header: Header) -> Result<RecordsFile, RecordsError> {
        let failed = |source| RecordsError::File { path: path.into(), source };
        let mut options = OpenOptions::new();
        let mut file =
            options.read(true).write(true).create(true).truncate(false).open(path).map_err(failed)?;
        match file.try_lock() {
            Ok(()) => {}
            Err(std::fs::TryLockError::WouldBlock) => {
                let busy = Error::new(ErrorKind::ResourceBusy, "another process writes this run");
                return Err(failed(busy));
            }
            Err(std::fs::TryLockError::Error(source)) => return Err(failed(source)),
        }
        if file.metadata().map_err(failed)?.len() == 0 {
            let records = Records { header, records: Vec::new() };
            let line = line(&records.header).map_err(failed)?;
            file.write_all(&line).and_then(|()| file.sync_data()).map_err(failed)?;
            return Ok(RecordsFile { path: path.into(), file, records });
        }
        let again = file.try_clone().map_err(failed)?;
        let (records, whole) = read_lines(path, again)?;
        if !header.is_same_run(&records.header) {
            return Err(RecordsError::Other { path: path.into() });
        }
        // What a process that was killed left of its last line.
        file.set_len(whole).and_then(|()| file.seek(SeekFrom::Start(whole))).map_err(failed)?;
        Ok(RecordsFile { path: path.into(), file, records })
    }

    /// Where it is.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Adds a process that has run. It is on the disk when this returns.
    ///
    /// # Errors
    ///
    /// What the system says.
    pub fn add(&mut self, record: Record) -> Result<(), RecordsError> {
        let written =
            line(&record).and_then(|line| self.file.write_all(&line)).and_then(|()| self.file.sync_data());
        written.map_err(|source| RecordsError::File { path: self.path.clone(), source })?;
        self.records.records.push(record);
        Ok(())
    }
}

impl Drop for RecordsFile {
    fn drop(&mut self) {
        // Before the file is closed: a process that another thread is just starting has it, too, until it runs its program.
        let _ = self.file.unlock();
    }
}

fn line(item: &impl Serialize) -> Result<Vec<u8>, Error> {
    let mut line = serde_json::to_vec(item)?;
    line.push(b'\n');
    Ok(line)
}
