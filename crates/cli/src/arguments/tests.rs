//! All commands and all their flags, from clap's own list of them.

use super::*;
use clap::error::ErrorKind;
use clap::{Arg, CommandFactory};
use eosphor::math::Vec3;
use eosphor::{CourseOptions, CpuOptions, CudaOptions, RenderSettings, SaveOptions};
use std::fmt::Debug;

/// What a value may be that nothing is wrong with before it is looked for.
const FREE: [&str; 13] = [
    "SCENE",
    "OUT",
    "OUT.png",
    "FILE",
    "SHARE",
    "A",
    "B",
    "camera",
    "FOLDER",
    "EXPERIMENT",
    "RUN",
    "FIRST",
    "SECOND",
];

/// Of the values that are words: whatever else a flag takes may begin with a dash.
const WORDS: [&str; 13] = [
    "NAME", "WHAT", "LIST", "DEVICE", "MODEL", "MODE", "UNITS", "ON", "WAY", "CURVE", "WHERE", "LEVEL",
    "A,B,C",
];

/// Every command that does something, with the words that call it.
fn commands() -> Vec<(Vec<String>, clap::Command)> {
    fn add(before: &[String], command: &clap::Command, all: &mut Vec<(Vec<String>, clap::Command)>) {
        let words = [before, &[command.get_name().to_owned()]].concat();
        match command.has_subcommands() {
            true => command.get_subcommands().for_each(|command| add(&words, command, all)),
            false => all.push((words, command.clone())),
        }
    }
    let mut all = Vec::new();
    add(&[], &Arguments::command(), &mut all);
    all
}

/// The flags that take a value, as they are called.
fn flags(command: &clap::Command) -> Vec<(String, Arg)> {
    let flag = |arg: &Arg| Some((format!("--{}", arg.get_long()?), arg.clone()));
    command.get_arguments().filter(|arg| arg.get_action().takes_values()).filter_map(flag).collect()
}

fn help_of(arg: &Arg) -> String {
    arg.get_help().map(ToString::to_string).unwrap_or_default()
}

/// What is said of a flag with a value; nothing where both are right.
fn said(words: &[String], flag: &str, value: &str) -> Option<(ErrorKind, String)> {
    let arguments = words.iter().map(String::as_str).chain([flag, value]);
    let error = Arguments::try_parse_from(arguments).err()?;
    // What else a command needs is asked for later.
    (error.kind() != ErrorKind::MissingRequiredArgument).then(|| (error.kind(), error.to_string()))
}

#[test]
fn the_flags_do_not_contradict_each_other() {
    Arguments::command().debug_assert();
}

#[test]
fn help_lists_no_flag_that_its_command_always_refuses() {
    let long_help = |words: &[&str]| {
        let mut command = Arguments::described();
        let error = command.try_get_matches_from_mut(words).unwrap_err();
        error.to_string()
    };
    for (words, taken) in [
        (["eosphor", "info", "--help"].as_slice(), "--builder"),
        (&["eosphor", "bench", "rays", "--help"], "--gpu-traversal"),
    ] {
        let help = long_help(words);
        assert!(help.contains(taken), "{help}");
        for flag in
            ["--tile", "--scheduler", "--block-size", "--gpu-paths", "--gpu-memory", "--gpu-scheduler"]
        {
            assert!(!help.contains(flag), "{words:?}: {flag}");
        }
    }
    assert!(long_help(&["eosphor", "bench", "render", "--help"]).contains("--tile"));
}

#[test]
fn wrong_values_are_said_with_their_flag() {
    let mut count = 0;
    for (words, command) in commands() {
        for (flag, arg) in flags(&command) {
            let names: Vec<&str> = arg.get_value_names().unwrap().iter().map(|name| name.as_str()).collect();
            if FREE.contains(&names[0]) || FREE.contains(&arg.get_id().as_str()) {
                continue;
            }
            // (Blocks of GPUs are numbers by name.)
            let values = if WORDS.contains(&names[0]) { &["@"][..] } else { &["@", "-3x", "--"] };
            for value in values {
                let said = said(&words, &flag, value).map(|(_, text)| text);
                let text = said.unwrap_or_else(|| panic!("{words:?} {flag} takes {value}"));
                // Of several names for one flag the message has all.
                assert!(text.contains(&flag) && !text.contains("unexpected"), "{words:?} {flag}: {text}");
            }
            count += 1;
        }
    }
    assert!(count > 100, "{count}");
}

/// Help texts name the ranges that messages name, which are those that hold.
#[test]
fn ranges_are_in_the_help() {
    let mut count = 0;
    for (words, command) in commands() {
        for (flag, arg) in flags(&command) {
            let Some((_, text)) = said(&words, &flag, "-1e30") else { continue };
            let numbers = ["it must be a whole number, ", "it must be a number, "];
            let Some((_, range)) = numbers.iter().find_map(|number| text.split_once(number)) else {
                continue;
            };
            let range = range.lines().next().unwrap();
            let help = help_of(&arg);
            // Of leaves the ranges are those of the structures.
            let is_said = help.contains(range) || flag == "--tree-depth" && help.contains("1 to 64");
            assert!(is_said, "{words:?} {flag}: {range}: {help}");
            count += 1;
        }
    }
    assert!(count > 60, "{count}");
}

