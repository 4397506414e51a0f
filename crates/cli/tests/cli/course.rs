//! `eosphor course`: the task of PLATO's course from outside.

use crate::place::{Place, Run};
use std::fs;
use std::io::Write;
use std::process::Stdio;

/// The example of the task, with 3 frames of 16 x 12 pixels, depth 3 and 2 x 2 rays a pixel, on a floor of 2 x 2 texels.
const INPUT: &str = "3
out/img_%d.data
16 12 120
7.0 3.0 0.0  2.0 1.0  2.0 6.0 1.0  0.0 0.0
2.0 0.0 0.0  0.5 0.1  1.0 4.0 1.0  0.0 0.0
2.0 0.0 0.0  1.0 0.0 0.0  1.0  0.9 0.1 10
0.0 2.0 0.0  0.0 1.0 0.0  0.75 0.8 0.2 5
0.0 0.0 0.0  0.0 0.7 0.7  0.5  0.7 0.3 2
-5.0 -5.0 -1.0  -5.0 5.0 -1.0  5.0 5.0 -1.0  5.0 -5.0 -1.0  floor.data  0.0 1.0 0.0  0.5
2
-10.0 0.0 10.0  1.0 1.0 1.0
1.0 0.0 10.0  0.0 0.0 1.0
3 2
";

/// Runs it with this on standard input, in a folder that has the floor's texture.
fn course(place: &Place, input: &str, flags: &[&str]) -> Run {
    let mut floor: Vec<u8> = [2i32, 2].iter().flat_map(|side| side.to_le_bytes()).collect();
    floor.extend([250, 200, 150, 255, 90, 60, 30, 255, 90, 60, 30, 255, 250, 200, 150, 255]);
    fs::write(place.path("floor.data"), floor).unwrap();
    let mut command = place.command(&[&["course"], flags].concat());
    command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped());
    let mut child = command.spawn().unwrap();
    // It may have ended before it has read all.
    let _ = child.stdin.take().unwrap().write_all(input.as_bytes());
    child.wait_with_output().unwrap().into()
}

#[test]
fn a_line_and_a_file_for_each_frame() {
    let place = Place::new();
    let run = course(&place, INPUT, &["--cpu"]).succeeded();
    let lines: Vec<Vec<&str>> = run.stdout.lines().map(|line| line.split('\t').collect()).collect();
    assert_eq!(lines.len(), 3, "{}", run.stdout);
    let read = |k: usize| fs::read(place.path(&format!("out/img_{k}.data"))).unwrap();
    for (k, line) in lines.iter().enumerate() {
        let [frame, milliseconds, rays] = line[..] else { panic!("{line:?}") };
        assert_eq!(frame, k.to_string());
        assert!(milliseconds.parse::<f64>().unwrap() > 0.0);
        // At least those of the camera.
        assert!(rays.parse::<u64>().unwrap() >= 16 * 12 * 4);
        let bytes = read(k);
        assert_eq!(bytes.len(), 8 + 16 * 12 * 4);
        assert_eq!(bytes[..8], [16, 0, 0, 0, 12, 0, 0, 0]);
        assert!(bytes[8..].chunks(4).all(|pixel| pixel[3] == 255));
        assert!(bytes[8..].chunks(4).any(|pixel| pixel[..3] != [0; 3]), "not all black");
    }
    assert!(read(0) != read(1));
    let frames: Vec<Vec<u8>> = (0..3).map(read).collect();
    course(&place, INPUT, &["--cpu", "--threads", "1", "--accel", "none"]).succeeded();
    assert!((0..3).all(|k| read(k) == frames[k]), "the same bytes in any way");
    course(&place, INPUT, &["--cpu", "--bodies", "cube,icosahedron,tetrahedron"]).succeeded();
    assert!(read(0) != frames[0], "other bodies");
}

#[test]
fn what_is_done_is_kept() {
    let place = Place::new();
    course(&place, INPUT, &["--cpu"]).succeeded();
    let read = |k: usize| fs::read(place.path(&format!("out/img_{k}.data"))).unwrap();
    let frames: Vec<Vec<u8>> = (0..3).map(read).collect();
    fs::remove_file(place.path("out/img_1.data")).unwrap();
    let run = course(&place, INPUT, &["--cpu", "--resume"]).succeeded();
    assert!(run.stderr.contains("2 of 3 frames are done already"), "{}", run.stderr);
    assert!(run.stdout.starts_with("1\t") && run.stdout.lines().count() == 1, "{}", run.stdout);
    assert!((0..3).all(|k| read(k) == frames[k]));
    let other = course(&place, INPUT, &["--cpu", "--resume", "--bodies", "cube,cube,cube"]);
    other.failed_with(&["cannot resume", "out/img_%d.data.manifest"]);
    // Wherever they are.
    fs::rename(place.path("out"), place.path("moved")).unwrap();
    let moved = course(&place, INPUT, &["--cpu", "--resume", "-o", "./moved/img_%d.data"]).succeeded();
    assert!(moved.stderr.contains("3 of 3 frames are done already"), "{}", moved.stderr);
}

