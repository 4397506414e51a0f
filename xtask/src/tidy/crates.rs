//! Crates know only what stands below them, and each has its licences.

use anyhow::{Context, Result};
use std::fs;
use std::path::Path;

/// From the bottom to the top. A crate uses crates before it and no others.
pub(super) const ORDER: [&str; 11] =
    ["core", "accel", "scene", "render", "cuda", "picture", "eosphor", "viewer", "cluster", "lab", "cli"];

/// Those that stand apart: what they may use of the above.
const APART: [(&str, &str, &[&str]); 4] = [
    ("cluster", "crates/cluster", &[]),
    ("lab", "crates/lab", &[]),
    ("gpu", "gpu", &["core"]),
    // Pictures are the same whatever device made them.
    ("picture", "crates/picture", &["core", "accel", "scene", "render"]),
];

pub(super) fn check(root: &Path) -> Result<Vec<String>> {
    let mut found = Vec::new();
    let mut look = |name: &str, folder: &str, allowed: &[&str]| -> Result<()> {
        let path = format!("{folder}/Cargo.toml");
        let manifest = fs::read_to_string(root.join(&path)).with_context(|| format!("cannot read {path}"))?;
        for used in own_dependencies(&manifest) {
            if !allowed.contains(&used) {
                found.push(format!("{path}: {name} may not use {used}, which does not stand below it"));
            }
        }
        Ok(())
    };
    for (number, name) in ORDER.iter().enumerate() {
        look(name, &format!("crates/{name}"), &ORDER[..number])?;
    }
    for (name, folder, allowed) in APART {
        look(name, folder, allowed)?;
    }
    for name in ORDER {
        found.extend(licences(root, name));
        found.extend(lost_tests(root, name)?);
    }
    Ok(found)
}

/// What a crate's package needs beside its sources: it is passed on alone.
fn licences(root: &Path, name: &str) -> Vec<String> {
    let mut found = Vec::new();
    for file in ["LICENSE-MIT", "LICENSE-APACHE"] {
        let path = format!("crates/{name}/{file}");
        match (fs::read(root.join(&path)), fs::read(root.join(file))) {
            (Ok(own), Ok(common)) if own == common => {}
            _ => found.push(format!("{path}: it must be a link to ../../{file}")),
        }
    }
    found
}

/// The project's crates among the dependencies of a manifest, those of tests and examples left out.
fn own_dependencies(manifest: &str) -> Vec<&str> {
    let mut is_dependencies = false;
    let mut names = Vec::new();
    for line in manifest.lines() {
        if line.starts_with('[') {
            let table = line.trim_matches(['[', ']']);
            is_dependencies = table == "dependencies" || table.ends_with(".dependencies");
        } else if is_dependencies {
            let name = line.split(['.', ' ', '=']).next().unwrap_or_default();
            match name.strip_prefix("eosphor-") {
                Some(rest) => names.push(rest),
                None if name == "eosphor" => names.push(name),
                None => {}
            }
        }
    }
    names
}

/// Files of tests that the one program of a crate's tests does not name: they would never run.
fn lost_tests(root: &Path, name: &str) -> Result<Vec<String>> {
    let folder = root.join("crates").join(name).join("tests");
    let Ok(program) = fs::read_to_string(folder.join("main.rs")) else { return Ok(Vec::new()) };
    let mut found = Vec::new();
    for entry in fs::read_dir(&folder)? {
        let path = entry?.path();
        let is_module =
            path.extension().is_some_and(|ending| ending == "rs") || path.join("mod.rs").is_file();
        let module = path.file_stem().unwrap_or_default().to_string_lossy();
        if is_module && module != "main" && !program.contains(&format!("mod {module};")) {
            found.push(format!("crates/{name}/tests/main.rs: it must say mod {module};"));
        }
    }
    Ok(found)
}

#[cfg(test)]
mod tests {
    #[test]
    fn dependencies_of_tests_do_not_count() {
        let manifest = "[dependencies]\neosphor-core.workspace = true\nlibc = \"1\"\n[dev-dependencies]\neosphor-render = { path = \"..\" }\n\
                        [target.'cfg(unix)'.dependencies]\neosphor = { workspace = true }\n";
        assert_eq!(super::own_dependencies(manifest), ["core", "eosphor"]);
    }
}
