//! The memory of textures.

use crate::place::Place;
use std::fs;

const SCENE: &str = r#"{ "eosphor": 2,
"materials": { "m": { "matte": { "color": [1, 1, 1] }, "texture": "wood.ppm" } },
"spheres": [{ "center": [0, 0, 0], "radius": 1, "material": "m" }] }
"#;

#[test]
fn the_budget_holds_in_every_command_that_loads_a_scene() {
    let place = Place::new();
    fs::write(place.path("s.json"), SCENE).unwrap();
    fs::write(place.path("wood.ppm"), [&b"P5 64 32 255\n"[..], &[200; 2048]].concat()).unwrap();
    let commands: [&[&str]; 4] = [
        &["render", "s.json", "-o", "a.png", "--size", "8x8"],
        &["info", "s.json"],
        &["bench", "render", "s.json", "--size", "8x8", "--repeats", "1"],
        &["bench", "rays", "s.json", "--size", "8x8", "--repeats", "1"],
    ];
    for command in commands {
        place.run(&[command, &["--texture-memory", "1K"]].concat()).failed_with(&[
            "wood.ppm: all textures together need 2.0 KiB (2048 bytes) of memory, their budget is 1.0 KiB",
            "--texture-memory",
        ]);
        assert!(!place.path("a.png").exists());
        place.run(&[command, &["--texture-memory", "1.5G"]].concat()).is_wrong_usage(&["whole number"]);
    }
    for command in commands {
        place.run(&[command, &["--texture-memory", "2048"]].concat()).succeeded();
        place.run(command).succeeded();
    }
}
