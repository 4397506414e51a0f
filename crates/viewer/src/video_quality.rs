//! The resolution and quantiser of moving frames that go as video.

use crate::quality::{FRAME, LEAST_SCALE, LINE, LINE_OF_JPEG, MEMORY};
use std::time::Duration;

/// H.264's quantisers, from fine to coarse.
const QUANTISERS: [u8; 5] = [22, 26, 30, 34, 38];

/// Which of them comes first.
const FIRST_STEP: usize = 2;

/// The bytes of a finer step over those of a coarser one, in pictures with noise.
const FINER: f64 = 6.0;

/// The bytes of a JPEG over those of a video frame of the same quality, rounded up.
const JPEG: f64 = 8.0;

/// The longer side of the largest frame that the encoder takes, and the shorter one.
const LARGEST: [f64; 2] = [3840.0, 2160.0];

/// Frames after a change until the picture may get worse; until it may get better, at first and at most. Each change costs a key
/// frame.
const WORSE_AFTER: u32 = 8;
const BETTER_AFTER: [u32; 2] = [60, 1920];

/// How much of the most bytes, and of the usual time, counts after another frame: a movement is quick at times and slow at others.
const LONG_MEMORY: f64 = 0.99;

/// What the frames of a video cost lately, and what follows for the next one.
#[derive(Clone, Copy, Debug)]
pub(crate) struct VideoQuality {
    /// Share of a side.
    scale: f64,
    /// Which of the quantisers.
    step: usize,
    /// Frames since one of them changed, without key frames.
    frames: u32,
    /// Frames after which the picture may get better; doubled each time that a better one was too much.
    better_after: u32,
    /// Whether the last change was to the better.
    got_better: bool,
    /// Means of the last frames.
    bytes: f64,
    seconds: f64,
    /// Of the last hundred frames: the most bytes, and the mean time.
    most_bytes: f64,
    usual_seconds: f64,
}

impl VideoQuality {
    /// That of a video which begins, with this share of a side, or a half where that is more.
    pub(crate) fn new(scale: f64) -> VideoQuality {
        VideoQuality {
            scale: scale.max(0.5),
            step: FIRST_STEP,
            frames: 0,
            better_after: BETTER_AFTER[0],
            got_better: false,
            bytes: 0.0,
            seconds: 0.0,
            most_bytes: 0.0,
            usual_seconds: 0.0,
        }
    }

    /// The size of the next frame, for this one at rest: of even sides.
    pub(crate) fn size(&self, full: [u32; 2]) -> [u32; 2] {
        let [longer, shorter] = [full[0].max(full[1]), full[0].min(full[1])].map(f64::from);
        let scale = self.scale.min(LARGEST[0] / longer).min(LARGEST[1] / shorter);
        full.map(|side| ((f64::from(side) * scale) as u32 & !1).max(2))
    }

    /// That of the next frame.
    pub(crate) fn quantiser(&self) -> u8 {
        QUANTISERS[self.step]
    }

    /// Learns from a frame that took so long to be rendered and encoded, and has so many bytes, on a line that takes so many
    /// a second.
    pub(crate) fn encoded(&mut self, took: Duration, bytes: usize, is_key: bool, line: Option<f64>) {
        if is_key {
            return;
        }
        let (bytes, seconds) = (bytes as f64, took.as_secs_f64());
        if self.frames == 0 {
            (self.bytes, self.most_bytes) = (bytes, bytes);
            (self.seconds, self.usual_seconds) = (seconds, seconds);
        }
        let mix = |memory: f64, old: f64, new: f64| memory * old + (1.0 - memory) * new;
        self.bytes = mix(MEMORY, self.bytes, bytes);
        self.seconds = mix(MEMORY, self.seconds, seconds);
        self.most_bytes = self.bytes.max(LONG_MEMORY * self.most_bytes);
        self.usual_seconds = mix(LONG_MEMORY, self.usual_seconds, seconds);
        self.frames += 1;
        // How many times as much there is room for.
        let of_line =
            |bytes: f64| line.map_or(f64::INFINITY, |line| line * LINE.as_secs_f64() / bytes.max(1.0));
        let of_time = |seconds: f64| FRAME.as_secs_f64() / seconds.max(1e-4);
        let last = QUANTISERS.len() - 1;
        if self.frames >= WORSE_AFTER && of_line(self.bytes) < 1.1 {
            match self.step < last {
                true => self.change(self.scale, self.step + 1),
                false => self.change(self.scale * 0.75, last),
            }
        } else if self.frames >= WORSE_AFTER && of_time(self.seconds) < 0.8 {
            self.change(self.scale * of_time(self.seconds).sqrt(), self.step);
        } else if self.frames >= self.better_after {
            let (of_line, of_time) = (of_line(self.most_bytes), of_time(self.usual_seconds));
            if self.step > 0 && of_line > FINER {
                self.change(self.scale, self.step - 1);
            } else if of_time > 1.2 && of_line > 1.5 {
                self.change(self.scale * (of_time * 0.95).sqrt().min(1.3), self.step);
            }
        }
    }

