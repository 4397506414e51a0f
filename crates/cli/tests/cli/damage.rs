//! Damaged files: one line that says which file, what is wrong with it in plain words, and what to do.

use crate::place::Place;
use std::fs;

/// Words of libraries, which nobody should have to read.
const RAW: [&str; 12] = [
    "Format",
    "decoding",
    "Error",
    "error",
    "inner",
    "::",
    "{",
    "InsufficientInput",
    "Eof",
    "EOF",
    "panicked",
    "buffer",
];

/// Damaged copies of a file: cut, and with bytes turned around.
fn damaged(bytes: &[u8]) -> Vec<Vec<u8>> {
    let cut = [3, 9, 40, bytes.len() / 2, bytes.len() - 20, bytes.len() - 1];
    let mut all: Vec<Vec<u8>> = cut.iter().map(|&end| bytes[..end.min(bytes.len())].to_vec()).collect();
    for at in (8..bytes.len()).step_by(bytes.len() / 12) {
        let mut flipped = bytes.to_vec();
        flipped[at..].iter_mut().take(24).for_each(|byte| *byte = !*byte);
        all.push(flipped);
    }
    all
}

/// The one line on stderr, which speaks of this file.
fn look(said: &str, name: &str, what: usize) {
    let line = said.lines().next().unwrap_or_else(|| panic!("{name}, {what}: nothing is said"));
    assert!(line.starts_with("eosphor: ") && line.contains(name), "{what}: {line}");
    assert!(!RAW.iter().any(|word| line["eosphor: ".len()..].contains(word)), "{what}: {line}");
}

#[test]
fn damaged_pictures_are_not_compared() {
    let place = Place::new();
    for name in ["a.png", "a.jpg", "a.hdr", "a.exr", "a.ppm"] {
        let size = ["--size", "48x40", "--no-metadata"];
        place.render(name, &size).succeeded();
        let bytes = fs::read(place.path(name)).unwrap();
        let broken = &format!("broken.{}", &name[2..]);
        let mut refused = 0;
        for (what, bytes) in damaged(&bytes).iter().enumerate() {
            fs::write(place.path(broken), bytes).unwrap();
            let run = place.run(&["compare", name, broken]);
            // Some damage is a picture of other pixels, or of another size.
            if run.stdout.is_empty() {
                assert_eq!(run.code, Some(1), "{name}, {what}: {}", run.stderr);
                look(&run.stderr, broken, what);
                refused += 1;
            }
        }
        assert!(refused > 3, "{name}: {refused}");
    }
}

#[test]
fn damaged_textures_are_said() {
    let place = Place::new();
    let scene = |name: &str| {
        format!(
            r#"{{ "eosphor": 2, "settings": {{ "size": [4, 4] }},
            "materials": {{ "m": {{ "matte": {{ "color": [1, 1, 1] }}, "texture": "{name}" }} }},
            "spheres": [{{ "center": [0, 0, 0], "radius": 1, "material": "m" }}] }}"#
        )
    };
    for name in ["a.png", "a.jpg", "a.hdr", "a.exr", "a.ppm"] {
        place.render(name, &["--size", "48x40", "--no-metadata"]).succeeded();
        let bytes = fs::read(place.path(name)).unwrap();
        fs::write(place.path("s.json"), scene(name)).unwrap();
        let mut refused = 0;
        for (what, bytes) in damaged(&bytes).iter().enumerate() {
            fs::write(place.path(name), bytes).unwrap();
            let run = place.run(&["info", "s.json"]);
            if run.code != Some(0) {
                assert_eq!(run.code, Some(1), "{name}, {what}: {}", run.stderr);
                look(&run.stderr, name, what);
                refused += 1;
            }
        }
        assert!(refused > 3, "{name}: {refused}");
    }
}

#[test]
fn damaged_scenes_are_said() {
    let place = Place::new();
    for name in ["knot.glb", "glass-and-mirrors.json"] {
        let path = format!("{}/../../scenes/{name}", env!("CARGO_MANIFEST_DIR"));
        let bytes = fs::read(path).unwrap();
        for (what, bytes) in damaged(&bytes).iter().enumerate() {
            fs::write(place.path(name), bytes).unwrap();
            let run = place.run(&["info", name]);
            if run.code != Some(0) {
                assert_eq!(run.code, Some(1), "{name}, {what}: {}", run.stderr);
                look(&run.stderr, name, what);
            }
        }
    }
    for (text, words) in [
        ("{", "the file ends within its JSON; get it again"),
        ("{}", "asset"),
        (r#"{"asset": {"version": "2.0"}, "nodes": 3}"#, "export it again"),
    ] {
        fs::write(place.path("a.gltf"), text).unwrap();
        let run = place.run(&["info", "a.gltf"]);
        run.failed_with(&["a.gltf", words]);
        assert!(!run.stderr.contains('`'), "{}", run.stderr);
    }
}
