//! Closed pipes, full disks and signals.

use crate::place::{Place, holds};
use std::fs::{self, File};
use std::io::{BufRead, BufReader};
use std::process::Stdio;
use std::time::{Duration, Instant};

#[test]
fn a_closed_pipe_is_no_failure() {
    let place = Place::new();
    let mut child = place.command(&["completions", "bash"]).stdout(Stdio::piped()).spawn().unwrap();
    drop(child.stdout.take());
    assert_eq!(child.wait().unwrap().code(), Some(0));
}

#[test]
fn a_full_disk_behind_stdout_is_one_line() {
    let Ok(full) = File::options().write(true).open("/dev/full") else { return };
    let output = Place::new().command(&["completions", "bash"]).stdout(full).output().unwrap();
    let stderr = String::from_utf8(output.stderr).unwrap();
    assert_eq!((output.status.code(), stderr.lines().count()), (Some(1), 1), "{stderr}");
}

#[test]
fn a_full_disk_behind_stderr_stops_nothing() {
    let Ok(full) = File::options().write(true).open("/dev/full") else { return };
    let place = Place::new();
    let arguments = ["render", "builtin:cornell", "-o", "a.png", "--size", "8x8", "--samples", "1"];
    let status = place.command(&arguments).stderr(full).status().unwrap();
    assert_eq!(status.code(), Some(0));
    assert_eq!(place.names(), ["a.png"]);
}

/// Minutes of work for a CPU, of which the first lines are done in no time.
const LONG: [&str; 11] = [
    "render",
    "builtin:cornell",
    "-o",
    "a.png",
    "--size",
    "2000x2000",
    "--samples",
    "64",
    "-v",
    "--backend",
    "cpu",
];

fn interrupt(child: &std::process::Child) {
    // SAFETY: kill only sends a signal; the child has not been waited for, so its number is its own.
    assert_eq!(unsafe { libc::kill(child.id() as i32, libc::SIGINT) }, 0);
}

/// Interrupts [`LONG`] with more flags after some time; what it said after that, and its exit code.
fn interrupted(place: &Place, more: &[&str]) -> (Vec<String>, Option<i32>) {
    let mut child = place.command(&[&LONG[..], more].concat()).stderr(Stdio::piped()).spawn().unwrap();
    let mut lines = BufReader::new(child.stderr.take().unwrap()).lines().map(Result::unwrap);
    assert!(lines.any(|line| line.starts_with("rendering")), "it never started");
    std::thread::sleep(Duration::from_millis(1500));
    interrupt(&child);
    let rest: Vec<String> = lines.collect();
    (rest, child.wait().unwrap().code())
}

#[test]
fn ctrl_c_keeps_the_partial_picture() {
    for (name, more) in [
        ("a.png", &[][..]),
        ("b.png", &["--band-rows", "4"]),
        ("c.exr", &["--layers", "all", "--band-rows", "4"]),
    ] {
        let place = Place::new();
        let (rest, code) = interrupted(&place, &[&["-o", name], more].concat());
        assert_eq!(code, Some(130), "{rest:?}");
        assert!(rest.last().is_some_and(|line| line.contains("partial") && line.contains(name)), "{rest:?}");
        assert_eq!(place.names(), [name]);
        let mark =
            if name.ends_with("png") { "Comment\0incomplete" } else { "incomplete\0int\0\x04\0\0\0\x01" };
        assert!(holds(&place.path(name), mark), "{name}");
        // It is whole all the same, and not all black.
        let json = place.run(&["compare", "--json", name, name]).succeeded().json();
        assert_eq!([&json["width"], &json["height"]], [2000, 2000]);
    }
}

/// Says so where there is none; with REQUIRE_GPU=1 that is a failure.
#[test]
fn ctrl_c_stops_a_gpu() {
    let place = Place::new();
    let devices = place.run(&["devices"]).succeeded().stdout;
    if !devices.contains("cuda:0") {
        assert!(std::env::var_os("REQUIRE_GPU").is_none_or(|v| v != "1"), "{devices}");
        return eprintln!("SKIPPED ctrl_c_stops_a_gpu: there is no GPU");
    }
    // Minutes for a GPU, too.
    let (rest, code) = interrupted(&place, &["--backend", "cuda", "--samples", "8192"]);
    assert_eq!(code, Some(130), "{rest:?}");
    assert!(rest.last().is_some_and(|line| line.contains("partial")), "{rest:?}");
    assert_eq!(place.names(), ["a.png"]);
}

#[test]
fn the_second_ctrl_c_removes_what_is_half_written() {
    let place = Place::new();
    // The first bands are done in no time; then a whole band is one tile, whose end the first Ctrl-C has to wait for.
    let slow = ["--band-rows", "2", "--tile", "4096", "--samples", "2000", "--threads", "1"];
    let arguments = [&LONG[..], &slow].concat();
    let mut child = place.command(&arguments).stderr(Stdio::piped()).spawn().unwrap();
    let start = Instant::now();
    // A temporary file, and nothing else.
    while place.names().is_empty() {
        assert!(start.elapsed() < Duration::from_secs(60), "no band was written");
        std::thread::sleep(Duration::from_millis(5));
    }
    assert!(place.names()[0].ends_with(".part"), "{:?}", place.names());
    let mut lines = BufReader::new(child.stderr.take().unwrap()).lines().map(Result::unwrap);
    interrupt(&child);
    assert!(lines.any(|line| line.contains("Ctrl-C again")));
    interrupt(&child);
    assert_eq!(child.wait().unwrap().code(), Some(130));
    assert!(place.names().is_empty(), "{:?}", place.names());
}

#[test]
fn the_second_ctrl_c_ends_at_once() {
    let place = Place::new();
    // One tile of many samples: the first Ctrl-C has to wait for its end.
    let slow = ["--samples", "65536", "--tile", "4096", "-v"];
    let arguments = [&["render", "builtin:cornell", "-o", "a.png", "--size", "512x512"], &slow[..]].concat();
    let mut child = place.command(&arguments).stderr(Stdio::piped()).spawn().unwrap();
    let mut lines = BufReader::new(child.stderr.take().unwrap()).lines().map(Result::unwrap);
    assert!(lines.any(|line| line.starts_with("rendering")), "it never started");
    interrupt(&child);
    assert!(lines.any(|line| line.contains("Ctrl-C again")));
    interrupt(&child);
    let start = Instant::now();
    assert_eq!(child.wait().unwrap().code(), Some(130));
    assert!(start.elapsed() < Duration::from_secs(5));
    assert!(fs::read_dir(place.path("")).unwrap().next().is_none());
}
