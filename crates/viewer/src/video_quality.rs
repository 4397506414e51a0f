//! The resolution and quantiser of moving frames that go as video.

use crate::quality::{FRAME, LEAST_SCALE, LINE, LINE_OF_JPEG, MEMORY};
use std::time::Duration;

/// H.264's quantisers, from fine to coarse.
const QUANTISERS: [u8; 4] = [26, 30, 34, 38];

/// Bytes of a finer step over those of a coarser one, where a picture has noise.
const FINER: f64 = 6.0;

/// A JPEG of the same quality has this many times the bytes, and a little more.
const JPEG: f64 = 8.0;

/// The longer side of the largest frame that the encoder takes, and the shorter one.
const LARGEST: [f64; 2] = [3840.0, 2160.0];

/// Frames after a change until the picture may get worse; until it may get better, at first and at most. Each change costs a key
/// frame.
const WORSE_AFTER: u32 = 8;
const BETTER_AFTER: [u32; 2] = [60, 1920];

/// How much of the most that frames cost counts after another one: a movement is quick at times and slow at others.
const MOST_MEMORY: f64 = 0.99;

/// What the frames of a video cost lately, and what follows for the next one.
#[derive(Clone, Copy, Debug)]
pub(crate) struct VideoQuality {
    /// Share of a side.
    scale: f64,
    /// Which of the quantisers.
    step: usize,
    /// Frames since one of them changed, without key frames.
    frames: u32,
    /// Frames after which it may get better: the double, each time that better was too much.
    better_after: u32,
    /// Whether the last change was to the better.
    got_better: bool,
    /// What frames cost lately.
    mean: Cost,
    /// The most of it.
    most: Cost,
}

#[derive(Clone, Copy, Debug, Default)]
struct Cost {
    bytes: f64,
    seconds: f64,
}

impl VideoQuality {
    /// Begins with frames whose sides have at least half of those at rest.
    pub(crate) fn new(scale: f64) -> VideoQuality {
        VideoQuality {
            scale: scale.max(0.5),
            step: 1,
            frames: 0,
            better_after: BETTER_AFTER[0],
            got_better: false,
            mean: Cost::default(),
            most: Cost::default(),
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
        let new = Cost { bytes: bytes as f64, seconds: took.as_secs_f64() };
        let mix =
            |old: f64, new: f64| if self.frames == 0 { new } else { MEMORY * old + (1.0 - MEMORY) * new };
        let most = |old: f64, new: f64| if self.frames == 0 { new } else { new.max(MOST_MEMORY * old) };
        let (mean, old) = (self.mean, self.most);
        self.mean = Cost { bytes: mix(mean.bytes, new.bytes), seconds: mix(mean.seconds, new.seconds) };
        self.most =
            Cost { bytes: most(old.bytes, self.mean.bytes), seconds: most(old.seconds, self.mean.seconds) };
        self.frames += 1;
        // How many times as much there is room for.
        let room = |cost: Cost| {
            let bytes = line.map_or(f64::INFINITY, |line| line * LINE.as_secs_f64());
            (bytes / cost.bytes.max(1.0), FRAME.as_secs_f64() / cost.seconds.max(1e-4))
        };
        let last = QUANTISERS.len() - 1;
        let (of_line, of_time) = room(self.mean);
        if self.frames >= WORSE_AFTER && of_line < 1.1 {
            match self.step < last {
                true => self.change(self.scale, self.step + 1),
                false => self.change(self.scale * 0.75, last),
            }
        } else if self.frames >= WORSE_AFTER && of_time < 0.85 {
            self.change(self.scale * of_time.sqrt(), self.step);
        } else if self.frames >= self.better_after {
            let (of_line, of_time) = room(self.most);
            if self.step > 0 && of_line > FINER {
                self.change(self.scale, self.step - 1);
            } else if of_time > 1.3 && of_line > 1.5 {
                self.change(self.scale * (of_time * 0.9).sqrt().min(1.3), self.step);
            }
        }
    }

    /// Whether the line holds JPEGs of that quality, so that video only costs time.
    pub(crate) fn is_needless(&self, line: Option<f64>) -> bool {
        line.is_some_and(|line| self.frames > 0 && line * LINE_OF_JPEG > JPEG * self.mean.bytes)
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
