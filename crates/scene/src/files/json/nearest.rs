//! "Did you mean": the known name nearest to an unknown one.

/// The known name with the fewest edits, where these are few against its length.
pub(in crate::files) fn nearest<'a>(name: &str, known: impl Iterator<Item = &'a str>) -> Option<&'a str> {
    let limit = (name.chars().count() / 3).max(1);
    known.map(|k| (edits(name, k), k)).filter(|&(n, _)| n <= limit).min().map(|(_, k)| k)
}

/// Levenshtein's distance of the first 64 characters.
fn edits(a: &str, b: &str) -> usize {
    let b: Vec<char> = b.chars().take(64).collect();
    let mut row: Vec<usize> = (0..=b.len()).collect();
    for (i, x) in a.chars().take(64).enumerate() {
        let mut diagonal = row[0];
        row[0] = i + 1;
        for (j, &y) in b.iter().enumerate() {
            let substitute = diagonal + usize::from(x != y);
            diagonal = row[j + 1];
            row[j + 1] = substitute.min(diagonal + 1).min(row[j] + 1);
        }
    }
    row[b.len()]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn few_edits_count() {
        let known = ["glass", "floor", "left wall"];
        let find = |name| nearest(name, known.into_iter());
        assert_eq!(find("glas"), Some("glass"));
        assert_eq!(find("flor"), Some("floor"));
        assert_eq!(find("Left Wall"), Some("left wall"));
        assert_eq!(find("mirror"), None);
        assert_eq!(edits("kitten", "sitting"), 3);
        assert_eq!(edits("", "abc"), 3);
    }
}
