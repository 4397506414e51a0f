//! `eosphor render` and `info`: pictures, flags, reports and what goes wrong.

use crate::place::Place;
use std::fs;

#[test]
fn every_format_is_written_and_stdout_stays_clean() {
    let place = Place::new();
    let names = ["a.JPEG", "a.data", "a.exr", "a.hdr", "a.jpg", "a.png", "a.ppm"];
    for name in names {
        let run = place.render(name, &[]).succeeded();
        assert!(run.stdout.is_empty());
        assert!(run.stderr.contains("camera") && run.stderr.contains("Mrays/s"), "{}", run.stderr);
    }
    assert_eq!(place.names(), names);
    assert_eq!(fs::metadata(place.path("a.data")).unwrap().len(), 8 + 16 * 12 * 4);
}

#[test]
fn quiet_says_nothing() {
    let run = Place::new().render("a.png", &["-q"]).succeeded();
    assert_eq!((run.stdout.as_str(), run.stderr.as_str()), ("", ""));
}

#[test]
fn json_has_rays_time_and_hierarchy() {
    let json = Place::new().render("a.png", &["--json", "--stats", "-q"]).succeeded().json();
    assert_eq!(json["complete"], true);
    assert_eq!(json["rays"]["camera"], 16 * 12);
    assert_eq!([&json["width"], &json["height"]], [16, 12]);
    assert!(json["rays"]["shadow"].as_u64().unwrap() > 0);
    assert!(json["work_per_ray"]["tests"].as_f64().unwrap() > 0.0);
    assert!(json["seconds"]["render"].as_f64().unwrap() > 0.0);
    assert!(json["hierarchy"]["nodes"].as_u64().unwrap() > 0);
}

#[test]
fn neither_threads_nor_tiles_nor_hierarchy_change_a_byte() {
    let place = Place::new();
    place.render("a.exr", &[]).succeeded();
    for flags in [
        ["--threads", "1"],
        ["--tile", "5"],
        ["--accel", "none"],
        ["--simd", "baseline"],
        ["--scheduler", "scalar"],
    ] {
        place.render("b.exr", &flags).succeeded();
        assert_eq!(place.run(&["compare", "a.exr", "b.exr"]).succeeded().stdout, "identical\n", "{flags:?}");
    }
}

#[test]
fn flags_win_over_the_preset() {
    let place = Place::new();
    let json = place.render("a.png", &["--preset", "pg1", "--depth", "0", "--json", "-q"]).succeeded().json();
    assert_eq!([&json["width"], &json["height"]], [16, 12]);
    let rays = &json["rays"];
    assert_eq!([&rays["reflected"], &rays["refracted"], &rays["glossy"]], [0, 0, 0]);
}

#[test]
fn moving_the_geometry_is_moving_the_camera_the_other_way() {
    let place = Place::new();
    let unlit = ["--lighting", "distance", "--max-distance", "4"];
    place.render("a.ppm", &[&unlit[..], &["--translate", "1,2,-4", "--eye", "1,3,0.5"]].concat()).succeeded();
    place.render("b.ppm", &[&unlit[..], &["--eye", "0,1,4.5"]].concat()).succeeded();
    let run = place.run(&["compare", "--json", "a.ppm", "b.ppm"]);
    assert!(run.json()["max_difference"].as_f64().unwrap() <= 1.0, "{}", run.stdout);
}

