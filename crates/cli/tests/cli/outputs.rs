//! One picture in several files.

use crate::place::Place;
use std::fs;

const TINY: [&str; 8] =
    ["render", "builtin:cornell", "--size", "16x12", "--samples", "2", "--light-samples", "1"];

#[test]
fn each_file_is_what_a_run_of_its_own_writes() {
    let place = Place::new();
    let flags = ["--no-metadata", "--layers", "depth,albedo", "--exr-half", "--jpeg-quality", "40"];
    let names = ["a.png", "a.exr", "a.jpg", "a.ppm", "a.hdr", "a.data"];
    let outputs: Vec<&str> = names.iter().flat_map(|name| ["-o", *name]).collect();
    let run = place.run(&[&TINY[..], &outputs, &flags, &["--json"]].concat()).succeeded();
    assert!(run.stderr.contains("a.png, a.exr, a.jpg, a.ppm, a.hdr, a.data: 16 x 12"), "{}", run.stderr);
    let report = run.json();
    assert_eq!(report["output"], "a.png");
    assert_eq!(report["outputs"].as_array().unwrap().len(), names.len());
    let of = |name: &str| match name {
        "a.exr" => vec!["--layers", "depth,albedo", "--exr-half"],
        "a.jpg" => vec!["--jpeg-quality", "40"],
        _ => vec![],
    };
    for name in names {
        let alone = format!("b{}", &name[1..]);
        place.run(&[&TINY[..], &["-o", &alone, "--no-metadata"], &of(name)].concat()).succeeded();
        let bytes = |name: &str| fs::read(place.path(name)).unwrap();
        assert!(bytes(name) == bytes(&alone), "{name}");
    }
}

#[test]
fn a_file_and_a_pipe_get_the_same() {
    let place = Place::new();
    let flags = ["-o", "-", "-o", "a.png", "--no-metadata"];
    let output = place.command(&[&TINY[..], &flags].concat()).output().unwrap();
    assert_eq!(output.status.code(), Some(0));
    assert!(output.stdout == fs::read(place.path("a.png")).unwrap());
    // Of the pair the file can be gone on with.
    let output = place.command(&[&TINY[..], &flags, &["--resume"]].concat()).output().unwrap();
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
}

#[test]
fn false_colours_go_everywhere_too() {
    let place = Place::new();
    place.run(&[&TINY[..], &["--show", "cost", "-o", "a.png", "-o", "a.ppm"]].concat()).succeeded();
    let compared = place.run(&["compare", "a.png", "a.ppm"]).succeeded();
    assert_eq!(compared.stdout, "identical\n");
}

#[test]
fn what_cannot_be_written_is_found_before_the_first_ray() {
    let place = Place::new();
    fs::create_dir(place.path("folder.png")).unwrap();
    // It would take for ever.
    let run = |outputs: &[&str]| {
        let outputs: Vec<&str> = outputs.iter().flat_map(|name| ["-o", *name]).collect();
        place.run(&[&TINY[..], &["--size", "9000x9000", "--samples", "65536"], &outputs].concat())
    };
    run(&["a.png", "/proc/nowhere/a.exr"]).failed_with(&["/proc/nowhere/a.exr"]);
    run(&["a.png", "folder.png"]).failed_with(&["folder.png", "folder"]);
    run(&["a.png", "a.tiff"]).is_wrong_usage(&["a.tiff", "unknown picture format"]);
    for (outputs, words) in [
        (&["a.png", "./a.png"][..], ["./a.png", "name it once"]),
        (&["-", "-"], ["standard output", "name it once"]),
        (&["a.png", "b%d.png"], ["several outputs", "single pictures"]),
        (&["a.png", "a.mp4"], ["several outputs", "single pictures"]),
    ] {
        run(outputs).is_wrong_usage(&words);
    }
    let share = [&TINY[..], &["-o", "a.png", "-o", "b.png", "--tiles", "1/2"]].concat();
    place.run(&share).is_wrong_usage(&["several outputs"]);
    let format = [&TINY[..], &["-o", "a.png", "-o", "b.ppm", "--layers", "depth"]].concat();
    place.run(&format).is_wrong_usage(&["--layers", ".exr"]);
    assert_eq!(place.names(), ["folder.png"]);
}
