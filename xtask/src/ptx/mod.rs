//! `cargo xtask ptx`: compiles `gpu/` to PTX, the text that NVIDIA's driver compiles for the card it finds.
//!
//! The PTX is committed, so users need no special compiler. Its header names a hash of the sources; a plain test
//! compares, so that it cannot fall behind them.

#[path = "../../../crates/cuda/src/ptx_text.rs"]
mod ptx_text;
mod ptxas;
mod registers;
mod sources;
mod text;
mod tokens;
mod toolchain;

use anyhow::{Context, Result, bail};
use std::fs;
use std::path::{Path, PathBuf};
use toolchain::Toolchain;

/// One flag each. sm_75 (Turing) runs as fast on newer chips as PTX made for them, and loads on all.
const FLAGS: [&str; 3] = ["-Ctarget-cpu=sm_75", "-Clinker=/bin/true", "--emit=asm"];

const TARGET: &str = "nvptx64-nvidia-cuda";

const OUTPUT: &str = "crates/cuda/ptx/eosphor.ptx";

/// Runs the command.
pub(crate) fn run(arguments: &[String]) -> Result<()> {
    let root = crate::root();
    match arguments {
        [] => write(&root),
        [flag] if flag == "--check" => check(&root),
        [flag] if flag == "--registers" => {
            check(&root)?;
            registers::check(&root.join(OUTPUT))
        }
        _ => bail!("usage: cargo xtask ptx [--check | --registers]"),
    }
}

/// Builds the PTX and writes it, unless there is something wrong with it.
fn write(root: &Path) -> Result<()> {
    let toolchain = Toolchain::find()?;
    eprintln!("compiler: {}", toolchain.version);
    let hash = sources::hash(root, &toolchain.version, &FLAGS)?;
    let body = text::with_launch_bounds(&text::without_exported_tables(&compile(root, &toolchain)?));
    if hash != sources::hash(root, &toolchain.version, &FLAGS)? {
        bail!("the sources (or gpu/Cargo.lock) changed meanwhile: run it again");
    }
    let ptx = text::with_header(&body, &hash, &toolchain.version, &FLAGS);
    let problems = text::problems(&ptx);
    if !problems.is_empty() {
        let rejected = target_dir(root).join("rejected.ptx");
        fs::write(&rejected, &ptx)?;
        bail!("the PTX is not as it must be ({}): {}", rejected.display(), problems.join("; "));
    }
    let output = root.join(OUTPUT);
    fs::create_dir_all(output.parent().expect("the output is in a folder"))?;
    fs::write(&output, &ptx).with_context(|| format!("writing {OUTPUT}"))?;
    eprintln!("{OUTPUT}: {} bytes", ptx.len());
    Ok(())
}

/// Verifies that the committed PTX is of the present sources and as it must be.
fn check(root: &Path) -> Result<()> {
    let ptx = fs::read_to_string(root.join(OUTPUT)).with_context(|| format!("reading {OUTPUT}"))?;
    let header = text::Header::read(&ptx).with_context(|| format!("{OUTPUT} has no header"))?;
    let mut problems = text::problems(&ptx);
    if header.flags != FLAGS.join(" ") {
        problems.push("the compiler's flags have changed".into());
    }
    if header.hash != sources::hash(root, header.compiler, &FLAGS)? {
        problems.push("gpu/ or crates/core have changed since it was made".into());
    }
    if problems.is_empty() {
        return Ok(());
    }
    bail!("{OUTPUT}: {}; run `cargo xtask ptx`", problems.join("; "))
}

fn target_dir(root: &Path) -> PathBuf {
    match std::env::var_os("CARGO_TARGET_DIR") {
        Some(dir) => PathBuf::from(dir).join("ptx"),
        None => root.join("gpu/target"),
    }
}

/// The compiler's own output.
fn compile(root: &Path, toolchain: &Toolchain) -> Result<String> {
    let target_dir = target_dir(root);
    let status = toolchain
        .cargo()
        .args(["build", "--release", "-Zbuild-std=core", "--target", TARGET])
        .current_dir(root.join("gpu"))
        .env("CARGO_ENCODED_RUSTFLAGS", FLAGS.join("\u{1f}"))
        .env("CARGO_TARGET_DIR", &target_dir)
        .status()
        .context("starting cargo")?;
    if !status.success() {
        bail!("the kernels do not compile");
    }
    let assembly = target_dir.join(TARGET).join("release/deps/eosphor_gpu.s");
    fs::read_to_string(&assembly).with_context(|| format!("reading {}", assembly.display()))
}

#[cfg(test)]
mod tests {
    #[test]
    fn the_committed_ptx_is_current_and_sound() {
        if let Err(error) = super::check(&crate::root()) {
            panic!("{error:#}");
        }
    }
}
