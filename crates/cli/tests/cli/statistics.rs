//! `--stats`: what is counted and timed, of stills and animations, and that pictures do not change.

use crate::place::Place;
use serde_json::Value;
use std::fmt::Write;
use std::fs;

/// The numbers of a ray, which do not depend on clocks.
fn counts(rays: &Value) -> Value {
    let mut rays = rays.clone();
    rays.as_object_mut().unwrap().remove("times").expect("times");
    rays
}

fn number(value: &Value, pointer: &str) -> f64 {
    value.pointer(pointer).and_then(Value::as_f64).unwrap_or_else(|| panic!("no number {pointer} in {value}"))
}

/// Of the work of some rays: means are quotients of the sums.
fn assert_means(report: &Value, total_rays: f64) {
    let (nodes, tests) = (number(report, "/rays/nodes_visited"), number(report, "/rays/primitive_tests"));
    let searches = number(report, "/rays/searches");
    for (pointer, expected) in [
        ("/work_per_ray/searches", searches / total_rays),
        ("/work_per_ray/nodes", nodes / total_rays),
        ("/work_per_ray/tests", tests / total_rays),
        ("/work_per_search/nodes", nodes / searches),
        ("/work_per_search/tests", tests / searches),
    ] {
        assert!((number(report, pointer) - expected).abs() < 1e-9, "{pointer}: {report}");
    }
    let times = ["traversal", "intersection"].map(|phase| {
        let nanoseconds = number(report, &format!("/rays/times/{phase}_nanoseconds"));
        let seconds = number(report, &format!("/search_seconds/{phase}"));
        assert!((seconds - nanoseconds * 1e-9).abs() < 1e-9, "{report}");
        nanoseconds
    });
    let mean = number(report, "/work_per_ray/nanoseconds");
    assert!((mean - (times[0] + times[1]) / total_rays).abs() < 1e-6, "{report}");
}

#[test]
fn pictures_are_the_same_and_threads_count_the_same() {
    let place = Place::new();
    let plain = place.render("plain.ppm", &["--json", "-q", "--backend", "cpu"]).succeeded().json();
    assert!(plain["work_per_ray"].is_null() && plain["search_seconds"].is_null());
    assert_eq!([&plain["rays"]["searches"], &plain["rays"]["nodes_visited"]], [0, 0]);
    assert_eq!(plain["rays"]["times"]["traversal_nanoseconds"], 0, "clocks run unasked");
    for accel in ["none", "bvh", "bvh8", "octree", "octree-parametric", "grid", "kdtree"] {
        let run = |threads, name| {
            let flags = ["--stats", "--json", "-q", "--accel", accel, "--threads", threads];
            place.render(name, &flags).succeeded().json()
        };
        let (one, three) = (run("1", "one.ppm"), run("3", "three.ppm"));
        for name in ["one.ppm", "three.ppm"] {
            assert!(
                fs::read(place.path(name)).unwrap() == fs::read(place.path("plain.ppm")).unwrap(),
                "{accel}"
            );
        }
        assert_eq!(counts(&one["rays"]), counts(&three["rays"]), "{accel}");
        assert_eq!(one["total_rays"], plain["total_rays"], "{accel}");
        assert_means(&one, number(&one, "/total_rays"));
    }
}

#[test]
fn the_table_has_work_and_times() {
    let run = Place::new().render("a.png", &["--stats"]).succeeded();
    for words in
        ["a search", "  searches", "  nodes", "  tests", "  nanoseconds", "  traversal", "  intersection"]
    {
        assert!(run.stderr.contains(words), "{words}: {}", run.stderr);
    }
}

