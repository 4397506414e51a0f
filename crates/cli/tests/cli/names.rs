//! Names of files that are no Unicode.

use crate::place::{Place, Run};
use std::ffi::{OsStr, OsString};
use std::fs;
use std::os::unix::ffi::OsStrExt;

/// A name with a byte that no UTF-8 has.
fn odd(after: &str) -> OsString {
    let mut name = OsStr::from_bytes(b"\xff").to_owned();
    name.push(after);
    name
}

fn run(place: &Place, words: &[&OsStr]) -> Run {
    place.command(&[]).args(words).output().unwrap().into()
}

#[test]
fn names_need_not_be_unicode() {
    let place = Place::new();
    let at = |name: &OsStr| place.path(".").join(name);
    let scene = r#"{ "eosphor": 2, "settings": { "size": [8, 8] }, "spheres": [{ "center": [0, 0, 0], "radius": 1 }] }"#;
    let [json, png, exr, obj, frames, share] =
        ["s.json", "a.png", "new/a.exr", "m.obj", "%d.png", "a.png.1-of-1.share"].map(odd);
    fs::write(at(&json), scene).unwrap();
    fs::write(at(&obj), "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n").unwrap();
    let [render, info, compare, merge, o] = ["render", "info", "compare", "merge", "-o"].map(OsStr::new);
    let more = |words: &str| words.split(' ').map(OsString::from).collect::<Vec<_>>();
    let with = |words: &[&OsStr], flags: &str| {
        let flags = more(flags);
        run(&place, &words.iter().copied().chain(flags.iter().map(OsString::as_os_str)).collect::<Vec<_>>())
    };
    let report = with(&[render, &json, o, &png, o, &exr], "--json -q").succeeded().json();
    assert_eq!(report["width"], 8);
    assert!(at(&png).is_file() && at(&exr).is_file());
    with(&[render, &obj, o, &png], "--size 8x8 -q").succeeded();
    with(&[render, &obj, o, &png], "--size 8x8 -q --tiles 1/1").succeeded();
    assert!(at(&share).is_file());
    run(&place, &[merge, o, &png]).succeeded();
    assert!(run(&place, &[info, &obj]).succeeded().stdout.contains("triangles        1"));
    assert_eq!(run(&place, &[compare, &png, &png]).succeeded().stdout, "identical\n");
    with(&[render, &json, o, &frames], "--orbit 2 -q").succeeded();
    with(&[render, &json, o, &frames], "--orbit 2 -q --resume").succeeded();
    assert!(at(&odd("1.png")).is_file());
}

#[test]
fn what_is_missing_is_one_line() {
    let place = Place::new();
    let [json, png, gltf] = ["s.json", "a.png", "s.gltf"].map(odd);
    let [render, compare, o] = ["render", "compare", "-o"].map(OsStr::new);
    run(&place, &[render, &json, o, &png]).failed_with(&["\u{fffd}s.json: cannot read", "No such file"]);
    run(&place, &[render, &gltf, o, &png]).failed_with(&["\u{fffd}s.gltf: cannot read"]);
    run(&place, &[compare, &png, &png]).failed_with(&["\u{fffd}a.png", "no such file"]);
    let course = run(&place, &[OsStr::new("course"), OsStr::new("--cpu"), o, &odd("%d.png")]);
    assert!(course.code != Some(0) && !place.path(".").join(odd("0.png")).exists());
}