/// A model at UTM coordinates: flags have the coordinates of the file, and nothing is lost.
#[test]
fn a_far_model_is_seen_as_a_near_one() {
    let place = Place::new();
    let obj = |name: &str, [x, y, z]: [f64; 3]| {
        let corners = [[0.25, 0.0, 0.0], [2.0 + 1.0 / 1024.0, 0.0, 0.5], [0.5, 1.5, -1.0 / 512.0]];
        let vertex = |c: &[f64; 3]| format!("v {} {} {}\n", x + c[0], y + c[1], z + c[2]);
        let text = corners.iter().map(vertex).collect::<String>() + "f 1 2 3\n";
        fs::write(place.path(name), text).unwrap();
    };
    obj("near.obj", [0.0; 3]);
    obj("far.obj", [500_000.0, 5_000_000.0, 96.0]);
    let render = |scene: &str, name: &str, more: &[&str]| {
        place.run(&[&["render", scene, "-o", name, "--size", "24x16"], more].concat()).succeeded().stderr
    };
    let (eye, look_at) = ("1,0.5,4.0009765625", "0.5,0.25,0");
    let (far_eye, far_look_at) = ("500001,5000000.5,100.0009765625", "500000.5,5000000.25,96");
    let note = "it is rendered about (500000, 5000000, 96)";

    assert!(!render("near.obj", "near.ppm", &["--eye", eye, "--look-at", look_at]).contains("far from 0"));
    let said = render("far.obj", "far.ppm", &["--eye", far_eye, "--look-at", far_look_at]);
    assert!(said.contains(note), "{said}");
    let back = ["--translate", "-500000,-5000000,-96", "--eye", eye, "--look-at", look_at];
    assert!(!render("far.obj", "back.ppm", &back).contains("far from 0"));
    let there = ["--translate", "500000,5000000,96", "--eye", far_eye, "--look-at", far_look_at];
    assert!(render("near.obj", "there.ppm", &there).contains(note));
    for other in ["far.ppm", "back.ppm", "there.ppm"] {
        place.run(&["compare", "near.ppm", other]).succeeded();
    }

    // What is shown without a camera is the same, too, and said in coordinates of the file.
    render("near.obj", "a.ppm", &[]);
    assert!(render("far.obj", "b.ppm", &[]).contains("no camera: seen from above the front (+z), at (50000"));
    place.run(&["compare", "a.ppm", "b.ppm"]).succeeded();
    let info = place.run(&["info", "far.obj", "--json"]).succeeded().json();
    assert_eq!(info["bounds"][0], serde_json::json!([500_000.25, 5_000_000.0, 96.0 - 1.0 / 512.0]));
    assert_eq!(info["bounds"][1], serde_json::json!([500_002.0 + 1.0 / 1024.0, 5_000_001.5, 96.5]));
}

#[test]
fn a_scene_without_a_camera_can_be_zoomed() {
    let place = Place::new();
    fs::write(place.path("t.obj"), "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n").unwrap();
    let flags = ["--size", "8x8", "--lighting", "diffuse", "-q"];
    place.run(&[&["render", "t.obj", "-o", "a.ppm"], &flags[..]].concat()).succeeded();
    place.run(&[&["render", "t.obj", "-o", "b.ppm", "--fov", "45"], &flags[..]].concat()).succeeded();
    place.run(&[&["render", "t.obj", "-o", "c.ppm", "--fov", "90"], &flags[..]].concat()).succeeded();
    place.run(&["compare", "a.ppm", "b.ppm"]).succeeded();
    assert_eq!(place.run(&["compare", "a.ppm", "c.ppm"]).code, Some(1));
}

#[test]
fn outputs_that_cannot_be_written_are_found_before_rendering() {
    let place = Place::new();
    fs::create_dir(place.path("folder.png")).unwrap();
    let huge = ["--samples", "65536"];
    place.render("/proc/no/a.png", &huge).failed_with(&["/proc/no/a.png"]);
    place.render("/dev/full/x.png", &huge).failed_with(&["/dev/full/x.png", "not a folder"]);
    place.render("folder.png", &huge).failed_with(&["folder.png", "this is a folder"]);
    place.render("a.tga", &huge).is_wrong_usage(&["a.tga", ".png, .ppm, .jpg, .hdr, .exr or .data"]);
    place.render("a", &huge).is_wrong_usage(&[".png, .ppm, .jpg, .hdr, .exr or .data"]);
    place.render(&format!("{}.png", "n".repeat(300)), &huge).failed_with(&["shorter"]);
    assert_eq!(place.names(), ["folder.png"]);
}

