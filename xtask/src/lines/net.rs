//! Two machines and the line between them, as network namespaces. They have no names, and end with the processes that hold them:
//! nothing is left after an error, Ctrl-C, or a kill.

use super::relay;
use anyhow::{Context, Result, ensure};
use std::fs;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

/// Most TCP connections of the world: it fills queues, which is what has to be seen here. The kernel's own default may be another.
const CONGESTION: &str = "cubic";

/// What is bad about a line.
#[derive(Clone, Copy, Default)]
pub(super) struct Faults {
    /// Milliseconds there and back.
    pub(super) round_trip: u32,
    /// Megabits a second from the server to the page; 0 is no limit.
    pub(super) megabits: u32,
    /// Percent of the packets that get lost, both ways.
    pub(super) loss: u32,
}

/// A process that is killed when this is dropped.
pub(super) struct Running(pub(super) Child);

impl Drop for Running {
    fn drop(&mut self) {
        // It may have ended.
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// A namespace: it lives while something runs in it.
pub(super) struct Machine {
    holder: Running,
}

impl Machine {
    fn new() -> Result<Machine> {
        // It ends when its input does: with this process at the latest.
        let holder = Command::new("unshare").args(["--net", "cat"]).stdin(Stdio::piped()).spawn();
        let machine = Machine { holder: Running(holder.context("cannot run unshare")?) };
        let name = |of: &str| fs::read_link(format!("/proc/{of}/ns/net"));
        let (own, pid, start) = (name("self")?, machine.pid(), Instant::now());
        while name(&pid)? == own {
            ensure!(start.elapsed() < Duration::from_secs(5), "no network namespace; are you root?");
            std::thread::sleep(Duration::from_millis(5));
        }
        machine.does("ip link set lo up")?;
        Ok(machine)
    }

    fn pid(&self) -> String {
        self.holder.0.id().to_string()
    }

    /// A command in it, which does not outlive this process.
    pub(super) fn command(&self, program: impl AsRef<Path>) -> Command {
        let mut command = Command::new("setpriv");
        command.args(["--pdeathsig", "KILL", "nsenter", "--target", &self.pid(), "--net", "--"]);
        command.arg(program.as_ref());
        command
    }

    fn does(&self, line: &str) -> Result<()> {
        let mut words = line.split(' ');
        self.ends_well(words.next().unwrap_or_default(), &words.collect::<Vec<_>>())
    }

    fn ends_well(&self, program: &str, arguments: &[&str]) -> Result<()> {
        let output = self.command(program).args(arguments).output().context("cannot run setpriv")?;
        let said = String::from_utf8_lossy(&output.stderr);
        ensure!(output.status.success(), "{program} {}: {}", arguments.join(" "), said.trim());
        Ok(())
    }
}

/// The machines. Packets from one to the other go through a third, where some of them are lost or wait.
pub(super) struct Net {
    pub(super) server: Machine,
    pub(super) page: Machine,
    /// The server's address.
    pub(super) address: &'static str,
    _relay: Option<Running>,
    _between: Machine,
}

impl Net {
    pub(super) fn new(faults: Faults) -> Result<Net> {
        let (server, page, between) = (Machine::new()?, Machine::new()?, Machine::new()?);
        for (machine, net) in [(&server, 1), (&page, 2)] {
            connect(machine, &between, net)?;
        }
        between.ends_well("sh", &["-c", "echo 1 > /proc/sys/net/ipv4/ip_forward"])?;
        if faults.megabits > 0 {
            // A short burst, or small frames would pass as on a quick line; a queue that is long enough to be seen.
            let limit = format!("rate {}mbit burst 32kbit latency 400ms", faults.megabits);
            server.does(&format!("tc qdisc add dev line root tbf {limit}"))?;
        }
        if faults.loss > 0 {
            // Between the machines: what is dropped where it is sent, TCP is told of.
            let hook = "type filter hook prerouting priority 0;";
            let rule = format!("numgen random mod 100 < {} drop;", faults.loss);
            between.ends_well("nft", &[&format!("table ip lines {{ chain lose {{ {hook} {rule} }}; }}")])?;
        }
        let relay = if faults.round_trip > 0 { Some(delay(&server, &page, &between, faults)?) } else { None };
        let address = if faults.round_trip > 0 { "10.199.3.1" } else { "10.199.1.1" };
        Ok(Net { server, page, address, _relay: relay, _between: between })
    }
}

/// A cable from a machine to the one between.
fn connect(machine: &Machine, between: &Machine, net: u32) -> Result<()> {
    let other = 3 - net;
    let (here, there) = (machine.pid(), between.pid());
    machine.does(&format!("ip link add line netns {here} type veth peer name line{net} netns {there}"))?;
    // Packets as they are on a cable: no bundles, of which one that is lost would be many.
    machine.does("ip link set line gso_max_segs 1 up")?;
    between.does(&format!("ip link set line{net} gso_max_segs 1 up"))?;
    machine.does(&format!("ip address add 10.199.{net}.1/24 dev line"))?;
    between.does(&format!("ip address add 10.199.{net}.2/24 dev line{net}"))?;
    machine.does(&format!("ip route add 10.199.{other}.0/24 via 10.199.{net}.2 congctl {CONGESTION}"))
}

/// A network of packets within datagrams (VXLAN), which a program passes on later. The kernel's own way to delay packets, netem,
/// is often not built in; this one needs nothing special either, and TCP sees a line that is long.
fn delay(server: &Machine, page: &Machine, between: &Machine, faults: Faults) -> Result<Running> {
    for (machine, net) in [(server, 1), (page, 2)] {
        let ends = format!("local 10.199.{net}.1 remote 10.199.{net}.2 dstport {}", relay::PORT);
        machine.does(&format!("ip link add far type vxlan id 7 {ends} nolearning dev line"))?;
        machine.does("ip link set far gso_max_segs 1 up")?;
        // The sums of what is in a datagram would be left to the cable, which has only the datagram.
        machine.does("ethtool -K far tx off")?;
        machine.does(&format!("ip address add 10.199.3.{net}/24 dev far"))?;
        machine.does(&format!(
            "ip route change 10.199.3.0/24 dev far proto kernel scope link src 10.199.3.{net} congctl {CONGESTION}"
        ))?;
    }
    let this = std::env::current_exe().context("cannot find this program")?;
    let mut command = between.command(this);
    command.args(["lines", relay::MODE, "10.199.1", "10.199.2", &(faults.round_trip * 1000 / 2).to_string()]);
    Ok(Running(command.stdin(Stdio::null()).spawn().context("cannot start the relay")?))
}
