//! `eosphor lab`: experiments about speed.

use crate::arguments::{LabCompareFlags, LabReportFlags, LabRunFlags};
use crate::failure::Failure;
use crate::interrupt;
use crate::streams::{self, Verbosity};
use eosphor::{explain, first_gpu};
use eosphor_lab::{
    Change, Experiment, Header, Machine, Program, Records, RecordsFile, Run, RunOptions, RunProgress, Step,
    Verdict, builtin_experiments, changes_markdown, compare_runs, experiment_schema, hash_of_program,
    make_pictures, markdown, read_pictures, readme_table, write_report,
};
use std::fmt::Write;
use std::fs;
use std::path::{Path, PathBuf};

/// Blocks of a quick run.
const QUICK_BLOCKS: u32 = 2;

/// The most bytes of a file that describes an experiment.
const MAX_FILE: u64 = 1 << 20;

/// The ending of files of runs.
const ENDING: &str = "jsonl";

pub(crate) fn lab_list() -> Result<(), Failure> {
    let mut text = String::new();
    for Experiment { name, question, variants, .. } in builtin_experiments() {
        let _ = writeln!(text, "{name:<14} {:>2} variants   {question}", variants.len());
    }
    streams::result(&text)
}

pub(crate) fn lab_run(flags: &LabRunFlags) -> Result<(), Failure> {
    let verbosity = if flags.quiet { Verbosity::Quiet } else { Verbosity::Normal };
    let experiments: Vec<(Experiment, Option<String>)> = match flags.all {
        true => builtin_experiments().into_iter().map(|experiment| (experiment, None)).collect(),
        false => flags.experiments.iter().map(|name| find(name)).collect::<Result<_, _>>()?,
    };
    interrupt::watch(verbosity)?;
    let program = std::env::current_exe();
    let program =
        program.map_err(|error| Failure::Failed(format!("cannot find this program: {}", explain(&error))))?;
    let blocks = if flags.quick { QUICK_BLOCKS } else { flags.blocks };
    let this_program = this_program(&program);
    let options = RunOptions { blocks, program: program.into(), has_gpu: first_gpu().is_some() };
    let folder = &flags.output;
    fs::create_dir_all(folder).map_err(|error| {
        Failure::Failed(format!("cannot make the folder: {}: {}", folder.display(), explain(&error)))
    })?;
    let machine = Machine::this_one();
    let seed = u64::from(flags.seed.unwrap_or_else(random_seed));
    let mut files = Vec::new();
    for (experiment, source) in experiments {
        let quick = if flags.quick { "-quick" } else { "" };
        let path = folder.join(format!("{}{quick}.{ENDING}", experiment.name));
        let mut header = Header::new(&experiment, flags.quick, machine.clone(), seed, this_program.clone());
        header.source = source;
        let file = RecordsFile::open(&path, header).map_err(Failure::because)?;
        let kept = file.records.header.seed;
        if flags.seed.is_some_and(|seed| u64::from(seed) != kept) {
            return Err(Failure::Usage(format!(
                "--seed {seed}: {} has a run with seed {kept}; leave the flag out to go on with it",
                path.display()
            )));
        }
        files.push((experiment, path, file));
    }
    let mut runs: Vec<_> = files
        .iter_mut()
        .map(|(experiment, path, file)| (experiment, path, Run::new(file, &options)))
        .collect();
    let say = |progress: RunProgress| {
        let RunProgress { experiment, block, undisturbed: [done, wanted], variant } = progress;
        let line =
            format!("{experiment}: block {}, {done} of {wanted} undisturbed ones done; {variant}", block + 1);
        verbosity.say(Verbosity::Normal, &line);
    };
    // By turns, a block of each: see `Run`.
    while !runs.is_empty() {
        let mut unfinished = Vec::new();
        for (experiment, path, mut run) in runs {
            match run.next_block(interrupt::cancel().asked(), &say).map_err(Failure::because)? {
                Step::Block => unfinished.push((experiment, path, run)),
                Step::Whole => {
                    if let Err(why) = make_pictures(experiment, &options.program, path) {
                        verbosity.say(Verbosity::Normal, &format!("{}: note: {why}", experiment.name));
                    }
                    streams::result(&markdown(std::slice::from_ref(run.records())))?;
                }
                Step::Cancelled => {
                    let count = run.records().records.len();
                    return Err(Failure::Interrupted(format!(
                        "interrupted; {count} processes are in {}: the same command goes on",
                        path.display()
                    )));
                }
            }
        }
        runs = unfinished;
    }
    Ok(())
}

