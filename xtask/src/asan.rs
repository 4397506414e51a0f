//! `cargo xtask asan [--release] [-- TEST_ARGUMENTS]`: tests of core and accel, and the programs that mean harm, under
//! AddressSanitizer. With `--release` the same in the release profile with debug assertions instead.
//!
//! The sanitizer's runtime comes with the stable toolchain; its flag is unstable, so the compiler is told to allow it.

use crate::root;
use anyhow::{Context, ensure};
use std::process::Command;

/// Named, so that build scripts and procedural macros are compiled without these flags.
const PLATFORM: &str = "x86_64-unknown-linux-gnu";

/// Which tests run: those of the crates with unsafe code in the way of a ray, and of the one that shades.
const CRATES: [&[&str]; 3] = [
    &["-p", "eosphor-core", "--lib", "--tests"],
    &["-p", "eosphor-accel", "--lib", "--tests"],
    &["-p", "eosphor-render", "--test", "all", "adversarial"],
];

pub(crate) fn run(arguments: &[String]) -> anyhow::Result<()> {
    let in_release = arguments.first().is_some_and(|a| a == "--release");
    let rest = &arguments[in_release as usize..];
    let target = root().join("target").join(if in_release { "checked-release" } else { "asan" });
    for tests in CRATES {
        let mut cargo = Command::new("cargo");
        cargo.args(["test", "--locked", "--target", PLATFORM]).args(tests).args(rest);
        cargo.current_dir(root()).env("CARGO_TARGET_DIR", &target);
        if in_release {
            cargo.args(["--release"]).env("CARGO_PROFILE_RELEASE_DEBUG_ASSERTIONS", "true");
            cargo.env("CARGO_PROFILE_RELEASE_OVERFLOW_CHECKS", "true");
        } else {
            cargo.env("RUSTC_BOOTSTRAP", "1").env("RUSTFLAGS", "-Zsanitizer=address");
            // The sanitizer keeps what was freed; arrays of a million triangles would be kept many times.
            cargo.env("ASAN_OPTIONS", "quarantine_size_mb=64:detect_leaks=0");
        }
        let status = cargo.status().context("cannot run cargo")?;
        ensure!(status.success(), "the tests of {} failed: see above", tests[1]);
    }
    Ok(())
}
