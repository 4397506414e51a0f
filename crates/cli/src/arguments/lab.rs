//! Flags of `eosphor lab`.

use super::values::whole;
use clap::{Args, Subcommand};
use std::path::PathBuf;

#[derive(Debug, Args)]
pub(crate) struct LabFlags {
    #[command(subcommand)]
    pub(crate) what: Lab,
}

#[derive(Debug, Subcommand)]
pub(crate) enum Lab {
    /// List the experiments
    List,
    /// Run experiments, or go on with them
    ///
    /// Every measurement is a process of its own. Blocks run all variants in random order, and the base twice. A run that was ended
    /// goes on; each process is on the disk when it has ended.
    #[command(after_help = super::examples::LAB_RUN)]
    Run(LabRunFlags),
    /// Write what runs have found, as far as they are: a page, Markdown, charts and tables
    ///
    /// report.html needs no other file. report.md has its charts in charts/; tables/ has all values as CSV.
    #[command(after_help = super::examples::LAB_REPORT)]
    Report(LabReportFlags),
    /// Compare two runs of the same experiments: two versions, or two machines
    ///
    /// Prints a table in Markdown. Exits with 1 where something of the second run is slower.
    #[command(after_help = super::examples::LAB_COMPARE)]
    Compare(LabCompareFlags),
    /// Print the JSON schema of files that describe experiments, for editors
    Schema,
}

#[derive(Debug, Args)]
pub(crate) struct LabCompareFlags {
    /// A run, or a folder of runs
    #[arg(value_name = "FIRST")]
    pub(crate) first: PathBuf,
    /// The run, or folder of runs, that is compared with it
    #[arg(value_name = "SECOND")]
    pub(crate) second: PathBuf,
}

#[derive(Debug, Args)]
pub(crate) struct LabRunFlags {
    /// Names of experiments (eosphor lab list), or JSON files that describe one
    #[arg(value_name = "EXPERIMENT", required_unless_present = "all")]
    pub(crate) experiments: Vec<String>,
    /// Run all experiments of the list
    #[arg(long, conflicts_with = "experiments")]
    pub(crate) all: bool,
    /// The folder that runs are kept in, a file each
    #[arg(short, long, value_name = "FOLDER", default_value = "eosphor-lab")]
    pub(crate) output: PathBuf,
    /// Undisturbed blocks to run, 1 to 1000; claims need 6
    #[arg(long, value_name = "N", default_value = "6", value_parser = whole::<u32>(1..=1000), allow_hyphen_values = true)]
    pub(crate) blocks: u32,
    /// Two blocks of less work, of which nothing is claimed
    #[arg(long, conflicts_with = "blocks")]
    pub(crate) quick: bool,
    /// Seed of the orders of blocks, 0 to 4294967295 [default: random; of a run that goes on, its own]
    #[arg(long, value_name = "N", value_parser = whole::<u32>(0..=u32::MAX), allow_hyphen_values = true)]
    pub(crate) seed: Option<u32>,
    /// Print errors only
    #[arg(short, long)]
    pub(crate) quiet: bool,
}

#[derive(Debug, Args)]
pub(crate) struct LabReportFlags {
    /// Files of runs [default: all of the folder]
    #[arg(value_name = "RUN")]
    pub(crate) runs: Vec<PathBuf>,
    /// The folder that runs are kept in, and the report is written to
    #[arg(short, long, value_name = "FOLDER", default_value = "eosphor-lab")]
    pub(crate) output: PathBuf,
    /// Print one short table for each run instead, in Markdown
    #[arg(long)]
    pub(crate) table: bool,
}
