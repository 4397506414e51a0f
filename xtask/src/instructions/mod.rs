//! `instructions`: counts the instructions of the small cases of `benches/` under Valgrind, and compares them with
//! `benches/instructions.json`. Instructions do not depend on what else the machine does, as times do; they do depend on
//! compiler and C library, which the file names. With others, and where a tool is missing, it says `SKIPPED` and passes.

mod figures;

use crate::root;
use anyhow::{Context, Result, bail, ensure};
use figures::{Conditions, Figures};
use std::collections::BTreeMap;
use std::ffi::OsString;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

const FILE: &str = "benches/instructions.json";

pub(crate) fn run(arguments: &[String]) -> Result<()> {
    let write = match arguments {
        [] => false,
        [flag] if flag == "--write" => true,
        _ => bail!("usage: cargo xtask instructions [--write]"),
    };
    let file = root().join(FILE);
    let missing = missing_tool()?;
    if write {
        ensure!(missing.is_none(), "{}", missing.unwrap_or_default());
        let figures = Figures { conditions: conditions()?, instructions: count()? };
        fs::write(&file, figures.to_json()).context(FILE)?;
        println!("{FILE}: {} figures", figures.instructions.len());
        return Ok(());
    }
    let before = Figures::parse(&fs::read_to_string(&file).context(FILE)?).context(FILE)?;
    if let Some(reason) = missing.or(before.conditions.other_than(&conditions()?)) {
        println!("instructions: SKIPPED: {reason}");
        return Ok(());
    }
    let compared = before.compare(&count()?);
    compared.lines.iter().for_each(|line| println!("{line}"));
    ensure!(compared.wrong.is_empty(), "{}", compared.wrong.join("\n"));
    Ok(())
}

/// What counts depend on, here.
fn conditions() -> Result<Conditions> {
    let compiler = output("rustc", &["-vV"])?.context("cannot run rustc")?;
    let of_compiler = |key: &str| {
        let line = compiler.lines().find_map(|line| line.strip_prefix(key));
        line.map(|value| value.trim().to_owned()).with_context(|| format!("rustc -vV has no {key}"))
    };
    let c_library = output("getconf", &["GNU_LIBC_VERSION"])?;
    Ok(Conditions {
        rustc: of_compiler("release:")?,
        target: of_compiler("host:")?,
        c_library: c_library.map_or("unknown".into(), |version| version.trim().to_owned()),
    })
}

/// What stands in the way of counting here.
fn missing_tool() -> Result<Option<String>> {
    #[cfg(target_arch = "x86_64")]
    let has_avx2 = is_x86_feature_detected!("avx2") && is_x86_feature_detected!("fma");
    #[cfg(not(target_arch = "x86_64"))]
    let has_avx2 = false;
    if !has_avx2 {
        return Ok(Some("this CPU has no AVX2, which is counted".into()));
    }
    if output("valgrind", &["--version"])?.is_none() {
        return Ok(Some("there is no valgrind; .ci/install-gungraun installs it".into()));
    }
    let wanted = locked_version("gungraun-runner")?;
    let found = output(&runner().to_string_lossy(), &["--version"])?.unwrap_or("none".into());
    let is_wanted = found.trim().ends_with(&format!(" {wanted}"));
    Ok((!is_wanted).then(|| {
        let found = found.trim();
        format!(
            "there must be gungraun-runner {wanted}, and there is {found}; .ci/install-gungraun installs it"
        )
    }))
}

/// The version of a package in Cargo.lock. The harness and its runner must be of one.
fn locked_version(package: &str) -> Result<String> {
    let lock = fs::read_to_string(root().join("Cargo.lock")).context("Cargo.lock")?;
    let start = format!("name = \"{package}\"\nversion = \"");
    let version = lock.split_once(&start).and_then(|(_, rest)| rest.split_once('"'));
    Ok(version.with_context(|| format!("Cargo.lock has no {package}"))?.0.to_owned())
}

/// Cargo's folder, from the root of the file system: benchmarks run in another folder.
fn target() -> PathBuf {
    let target = std::env::var("CARGO_TARGET_DIR").map_or_else(|_| root().join("target"), PathBuf::from);
    std::path::absolute(&target).unwrap_or(target)
}

/// Where `.ci/install-gungraun` puts it.
fn runner() -> PathBuf {
    target().join("gungraun/bin/gungraun-runner")
}

/// What a program prints; `None` where it is not there or fails.
fn output(program: &str, arguments: &[&str]) -> Result<Option<String>> {
    match Command::new(program).args(arguments).current_dir(root()).output() {
        Ok(output) if output.status.success() => Ok(Some(String::from_utf8(output.stdout)?)),
        _ => Ok(None),
    }
}

/// Counts all cases.
fn count() -> Result<BTreeMap<String, u64>> {
    let home = target().join("instructions");
    // Earlier results would be compared with, or taken for those of cases that are no more.
    if home.exists() {
        fs::remove_dir_all(&home).with_context(|| format!("cannot clear {}", home.display()))?;
    }
    let places = std::env::var_os("PATH").unwrap_or_default();
    let folder = runner().parent().map(Path::to_owned);
    let path: OsString = std::env::join_paths(folder.into_iter().chain(std::env::split_paths(&places)))?;
    // Together with the program, so that both share what is compiled (.ci/run).
    let benches = ["-p", "eosphor-cli", "-p", "eosphor-benches", "--bench", "instructions"];
    let counted = Command::new("cargo")
        .args(["bench", "--locked", "--quiet"])
        .args(benches)
        .current_dir(root())
        .env("PATH", path)
        .env("GUNGRAUN_HOME", &home)
        .env("GUNGRAUN_SAVE_SUMMARY", "json")
        .output()
        .context("cannot run cargo")?;
    let said = || [&counted.stdout[..], &counted.stderr].map(String::from_utf8_lossy).join("\n");
    ensure!(counted.status.success(), "the benchmarks failed:\n{}", said());
    let mut counts = BTreeMap::new();
    summaries(&home, &mut counts)?;
    Ok(counts)
}

/// Reads what the runner left for each case, in folders below this one.
fn summaries(folder: &Path, counts: &mut BTreeMap<String, u64>) -> Result<()> {
    for entry in fs::read_dir(folder).with_context(|| format!("cannot read {}", folder.display()))? {
        let path = entry?.path();
        if path.is_dir() {
            summaries(&path, counts)?;
        } else if path.ends_with("summary.json") {
            let (name, count) = figures::of_summary(&fs::read_to_string(&path)?)
                .with_context(|| path.display().to_string())?;
            counts.insert(name, count);
        }
    }
    Ok(())
}
