//! Interruptions, orders, threads and damage: none of them changes the file.

use super::*;

const SIZE: (u32, u32) = (48, 34);

#[test]
fn the_same_frames_are_the_same_bytes_in_any_order_and_from_any_threads() {
    let expected = undisturbed(SIZE, 71);
    assert_eq!(undisturbed(SIZE, 71), expected);
    for threads in [1, 2, 5] {
        let (_folder, path) = in_folder();
        let video = open(&path, SIZE, 71, threads);
        std::thread::scope(|scope| {
            let video = &video;
            for start in 0..3 {
                // Backwards, every third; the first thread writes some that others write too.
                scope.spawn(move || {
                    for number in (0..71).rev().filter(|n| n % 3 == start || (start == 0 && n % 10 == 0)) {
                        video.write_frame(number, &frame(number, SIZE)).unwrap();
                    }
                });
            }
        });
        assert!(video.missing_frames().is_empty());
        video.finish().unwrap();
        assert!(fs::read(&path).unwrap() == expected, "{threads} threads");
    }
}

#[test]
fn a_run_may_end_after_every_frame() {
    let expected = undisturbed(SIZE, 64);
    let (folder, path) = in_folder();
    // Out of order, so that segments are complete late and early.
    let order: Vec<u32> = (0..64).map(|i| i * 37 % 64).collect();
    let mut left: Vec<u32> = (0..64).collect();
    for &number in &order {
        let video = open(&path, SIZE, 64, 2);
        assert_eq!(video.missing_frames(), left, "nothing that was stored is asked for again");
        video.write_frame(number, &frame(number, SIZE)).unwrap();
        left.retain(|&n| n != number);
        drop(video);
        assert!(!path.exists());
    }
    // The last run may end before it has encoded or joined anything, any number of times.
    for _ in 0..3 {
        drop(open(&path, SIZE, 64, 2));
    }
    let video = open(&path, SIZE, 64, 2);
    assert!(video.missing_frames().is_empty());
    video.finish().unwrap();
    assert!(fs::read(&path).unwrap() == expected);
    assert_eq!(names(folder.path()), ["a.mp4"]);
}

/// Nobody may see there what he may not see in the video.
#[cfg(unix)]
#[test]
fn frames_are_for_those_who_may_see_the_video() {
    use std::os::unix::fs::PermissionsExt;
    let (_folder, path) = in_folder();
    for (mode, of_folder) in [(0o600, 0o700), (0o640, 0o750), (0o444, 0o755)] {
        fs::write(&path, "old").unwrap();
        fs::set_permissions(&path, fs::Permissions::from_mode(mode)).unwrap();
        let video = open(&path, SIZE, 2, 1);
        assert_eq!(fs::metadata(video.folder()).unwrap().permissions().mode() & 0o777, of_folder, "{mode:o}");
        drop(video);
        VideoWriter::discard(&path).unwrap();
    }
}

/// What a killed program leaves: files that were being written, and frames whose segment is written.
#[test]
fn what_a_killed_program_leaves_is_tidied_up() {
    let expected = undisturbed(SIZE, 35);
    let (_folder, path) = in_folder();
    let video = open(&path, SIZE, 35, 1);
    for number in 0..32 {
        video.write_frame(number, &frame(number, SIZE)).unwrap();
    }
    wait_for(&video, 30);
    let inside = video.folder().to_owned();
    drop(video);
    let there = names(&inside);
    assert_eq!(
        there,
        ["frame-0000030.png", "frame-0000031.png", "lock", "segment-000000.h264", "settings.json"]
    );
    fs::write(inside.join(".eosphor-abc.part"), b"half a frame").unwrap();
    fs::copy(inside.join("frame-0000030.png"), inside.join("frame-0000003.png")).unwrap();
    fs::write(inside.join("manifest.json"), b"the caller's").unwrap();
    let done = path.with_extension("mp4.done");
    fs::create_dir(&done).unwrap();
    fs::copy(inside.join("settings.json"), done.join("settings.json")).unwrap();
    let video = open(&path, SIZE, 35, 1);
    assert_eq!(video.missing_frames(), [32, 33, 34]);
    let left: Vec<String> = there.iter().cloned().chain(["manifest.json".into()]).collect();
    assert_eq!(names(&inside).len(), left.len());
    assert!(left.iter().all(|name| inside.join(name).exists()));
    assert!(!done.exists());
    for number in video.missing_frames() {
        video.write_frame(number, &frame(number, SIZE)).unwrap();
    }
    video.finish().unwrap();
    assert!(fs::read(&path).unwrap() == expected);
    assert!(!inside.exists());
}

