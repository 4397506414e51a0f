//! Stills that end early, and go on.

use crate::place::{Place, Run};
use std::fs;
use std::io::{BufRead, BufReader};
use std::process::Stdio;
use std::time::{Duration, Instant};

const COMMON: [&str; 8] =
    ["render", "builtin:cornell", "--size", "96x64", "--light-samples", "1", "--backend", "cpu"];

/// The flags, with the output where they name none.
fn with_output<'a>(more: &[&'a str]) -> Vec<&'a str> {
    let output: &[&str] = if more.contains(&"-o") { &[] } else { &["-o", "a.png"] };
    [&COMMON[..], output, more].concat()
}

fn run(place: &Place, more: &[&str]) -> Run {
    place.run(&with_output(more))
}

/// Starts a render and ends it by a signal, when `wait` says so; with so many samples that it does not come to its own end
/// first. How many these are.
fn ended_by(place: &Place, signal: i32, more: &[&str], wait: &dyn Fn() -> bool) -> String {
    for samples in [100, 800, 6400, 51_200] {
        let samples = samples.to_string();
        let arguments = with_output(&[&["-v", "--samples", &samples], more].concat());
        let mut child = place.command(&arguments).stderr(Stdio::piped()).spawn().unwrap();
        let mut lines = BufReader::new(child.stderr.take().unwrap()).lines().map(Result::unwrap);
        assert!(lines.any(|line| line.starts_with("rendering")), "it never started");
        while child.try_wait().unwrap().is_none() && !wait() {
            std::thread::sleep(Duration::from_millis(5));
        }
        if child.try_wait().unwrap().is_none() {
            // SAFETY: kill only sends a signal; the child has not been waited for, so its number is its own.
            assert_eq!(unsafe { libc::kill(child.id() as i32, signal) }, 0);
        }
        lines.for_each(drop);
        let code = child.wait().unwrap().code();
        if code != Some(0) {
            assert_eq!(code, (signal != libc::SIGKILL).then_some(128 + signal));
            return samples;
        }
        place.names().iter().for_each(|name| fs::remove_file(place.path(name)).unwrap());
    }
    panic!("it comes to its end before it can be ended");
}

/// Time for the first strips.
fn later() -> bool {
    std::thread::sleep(Duration::from_millis(300));
    true
}

/// What an undisturbed render writes.
fn undisturbed(flags: &[&str], name: &str) -> Vec<u8> {
    let place = Place::new();
    run(&place, &[&["-q"], flags].concat()).succeeded();
    assert_eq!(place.names(), [name]);
    fs::read(place.path(name)).unwrap()
}

/// The share of the samples that a run found done.
fn resumed(run: Run) -> f64 {
    run.succeeded().json()["resumed"].as_f64().unwrap()
}

#[test]
fn a_signal_loses_nothing() {
    let place = Place::new();
    let samples = ended_by(&place, libc::SIGTERM, &[], &later);
    assert_eq!(place.names(), ["a.partial.png", "a.png.part"]);
    let flags = ["--samples", &samples, "--resume", "--json", "--threads", "1"];
    let goes_on = run(&place, &flags);
    assert!(goes_on.stderr.contains("% of the samples are done already"), "{}", goes_on.stderr);
    assert!(resumed(goes_on) > 0.0);
    assert_eq!(place.names(), ["a.png"], "nothing else is left");
    let whole = undisturbed(&["--samples", &samples, "--json", "--threads", "1"], "a.png");
    // The flag -q is in the command line of the one.
    let pixels = |bytes: &[u8]| eosphor::Picture::from_bytes(bytes, eosphor::Format::Png).unwrap();
    assert!(pixels(&fs::read(place.path("a.png")).unwrap()) == pixels(&whole));
}

/// Layers, several strips, and killed more than once.
#[test]
fn a_killed_program_has_kept_what_was_done_until_then() {
    let place = Place::new();
    let flags = ["-o", "b.exr", "--layers", "all", "--band-rows", "16", "--no-metadata"];
    let every = [&flags[..], &["--checkpoint-every", "1"]].concat();
    let kept = place.path("b.exr.part");
    let length = || fs::metadata(&kept).map_or(0, |data| data.len());
    let samples = ended_by(&place, libc::SIGKILL, &every, &|| length() > 0);
    let flags = [&flags[..], &["--samples", &samples]].concat();
    let share = resumed(run(&place, &[&flags[..], &["--resume", "--json"]].concat()));
    // (All of them where it was killed while it wrote the picture.)
    assert!((0.0..=1.0).contains(&share), "{share}");
    assert!(fs::read(place.path("b.exr")).unwrap() == undisturbed(&flags, "b.exr"), "byte for byte");
    // (A killed program leaves its temporary file; nobody else may take it away.)
    assert!(place.names().iter().all(|name| name == "b.exr" || name.starts_with(".eosphor-")));
}

/// What is kept lies beside the first file, and each has its partial picture.
#[test]
fn several_files_go_on_together() {
    let place = Place::new();
    let outputs = ["-o", "b.exr", "-o", "a.png", "--no-metadata"];
    let samples = ended_by(&place, libc::SIGTERM, &outputs, &later);
    assert_eq!(place.names(), ["a.partial.png", "b.exr.part", "b.partial.exr"]);
    let flags = [&outputs[..], &["--samples", &samples]].concat();
    assert!(resumed(run(&place, &[&flags[..], &["--resume", "--json"]].concat())) > 0.0);
    assert_eq!(place.names(), ["a.png", "b.exr"], "nothing else is left");
    let alone = |name| undisturbed(&["-o", name, "--no-metadata", "--samples", &samples], name);
    for name in ["a.png", "b.exr"] {
        assert!(fs::read(place.path(name)).unwrap() == alone(name), "{name}: byte for byte");
    }
}

