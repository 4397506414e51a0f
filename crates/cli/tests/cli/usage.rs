//! Exit codes: 2 for wrong usage, 1 for work that failed. Every flag is gone through in `src/arguments/tests.rs`.

use crate::place::Place;
use std::fs;

/// Every command, with what it needs at least.
const COMMANDS: [&[&str]; 17] = [
    &["render", "builtin:cornell", "-o", "a.png"],
    &["course", "--default"],
    &["info", "builtin:cornell"],
    &["compare", "a.png", "b.png"],
    &["merge", "-o", "a.png"],
    &["bench", "rays", "builtin:cornell"],
    &["bench", "render", "builtin:cornell"],
    &["bench", "noise", "builtin:cornell"],
    &["lab", "list"],
    &["lab", "report"],
    &["lab", "compare", "a", "b"],
    &["lab", "schema"],
    &["view", "builtin:cornell", "--no-open"],
    &["devices"],
    &["schema"],
    &["completions", "bash"],
    &["help", "render"],
];

#[test]
fn unknown_flags_and_arguments_are_wrong_usage() {
    let place = Place::new();
    for command in &COMMANDS[..16] {
        place.run(&[command, &["--nonsense"][..]].concat()).is_wrong_usage(&["--nonsense"]);
        // Those take any number of files.
        if command[0] != "merge" && command != &["lab", "report"] {
            place.run(&[command, &["too-much"][..]].concat()).is_wrong_usage(&["too-much"]);
        }
    }
    // None is missing above.
    let help = place.run(&["--help"]).succeeded().stdout;
    let (_, commands) = help.split_once("Commands:\n").unwrap();
    for line in commands.lines().take_while(|line| line.starts_with("  ")) {
        let name = line.split_whitespace().next().unwrap();
        assert!(COMMANDS.iter().any(|command| command[0] == name), "{name}");
    }
    for wrong in [
        &["nonsense"][..],
        &[],
        &["bench"],
        &["bench", "nonsense"],
        &["render"],
        &["compare", "a.png"],
        &["merge"],
    ] {
        assert_eq!(place.run(wrong).code, Some(2), "{wrong:?}");
    }
    assert!(place.names().is_empty());
}

/// A dash does not make another flag of a number: the range is said.
#[test]
fn negative_numbers_are_values() {
    let place = Place::new();
    for (flag, range) in [
        ("--samples", "1 to 65536"),
        ("--depth", "0 to 64"),
        ("--size", "1 to 65535"),
        ("--threads", "1 to 1024"),
        ("--checkpoint-every", "1 to 86400"),
        ("--fov", "over 0 and under 180"),
        ("--frames", "0..120"),
        ("--seed", "0 to 4294967295"),
    ] {
        let run = place.run(&["render", "builtin:cornell", "-o", "a.png", flag, "-3x1"]);
        run.is_wrong_usage(&["'-3x1'", flag, range]);
        let run = place.run(&["render", "builtin:cornell", "-o", "a.png", flag, "-3"]);
        run.is_wrong_usage(&["'-3'", flag, if flag == "--size" { "800x600" } else { range }]);
    }
}

