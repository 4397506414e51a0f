//! What the programs that measure other ray tracing libraries share: their arguments, their data, how they measure, and
//! what they print. peers/README.md documents all of it.

mod arguments;
#[cfg(feature = "check")]
pub mod check;
mod clock;
mod data;
mod library;
mod measure;
#[cfg(feature = "check")]
pub mod sample;

pub use arguments::{Options, Quality};
pub use data::{Hit, MISS, Ray, Triangle};
pub use library::Library;

use arguments::Arguments;
use data::Data;
use std::process::ExitCode;

/// A name on the command line, and what it measures.
pub struct Peer {
    name: &'static str,
    measure: fn(&Data, &Options) -> Result<(), String>,
}

impl Peer {
    /// A library under its name.
    pub const fn new<L: Library>(name: &'static str) -> Self {
        Self { name, measure: measure::measure::<L> }
    }
}

/// The whole program: reads the arguments and the data, measures, prints. An error is one line on stderr.
pub fn run(peers: &[Peer]) -> ExitCode {
    match try_run(peers) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::from(1)
        }
    }
}

fn try_run(peers: &[Peer]) -> Result<(), String> {
    let names: Vec<&str> = peers.iter().map(|peer| peer.name).collect();
    let arguments = Arguments::parse(std::env::args_os().skip(1), &names)?;
    let Some(peer) = peers.iter().find(|peer| peer.name == arguments.library) else {
        return Err(format!("no library is named '{}'; there are {}", arguments.library, names.join(", ")));
    };
    let data = Data::read(&arguments.folder)?;
    (peer.measure)(&data, &arguments.options)
}
