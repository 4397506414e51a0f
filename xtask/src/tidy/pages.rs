//! Paths that pages name exist.

use super::Text;

/// Folders at the root: a name in code style that begins with one of these is a path.
const FOLDERS: [&str; 6] = ["crates/", "docs/", "gpu/", "scenes/", "xtask/", ".ci/"];

/// Endings of files that pages name.
const ENDINGS: [&str; 4] = [".rs", ".md", ".toml", ".ptx"];

pub(super) fn check(page: &Text, paths: &[String], found: &mut Vec<String>) {
    // What was is not what is.
    if page.path == "CHANGELOG.md" {
        return;
    }
    let folder = page.path.rsplit_once('/').map_or("", |(folder, _)| folder);
    for (number, line) in in_prose(&page.content) {
        let mut missing = |path: &str| found.push(format!("{}:{number}: there is no {path}", page.path));
        for target in links(line) {
            if !exists(&joined(folder, target), paths) {
                missing(target);
            }
        }
        for name in line.split('`').skip(1).step_by(2) {
            if is_path(name) && !is_of_the_tree(name, paths) {
                missing(name);
            }
        }
    }
}

/// The lines of a page outside its blocks of code, with their numbers.
pub(super) fn in_prose(content: &str) -> impl Iterator<Item = (usize, &str)> {
    let mut in_code = false;
    (1..).zip(content.lines()).filter(move |(_, line)| {
        let is_fence = line.trim_start().starts_with("```");
        in_code ^= is_fence;
        !in_code && !is_fence
    })
}

/// Targets of a line's links that are paths.
fn links(line: &str) -> impl Iterator<Item = &str> {
    let targets = line.split("](").skip(1).filter_map(|rest| rest.split(')').next());
    let paths = targets.map(|target| target.split('#').next().unwrap_or_default());
    paths.filter(|path| !path.is_empty() && !path.contains("://") && !path.starts_with("mailto:"))
}

/// Whether a name in code style is that of a file or folder of the repository.
fn is_path(name: &str) -> bool {
    let is_plain = name.chars().all(|c| c.is_ascii_alphanumeric() || "/._-".contains(c));
    let is_named = name.contains('/') && ENDINGS.iter().any(|ending| name.ends_with(ending));
    is_plain && (is_named || FOLDERS.iter().any(|folder| name.starts_with(folder)))
}

/// Pages leave out what is clear: a path may lack its first folders, and `src`.
fn is_of_the_tree(name: &str, paths: &[String]) -> bool {
    let name = name.trim_end_matches('/');
    let without_src = |path: &str| path.replace("/src/", "/");
    let ends = |path: &str| path == name || path.ends_with(&format!("/{name}"));
    let leads = |path: &str| path.starts_with(&format!("{name}/")) || path.contains(&format!("/{name}/"));
    let is_it = |path: &str| ends(path) || leads(path);
    // What a build or a run makes is not committed.
    name.starts_with("target/")
        || name.starts_with("../")
        || paths.iter().any(|path| is_it(path) || is_it(&without_src(path)))
}

/// A link's target from the root.
pub(super) fn joined(folder: &str, target: &str) -> String {
    let mut parts: Vec<&str> = folder.split('/').filter(|part| !part.is_empty()).collect();
    for part in target.split('/') {
        match part {
            "" | "." => {}
            ".." => drop(parts.pop()),
            part => parts.push(part),
        }
    }
    parts.join("/")
}

fn exists(path: &str, paths: &[String]) -> bool {
    paths.iter().any(|known| known == path || known.starts_with(&format!("{path}/"))) || path.is_empty()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_pages_name_is_found_or_not() {
        let paths = ["docs/units.md", "crates/core/src/ray.rs", "README.md"].map(String::from);
        let found = |path: &str, content: &str| {
            let mut found = Vec::new();
            check(&Text { path: path.into(), content: content.into() }, &paths, &mut found);
            found.len()
        };
        assert_eq!(found("README.md", "[a](docs/units.md) `core/ray.rs` `core/src/ray.rs` `crates/core`"), 0);
        assert_eq!(found("README.md", "[a](docs/unit.md) `core/rays.rs` `crates/cuda`"), 3);
        assert_eq!(found("docs/units.md", "[a](../README.md#start) [b](https://a.b/c) `a/b`"), 0);
        assert_eq!(found("README.md", "```\n`core/rays.rs`\n```"), 0);
    }
}
