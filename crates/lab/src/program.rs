//! The program that is measured: which one exactly.

use serde::{Deserialize, Serialize};
use std::fs::File;
use std::path::Path;

/// A build of Eosphor.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub struct Program {
    /// Its version.
    pub version: String,
    /// The commit that it was built from, where there was one.
    pub commit: Option<String>,
    /// The compiler.
    pub compiler: String,
    /// The profile that it was built with, and for which machines.
    pub profile: String,
    /// Its cargo features.
    pub features: Vec<String>,
    /// A hash of its file: what tells builds of one commit apart.
    pub hash: String,
}

/// The first 16 digits of the hash of a program's file. `None`: it cannot be read.
pub fn hash_of_program(path: &Path) -> Option<String> {
    let mut hasher = blake3::Hasher::new();
    hasher.update_reader(File::open(path).ok()?).ok()?;
    Some(hasher.finalize().to_hex()[..16].to_owned())
}
