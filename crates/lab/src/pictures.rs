//! Pictures of a run, beside its file.

use crate::experiment::{Experiment, Shown};
use crate::process::run_process;
use crate::records::Records;
use crate::report::ReportPicture;
use std::ffi::OsString;
use std::fs::{self, File};
use std::io::Read;
use std::path::{Path, PathBuf};

/// The most bytes of a picture that a report takes up.
const MAX_BYTES: u64 = 1 << 20;

/// Where picture `number` of a run is: `structures.jsonl-1-a.png`.
fn path_of(run: &Path, number: usize, side: char) -> PathBuf {
    let mut name = run.as_os_str().to_owned();
    name.push(format!("-{}-{side}.png", number + 1));
    name.into()
}

/// Renders the pictures of an experiment that are not there yet, beside the file of its run.
///
/// # Errors
///
/// Why one was not rendered, in a line.
pub fn make_pictures(experiment: &Experiment, program: &OsString, run: &Path) -> Result<(), String> {
    for (number, Shown { a, b, title, .. }) in experiment.pictures.iter().enumerate() {
        for (side, arguments) in [('a', a), ('b', b)] {
            let path = path_of(run, number, side);
            if arguments.is_empty() || path.exists() {
                continue;
            }
            let mut words = vec![program.clone(), "render".into()];
            words.extend(arguments.iter().map(OsString::from));
            words.extend(["--quiet".into(), "-o".into(), path.into_os_string()]);
            run_process(&words, None, &[]).map_err(|why| format!("the picture \"{title}\": {why}"))?;
        }
    }
    Ok(())
}

/// The pictures of a run that are there, for its report.
pub fn read_pictures(records: &Records, run: &Path) -> Vec<ReportPicture> {
    let experiment = &records.header.experiment;
    let of_one = |(number, shown): (usize, &Shown)| {
        Some(ReportPicture {
            experiment: experiment.name.clone(),
            title: shown.title.clone(),
            caption: shown.caption.clone(),
            a_png: read(&path_of(run, number, 'a'))?,
            b_png: read(&path_of(run, number, 'b')),
            heat_png: None,
        })
    };
    experiment.pictures.iter().enumerate().filter_map(of_one).collect()
}

fn read(path: &Path) -> Option<Vec<u8>> {
    if fs::metadata(path).ok()?.len() > MAX_BYTES {
        return None;
    }
    let mut bytes = Vec::new();
    File::open(path).ok()?.take(MAX_BYTES).read_to_end(&mut bytes).ok()?;
    bytes.starts_with(b"\x89PNG").then_some(bytes)
}
