//! Inputs are never overwritten, and neither devices nor pipes are read.

use crate::place::{Place, Run};
use std::fs;
use std::os::unix::fs::symlink;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

const SCENE: &str = r#"{ "eosphor": 2,
"materials": { "m": { "matte": { "color": [1, 1, 1] }, "texture": "wood.png" } },
"spheres": [{ "center": [0, 0, 0], "radius": 1, "material": "m" }] }
"#;

/// A place with `s.json` and its texture, and the bytes of that.
fn with_scene() -> (Place, Vec<u8>) {
    let place = Place::new();
    place.render("wood.png", &[]).succeeded();
    fs::write(place.path("s.json"), SCENE).unwrap();
    let texture = fs::read(place.path("wood.png")).unwrap();
    (place, texture)
}

/// Runs the program and panics where it does not end soon.
fn ends(place: &Place, arguments: &[&str]) -> Run {
    let mut command = place.command(arguments);
    let mut child =
        command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    let start = Instant::now();
    while child.try_wait().unwrap().is_none() {
        if start.elapsed() > Duration::from_secs(30) {
            child.kill().unwrap();
            child.wait().unwrap();
            panic!("{arguments:?} does not end");
        }
        std::thread::sleep(Duration::from_millis(5));
    }
    child.wait_with_output().unwrap().into()
}

fn fifo(place: &Place, name: &str) {
    assert!(Command::new("mkfifo").arg(place.path(name)).status().unwrap().success());
}

#[test]
fn the_picture_never_replaces_the_scene_or_its_texture() {
    let (place, texture) = with_scene();
    symlink("s.json", place.path("soft.png")).unwrap();
    fs::hard_link(place.path("s.json"), place.path("hard.png")).unwrap();
    symlink("wood.png", place.path("way.png")).unwrap();
    let names = place.names();
    for (output, input) in [
        ("soft.png", "s.json"),
        ("hard.png", "s.json"),
        ("wood.png", "wood.png"),
        ("./wood.png", "wood.png"),
        ("way.png", "wood.png"),
    ] {
        let run = place.run(&["render", "s.json", "-o", output, "--size", "8x8"]);
        run.failed_with(&["cannot write the picture", output, input, "choose another name"]);
        assert_eq!(fs::read(place.path("s.json")).unwrap(), SCENE.as_bytes(), "{output}");
        assert_eq!(fs::read(place.path("wood.png")).unwrap(), texture, "{output}");
        assert_eq!(place.names(), names, "{output}");
    }
    place.run(&["render", "s.json", "-o", "new.png", "--size", "8x8"]).succeeded();
}

#[test]
fn the_difference_never_replaces_what_is_compared() {
    let place = Place::new();
    place.render("a.png", &[]).succeeded();
    place.render("b.png", &["--exposure", "1"]).succeeded();
    symlink("b.png", place.path("soft.png")).unwrap();
    fs::hard_link(place.path("a.png"), place.path("hard.png")).unwrap();
    let bytes = ["a.png", "b.png"].map(|name| fs::read(place.path(name)).unwrap());
    for output in ["a.png", "b.png", "./a.png", "soft.png", "hard.png"] {
        let run = place.run(&["compare", "a.png", "b.png", "--diff", output]);
        run.failed_with(&["cannot write the difference", output, "choose another name"]);
        assert_eq!(["a.png", "b.png"].map(|name| fs::read(place.path(name)).unwrap()), bytes, "{output}");
    }
}

#[test]
fn devices_and_pipes_are_no_scenes() {
    let place = Place::new();
    for (kind, extension) in [("pipe", "obj"), ("pipe", "json"), ("zero", "obj"), ("zero", "json")] {
        let name = &format!("{kind}.{extension}");
        if kind == "pipe" {
            fifo(&place, name)
        } else {
            symlink("/dev/zero", place.path(name)).unwrap()
        }
        ends(&place, &["render", name, "-o", "a.png"]).failed_with(&[name, "not a file"]);
        ends(&place, &["info", name]).failed_with(&[name, "not a file"]);
    }
}

#[test]
fn devices_and_pipes_are_no_textures() {
    for pipe in [true, false] {
        let (place, _) = with_scene();
        fs::remove_file(place.path("wood.png")).unwrap();
        if pipe {
            fifo(&place, "wood.png");
        } else {
            symlink("/dev/zero", place.path("wood.png")).unwrap();
        }
        ends(&place, &["render", "s.json", "-o", "a.png", "--size", "8x8"]).failed_with(&[
            "s.json",
            "wood.png",
            "not a file",
        ]);
        // Textures of an OBJ that cannot be read are a warning.
        fs::write(place.path("t.obj"), "mtllib t.mtl\nusemtl m\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
            .unwrap();
        fs::write(place.path("t.mtl"), "newmtl m\nmap_Kd wood.png\n").unwrap();
        let run = ends(&place, &["render", "t.obj", "-o", "b.png", "--size", "8x8"]).succeeded();
        assert!(run.stderr.contains("texture \"wood.png\""), "{}", run.stderr);
    }
}

#[test]
fn devices_and_pipes_are_not_compared() {
    let place = Place::new();
    place.render("a.png", &[]).succeeded();
    fifo(&place, "pipe.png");
    symlink("/dev/zero", place.path("zero.png")).unwrap();
    for name in ["pipe.png", "zero.png"] {
        ends(&place, &["compare", name, "a.png"]).failed_with(&[name, "not a file"]);
        ends(&place, &["compare", "a.png", name]).failed_with(&[name, "not a file"]);
    }
}
