//! A relay that passes datagrams on after some time: in their order, without a limit of rate.

use anyhow::{Context, Result, bail};
use std::net::UdpSocket;
use std::sync::mpsc::channel;
use std::time::{Duration, Instant};

/// How the command is asked to be one.
pub(super) const MODE: &str = "--relay";

/// Where VXLAN is.
pub(super) const PORT: u16 = 4789;

/// Passes on what comes from each of two networks to the other, until it is killed. `ONE OTHER MICROSECONDS`; of each network
/// it is number 2, and talks to number 1.
pub(super) fn run(arguments: &[String]) -> Result<()> {
    let [one, other, microseconds] = arguments else { bail!("{MODE} takes two networks and a time") };
    let delay = Duration::from_micros(microseconds.parse()?);
    // Not connected: VXLAN hears at one port and speaks from many.
    let socket = |network: &str| UdpSocket::bind(format!("{network}.2:{PORT}")).context("cannot listen");
    let (from_one, from_other) = (socket(one)?, socket(other)?);
    let [to_one, to_other] = [one, other].map(|network| format!("{network}.1:{PORT}"));
    std::thread::scope(|scope| {
        scope.spawn(|| pass(&from_one, &from_other, &to_other, delay));
        scope.spawn(|| pass(&from_other, &from_one, &to_one, delay));
    });
    Ok(())
}

/// One way.
fn pass(from: &UdpSocket, to: &UdpSocket, address: &str, delay: Duration) {
    let (came, waiting) = channel::<(Instant, Vec<u8>)>();
    let send = || {
        for (due, packet) in waiting {
            std::thread::sleep(due.saturating_duration_since(Instant::now()));
            // One that cannot be sent is lost, as on any line.
            let _ = to.send_to(&packet, address);
        }
    };
    let receive = || {
        let mut buffer = [0; 2048];
        loop {
            // An error is that of an earlier packet, which nobody took.
            let Ok((length, _)) = from.recv_from(&mut buffer) else { continue };
            if came.send((Instant::now() + delay, buffer[..length].to_vec())).is_err() {
                return;
            }
        }
    };
    std::thread::scope(|scope| {
        scope.spawn(send);
        receive();
    });
}
