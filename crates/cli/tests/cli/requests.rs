//! What a scene's file asks for besides the picture, and the flags that win over it.

use crate::place::Place;
use std::fs;

const OBJ: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nv 0.5 0.5 1\nf 1 2 5\nf 2 4 5\nf 4 3 5\nf 3 1 5\n";

/// A configuration of PG1 with this renderer, over a pyramid.
fn pg1(place: &Place, renderer: &str) {
    fs::write(place.path("a.obj"), OBJ).unwrap();
    let camera = r#"{"pos": [0.5, 0.5, 4], "dir": [0, 0, -1], "width": 12, "height": 8}"#;
    let text = format!(
        r#"{{"renderer": {renderer}, "scene": {{"source_file": "a.obj", "camera": {camera},
            "point_lights": [{{"pos": [0, 1, 5], "color": [1, 1, 1]}}]}}}}"#
    );
    fs::write(place.path("c.json"), text).unwrap();
}

/// A scene of ours with these keys.
fn scene(place: &Place, keys: &str) {
    let text = format!(
        r#"{{"eosphor": 2, {keys} "settings": {{"size": [12, 8]}}, "spheres": [{{"center": [0, 0, 0], "radius": 1}},
            {{"center": [3, 0, 0], "radius": 1}}, {{"center": [0, 3, 0], "radius": 1}}]}}"#
    );
    fs::write(place.path("s.json"), text).unwrap();
}

#[test]
fn a_configuration_of_pg1_runs_as_it_is() {
    let place = Place::new();
    // (Both ways through an octree go through one structure.)
    for (name, expected) in [("octree", "octree"), ("octee_parametric", "octree"), ("none", "none")] {
        pg1(
            &place,
            &format!(
                r#"{{"render_mode": "cpu", "output": {{"filename": "out.ppm"}}, "acceleratied_data_structure":
                    {{"name": "{name}", "max_triangles_per_BB": 1, "max_depth": 3}}}}"#
            ),
        );
        let report = place.run(&["render", "c.json", "--json", "-q"]).succeeded().json();
        assert_eq!(report["hierarchy"]["structure"], expected);
        assert!(report["backend"].as_str().unwrap().starts_with("CPU"), "{report}");
        assert_eq!(report["output"], "out.ppm");
        assert!(report["hierarchy"]["max_leaf_depth"].as_u64().unwrap() <= 3, "{report}");
        assert!(fs::read(place.path("out.ppm")).unwrap().starts_with(b"P6"));
        fs::remove_file(place.path("out.ppm")).unwrap();
    }
}

