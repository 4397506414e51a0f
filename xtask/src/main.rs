//! The project's own commands: `cargo xtask COMMAND`.

mod albedo;
mod asan;
mod browser;
mod emulate;
mod fma;
mod fuzz;
mod instructions;
mod kills;
mod lab;
mod lines;
mod ptx;
mod sheet;
mod structures;
mod tables;
mod tidy;
mod tour;

use anyhow::Context;
use std::path::PathBuf;
use std::process::ExitCode;

/// A command: its name, what it does, and the function that takes its arguments.
type Command = (&'static str, &'static str, fn(&[String]) -> anyhow::Result<()>);

const COMMANDS: &[Command] = &[
    (
        "albedo",
        "make the tables of what rough mirrors and rough glass lose by single scattering",
        albedo::run,
    ),
    (
        "asan",
        "run the tests of unsafe code under AddressSanitizer, or in the release profile with debug assertions [--release]",
        asan::run,
    ),
    ("browser", "try the page of eosphor view in headless Chromium [SECONDS]", browser::run),
    (
        "ptx",
        "build the GPU kernels into crates/cuda/ptx; --check only verifies what is there, --registers what it takes",
        ptx::run,
    ),
    (
        "emulate",
        "run the tests of GPU pictures on CPUs, by a driver that executes PTX [TEST...]",
        emulate::run,
    ),
    ("fma", "check that AVX2 and AVX-512 code calls no library fma [BINARY]", fma::run),
    ("fuzz", "run the fuzz targets [--asan] [--stage] [SECONDS [TARGET...]]", fuzz::run),
    (
        "instructions",
        "count the instructions of the cases of benches/, and compare with their figures; --write renews those",
        instructions::run,
    ),
    (
        "kills",
        "kill renders at random moments and let them go on [--stills N] [--ranks N] [--sequences N] [--backend NAME] [--program PATH]",
        kills::run,
    ),
    (
        "lab",
        "try whether eosphor lab lies: known truths on a quiet machine and beside other work [CASE...] [--runs N]",
        lab::run,
    ),
    (
        "lines",
        "try eosphor view over slow, far and lossy lines, and a tunnel [SECONDS [CASE...]]",
        lines::run,
    ),
    (
        "sheet",
        "render a contact sheet of models, modes and materials to look at [--models] [OUT.png]",
        sheet::run,
    ),
    (
        "structures",
        "measure every structure and builder, and write the tables of docs/accel-speed.md [--quick] [SCENES_DIR]",
        structures::run,
    ),
    (
        "tables",
        "check that the tables of READMEs are those of the runs that they name; --write makes them anew",
        tables::run,
    ),
    (
        "tidy",
        "check that the tree is as the pages say: paths, crates, circles of modules, what only some files may do",
        tidy::run,
    ),
    ("tour", "run the commands that README.md and docs/ show, as they stand there [DOCUMENT...]", tour::run),
];

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let chosen = arguments.first().and_then(|name| COMMANDS.iter().find(|command| command.0 == name));
    let Some((name, _, run)) = chosen else {
        eprintln!("usage: cargo xtask COMMAND\n");
        COMMANDS.iter().for_each(|(name, help, _)| eprintln!("  {name:12} {help}"));
        return ExitCode::from(2);
    };
    match run(&arguments[1..]) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("xtask {name}: {error:#}");
            ExitCode::FAILURE
        }
    }
}

/// The root of the repository.
fn root() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("..")
}

/// The program: the one that `EOSPHOR_PROGRAM` names, or a fresh one.
fn build_program() -> anyhow::Result<PathBuf> {
    if let Some(program) = std::env::var_os("EOSPHOR_PROGRAM") {
        return Ok(program.into());
    }
    let status = std::process::Command::new("cargo")
        .args(["build", "--release", "--locked", "-p", "eosphor-cli"])
        .current_dir(root())
        .status()
        .context("cannot run cargo")?;
    anyhow::ensure!(status.success(), "the build failed");
    let target = std::env::var("CARGO_TARGET_DIR").map_or_else(|_| root().join("target"), PathBuf::from);
    Ok(target.join("release/eosphor"))
}