/// Flags that cannot be meant exit with 2 wherever that is found out; what a file's content makes fail exits with 1.
#[test]
fn what_flags_make_fail_is_wrong_usage() {
    let place = Place::new();
    fs::write(place.path("t.obj"), "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n").unwrap();
    fs::write(place.path("t.gltf"), r#"{"asset": {"version": "2.0"}}"#).unwrap();
    let before = place.names();
    let render = |more: &[&str]| {
        place.run(&[&["render", "builtin:cornell", "-o", "a.png", "--size", "8x8"], more].concat())
    };
    render(&["--up", "0,0,0"]).is_wrong_usage(&["camera", "up"]);
    render(&["--eye", "1,2,3", "--look-at", "1,2,3"]).is_wrong_usage(&["camera", "look-at"]);
    render(&["--direction", "0,0,0"]).is_wrong_usage(&["camera", "direction"]);
    for scene in ["t.obj", "t.gltf"] {
        for command in [&["render", scene, "-o", "a.png"][..], &["bench", "render", scene]] {
            place.run(&[command, &["--camera", "1"]].concat()).is_wrong_usage(&[scene, "camera"]);
        }
    }
    for command in [
        &["render", "builtin:cornell", "-o", "x.tga"][..],
        &["render", "builtin:cornell", "-o", "x_%d.tga", "--orbit", "2"],
        &["compare", "a.png", "b.png", "--diff", "x.tga"],
        &["merge", "a.share", "-o", "x.tga"],
    ] {
        place.run(command).is_wrong_usage(&["unknown picture format", ".png"]);
    }
    #[cfg(feature = "video")]
    for size in ["1x1", "5000x5000"] {
        let command = ["render", "builtin:solids", "-o", "a.mp4", "--frames", "0..2", "--size", size];
        place.run(&command).is_wrong_usage(&["--size", "the encoder takes 16 x 16 to 3840 x 2160"]);
    }
    assert_eq!(place.names(), before);

    let scene = |keys: &str| {
        let text = format!(r#"{{"eosphor": 2, {keys} "spheres": [{{"center": [0, 0, 0], "radius": 1}}]}}"#);
        fs::write(place.path("s.json"), text).unwrap();
    };
    scene(r#""camera": {"position": [0, 0, 5], "look-at": [0, 0, 5]},"#);
    place.run(&["render", "s.json", "-o", "a.png"]).failed_with(&["s.json:1"]);
    scene(r#""output": "x.tga","#);
    place.run(&["render", "s.json"]).failed_with(&["s.json: output: unknown picture format"]);
    #[cfg(feature = "video")]
    {
        scene(r#""settings": {"size": [1, 1]}, "animation": {"frames": 2},"#);
        place.run(&["render", "s.json", "-o", "a.mp4", "-q"]).failed_with(&["the encoder takes 16 x 16"]);
    }
}

/// What looks at a scene and measures takes no flag in vain either.
#[test]
fn flags_about_devices_are_never_ignored() {
    let place = Place::new();
    let check = |command: &[&str], flags: &[&str]| {
        place.run(&[command, flags].concat()).is_wrong_usage(&[flags[0], "would do nothing"]);
    };
    let info = ["info", "builtin:cornell"];
    for flags in [
        &["--tile", "8"][..],
        &["--block-size", "64"],
        &["--gpu-paths", "4096"],
        &["--gpu-memory", "1G"],
        &["--gpu-scheduler", "queues"],
        &["--gpu-traversal", "vote"],
        &["--scheduler", "scalar"],
        &["--simd", "baseline"],
    ] {
        check(&info, flags);
    }
    for flags in
        [&["--builder", "morton"][..], &["--leaf-size", "4"], &["--tree-depth", "9"], &["--sah-costs", "1,1"]]
    {
        check(&[&info[..], &["--accel", "builders"]].concat(), flags);
    }
    for table in ["all", "builders"] {
        check(&[&info[..], &["--accel", table]].concat(), &["--backend", "cuda"]);
    }
    for (flag, value, range) in [
        ("--leaf-size", "300", "with a bvh to 255"),
        ("--sah-costs", "-5,-1", "0 or more"),
        ("--tree-depth", "50", "1 to 16 with an octree"),
    ] {
        let run = place.run(&[&info[..], &["--accel", "all", flag, value]].concat());
        run.is_wrong_usage(&[flag, "it must be", range]);
    }
    let rays = ["bench", "rays", "builtin:cornell", "--size", "8x8", "--repeats", "1"];
    for flags in [
        &["--block-size", "64"][..],
        &["--gpu-paths", "4096"],
        &["--gpu-memory", "1G"],
        &["--gpu-scheduler", "queues"],
        &["--gpu-traversal", "vote"],
        &["--tile", "8"],
        &["--scheduler", "scalar"],
    ] {
        check(&rays, flags);
    }
    // GPUs alone have stages, and kernels that do everything have none.
    let render = ["bench", "render", "builtin:cornell", "--phases", "--backend"];
    for (device, needs) in [
        (&["cpu"][..], "--backend cuda"),
        (&["cuda", "--gpu-scheduler", "megakernel"], "--gpu-scheduler queues"),
    ] {
        let run = place.run(&[&render[..], device].concat());
        run.is_wrong_usage(&["--phases would do nothing", needs]);
    }
    for flags in [&["--cpu"][..], &["--edge-lights"], &["-o", "a_%d.png"], &["--threads", "1"]] {
        let run = place.run(&[&["course", "--default"], flags].concat());
        run.is_wrong_usage(&["--default", "cannot be used with"]);
    }
}

#[test]
fn what_is_missing_has_failed() {
    let place = Place::new();
    fs::write(place.path("scene.json"), "{}").unwrap();
    for command in [
        &["render", "scene.jsno", "-o", "a.png"][..],
        &["info", "scene.jsno"],
        &["bench", "rays", "scene.jsno"],
        &["bench", "render", "scene.jsno"],
    ] {
        // The ending is of no kind that is read, but nothing is there to be read either.
        place.run(command).failed_with(&["scene.jsno"]);
    }
    for command in [
        &["render", "scnee.json", "-o", "a.png"][..],
        &["info", "scnee.json"],
        &["bench", "rays", "scnee.json"],
        &["bench", "render", "scnee.json"],
    ] {
        place.run(command).failed_with(&["scnee.json: cannot read", "did you mean scene.json?"]);
    }
    for command in [&["render", "builtin:cornel", "-o", "a.png"][..], &["info", "builtin:cornel"]] {
        place.run(command).failed_with(&["built-in", "cornell"]);
    }
    place.run(&["compare", "a.png", "b.png"]).failed_with(&["a.png", "no such file"]);
    place.run(&["merge", "a.share", "-o", "a.png"]).failed_with(&["a.share", "no such file"]);
    place.run(&["merge", "-o", "a.png"]).failed_with(&["there are no shares of a.png"]);
    assert_eq!(place.names(), ["scene.json"]);
}
