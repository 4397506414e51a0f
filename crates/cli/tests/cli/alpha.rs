//! Pictures without their background.

use crate::place::{Place, Run};
use eosphor::Picture;
use std::fs;

/// A matte ball, a ball of glass and a mirror before a background.
const SCENE: &str = r#"{"eosphor": 2, "camera": {"position": [0, 0, 8], "look-at": [0, 0, 0]},
    "lights": [{"point": {"position": [2, 4, 6], "color": [90, 80, 70]}}],
    "materials": {
        "matte": {"matte": {"color": [0.8, 0.3, 0.2]}},
        "glass": {"dielectric": {"ior": 1.5}},
        "mirror": {"mirror": {"reflectance": [1, 1, 1]}}},
    "spheres": [
        {"center": [-1.6, 0, 0], "radius": 0.7, "material": "matte"},
        {"center": [0, 0, 0], "radius": 0.7, "material": "glass"},
        {"center": [1.6, 0, 0], "radius": 0.7, "material": "mirror"}],
    "settings": {"background": [0.2, 0.5, 0.9], "samples": 5}}"#;

fn render(place: &Place, name: &str, more: &[&str]) -> Run {
    let flags = ["render", "s.json", "-o", name, "--size", "60x24", "--no-metadata"];
    place.run(&[&flags[..], more].concat())
}

fn place() -> Place {
    let place = Place::new();
    fs::write(place.path("s.json"), SCENE).unwrap();
    place
}

fn linear(place: &Place, name: &str) -> Vec<[f32; 3]> {
    let Picture::Linear(film) = Picture::read(&place.path(name)).unwrap() else { panic!("EXR is linear") };
    film.pixels.into_iter().map(<[f32; 3]>::from).collect()
}

fn bytes(place: &Place, name: &str) -> Vec<[u8; 4]> {
    let Picture::Bytes(image) = Picture::read(&place.path(name)).unwrap() else { panic!("PNG has bytes") };
    image.rgba
}

/// Over its own background the picture is what it was.
#[test]
fn over_its_background_it_is_the_picture() {
    let place = place();
    render(&place, "whole.exr", &[]).succeeded();
    render(&place, "own.exr", &["--alpha"]).succeeded();
    render(&place, "a.png", &["--alpha", "--transfer", "linear"]).succeeded();
    let (whole, own, image) =
        (linear(&place, "whole.exr"), linear(&place, "own.exr"), bytes(&place, "a.png"));
    let mut edges = 0;
    for ((whole, own), pixel) in whole.iter().zip(&own).zip(&image) {
        let alpha = f32::from(pixel[3]) / 255.0;
        edges += u32::from(pixel[3] % 255 != 0);
        for (k, background) in [0.2f32, 0.5, 0.9].into_iter().enumerate() {
            // Coverage is a number of fifths, which are 51 steps of a byte each.
            assert_eq!(pixel[3] % 51, 0);
            let over = own[k] + background * (1.0 - alpha);
            assert!((over - whole[k]).abs() < 1e-5, "{over} {whole:?}");
            match pixel[3] {
                0 => assert!(own[k] == 0.0 && pixel[k] == 0),
                255 => assert_eq!(own[k], whole[k]),
                _ => {}
            }
            // What is not multiplied.
            let straight = (own[k] / alpha.max(0.01)).clamp(0.0, 1.0);
            assert!((straight * 255.0 - f32::from(pixel[k])).abs() < 0.51, "{straight} {pixel:?}");
        }
    }
    assert!(edges > 20, "{edges}");
    // Glass and mirrors show the background, and cover.
    let middle = |x: usize| image[12 * 60 + x];
    assert_eq!([middle(30)[3], middle(43)[3], middle(17)[3], middle(0)[3]], [255, 255, 255, 0]);
}

#[test]
fn every_way_has_the_same_alpha() {
    let place = place();
    render(&place, "a.png", &["--alpha"]).succeeded();
    render(&place, "a.exr", &["--alpha", "--layers", "all"]).succeeded();
    let same = |a: &str, b: &str| fs::read(place.path(a)).unwrap() == fs::read(place.path(b)).unwrap();
    for more in [
        &["--threads", "1", "--band-rows", "5"][..],
        &["--accel", "kdtree"],
        &["--accel", "none"],
        &["-o", "c.jpg", "-o", "c.exr"],
    ] {
        render(&place, "b.png", &[&["--alpha"], more].concat()).succeeded();
        assert!(same("a.png", "b.png"), "{more:?}");
    }
    render(&place, "d.jpg", &[]).succeeded();
    assert!(same("c.jpg", "d.jpg"), "a format without alpha shows the background");
    for share in ["1/2", "2/2"] {
        render(&place, "e.png", &["--alpha", "--tiles", share]).succeeded();
        render(&place, "e.exr", &["--alpha", "--layers", "all", "--tiles", share]).succeeded();
    }
    place.run(&["merge", "e.png.1-of-2.share", "e.png.2-of-2.share", "-o", "e.png"]).succeeded();
    place.run(&["merge", "e.exr.1-of-2.share", "e.exr.2-of-2.share", "-o", "e.exr"]).succeeded();
    assert!(same("a.png", "e.png"));
    let layers = place.run(&["compare", "a.exr", "e.exr"]).succeeded();
    assert!(layers.stdout.contains("identical"), "{}", layers.stdout);
}

/// A surface that is there by a quarter covers a quarter, and two of them as much as is left of it.
#[test]
fn holes_and_veils_are_seen_through() {
    let place = Place::new();
    let quad = |z: f32, material: &str| {
        format!(
            r#"{{"corners": [[-1, -1, {z}], [-1, 1, {z}], [1, 1, {z}], [1, -1, {z}]], "material": "{material}"}}"#
        )
    };
    for (quads, alpha) in [
        (quad(0.0, "whole"), 255),
        (quad(0.0, "veil"), 64),
        (format!("{}, {}", quad(0.0, "veil"), quad(-0.5, "veil")), 112),
        (format!("{}, {}", quad(0.0, "veil"), quad(-0.5, "whole")), 255),
        (quad(0.0, "hole"), 0),
    ] {
        let text = format!(
            r#"{{"eosphor": 2, "camera": {{"position": [0, 0, 5], "look-at": [0, 0, 0]}}, "quadrilaterals": [{quads}],
                "materials": {{
                    "whole": {{"matte": {{"color": [1, 1, 1]}}}},
                    "veil": {{"pbr": {{"opacity": 0.25}}, "alpha": "blend"}},
                    "hole": {{"pbr": {{"opacity": 0.25}}, "alpha": {{"mask": {{"cutoff": 0.5}}}}}}}},
                "settings": {{"background": [0.2, 0.5, 0.9]}}}}"#
        );
        fs::write(place.path("s.json"), text).unwrap();
        render(&place, "a.png", &["--alpha"]).succeeded();
        assert_eq!(bytes(&place, "a.png")[12 * 60 + 30][3], alpha, "{quads}");
    }
}

#[test]
fn where_alpha_does_nothing_it_is_wrong_usage() {
    let place = place();
    render(&place, "a.jpg", &["--alpha"]).is_wrong_usage(&["--alpha", ".png or .exr"]);
    render(&place, "a.png", &["--alpha", "--show", "cost"]).is_wrong_usage(&["--alpha", "--show"]);
    render(&place, "a.png", &["--alpha", "--sample-range", "0..1"]).is_wrong_usage(&["--alpha"]);
    render(&place, "a_%d.png", &["--alpha", "--orbit", "2"]).is_wrong_usage(&["--alpha", "single pictures"]);
}
