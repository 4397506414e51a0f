//! `rust-peers LIBRARY DATA_FOLDER [FLAGS]`: measures a ray tracing library written in Rust. See peers/README.md.

mod bvh;
mod obvhs;
mod parry;

use peer_harness::Peer;
use std::process::ExitCode;

fn main() -> ExitCode {
    peer_harness::run(&[
        Peer::new::<obvhs::Binary>("obvhs-bvh2"),
        Peer::new::<obvhs::Wide>("obvhs-cwbvh"),
        Peer::new::<bvh::Tree>("bvh"),
        Peer::new::<parry::Mesh>("parry"),
    ])
}