#[test]
fn what_is_no_flag_is_unknown() {
    for (words, _) in commands() {
        let (kind, text) = said(&words, "--nonsense", "1").unwrap();
        assert!(kind == ErrorKind::UnknownArgument && text.contains("--nonsense"), "{words:?}: {text}");
    }
}

/// A default as a help text says it: names as on the command line.
fn shown(value: impl Debug) -> String {
    let mut text = String::new();
    for letter in format!("{value:?}").chars() {
        if letter.is_uppercase() && !text.is_empty() {
            text.push('-');
        }
        text.extend(letter.to_lowercase());
    }
    text
}

/// The program's defaults are those that the help says.
#[test]
fn defaults_are_in_the_help() {
    let render = commands().into_iter().find(|(words, _)| words[1..] == ["render"]).unwrap().1;
    let RenderSettings {
        size: [width, height],
        samples,
        pixel_sampling,
        integrator,
        roulette,
        clamp_indirect,
        lights,
        light_samples,
        depth,
        energy_threshold,
        lighting,
        shadows,
        fresnel,
        normals,
        crease_degrees,
        cull_back_faces,
        light_from_behind,
        light_units,
        light_falloff,
        headlight,
        ambient,
        max_distance,
        background: Vec3 { x, y, z },
        composition,
        srgb_textures,
        tone_curve,
        transfer,
        exposure,
        seed,
    } = RenderSettings::default();
    assert!(max_distance.is_none() && clamp_indirect.is_none() && lights.is_none());
    let on = |is_on: bool, flags: [&'static str; 2]| (flags[usize::from(!is_on)], "[default]".to_owned());
    let default = |value: &dyn ToString| format!("[default: {}]", value.to_string());
    let expected = [
        ("size", default(&format!("{width}x{height}"))),
        ("samples", format!("[default: {samples}, but 32 for path-traced glTF]")),
        ("pixel-sampling", default(&shown(pixel_sampling))),
        ("integrator", format!("[default: {}, but path for glTF]", shown(integrator))),
        ("roulette", default(&roulette)),
        ("light-samples", default(&light_samples)),
        ("depth", default(&depth)),
        ("energy-threshold", default(&energy_threshold)),
        ("lighting", default(&shown(lighting))),
        ("shadows", default(&shown(shadows))),
        ("fresnel", default(&shown(fresnel))),
        ("normals", default(&shown(normals))),
        ("crease", default(&crease_degrees)),
        on(cull_back_faces, ["cull", "no-cull"]),
        on(light_from_behind, ["light-from-behind", "no-light-from-behind"]),
        ("light-units", default(&shown(light_units))),
        on(light_falloff, ["light-falloff", "no-light-falloff"]),
        ("headlight", default(&if headlight { "on" } else { "off" })),
        ("ambient", default(&ambient)),
        ("background", default(&format!("{x},{y},{z}"))),
        ("composition", default(&shown(composition))),
        on(srgb_textures, ["srgb-textures", "linear-textures"]),
        ("tone-curve", format!("[default: {}, but neutral for path-traced glTF]", shown(tone_curve))),
        ("transfer", default(&shown(transfer))),
        ("exposure", default(&exposure)),
        ("seed", default(&seed)),
        ("block-size", default(&CudaOptions::default().block_size)),
        ("jpeg-quality", default(&SaveOptions::default().jpeg_quality)),
    ];
    for (flag, text) in expected {
        let arg = render.get_arguments().find(|arg| arg.get_long() == Some(flag)).unwrap();
        assert!(help_of(arg).contains(&text), "--{flag}: {text}: {}", help_of(arg));
    }
    let [a, b, c] = CourseOptions::default().shapes.map(|shape| shown(shape.unwrap()));
    let course = commands().into_iter().find(|(words, _)| words[1..] == ["course"]).unwrap().1;
    let bodies = course.get_arguments().find(|arg| arg.get_long() == Some("bodies")).unwrap();
    assert!(help_of(bodies).contains(&format!("[default: {a},{b},{c}]")), "{}", help_of(bodies));
    assert_eq!(CpuOptions::default().accel.name(), "bvh8");
}

#[test]
fn every_flag_is_explained() {
    for (words, command) in commands() {
        for arg in command.get_arguments() {
            assert!(!help_of(arg).is_empty(), "{words:?} {}", arg.get_id());
        }
        if let Some((_, examples)) = command
            .get_after_help()
            .map(ToString::to_string)
            .as_deref()
            .and_then(|help| help.split_once("Examples:\n"))
        {
            assert_eq!(examples.lines().count(), 3, "{words:?}");
        }
    }
}