#[cfg(unix)]
#[test]
fn folders_that_may_not_be_written_to() {
    use std::os::unix::fs::PermissionsExt;
    let place = Place::new();
    let folder = place.path("locked");
    fs::create_dir(&folder).unwrap();
    fs::set_permissions(&folder, fs::Permissions::from_mode(0o555)).unwrap();
    // Root may write anywhere; /proc takes no files from anybody.
    if fs::write(folder.join("probe"), "").is_ok() {
        place.render("/proc/a.png", &[]).failed_with(&["/proc/a.png"]);
    } else {
        place.render("locked/a.png", &[]).failed_with(&["locked/a.png", "permission denied"]);
    }
}

#[test]
fn wrong_flags_are_wrong_usage() {
    let place = Place::new();
    let bad: [(&[&str], &str); 18] = [
        (&["--size", "0x5"], "1 to 65535"),
        (&["--size", "99999x99999"], "1 to 65535"),
        (&["--size", "800"], "WIDTHxHEIGHT"),
        (&["--samples", "0"], "1 to 65536"),
        (&["--depth", "65"], "0 to 64"),
        (&["--background", "1,2"], "three numbers"),
        (&["--exposure", "nan"], "-64 to 64"),
        (&["--exposure", "1000"], "exposure"),
        (&["--threads", "0"], "1 to 1024"),
        (&["--fov", "180"], "fov"),
        (&["--focus-distance", "1"], "--aperture"),
        (&["--lighting", "x"], "blinn-phong"),
        (&["--layers", "depth"], "--layers is for pictures that end in .exr"),
        (&["--layers", "depth,x"], "albedo, normal, depth, object, material, cost"),
        (&["--exr-half"], "--exr-half is for pictures that end in .exr"),
        (&["--jpeg-quality", "50"], "--jpeg-quality is for pictures that end in .jpg"),
        (&["--jpeg-quality", "0"], "1 to 100"),
        (&["--jpeg-quality", "101"], "1 to 100"),
    ];
    for (flags, words) in bad {
        let whole = [&["render", "builtin:cornell", "-o", "a.png", "--light-samples", "1"], flags].concat();
        place.run(&whole).is_wrong_usage(&[words]);
    }
    place.run(&["render", "builtin:cornell"]).is_wrong_usage(&["--output"]);
    place.run(&[]).is_wrong_usage(&["render"]);
    assert!(place.names().is_empty());
}

