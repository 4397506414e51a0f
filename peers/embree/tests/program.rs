//! Embree finds the hits of a small sample. It has to be fetched before: peers/build.

use peer_harness::check;
use std::path::Path;
use std::process::Command;

const PROGRAM: &str = env!("CARGO_BIN_EXE_embree-peer");
const FILES: &str = env!("CARGO_TARGET_TMPDIR");

fn all_hits(library: &str) {
    let sample = check::sample(FILES, library);
    check::finds_all_hits(PROGRAM, library, &sample, &[]);
    // 7 is no multiple of a packet's width.
    check::finds_all_hits(PROGRAM, library, &sample, &["--batch", "7", "--quality", "low"]);
    check::finds_all_hits(PROGRAM, library, &sample, &["--threads", "2", "--quality", "medium"]);
}

#[test]
fn single_rays_find_all_hits() {
    all_hits("embree");
}

#[test]
fn packets_find_all_hits() {
    all_hits("embree-packets");
}

#[test]
fn what_cannot_be_read_or_opened_is_refused() {
    check::refuses(PROGRAM, "embree", Path::new("/no/such/folder"), &[], "/no/such/folder/mesh.tris");
    let sample = check::sample(FILES, "refused");
    let output =
        Command::new(PROGRAM).arg("embree").arg(&sample).env("EMBREE_LIBRARY", "/no/such.so").output();
    let output = output.expect("the program can be started");
    let errors = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "{errors}");
    assert!(errors.contains("cannot open Embree (/no/such.so)") && errors.lines().count() == 1, "{errors}");
}
