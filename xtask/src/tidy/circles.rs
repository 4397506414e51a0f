//! Modules of a crate know each other in one direction: no circles among the files and folders that lie directly in `src/`.

use super::Text;
use std::collections::{BTreeMap, BTreeSet};

/// For each module, the modules of the same crate that it names, and a file that does.
type Graph = BTreeMap<String, BTreeMap<String, String>>;

/// What the files of a crate name of each other. Files of tests are left out, and what is below `#[cfg(test)]`.
pub(super) fn check(crate_name: &str, texts: &[Text], found: &mut Vec<String>) {
    let folder = format!("crates/{crate_name}/src/");
    let files: Vec<(&str, &Text)> =
        texts.iter().filter_map(|text| Some((text.path.strip_prefix(&folder)?, text))).collect();
    let root = files.iter().find(|(path, _)| ["lib.rs", "main.rs"].contains(path));
    let at_root = root.map(|(_, text)| exported(&text.content)).unwrap_or_default();
    let modules: BTreeSet<&str> = files.iter().map(|(path, _)| module_of(path)).collect();
    let mut graph = Graph::new();
    for (path, text) in files {
        let own = module_of(path);
        if ["lib", "main"].contains(&own) || path.contains("tests") {
            continue;
        }
        let named = named_after_crate(&text.content);
        let others = named.iter().filter_map(|name| match modules.get(name.as_str()) {
            Some(module) => Some((*module).to_owned()),
            None => at_root.get(name).cloned(),
        });
        for other in others.filter(|other| other != own) {
            graph.entry(own.to_owned()).or_default().entry(other).or_insert_with(|| text.path.clone());
        }
    }
    if let Some(circle) = circle(&graph) {
        let steps = circle.windows(2).map(|pair| format!("{} ({})", pair[0], graph[&pair[0]][&pair[1]]));
        let steps: Vec<String> = steps.collect();
        found.push(format!(
            "crates/{crate_name}: modules in a circle: {} -> {}",
            steps.join(" -> "),
            circle[0]
        ));
    }
}

/// The file or folder directly in `src/`.
fn module_of(path: &str) -> &str {
    let first = path.split('/').next().unwrap_or(path);
    first.strip_suffix(".rs").unwrap_or(first)
}

/// Code without comments and tests.
fn code(content: &str) -> String {
    let before_tests = content.split("#[cfg(test)]\nmod tests").next().unwrap_or(content);
    let lines = before_tests.lines().filter(|line| !line.trim_start().starts_with("//"));
    lines.collect::<Vec<_>>().join("\n")
}

/// The names that follow `crate::`, of lists the first name of each item.
fn named_after_crate(content: &str) -> BTreeSet<String> {
    let code = code(content);
    let mut names = BTreeSet::new();
    for (at, start) in code.match_indices("crate::") {
        if code[..at].ends_with(|c: char| c.is_alphanumeric() || c == '_' || c == '$') {
            continue;
        }
        let rest = &code[at + start.len()..];
        if let Some(list) = rest.strip_prefix('{') {
            names.extend(items(list));
        } else {
            names.extend(identifier(rest));
        }
    }
    names
}

/// The first name of each item of a list, up to its closing brace.
fn items(list: &str) -> Vec<String> {
    let (mut depth, mut is_first, mut names) = (0, true, Vec::new());
    for (at, c) in list.char_indices() {
        match c {
            '{' => depth += 1,
            '}' if depth == 0 => break,
            '}' => depth -= 1,
            ',' if depth == 0 => is_first = true,
            c if is_first && !c.is_whitespace() => {
                is_first = false;
                names.extend(identifier(&list[at..]));
            }
            _ => {}
        }
    }
    names
}

fn identifier(text: &str) -> Option<String> {
    let end = text.find(|c: char| !c.is_alphanumeric() && c != '_').unwrap_or(text.len());
    (end > 0).then(|| text[..end].to_owned())
}

/// For each name that the crate's root exports from a module, the module.
fn exported(content: &str) -> BTreeMap<String, String> {
    let code = code(content);
    let mut names = BTreeMap::new();
    for statement in code.split(';') {
        let Some((_, path)) = statement.split_once("use ") else { continue };
        let Some((module, rest)) = path.trim().split_once("::") else { continue };
        let list = rest.rsplit_once('{').map_or(rest.rsplit("::").next().unwrap_or(rest), |(_, list)| list);
        for name in items(list) {
            names.insert(name, module.trim().to_owned());
        }
    }
    names
}

/// Some circle, its first module again at the end.
fn circle(graph: &Graph) -> Option<Vec<String>> {
    fn visit(at: &str, graph: &Graph, way: &mut Vec<String>, done: &mut BTreeSet<String>) -> bool {
        if let Some(start) = way.iter().position(|module| module == at) {
            way.drain(..start);
            way.push(at.to_owned());
            return true;
        }
        if !done.insert(at.to_owned()) {
            return false;
        }
        way.push(at.to_owned());
        if graph.get(at).is_some_and(|others| others.keys().any(|other| visit(other, graph, way, done))) {
            return true;
        }
        way.pop();
        false
    }
    let mut done = BTreeSet::new();
    graph.keys().find_map(|module| {
        let mut way = Vec::new();
        visit(module, graph, &mut way, &mut done).then_some(way)
    })
}

#[cfg(test)]
mod tests {
    use super::super::Text;

    fn found(files: &[(&str, &str)]) -> Vec<String> {
        let text = |(path, content): &(&str, &str)| Text {
            path: format!("crates/core/src/{path}"),
            content: (*content).to_owned(),
        };
        let texts: Vec<Text> = files.iter().map(text).collect();
        let mut found = Vec::new();
        super::check("core", &texts, &mut found);
        found
    }

    #[test]
    fn circles_are_found_through_lists_folders_and_the_root() {
        let lib = ("lib.rs", "mod a;\npub use c::{Deep, Name};");
        let circle = found(&[
            lib,
            ("a.rs", "use crate::{b::{x, y}, d};"),
            ("b/e.rs", "use crate::Name;"),
            ("c.rs", "use crate::a::Q;"),
        ]);
        assert_eq!(
            circle,
            ["crates/core: modules in a circle: a (crates/core/src/a.rs) -> b (crates/core/src/b/e.rs) -> \
              c (crates/core/src/c.rs) -> a"]
        );
    }

    #[test]
    fn tests_comments_and_the_way_down_are_no_circles() {
        let ways = [
            ("a.rs", "use crate::b;\n// crate::c\n#[cfg(test)]\nmod tests { use crate::c; }"),
            ("b/mod.rs", "use crate::b::e; use crate::c;"),
            ("c.rs", "use $crate::a; fn f() { other_crate::a() }"),
            ("d/tests.rs", "use crate::a;"),
        ];
        assert_eq!(found(&ways), Vec::<String>::new());
    }
}
