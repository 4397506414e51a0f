//! The picture at rest, which gets sharper sample by sample.

use eosphor::SampleSums;

/// The sums of the samples that were taken of a view.
pub(crate) struct Progress {
    /// The scene that they are of.
    pub(crate) version: u64,
    /// The input that they show.
    pub(crate) sums: SampleSums,
    pub(crate) samples: u32,
    pub(crate) all_samples: u32,
    /// The last frame was sent.
    pub(crate) is_sent: bool,
}

impl Progress {
    /// That of no samples.
    pub(crate) fn new(version: u64, [width, height]: [u32; 2], all_samples: u32) -> Progress {
        let sums = SampleSums::new(width, height);
        Progress { version, sums, samples: 0, all_samples, is_sent: false }
    }

    /// That of what is drawn at once, and has no sums.
    pub(crate) fn at_once(version: u64, all_samples: u32) -> Progress {
        Progress { samples: all_samples, ..Progress::new(version, [0, 0], all_samples) }
    }

    /// The samples to take next: 1, 3, 12, 48 ...
    pub(crate) fn next_samples(&self) -> std::ops::Range<u32> {
        let end = if self.samples == 0 { 1 } else { self.samples.saturating_mul(4) };
        self.samples..end.min(self.all_samples)
    }

    /// All samples were taken.
    pub(crate) fn is_whole(&self) -> bool {
        self.samples == self.all_samples
    }

    /// Nothing is left to do.
    pub(crate) fn is_complete(&self) -> bool {
        self.is_whole() && self.is_sent
    }
}
