//! Parts of pictures.

use crate::place::{Place, Run};
use eosphor::{Film, Picture};
use std::fs;

const REGION: [u32; 4] = [5, 2, 9, 7];
const FLAG: &str = "5,2,9x7";

/// Renders 24 x 18 pixels.
fn render(place: &Place, name: &str, more: &[&str]) -> Run {
    let flags = ["render", "builtin:cornell", "-o", name, "--size", "24x18", "--light-samples", "1"];
    place.run(&[&flags[..], &["--no-metadata", "--aperture", "0.05", "--focus-distance", "4"], more].concat())
}

fn read(place: &Place, name: &str) -> Picture {
    Picture::read(&place.path(name)).unwrap()
}

/// The part of a picture.
fn part(picture: &Picture) -> Picture {
    let [x, y, width, height] = REGION.map(|number| number as usize);
    let all = picture.size().0 as usize;
    let places = (y..y + height).flat_map(|y| (x..x + width).map(move |x| y * all + x));
    match picture {
        Picture::Bytes(image) => {
            let mut image = image.clone();
            image.rgba = places.map(|place| image.rgba[place]).collect();
            (image.width, image.height) = (REGION[2], REGION[3]);
            Picture::Bytes(image)
        }
        Picture::Linear(film) => {
            let pixels = places.map(|place| film.pixels[place]).collect();
            Picture::Linear(Film { width: REGION[2], height: REGION[3], pixels })
        }
    }
}

#[test]
fn the_pixels_are_the_whole_pictures() {
    let place = Place::new();
    for samples in [&["--samples", "1"][..], &["--samples", "3"], &["--ssaa", "2"]] {
        for name in ["a.png", "a.exr", "a.hdr"] {
            let part_name = name.replace('a', "b");
            render(&place, name, samples).succeeded();
            let run =
                render(&place, &part_name, &[samples, &["--region", FLAG, "--json"]].concat()).succeeded();
            assert!(read(&place, &part_name) == part(&read(&place, name)), "{name} {samples:?}");
            assert_eq!((run.json()["width"].as_u64(), run.json()["height"].as_u64()), (Some(9), Some(7)));
            assert!(run.stderr.contains("9 x 7 on"), "{}", run.stderr);
        }
        for accel in ["none", "bvh", "octree", "octree-parametric", "grid", "kdtree", "bvh8"] {
            let flags =
                [samples, &["--region", FLAG, "--accel", accel, "--threads", "1", "--band-rows", "2"]];
            render(&place, "c.exr", &flags.concat()).succeeded();
            assert!(read(&place, "c.exr") == read(&place, "b.exr"), "{accel}");
        }
    }
}

#[test]
fn shares_and_samples_of_a_part_make_the_part() {
    let place = Place::new();
    let bytes = |name| fs::read(place.path(name)).unwrap();
    let flags = ["--samples", "5", "--region", FLAG];
    let with = |more: &[&'static str]| [&flags[..], more].concat();
    render(&place, "whole.exr", &with(&["--layers", "all"])).succeeded();
    for share in ["1/2", "2/2"] {
        render(&place, "a.exr", &with(&["--layers", "all", "--tiles", share])).succeeded();
    }
    place.run(&["merge", "-o", "a.exr"]).succeeded();
    assert!(bytes("a.exr") == bytes("whole.exr"), "rows");
    render(&place, "plain.exr", &flags).succeeded();
    for share in ["0..2", "2..5"] {
        render(&place, "b.exr", &with(&["--sample-range", share])).succeeded();
    }
    place.run(&["merge", "-o", "b.exr"]).succeeded();
    assert!(bytes("b.exr") == bytes("plain.exr"), "samples");
    // Shares of two parts of one size are of two pictures.
    render(&place, "c.exr", &["--samples", "5", "--region", FLAG, "--tiles", "1/2"]).succeeded();
    render(&place, "c.exr", &["--samples", "5", "--region", "6,2,9x7", "--tiles", "2/2"]).succeeded();
    place.run(&["merge", "-o", "c.exr"]).failed_with(&["shares of different pictures"]);
    render(&place, "d.exr", &["--samples", "2", "--region", FLAG, "--sample-range", "0..1"]).succeeded();
    render(&place, "d.exr", &["--samples", "2", "--region", "6,2,9x7", "--sample-range", "1..2"]).succeeded();
    place.run(&["merge", "-o", "d.exr"]).failed_with(&["shares of different pictures"]);
}

#[test]
fn what_is_no_part_of_the_picture_is_wrong_usage() {
    let place = Place::new();
    for region in ["0,0,25x1", "24,0,1x1", "0,17,1x2", "4000000000,0,1x1"] {
        render(&place, "a.png", &["--region", region]).is_wrong_usage(&[region, "24 x 18 pixels"]);
    }
    for region in ["5,2", "-1,2,3x3", "a"] {
        render(&place, "a.png", &[&format!("--region={region}")[..]])
            .is_wrong_usage(&["--region", "as 100,50"]);
    }
    render(&place, "a.png", &["--region", "5,2,0x7"]).is_wrong_usage(&["--region", "each side"]);
    render(&place, "a.png", &["--region", FLAG, "--show", "cost"]).is_wrong_usage(&["--region", "--show"]);
    render(&place, "a%d.png", &["--region", FLAG, "--orbit", "2"]).is_wrong_usage(&["--region", "single"]);
    assert!(place.names().is_empty());
}
