//! The formats that pages list are those of the code.

use super::Text;

/// Where the code says what scenes are read from: [`read_formats`].
const READ: &str = "crates/scene/src/files/mod.rs";
/// Where the code says what pictures are written in: [`written_formats`].
const WRITTEN: &str = "crates/picture/src/output/format.rs";

/// Pages with a list of what scenes are read from. Each has every name, once at least.
const PAGES_OF_READ: [&str; 3] =
    ["docs/features.md", "crates/scene/README.md", "crates/scene/src/files/README.md"];
/// The page with a table row of what pictures are written in.
const PAGE_OF_WRITTEN: &str = "docs/features.md";

pub(super) fn check(texts: &[Text], found: &mut Vec<String>) {
    let content = |path: &str| texts.iter().find(|text| text.path == path).map_or("", |text| &text.content);
    let read = read_formats(content(READ));
    if read.is_empty() {
        found.push(format!("{READ}: READ_FORMATS names no formats"));
    }
    for page in PAGES_OF_READ {
        for name in read.iter().filter(|name| !content(page).contains(name.as_str())) {
            found.push(format!("{page}: {name} of READ_FORMATS ({READ}) is not named"));
        }
    }
    let written = written_formats(content(WRITTEN));
    let row = content(PAGE_OF_WRITTEN).lines().find_map(|line| line.strip_prefix("| pictures |"));
    let mut listed = row.map(listed_formats).unwrap_or_default();
    listed.sort();
    if written.is_empty() || listed != written {
        found.push(format!(
            "{PAGE_OF_WRITTEN}: the row of pictures has {}, {WRITTEN} has {}",
            listed.join(", "),
            written.join(", ")
        ));
    }
}

/// The names before the parentheses in the text of `READ_FORMATS`, in their last words: `OBJ`, `glTF`, `PG1`.
fn read_formats(code: &str) -> Vec<String> {
    let Some((_, rest)) = code.split_once("READ_FORMATS: &str") else { return Vec::new() };
    let text = rest.split('"').nth(1).unwrap_or_default();
    let before_parentheses = text.split('(').rev().skip(1).collect::<Vec<_>>();
    let names = before_parentheses.iter().rev().filter_map(|part| {
        // Both "Eosphor scenes" and "PG1 configurations" have the telling word first.
        let part = part.rsplit_once("), ").map_or(*part, |(_, part)| part);
        part.split_whitespace().next()
    });
    // Our own format is called otherwise on each page.
    names.filter(|name| *name != "Eosphor").map(String::from).collect()
}

/// The variants of `Format`, sorted, in capitals.
fn written_formats(code: &str) -> Vec<String> {
    let Some((_, rest)) = code.split_once("pub enum Format {") else { return Vec::new() };
    let body = rest.split('}').next().unwrap_or_default();
    let lines = body.lines().map(str::trim).filter(|line| !line.starts_with("//") && !line.is_empty());
    let mut names: Vec<String> = lines.map(|line| line.trim_end_matches(',').to_uppercase()).collect();
    names.sort();
    names
}

/// The formats of a table row, in capitals: what stands before the first semicolon of its cell, without what
/// some of them have.
fn listed_formats(row: &str) -> Vec<String> {
    let list = row.split([';', '|']).next().unwrap_or_default();
    let names = list.split(',').map(|name| name.split(" with ").next().unwrap_or_default());
    names.map(|name| name.trim().trim_matches('`').trim_start_matches('.').to_uppercase()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn found(read: &str, written: &str, row: &str) -> usize {
        let text = |path: &str, content: String| Text { path: path.into(), content };
        let page = format!("OBJ, glTF, PG1\n| pictures | {row} | layers |\n");
        let mut texts: Vec<Text> = PAGES_OF_READ.iter().map(|path| text(path, page.clone())).collect();
        texts.push(text(READ, format!("pub const READ_FORMATS: &str = \"{read} and builtin:NAME\";")));
        texts.push(text(WRITTEN, format!("pub enum Format {{\n    /// A.\n{written}\n}}\n")));
        let mut found = Vec::new();
        check(&texts, &mut found);
        found.len()
    }

    #[test]
    fn lists_of_pages_are_those_of_the_code() {
        let read = "OBJ (.obj), glTF (.gltf, .glb), Eosphor scenes (.json), PG1 configurations (.json)";
        let written = "    Png,\n    Exr,\n    Data,";
        assert_eq!(found(read, written, "PNG, EXR with layers, `.data`; of any size"), 0);
        assert_eq!(found(read, written, "PNG, EXR; of any size"), 1);
        assert_eq!(found(read, written, "PNG, EXR, WEBP, `.data`"), 1);
        let more = format!("{read}, USD (.usd)");
        assert_eq!(found(&more, written, "PNG, EXR, `.data`"), PAGES_OF_READ.len());
    }
}
