//! Animations: numbered files, and going on after an interruption.

use crate::place::Place;
use std::fs;
#[cfg(unix)]
use std::io::{BufRead, BufReader};
use std::path::Path;

/// What all runs have in common.
const COMMON: [&str; 7] = ["builtin:cornell", "--size", "16x12", "--samples", "1", "--light-samples", "1"];

fn still(place: &Place, name: &str, flags: &[&str]) -> crate::place::Run {
    place.run(&[&["render"], &COMMON[..], &["-o", place.path(name).to_str().unwrap()], flags].concat())
}

fn frames(place: &Place, pattern: &str, flags: &[&str]) -> crate::place::Run {
    still(place, pattern, &[&["--orbit", "6"], flags].concat())
}

fn bytes(path: &Path) -> Vec<u8> {
    fs::read(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

#[test]
fn frames_are_the_same_however_many_are_in_work() {
    let place = Place::new();
    frames(&place, "a_%d.ppm", &["--in-flight", "1", "--threads", "1"]).succeeded();
    frames(&place, "b_%03d.ppm", &["--in-flight", "4"]).succeeded();
    let all: Vec<Vec<u8>> = (0..6).map(|k| bytes(&place.path(&format!("a_{k}.ppm")))).collect();
    for (k, frame) in all.iter().enumerate() {
        assert!(*frame == bytes(&place.path(&format!("b_{k:03}.ppm"))), "frame {k}");
        assert!(k == 0 || *frame != all[k - 1], "frame {k} moves");
    }
    // A still is the first frame.
    still(&place, "still.ppm", &[]).succeeded();
    assert!(bytes(&place.path("still.ppm")) == all[0]);
    frames(&place, "some_%d.ppm", &["--frames", "2..4"]).succeeded();
    assert!(bytes(&place.path("some_3.ppm")) == all[3] && !place.path("some_4.ppm").exists());
}

#[test]
fn what_is_done_is_kept_and_what_is_stale_is_refused() {
    let place = Place::new();
    frames(&place, "%d.png", &[]).succeeded();
    let frame = |k: u32| place.path(&format!("{k}.png"));
    let all: Vec<Vec<u8>> = (0..6).map(|k| bytes(&frame(k))).collect();
    // One is gone, one is broken.
    fs::remove_file(frame(2)).unwrap();
    fs::write(frame(4), b"x").unwrap();
    let kept = fs::metadata(frame(3)).unwrap().modified().unwrap();
    let run = frames(&place, "%d.png", &["--resume"]).succeeded();
    assert!(run.stderr.contains("4 of 6 frames are done already"), "{}", run.stderr);
    assert!((0..6).all(|k| bytes(&frame(k)) == all[k as usize]), "byte for byte");
    assert_eq!(fs::metadata(frame(3)).unwrap().modified().unwrap(), kept, "it was not rendered again");
    for (flags, reason) in [
        (&["--seed", "7"][..], "another scene, or with other settings"),
        (&["--orbit", "7"], "another animation"),
        (&["--no-metadata"], "settings of the file"),
    ] {
        let run = frames(&place, "%d.png", &[flags, &["--resume"]].concat());
        assert!(run.code == Some(1) && run.stderr.contains(reason), "{flags:?}: {}", run.stderr);
    }
    assert!((0..6).all(|k| bytes(&frame(k)) == all[k as usize]), "nothing was touched");
}

/// Jobs that know nothing of each other render some frames each, at the same time and into one folder.
#[test]
fn jobs_of_some_frames_each_do_not_disturb_each_other() {
    let place = Place::new();
    frames(&place, "whole_%d.ppm", &[]).succeeded();
    std::thread::scope(|scope| {
        for range in ["0..2", "2..3", "3..6"] {
            let place = &place;
            scope.spawn(move || frames(place, "part_%d.ppm", &["--frames", range]).succeeded());
        }
    });
    for k in 0..6 {
        let [whole, part] = ["whole", "part"].map(|name| bytes(&place.path(&format!("{name}_{k}.ppm"))));
        assert!(whole == part, "frame {k}");
    }
    fs::remove_file(place.path("part_4.ppm")).unwrap();
    let run = frames(&place, "part_%d.ppm", &["--frames", "3..6", "--resume"]).succeeded();
    assert!(run.stderr.contains("2 of 3 frames are done already"), "{}", run.stderr);
    // They have one account of what is done, which counts for all frames together, too.
    let run = frames(&place, "part_%d.ppm", &["--resume"]).succeeded();
    assert!(run.stderr.contains("6 of 6 frames are done already"), "{}", run.stderr);
    fs::rename(place.path("part_%d.ppm.manifest"), place.path("kept")).unwrap();
    assert!(
        bytes(&place.path("kept")) == bytes(&place.path("whole_%d.ppm.manifest")),
        "as one process leaves it"
    );
    assert!(place.names().iter().all(|name| !name.ends_with(".part")), "{:?}", place.names());
}

/// Several processes at one command, and each frame is rendered once.
#[test]
fn shared_frames_are_rendered_once() {
    let place = Place::new();
    frames(&place, "whole_%d.ppm", &[]).succeeded();
    let counts: Vec<u64> = std::thread::scope(|scope| {
        let share = || frames(&place, "part_%d.ppm", &["--share", "--json"]).succeeded().json();
        let all = [scope.spawn(share), scope.spawn(share), scope.spawn(share)];
        all.map(|run| run.join().unwrap()["frames"].as_u64().unwrap()).to_vec()
    });
    assert_eq!(counts.iter().sum::<u64>(), 6, "{counts:?}");
    for k in 0..6 {
        let [whole, part] = ["whole", "part"].map(|name| bytes(&place.path(&format!("{name}_{k}.ppm"))));
        assert!(whole == part, "frame {k}");
    }
    let [whole, part] = ["whole", "part"].map(|name| bytes(&place.path(&format!("{name}_%d.ppm.manifest"))));
    assert!(
        whole == part && place.names().iter().all(|name| !name.ends_with(".part")),
        "{:?}",
        place.names()
    );
}

/// A second process is told who has the frames; it takes nothing away.
#[test]
fn frames_in_work_are_left_alone() {
    let place = Place::new();
    let long = ["--size", "400x400", "--samples", "400", "-q"];
    let output = place.path("a_%d.ppm");
    let arguments =
        [&["render"], &COMMON[..], &["--orbit", "6", "-o", output.to_str().unwrap()], &long].concat();
    let mut first = place.command(&arguments).spawn().unwrap();
    let owner = format!("process {}", first.id());
    let start = std::time::Instant::now();
    while !place.names().iter().any(|name| name.ends_with(".part")) {
        assert!(start.elapsed() < std::time::Duration::from_secs(60), "it never began");
        std::thread::sleep(std::time::Duration::from_millis(5));
    }
    for flags in
        [&[][..], &["--resume"], &["--frames", "2..3"], &["--seed", "7"], &["--seed", "7", "--share"]]
    {
        let run = frames(&place, "a_%d.ppm", &[&long, flags].concat());
        // What can be done meanwhile is said where it can.
        let can_share = !flags.contains(&"--seed");
        assert_eq!(run.stderr.contains("or let both --share them"), can_share, "{}", run.stderr);
        run.failed_with(&["a_%d.ppm.manifest", &owner, "in work: wait for it"]);
    }
    first.kill().unwrap();
    first.wait().unwrap();
    // It is gone, and what it left goes, too.
    frames(&place, "a_%d.ppm", &["--frames", "2..3"]).succeeded();
    assert_eq!(place.names(), ["a_%d.ppm.manifest", "a_2.ppm"]);
}

/// What is said after a signal is what is so.
#[cfg(unix)]
fn interrupted(place: &Place, output: &str, flags: &[&str]) -> String {
    use std::os::unix::fs::PermissionsExt;
    // It takes pictures like the real one.
    fs::write(place.path("ffmpeg"), "#!/bin/sh\ncat > /dev/null\n").unwrap();
    fs::set_permissions(place.path("ffmpeg"), fs::Permissions::from_mode(0o755)).unwrap();
    let path = format!("{}:{}", place.path("").display(), std::env::var("PATH").unwrap());
    let long = ["--orbit", "6", "-o", output, "--size", "400x400", "--samples", "4000", "-v"];
    let arguments = [&["render"], &COMMON[..1], &long, flags].concat();
    let mut command = place.command(&arguments);
    let mut child = command.env("PATH", path).stderr(std::process::Stdio::piped()).spawn().unwrap();
    let mut lines = BufReader::new(child.stderr.take().unwrap()).lines().map(Result::unwrap);
    assert!(lines.any(|line| line.starts_with("rendering")), "it never started");
    // SAFETY: kill only sends a signal; the child has not been waited for, so its number is its own.
    assert_eq!(unsafe { libc::kill(child.id() as i32, libc::SIGTERM) }, 0);
    let last = lines.last().unwrap();
    assert_eq!(child.wait().unwrap().code(), Some(143), "{last}");
    last
}

#[cfg(unix)]
#[test]
fn how_to_go_on_after_a_signal() {
    let place = Place::new();
    let said = interrupted(&place, "a_%d.ppm", &[]);
    assert!(said.ends_with("0 of 6 frames are done: the same with --resume goes on"), "{said}");
    let said = interrupted(&place, "a_%d.ppm", &["--share"]);
    assert!(said.ends_with("0 of 6 frames are done: the same command goes on"), "{said}");
    if cfg!(feature = "video") {
        let said = interrupted(&place, "a.mp4", &[]);
        assert!(said.ends_with("the same with --resume goes on"), "{said}");
        let said = interrupted(&place, "b.mp4", &["--ffmpeg"]);
        assert!(said.contains("none is kept") && !said.contains("--resume"), "{said}");
    }
}

/// The same for shares of a picture.
#[test]
fn shares_make_the_picture() {
    let place = Place::new();
    let share = |output: &str, more: &[&str]| {
        let flags = ["render", "builtin:cornell", "-o", output, "--size", "33x41", "--samples", "2"];
        place.run(&[&flags[..], &["--light-samples", "1"], more].concat())
    };
    for (output, layers) in [("a.png", &[][..]), ("a.exr", &["--layers", "all"])] {
        share(output, layers).succeeded();
        let whole = bytes(&place.path(output));
        fs::remove_file(place.path(output)).unwrap();
        for number in ["1/3", "2/3", "3/3"] {
            share(output, &[layers, &["--tiles", number]].concat()).succeeded();
        }
        place.run(&["merge", "-o", output]).succeeded();
        assert!(bytes(&place.path(output)) == whole, "{output}, byte for byte");
        fs::remove_file(place.path(&format!("{output}.2-of-3.share"))).unwrap();
        place.run(&["merge", "-o", output]).failed_with(&["shares are missing: 2 of 3"]);
    }
    place.run(&["merge", "-o", "none.png"]).failed_with(&["there are no shares of none.png"]);
    for wrong in ["0/3", "4/3", "3", "a/b"] {
        assert_eq!(share("a.png", &["--tiles", wrong]).code, Some(2), "{wrong}");
    }
}

/// And for some of the samples of each pixel.
#[test]
fn samples_make_the_picture() {
    let place = Place::new();
    let share = |output: &str, more: &[&str]| {
        let flags = ["render", "builtin:cornell", "-o", output, "--size", "33x41", "--samples", "9"];
        place.run(&[&flags[..], &["--light-samples", "1"], more].concat())
    };
    for (output, rows) in [("a.png", "41"), ("a.exr", "7"), ("a.jpg", "16")] {
        share(output, &[]).succeeded();
        let whole = bytes(&place.path(output));
        fs::remove_file(place.path(output)).unwrap();
        // Strips of other rows in each; the whole says what the first one was called by.
        for (range, rows) in
            [("4..9", &["--band-rows", rows][..]), ("0..1", &[]), ("1..4", &["--band-rows", "5"])]
        {
            share(output, &[&["--sample-range", range], rows].concat()).succeeded();
        }
        place.run(&["merge", "-o", output]).succeeded();
        assert!(bytes(&place.path(output)) == whole, "{output}, byte for byte");
        let [first, second, third] = ["0-1", "1-4", "4-9"].map(|range| format!("{output}.{range}.sums"));
        let merge = |names: &[&String]| {
            let names: Vec<&str> = names.iter().map(|name| name.as_str()).collect();
            place.run(&[&["merge", "-o", output], &names[..]].concat())
        };
        merge(&[&first, &third]).failed_with(&["samples are missing: 1 to 4 of 9", "--sample-range 1..4"]);
        merge(&[&first, &second]).failed_with(&["samples are missing: 4 to 9 of 9"]);
        share(output, &["--sample-range", "0..2"]).succeeded();
        merge(&[&format!("{output}.0-2.sums"), &second]).failed_with(&["have the same samples"]);
        fs::remove_file(place.path(&format!("{output}.0-2.sums"))).unwrap();
        share(output, &["--sample-range", "0..1", "--seed", "7"]).succeeded();
        merge(&[&first, &second, &third]).failed_with(&["different pictures"]);
        // Half of one.
        let half = bytes(&place.path(&first));
        fs::write(place.path(&first), &half[..half.len() - 100]).unwrap();
        merge(&[&first, &second, &third]).failed_with(&[&first, "not whole", "--resume"]);
        share(output, &["--sample-range", "0..1", "--seed", "7", "--resume"]).succeeded();
        merge(&[&first, &second, &third]).failed_with(&["different pictures"]);
    }
    share("a.png", &["--sample-range", "5..10"]).is_wrong_usage(&["a pixel has 9 samples"]);
    share("a.png", &["--sample-range", "5..5"]).is_wrong_usage(&["as in 0..64"]);
    share("a.png", &["--sample-range", "0..5", "--stats"]).is_wrong_usage(&["--sample-range", "--stats"]);
    share("a.exr", &["--sample-range", "0..5", "--layers", "all"]).is_wrong_usage(&["--layers"]);
}

#[cfg(feature = "video")]
#[test]
fn videos_are_the_same_however_they_were_made() {
    let place = Place::new();
    // The least that the encoder takes.
    let size = &["--size", "16x16"][..];
    frames(&place, "a.mp4", &[size, &["--in-flight", "1"]].concat()).succeeded();
    frames(&place, "b.mp4", &[size, &["--in-flight", "4", "--threads", "1"]].concat()).succeeded();
    assert!(bytes(&place.path("a.mp4")) == bytes(&place.path("b.mp4")));
    let run = frames(&place, "a.mp4", &[size, &["--resume"]].concat()).succeeded();
    assert!(run.stderr.contains("done already"), "{}", run.stderr);
    let run = frames(&place, "a.mp4", &[size, &["--resume", "--seed", "7"]].concat());
    assert!(run.code == Some(1) && run.stderr.contains("another scene"), "{}", run.stderr);
    // What differs is said.
    for (flags, reason) in [
        (&["--frames", "0..3"][..], "with another range of frames: 0..6, not 0..3"),
        (&["--fps", "12"], "with another number of frames a second: 24, not 12"),
        (&["--video-quality", "50"], "with another quality of the video: 90, not 50"),
        (&["--size", "32x16"], "with another size: 16 x 16, not 32 x 16"),
    ] {
        let of_size = if flags[0] == "--size" { &[] } else { size };
        frames(&place, "a.mp4", &[of_size, flags, &["--resume"]].concat())
            .failed_with(&["cannot resume", reason]);
    }
    // Where nothing can be made, nothing is left.
    let before = place.names();
    assert_eq!(frames(&place, "c.mp4", &["--size", "3x3"]).code, Some(2));
    assert_eq!(frames(&place, "/proc/none/c.mp4", size).code, Some(1));
    assert_eq!(place.names(), before);
}

/// Files may have so many blocks (`ulimit -f`): as on a disk that is full, at a size that tests can choose.
#[cfg(all(unix, feature = "video"))]
fn with_small_files(place: &Place, blocks: u32, arguments: &[&str]) -> crate::place::Run {
    let command = format!("ulimit -f {blocks}; exec \"$0\" \"$@\"");
    let mut shell = std::process::Command::new("sh");
    shell.args(["-c", &command, env!("CARGO_BIN_EXE_eosphor")]).args(arguments);
    shell.current_dir(place.path("")).output().unwrap().into()
}

#[cfg(all(unix, feature = "video"))]
#[test]
fn a_disk_without_room_is_said_with_what_is_kept() {
    let place = Place::new();
    let flags = ["--size", "32x32", "--orbit", "30", "--video-quality", "100", "--no-metadata", "-q"];
    let render = |output| [&["render", "builtin:cornell", "-o", output], &COMMON[3..], &flags].concat();
    // Frames fit, a segment of them does not.
    let run = with_small_files(&place, 8, &render("a.mp4"));
    run.failed_with(&["files may not become so large", "a.mp4.part has", "of 30 frames", "--resume goes on"]);
    assert_eq!(place.names(), ["a.mp4.manifest", "a.mp4.part"]);
    place.run(&[&render("a.mp4")[..], &["--resume"]].concat()).succeeded();
    place.run(&render("b.mp4")).succeeded();
    assert!(bytes(&place.path("a.mp4")) == bytes(&place.path("b.mp4")), "byte for byte");
    // No frame fits, or nothing at all: nothing is left that would say nothing.
    let before = place.names();
    for blocks in [2, 0] {
        let run = with_small_files(&place, blocks, &render("c.mp4"));
        assert!(!run.stderr.contains("os error") && !run.stderr.contains("--resume"), "{}", run.stderr);
        run.failed_with(&["files may not become so large"]);
        assert_eq!(place.names(), before, "{blocks}");
    }
    // A sequence keeps the frames that are whole.
    let frames =
        [&["render", "builtin:cornell", "-o", "%d.ppm"], &COMMON[1..], &["--orbit", "2", "-q"]].concat();
    place.run(&[&frames[..], &["--frames", "0..1"]].concat()).succeeded();
    with_small_files(&place, 0, &[&frames[..], &["--resume"]].concat())
        .failed_with(&["files may not become so large"]);
    with_small_files(&place, 1, &[&frames[..], &["--resume"]].concat()).failed_with(&[
        "1.ppm: files may not become so large",
        "1 of 2 frames are done: the same with --resume",
    ]);
}

#[test]
fn what_cannot_be_is_said() {
    let place = Place::new();
    let usage = |pattern: &str, flags: &[&str], reason: &str| {
        let run = frames(&place, pattern, flags);
        assert!(run.code == Some(2) && run.stderr.contains(reason), "{pattern} {flags:?}: {}", run.stderr);
    };
    usage("a.png", &["--frames", "0..2"], "frame_%04d.png");
    usage("%d.png", &["--frame", "2"], "--frames chooses among several");
    usage("%d_%d.png", &[], "frame_%04d.png");
    usage("%d.png", &["--frames", "3..7"], "the animation has 6 frames, 0..6");
    usage("%d.png", &["--frames", "3..3"], "as in 0..120");
    usage("%d.exr", &["--layers", "all"], "for single pictures");
    let pattern = place.path("%d.png");
    let run = place.run(&["render", "builtin:cornell", "-o", pattern.to_str().unwrap()]);
    assert!(run.code == Some(2) && run.stderr.contains("nothing moves"), "{}", run.stderr);
}

/// An object that moves by keys: frames differ, and are those of a run that was interrupted.
#[test]
fn objects_move() {
    let place = Place::new();
    fs::write(place.path("tri.obj"), "v -1 -1 0\nv 1 -1 0\nv 0 1 0\nf 1 2 3\n").unwrap();
    let scene = |x: f32| {
        let text = format!(
            r#"{{"eosphor": 2, "animation": {{"frames": 4, "fps": 4}}, "camera": {{"position": [0, 0, 5], "direction": [0, 0, -1]}},
            "meshes": [{{"file": "tri.obj", "moves": [{{"keys": [
                {{"seconds": 0, "translate": [0, 0, 0]}}, {{"seconds": 1, "translate": [{x}, 0, 0], "scale": 2}}]}}]}}]}}"#
        );
        fs::write(place.path("scene.json"), text).unwrap();
    };
    let render = |pattern: &str, flags: &[&str]| {
        let (scene, output) = (place.path("scene.json"), place.path(pattern));
        let common = ["render", scene.to_str().unwrap(), "-o", output.to_str().unwrap(), "--size", "24x18"];
        place.run(&[&common[..], &["--samples", "1"], flags].concat())
    };
    scene(1.0);
    render("a_%d.ppm", &["--accel", "bvh8", "--in-flight", "1"]).succeeded();
    render("b_%d.ppm", &["--accel", "octree", "--in-flight", "4"]).succeeded();
    let all: Vec<Vec<u8>> = (0..4).map(|k| bytes(&place.path(&format!("a_{k}.ppm")))).collect();
    for (k, frame) in all.iter().enumerate() {
        assert!(*frame == bytes(&place.path(&format!("b_{k}.ppm"))), "frame {k}");
        assert!(k == 0 || *frame != all[k - 1], "frame {k} moves");
    }
    // A single picture shows any of them, by flag or file, and its layers.
    render("still.ppm", &["--frame", "2"]).succeeded();
    assert!(bytes(&place.path("still.ppm")) == all[2]);
    let text = fs::read_to_string(place.path("scene.json")).unwrap();
    fs::write(place.path("scene.json"), text.replacen("{", r#"{"frame": 3, "#, 1)).unwrap();
    render("still.ppm", &[]).succeeded();
    assert!(bytes(&place.path("still.ppm")) == all[3]);
    render("still.exr", &["--layers", "object"]).succeeded();
    for (frame, words) in [("4", "no frame 4; the animation has 0 to 3"), ("6000000", "--frame")] {
        render("no.ppm", &["--frame", frame]).is_wrong_usage(&[words]);
    }
    fs::write(place.path("scene.json"), text).unwrap();
    let still = ["render", "builtin:cornell", "-o", "no.ppm", "--frame", "0"];
    place.run(&still).is_wrong_usage(&["--frame would do nothing here", "a scene with an animation"]);
    fs::remove_file(place.path("a_2.ppm")).unwrap();
    render("a_%d.ppm", &["--resume"]).succeeded();
    assert!(bytes(&place.path("a_2.ppm")) == all[2]);
    // --translate moves what comes out of the motions.
    render("moved_%d.ppm", &["--translate", "0.5,0.25,0"]).succeeded();
    let text = fs::read_to_string(place.path("scene.json")).unwrap();
    let last = r#", {"transform": {"translate": [0.5, 0.25, 0]}}]}]"#;
    fs::write(place.path("scene.json"), text.replace("]}]}]", &format!("]}}{last}"))).unwrap();
    render("said_%d.ppm", &[]).succeeded();
    for k in 0..4 {
        let [moved, said] = ["moved", "said"].map(|name| bytes(&place.path(&format!("{name}_{k}.ppm"))));
        assert!(moved == said && moved != all[k as usize], "frame {k}");
    }
    // Where it goes differently, nothing is kept.
    scene(1.5);
    let run = render("a_%d.ppm", &["--resume"]);
    assert!(run.code == Some(1) && run.stderr.contains("another animation"), "{}", run.stderr);
}
