//! Lights from the command line, and what there is where nothing lights a model.

use crate::place::{Place, Run};
use eosphor::Picture;
use std::fs;

/// A ball and a quadrilateral below it, with these lights.
fn scene(place: &Place, name: &str, lights: &str) {
    let text = format!(
        r#"{{"eosphor": 2, "camera": {{"position": [0, 2, 5], "look-at": [0, 0, 0]}}, {lights}
            "spheres": [{{"center": [0, 0, 0], "radius": 1}}],
            "quadrilaterals": [{{"corners": [[-3, -1, 3], [-3, -1, -3], [3, -1, -3], [3, -1, 3]]}}]}}"#
    );
    fs::write(place.path(name), text).unwrap();
}

fn render(place: &Place, scene: &str, out: &str, more: &[&str]) -> Run {
    let flags = ["render", scene, "-o", out, "--size", "24x24", "--no-metadata"];
    place.run(&[&flags[..], more].concat())
}

#[test]
fn lights_of_flags_are_those_of_scenes() {
    let place = Place::new();
    scene(&place, "bare.json", "");
    for (number, (flags, lights)) in [
        (
            &["--sun", "1,-2,-1,1.5"][..],
            r#""lights": [{"directional": {"direction": [1, -2, -1], "color": [1.5, 1.5, 1.5]}}],"#,
        ),
        (
            &["--sun", "0,-1,0"],
            r#""lights": [{"directional": {"direction": [0, -1, 0], "color": [3, 3, 3]}}],"#,
        ),
        (
            &["--light", "-2,3,1,20"],
            r#""lights": [{"point": {"position": [-2, 3, 1], "color": [20, 20, 20]}}],"#,
        ),
        (
            &["--light", "2,3,1", "--sun", "0,-1,-1", "--light", "-2,3,1,0.5"],
            r#""lights": [{"directional": {"direction": [0, -1, -1], "color": [3, 3, 3]}},
                {"point": {"position": [2, 3, 1], "color": [10, 10, 10]}},
                {"point": {"position": [-2, 3, 1], "color": [0.5, 0.5, 0.5]}}],"#,
        ),
    ]
    .into_iter()
    .enumerate()
    {
        scene(&place, "lit.json", lights);
        let run = render(&place, "bare.json", "a.exr", flags).succeeded();
        assert!(!run.stderr.contains("headlight"), "{}", run.stderr);
        render(&place, "lit.json", "b.exr", &[]).succeeded();
        assert!(fs::read(place.path("a.exr")).unwrap() == fs::read(place.path("b.exr")).unwrap(), "{number}");
    }
    // They come to what the scene has.
    let one = r#""lights": [{"point": {"position": [-2, 3, 1], "color": [0.5, 0.5, 0.5]}}],"#;
    scene(&place, "one.json", one);
    render(&place, "one.json", "a.exr", &["--light", "2,3,1"]).succeeded();
    render(&place, "bare.json", "b.exr", &["--light", "-2,3,1,0.5", "--light", "2,3,1"]).succeeded();
    assert!(fs::read(place.path("a.exr")).unwrap() == fs::read(place.path("b.exr")).unwrap());
}

#[test]
fn wrong_lights_are_wrong_usage() {
    let place = Place::new();
    scene(&place, "bare.json", "");
    for (flags, words) in [
        (&["--sun", "0,0,0"][..], &["--sun", "no length"][..]),
        (&["--sun", "1,2"], &["--sun", "three numbers, or four"]),
        (&["--light", "1,2,3,-1"], &["--light", "from 0 to 1e6"]),
        (&["--light", "1,2,3", "--lighting", "diffuse"], &["--light", "would do nothing here", "phong"]),
        (&["--sun", "1,2,3", "--lighting", "distance"], &["--sun", "would do nothing here"]),
    ] {
        render(&place, "bare.json", "a.png", flags).is_wrong_usage(words);
    }
}

/// What is behind a model, in the corner of the picture.
fn behind(place: &Place, name: &str) -> [f32; 3] {
    let Picture::Linear(film) = Picture::read(&place.path(name)).unwrap() else { panic!("EXR is linear") };
    film.pixels[0].into()
}

#[test]
fn what_nothing_lights_has_grey_surroundings() {
    let place = Place::new();
    let obj = "v 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl m\nf 1 2 3\n";
    fs::write(place.path("dark.obj"), obj).unwrap();
    fs::write(place.path("lamp.obj"), format!("mtllib lamp.mtl\n{obj}")).unwrap();
    fs::write(place.path("lamp.mtl"), "newmtl m\nKe 1 1 1\n").unwrap();
    fs::write(place.path("spare.obj"), format!("mtllib spare.mtl\n{obj}")).unwrap();
    fs::write(place.path("spare.mtl"), "newmtl other\nKe 1 1 1\nnewmtl m\nKd 1 1 1\n").unwrap();
    let ply = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
               element face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";
    fs::write(place.path("dark.ply"), ply).unwrap();
    let text = r#"{"eosphor": 2, "meshes": [{"file": "dark.obj"}]}"#;
    fs::write(place.path("own.json"), text).unwrap();
    let away = ["--eye", "0.3,0.3,5", "--look-at", "0.3,0.3,0"];
    for (file, flags, radiance) in [
        ("dark.obj", &[][..], 0.25),
        ("spare.obj", &[], 0.25),
        ("dark.ply", &[], 0.25),
        ("lamp.obj", &[], 0.0),
        ("own.json", &[], 0.0),
        ("dark.obj", &["--headlight", "off"], 0.0),
        ("dark.obj", &["--sun", "0,0,-1"], 0.0),
        ("dark.ply", &["--background", "0,0,1"], 1.0),
    ] {
        render(&place, file, "a.exr", &[&away[..], flags].concat()).succeeded();
        assert_eq!(behind(&place, "a.exr")[2], radiance, "{file} {flags:?}");
    }
}
