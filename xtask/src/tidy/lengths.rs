//! Files are no longer than people read at once.

use super::Text;

/// No file has more lines.
const MAX_LINES: usize = 500;

/// A file that is longer, the most lines that it may have, and why it is not divided. The list only becomes shorter.
type Longer = (&'static str, usize, &'static str);

const LONGER: [Longer; 9] = [
    ("crates/accel/src/simd/avx2.rs", 625, "one impl of a trait with many short methods"),
    ("crates/core/src/bsdf/glass_tables.rs", 14214, "a table, made by cargo xtask albedo"),
    ("crates/core/src/device/pairs.rs", 700, "format and walk of one structure; its tests are half of it"),
    ("crates/core/src/texture.rs", 650, "its tests are half of it"),
    ("crates/picture/src/frames/manifest.rs", 590, "its tests are a third of it"),
    ("crates/picture/src/still/checkpoint.rs", 570, "its tests are half of it"),
    ("crates/scene/src/files/images/tests.rs", 540, "tests of seven formats"),
    ("crates/scene/src/files/json/tests.rs", 570, "tests of one reader"),
    ("crates/scene/src/flatten/tests.rs", 690, "tests of all that flattening does"),
];

pub(super) fn check(texts: &[Text], found: &mut Vec<String>) {
    check_against(&LONGER, texts, found);
}

fn check_against(longer: &[Longer], texts: &[Text], found: &mut Vec<String>) {
    let code = || texts.iter().filter(|text| text.path.ends_with(".rs"));
    for text in code() {
        let lines = text.content.lines().count();
        let most = longer.iter().find(|entry| entry.0 == text.path).map_or(MAX_LINES, |entry| entry.1);
        if lines > most {
            found.push(format!("{}: {lines} lines, and it may have {most}: divide it", text.path));
        }
    }
    for (path, _, _) in longer {
        let lines = code().find(|text| text.path == *path).map(|text| text.content.lines().count());
        if lines.is_none_or(|lines| lines <= MAX_LINES) {
            found.push(format!("{path} is on the list of long files and is none: take it off the list"));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn long_files_are_found_and_the_list_of_them_shrinks() {
        let found = |lines: usize, longer: &[Longer]| {
            let texts = [Text { path: "crates/core/src/ray.rs".into(), content: "\n".repeat(lines) }];
            let mut found = Vec::new();
            check_against(longer, &texts, &mut found);
            found.len()
        };
        let listed = [("crates/core/src/ray.rs", 600, "a reason")];
        assert_eq!((found(500, &[]), found(501, &[])), (0, 1));
        assert_eq!((found(600, &listed), found(601, &listed)), (0, 1));
        assert_eq!(found(500, &listed), 1, "it is no longer long");
        assert_eq!(found(1, &[("crates/core/src/gone.rs", 600, "a reason")]), 1);
    }
}
