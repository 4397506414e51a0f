//! `cargo xtask fuzz [--asan] [--stage] [SECONDS [TARGET...]]`: builds the fuzz targets and runs them, all at a time.
//!
//! `--asan` builds them with AddressSanitizer, which makes them a few times slower.
//!
//! Targets that are named are the only ones that are built.
//!
//! `--stage` only puts programs and seeds into `.fuzz/` with a script `run SECONDS` for a machine without cargo.

use crate::root;
use anyhow::{Context, ensure};
use serde_json::Value;
use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

const TARGETS: [&str; 12] = [
    "obj",
    "mtl",
    "gltf",
    "glb",
    "ply",
    "json",
    "pg1",
    "texture",
    "picture",
    "builders",
    "traversals",
    "message",
];

/// What libFuzzer needs of the compiler; these are cargo-fuzz's, without a sanitizer. The readers have no unsafe
/// code to sanitize; the traversals have debug assertions where they index unchecked.
const RUSTFLAGS: &str = "-Cpasses=sancov-module -Cllvm-args=-sanitizer-coverage-level=4 \
    -Cllvm-args=-sanitizer-coverage-inline-8bit-counters -Cllvm-args=-sanitizer-coverage-pc-table \
    -Cllvm-args=-sanitizer-coverage-trace-compares --cfg fuzzing -Ccodegen-units=1";

/// Named, so that build scripts are compiled without these flags.
const PLATFORM: &str = "x86_64-unknown-linux-gnu";

/// Largest file that a seed may be: small ones find more.
const MAX_SEED: u64 = 20_000;

pub(crate) fn run(arguments: &[String]) -> anyhow::Result<()> {
    let mut rest = arguments;
    let mut option = |name: &str| {
        let is_given = rest.first().is_some_and(|a| a == name);
        rest = &rest[is_given as usize..];
        is_given
    };
    let (with_sanitizer, stage_only) = (option("--asan"), option("--stage"));
    let mut rest = rest.iter();
    let seconds: u64 = rest.next().map_or(Ok(600), |s| s.parse()).context("SECONDS is not a number")?;
    let chosen: Vec<&str> = rest.map(String::as_str).collect();
    let unknown = chosen.iter().find(|t| !TARGETS.contains(t));
    ensure!(unknown.is_none(), "there is no target {unknown:?}; there are {}", TARGETS.join(", "));
    let chosen = if chosen.is_empty() { TARGETS.to_vec() } else { chosen };
    let stage = stage(with_sanitizer, &chosen)?;
    println!("staged in {}", stage.display());
    if stage_only {
        return Ok(());
    }
    let status = Command::new("./run")
        .arg(seconds.to_string())
        .args(chosen)
        .current_dir(&stage)
        .status()
        .context("cannot run the targets")?;
    ensure!(status.success(), "a target has found something: see {}", stage.join("found").display());
    Ok(())
}

/// Builds the programs of these targets and gathers seeds; the folder.
fn stage(with_sanitizer: bool, targets: &[&str]) -> anyhow::Result<PathBuf> {
    let target = root().join(if with_sanitizer { "fuzz/target/asan" } else { "fuzz/target" });
    let mut cargo = Command::new("cargo");
    if with_sanitizer {
        // The runtime comes with the stable toolchain; the flag is unstable, so the compiler is told to allow it.
        cargo.env("RUSTC_BOOTSTRAP", "1").env("RUSTFLAGS", format!("{RUSTFLAGS} -Zsanitizer=address"));
    } else {
        cargo.env("RUSTFLAGS", RUSTFLAGS);
    }
    let status = cargo
        .args(["build", "--release", "--locked", "--target", PLATFORM, "--target-dir"])
        .arg(&target)
        .args(targets.iter().flat_map(|name| ["--bin", name]))
        .env_remove("CARGO_TARGET_DIR")
        .current_dir(root().join("fuzz"))
        .stdout(Stdio::null())
        .status()
        .context("cannot run cargo")?;
    ensure!(status.success(), "the build failed");
    let stage = root().join(".fuzz");
    let _ = fs::remove_dir_all(&stage);
    for &name in targets {
        fs::create_dir_all(stage.join("seeds").join(name))?;
        let program = stage.join(name);
        fs::copy(target.join(PLATFORM).join("release").join(name), &program)?;
        let _ = Command::new("strip").arg(&program).status();
        gather_seeds(name, &stage.join("seeds").join(name))?;
    }
    write_dictionaries(&stage)?;
    fs::write(stage.join("run"), RUN)?;
    let status = Command::new("chmod").arg("+x").arg(stage.join("run")).status()?;
    ensure!(status.success(), "chmod failed");
    Ok(stage)
}