#[test]
fn flags_that_would_do_nothing_are_wrong_usage() {
    let place = Place::new();
    let bad: &[(&[&str], &str)] = &[
        (&["--orbit", "4"], "--orbit would do nothing here: it needs frames"),
        (&["--fps", "25"], "--fps would do nothing here: it needs frames"),
        (&["--resume", "--stats"], "--resume would do nothing here: it needs a render without --stats"),
        (&["--resume", "--show", "cost"], "--resume would do nothing here: it needs a picture or frames"),
        (
            &["--checkpoint-every", "5", "--show", "cost"],
            "--checkpoint-every would do nothing here: it needs a still",
        ),
        (
            &["--orbit", "4", "-o", "%d.png", "--checkpoint-every", "5"],
            "--checkpoint-every would do nothing here: it needs a still",
        ),
        (&["--video-quality", "50"], "--video-quality would do nothing here: it needs an .mp4"),
        (&["--ffmpeg"], "--ffmpeg would do nothing here: it needs an .mp4"),
        (&["--orbit", "4", "-o", "%d.png", "--ffmpeg"], "--ffmpeg would do nothing here: it needs an .mp4"),
        (
            &["--orbit", "4", "-o", "%d.png", "--fps", "25"],
            "needs an .mp4, or something that moves by seconds",
        ),
        (&["--max-distance", "4"], "--max-distance would do nothing here: it needs --lighting distance"),
        (&["--accel", "grid", "--builder", "sweep"], "--builder would do nothing here: it needs --accel bvh"),
        (&["--block-size", "544"], "32 to 512"),
        (&["--gpu-paths", "4095"], "4096 to 16777216"),
        (&["--gpu-memory", "1.5G"], "a whole number of bytes, or of K, M, G or T"),
        (&["--backend", "cpu", "--gpu-memory", "1G"], "--gpu-memory would do nothing here: it needs a GPU"),
        (
            &["--gpu-paths", "4096", "--gpu-scheduler", "megakernel"],
            "--gpu-paths would do nothing here: it needs --gpu-scheduler queues or auto",
        ),
        (
            &["--integrator", "path", "--backend", "cpu", "--gpu-paths", "4096"],
            "--gpu-paths would do nothing here: it needs a GPU",
        ),
        (&["--gpu-traversal", "vote", "--accel", "grid"], "one through grid"),
        (&["--gpu-scheduler", "megakernel", "--accel", "grid"], "leave that out, or choose queues"),
        (
            &["--backend", "cpu", "--gpu-scheduler", "queues"],
            "--gpu-scheduler would do nothing here: it needs a GPU",
        ),
        (&["--backend", "cpu", "--block-size", "64"], "--block-size would do nothing here: it needs a GPU"),
        (
            &["--backend", "cpu", "--gpu-traversal", "vote"],
            "--gpu-traversal would do nothing here: it needs a GPU",
        ),
        (&["--threads", "2", "--block-size", "64"], "--block-size would do nothing here: it needs a GPU"),
        (
            &["--simd", "baseline", "--gpu-traversal", "vote"],
            "--gpu-traversal would do nothing here: it needs a GPU",
        ),
        (&["--backend", "cuda", "--tile", "8"], "--tile would do nothing here: it needs the CPU"),
        (&["--backend", "cuda", "--simd", "baseline"], "--simd would do nothing here: it needs the CPU"),
        (
            &["--backend", "cuda", "--scheduler", "scalar"],
            "--scheduler would do nothing here: it needs the CPU",
        ),
        (
            &["--backend", "cuda", "--show", "cost"],
            "--backend cuda would do nothing here: it needs a picture of the scene, not --show",
        ),
        (
            &["--crease", "20", "--normals", "flat"],
            "--crease would do nothing here: it needs --normals auto or generated",
        ),
        (&["--crease", "20", "--preset", "pg1"], "--crease would do nothing here"),
        (&["--rank-timeout", "5"], "--rank-timeout would do nothing here: it needs many processes"),
        (
            &["--exposure", "1", "-o", "a.exr"],
            "--exposure would do nothing here: it needs a picture of the scene",
        ),
        (
            &["--transfer", "linear", "-o", "a.hdr", "-o", "b.exr"],
            "--transfer would do nothing here: it needs a picture of the scene in bytes",
        ),
        (
            &["--tone-curve", "agx", "-o", "a.exr"],
            "--tone-curve would do nothing here: it needs a picture of the scene in bytes",
        ),
        (&["--tone-curve", "filmic"], "neutral"),
        (&["--exposure", "1", "--show", "cost"], "--exposure would do nothing here"),
    ];
    for (flags, words) in bad {
        let usual = ["render", "builtin:cornell", "--size", "8x8", "--light-samples", "1"];
        let output: &[&str] = if flags.contains(&"-o") { &[] } else { &["-o", "a.png"] };
        place.run(&[&usual[..], output, flags].concat()).is_wrong_usage(&[words]);
    }
    assert!(place.names().is_empty());
}

