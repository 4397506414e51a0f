//! Flags about many processes.

use super::{Need, check};
use crate::failure::Failure;
use clap::Args;
use std::time::Duration;

/// Only under a launcher of MPI do they say anything.
#[derive(Clone, Copy, Debug, Args)]
#[command(next_help_heading = "Many processes (under mpirun or srun)")]
pub(crate) struct ClusterFlags {
    /// Seconds without a message from a rank (its process is stopped, or its host is gone) after which the job ends, 0 to
    /// 4294967295; twice as many while MPI starts; 0 means never [default: 60]
    #[arg(long, value_name = "SECONDS", value_parser = super::values::whole::<u32>(0..=u32::MAX), allow_hyphen_values = true)]
    pub(crate) rank_timeout: Option<u32>,
}

/// Seconds, where nothing is said.
const DEFAULT_TIMEOUT: u32 = 60;

impl ClusterFlags {
    /// Fails where one of these would do nothing.
    pub(crate) fn check(&self, is_launched: bool) -> Result<(), Failure> {
        check(&[Need {
            flag: "--rank-timeout",
            is_given: self.rank_timeout.is_some(),
            is_met: is_launched,
            needs: "many processes, under mpirun or srun",
        }])
    }

    /// How long a rank may say nothing.
    pub(crate) fn silence(&self) -> Option<Duration> {
        let seconds = self.rank_timeout.unwrap_or(DEFAULT_TIMEOUT);
        (seconds > 0).then(|| Duration::from_secs(seconds.into()))
    }
}
