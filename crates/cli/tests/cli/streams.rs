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
const LONG: [&str; 9] =
    ["render", "builtin:cornell", "--size", "2000x2000", "--samples", "64", "-v", "--backend", "cpu"];

/// [`LONG`] with more flags; into a.png where they name no output.
fn long<'a>(more: &[&'a str]) -> Vec<&'a str> {
    let output: &[&str] = if more.contains(&"-o") { &[] } else { &["-o", "a.png"] };
    [&LONG[..], output, more].concat()
}

fn send(child: &std::process::Child, signal: i32) {
    // SAFETY: kill only sends a signal; the child has not been waited for, so its number is its own.
    assert_eq!(unsafe { libc::kill(child.id() as i32, signal) }, 0);
}

fn interrupt(child: &std::process::Child) {
    send(child, libc::SIGINT);
}

/// Interrupts [`LONG`] with more flags after some time; what it said after that, and its exit code.
fn interrupted(place: &Place, more: &[&str]) -> (Vec<String>, Option<i32>) {
    ended_by(place, &[libc::SIGINT], more)
}

/// The same by other signals.
fn ended_by(place: &Place, signals: &[i32], more: &[&str]) -> (Vec<String>, Option<i32>) {
    let mut child = place.command(&long(more)).stderr(Stdio::piped()).spawn().unwrap();
    let mut lines = BufReader::new(child.stderr.take().unwrap()).lines().map(Result::unwrap);
    assert!(lines.any(|line| line.starts_with("rendering")), "it never started");
    std::thread::sleep(Duration::from_millis(1500));
    signals.iter().for_each(|&signal| send(&child, signal));
    let rest: Vec<String> = lines.collect();
    (rest, child.wait().unwrap().code())
}