/// Where laws or keys say where the camera is and where it looks, flags cannot.
#[test]
fn a_camera_that_is_led_takes_no_other_place() {
    let place = Place::new();
    let keys = r#"{"eosphor": 2, "camera": {"position": [0, 0, 5], "direction": [0, 0, -1]}, "spheres": [{"center": [1, 0, 0],
        "radius": 1}], "animation": {"frames": 2, "camera": {"keys": {"keys": [{"seconds": 0, "position": [0, 0, 4],
        "look-at": [0, 0, 0]}]}}}}"#;
    fs::write(place.path("keys.json"), keys).unwrap();
    for scene in ["builtin:solids", "keys.json"] {
        let render = |name: &str, more: &[&str]| {
            place.run(&[&["render", scene, "-o", name, "--size", "16x12", "-q"], more].concat())
        };
        for flags in [["--eye", "9,9,9"], ["--look-at", "1,0,0"], ["--direction", "1,0,0"]] {
            render("a.png", &flags).is_wrong_usage(&[flags[0], "would do nothing", "animation"]);
        }
        render("a.ppm", &[]).succeeded();
        for flags in [&["--fov", "20"][..], &["--up", "1,1,0"]] {
            render("b.ppm", flags).succeeded();
            assert_eq!(place.run(&["compare", "a.ppm", "b.ppm"]).code, Some(1), "{scene} {flags:?}");
        }
        render("%d.ppm", &["--orbit", "2", "--eye", "9,9,9"]).succeeded();
    }
}

#[test]
fn scenes_that_cannot_be_read_are_one_line() {
    let place = Place::new();
    fs::write(place.path("bad.json"), "{ \"eosphor\": 2,\n \"nonsense\": }").unwrap();
    fs::write(place.path("binary.obj"), [0u8, 159, 146, 150, 255, 10, 118, 32, 255]).unwrap();
    for (scene, word) in [
        ("none.obj", "none.obj"),
        ("builtin:none", "cornell"),
        ("bad.json", "bad.json:2"),
        ("a.stl", "a.stl"),
        (".", "."),
    ] {
        place.run(&["render", scene, "-o", "a.png"]).failed_with(&[word]);
        place.run(&["info", scene]).failed_with(&[word]);
    }
    assert!(place.run(&["info", "binary.obj"]).code.is_some_and(|code| code < 2));
}

#[test]
fn info_describes_the_scene() {
    let place = Place::new();
    let run = place.run(&["info", "builtin:cornell"]).succeeded();
    assert!(run.stdout.contains("2,188") && run.stdout.contains("hierarchy"), "{}", run.stdout);
    let json = place.run(&["info", "builtin:cornell", "--json"]).succeeded().json();
    assert_eq!(json["triangles"], 2188);
    assert_eq!(json["lights"], 2);
    assert!(json["hierarchy"]["leaves"].as_u64().unwrap() > 1);
}

#[test]
fn cuda_without_a_driver_is_one_clear_line() {
    if std::path::Path::new("/dev/nvidia0").exists() {
        eprintln!("SKIPPED: this machine has a GPU");
        return;
    }
    let place = Place::new();
    place.render("a.png", &["--backend", "cuda"]).failed_with(&["no CUDA"]);
}

#[test]
fn cuda_says_what_it_has_before_it_looks_for_a_driver() {
    let place = Place::new();
    let cuda = |flag, value| place.render("a.png", &["--backend", "cuda", flag, value]);
    cuda("--accel", "bvh8")
        .is_wrong_usage(&["bvh8 is made for", "none, bvh, octree, octree-parametric, grid, kdtree"]);
    cuda("--block-size", "1024").is_wrong_usage(&["--block-size", "32 to 512"]);
    cuda("--block-size", "100").is_wrong_usage(&["blocks of 100 threads"]);
    let arguments = ["--backend", "cuda", "--accel", "grid", "--gpu-traversal", "vote"];
    place.render("a.png", &arguments).is_wrong_usage(&["vote", "one through grid", "choose bvh"]);
}

