//! Runs a program as `eosphor lab` does, and looks at what it prints. For tests; a failure is a panic.

use crate::data::SETS;
use serde_json::Value;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

/// Rays of each set of a sample.
const RAYS: usize = 3000;

/// An empty folder of this name in a folder for the files of tests.
pub fn folder(parent: &str, name: &str) -> PathBuf {
    let folder = Path::new(parent).join(name);
    // What an earlier run left there would hide what is missing.
    let _ = fs::remove_dir_all(&folder);
    fs::create_dir_all(&folder).expect("the folder can be made");
    folder
}

/// A folder with a sample: 500 triangles, and 3000 rays in each set.
pub fn sample(parent: &str, name: &str) -> PathBuf {
    let folder = folder(parent, name);
    crate::sample::write(&folder, 500, RAYS).expect("the sample can be written");
    folder
}

/// Runs a program with these words and flags.
pub fn run(program: &str, library: &str, folder: &Path, flags: &[&str]) -> Output {
    Command::new(program).arg(library).arg(folder).args(flags).output().expect("the program can be started")
}

/// A library finds what the sample's brute force finds, and prints it as the format says.
pub fn finds_all_hits(program: &str, library: &str, sample: &Path, flags: &[&str]) {
    let what = format!("{library} {flags:?}");
    let output = run(program, library, sample, &[&["--repeats", "2"], flags].concat());
    let errors = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success() && errors.is_empty(), "{what}: {}: {errors}", output.status);
    let text = String::from_utf8(output.stdout).expect("it prints text");
    let lines: Vec<Value> =
        text.lines().map(|line| serde_json::from_str(line).expect("a line is JSON")).collect();
    let mut quantities = vec!["build".to_owned()];
    quantities.extend(SETS.iter().flat_map(|set| [format!("{set}, closest hit"), format!("{set}, any hit")]));
    let printed: Vec<&str> = lines.iter().filter_map(|line| line["quantity"].as_str()).collect();
    assert_eq!(printed, quantities, "{what}");
    for line in &lines {
        assert_eq!(line["unit"], "ms", "{what}: {line}");
        for times in [&line["values"], &line["cpu"]] {
            let times: Vec<f64> = times.as_array().into_iter().flatten().filter_map(Value::as_f64).collect();
            assert!(times.len() == 2 && times.iter().all(|time| *time >= 0.0), "{what}: {line}");
        }
    }
    for (line, set) in lines[1..].iter().zip(SETS.iter().flat_map(|set| [set, set])) {
        let number =
            |name: &str| line[name].as_u64().unwrap_or_else(|| panic!("{what}: {name} of {line}")) as usize;
        let expected = expected_hits(&sample.join(format!("{set}.hits")));
        assert!(
            expected > RAYS / 10 && expected < RAYS - RAYS / 10,
            "the sample has hits and misses: {expected}"
        );
        assert_eq!(number("work"), RAYS, "{what}: {line}");
        assert!(
            number("hits").abs_diff(expected) * 100 <= expected,
            "{what}: {expected} hits expected: {line}"
        );
        assert!(number("different") * 100 < RAYS, "{what}: {line}");
    }
}

/// The program refuses to run, with one line and exit code 1.
pub fn refuses(program: &str, library: &str, folder: &Path, flags: &[&str], message: &str) {
    let output = run(program, library, folder, flags);
    let errors = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "{message}: {errors}");
    assert!(output.stdout.is_empty() && errors.lines().count() == 1, "{message}: {errors}");
    assert!(errors.contains(message), "'{message}' is expected: {errors}");
}

fn expected_hits(path: &Path) -> usize {
    let bytes = fs::read(path).expect("the sample is there");
    bytes[4..].chunks(8).filter(|hit| hit[4..] != [0xff; 4]).count()
}
