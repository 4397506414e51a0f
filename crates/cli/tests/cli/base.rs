//! Scenes that begin with another file.

use crate::place::Place;
use std::fs;

#[test]
fn what_a_file_says_over_its_base_is_what_flags_say() {
    let place = Place::new();
    let over = r#"{"eosphor": 2, "base": "builtin:glass",
        "camera": {"position": [3, 2.1, 5], "look-at": [0, 0.6, 0], "fov-x-degrees": 35},
        "lights": [{"directional": {"direction": [-1, -2, -1], "color": [1.5, 1.5, 1.5]}}],
        "settings": {"size": [16, 12], "samples": 2, "light-samples": 3, "depth": 4, "exposure": 0.3, "seed": 7}}"#;
    fs::write(place.path("over.json"), over).unwrap();
    // A base of a base that says something else.
    fs::create_dir(place.path("in")).unwrap();
    let twice =
        r#"{"eosphor": 2, "base": "../over.json", "settings": {"samples": 1}, "output": "twice.png"}"#;
    fs::write(place.path("in/twice.json"), twice).unwrap();
    let flags: Vec<&str> = "--eye 3,2.1,5 --look-at 0,0.6,0 --fov 35 --sun=-1,-2,-1,1.5 --size 16x12 --light-samples 3 --depth 4 \
        --exposure 0.3 --seed 7 --samples"
        .split_whitespace()
        .collect();
    let render = |scene: &[&str]| {
        let fixed = ["render", "-q", "--no-metadata", "--backend", "cpu"];
        place.run(&[&fixed[..], scene].concat()).succeeded();
    };
    let bytes = |name: &str| fs::read(place.path(name)).unwrap();
    render(&[&["builtin:glass", "-o", "flags.png"], &flags[..], &["2"]].concat());
    render(&["over.json", "-o", "over.png"]);
    assert!(bytes("flags.png") == bytes("over.png"));
    render(&[&["builtin:glass", "-o", "flags.png"], &flags[..], &["1"]].concat());
    render(&["in/twice.json"]);
    assert!(bytes("flags.png") == bytes("twice.png") && bytes("flags.png") != bytes("over.png"));
}

#[test]
fn what_is_wrong_with_a_base_is_said() {
    let place = Place::new();
    fs::write(place.path("room.obj"), "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n").unwrap();
    for (text, words) in [
        (r#"{"eosphor": 2, "base": "rom.obj"}"#, ["s.json:1:24: base: ", "did you mean room.obj?"]),
        (r#"{"eosphor": 2, "base": "s.json"}"#, ["s.json:1:24: base: ", "leads back to the file itself"]),
        (
            r#"{"eosphor": 2, "base": "room.obj", "spheres": []}"#,
            ["s.json:1:36: ", "put it into the base file"],
        ),
    ] {
        fs::write(place.path("s.json"), text).unwrap();
        place.run(&["render", "s.json", "-o", "a.png"]).failed_with(&words);
    }
}