#[test]
fn the_default_runs_as_it_is() {
    let place = Place::new();
    let text = course(&place, "", &["--default"]).succeeded().stdout;
    // Fewer and smaller.
    let mut lines: Vec<&str> = text.lines().collect();
    assert_eq!(lines[0], "104");
    (lines[0], lines[2]) = ("2", "24 16 120");
    let run = course(&place, &lines.join("\n"), &["--cpu"]).succeeded();
    assert_eq!(run.stdout.lines().count(), 2);
}

#[test]
fn wrong_input_is_one_line_that_names_the_place() {
    let place = Place::new();
    for (from, to, words) in [
        ("16 12 120", "16 zwölf 120", ["input:3", "height"]),
        ("0.75 0.8", "-0.75 0.8", ["input:7", "radius"]),
        ("img_%d", "img", ["input:2", "%d"]),
        ("\n3 2\n", "\n3\n", ["standard input", "ends"]),
        ("floor.data", "none.data", ["input:9: texture of the floor", "cannot read"]),
        ("img_%d.data", "img_%d.xyz", ["input:2: output path", "xyz"]),
        ("img_%d.data", "img.mp4", ["input:2: output path", "--output"]),
    ] {
        assert!(INPUT.contains(from));
        let run = course(&place, &INPUT.replacen(from, to, 1), &["--cpu"]);
        assert_eq!((run.code, run.stdout.as_str()), (Some(1), ""), "{to}: {}", run.stderr);
        assert!(words.iter().all(|word| run.stderr.contains(word)), "{to}: {}", run.stderr);
    }
    assert_eq!(course(&place, INPUT, &["--cpu", "--gpu"]).code, Some(2));
    assert_eq!(course(&place, INPUT, &["--bodies", "cube,ball,cube"]).code, Some(2));
}

/// The scene that says in JSON what the course's own input says: the same bytes.
#[test]
fn a_json_scene_says_the_same() {
    let place = Place::new();
    let text = course(&place, "", &["--default"]).succeeded().stdout;
    let mut lines: Vec<&str> = text.lines().collect();
    (lines[1], lines[2]) = ("out/course_%d.data", "48 32 120");
    lines[0] = "3";
    let input = lines.join("\n");
    let scene = fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/../../scenes/solids.json")).unwrap();
    assert!(scene.contains("\"frames\": 104"));
    fs::write(place.path("s.json"), scene.replace("\"frames\": 104", "\"frames\": 3")).unwrap();
    fs::create_dir(place.path("out")).unwrap();
    place.run(&["render", "s.json", "-o", "out/json_%d.data", "--size", "48x32"]).succeeded();
    course(&place, &input, &["--cpu"]).succeeded();
    let read = |name: &str, k: usize| fs::read(place.path(&format!("out/{name}_{k}.data"))).unwrap();
    for k in 0..3 {
        assert!(read("course", k) == read("json", k), "frame {k}");
    }
    assert!(read("json", 0) != read("json", 1));
}

#[cfg(feature = "video")]
#[test]
fn a_video_of_the_flight() {
    let place = Place::new();
    let input = INPUT.replacen("16 12", "17 19", 1);
    let run = course(&place, &input, &["--cpu", "-o", "films/a.mp4", "--fps", "12"]).succeeded();
    assert_eq!(run.stdout.lines().count(), 3, "{}", run.stdout);
    assert!(run.stderr.contains("18 x 20"), "{}", run.stderr);
    let film = fs::read(place.path("films/a.mp4")).unwrap();
    assert!(!place.path("out").exists());
    // However it is made, and what is done stays.
    course(&place, &input, &["--cpu", "-o", "b.mp4", "--fps", "12", "--threads", "1"]).succeeded();
    assert!(fs::read(place.path("b.mp4")).unwrap() == film);
    let again = course(&place, &input, &["--cpu", "-o", "b.mp4", "--fps", "12", "--resume"]).succeeded();
    assert!(again.stderr.contains("done already") && again.stdout.is_empty(), "{}", again.stderr);
    let other = course(&place, &input, &["--cpu", "-o", "b.mp4", "--fps", "12", "--resume", "--edge-lights"]);
    other.failed_with(&["cannot resume", "b.mp4.manifest"]);
    course(&place, &input, &["--cpu", "-o", "b.mp4", "--video-quality", "20"]).succeeded();
    assert!(fs::read(place.path("b.mp4")).unwrap() != film);
    for flags in [&["--fps", "12"][..], &["--video-quality", "20"], &["--ffmpeg", "-o", "a_%d.png"]] {
        course(&place, &input, flags).is_wrong_usage(&[flags[0], "an .mp4"]);
    }
}

