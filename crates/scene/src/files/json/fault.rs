//! What is wrong with a file, and the words to say it.

/// Something wrong at a place in the text.
#[derive(Debug)]
pub(super) struct Fault {
    /// In bytes.
    pub(super) at: usize,
    pub(super) message: String,
}

impl Fault {
    pub(super) fn new(at: usize, message: impl Into<String>) -> Fault {
        Fault { at, message: message.into() }
    }
}

/// Characters of a name that messages show.
const SHOWN: usize = 60;

/// A name of the file in quotes: cut where it is long, without control characters.
pub(in crate::files) fn quoted(name: &str) -> String {
    let mut shown: String = name.chars().take(SHOWN).map(|c| if c.is_control() { ' ' } else { c }).collect();
    if name.chars().nth(SHOWN).is_some() {
        shown.push_str("...");
    }
    format!("\"{shown}\"")
}

/// Longer lists are cut.
const LISTED: usize = 30;

/// `"a", "b" or "c"`, with this word before the last.
pub(super) fn listed<'a>(names: impl IntoIterator<Item = &'a str>, before_last: &str) -> String {
    let mut names: Vec<String> = names.into_iter().map(quoted).collect();
    if let Some(more) = names.len().checked_sub(LISTED).filter(|&more| more > 0) {
        names.truncate(LISTED);
        return format!("{} and {more} more", names.join(", "));
    }
    match (names.pop(), names.is_empty()) {
        (None, _) => String::new(),
        (Some(only), true) => only,
        (Some(last), false) => format!("{} {before_last} {last}", names.join(", ")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_tamed() {
        assert_eq!(quoted("a\nb\u{1b}c"), "\"a b c\"");
        assert_eq!(quoted(&"x".repeat(61)), format!("\"{}...\"", "x".repeat(60)));
        assert_eq!(listed(["a", "b", "c"], "or"), "\"a\", \"b\" or \"c\"");
        assert_eq!(listed(["a"], "or"), "\"a\"");
        assert_eq!(listed([], "or"), "");
        assert!(listed(["a"; 40], "or").ends_with("\"a\", \"a\" and 10 more"));
    }
}
