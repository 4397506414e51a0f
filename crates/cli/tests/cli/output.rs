//! Files: the same bytes in any bands, layers, metadata, and formats beside each other.

use crate::place::{Place, holds};
use std::fs;

const FORMATS: [&str; 6] = ["png", "ppm", "jpg", "hdr", "exr", "data"];

#[test]
fn bands_change_no_byte() {
    let place = Place::new();
    for format in FORMATS {
        let (whole, bands) = (&format!("a.{format}"), &format!("b.{format}"));
        let layers: &[&str] = if format == "exr" { &["--layers", "all"] } else { &[] };
        place.render(whole, &[&["--no-metadata"], layers].concat()).succeeded();
        for rows in ["1", "5", "11"] {
            place.render(bands, &[&["--no-metadata", "--band-rows", rows], layers].concat()).succeeded();
            let bytes = |name: &String| fs::read(place.path(name)).unwrap();
            assert!(bytes(whole) == bytes(bands), "{format}, bands of {rows} rows");
        }
    }
    let all = place.render("c.png", &["--json", "-q"]).succeeded().json();
    let bands = place.render("c.png", &["--json", "-q", "--band-rows", "5"]).succeeded().json();
    assert_eq!(all["rays"], bands["rays"]);
}

#[test]
fn neither_threads_nor_simd_change_a_layer() {
    let place = Place::new();
    // `cost` is of the hierarchy.
    let layers = ["--no-metadata", "--layers", "albedo,normal,depth,object,material", "--samples", "3"];
    place.render("a.exr", &layers).succeeded();
    for flags in [["--threads", "1"], ["--tile", "5"], ["--accel", "none"], ["--simd", "baseline"]] {
        place.render("b.exr", &[&layers[..], &flags].concat()).succeeded();
        let bytes = |name| fs::read(place.path(name)).unwrap();
        assert!(bytes("a.exr") == bytes("b.exr"), "{flags:?}");
    }
}

#[test]
fn files_say_what_they_are_made_of() {
    let place = Place::new();
    let said = |name: &str, flags: &[&str], text: &str| {
        place.render(name, flags).succeeded();
        holds(&place.path(name), text)
    };
    for name in ["a.png", "a.exr"] {
        assert!(said(name, &[], &format!("eosphor render builtin:cornell -o {name} --size 16x12")));
        assert!(said(name, &[], "Eosphor 0.") && said(name, &["--no-metadata"], "Eosphor 0."));
        assert!(!said(name, &["--no-metadata"], "builtin:cornell"), "{name}");
    }
    // The hash is that of what reaches a pixel.
    let hash = |flags: &[&str]| {
        place.render("h.png", flags).succeeded();
        let bytes = fs::read(place.path("h.png")).unwrap();
        let text = String::from_utf8_lossy(&bytes);
        let (_, after) = text.split_once("Scene hash\0").unwrap();
        after[..64].to_owned()
    };
    let plain = hash(&[]);
    assert!(plain.bytes().all(|c| c.is_ascii_hexdigit()));
    for same in [&["--threads", "1"], &["--accel", "none"], &["--band-rows", "3"]] {
        assert_eq!(hash(same), plain, "{same:?}");
    }
    for other in [["--exposure", "1"], ["--samples", "2"], ["--translate", "0,0,1"], ["--preset", "pg1"]] {
        assert_ne!(hash(&other), plain, "{other:?}");
    }
}

#[test]
fn formats_are_compared_with_each_other() {
    let place = Place::new();
    for format in FORMATS {
        place.render(&format!("a.{format}"), &[]).succeeded();
    }
    place.render("half.exr", &["--exr-half"]).succeeded();
    place.render("worse.jpg", &["--jpeg-quality", "30"]).succeeded();
    for other in ["a.ppm", "a.data"] {
        assert_eq!(place.run(&["compare", "a.png", other]).succeeded().stdout, "identical\n", "{other}");
    }
    let compared = |a, b| {
        let run = place.run(&["compare", "--json", a, b]);
        assert_eq!(run.code, Some(1), "{a} and {b}: {}", run.stderr);
        run.json()["rmse"].as_f64().unwrap()
    };
    let (good, worse) = (compared("a.png", "a.jpg"), compared("a.png", "worse.jpg"));
    assert!(good < worse && good < 10.0 && worse < 40.0, "{good} {worse}");
    assert!(compared("a.exr", "half.exr") < 0.01 && compared("a.exr", "a.hdr") < 0.01);
    place.run(&["compare", "a.png", "a.exr"]).failed_with(&["a.png", "linear"]);
    place.run(&["compare", "a.png", "a.jpg", "--diff", "d.exr"]).is_wrong_usage(&["--diff", ".png"]);
    place.run(&["compare", "a.exr", "half.exr", "--diff", "d.jpg"]);
    assert!(place.names().contains(&"d.jpg".into()));
}

#[test]
fn half_floats_and_quality_make_smaller_files() {
    let place = Place::new();
    let size = |name: &str, flags: &[&str]| {
        let size = ["--size", "64x64", "--no-metadata"];
        place.render(name, &[&size[..], flags].concat()).succeeded();
        fs::metadata(place.path(name)).unwrap().len()
    };
    assert!(size("a.exr", &["--exr-half"]) < size("b.exr", &[]));
    assert!(size("a.jpg", &["--jpeg-quality", "40"]) < size("b.jpg", &[]));
    assert!(size("c.exr", &["--layers", "depth"]) < size("d.exr", &["--layers", "all"]));
}