#[test]
fn cost_is_shown_in_false_colours() {
    let place = Place::new();
    let run = place.render("cost.png", &["--show", "cost", "--json"]).succeeded();
    let json = run.json();
    assert!(json["largest"].as_u64() >= json["brightest"].as_u64() && json["mean"].as_f64().unwrap() > 1.0);
    assert!(run.stderr.contains("the brightest stands for"), "{}", run.stderr);
    // What is shown depends on the hierarchy alone.
    let same = ["--show", "cost", "--threads", "1", "--simd", "baseline", "--tile", "5", "--no-metadata"];
    place.render("a.png", &["--show", "cost", "--no-metadata"]).succeeded();
    place.render("b.png", &same).succeeded();
    assert_eq!(fs::read(place.path("a.png")).unwrap(), fs::read(place.path("b.png")).unwrap());
    let run = place.render("c.png", &["--show", "cost", "--show-max", "7", "--accel", "none"]).succeeded();
    assert!(run.stderr.contains("stands for 7"), "{}", run.stderr);
    place.render("d.png", &["--show-max", "7"]).is_wrong_usage(&["--show"]);
    place.render("d.png", &["--show", "costs"]).is_wrong_usage(&["cost"]);
}

#[test]
fn all_structures_in_a_table() {
    let place = Place::new();
    let run = place.run(&["info", "builtin:cornell", "--accel", "all"]).succeeded();
    assert!(
        ["none", "bvh", "tests/ray", "Mrays/s"].iter().all(|word| run.stdout.contains(word)),
        "{}",
        run.stdout
    );
    let json = place.run(&["info", "builtin:cornell", "--accel", "all", "--json"]).succeeded().json();
    let tests = |row: usize| json[row]["camera_rays"]["tests_a_ray"].as_f64().unwrap();
    assert_eq!([&json[0]["accel"], &json[1]["accel"]], ["none", "bvh"]);
    assert!(tests(0) > tests(1) && tests(1) > 0.0, "{json}");
    let json = place.run(&["info", "builtin:cornell", "--accel", "builders", "--json"]).succeeded().json();
    let rows = json.as_array().unwrap();
    assert_eq!(rows.len(), 2 * 6, "two structures by six builders");
    assert!(rows.iter().all(|row| row["builder"].is_string()), "{json}");
    place.render("a.png", &["--accel", "all"]).is_wrong_usage(&["none", "bvh"]);
}

