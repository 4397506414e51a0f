//! All libraries find the hits of a small sample, and bad input is refused.

use peer_harness::check;
use std::fs;
use std::path::Path;

const PROGRAM: &str = env!("CARGO_BIN_EXE_rust-peers");
const FILES: &str = env!("CARGO_TARGET_TMPDIR");

fn all_hits(library: &str) {
    let sample = check::sample(FILES, library);
    check::finds_all_hits(PROGRAM, library, &sample, &[]);
    check::finds_all_hits(PROGRAM, library, &sample, &["--batch", "7", "--quality", "low"]);
    check::finds_all_hits(PROGRAM, library, &sample, &["--threads", "2", "--quality", "medium"]);
}

#[test]
fn obvhs_bvh2_finds_all_hits() {
    all_hits("obvhs-bvh2");
}

#[test]
fn obvhs_cwbvh_finds_all_hits() {
    all_hits("obvhs-cwbvh");
}

#[test]
fn bvh_finds_all_hits() {
    all_hits("bvh");
}

#[test]
fn parry_finds_all_hits() {
    all_hits("parry");
}

#[test]
fn bad_arguments_are_refused() {
    let sample = check::sample(FILES, "arguments");
    let refuses =
        |library, flags: &[&str], message| check::refuses(PROGRAM, library, &sample, flags, message);
    refuses("no-such", &[], "no library is named 'no-such'");
    refuses("bvh", &["--repeats", "0"], "--repeats 0");
    refuses("bvh", &["--batch", "-1"], "--batch -1");
    refuses("bvh", &["--threads"], "--threads needs a value");
    refuses("bvh", &["--quality", "best"], "--quality best");
    refuses("bvh", &["--colour", "red"], "no flag is named --colour");
    refuses("bvh", &["another"], "usage");
    check::refuses(PROGRAM, "bvh", Path::new("/no/such/folder"), &[], "/no/such/folder/mesh.tris");
}

/// A sample with one file changed is refused with this message, which names the file.
fn refuses_changed(file: &str, change: impl Fn(&mut Vec<u8>), message: &str) {
    let sample = check::sample(FILES, "changed");
    let path = sample.join(file);
    let mut bytes = fs::read(&path).expect("the sample is there");
    change(&mut bytes);
    fs::write(&path, bytes).expect("the sample can be changed");
    check::refuses(PROGRAM, "bvh", &sample, &[], &format!("{file}: {message}"));
}

#[test]
fn bad_files_are_refused() {
    let word = |at: usize, bits: u32| {
        move |bytes: &mut Vec<u8>| bytes[4 * at..4 * at + 4].copy_from_slice(&bits.to_le_bytes())
    };
    refuses_changed("mesh.tris", |bytes| bytes.truncate(3), "is too short for a count");
    refuses_changed("mesh.tris", |bytes| bytes.truncate(100), "has 100 bytes; its count of 500 needs 18004");
    refuses_changed("mesh.tris", |bytes| bytes.push(0), "has 18005 bytes");
    refuses_changed("mesh.tris", word(0, u32::MAX), "has 18004 bytes; its count of 4294967295");
    refuses_changed("mesh.tris", |bytes| *bytes = vec![0; 4], "is empty");
    refuses_changed("mesh.tris", word(10, f32::NAN.to_bits()), "triangle 1 has a corner that is not finite");
    refuses_changed("primary.rays", word(1 + 8 + 4, f32::INFINITY.to_bits()), "ray 1 is none");
    refuses_changed("bounce.rays", |bytes| bytes.truncate(1000), "has 1000 bytes");
    refuses_changed("shuffled.hits", word(2, 500), "triangle 500 of 500");
    let fewer = |bytes: &mut Vec<u8>| {
        bytes.truncate(4 + 8 * 2999);
        word(0, 2999)(bytes);
    };
    refuses_changed("primary.hits", fewer, "2999 hits for 3000 rays");
    let sample = check::sample(FILES, "missing");
    fs::remove_file(sample.join("shuffled.rays")).expect("it is there");
    check::refuses(PROGRAM, "bvh", &sample, &[], "shuffled.rays");
    fs::create_dir(sample.join("shuffled.rays")).expect("nothing is there");
    check::refuses(PROGRAM, "bvh", &sample, &[], "is not a file");
}
