//! The line of a text file that an error speaks of.

use std::fmt;

/// Columns of the line that are shown.
const WIDTH: usize = 100;

/// A line of a text and a place in it. Displayed it has two lines: the text with its number, and a caret below the
/// place. It holds no control characters.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Snippet {
    /// Number of the line, from 1.
    pub line: u32,
    /// The line, or the part of it around the place.
    pub text: String,
    /// Characters of `text` before the place.
    pub caret: usize,
}

impl Snippet {
    /// The line around a byte of a text.
    pub(crate) fn of(text: &str, at: usize) -> Snippet {
        let (line, start) = line_at(text, at);
        let whole = text[start..].lines().next().unwrap_or_default();
        let before = whole.char_indices().take_while(|&(i, _)| start + i < at).count();
        // A window around the place, which leaves most of it for what follows.
        let first = before.saturating_sub(WIDTH * 2 / 3);
        let mut shown: String = whole.chars().skip(first).take(WIDTH).map(tame).collect();
        let mut caret = before - first;
        if whole.chars().nth(first + WIDTH).is_some() {
            shown.push_str("...");
        }
        if first > 0 {
            shown.insert_str(0, "...");
            caret += 3;
        }
        Snippet { line, text: shown, caret }
    }
}

/// The number of the line of a byte, from 1, and the byte where it begins.
pub(crate) fn line_at(text: &str, at: usize) -> (u32, usize) {
    let before = &text.as_bytes()[..at.min(text.len())];
    let line = before.iter().filter(|&&b| b == b'\n').count() + 1;
    let start = before.iter().rposition(|&b| b == b'\n').map_or(0, |i| i + 1);
    (u32::try_from(line).unwrap_or(u32::MAX), start)
}

/// Neither control characters nor those that have no width or turn the direction of what follows.
fn tame(c: char) -> char {
    let unseen =
        matches!(c, '\u{200b}'..='\u{200f}' | '\u{2028}'..='\u{202e}' | '\u{2060}'..='\u{206f}' | '\u{feff}');
    if c.is_control() || unseen { ' ' } else { c }
}

impl fmt::Display for Snippet {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let number = self.line.to_string();
        writeln!(f, " {number} | {}", self.text)?;
        write!(f, " {:width$} | {:caret$}^", "", "", width = number.len(), caret = self.caret)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn the_caret_stands_below_the_place() {
        let text = "{\n\t\"ä\": x,\r\n}";
        let snippet = Snippet::of(text, text.find('x').unwrap());
        assert_eq!(snippet.to_string(), " 2 |  \"ä\": x,\n   |       ^");
        assert_eq!(Snippet::of("", 0).to_string(), " 1 | \n   | ^");
        assert_eq!(Snippet::of("ab\n", 3).to_string(), " 2 | \n   | ^");
    }

    #[test]
    fn long_lines_are_cut() {
        let text = format!("{}x{}", "a".repeat(500), "b".repeat(500));
        let Snippet { text: shown, caret, .. } = Snippet::of(&text, 500);
        assert_eq!(shown.chars().nth(caret), Some('x'));
        assert!(shown.len() < 110 && shown.starts_with("...a") && shown.ends_with("b..."), "{shown}");
    }

    proptest! {
        #[test]
        fn any_text(text in ".{0,300}", at in any::<proptest::sample::Index>()) {
            let at = at.index(text.len() + 1);
            let snippet = Snippet::of(&text, at);
            prop_assert!(!snippet.text.chars().any(char::is_control));
            prop_assert!(snippet.caret <= snippet.text.chars().count());
            prop_assert_eq!(snippet.to_string().lines().count(), 2);
        }
    }
}
