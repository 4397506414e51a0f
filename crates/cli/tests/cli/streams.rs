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

/// Minutes of work, of which the first lines are done in no time.
const LONG: [&str; 9] =
    ["render", "builtin:cornell", "-o", "a.png", "--size", "2000x2000", "--samples", "64", "-v"];

fn interrupt(child: &std::process::Child) {
    // SAFETY: kill only sends a signal; the child has not been waited for, so its number is its own.
    assert_eq!(unsafe { libc::kill(child.id() as i32, libc::SIGINT) }, 0);
}

#[test]
fn ctrl_c_keeps_the_partial_picture() {
    let place = Place::new();
    let mut child = place.command(&LONG).stderr(Stdio::piped()).spawn().unwrap();
    let mut lines = BufReader::new(child.stderr.take().unwrap()).lines().map(Result::unwrap);
    assert!(lines.any(|line| line.starts_with("rendering")), "it never started");
    std::thread::sleep(Duration::from_millis(1500));
    interrupt(&child);
    let rest: Vec<String> = lines.collect();
    assert_eq!(child.wait().unwrap().code(), Some(130), "{rest:?}");
    assert!(rest.last().is_some_and(|line| line.contains("partial") && line.contains("a.png")), "{rest:?}");
    assert_eq!(place.names(), ["a.png"]);
    assert!(holds(&place.path("a.png"), "Comment\0incomplete"));
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