#[test]
fn flags_win_over_what_a_file_asks_for() {
    let place = Place::new();
    scene(&place, r#""output": "f.png", "device": {"backend": "cpu", "accel": "octree", "tree-depth": 2},"#);
    let report = |more: &[&str]| {
        place.run(&[&["render", "s.json", "--json", "-q", "--no-metadata"], more].concat()).succeeded().json()
    };
    assert_eq!(report(&[])["hierarchy"]["structure"], "octree");
    assert_eq!(place.names(), ["f.png", "s.json"]);
    // What was for the octree does not bother others.
    assert_eq!(report(&["--accel", "grid", "-o", "g.png"])["hierarchy"]["structure"], "grid");
    assert_eq!(report(&["--tree-depth", "1", "-o", "h.png"])["hierarchy"]["structure"], "octree");
    assert_eq!(fs::read(place.path("f.png")).unwrap(), fs::read(place.path("g.png")).unwrap());
    let bench = ["bench", "render", "s.json", "--repeats", "1", "--json"];
    assert!(place.run(&bench).succeeded().stdout.contains("CPU"));
}

#[test]
fn a_picture_needs_a_name() {
    let place = Place::new();
    scene(&place, "");
    place.run(&["render", "s.json"]).is_wrong_usage(&["the picture has no name", "-o picture.png"]);
    place.run(&["render", "builtin:cornell"]).is_wrong_usage(&["the picture has no name"]);
}

#[test]
fn what_does_not_fit_is_said() {
    let place = Place::new();
    for (device, words) in [
        (r#"{"accel": "grid", "leaf-size": 4}"#, ["leaf-size", "would do nothing", "octree"]),
        (r#"{"leaf-size": 4}"#, ["leaf-size", "would do nothing", "bvh"]),
        (r#"{"accel": "octree", "tree-depth": 17}"#, ["tree-depth", "must be", "1 to 16"]),
        (
            r#"{"accel": "bvh", "builder": "morton", "sah-costs": [1, 1]}"#,
            ["sah-costs", "would do nothing", "morton"],
        ),
        (r#"{"accel": "oktree"}"#, ["s.json:1", "oktree", "octree"]),
        (r#"{"backend": "cuda:0"}"#, ["s.json:1", "backend", "cuda"]),
    ] {
        scene(&place, &format!(r#""device": {device},"#));
        place.run(&["render", "s.json", "-o", "a.png"]).failed_with(&words);
    }
    pg1(&place, r#"{"acceleratied_data_structure": {"name": "octree", "max_depth": 40}}"#);
    place.run(&["render", "c.json", "-o", "a.png"]).failed_with(&["c.json", "max_depth", "1 to 16"]);
    for (flags, words) in [
        (&["--leaf-size", "4"][..], "--leaf-size would do nothing"),
        (&["--accel", "grid", "--tree-depth", "4"], "--tree-depth would do nothing"),
        (&["--accel", "bvh", "--leaf-size", "256"], "--leaf-size: it must be"),
        (&["--accel", "kdtree", "--sah-costs", "1,0"], "--sah-costs: it must be"),
        (&["--accel", "kdtree", "--sah-costs", "1"], "--sah-costs"),
    ] {
        let arguments = [&["render", "builtin:cornell", "-o", "a.png"], flags].concat();
        place.run(&arguments).is_wrong_usage(&[words]);
    }
}

/// Each option changes the hierarchy, and none the picture.
#[test]
fn options_of_hierarchies_change_them_and_no_pixel() {
    let place = Place::new();
    let render = |name: &str, more: &[&str]| {
        let fixed =
            ["render", "builtin:cornell", "-o", name, "--size", "24x18", "--backend", "cpu", "--json", "-q"];
        let fixed = [&fixed[..], &["--samples", "2", "--no-metadata"], more].concat();
        let hierarchy = place.run(&fixed).succeeded().json()["hierarchy"].clone();
        let numbers = ["nodes", "leaves", "references", "max_leaf_depth", "max_leaf_size"];
        (numbers.map(|key| hierarchy[key].as_f64()), fs::read(place.path(name)).unwrap())
    };
    for (accel, options) in [
        (
            "bvh",
            &["--leaf-size 1", "--leaf-size 64 --sah-costs 4,1", "--tree-depth 5", "--sah-costs 1,9"][..],
        ),
        ("octree", &["--leaf-size 200", "--tree-depth 2", "--sah-costs 9,1"]),
        ("octree-parametric", &["--leaf-size 200", "--tree-depth 2", "--sah-costs 30,1"]),
        ("kdtree", &["--tree-depth 5", "--sah-costs 20,1"]),
    ] {
        let (usual, picture) = render("u.png", &["--accel", accel]);
        for option in options {
            let flags: Vec<&str> = ["--accel", accel].into_iter().chain(option.split(' ')).collect();
            let (numbers, same) = render("o.png", &flags);
            assert_ne!(numbers, usual, "{accel} {option}");
            assert_eq!(same, picture, "{accel} {option}");
        }
    }
}

#[test]
fn rays_are_traced_through_every_structure() {
    let place = Place::new();
    for accel in ["none", "bvh", "octree", "grid"] {
        let arguments = ["bench", "rays", "builtin:cornell", "--size", "8x6", "--repeats", "1", "--json"];
        let report = place.run(&[&arguments[..], &["--accel", accel]].concat()).succeeded().json();
        assert_eq!(report["accel"], accel);
        assert!(report["rows"].as_array().unwrap().iter().all(|row| row["different"] == 0));
    }
    let cuda = ["bench", "rays", "builtin:cornell", "--backend", "cuda", "--accel", "grid"];
    place.run(&cuda).is_wrong_usage(&["--accel would do nothing", "bvh"]);
}