#[test]
fn damaged_files_are_asked_for_again() {
    let expected = undisturbed(SIZE, 62);
    type Damage = fn(&Path);
    let damages: [Damage; 4] = [
        |path| fs::write(path, b"").unwrap(),
        |path| fs::OpenOptions::new().write(true).open(path).unwrap().set_len(99).unwrap(),
        |path| {
            let mut bytes = fs::read(path).unwrap();
            let middle = bytes.len() / 2;
            bytes[middle] ^= 4;
            fs::write(path, bytes).unwrap();
        },
        |path| fs::remove_file(path).unwrap(),
    ];
    for damage in damages {
        let (_folder, path) = in_folder();
        let video = open(&path, SIZE, 62, 1);
        for number in (0..61).filter(|&number| number != 31) {
            video.write_frame(number, &frame(number, SIZE)).unwrap();
        }
        wait_for(&video, 30);
        let inside = video.folder().to_owned();
        drop(video);
        damage(&inside.join("segment-000000.h264"));
        damage(&inside.join("frame-0000044.png"));
        let video = open(&path, SIZE, 62, 1);
        assert_eq!(video.missing_frames(), Vec::from_iter((0..30).chain([31, 44, 61])));
        for number in video.missing_frames() {
            video.write_frame(number, &frame(number, SIZE)).unwrap();
        }
        video.finish().unwrap();
        assert!(fs::read(&path).unwrap() == expected);
    }
}

#[test]
fn a_frame_of_another_size_in_the_folder_is_asked_for_again() {
    let (_folder, path) = in_folder();
    let video = open(&path, SIZE, 2, 1);
    video.write_frame(0, &frame(0, SIZE)).unwrap();
    let file = video.folder().join("frame-0000000.png");
    drop(video);
    super::super::frame::write(&file, &frame(0, (34, 48))).unwrap();
    assert_eq!(open(&path, SIZE, 2, 1).missing_frames(), [0, 1]);
}

#[test]
fn a_video_of_other_settings_is_refused() {
    let (_folder, path) = in_folder();
    drop(open(&path, SIZE, 40, 1));
    let other = |size, rate: &str, frames, quality| {
        let options = VideoOptions { quality, ..options(1) };
        VideoWriter::open(&path, size, rate.parse().unwrap(), frames, &options)
    };
    let cases = [
        (other((34, 48), "29.97", 40, 90), "another size 48 x 34 instead of 34 x 48"),
        (other(SIZE, "30", 40, 90), "another frames a second 30000/1001 instead of 30"),
        (other(SIZE, "29.97", 41, 90), "another number of frames 40 instead of 41"),
        (other(SIZE, "29.97", 40, 91), "another quality 90 instead of 91"),
    ];
    for (result, expected) in cases {
        let error = refused(result);
        assert!(error.contains(expected) && error.contains("a.mp4.part"), "{error}");
    }
    assert!(other(SIZE, "29.97", 40, 90).is_ok());
    VideoWriter::discard(&path).unwrap();
    VideoWriter::discard(&path).unwrap();
    assert!(other(SIZE, "30", 41, 81).is_ok());
}

#[test]
fn two_programs_do_not_write_one_video() {
    let (_folder, path) = in_folder();
    let video = open(&path, SIZE, 2, 1);
    let second = refused(VideoWriter::open(&path, SIZE, rate(), 2, &options(1)));
    assert!(second.contains("another program"), "{second}");
    assert!(VideoWriter::discard(&path).is_err());
    drop(video);
    open(&path, SIZE, 2, 1);
}

#[test]
fn folders_of_others_are_left_alone() {
    let (_folder, path) = in_folder();
    let taken = path.with_extension("mp4.part");
    fs::create_dir(&taken).unwrap();
    fs::write(taken.join("letters.txt"), b"mine").unwrap();
    let error = refused(VideoWriter::open(&path, SIZE, rate(), 2, &options(1)));
    assert!(error.contains("no video was made in it"), "{error}");
    assert!(VideoWriter::discard(&path).is_err());
    assert_eq!(fs::read(taken.join("letters.txt")).unwrap(), b"mine");
    fs::remove_dir_all(&taken).unwrap();
    fs::write(&taken, b"a file").unwrap();
    assert!(refused(VideoWriter::open(&path, SIZE, rate(), 2, &options(1))).contains("it is a file"));
    fs::remove_file(&taken).unwrap();
    // Killed after it made the folder, before it wrote the settings.
    fs::create_dir(&taken).unwrap();
    fs::write(taken.join(".eosphor-x.part"), b"{").unwrap();
    assert_eq!(open(&path, SIZE, 2, 1).missing_frames(), [0, 1]);
}

