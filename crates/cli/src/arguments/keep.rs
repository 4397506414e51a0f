//! Flags about renders that end early.

use super::{FileFlags, Need, OutputKind, ReportFlags, Show, check};
use crate::failure::Failure;
use clap::Args;
use std::time::Duration;

/// Seconds between two writings of what is done, where nothing is said.
const DEFAULT_INTERVAL: u32 = 60;

#[derive(Clone, Copy, Debug, Args)]
#[command(next_help_heading = "Interruption")]
pub(crate) struct KeepFlags {
    /// Continue an interrupted render of the same scene and settings: keep the frames that are whole, or the samples of a still
    /// that OUT.part holds. A still may be given more --samples than before
    #[arg(long)]
    pub(crate) resume: bool,
    /// Seconds between two writes of OUT.part while a still is rendered, 1 to 86400; Ctrl-C, SIGTERM and SIGHUP write it too
    /// [default: 60]
    #[arg(long, value_name = "SECONDS", value_parser = super::values::whole::<u32>(1..=86_400), allow_hyphen_values = true)]
    checkpoint_every: Option<u32>,
}

impl KeepFlags {
    /// Fails where one of these, or of those about shares of a picture, would do nothing.
    pub(crate) fn check(
        &self,
        output: OutputKind,
        file: &FileFlags,
        show: Option<Show>,
        report: &ReportFlags,
        has_file: bool,
    ) -> Result<(), Failure> {
        let is_picture = show.is_none();
        let is_still = output == OutputKind::Still && is_picture;
        let of_file = |flag, is_given| Need {
            flag,
            is_given,
            is_met: has_file,
            needs: "an output that is a file, beside which it keeps or finds one, not -o -",
        };
        check(&[
            of_file("--tiles", file.tiles.is_some()),
            of_file("--sample-range", file.sample_range.is_some()),
            of_file("--resume", self.resume),
            of_file("--checkpoint-every", self.checkpoint_every.is_some()),
            Need {
                flag: "--sample-range",
                is_given: file.sample_range.is_some(),
                is_met: output == OutputKind::Still && !report.stats && !report.json,
                needs: "a still, without --stats and --json",
            },
            Need {
                flag: "--resume",
                is_given: self.resume,
                is_met: is_picture,
                needs: "a picture or frames, not --show",
            },
            Need {
                flag: "--resume",
                is_given: self.resume && report.stats,
                is_met: false,
                needs: "a render without --stats, which are of a whole one",
            },
            Need {
                flag: "--checkpoint-every",
                is_given: self.checkpoint_every.is_some(),
                is_met: is_still,
                needs: "a still, without --show",
            },
        ])
    }

    /// Between two writings of what is done of a still.
    pub(crate) fn interval(&self) -> Duration {
        Duration::from_secs(self.checkpoint_every.unwrap_or(DEFAULT_INTERVAL).into())
    }
}
