//! `eosphor compare`, `devices` and `completions`.

use crate::place::Place;
use std::fs;

fn ppm(place: &Place, name: &str, size: &str, bytes: &[u8]) {
    fs::write(place.path(name), [format!("P6 {size} 255\n").as_bytes(), bytes].concat()).unwrap();
}

#[test]
fn the_verdict_comes_first() {
    let place = Place::new();
    ppm(&place, "a.ppm", "2 2", &[9; 12]);
    ppm(&place, "b.ppm", "2 2", &[9, 9, 9, 9, 9, 9, 9, 9, 9, 9, 10, 9]);
    let same = place.run(&["compare", "a.ppm", "a.ppm"]);
    assert_eq!((same.code, same.stdout.as_str()), (Some(0), "identical\n"));
    let run = place.run(&["compare", "a.ppm", "b.ppm", "--diff", "d.png"]);
    assert_eq!((run.code, run.stderr.as_str()), (Some(1), ""));
    assert_eq!(run.stdout.lines().next(), Some("different: first at (1, 1): 9 9 9 and 9 10 9"));
    assert_eq!(place.names(), ["a.ppm", "b.ppm", "d.png"]);
}

#[test]
fn json_says_the_same() {
    let place = Place::new();
    ppm(&place, "a.ppm", "1 2", &[0; 6]);
    ppm(&place, "b.ppm", "1 2", &[0, 0, 0, 255, 255, 255]);
    let json = place.run(&["compare", "--json", "a.ppm", "b.ppm"]).json();
    assert_eq!(json["identical"], false);
    assert_eq!([&json["first"]["x"], &json["first"]["y"]], [0, 1]);
    assert_eq!(json["differing_pixels"], 1);
    let json = place.run(&["compare", "--json", "a.ppm", "a.ppm"]).succeeded().json();
    assert_eq!(json["identical"], true);
    assert!(json["psnr"].is_null());
}

#[test]
fn what_cannot_be_compared_is_one_line() {
    let place = Place::new();
    ppm(&place, "a.ppm", "2 1", &[0; 6]);
    ppm(&place, "b.ppm", "1 2", &[0; 6]);
    fs::write(place.path("cut.ppm"), "P6 4 4 255\n123").unwrap();
    fs::write(place.path("text.png"), "hello").unwrap();
    fs::write(place.path("empty.exr"), "").unwrap();
    place.run(&["compare", "a.ppm", "b.ppm"]).failed_with(&["a.ppm", "b.ppm", "2 x 1 and 1 x 2"]);
    place.run(&["compare", "a.ppm", "none.png"]).failed_with(&["none.png", "no such file"]);
    place.run(&["compare", "cut.ppm", "a.ppm"]).failed_with(&["cut.ppm", "cut short"]);
    place.run(&["compare", "text.png", "a.ppm"]).failed_with(&["text.png"]);
    place.run(&["compare", "empty.exr", "a.ppm"]).failed_with(&["empty.exr"]);
    place.run(&["compare", "a.ppm", "b.ppm", "--diff", "/proc/no/d.png"]).failed_with(&["/proc/no/d.png"]);
}

#[test]
fn devices_names_the_cpu() {
    let place = Place::new();
    assert!(place.run(&["devices"]).succeeded().stdout.contains("baseline"));
    let json = place.run(&["devices", "--json"]).succeeded().json();
    assert!(json["cpu"]["threads"].as_u64().unwrap() > 0);
    assert_eq!(json["cpu"]["simd"][0], "baseline");
}

#[test]
fn completions_know_the_flags() {
    let place = Place::new();
    for shell in ["bash", "zsh", "fish", "powershell", "elvish"] {
        let run = place.run(&["completions", shell]).succeeded();
        assert!(run.stdout.contains("light-samples"), "{shell}");
    }
    place.run(&["completions", "cmd"]).is_wrong_usage(&["bash"]);
}
