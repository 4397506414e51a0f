//! A hash of everything that the PTX is made from: of Rust sources their tokens, so that comments, tests and formatting do not
//! count, of other files their bytes.

use super::tokens;
use anyhow::{Context, Result};
use sha2::{Digest, Sha256};
use std::fs;
use std::path::{Path, PathBuf};

/// Files and folders, relative to the root.
const SOURCES: [&str; 5] =
    ["crates/core/Cargo.toml", "crates/core/src", "gpu/Cargo.lock", "gpu/Cargo.toml", "gpu/src"];

/// SHA-256, in hexadecimal, of paths and contents of the sources, and of compiler and flags.
pub(super) fn hash(root: &Path, compiler: &str, flags: &[&str]) -> Result<String> {
    let mut files = Vec::new();
    for source in SOURCES {
        collect(root, source.into(), &mut files)?;
    }
    files.sort();
    let mut hasher = Sha256::new();
    // Lengths go first, so that no two sets of inputs look the same.
    let mut add = |bytes: &[u8]| {
        hasher.update((bytes.len() as u64).to_le_bytes());
        hasher.update(bytes);
    };
    add(compiler.as_bytes());
    add(flags.join(" ").as_bytes());
    for file in &files {
        add(file.as_bytes());
        let bytes = fs::read(root.join(file)).with_context(|| format!("reading {file}"))?;
        match file.strip_suffix(".rs") {
            Some(_) => {
                add(tokens::of_source(std::str::from_utf8(&bytes)?).with_context(|| file.clone())?.as_bytes())
            }
            None => add(&bytes),
        }
    }
    Ok(hasher.finalize().iter().map(|byte| format!("{byte:02x}")).collect())
}

/// Adds the file, or all files below the folder, as paths from the root with forward slashes.
fn collect(root: &Path, path: String, files: &mut Vec<String>) -> Result<()> {
    let full: PathBuf = root.join(&path);
    if !full.is_dir() {
        files.push(path);
        return Ok(());
    }
    for entry in fs::read_dir(&full).with_context(|| format!("reading {path}"))? {
        let name = entry?.file_name();
        let name = name.to_str().with_context(|| format!("a file name in {path} is not Unicode"))?;
        collect(root, format!("{path}/{name}"), files)?;
    }
    Ok(())
}
