//! `cargo xtask browser [SECONDS [PROCESSES]]`: the viewer's page in headless Chromium, with the program as users build it; latency
//! is measured for so many seconds of so many servers. Needs Node.js and Chromium (`apt-get install nodejs npm chromium`); npm
//! brings what drives the browser. Screenshots go to `target/browser/`.

use crate::{build_program, root};
use anyhow::{Context, ensure};
use std::fs;
use std::process::Command;

/// Names of Chromium.
const BROWSERS: [&str; 4] = ["chromium", "chromium-browser", "google-chrome", "chrome"];

pub(crate) fn run(arguments: &[String]) -> anyhow::Result<()> {
    let number = |at: usize, name: &'static str, default| {
        let text = arguments.get(at).map_or(default, String::as_str);
        text.parse::<u32>()
            .with_context(|| format!("{name} is not a number"))
            .map(|number| number.to_string())
    };
    let (seconds, processes) = (number(0, "SECONDS", "10")?, number(1, "PROCESSES", "1")?);
    let path = std::env::var_os("PATH").unwrap_or_default();
    let candidates = std::env::split_paths(&path).flat_map(|folder| BROWSERS.map(|name| folder.join(name)));
    let chromium = candidates
        .into_iter()
        .find(|file| file.is_file())
        .context("no Chromium: apt-get install chromium")?;
    let program = build_program()?;
    let folder = root().join("target/browser");
    fs::create_dir_all(&folder).with_context(|| format!("cannot make {}", folder.display()))?;
    for name in ["package.json", "check.mjs"] {
        let from = root().join("xtask/browser").join(name);
        fs::copy(&from, folder.join(name)).with_context(|| format!("cannot copy {}", from.display()))?;
    }
    let done = |command: &mut Command, what: &str| {
        let status = command.current_dir(&folder).status().with_context(|| format!("cannot run {what}"))?;
        ensure!(status.success(), "{what} failed: see above");
        Ok(())
    };
    done(Command::new("npm").args(["install", "--no-audit", "--no-fund", "--silent"]), "npm")?;
    let mut check = Command::new("node");
    check.arg("check.mjs").arg(program).arg(root().join("scenes")).arg(&folder).arg(chromium).arg(seconds);
    check.arg(processes);
    done(&mut check, "node")
}