/// Which build of Eosphor this is.
fn this_program(path: &Path) -> Program {
    let given = |text: &str| (!text.is_empty()).then(|| text.to_owned());
    Program {
        version: env!("CARGO_PKG_VERSION").into(),
        commit: given(env!("EOSPHOR_COMMIT")),
        compiler: env!("EOSPHOR_COMPILER").into(),
        profile: env!("EOSPHOR_PROFILE").into(),
        features: env!("EOSPHOR_FEATURES").split(',').filter_map(given).collect(),
        hash: hash_of_program(path).unwrap_or_default(),
    }
}

pub(crate) fn lab_report(flags: &LabReportFlags) -> Result<(), Failure> {
    let paths = match flags.runs.is_empty() {
        true => runs_of(&flags.output)?,
        false => flags.runs.clone(),
    };
    let runs = read_all(&paths)?;
    if flags.table {
        let tables: Vec<String> = runs.iter().map(readme_table).collect();
        return streams::result(&tables.join("\n"));
    }
    let pictures: Vec<_> =
        runs.iter().zip(&paths).flat_map(|(records, path)| read_pictures(records, path)).collect();
    let written = write_report(&runs, &pictures, &flags.output).map_err(Failure::because)?;
    let page = flags.output.join("report.html");
    streams::result(&format!("{} and {} files beside it\n", page.display(), written.len().saturating_sub(1)))
}

pub(crate) fn lab_compare(flags: &LabCompareFlags) -> Result<(), Failure> {
    let [first, second] = [&flags.first, &flags.second].map(|path| match path.is_dir() {
        true => read_all(&runs_of(path)?),
        false => read_all(std::slice::from_ref(path)),
    });
    let changes = compare_runs(&first?, &second?);
    if changes.is_empty() {
        return Err(Failure::usage("the two have no experiment in common"));
    }
    streams::result(&changes_markdown(&changes))?;
    let slower = |change: &&Change| change.verdict == Verdict::More;
    match changes.iter().filter(slower).count() {
        0 => Ok(()),
        n => Err(Failure::Failed(format!("{n} of {} values of the second run are higher", changes.len()))),
    }
}

pub(crate) fn lab_schema() -> Result<(), Failure> {
    streams::result(&experiment_schema())
}

fn read_all(paths: &[PathBuf]) -> Result<Vec<Records>, Failure> {
    paths.iter().map(|path| Records::read(path).map_err(Failure::because)).collect()
}

/// The files of runs of a folder, by name.
fn runs_of(folder: &Path) -> Result<Vec<PathBuf>, Failure> {
    let cannot = |error: std::io::Error| {
        Failure::Failed(format!("cannot read the folder of runs: {}: {}", folder.display(), explain(&error)))
    };
    let mut runs = Vec::new();
    for entry in fs::read_dir(folder).map_err(cannot)? {
        let path = entry.map_err(cannot)?.path();
        if path.extension().is_some_and(|ending| ending == ENDING) {
            runs.push(path);
        }
    }
    runs.sort();
    match runs.is_empty() {
        true => {
            Err(Failure::Failed(format!("{} has no runs: make some with eosphor lab run", folder.display())))
        }
        false => Ok(runs),
    }
}

/// The experiment of this name, or of this file, and the file.
fn find(name: &str) -> Result<(Experiment, Option<String>), Failure> {
    if let Some(experiment) = builtin_experiments().into_iter().find(|experiment| experiment.name == name) {
        return Ok((experiment, None));
    }
    if !name.ends_with(".json") {
        let names: Vec<String> =
            builtin_experiments().into_iter().map(|experiment| experiment.name).collect();
        return Err(Failure::Usage(format!(
            "there is no experiment {name}: there are {}, and files that end in .json",
            names.join(", ")
        )));
    }
    let cannot = |error: std::io::Error| {
        Failure::Failed(format!("cannot read the experiment: {name}: {}", explain(&error)))
    };
    let length = fs::metadata(name).map_err(cannot)?.len();
    if length > MAX_FILE {
        return Err(Failure::Failed(format!("cannot read the experiment: {name}: more than 1 MiB")));
    }
    let text = fs::read_to_string(name).map_err(cannot)?;
    // The error names line and column.
    let experiment: Experiment =
        serde_json::from_str(&text).map_err(|error| Failure::Failed(format!("{name}: {error}")))?;
    let checked = experiment.check().and_then(|()| experiment.check_use());
    checked.map_err(|error| Failure::Failed(format!("{name}: {error}")))?;
    Ok((experiment, Some(name.to_owned())))
}

/// Different with every call.
fn random_seed() -> u32 {
    use std::hash::{BuildHasher, RandomState};
    RandomState::new().hash_one(std::process::id()) as u32
}
