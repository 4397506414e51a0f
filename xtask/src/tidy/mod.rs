//! `cargo xtask tidy`: what the pages promise about the tree, held against the tree. Part of `cargo test`.

mod anchors;
mod circles;
mod crates;
mod formats;
mod lengths;
mod pages;
mod sources;
mod type_names;

use anyhow::{Context, Result, bail};
use std::fs;
use std::path::Path;
use std::process::Command;

/// A text of the repository.
struct Text {
    /// From the root.
    path: String,
    content: String,
}

pub(crate) fn run(arguments: &[String]) -> Result<()> {
    if !arguments.is_empty() {
        bail!("usage: cargo xtask tidy");
    }
    check(&crate::root())
}

/// One error with a line for each thing that is not as it should be.
fn check(root: &Path) -> Result<()> {
    let paths = tracked(root)?;
    let mut found = crates::check(root)?;
    let mut texts = Vec::new();
    for path in paths.iter().filter(|path| path.ends_with(".rs") || path.ends_with(".md")) {
        let content = fs::read_to_string(root.join(path)).with_context(|| format!("cannot read {path}"))?;
        texts.push(Text { path: path.clone(), content });
    }
    for text in &texts {
        match text.path.ends_with(".md") {
            true => pages::check(text, &paths, &mut found),
            false => sources::check(text, &mut found),
        }
    }
    for name in crates::ORDER {
        circles::check(name, &texts, &mut found);
    }
    anchors::check(&texts, &mut found);
    type_names::check(&texts, &mut found);
    formats::check(&texts, &mut found);
    lengths::check(&texts, &mut found);
    if !found.is_empty() {
        bail!("{} things are not tidy:\n{}", found.len(), found.join("\n"));
    }
    Ok(())
}

/// The files of the repository, from its root: those that git knows, or all where this is no checkout.
fn tracked(root: &Path) -> Result<Vec<String>> {
    let listed = Command::new("git")
        .args(["ls-files", "--cached", "--others", "--exclude-standard"])
        .current_dir(root)
        .output();
    let mut paths: Vec<String> = match listed {
        Ok(output) if output.status.success() => {
            String::from_utf8_lossy(&output.stdout).lines().map(String::from).collect()
        }
        _ => Vec::new(),
    };
    if paths.is_empty() {
        walk(root, "", &mut paths)?;
    }
    // A file that was deleted and not yet committed is listed, too.
    paths.retain(|path| root.join(path).is_file());
    Ok(paths)
}

fn walk(root: &Path, folder: &str, paths: &mut Vec<String>) -> Result<()> {
    for entry in fs::read_dir(root.join(folder))? {
        let entry = entry?;
        let name = entry.file_name().to_string_lossy().into_owned();
        let path = if folder.is_empty() { name.clone() } else { format!("{folder}/{name}") };
        if entry.file_type()?.is_dir() {
            if name != "target" && !name.starts_with('.') {
                walk(root, &path, paths)?;
            }
        } else {
            paths.push(path);
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    #[test]
    fn the_tree_is_as_the_pages_say() {
        if let Err(error) = super::check(&crate::root()) {
            panic!("{error:#}");
        }
    }
}
