//! Many processes, on one host or on many, at one job of the Eosphor ray tracer.
//!
//! MPI is opened at run time: nothing is needed to build this crate, and a process that no launcher started never looks
//! for MPI at all. Under `mpirun` or `srun` a [`World`] is all processes of the job. [`World::broadcast`] gives the bytes
//! of rank 0 to all, and [`World::run`] farms out numbered units of work: each rank computes some, and rank 0 collects
//! the results in order. The crate knows bytes and numbers only, not what they mean.
//!
//! ```
//! use eosphor_cluster::{Coordinator, Job, World};
//! use std::sync::atomic::AtomicBool;
//!
//! let Some(world) = World::open(None)? else { return Ok(()) }; // no launcher: one process, which needs no MPI
//! world.abort_handle().on_panic();
//! world.agree("program version", env!("CARGO_PKG_VERSION"))?;
//! let scene = world.broadcast(if world.rank() == 0 { vec![1, 2, 3] } else { Vec::new() })?;
//!
//! let (mut sum, cancel) = (0, AtomicBool::new(false));
//! let (mut describe, mut progress) = (|unit: u64| Ok(Some(vec![unit as u8])), |_: &_| ());
//! let mut collect = |_, result: Vec<u8>| {
//!     sum += u64::from(result[0]);
//!     Ok(())
//! };
//! let coordinator = Coordinator {
//!     describe: &mut describe,
//!     collect: &mut collect,
//!     in_order: true,
//!     progress: &mut progress,
//!     cancel: &cancel,
//! };
//! let report = world.run(Job {
//!     units: 10,
//!     in_flight: 2,
//!     coordinator: (world.rank() == 0).then_some(coordinator),
//!     compute: &|_, description| Ok(vec![description[0] + scene[0]]),
//!     threads: 1,
//! })?;
//! assert!(report.complete);
//! world.finish()?;
//! # Ok::<(), eosphor_cluster::ClusterError>(())
//! ```
#![warn(missing_docs)]

mod abort;
mod chain;
mod collective;
mod coordinate;
mod error;
mod idle;
mod job;
mod launcher;
mod library;
mod messages;
mod mpi;
mod run;
mod thread_pool;
mod time_outs;
mod transfer;
mod watch;
mod work;
mod world;

pub use abort::Abort;
pub use error::ClusterError;
pub use job::{Compute, Coordinator, Job, JobProgress, RankProgress, Report};
pub use launcher::{launched_local_rank, launched_rank};
pub use world::World;