/// Nothing is lit where nobody wants it.
#[test]
fn headlights_can_be_turned_off() {
    let place = Place::new();
    let is_black = |name: &str| {
        let eosphor::Picture::Bytes(image) = eosphor::Picture::read(&place.path(name)).unwrap() else {
            panic!()
        };
        image.rgba.iter().all(|pixel| pixel[..3] == [0; 3])
    };
    let scene = |lights: &str| {
        let spheres = r#""spheres": [{"center": [0, 0, 0], "radius": 1}]"#;
        let text = format!(r#"{{"eosphor": 2, {lights} {spheres}}}"#);
        std::fs::write(place.path("s.json"), text).unwrap();
    };
    let render = |name: &str, more: &[&str]| {
        let flags = ["render", "s.json", "-o", name, "--size", "16x16"];
        place.run(&[&flags[..], more].concat()).succeeded()
    };
    scene("");
    assert!(render("a.png", &[]).stderr.contains("no light: a headlight") && !is_black("a.png"));
    assert!(!render("b.png", &["--headlight", "off"]).stderr.contains("headlight") && is_black("b.png"));
    scene(r#""settings": {"headlight": false},"#);
    assert!(!render("c.png", &[]).stderr.contains("headlight") && is_black("c.png"));
    assert!(render("d.png", &["--headlight", "on"]).stderr.contains("headlight") && !is_black("d.png"));
    scene(r#""lights": [],"#);
    assert!(!render("e.png", &[]).stderr.contains("headlight") && is_black("e.png"));
    // No preset brings back what the scene does not want. (Grey surroundings are PG1's own.)
    for keys in [r#""lights": [],"#, r#""settings": {"headlight": false},"#] {
        scene(keys);
        for preset in ["eos", "pg1", "course"] {
            let flags = ["--preset", preset, "--background", "0,0,0", "--ambient", "0", "--eye", "0,0,4"];
            let run = render("f.png", &flags);
            assert!(
                !run.stderr.contains("headlight") && is_black("f.png"),
                "{keys} {preset}: {}",
                run.stderr
            );
        }
    }
    scene("");
    for (preset, has_headlight) in [("eos", false), ("pg1", true), ("course", true)] {
        let run = render("g.png", &["--preset", preset, "--eye", "0,0,4"]);
        assert!(run.stderr.contains("headlight") == has_headlight && !is_black("g.png"), "{preset}");
    }
    // The sun comes to the two lights of EOS, not in their place.
    let eos = ["--preset", "eos", "--eye", "0,0,4"];
    let rays =
        |more: &[&str]| render("h.png", &[&eos[..], &["-q", "--json"], more].concat()).json()["rays"].clone();
    assert!(rays(&["--sun", "0,0,-1"])["shadow"].as_u64() > rays(&[])["shadow"].as_u64());
}

#[test]
fn a_missing_file_names_the_nearest() {
    let place = Place::new();
    std::fs::write(place.path("bunny.obj"), "").unwrap();
    let run = place.run(&["render", "buny.obj", "-o", "a.png"]);
    run.failed_with(&["buny.obj: cannot read: No such file", "did you mean bunny.obj?"]);
    // Also where the ending is of no kind that is read, and of pictures and shares.
    std::fs::write(place.path("bunny.png"), "").unwrap();
    std::fs::write(place.path("bunny.share"), "").unwrap();
    let wrong_ending = place.run(&["render", "bunny.oj", "-o", "a.png"]);
    wrong_ending.failed_with(&["bunny.oj: cannot read: No such file", "did you mean bunny.obj?"]);
    place.run(&["compare", "buny.png", "bunny.png"]).failed_with(&["buny.png", "did you mean bunny.png?"]);
    place
        .run(&["merge", "buny.share", "-o", "a.png"])
        .failed_with(&["buny.share", "did you mean bunny.share?"]);
    for command in [&["render", "nothing.obj", "-o", "a.png"][..], &["compare", "x.png", "y.png"]] {
        let run = place.run(command);
        assert!(run.code == Some(1) && !run.stderr.contains("os error"), "{}", run.stderr);
    }
}

/// A texture that is missing names near matches in the warning; one whose name is no UTF-8 is found.
#[cfg(target_os = "linux")]
#[test]
fn textures_of_materials_are_found_by_any_name() {
    use std::os::unix::ffi::OsStrExt;
    let place = Place::new();
    let odd = std::ffi::OsStr::from_bytes(b"holz\xff.ppm");
    fs::write(place.path(".").join(odd), [&b"P6 1 1 255\n"[..], &[255, 0, 0]].concat()).unwrap();
    fs::write(
        place.path("t.obj"),
        "mtllib t.mtl\nusemtl m\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nf 1/1 2/1 3/1\n",
    )
    .unwrap();
    let material = |name: &[u8]| {
        fs::write(place.path("t.mtl"), [b"newmtl m\nKd 1 1 1\nmap_Kd ", name, b"\n"].concat()).unwrap();
    };
    material(b"holz\xff.ppm");
    let info = place.run(&["info", "t.obj", "--json"]).succeeded();
    assert!(info.json()["textures"] == 1 && !info.stdout.contains("missing"), "{}", info.stdout);
    fs::write(place.path("wood.ppm"), "").unwrap();
    material(b"wod.ppm");
    let run = place.run(&["render", "t.obj", "-o", "a.png", "--size", "8x8"]).succeeded();
    assert!(run.stderr.contains("texture \"wod.ppm\" is missing (did you mean wood.ppm?)"), "{}", run.stderr);
}
