//! `cargo xtask emulate`: the tests of pictures of GPUs, by a driver that executes PTX on CPUs.

use anyhow::{Result, ensure};
use std::fs;
use std::process::Command;

/// Runs the command.
pub(crate) fn run(arguments: &[String]) -> Result<()> {
    let root = crate::root();
    let target = std::env::var_os("CARGO_TARGET_DIR").map_or_else(|| root.join("target"), Into::into);
    let cargo = || {
        let mut cargo = Command::new(std::env::var_os("CARGO").unwrap_or("cargo".into()));
        cargo.current_dir(&root);
        cargo
    };
    let status =
        cargo().args(["build", "--locked", "-p", "eosphor-cuda", "--example", "cuda_emulator"]).status()?;
    ensure!(status.success(), "the emulator does not compile");
    // By the name that programs look for, and where no other one does.
    let folder = target.join("cuda-emulator");
    fs::create_dir_all(&folder)?;
    fs::copy(target.join("debug/examples/libcuda_emulator.so"), folder.join("libcuda.so"))?;
    let status = cargo()
        .args(["test", "--locked", "-p", "eosphor-cuda", "--test", "identity", "--test", "ways", "--"])
        .args(arguments)
        .env("LD_LIBRARY_PATH", &folder)
        .env("REQUIRE_GPU", "1")
        .env("CUDA_EMULATOR", "1")
        .status()?;
    ensure!(status.success(), "tests failed");
    Ok(())
}
