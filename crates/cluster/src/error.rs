//! What can go wrong between processes.

use std::path::PathBuf;

/// What went wrong, where, and what to do.
#[derive(Debug, thiserror::Error)]
pub enum ClusterError {
    /// A launcher started this process, but there is no MPI library for it.
    #[error(
        "{launcher} started this process, but no MPI library for it was found (looked for {looked_for}): install one \
         ({install}), put its folder into LD_LIBRARY_PATH, or set EOSPHOR_MPI to the library's path"
    )]
    NoLibrary {
        /// The launcher, in words.
        launcher: String,
        /// File names and folders.
        looked_for: String,
        /// Packages that have such a library.
        install: String,
    },
    /// A library could not be opened or used.
    #[error("the MPI library {}: {reason}", path.display())]
    Library {
        /// The library.
        path: PathBuf,
        /// Why, and what to do.
        reason: String,
    },
    /// The library is of another kind than the launcher, so that the processes would not find each other.
    #[error(
        "{launcher} started this process, but {} is {library}, which does not understand that launcher: start with \
         the mpirun of that library, or set EOSPHOR_MPI to the launcher's own library",
        path.display()
    )]
    WrongLibrary {
        /// The launcher, in words.
        launcher: String,
        /// What the library says that it is.
        library: String,
        /// The library.
        path: PathBuf,
    },
    /// The launcher started another number of processes than the library sees.
    #[error(
        "{launcher} started {started} processes, but {library} ({}) sees {seen}: they are of different kinds; start \
         with the mpirun of that library, or set EOSPHOR_MPI to the launcher's own library",
        path.display()
    )]
    WrongSize {
        /// The launcher, in words.
        launcher: String,
        /// How many processes the launcher says that it started.
        started: u32,
        /// What the library says that it is.
        library: String,
        /// The library.
        path: PathBuf,
        /// How many processes the library sees.
        seen: u32,
    },
    /// A call of MPI failed.
    #[error("rank {rank} on {host}: {call}: {reason}: is a process or a host of the job gone?")]
    Mpi {
        /// The call.
        call: &'static str,
        /// The rank that it failed on.
        rank: u32,
        /// Name of the rank's host.
        host: String,
        /// The library's own words.
        reason: String,
    },
    /// Ranks say different things. All ranks get the same error: let rank 0 print it.
    #[error(
        "ranks differ in {what}: {differences}: start the same program, with the same arguments, on every host"
    )]
    Disagreement {
        /// In what.
        what: String,
        /// Which ranks say what.
        differences: String,
    },
    /// Bytes did not reach a rank as they were. All ranks get the same error: let rank 0 print it.
    #[error("broadcast of {bytes} bytes: {reason}")]
    Broadcast {
        /// How many bytes there were.
        bytes: u64,
        /// Which rank, and why.
        reason: String,
    },
    /// A call that makes no sense, which is the program's fault.
    #[error("rank {rank}: {reason}")]
    Misuse {
        /// The rank.
        rank: u32,
        /// What is wrong with it.
        reason: String,
    },
}
