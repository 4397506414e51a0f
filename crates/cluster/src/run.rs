//! A job, from its beginning to its end.

use crate::coordinate::coordinate;
use crate::error::ClusterError;
use crate::job::{Job, Report};
use crate::work::work;
use crate::world::World;

impl World {
    /// Runs a job to its end. All ranks call it, each with the role that it has, and all leave it together with the same
    /// report; then they may run another.
    ///
    /// An error of the job's functions, a panic in them, a failure of MPI, or a rank that says nothing for too long ends
    /// the process on all ranks, with one line on stderr.
    ///
    /// # Errors
    ///
    /// The job makes no sense: it has no threads, or a coordinator elsewhere than on rank 0.
    pub fn run(&self, mut job: Job<'_, '_>) -> Result<Report, ClusterError> {
        let misuse = |reason: &str| ClusterError::Misuse { rank: self.rank(), reason: reason.into() };
        if job.threads == 0 {
            return Err(misuse("a job needs at least one thread on every rank"));
        }
        match (self.rank(), job.coordinator.take()) {
            (0, Some(coordinator)) => coordinate(self, &job, coordinator),
            (0, None) => Err(misuse("a job needs a coordinator on rank 0")),
            (_, Some(_)) => Err(misuse("a job has its coordinator on rank 0 alone")),
            (_, None) => work(self, &job),
        }
    }
}
