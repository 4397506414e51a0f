//! `embree-peer LIBRARY DATA_FOLDER [FLAGS]`: measures Embree 4. See peers/README.md.

mod api;
mod scene;

use peer_harness::Peer;
use std::process::ExitCode;

fn main() -> ExitCode {
    peer_harness::run(&[Peer::new::<scene::Single>("embree"), Peer::new::<scene::Packets>("embree-packets")])
}