#[test]
fn ctrl_c_keeps_the_partial_picture() {
    for (output, name, more) in [
        ("a.png", "a.partial.png", &[][..]),
        ("b.png", "b.partial.png", &["--band-rows", "4"]),
        ("c.exr", "c.partial.exr", &["--layers", "all", "--band-rows", "4"]),
    ] {
        let place = Place::new();
        let (rest, code) = interrupted(&place, &[&["-o", output], more].concat());
        assert_eq!(code, Some(130), "{rest:?}");
        assert!(rest.last().is_some_and(|line| line.contains("partial") && line.contains(name)), "{rest:?}");
        let mut left = [name.to_owned(), format!("{output}.part")];
        left.sort();
        assert_eq!(place.names(), left);
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
    assert_eq!(place.names(), ["a.partial.png", "a.png.part"]);
}

#[test]
fn a_finished_picture_outlives_an_interrupted_render() {
    let place = Place::new();
    let small = ["render", "builtin:cornell", "-o", "a.png", "--size", "8x8", "--samples", "1", "-q"];
    place.run(&small).succeeded();
    let finished = fs::read(place.path("a.png")).unwrap();
    let (rest, code) = interrupted(&place, &[]);
    assert_eq!(code, Some(130), "{rest:?}");
    assert_eq!(fs::read(place.path("a.png")).unwrap(), finished);
    assert_eq!(place.names(), ["a.partial.png", "a.png", "a.png.part"]);
}

/// What Slurm, systemd, docker and `timeout` send, and what a terminal sends that is closed: more than once, often.
#[test]
fn other_signals_keep_what_is_done_too() {
    for (signals, code, word) in [
        (&[libc::SIGTERM, libc::SIGTERM][..], 143, "SIGTERM"),
        (&[libc::SIGHUP, libc::SIGHUP, libc::SIGTERM], 129, "SIGHUP"),
    ] {
        let place = Place::new();
        let (rest, ended) = ended_by(&place, signals, &[]);
        assert!(rest.iter().any(|line| line.contains("keeping what is done")), "{rest:?}");
        // Of several that come at once, the system does not say which was first.
        let one_of = [Some(code), Some(143)];
        assert!(one_of.contains(&ended) && rest.iter().any(|l| l.contains(word) || l.contains("SIGTERM")));
        assert_eq!(place.names(), ["a.partial.png", "a.png.part"]);
    }
}

/// Whoever starts a program with `nohup` wants it to go on.
#[test]
fn nohup_is_obeyed() {
    use std::os::unix::process::CommandExt;
    let place = Place::new();
    let arguments =
        ["render", "builtin:cornell", "-o", "a.png", "--size", "400x400", "--samples", "16", "-v"];
    let mut command = place.command(&arguments);
    // SAFETY: ignoring a signal runs no code.
    unsafe {
        command.pre_exec(|| {
            libc::signal(libc::SIGHUP, libc::SIG_IGN);
            Ok(())
        })
    };
    let mut child = command.stderr(Stdio::piped()).spawn().unwrap();
    let mut lines = BufReader::new(child.stderr.take().unwrap()).lines().map(Result::unwrap);
    assert!(lines.any(|line| line.starts_with("rendering")), "it never started");
    send(&child, libc::SIGHUP);
    lines.for_each(drop);
    assert_eq!(child.wait().unwrap().code(), Some(0));
    assert_eq!(place.names(), ["a.png"]);
}

#[test]
fn the_second_ctrl_c_removes_what_is_half_written() {
    let place = Place::new();
    // The first strips are done in no time; then the first Ctrl-C has to wait for the end of a piece, mostly.
    let slow = ["--band-rows", "2", "--tile", "4096", "--samples", "64", "--threads", "1"];
    let arguments = long(&slow);
    let mut child = place.command(&arguments).stderr(Stdio::piped()).spawn().unwrap();
    let mut lines = BufReader::new(child.stderr.take().unwrap()).lines().map(Result::unwrap);
    // Before, it tries whether it can write there, and does not watch for signals yet.
    assert!(lines.any(|line| line.starts_with("rendering")), "it never started");
    let start = Instant::now();
    // A temporary file, and nothing else. (A folder that is read while files change may seem to have none.)
    let names = loop {
        let names = place.names();
        if !names.is_empty() {
            break names;
        }
        assert!(start.elapsed() < Duration::from_secs(60), "no band was written");
        std::thread::sleep(Duration::from_millis(5));
    };
    assert!(names[0].ends_with(".part"), "{names:?}");
    interrupt(&child);
    // It may have come to its end before it said that it would.
    let _said = lines.any(|line| line.contains("Ctrl-C again"));
    interrupt(&child);
    assert_eq!(child.wait().unwrap().code(), Some(130));
    nothing_is_half_written(&place);
}

/// It may have come to its end after the first signal.
fn nothing_is_half_written(place: &Place) {
    let names = place.names();
    assert!(names.iter().all(|name| ["a.partial.png", "a.png.part"].contains(&&**name)), "{names:?}");
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
    nothing_is_half_written(&place);
}

/// What a run of the program leads into a pipe, and what it says.
fn piped(place: &Place, flags: &[&str]) -> std::process::Output {
    let tiny =
        ["render", "builtin:cornell", "-o", "-", "--size", "16x12", "--samples", "1", "--light-samples", "1"];
    place.command(&[&tiny[..], flags].concat()).output().unwrap()
}

#[test]
fn standard_output_gets_the_bytes_of_the_file() {
    let place = Place::new();
    for format in ["png", "ppm", "jpg", "hdr", "exr", "data"] {
        let name = format!("a.{format}");
        let layers: &[&str] = if format == "exr" { &["--layers", "depth"] } else { &[] };
        place.render(&name, &[&["--no-metadata"], layers].concat()).succeeded();
        let output = piped(&place, &[&["--no-metadata", "--format", format], layers].concat());
        assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
        assert!(output.stdout == std::fs::read(place.path(&name)).unwrap(), "{format}");
        assert!(String::from_utf8_lossy(&output.stderr).contains("standard output: 16 x 12"));
        std::fs::remove_file(place.path(&name)).unwrap();
    }
    assert!(piped(&place, &[]).stdout.starts_with(b"\x89PNG"), "where nothing is said");
    assert!(piped(&place, &["--show", "cost", "--format", "ppm"]).stdout.starts_with(b"P6\n"));
    assert!(place.names().is_empty(), "no file beside it");
}

#[test]
fn what_standard_output_cannot_take_is_wrong_usage() {
    let place = Place::new();
    for (flags, words) in [
        (&["--resume"][..], ["--resume", "not -o -"]),
        (&["--checkpoint-every", "5"], ["--checkpoint-every", "not -o -"]),
        (&["--tiles", "1/2"], ["--tiles", "not -o -"]),
        (&["--sample-range", "0..1"], ["--sample-range", "not -o -"]),
        (&["--json"], ["--json", "not -o -"]),
        (&["--frames", "0..1"], ["-: ", "frame_%04d.png"]),
        (&["--layers", "depth"], ["--layers", ".exr"]),
        (&["--format", "mp4"], ["--format", "[possible values"]),
    ] {
        let output = piped(&place, flags);
        assert!(output.stdout.is_empty());
        crate::place::Run::from(output).is_wrong_usage(&words);
    }
    place.render("a.png", &["--format", "png"]).is_wrong_usage(&["--format", "-o -"]);
    place.render("a.mp4", &["--format", "png"]).is_wrong_usage(&["--format", "-o -"]);
    place.render("a.mp4", &["--exr-half"]).is_wrong_usage(&["--exr-half", ".exr"]);
}

#[test]
fn a_picture_for_nobody_is_one_line() {
    let place = Place::new();
    let flags = ["render", "builtin:cornell", "-q", "-o", "-", "--size", "16x12", "--samples", "1"];
    let mut child = place.command(&flags).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    drop(child.stdout.take());
    crate::place::Run::from(child.wait_with_output().unwrap())
        .failed_with(&["cannot write the picture: standard output: ", "closed the pipe"]);
    let full = std::fs::OpenOptions::new().write(true).open("/dev/full").unwrap();
    let child = place.command(&flags).stdout(full).stderr(Stdio::piped()).spawn().unwrap();
    crate::place::Run::from(child.wait_with_output().unwrap())
        .failed_with(&["standard output: no space left"]);
}

#[test]
fn after_a_signal_nothing_is_led_into_a_pipe() {
    let place = Place::new();
    let flags = ["render", "builtin:cornell", "-v", "-o", "-", "--size", "320x256", "--samples", "60000"];
    let mut child = place.command(&flags).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    let mut lines = BufReader::new(child.stderr.take().unwrap()).lines().map(Result::unwrap);
    assert!(lines.any(|line| line.starts_with("rendering")), "it never started");
    interrupt(&child);
    let last = lines.last().unwrap();
    assert!(last.starts_with("eosphor: interrupted: standard output"), "{last}");
    let output = child.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(130));
    assert!(output.stdout.is_empty() && place.names().is_empty());
}