#[test]
fn animations_have_each_frame_and_all_together() {
    let place = Place::new();
    let frames = |name: &str, more: &[&str]| {
        let flags = ["--orbit", "3", "--accel", "kdtree", "--json"];
        place.render(name, &[&flags[..], more].concat()).succeeded()
    };
    let plain = frames("a_%d.ppm", &["-q"]).json();
    assert!(plain["by_frame"].is_null() && plain["rays"].is_null());
    let counted = frames("b_%d.ppm", &["--stats", "--threads", "2"]);
    let (shown, json) = (counted.stderr.clone(), counted.json());
    let by_frame = json["by_frame"].as_array().unwrap();
    assert_eq!(by_frame.len(), 3);
    for (k, frame) in by_frame.iter().enumerate() {
        assert_eq!(frame["frame"], k);
        assert_means(frame, number(frame, "/total_rays"));
        let own = |name: &str| fs::read(place.path(&format!("{name}_{k}.ppm"))).unwrap();
        assert!(own("a") == own("b"), "frame {k}");
    }
    for pointer in
        ["/rays/searches", "/rays/primitive_tests", "/rays/camera", "/rays/times/traversal_nanoseconds"]
    {
        let sum: f64 = by_frame.iter().map(|frame| number(frame, pointer)).sum();
        assert_eq!(sum, number(&json, pointer), "{pointer}");
    }
    assert_means(&json, number(&json, "/total_rays"));
    assert_eq!(json["hierarchy"]["structure"], "kdtree");
    assert!(shown.contains("tests/search") && shown.contains("  intersection"), "{shown}");
    // Frames count the same in any company.
    let alone = frames("c_%d.ppm", &["--stats", "--frames", "1", "-q"]).json();
    assert_eq!(counts(&alone["rays"]), counts(&by_frame[1]["rays"]));
}

#[test]
fn what_does_not_count_is_wrong_usage() {
    let place = Place::new();
    let bad: [(&[&str], &str); 5] = [
        (&["--show", "cost"], "--stats would do nothing here: it needs a picture of the scene"),
        (&["--backend", "cpu", "--block-size", "64"], "--block-size would do nothing here: it needs a GPU"),
        (
            &["--gpu-paths", "4096", "--integrator", "path"],
            "--gpu-paths would do nothing here: it needs a render without --stats",
        ),
        (
            &["--gpu-scheduler", "queues"],
            "--gpu-scheduler would do nothing here: it needs a render without --stats",
        ),
        (
            &["--gpu-traversal", "vote"],
            "--gpu-traversal would do nothing here: it needs a render without --stats",
        ),
    ];
    for (flags, words) in bad {
        let run = place.render("a.png", &[&["--stats"], flags].concat());
        run.is_wrong_usage(&[words]);
        assert_eq!(run.stderr.lines().count(), 1, "{}", run.stderr);
    }
    assert!(place.names().is_empty());
}

/// A mesh of 2 · 16 · 16 triangles, placed twice: all that there is are instances.
#[test]
fn a_scene_of_instances_has_a_cost() {
    let place = Place::new();
    let mut obj = String::new();
    for k in 0..17 * 17 {
        let (x, y) = (k % 17, k / 17);
        writeln!(obj, "v {x} {y} {}", (x * y) % 3).unwrap();
    }
    for k in 0..16 * 16 {
        let first = k % 16 + 17 * (k / 16) + 1;
        writeln!(obj, "f {} {} {} {}", first, first + 1, first + 18, first + 17).unwrap();
    }
    fs::write(place.path("grid.obj"), obj).unwrap();
    let scene = r#"{ "eosphor": 2, "meshes": [{ "file": "grid.obj", "name": "grid" }],
        "instances": [{ "mesh": "grid" }, { "mesh": "grid", "transform": { "translate": [40, 0, 0] } }] }"#;
    fs::write(place.path("scene.json"), scene).unwrap();
    let rows = place.run(&["info", "scene.json", "--accel", "all", "--json"]).succeeded().json();
    let rows = rows.as_array().unwrap();
    assert_eq!(rows.len(), 7);
    for row in rows {
        let cost = number(row, "/statistics/sah_cost");
        assert!(cost > 1.0 && cost < 1026.0, "{row}");
    }
}