#[test]
fn misuse_is_an_error() {
    let (folder, path) = in_folder();
    let at = |name: &str| VideoWriter::open(&folder.path().join(name), SIZE, rate(), 2, &options(1));
    assert!(refused(at("a.avi")).contains("ends in .mp4"));
    assert!(refused(at("no/a.mp4")).contains("no such file or folder"));
    assert!(refused(VideoWriter::open(&path, (5000, 5000), rate(), 2, &options(1))).contains("3840 x 2160"));
    assert!(refused(VideoWriter::open(&path, SIZE, rate(), 0, &options(1))).contains("0 frames"));
    let video = open(&path, SIZE, 2, 1);
    assert!(video.write_frame(2, &frame(0, SIZE)).unwrap_err().to_string().contains("no frame 2"));
    assert!(video.write_frame(0, &frame(0, (34, 48))).unwrap_err().to_string().contains("34 x 48"));
    let short = Developed { rgb: vec![1, 2, 3], ..frame(0, SIZE) };
    assert!(video.write_frame(0, &short).is_err());
    video.write_frame(1, &frame(1, SIZE)).unwrap();
    assert!(video.finish().unwrap_err().to_string().contains("1 of its frames are missing"));
    assert_eq!(open(&path, SIZE, 2, 1).missing_frames(), [0], "what was stored stays");
}

#[test]
fn what_goes_wrong_in_the_background_is_said() {
    let (_folder, path) = in_folder();
    let video = open(&path, SIZE, 30, 1);
    for number in 0..29 {
        video.write_frame(number, &frame(number, SIZE)).unwrap();
    }
    let file = video.folder().join("frame-0000007.png");
    fs::write(&file, b"not a frame any more").unwrap();
    video.write_frame(29, &frame(29, SIZE)).unwrap();
    let error = video.finish().unwrap_err().to_string();
    assert!(error.contains("frame-0000007.png"), "{error}");
    // The next run asks for it.
    let video = open(&path, SIZE, 30, 1);
    assert_eq!(video.missing_frames(), [7]);
    video.write_frame(7, &frame(7, SIZE)).unwrap();
    video.finish().unwrap();
    assert!(fs::read(&path).unwrap() == undisturbed(SIZE, 30));
}

/// Where the child of the test below writes to.
const CHILD: &str = "EOSPHOR_TEST_VIDEO";

const CHILD_FRAMES: u32 = 70;

/// Not a test: what the test below kills.
#[test]
#[ignore = "a part of killed_at_any_moment_nothing_is_lost"]
fn child_that_is_killed() {
    use std::io::Write;
    let Some(path) = std::env::var_os(CHILD).map(PathBuf::from) else { return };
    let mut log = fs::File::options().create(true).append(true).open(path.with_extension("log")).unwrap();
    let video = open(&path, SIZE, CHILD_FRAMES, 2);
    for number in video.missing_frames() {
        video.write_frame(number, &frame(number, SIZE)).unwrap();
        log.write_all(format!("{number}\n").as_bytes()).unwrap();
    }
    video.finish().unwrap();
}

#[test]
fn killed_at_any_moment_nothing_is_lost() {
    let expected = undisturbed(SIZE, CHILD_FRAMES);
    let (_folder, path) = in_folder();
    let test = "output::video::tests::resume::child_that_is_killed";
    let mut killed = 0;
    loop {
        let mut child = std::process::Command::new(std::env::current_exe().unwrap())
            .args(["--exact", test, "--ignored"])
            .env(CHILD, &path)
            .stdout(std::process::Stdio::null())
            .spawn()
            .unwrap();
        // Later each time, or a slow machine would never come to an end.
        std::thread::sleep(std::time::Duration::from_millis(10 + 3 * killed));
        child.kill().unwrap();
        let success = child.wait().unwrap().success();
        // It may be killed when all is done but to end.
        if success || (path.exists() && !path.with_extension("mp4.part").exists()) {
            break;
        }
        killed += 1;
        assert!(killed < 500, "it does not get on");
    }
    eprintln!("killed {killed} times");
    assert!(fs::read(&path).unwrap() == expected);
    let log = fs::read_to_string(path.with_extension("log")).unwrap();
    let mut written: Vec<&str> = log.lines().collect();
    let all = written.len();
    written.sort();
    written.dedup();
    assert_eq!(written.len(), all, "nothing that was stored is asked for again");
}
