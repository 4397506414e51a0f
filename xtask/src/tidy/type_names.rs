//! Public types have names of their own across all crates.

use super::Text;
use super::crates::ORDER;
use std::collections::{BTreeMap, BTreeSet};

/// Names that several crates have: which crates, and why.
type Shared = (&'static str, &'static [&'static str], &'static str);

/// A scene exists twice, under the words that its readers know: as people write it and as shading reads it.
const MODEL_AND_ARRAYS: &str = "what people write, and what shading reads of it";
/// `eosphor-accel` is used without the other crates; its scenes are only meshes and instances.
const ACCEL_ALONE: &str = "accel is used by itself, where a scene is geometry alone";

const SHARED: [Shared; 9] = [
    ("Camera", &["core", "scene"], MODEL_AND_ARRAYS),
    ("Instance", &["core", "scene"], MODEL_AND_ARRAYS),
    ("Light", &["core", "scene"], MODEL_AND_ARRAYS),
    ("Material", &["core", "scene"], MODEL_AND_ARRAYS),
    ("PixelSampling", &["core", "scene"], MODEL_AND_ARRAYS),
    ("Scene", &["accel", "scene"], ACCEL_ALONE),
    ("SceneError", &["accel", "scene"], ACCEL_ALONE),
    ("Sphere", &["core", "scene"], MODEL_AND_ARRAYS),
    ("Texture", &["core", "scene"], MODEL_AND_ARRAYS),
];

pub(super) fn check(texts: &[Text], found: &mut Vec<String>) {
    check_against(&SHARED, texts, found);
}

fn check_against(shared: &[Shared], texts: &[Text], found: &mut Vec<String>) {
    let mut crates_of: BTreeMap<String, Vec<&str>> = BTreeMap::new();
    for name in ORDER {
        for public in public_types(name, texts) {
            crates_of.entry(public).or_default().push(name);
        }
    }
    for (name, crates) in &crates_of {
        let entry = shared.iter().find(|entry| entry.0 == name);
        if crates.len() > 1 && entry.is_none_or(|entry| entry.1 != crates.as_slice()) {
            found.push(format!("{name} is a public type of several crates: {}", crates.join(", ")));
        }
    }
    for (name, crates, _) in shared {
        if crates_of.get(*name).is_none_or(|of| of.len() < 2) {
            found.push(format!("{name} is allowed to {} and no longer theirs together", crates.join(", ")));
        }
    }
}

/// The types that a crate defines and others can name: through public modules and re-exports of its own ones.
fn public_types(crate_name: &str, texts: &[Text]) -> BTreeSet<String> {
    let folder = format!("crates/{crate_name}/src/");
    let files: BTreeMap<&str, &str> = texts
        .iter()
        .filter_map(|text| Some((text.path.strip_prefix(&folder)?, text.content.as_str())))
        .collect();
    let mut names = BTreeSet::new();
    visit("", &files, &mut names);
    names
}

/// Adds what a module makes public. `module` is its path with slashes, empty for the root.
fn visit(module: &str, files: &BTreeMap<&str, &str>, names: &mut BTreeSet<String>) {
    let candidates = match module {
        "" => vec!["lib.rs".to_owned()],
        module => vec![format!("{module}.rs"), format!("{module}/mod.rs")],
    };
    let Some(content) = candidates.iter().find_map(|path| files.get(path.as_str())) else { return };
    let inside = |name: &str| if module.is_empty() { name.to_owned() } else { format!("{module}/{name}") };
    let code = content.split("#[cfg(test)]\nmod tests").next().unwrap_or(content);
    let own_modules: BTreeSet<&str> = code.lines().filter_map(module_name).collect();
    for line in code.lines() {
        if let Some(name) = line.strip_prefix("pub mod ").and_then(|rest| rest.strip_suffix(';')) {
            visit(&inside(name), files, names);
        }
        names.extend(defined(line));
    }
    for statement in code.split("\npub use ").skip(1) {
        let path = statement.split(';').next().unwrap_or_default();
        let path = path.trim_start_matches("crate::").trim_start_matches("self::");
        let Some((first, rest)) = path.split_once("::") else { continue };
        if !own_modules.contains(first) {
            continue;
        }
        match rest.trim() {
            "*" => visit(&inside(first), files, names),
            rest => names.extend(leaves(rest).into_iter().filter(|name| is_type(name))),
        }
    }
}

/// The name of a module that a line declares.
fn module_name(line: &str) -> Option<&str> {
    let rest = line.strip_prefix("pub(crate) ").or_else(|| line.strip_prefix("pub ")).unwrap_or(line);
    rest.strip_prefix("mod ")?.strip_suffix(';')
}

/// The public type that a line at the margin defines.
fn defined(line: &str) -> Option<String> {
    let rest = line.strip_prefix("pub ")?;
    let rest = rest.strip_prefix("unsafe ").unwrap_or(rest);
    let kinds = ["struct ", "enum ", "union ", "trait ", "type "];
    let rest = kinds.iter().find_map(|kind| rest.strip_prefix(kind))?;
    let end = rest.find(|c: char| !c.is_alphanumeric() && c != '_').unwrap_or(rest.len());
    Some(rest[..end].to_owned())
}

/// The last names of a path or list of paths, or what they are renamed to.
fn leaves(list: &str) -> Vec<String> {
    let items = list.split([',', '{', '}']).map(str::trim).filter(|item| !item.is_empty());
    let last = items.filter(|item| !item.ends_with("::")).map(|item| match item.split_once(" as ") {
        Some((_, name)) => name,
        None => item.rsplit("::").next().unwrap_or(item),
    });
    last.map(String::from).collect()
}

/// Types begin with a capital and are not all capitals, as constants are.
fn is_type(name: &str) -> bool {
    name.starts_with(char::is_uppercase) && name.chars().any(char::is_lowercase)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn found(shared: &[Shared], scene: &str) -> Vec<String> {
        let text = |path: &str, content: &str| Text { path: path.into(), content: content.into() };
        let texts = [
            text("crates/core/src/lib.rs", "pub mod light;\nmod hidden;\npub use hidden::{f, MAX, Ray};\n"),
            text("crates/core/src/light/mod.rs", "pub enum Light {\n"),
            text("crates/core/src/hidden.rs", "pub struct Inner;\npub struct Ray;\n"),
            text("crates/scene/src/lib.rs", scene),
            text("crates/scene/src/model.rs", "pub struct Light {}\npub(crate) struct Ray;\n"),
        ];
        let mut found = Vec::new();
        check_against(shared, &texts, &mut found);
        found
    }

    #[test]
    fn names_of_two_crates_are_found_in_what_is_public() {
        let twice = ["Light is a public type of several crates: core, scene"];
        assert_eq!(found(&[], "mod model;\npub use model::*;\n"), twice);
        assert_eq!(found(&[], "mod model;\npub use model::Light;\n"), twice);
        assert!(
            found(&[], "mod model;\npub use eosphor_core::light::Light;\npub struct Inner;\n").is_empty()
        );
        let shared: [Shared; 1] = [("Light", &["core", "scene"], "what people write and what machines read")];
        assert!(found(&shared, "mod model;\npub use model::*;\n").is_empty());
        assert_eq!(found(&shared, "mod model;\n").len(), 1, "the entry has had its day");
    }
}
