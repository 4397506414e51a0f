//! Flags about many processes.

use clap::Args;

/// Only under a launcher of MPI do they say anything.
#[derive(Clone, Copy, Debug, Args)]
#[command(next_help_heading = "Many processes (under mpirun or srun)")]
pub(crate) struct ClusterFlags {
    /// End the job where a rank has said nothing for so many seconds, since it is stopped or its host gone (while MPI starts:
    /// for twice as many), 0 to 4294967295; 0: never
    #[arg(long, value_name = "SECONDS", default_value_t = 60, value_parser = super::values::whole::<u32>(0..=u32::MAX), allow_hyphen_values = true)]
    pub(crate) rank_timeout: u32,
}
