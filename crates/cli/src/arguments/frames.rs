//! Flags of animations.

use super::values::{whole, within};
use super::{Need, check};
use crate::failure::Failure;
use clap::Args;
use clap::builder::TypedValueParser;
use eosphor::{MAX_FRAMES, Scene};
use std::ops::{Bound, Range};

#[derive(Debug, Args)]
#[command(next_help_heading = "Animation")]
pub(crate) struct FrameFlags {
    /// The frames of an animation to render, A to B - 1: 0..120 are the first 120; one number is one frame [default: all]
    #[arg(long, value_name = "A..B", value_parser = frame_range, allow_hyphen_values = true)]
    pub(crate) frames: Option<FrameRange>,
    /// The frame of the animation that a single picture shows, 0 to 5999999 [default: the scene's, or 0]
    #[arg(long, value_name = "N", value_parser = whole::<u32>(0..=MAX_FRAMES - 1), allow_hyphen_values = true)]
    pub(crate) frame: Option<u32>,
    /// Render a turntable of N frames, 1 to 6000000: the camera circles once around the point that it looks at
    #[arg(long, value_name = "N", value_parser = whole::<u32>(1..=MAX_FRAMES), allow_hyphen_values = true)]
    pub(crate) orbit: Option<u32>,
    /// Frames per second, over 0 and at most 1000 (240 for an .mp4) [default: the scene's, or 24]
    #[arg(long, value_name = "X", value_parser = frame_rate(), allow_hyphen_values = true)]
    pub(crate) fps: Option<f32>,
    /// Quality of an .mp4, 1 to 100; losses are hard to see at 90 [default: 90]
    #[cfg(feature = "video")]
    #[arg(long, value_name = "N", value_parser = whole::<u8>(1..=100), allow_hyphen_values = true)]
    pub(crate) video_quality: Option<u8>,
    /// Encode an .mp4 with the program ffmpeg, which must be installed
    #[cfg(feature = "video")]
    #[arg(long, conflicts_with = "resume")]
    pub(crate) ffmpeg: bool,
    /// Divide the frames among all processes that run with this flag, on this machine or over a shared file system: each
    /// renders frames that are not done and that no other process is rendering
    #[arg(long, conflicts_with = "resume")]
    pub(crate) share: bool,
    /// Frames in flight at the same time, 1 to 64; changes no pixel [default: what suits the device]
    #[arg(long, value_name = "N", value_parser = whole::<u16>(1..=64), allow_hyphen_values = true, hide = true)]
    pub(crate) in_flight: Option<u16>,
}

/// What is to be written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum OutputKind {
    /// One picture.
    Still,
    /// A picture for each frame.
    Frames,
    /// One file of all frames.
    Video,
}

/// Frames by number.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct FrameRange(pub(crate) Range<u32>);

/// `0..120`, or one number.
fn frame_range(text: &str) -> Result<FrameRange, String> {
    let wrong =
        || "it must be the first frame, two dots and the one after the last, as in 0..120".to_string();
    let range = match text.split_once("..") {
        Some((start, end)) => start.parse().ok().zip(end.parse().ok()).map(|(start, end)| start..end),
        None => text.parse::<u32>().ok().and_then(|frame| Some(frame..frame.checked_add(1)?)),
    };
    let range = range.ok_or_else(wrong)?;
    match range.start < range.end && range.end <= MAX_FRAMES {
        true => Ok(FrameRange(range)),
        false => Err(format!("there are no such frames: {}", wrong())),
    }
}

/// Frames a second.
pub(super) fn frame_rate() -> impl TypedValueParser<Value = f32> {
    within((Bound::Excluded(0.0), Bound::Included(1000.0)))
}

/// A parser for frames per second of a video.
pub(super) fn video_rate() -> impl TypedValueParser<Value = f32> {
    within((Bound::Excluded(0.0), Bound::Included(240.0)))
}

impl FrameFlags {
    /// Fails where one of these would do nothing for an output of this kind.
    pub(crate) fn check(&self, output: OutputKind) -> Result<(), Failure> {
        let is_sequence = output != OutputKind::Still;
        #[cfg(feature = "video")]
        let is_video = output == OutputKind::Video;
        let need = |flag, is_given, is_met, needs| Need { flag, is_given, is_met, needs };
        let frames = "frames (an output as frame_%04d.png, or an .mp4)";
        check(&[
            need(
                "--frame",
                self.frame.is_some(),
                !is_sequence,
                "a single picture; --frames chooses among several",
            ),
            need("--orbit", self.orbit.is_some(), is_sequence, frames),
            need("--fps", self.fps.is_some(), is_sequence, frames),
            need("--share", self.share, output == OutputKind::Frames, "frames (an output as frame_%04d.png)"),
            need("--in-flight", self.in_flight.is_some(), is_sequence, frames),
            #[cfg(feature = "video")]
            need("--video-quality", self.video_quality.is_some(), is_video, "an .mp4"),
            #[cfg(feature = "video")]
            need("--ffmpeg", self.ffmpeg, is_video, "an .mp4"),
        ])
    }

    /// Fails where `--fps` would do nothing in this scene.
    pub(crate) fn check_fps(&self, output: OutputKind, scene: &Scene) -> Result<(), Failure> {
        check(&[Need {
            flag: "--fps",
            is_given: self.fps.is_some(),
            is_met: output == OutputKind::Video || scene.moves_by_seconds(),
            needs: "an .mp4, or something that moves by seconds",
        }])
    }

    /// Changes how a scene moves and which frame it shows, as the flags say. Fails where there is no such frame.
    pub(crate) fn apply(&self, scene: &mut Scene) -> Result<(), Failure> {
        if let Some(frames) = self.orbit {
            scene.orbit_camera(frames);
        }
        if let (Some(fps), Some(animation)) = (self.fps, &mut scene.animation) {
            animation.fps = fps;
        }
        if let Some(frame) = self.frame {
            check(&[Need {
                flag: "--frame",
                is_given: true,
                is_met: scene.animation.is_some(),
                needs: "a scene with an animation",
            }])?;
            let frames = scene.animation.as_ref().map_or(1, |animation| animation.frames);
            if frame >= frames {
                let message =
                    format!("--frame: there is no frame {frame}; the animation has 0 to {}", frames - 1);
                return Err(Failure::Usage(message));
            }
            scene.frame = frame;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranges_of_frames() {
        assert_eq!(frame_range("0..120").unwrap().0, 0..120);
        assert_eq!(frame_range("7").unwrap().0, 7..8);
        for bad in
            ["", "..", "3..", "..3", "5..5", "6..5", "a..b", "-1..3", "0..99999999", "4294967295", "0...3"]
        {
            assert!(frame_range(bad).is_err(), "{bad}");
        }
    }
}
