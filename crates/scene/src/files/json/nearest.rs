//! "Did you mean": the known name nearest to an unknown one.

use super::fault::{listed, quoted};

/// A question for the nearest known name, else a list of all.
pub(super) fn hint<'a>(name: &str, known: impl Iterator<Item = &'a str> + Clone) -> String {
    match nearest(name, known.clone()) {
        Some(near) => format!("did you mean {}?", quoted(near)),
        None if known.clone().nth(1).is_some() => format!("there are {}", listed(known, "and")),
        None if known.clone().next().is_some() => format!("there is only {}", listed(known, "and")),
        None => "there is none".into(),
    }
}

/// The known name with the fewest edits, where these are few against its length; else the first that begins with the
/// name, or with which it begins. Case and hyphens do not count: `lookAt` is `look-at`.
pub(in crate::files) fn nearest<'a>(
    name: &str,
    known: impl Iterator<Item = &'a str> + Clone,
) -> Option<&'a str> {
    let name = plain(name);
    let limit = (name.len() / 3).max(1);
    let few = known.clone().map(|k| (edits(&name, &plain(k)), k)).filter(|&(n, _)| n <= limit).min();
    let mut begins = known.filter(|k| {
        let known = plain(k);
        name.len().min(known.len()) > 2 && (known.starts_with(&name) || name.starts_with(&known))
    });
    few.map(|(_, k)| k).or_else(|| begins.next())
}

/// The first 64 characters, small, without what divides words.
fn plain(name: &str) -> Vec<char> {
    let letters = name.chars().filter(|c| !matches!(c, '-' | '_' | ' '));
    letters.flat_map(char::to_lowercase).take(64).collect()
}

/// Levenshtein's distance.
fn edits(a: &[char], b: &[char]) -> usize {
    let mut row: Vec<usize> = (0..=b.len()).collect();
    for (i, x) in a.iter().enumerate() {
        let mut diagonal = row[0];
        row[0] = i + 1;
        for (j, y) in b.iter().enumerate() {
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
        let known = ["glass", "floor", "left wall", "fov-x-degrees", "fov-y-degrees", "look-at"];
        let find = |name| nearest(name, known.into_iter());
        assert_eq!(find("glas"), Some("glass"));
        assert_eq!(find("flor"), Some("floor"));
        assert_eq!(find("Left Wall"), Some("left wall"));
        assert_eq!(find("lookAt"), Some("look-at"));
        assert_eq!(find("fov"), Some("fov-x-degrees"));
        assert_eq!(find("floorboards"), Some("floor"));
        assert_eq!(find("fov_y"), Some("fov-y-degrees"));
        assert_eq!(find("mirror"), None);
        assert_eq!(find(""), None);
        let distance = |a: &str, b: &str| edits(&plain(a), &plain(b));
        assert_eq!(distance("kitten", "sitting"), 3);
        assert_eq!(distance("", "abc"), 3);
    }

    #[test]
    fn without_a_near_name_all_are_listed() {
        assert_eq!(hint("x", ["red", "blue"].into_iter()), "there are \"red\" and \"blue\"");
        assert_eq!(hint("x", ["red"].into_iter()), "there is only \"red\"");
        assert_eq!(hint("x", [].into_iter()), "there is none");
        assert_eq!(hint("rad", ["red", "blue"].into_iter()), "did you mean \"red\"?");
    }
}