    /// Whether the line is quick enough for JPEGs of this quality, so that video only costs time.
    pub(crate) fn is_needless(&self, line: Option<f64>) -> bool {
        line.is_some_and(|line| self.frames > 0 && line * LINE_OF_JPEG > JPEG * self.bytes)
    }

    fn change(&mut self, scale: f64, step: usize) {
        let scale = scale.clamp(LEAST_SCALE, 1.0);
        if scale == self.scale && step == self.step {
            return;
        }
        let gets_better = scale > self.scale || step < self.step;
        if self.got_better && !gets_better {
            self.better_after = (2 * self.better_after).min(BETTER_AFTER[1]);
        }
        (self.scale, self.step, self.frames, self.got_better) = (scale, step, 0, gets_better);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const FULL: [u32; 2] = [1920, 1080];

    /// What a frame costs whose picture moves this quickly, as a scene with noise was measured.
    fn cost(video: &VideoQuality, motion: f64) -> (Duration, usize) {
        let size = video.size(FULL);
        let pixels = f64::from(size[0] * size[1]);
        let finer = FINER.powi(FIRST_STEP as i32 - video.step as i32);
        let bytes = pixels * 0.006 * motion * finer;
        (Duration::from_secs_f64(0.006 + pixels * 5e-8), bytes as usize)
    }

    /// What a video comes to on a line, and how often it changed on the way and in the last minute.
    fn run(line: f64) -> (VideoQuality, [u32; 2]) {
        let (mut video, mut changes) = (VideoQuality::new(0.3), [0; 2]);
        for number in 0..6000 {
            let (before, motion) = ((video.scale, video.step), 1.0 + (f64::from(number) * 0.05).sin());
            let (took, bytes) = cost(&video, motion);
            let is_key = video.frames == 0 && number % 2 == 0;
            video.encoded(took, bytes, is_key, Some(line));
            let changed = u32::from(before != (video.scale, video.step));
            changes[usize::from(number >= 4200)] += changed;
        }
        (video, changes)
    }

    #[test]
    fn frames_fill_the_line_and_come_to_rest() {
        for line in [60e3, 250e3, 1.25e6, 1e9] {
            let (video, changes) = run(line);
            assert!(changes[0] < 20 && changes[1] <= 2, "{line}: {changes:?}, {video:?}");
            assert!(video.most_bytes / line < LINE.as_secs_f64() * 1.1, "{line}: {video:?}");
        }
        let steps = [60e3, 250e3, 1.25e6].map(|line| run(line).0.step);
        assert!(steps.is_sorted_by(|slow, quick| slow >= quick), "{steps:?}");
    }

    #[test]
    fn sizes_are_what_the_encoder_takes() {
        let video = VideoQuality::new(0.0);
        assert_eq!(video.size([1920, 1080]), [960, 540]);
        assert_eq!(video.size([333, 187]), [166, 92]);
        assert_eq!(video.size([16_000, 9_000]), [3840, 2160]);
        assert_eq!(video.size([1, 1]), [2, 2]);
        let [width, height] = VideoQuality::new(1.0).size([2161, 60_000]);
        assert!(width % 2 == 0 && height <= 3840, "{width} x {height}");
    }

    #[test]
    fn a_quick_line_needs_no_video() {
        let mut video = VideoQuality::new(0.5);
        assert!(!video.is_needless(Some(1e9)));
        for _ in 0..20 {
            video.encoded(Duration::from_millis(30), 4_000, false, Some(1e6));
        }
        assert!(!video.is_needless(None) && !video.is_needless(Some(1e6)) && video.is_needless(Some(10e6)));
    }
}
