//! `eosphor schema`, and how a wrong scene is shown.

use crate::place::Place;
use std::fs;

#[test]
fn the_schema_and_the_reference_go_to_stdout() {
    let place = Place::new();
    let schema = place.run(&["schema"]).succeeded().json();
    assert_eq!(schema["$schema"], "https://json-schema.org/draft/2020-12/schema");
    let page = place.run(&["schema", "--markdown"]).succeeded().stdout;
    assert!(page.starts_with("# ") && page.contains("## Camera"), "{page}");
    place.run(&["schema", "x"]).is_wrong_usage(&["unexpected argument"]);
}

#[test]
fn the_line_of_a_wrong_scene_is_shown() {
    let place = Place::new();
    fs::write(place.path("s.json"), "{\n  \"eosphor\": 2,\n\t\"settings\": { \"dept\": 3 }\n}\n").unwrap();
    for command in [&["info", "s.json"][..], &["render", "s.json", "-o", "a.png"]] {
        let run = place.run(command);
        let expected = "eosphor: s.json:3:16: unknown key \"dept\"; did you mean \"depth\"?\n \
                        3 |  \"settings\": { \"dept\": 3 }\n   |                ^\n";
        assert_eq!((run.code, run.stderr.as_str()), (Some(1), expected));
    }
}