/// The encoder takes no fewer than 16 x 16 pixels.
#[cfg(feature = "video")]
#[test]
fn a_video_of_one_pixel_is_refused_in_one_line() {
    let place = Place::new();
    let before = place.names();
    let run = place.run(&["render", "builtin:solids", "-o", "a.mp4", "--frames", "0..2", "--size", "1x1"]);
    assert_eq!((run.code, run.stderr.lines().count()), (Some(2), 1), "{}", run.stderr);
    assert!(run.stderr.contains("1 x 1 pixels: the encoder takes 16 x 16 to 3840 x 2160"), "{}", run.stderr);
    assert_eq!(place.names(), before);
}

#[test]
fn frames_go_where_a_flag_says() {
    let place = Place::new();
    course(&place, INPUT, &["--cpu", "-o", "there/%d.png"]).succeeded();
    assert!(place.path("there/2.png").exists() && !place.path("out").exists());
    course(&place, INPUT, &["--cpu", "-o", "a.png"]).is_wrong_usage(&["a.png", "%d"]);
    course(&place, INPUT, &["--cpu", "-o", "%d.tga"]).is_wrong_usage(&["0.tga", "unknown picture format"]);
}

/// Folders are made for frames, and none for an input that is wrong.
#[test]
fn only_right_input_makes_folders() {
    let place = Place::new();
    fs::write(place.path("file"), "").unwrap();
    let input = INPUT.replacen("out/", "new/a/", 1);
    for (from, to) in [
        ("16 12 120", "16 0 120"),
        ("floor.data", "none.data"),
        ("img_%d.data", "img_%d.xyz"),
        ("new/a/", "file/a/"),
    ] {
        let run = course(&place, &input.replacen(from, to, 1), &["--cpu"]);
        assert_eq!(run.code, Some(1), "{to}: {}", run.stderr);
        assert_eq!(place.names(), ["file", "floor.data"], "{to}");
    }
    course(&place, INPUT, &["--cpu", "-o", "new/a/%d.tga"]).is_wrong_usage(&["tga"]);
    assert_eq!(place.names(), ["file", "floor.data"]);
    course(&place, &input, &["--cpu"]).succeeded();
    assert!(place.path("new/a/img_2.data").is_file());
}

/// Without bodies and lights nothing shines: a headlight is added, and this is said.
#[test]
fn a_headlight_is_spoken_of() {
    let place = Place::new();
    let dark = INPUT.replacen("2\n-10.0 0.0 10.0  1.0 1.0 1.0\n1.0 0.0 10.0  0.0 0.0 1.0\n", "0\n", 1);
    assert_ne!(dark, INPUT);
    let run = course(&place, &dark, &["--cpu", "--bodies", "none,none,none"]).succeeded();
    assert!(run.stderr.contains("note: no light: a headlight"), "{}", run.stderr);
    let run = course(&place, INPUT, &["--cpu"]).succeeded();
    assert!(!run.stderr.contains("headlight"), "{}", run.stderr);
}

/// Numbered frames are Unicode; videos need not be.
#[cfg(target_os = "linux")]
#[test]
fn frames_of_no_unicode_are_wrong_usage() {
    use std::os::unix::ffi::OsStrExt;
    let place = Place::new();
    let output = std::ffi::OsStr::from_bytes(b"\xff_%d.png");
    let mut command = place.command(&["course", "--cpu", "-o"]);
    let input = place.path("input");
    fs::write(&input, INPUT).unwrap();
    let run: Run = command.arg(output).stdin(fs::File::open(input).unwrap()).output().unwrap().into();
    run.is_wrong_usage(&["-o: \u{fffd}_%d.png", "must be Unicode"]);
    assert_eq!(place.names(), ["input"]);
}

/// Frames that are whole are kept, and it is said how to go on.
#[test]
fn a_frame_that_cannot_be_written_leaves_the_others() {
    let place = Place::new();
    course(&place, INPUT, &["--cpu"]).succeeded();
    fs::remove_file(place.path("out/img_1.data")).unwrap();
    fs::create_dir(place.path("out/img_1.data")).unwrap();
    let run = course(&place, INPUT, &["--cpu", "--resume"]);
    assert_eq!(run.code, Some(1), "{}", run.stderr);
    let end = "img_1.data: this is a folder; add a file name; 2 of 3 frames are done: the same with --resume goes on\n";
    assert!(run.stderr.ends_with(end), "{}", run.stderr);
}
