//! Text files as lines and words of bytes: what OBJ and MTL have in common.

use std::borrow::Cow;

/// Lines without their ends, comments and surrounding blanks, with the number of the first line from 1. LF, CRLF and
/// CR end lines; a backslash at the end joins the next one. Empty lines are left out.
pub(super) struct Lines<'a> {
    rest: &'a [u8],
    number: u32,
}

impl<'a> Lines<'a> {
    pub(super) fn new(bytes: &'a [u8]) -> Lines<'a> {
        // A byte order mark is no part of the text.
        Lines { rest: bytes.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(bytes), number: 0 }
    }

    /// The next physical line without its end.
    fn physical(&mut self) -> Option<&'a [u8]> {
        if self.rest.is_empty() {
            return None;
        }
        self.number = self.number.saturating_add(1);
        let rest = self.rest;
        let Some(end) = rest.iter().position(|&b| b == b'\n' || b == b'\r') else {
            self.rest = &[];
            return Some(rest);
        };
        let skip = if rest[end..].starts_with(b"\r\n") { 2 } else { 1 };
        self.rest = &rest[end + skip..];
        Some(&rest[..end])
    }
}

impl<'a> Iterator for Lines<'a> {
    type Item = (u32, Cow<'a, [u8]>);

    fn next(&mut self) -> Option<(u32, Cow<'a, [u8]>)> {
        loop {
            let first = self.physical()?;
            let number = self.number;
            let mut line = trim(without_comment(first));
            if line.is_empty() {
                continue;
            }
            let mut joined: Option<Vec<u8>> = None;
            while let Some(head) = line.strip_suffix(b"\\") {
                let all = joined.get_or_insert_default();
                all.extend_from_slice(head);
                all.push(b' ');
                line = trim(without_comment(self.physical().unwrap_or(b"")));
            }
            let line = match joined {
                None => Cow::Borrowed(line),
                Some(mut all) => {
                    all.extend_from_slice(line);
                    Cow::Owned(all)
                }
            };
            return Some((number, line));
        }
    }
}

/// Cuts a comment: `#` at the start or after a blank. Inside a word it belongs to a name.
fn without_comment(line: &[u8]) -> &[u8] {
    let starts = |i: usize| line[i] == b'#' && (i == 0 || is_blank(line[i - 1]));
    match (0..line.len()).find(|&i| starts(i)) {
        Some(i) => &line[..i],
        None => line,
    }
}

pub(super) fn is_blank(b: u8) -> bool {
    matches!(b, b' ' | b'\t' | 0x0b | 0x0c)
}

pub(super) fn trim(line: &[u8]) -> &[u8] {
    let Some(start) = line.iter().position(|&b| !is_blank(b)) else { return &[] };
    let end = line.iter().rposition(|&b| !is_blank(b)).map_or(0, |i| i + 1);
    &line[start..end]
}

/// The first word and the trimmed rest.
pub(super) fn split_key(line: &[u8]) -> (&[u8], &[u8]) {
    let end = line.iter().position(|&b| is_blank(b)).unwrap_or(line.len());
    (&line[..end], trim(&line[end..]))
}

/// Words between blanks.
pub(super) fn words(line: &[u8]) -> impl Iterator<Item = &[u8]> {
    line.split(|&b| is_blank(b)).filter(|w| !w.is_empty())
}

/// Bytes as text for names and messages, cut to a bearable length.
pub(super) fn text(bytes: &[u8]) -> String {
    const MAX: usize = 200;
    let cut = String::from_utf8_lossy(&bytes[..bytes.len().min(MAX)]).into_owned();
    if bytes.len() > MAX { cut + "..." } else { cut }
}

/// What a word says as a number.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Number {
    /// A finite number.
    Good(f32),
    /// A finite number followed by something else, as in `-0.2200.`.
    Stray(f32),
    /// Infinite or not a number, as in `nan`, `-inf`, `1.#IND`, `1e99`.
    NotFinite,
    /// No number at all.
    Bad,
}

/// Reads a word as a number, correctly rounded to single precision.
pub(super) fn number(word: &[u8]) -> Number {
    match fast_float2::parse_partial::<f32, _>(word) {
        Ok((x, _)) if !x.is_finite() => Number::NotFinite,
        Ok((x, length)) if length == word.len() => Number::Good(x),
        Ok((_, length)) if word[length..].starts_with(b"#") => Number::NotFinite,
        Ok((x, _)) => Number::Stray(x),
        Err(_) => Number::Bad,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lines(text: &str) -> Vec<(u32, String)> {
        Lines::new(text.as_bytes()).map(|(n, l)| (n, String::from_utf8(l.into_owned()).unwrap())).collect()
    }

    #[test]
    fn line_ends_comments_and_continuations() {
        let expected = |list: &[(u32, &str)]| -> Vec<(u32, String)> {
            list.iter().map(|&(n, s)| (n, s.to_string())).collect()
        };
        assert_eq!(lines("a\r\nb\rc\n\nd"), expected(&[(1, "a"), (2, "b"), (3, "c"), (5, "d")]));
        assert_eq!(lines("# x\n  v 1 # y\nname#1 "), expected(&[(2, "v 1"), (3, "name#1")]));
        assert_eq!(lines("f 1 \\\n 2\\\r\n3\nv"), expected(&[(1, "f 1  2 3"), (4, "v")]));
        assert_eq!(lines("f 1\\"), expected(&[(1, "f 1 ")]));
        assert_eq!(lines("# comment \\\nv 1"), expected(&[(2, "v 1")]));
        assert_eq!(lines("\u{feff}v 1"), expected(&[(1, "v 1")]));
    }

    #[test]
    fn numbers() {
        for (word, expected) in [
            ("1", Number::Good(1.0)),
            ("+2.", Number::Good(2.0)),
            (".5", Number::Good(0.5)),
            ("-3.1E2", Number::Good(-310.0)),
            ("-0.2200.", Number::Stray(-0.22)),
            ("3.1+e2", Number::Stray(3.1)),
            ("nan", Number::NotFinite),
            ("-inf", Number::NotFinite),
            ("1.#IND", Number::NotFinite),
            ("1e99", Number::NotFinite),
            ("x", Number::Bad),
            ("", Number::Bad),
            ("-", Number::Bad),
        ] {
            assert_eq!(number(word.as_bytes()), expected, "{word}");
        }
    }
}
