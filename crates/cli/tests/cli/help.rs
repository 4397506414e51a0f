//! What `--help` shows: the built-in scenes, and examples that run.

use crate::place::Place;
use std::fs::{self, File};
use std::process::Stdio;

/// Examples of a command, as words. Those of shells' redirections stay in them.
fn examples(place: &Place, command: &[&str]) -> Vec<Vec<String>> {
    let help = place.run(&[command, &["--help"]].concat()).succeeded().stdout;
    let (_, examples) = help.split_once("Examples:\n").unwrap_or_else(|| panic!("{help}"));
    let words = |line: &str| line.split_whitespace().map(str::to_owned).collect();
    let all: Vec<Vec<String>> = examples.lines().map(words).collect();
    assert_eq!(all.len(), 3, "{help}");
    all
}

/// Runs an example, smaller than it is, as a shell would.
fn run(place: &Place, example: &[String], smaller: &[&str]) {
    let (words, files) = match example.iter().position(|word| word == "<" || word == ">") {
        Some(end) => example.split_at(end),
        None => (example, &[][..]),
    };
    assert_eq!(words[0], "eosphor");
    let words: Vec<&str> = words[1..].iter().map(String::as_str).chain(smaller.iter().copied()).collect();
    let mut command = place.command(&words);
    match files {
        [sign, file] if sign == "<" => drop(command.stdin(File::open(place.path(file)).unwrap())),
        [_, file] => drop(command.stdout(File::create(place.path(file)).unwrap())),
        _ => drop(command.stdin(Stdio::null())),
    }
    let output = command.output().unwrap();
    let is_done = output.status.success() || words[0] == "compare" && output.status.code() == Some(1);
    assert!(
        is_done && !output.stderr.starts_with(b"eosphor: "),
        "{words:?}: {}",
        String::from_utf8_lossy(&output.stderr)
    );
}

#[test]
fn the_examples_run() {
    let place = Place::new();
    let tiny = ["--size", "16x12", "--samples", "1", "--light-samples", "1"];
    for example in examples(&place, &[]) {
        let smaller = if example[1] == "render" { &tiny[..] } else { &[] };
        run(&place, &example, smaller);
    }
    for example in examples(&place, &["render"]) {
        run(&place, &example, &tiny);
    }
    assert!(place.path("turn/frame_035.png").exists());
    for example in examples(&place, &["merge"]) {
        run(&place, &example, if example[1] == "render" { &tiny } else { &[] });
    }
    for name in ["a.png", "b.png", "b.ppm", "a.exr", "b.hdr"] {
        place.render(name, &[]).succeeded();
    }
    for command in ["info", "compare"] {
        examples(&place, &[command]).iter().for_each(|example| run(&place, example, &[]));
    }
    for example in examples(&place, &["bench", "rays"]) {
        run(&place, &example, &["--size", "8x6", "--repeats", "1"]);
    }
    for example in examples(&place, &["bench", "render"]) {
        // Not every CPU has the instructions that the last one names.
        let smaller = [&tiny[..], &["--repeats", "1", "--simd", "auto"]].concat();
        run(&place, &example, &smaller);
    }
}

#[test]
fn the_examples_of_the_course_run() {
    let place = Place::new();
    let examples = examples(&place, &["course"]);
    run(&place, &examples[0], &[]);
    // Fewer frames, and smaller.
    let input = fs::read_to_string(place.path("input.txt")).unwrap();
    let mut lines: Vec<&str> = input.lines().collect();
    (lines[0], lines[2]) = ("2", "24 16 120");
    fs::write(place.path("input.txt"), lines.join("\n")).unwrap();
    examples[1..].iter().for_each(|example| run(&place, example, &[]));
    assert!(place.path("frames/0001.png").exists());
}

#[test]
fn help_lists_the_built_in_scenes() {
    let place = Place::new();
    let known = place.run(&["info", "builtin:"]).stderr;
    let (_, names) = known.trim().split_once("; there is ").unwrap();
    for command in [&["render"][..], &["info"], &["bench", "rays"], &["bench", "render"]] {
        let help = place.run(&[command, &["--help"]].concat()).succeeded().stdout;
        let help = help.split_whitespace().collect::<Vec<_>>().join(" ");
        let listed = names.split(", ").map(|name| format!("builtin:{name}")).collect::<Vec<_>>().join(", ");
        assert!(help.contains(&listed), "{command:?}: {help}");
    }
}
