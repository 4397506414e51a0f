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
    for (name, expected) in
        [("octree", "octree"), ("octee_parametric", "octree-parametric"), ("none", "none")]
    {
        pg1(
            &place,
            &format!(
                r#"{{"render_mode": "cpu", "output": {{"filename": "out.ppm"}}, "acceleratied_data_structure":
                    {{"name": "{name}", "max_triangles_per_BB": 1, "max_depth": 3}}}}"#
            ),
        );
        let run = place.run(&["render", "c.json", "--json"]).succeeded();
        assert!(run.stderr.contains(&format!("hierarchy        {expected}, built in")), "{}", run.stderr);
        let report = run.json();
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

/// What a file asks for is there for all commands that have hierarchies and devices.
#[test]
fn all_commands_obey_a_file() {
    let place = Place::new();
    scene(&place, r#""device": {"backend": "cpu", "accel": "octree", "tree-depth": 2},"#);
    let info = |more: &[&str]| {
        let report = place.run(&[&["info", "s.json", "--json"], more].concat()).succeeded().json();
        let hierarchy = &report["hierarchy"];
        (hierarchy["structure"].as_str().unwrap().to_owned(), hierarchy["max_leaf_depth"].as_u64().unwrap())
    };
    let (structure, depth) = info(&[]);
    assert!(structure == "octree" && depth <= 2, "{structure} {depth}");
    assert_eq!(info(&["--accel", "grid"]).0, "grid");
    assert!(info(&["--tree-depth", "1"]).1 <= 1);
    place.run(&["info", "s.json", "--accel", "all"]).succeeded();
    let rays = |more: &[&str]| {
        let fixed = ["bench", "rays", "s.json", "--size", "8x6", "--repeats", "1", "--json"];
        place.run(&[&fixed[..], more].concat()).succeeded().json()["accel"].as_str().unwrap().to_owned()
    };
    assert_eq!((rays(&[]), rays(&["--accel", "kdtree"])), ("octree".into(), "kdtree".into()));
    scene(&place, r#""device": {"accel": "grid", "leaf-size": 4},"#);
    for command in [&["info", "s.json"][..], &["bench", "rays", "s.json"], &["bench", "render", "s.json"]] {
        place.run(command).failed_with(&["leaf-size", "would do nothing"]);
    }
}

/// Each key has a line that says what became of it.
#[test]
fn every_key_of_pg1_is_accounted_for() {
    let place = Place::new();
    fs::write(place.path("a.obj"), OBJ).unwrap();
    let text = r#"{"seed": 7, "obj_loader": {"triangulate": false, "basepath": "models"},
        "renderer": {"render_mode": "cpu", "max_depth": 3, "samples_per_triangle": 5, "render_type": "phong",
            "max_distance": 9.5, "shading_type": "flat", "cull_backfaces": false, "background_color": [0, 0.5, 1],
            "acceleratied_data_structure": {"name": "octee_parametric", "max_triangles_per_BB": 1, "max_depth": 3},
            "output": {"filename": "inner.ppm"}},
        "output": {"filename": "out.ppm"},
        "scene": {"source_file": "a.obj", "camera": {"pos": [0.5, 0.5, 4], "dir": [0, 0, -1], "up": [0, 1, 0],
            "fov": 1, "width": 12, "height": 8, "samples_per_pixel": 2},
            "point_lights": [{"pos": [0, 1, 5], "color": [1, 1, 1]}]}}"#;
    fs::write(place.path("c.json"), text).unwrap();
    let lines = |more: &[&str]| {
        let run = place.run(&[&["render", "c.json", "-v"], more].concat()).succeeded();
        let ours = run.stderr.lines().filter_map(|line| line.strip_prefix("c.json: "));
        ours.map(str::to_owned).collect::<Vec<String>>()
    };
    let usual = [
        "obj_loader.basepath = \"models\": not used: the model is not there but beside this file",
        "obj_loader.triangulate = false: not used: faces become triangles in any case",
        "output.filename = \"out.ppm\": obeyed as output",
        "renderer.acceleratied_data_structure.max_depth = 3: obeyed as tree-depth",
        "renderer.acceleratied_data_structure.max_triangles_per_BB = 1: obeyed as leaf-size",
        "renderer.acceleratied_data_structure.name = \"octee_parametric\": obeyed as accel",
        "renderer.background_color = [0,0.5,1]: obeyed as background",
        "renderer.cull_backfaces = false: obeyed as cull",
        "renderer.max_depth = 3: obeyed as depth",
        "renderer.max_distance = 9.5: not used: it is for the lighting distance",
        "renderer.output.filename = \"inner.ppm\": not used: the \"output\" of the whole file is taken",
        "renderer.render_mode = \"cpu\": obeyed as backend",
        "renderer.render_type = \"phong\": obeyed as lighting",
        "renderer.samples_per_triangle = 5: obeyed as light-samples",
        "renderer.shading_type = \"flat\": obeyed as normals",
        "scene.camera.dir = [0,0,-1]: obeyed as direction",
        "scene.camera.fov = 1: obeyed as fov",
        "scene.camera.height = 8: obeyed as height of the size",
        "scene.camera.pos = [0.5,0.5,4]: obeyed as eye",
        "scene.camera.samples_per_pixel = 2: obeyed as samples",
        "scene.camera.up = [0,1,0]: obeyed as up",
        "scene.camera.width = 12: obeyed as width of the size",
        "scene.point_lights[0].color = [1,1,1]: obeyed as colour of a light",
        "scene.point_lights[0].pos = [0,1,5]: obeyed as position of a light",
        "scene.source_file = \"a.obj\": obeyed as the model",
        "seed = 7: obeyed as seed",
    ];
    let mut all = lines(&[]);
    all.sort();
    assert_eq!(all, usual);
    // Flags win.
    for (flags, key, winner) in [
        (&["--depth", "1"][..], "renderer.max_depth", "--depth"),
        (&["--preset", "eos"], "renderer.shading_type", "--preset"),
        (&["--size", "8x8"], "scene.camera.width", "--size"),
        (&["--no-cull"], "renderer.cull_backfaces", "--no-cull"),
        (&["-o", "b.png"], "output.filename", "--output"),
        (&["--accel", "grid"], "renderer.acceleratied_data_structure.max_depth", "--accel"),
        (&["--leaf-size", "2"], "renderer.acceleratied_data_structure.max_triangles_per_BB", "--leaf-size"),
        (&["--look-at", "0,0,0"], "scene.camera.dir", "--look-at"),
        (&["--backend", "cpu"], "renderer.render_mode", "--backend"),
    ] {
        let all = lines(flags);
        let line = all.iter().find(|line| line.starts_with(&format!("{key} = "))).unwrap();
        assert!(line.ends_with(&format!(": overridden by {winner}")), "{line}");
        assert_eq!(all.len(), usual.len());
    }
    let same = lines(&["--accel", "octree-parametric"]);
    assert!(same.iter().all(|line| !line.contains("overridden")), "{same:?}");
    let distance = lines(&["--lighting", "distance"]);
    assert!(distance.contains(&"renderer.max_distance = 9.5: obeyed as max-distance".to_owned()));
    // Other files have none.
    scene(&place, r#""output": "o.png","#);
    let run = place.run(&["render", "s.json", "-v"]).succeeded();
    assert!(!run.stderr.contains("obeyed"), "{}", run.stderr);
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

#[test]
fn a_scene_over_its_base_is_the_base_with_flags() {
    let place = Place::new();
    scene(&place, r#""camera": {"position": [1, 2, 9]},"#);
    fs::create_dir(place.path("in")).unwrap();
    let over = r#"{"eosphor": 2, "base": "../s.json", "camera": {"position": [2.5, 1, 9.1], "look-at": [1, 1, 0]},
        "settings": {"samples": 3, "exposure": 0.5}, "output": "over.png"}"#;
    fs::write(place.path("in/o.json"), over).unwrap();
    place.run(&["render", "in/o.json", "--no-metadata"]).succeeded();
    let flags =
        "--eye=2.5,1,9.1 --look-at=1,1,0 --fov=45 --samples=3 --exposure=0.5 --no-metadata -o flags.png";
    place.run(&[&["render", "s.json"][..], &flags.split(' ').collect::<Vec<_>>()].concat()).succeeded();
    assert!(fs::read(place.path("over.png")).unwrap() == fs::read(place.path("flags.png")).unwrap());
    fs::write(place.path("in/o.json"), over.replace("../s.json", "s.json")).unwrap();
    place.run(&["render", "in/o.json"]).failed_with(&["in/o.json:1:24", "base: ", "No such file"]);
}