#[test]
fn more_samples_go_on_from_fewer() {
    let place = Place::new();
    let samples = ended_by(&place, libc::SIGINT, &[], &later);
    let more = (samples.parse::<u32>().unwrap() + 50).to_string();
    let flags = ["--samples", &more, "--no-metadata"];
    assert!(resumed(run(&place, &[&flags[..], &["--resume", "--json"]].concat())) > 0.0);
    assert!(fs::read(place.path("a.png")).unwrap() == undisturbed(&flags, "a.png"), "byte for byte");
}

/// A part of the picture is gone on with as that part.
#[test]
fn parts_of_pictures_go_on_too() {
    let place = Place::new();
    let region = ["--region", "11,7,60x50", "--no-metadata"];
    let samples = ended_by(&place, libc::SIGTERM, &region, &later);
    let flags = ["--samples", &samples, "--no-metadata"];
    let other = [&flags[..], &["--region", "12,7,60x50", "--resume"]].concat();
    run(&place, &other).failed_with(&["cannot resume: a.png.part", "another part of the picture"]);
    run(&place, &[&flags[..], &["--resume"]].concat()).failed_with(&["cannot resume", "60 x 50 pixels"]);
    let flags = [&region[..], &["--samples", &samples]].concat();
    assert!(resumed(run(&place, &[&flags[..], &["--resume", "--json"]].concat())) > 0.0);
    assert_eq!(place.names(), ["a.png"], "nothing else is left");
    assert!(fs::read(place.path("a.png")).unwrap() == undisturbed(&flags, "a.png"), "byte for byte");
}

/// A share of the rows is gone on with as that share, with its layers.
#[test]
fn shares_of_rows_go_on_too() {
    let place = Place::new();
    let share = ["-o", "b.exr", "--layers", "all", "--tiles", "2/3", "--no-metadata"];
    let kept = place.path("b.exr.2-of-3.share.part");
    let often = [&share[..], &["--checkpoint-every", "1"]].concat();
    let samples = ended_by(&place, libc::SIGTERM, &often, &|| kept.exists());
    assert_eq!(place.names(), ["b.exr.2-of-3.share.part"]);
    let flags = [&share[..], &["--samples", &samples]].concat();
    let stale = [&flags[..], &["--seed", "7", "--resume"]].concat();
    run(&place, &stale).failed_with(&["cannot resume: b.exr.2-of-3.share.part", "another scene"]);
    let goes_on = run(&place, &[&flags[..], &["--resume"]].concat()).succeeded();
    assert!(goes_on.stderr.contains("% of the samples are done already"), "{}", goes_on.stderr);
    assert_eq!(place.names(), ["b.exr.2-of-3.share"], "nothing else is left");
    let name = "b.exr.2-of-3.share";
    assert!(fs::read(place.path(name)).unwrap() == undisturbed(&flags, name), "byte for byte");
}

#[test]
fn what_cannot_be_gone_on_with_is_said() {
    let place = Place::new();
    let samples = ended_by(&place, libc::SIGINT, &[], &later);
    let names = place.names();
    for (flags, reason) in [
        (&["--seed", "7"][..], "another scene, or with other settings"),
        (&["--size", "97x64"], "96 x 64 pixels"),
        (&["--samples", "1"], "another scene, or with other settings"),
    ] {
        let flags = [&["--samples", &samples], flags, &["--resume"]].concat();
        run(&place, &flags).failed_with(&["cannot resume: a.png.part", reason]);
    }
    assert_eq!(place.names(), names, "nothing was touched");
    // Something else in its place, and nothing.
    fs::write(place.path("a.png.part"), [7; 1000]).unwrap();
    run(&place, &["--resume"]).failed_with(&["a.png.part", "delete it"]);
    fs::remove_file(place.path("a.png.part")).unwrap();
    let anew = run(&place, &["--samples", "1", "--resume"]).succeeded();
    assert!(anew.stderr.contains("rendered from its beginning"), "{}", anew.stderr);
}

/// A render of the same picture is left alone, whatever the other one wants.
#[test]
fn two_renders_of_one_picture_do_not_disturb_each_other() {
    let place = Place::new();
    let arguments = with_output(&["--samples", "60000", "--checkpoint-every", "1", "-q"]);
    let mut first = place.command(&arguments).spawn().unwrap();
    let start = Instant::now();
    while !fs::metadata(place.path("a.png.part")).is_ok_and(|data| data.len() > 1000) {
        assert!(start.elapsed() < Duration::from_secs(60), "nothing was kept");
        std::thread::sleep(Duration::from_millis(5));
    }
    let owner = format!("process {}", first.id());
    for more in [&[][..], &["--resume"]] {
        let more = [&["--samples", "60000"], more].concat();
        run(&place, &more).failed_with(&["a.png.part", &owner, "is rendering this picture"]);
    }
    first.kill().unwrap();
    first.wait().unwrap();
}
