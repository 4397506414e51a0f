//! `cargo xtask lines [SECONDS [CASE...]]`: the viewer over bad lines, between network namespaces, against what is promised of it.
//! Needs Linux and root, `ip`, `tc`, `nft`, `ethtool`, and `sshd` (`apt-get install iproute2 nftables ethtool openssh-server`).

mod net;
mod relay;
mod tunnel;

use crate::{build_program, root};
use anyhow::{Context, Result, bail, ensure};
use net::{Faults, Net, Running};
use serde_json::Value;
use std::fs;
use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use tunnel::Tunnel;

/// What it runs, and the packages that have it.
const PROGRAMS: [(&str, &str); 10] = [
    ("ip", "iproute2"),
    ("tc", "iproute2"),
    ("nft", "nftables"),
    ("ethtool", "ethtool"),
    ("sshd", "openssh-server"),
    ("ssh", "openssh-client"),
    ("ssh-keygen", "openssh-client"),
    ("unshare", "util-linux"),
    ("nsenter", "util-linux"),
    ("setpriv", "util-linux"),
];

/// Where these are, besides the folders of `PATH`.
const FOLDERS: [&str; 3] = ["/usr/local/sbin", "/usr/sbin", "/sbin"];

/// A case is looked at in so many parts: where it lasts five minutes, these are minutes.
const PARTS: usize = 5;

/// Seconds of a case; those without a limit of rate have no queue that could grow, and last no more than the second number.
const SECONDS: f64 = 50.0;
const SHORT: f64 = 60.0;

const SMALL: &[&str] = &["builtin:cornell", "--size", "640x360", "--shadows", "coloured"];

/// What is rendered quickly, so that the line is the limit.
const LARGE: &[&str] =
    &["builtin:cornell", "--size", "1920x1080", "--shadows", "none", "--depth", "1", "--light-samples", "1"];

/// What is promised.
#[derive(Clone, Copy)]
enum Goal {
    /// Nothing: it is there to compare with.
    Reference,
    /// Milliseconds from input to picture, in the median.
    Latency(f64),
    /// So many frames a second, and no queue: the last part is as quick as the first, but for so much.
    Rate(f64, f64),
    /// No longer time without a frame, in milliseconds.
    Gap(f64),
}

struct Case {
    name: &'static str,
    what: &'static str,
    faults: Faults,
    flags: &'static [&'static str],
    by_ssh: bool,
    goal: Goal,
}

const CLEAN: Faults = Faults { round_trip: 0, megabits: 0, loss: 0 };
const REFERENCE: Case = Case {
    name: "clean",
    what: "no faults",
    faults: CLEAN,
    flags: SMALL,
    by_ssh: false,
    goal: Goal::Reference,
};

const CASES: [Case; 9] = [
    REFERENCE,
    Case {
        name: "far",
        what: "50 ms round trip",
        faults: Faults { round_trip: 50, ..CLEAN },
        goal: Goal::Latency(120.0),
        ..REFERENCE
    },
    Case {
        name: "slow",
        what: "10 Mbit/s",
        faults: Faults { megabits: 10, ..CLEAN },
        goal: Goal::Rate(15.0, 1.2),
        ..REFERENCE
    },
    Case {
        name: "slow-large",
        what: "10 Mbit/s, 1920 x 1080",
        faults: Faults { megabits: 10, ..CLEAN },
        flags: LARGE,
        goal: Goal::Rate(15.0, 1.2),
        ..REFERENCE
    },
    Case {
        name: "slower-large",
        what: "2 Mbit/s, 1920 x 1080",
        faults: Faults { megabits: 2, ..CLEAN },
        flags: LARGE,
        ..REFERENCE
    },
    Case {
        name: "lossy",
        what: "2 % loss",
        faults: Faults { loss: 2, ..CLEAN },
        goal: Goal::Gap(1000.0),
        ..REFERENCE
    },
    Case { name: "ssh", what: "ssh -L", by_ssh: true, ..REFERENCE },
    Case {
        name: "far-slow",
        what: "50 ms, 10 Mbit/s, 1920 x 1080",
        faults: Faults { round_trip: 50, megabits: 10, loss: 0 },
        flags: LARGE,
        ..REFERENCE
    },
    Case {
        name: "far-lossy",
        what: "50 ms, 2 % loss",
        faults: Faults { round_trip: 50, megabits: 0, loss: 2 },
        ..REFERENCE
    },
];

/// What a page measured in a part of the time.
struct Part {
    frames_per_second: f64,
    median: f64,
    p95: f64,
    longest_gap: f64,
    bytes_per_second: f64,
    bytes_per_frame: f64,
    /// Least, middle and largest.
    widths: [f64; 3],
}

pub(crate) fn run(arguments: &[String]) -> Result<()> {
    if let Some((first, rest)) = arguments.split_first()
        && first == relay::MODE
    {
        return relay::run(rest);
    }
    let seconds: f64 = match arguments.first() {
        Some(text) => text.parse().context("SECONDS is not a number")?,
        None => SECONDS,
    };
    let wanted = arguments.get(1..).unwrap_or_default();
    if let Some(unknown) = wanted.iter().find(|name| CASES.iter().all(|case| case.name != **name)) {
        bail!("there is no case {unknown}; there are: {}", CASES.map(|case| case.name).join(", "));
    }
    check_programs()?;
    let programs = (fs::canonicalize(build_program()?)?, fs::canonicalize(build_page()?)?);
    println!("| line | part | frames/s | median | 95 % | longest gap | width | kB/frame | Mbit/s |");
    println!("|---|---|---|---|---|---|---|---|---|");
    let mut missed = Vec::new();
    for case in CASES.iter().filter(|case| wanted.is_empty() || wanted.iter().any(|name| name == case.name)) {
        let seconds = if matches!(case.goal, Goal::Rate(..)) { seconds } else { seconds.min(SHORT) };
        let parts = case.measure(&programs, seconds).with_context(|| case.name)?;
        parts.iter().enumerate().for_each(|(k, part)| part.print(case.what, k + 1));
        missed.extend(case.missed(&parts).map(|what| format!("{}: {what}", case.what)));
    }
    ensure!(missed.is_empty(), "missed: {}", missed.join("; "));
    Ok(())
}