/// Words of the formats, of which libFuzzer makes texts: keys and values of the scene files' schema, and those of glTF.
fn write_dictionaries(stage: &Path) -> anyhow::Result<()> {
    let folder = stage.join("dictionaries");
    fs::create_dir_all(&folder)?;
    let schema: Value = serde_json::from_str(&fs::read_to_string(root().join("scenes/schema.json"))?)?;
    let mut words = BTreeSet::new();
    collect_words(&schema, &mut words);
    let lines: Vec<String> = words.iter().map(|word| format!("\"\\\"{word}\\\"\"\n")).collect();
    fs::write(folder.join("json"), lines.concat())?;
    for target in ["gltf", "glb"] {
        fs::copy(root().join("fuzz/gltf.dict"), folder.join(target))?;
    }
    Ok(())
}

/// The names of properties, and the texts that values may be.
fn collect_words(schema: &Value, words: &mut BTreeSet<String>) {
    match schema {
        Value::Object(keys) => {
            let properties = keys.get("properties").and_then(Value::as_object);
            words.extend(properties.into_iter().flat_map(|properties| properties.keys().cloned()));
            let values = keys.get("enum").and_then(Value::as_array).into_iter().flatten();
            let values = values.chain(keys.get("const")).filter_map(Value::as_str);
            words.extend(values.map(str::to_owned));
            keys.values().for_each(|value| collect_words(value, words));
        }
        Value::Array(items) => items.iter().for_each(|item| collect_words(item, words)),
        Value::Null | Value::Bool(_) | Value::Number(_) | Value::String(_) => {}
    }
}

/// Small files of the target's kind: what earlier runs found, seeds, this repository's scenes, and the test scenes beside the
/// checkout where they are.
fn gather_seeds(target: &str, folder: &Path) -> anyhow::Result<()> {
    let endings: &[&str] = match target {
        // Bytes of which `fuzz/src/hits.rs` makes a world.
        "builders" | "traversals" => &["world"],
        "gltf" => &["gltf"],
        "glb" => &["glb"],
        "json" | "pg1" => &["json"],
        "texture" | "picture" => &["png", "jpg", "hdr", "exr", "data", "tga", "bmp", "ppm"],
        kind => &[kind],
    };
    let mut found = Vec::new();
    for place in
        ["fuzz/regressions", "fuzz/seeds", "scenes", "crates/scene/tests", "docs", "../shared/scenes"]
    {
        collect(&root().join(place), endings, &mut found);
    }
    for (number, path) in found.iter().enumerate() {
        let mut bytes = fs::read(path)?;
        if matches!(target, "texture" | "picture") {
            // The first byte chooses the kind.
            bytes.insert(0, number as u8);
        }
        fs::write(folder.join(format!("seed{number}")), bytes)?;
    }
    Ok(())
}

fn collect(folder: &Path, endings: &[&str], found: &mut Vec<PathBuf>) {
    let Ok(entries) = fs::read_dir(folder) else { return };
    for path in entries.flatten().map(|entry| entry.path()) {
        if path.is_dir() {
            collect(&path, endings, found);
        } else if path.extension().is_some_and(|e| endings.iter().any(|known| e.eq_ignore_ascii_case(known)))
            && path.metadata().is_ok_and(|m| m.len() <= MAX_SEED)
        {
            found.push(path);
        }
    }
}

/// Runs targets side by side; what they find goes to `found/`, a line for each to stdout.
const RUN: &str = r#"#!/usr/bin/env bash
# run SECONDS [TARGET...]
set -uo pipefail
cd "$(dirname "$(readlink -f "$0")")"
out=${OUT:-.}
# The sanitizer, where it is built in, keeps what was freed.
export ASAN_OPTIONS=quarantine_size_mb=64:detect_leaks=0
seconds=$1; shift
[ $# -gt 0 ] || set -- obj mtl gltf glb ply json pg1 texture picture builders traversals message
mkdir -p "$out/found" "$out/logs"
for target in "$@"; do
  mkdir -p "corpus/$target"
  words=()
  [ ! -f "dictionaries/$target" ] || words=(-dict="dictionaries/$target")
  RUST_BACKTRACE=1 ./"$target" "corpus/$target" "seeds/$target" "${words[@]}" -max_total_time="$seconds" -timeout=10 -rss_limit_mb=2048 \
    -max_len=20000 -artifact_prefix="$out/found/$target-" >"$out/logs/$target.txt" 2>&1 &
done
wait
failed=0
for target in "$@"; do
  done_line=$(grep -a '^Done ' "$out/logs/$target.txt" || echo "stopped early")
  echo "$target: $done_line, $(ls "corpus/$target" | wc -l) new inputs, $(ls "$out/found" | grep -c "^$target-") found"
  grep -aq '^Done ' "$out/logs/$target.txt" || failed=1
done
exit $failed
"#;
