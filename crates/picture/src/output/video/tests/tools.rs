//! What other programs say, where they are installed; and `ffmpeg` as a way to write.

use super::*;
use std::process::Command;

fn is_installed(program: &str) -> bool {
    let found = Command::new(program).arg("-version").output().is_ok_and(|output| output.status.success());
    if !found {
        eprintln!("SKIPPED: {program} is not installed");
    }
    found
}

fn probe(path: &Path) -> String {
    let output = Command::new("ffprobe")
        .args(["-v", "error", "-count_frames", "-show_entries"])
        .arg(
            "stream=codec_name,width,height,pix_fmt,color_range,color_space,color_transfer,color_primaries,\
             r_frame_rate,avg_frame_rate,nb_frames,nb_read_frames",
        )
        .args(["-of", "default=noprint_wrappers=1"])
        .arg(path)
        .output()
        .unwrap();
    assert_eq!(String::from_utf8_lossy(&output.stderr), "");
    String::from_utf8(output.stdout).unwrap()
}

const EXPECTED: [&str; 12] = [
    "codec_name=h264",
    "width=50",
    "height=34",
    "pix_fmt=yuv420p",
    "color_range=tv",
    "color_space=bt709",
    "color_transfer=bt709",
    "color_primaries=bt709",
    "r_frame_rate=30000/1001",
    "avg_frame_rate=30000/1001",
    "nb_frames=65",
    "nb_read_frames=65",
];

#[test]
fn ffprobe_agrees() {
    if !is_installed("ffprobe") {
        return;
    }
    let (_folder, path) = in_folder();
    fs::write(&path, undisturbed((49, 33), 65)).unwrap();
    let said = probe(&path);
    assert!(EXPECTED.iter().all(|line| said.lines().any(|said| said == *line)), "{said}");
}

/// ffmpeg's decoder and its conversion, which know nothing of ours.
#[test]
fn ffmpeg_gives_back_the_colours() {
    if !is_installed("ffmpeg") {
        return;
    }
    let size = (96, 64);
    let (_folder, path) = in_folder();
    fs::write(&path, undisturbed(size, 31)).unwrap();
    assert_near(&path, size, 31);
}

fn assert_near(path: &Path, size: (u32, u32), frames: u32) {
    let output = Command::new("ffmpeg")
        .args(["-v", "error", "-i"])
        .arg(path)
        .args([
            "-vf",
            "scale=flags=accurate_rnd+full_chroma_int+bicubic",
            "-f",
            "rawvideo",
            "-pix_fmt",
            "rgb24",
            "-",
        ])
        .output()
        .unwrap();
    assert_eq!(String::from_utf8_lossy(&output.stderr), "");
    let length = (size.0 * size.1 * 3) as usize;
    assert_eq!(output.stdout.len(), length * frames as usize);
    for (number, decoded) in (0..).zip(output.stdout.chunks(length)) {
        let written = frame(number, size).rgb;
        let squares: f64 = written.iter().zip(decoded).map(|(a, b)| (*a as f64 - *b as f64).powi(2)).sum();
        let decibel = 10.0 * (255.0 * 255.0 * length as f64 / squares).log10();
        assert!(decibel > 38.0, "frame {number}: {decibel:.1} dB");
        for c in 0..3 {
            let of = |bytes: &[u8]| bytes[c..].iter().step_by(3).map(|&x| x as f64).sum::<f64>();
            let mean = (of(decoded) - of(&written)) / (length / 3) as f64;
            assert!(mean.abs() < 1.5, "frame {number}, channel {c}: {mean}");
        }
    }
}

#[test]
fn frames_go_to_ffmpeg() {
    if !is_installed("ffmpeg") || !is_installed("ffprobe") {
        return;
    }
    for size in [(96, 64), (49, 33)] {
        let (folder, path) = in_folder();
        // x264 at less quality takes more from colours than the comparison allows.
        let options = FfmpegOptions { quality: 100, ..FfmpegOptions::default() };
        let mut video = FfmpegPipe::open(&path, size, rate(), &options).unwrap();
        for number in 0..65 {
            video.write_frame(&frame(number, size)).unwrap();
        }
        video.finish().unwrap();
        assert_eq!(names(folder.path()), ["a.mp4"]);
        match size {
            (49, 33) => {
                let said = probe(&path);
                assert!(EXPECTED.iter().all(|line| said.lines().any(|said| said == *line)), "{said}");
            }
            _ => assert_near(&path, size, 65),
        }
    }
}

#[test]
fn a_pipe_that_is_dropped_leaves_nothing() {
    if !is_installed("ffmpeg") {
        return;
    }
    let (folder, path) = in_folder();
    let mut video = FfmpegPipe::open(&path, (32, 32), rate(), &FfmpegOptions::default()).unwrap();
    video.write_frame(&frame(0, (32, 32))).unwrap();
    assert!(video.write_frame(&frame(0, (32, 34))).is_err());
    drop(video);
    assert!(names(folder.path()).is_empty());
}

#[test]
fn without_ffmpeg_the_error_says_so() {
    let (folder, path) = in_folder();
    let options = FfmpegOptions { program: "no-such-ffmpeg".into(), ..FfmpegOptions::default() };
    let error = FfmpegPipe::open(&path, (32, 32), rate(), &options).err().unwrap().to_string();
    assert!(error.contains("there is no program no-such-ffmpeg; install ffmpeg"), "{error}");
    assert!(names(folder.path()).is_empty());
}

/// A program in ffmpeg's place that says something and fails.
#[cfg(unix)]
#[test]
fn what_ffmpeg_says_last_is_the_reason() {
    use std::os::unix::fs::PermissionsExt;
    let (folder, path) = in_folder();
    let program = folder.path().join("ffmpeg.sh");
    fs::write(&program, "#!/bin/sh\necho first >&2\necho 'Unknown encoder libx264' >&2\necho >&2\nexit 1\n")
        .unwrap();
    fs::set_permissions(&program, fs::Permissions::from_mode(0o755)).unwrap();
    let options = FfmpegOptions { program, ..FfmpegOptions::default() };
    let said = |error: OutputError| {
        let error = error.to_string();
        assert!(error.contains("ffmpeg failed: Unknown encoder libx264"), "{error}");
    };
    let size = (640, 480);
    let mut video = FfmpegPipe::open(&path, size, rate(), &options).unwrap();
    // The pipe takes some before it is known to be broken.
    let picture = frame(0, size);
    said((0..100).find_map(|_| video.write_frame(&picture).err()).unwrap());
    assert!(video.finish().is_err());
    said(FfmpegPipe::open(&path, size, rate(), &options).unwrap().finish().unwrap_err());
    assert_eq!(names(folder.path()), ["ffmpeg.sh"]);
}