/// Says which programs are missing, and what to install.
fn check_programs() -> Result<()> {
    let path = std::env::var_os("PATH").unwrap_or_default();
    let folders: Vec<PathBuf> = std::env::split_paths(&path).chain(FOLDERS.map(PathBuf::from)).collect();
    let missing: Vec<_> = PROGRAMS
        .iter()
        .filter(|(name, _)| !folders.iter().any(|folder| folder.join(name).is_file()))
        .collect();
    let names: Vec<&str> = missing.iter().map(|(name, _)| *name).collect();
    let packages: Vec<&str> = missing.iter().map(|(_, package)| *package).collect();
    ensure!(missing.is_empty(), "no {}: apt-get install {}", names.join(", "), packages.join(" "));
    Ok(())
}

/// The page as a program.
fn build_page() -> Result<PathBuf> {
    let status = Command::new("cargo")
        .args(["build", "--release", "--locked", "-p", "eosphor-viewer", "--example", "page"])
        .current_dir(root())
        .status()
        .context("cannot run cargo")?;
    ensure!(status.success(), "the build of the page failed");
    let target = std::env::var("CARGO_TARGET_DIR").map_or_else(|_| root().join("target"), PathBuf::from);
    Ok(target.join("release/examples/page"))
}

impl Case {
    fn measure(&self, programs: &(PathBuf, PathBuf), seconds: f64) -> Result<Vec<Part>> {
        let (program, page) = programs;
        let net = Net::new(self.faults)?;
        let folder = std::env::temp_dir().join(format!("eosphor-lines-{}", std::process::id()));
        fs::create_dir_all(&folder)?;
        let measured = if self.by_ssh {
            let (_tunnel, url) = Tunnel::open(&net, &folder, program, self.flags)?;
            measure(&net, page, &url, seconds)?
        } else {
            let (_viewer, url) = view(&net, program, self.flags)?;
            measure(&net, page, &url, seconds)?
        };
        fs::remove_dir_all(&folder)?;
        Ok(measured)
    }

    /// What of the promise is not kept.
    fn missed(&self, parts: &[Part]) -> Option<String> {
        let worst = |value: fn(&Part) -> f64| parts.iter().map(value).fold(f64::NAN, f64::max);
        match self.goal {
            Goal::Reference => None,
            Goal::Latency(most) => {
                let median = worst(|part| part.median);
                (!(median <= most)).then(|| format!("median {median:.0} ms, not {most:.0}"))
            }
            Goal::Rate(least, growth) => {
                let rate = -worst(|part| -part.frames_per_second);
                let grown = parts.last()?.median / parts.first()?.median;
                let is_kept = rate >= least && grown <= growth;
                (!is_kept).then(|| format!("{rate:.1} frames/s, not {least:.0}, or grown by {grown:.2}"))
            }
            Goal::Gap(most) => {
                let gap = worst(|part| part.longest_gap);
                (!(gap <= most)).then(|| format!("{gap:.0} ms without a frame, not {most:.0}"))
            }
        }
    }
}

/// A viewer on the one machine, with its address.
fn view(net: &Net, program: &Path, flags: &[&str]) -> Result<(Running, String)> {
    let mut command = net.server.command(program);
    command.arg("view").args(flags).args(["--no-open", "--listen", net.address]);
    let viewer = command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::null()).spawn();
    let mut viewer = Running(viewer.context("cannot start the viewer")?);
    let mut url = String::new();
    BufReader::new(viewer.0.stdout.take().context("no output")?).read_line(&mut url)?;
    ensure!(url.starts_with("http://"), "the viewer does not start: {url}");
    Ok((viewer, url))
}

/// A page on the other.
fn measure(net: &Net, page: &Path, url: &str, seconds: f64) -> Result<Vec<Part>> {
    let mut command = net.page.command(page);
    command.args(["--connect", url.trim(), &seconds.to_string(), &PARTS.to_string()]);
    let output =
        command.stdin(Stdio::null()).stderr(Stdio::inherit()).output().context("cannot run the page")?;
    ensure!(output.status.success(), "the page failed");
    String::from_utf8(output.stdout)?.lines().map(Part::read).collect()
}

impl Part {
    fn read(line: &str) -> Result<Part> {
        let json: Value = serde_json::from_str(line)?;
        // Without a frame there is no median, say.
        let number = |value: &Value| value.as_f64().unwrap_or(f64::NAN);
        Ok(Part {
            frames_per_second: number(&json["frames-per-second"]),
            median: number(&json["median"]),
            p95: number(&json["p95"]),
            longest_gap: number(&json["longest-gap"]),
            bytes_per_second: number(&json["bytes-per-second"]),
            bytes_per_frame: number(&json["bytes-per-frame"]),
            widths: [0, 1, 2].map(|k| number(&json["widths"][k])),
        })
    }

    fn print(&self, what: &str, number: usize) {
        let [least, middle, largest] = self.widths;
        println!(
            "| {what} | {number} | {:.1} | {:.0} ms | {:.0} ms | {:.0} ms | {middle:.0} ({least:.0} to {largest:.0}) | {:.1} | {:.2} |",
            self.frames_per_second,
            self.median,
            self.p95,
            self.longest_gap,
            self.bytes_per_frame / 1e3,
            self.bytes_per_second * 8e-6
        );
    }
}
