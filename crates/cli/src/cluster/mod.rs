//! Many processes at one command: under a launcher of MPI (`mpirun`, `srun`), rank 0 runs it with all ranks as its backend,
//! and the others render for it. Pixels do not depend on who renders them.

mod backend;
mod coordinator;
mod processors;
mod wire;
mod worker;

use crate::arguments::{ClusterFlags, CourseFlags, DeviceFlags, RenderFlags};
use crate::failure::Failure;
use crate::streams::{self, Verbosity};
use eosphor::{Accel, Backend};
use eosphor_cluster::{ClusterError, World};

/// What a rank renders by: flags of the command, which all ranks have.
pub(crate) struct RankOptions {
    pub(crate) device: DeviceFlags,
    pub(crate) cluster: ClusterFlags,
    pub(crate) accel: Option<Accel>,
    pub(crate) count_work: bool,
    pub(crate) verbosity: Verbosity,
}

impl RenderFlags {
    /// What concerns other ranks.
    pub(crate) fn of_rank(&self) -> RankOptions {
        RankOptions {
            device: self.device.clone(),
            cluster: self.cluster,
            accel: self.picture.accel,
            count_work: self.report.stats,
            verbosity: self.report.verbosity(),
        }
    }
}

impl CourseFlags {
    /// What concerns other ranks.
    pub(crate) fn of_rank(&self) -> RankOptions {
        let (device, cluster, accel) = (self.device(), self.cluster, self.accel);
        RankOptions { device, cluster, accel, count_work: false, verbosity: Verbosity::Quiet }
    }
}

/// Whether a launcher of MPI started this process as another rank than 0: what all ranks would say, rank 0 says.
pub(crate) fn is_silent() -> bool {
    eosphor_cluster::launched_rank().is_some_and(|rank| rank > 0)
}

/// Runs a command. It is given all ranks as a backend, where there are several; other ranks than 0 do not run it but render
/// for it. Without a launcher no MPI is looked for.
pub(crate) fn run(
    options: &RankOptions,
    command: impl FnOnce(Option<&dyn Backend>) -> Result<(), Failure> + Send,
) -> Result<(), Failure> {
    let Some(world) = World::open(options.cluster.silence()).map_err(complain)? else {
        options.cluster.check(false)?;
        return command(None);
    };
    world.abort_handle().on_panic();
    let done = match (world.rank(), world.size()) {
        (_, 1) => command(None),
        (0, _) => coordinator::run(&world, options, command),
        _ => worker::run(&world, options),
    };
    world.finish().map_err(Failure::because)?;
    done
}

/// Says that there is no MPI: once on each host, as that may be the only one without.
fn complain(error: ClusterError) -> Failure {
    if is_silent() && eosphor_cluster::launched_local_rank() == Some(0) {
        streams::error(&error.to_string());
    }
    Failure::because(error)
}
