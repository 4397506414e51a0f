//! Exit codes: 2 for wrong usage, 1 for work that failed. Every flag is gone through in `src/arguments/tests.rs`.

use crate::place::Place;
use std::fs;

/// Every command, with what it needs at least.
const COMMANDS: [&[&str]; 11] = [
    &["render", "builtin:cornell", "-o", "a.png"],
    &["course", "--default"],
    &["info", "builtin:cornell"],
    &["compare", "a.png", "b.png"],
    &["merge", "-o", "a.png"],
    &["bench", "rays", "builtin:cornell"],
    &["bench", "render", "builtin:cornell"],
    &["devices"],
    &["schema"],
    &["completions", "bash"],
    &["help", "render"],
];

#[test]
fn unknown_flags_and_arguments_are_wrong_usage() {
    let place = Place::new();
    for command in &COMMANDS[..10] {
        place.run(&[command, &["--nonsense"][..]].concat()).is_wrong_usage(&["--nonsense"]);
        if command[0] != "merge" {
            place.run(&[command, &["too-much"][..]].concat()).is_wrong_usage(&["too-much"]);
        }
    }
    // None is missing above.
    let help = place.run(&["--help"]).succeeded().stdout;
    let (_, commands) = help.split_once("Commands:\n").unwrap();
    for line in commands.lines().take_while(|line| line.starts_with("  ")) {
        let name = line.split_whitespace().next().unwrap();
        assert!(COMMANDS.iter().any(|command| command[0] == name), "{name}");
    }
    for wrong in [
        &["nonsense"][..],
        &[],
        &["bench"],
        &["bench", "nonsense"],
        &["render"],
        &["compare", "a.png"],
        &["merge"],
    ] {
        assert_eq!(place.run(wrong).code, Some(2), "{wrong:?}");
    }
    assert!(place.names().is_empty());
}

/// A dash does not make another flag of a number: the range is said.
#[test]
fn negative_numbers_are_values() {
    let place = Place::new();
    for (flag, range) in [
        ("--samples", "1 to 65536"),
        ("--depth", "0 to 64"),
        ("--size", "1 to 65535"),
        ("--threads", "1 to 1024"),
        ("--checkpoint-every", "1 to 86400"),
        ("--fov", "over 0 and under 180"),
        ("--frames", "0..120"),
        ("--seed", "0 to 4294967295"),
    ] {
        let run = place.run(&["render", "builtin:cornell", "-o", "a.png", flag, "-3x1"]);
        run.is_wrong_usage(&["'-3x1'", flag, range]);
        let run = place.run(&["render", "builtin:cornell", "-o", "a.png", flag, "-3"]);
        run.is_wrong_usage(&["'-3'", flag, if flag == "--size" { "800x600" } else { range }]);
    }
}

#[test]
fn what_is_missing_has_failed() {
    let place = Place::new();
    fs::write(place.path("scene.json"), "{}").unwrap();
    for command in [
        &["render", "scene.jsno", "-o", "a.png"][..],
        &["info", "scene.jsno"],
        &["bench", "rays", "scene.jsno"],
        &["bench", "render", "scene.jsno"],
    ] {
        // The ending is of no kind that is read, but nothing is there to be read either.
        place.run(command).failed_with(&["scene.jsno"]);
    }
    for command in [
        &["render", "scnee.json", "-o", "a.png"][..],
        &["info", "scnee.json"],
        &["bench", "rays", "scnee.json"],
        &["bench", "render", "scnee.json"],
    ] {
        place.run(command).failed_with(&["scnee.json: cannot read", "did you mean scene.json?"]);
    }
    for command in [&["render", "builtin:cornel", "-o", "a.png"][..], &["info", "builtin:cornel"]] {
        place.run(command).failed_with(&["built-in", "cornell"]);
    }
    place.run(&["compare", "a.png", "b.png"]).failed_with(&["a.png", "no such file"]);
    place.run(&["merge", "a.share", "-o", "a.png"]).failed_with(&["a.share", "no such file"]);
    place.run(&["merge", "-o", "a.png"]).failed_with(&["there are no shares of a.png"]);
    assert_eq!(place.names(), ["scene.json"]);
}
