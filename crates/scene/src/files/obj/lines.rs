//! Text files as lines and words of bytes: what OBJ and MTL have in common.

use memchr::{memchr, memchr2, memrchr2};
use std::borrow::Cow;

/// Lines without their ends, comments and surrounding blanks, with the number of the first line from 1. LF, CRLF and
/// CR end lines; a backslash at the end joins the next one. Empty lines are left out.
pub(super) struct Lines<'a> {
    rest: &'a [u8],
    number: u32,
}

impl<'a> Lines<'a> {
    pub(super) fn new(bytes: &'a [u8]) -> Lines<'a> {
        Lines::after(without_mark(bytes), 0)
    }

    /// The lines of what follows so many others.
    pub(super) fn after(rest: &'a [u8], number: u32) -> Lines<'a> {
        Lines { rest, number }
    }

    /// What is not yet read.
    pub(super) fn rest(&self) -> &'a [u8] {
        self.rest
    }

    /// The number of the line that was read last.
    pub(super) fn number(&self) -> u32 {
        self.number
    }

    /// The next physical line without its end.
    fn physical(&mut self) -> Option<&'a [u8]> {
        if self.rest.is_empty() {
            return None;
        }
        self.number = self.number.saturating_add(1);
        let rest = self.rest;
        let Some(end) = memchr2(b'\n', b'\r', rest) else {
            self.rest = &[];
            return Some(rest);
        };
        self.rest = &rest[end + end_length(&rest[end..])..];
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

/// A byte order mark is no part of the text.
pub(super) fn without_mark(bytes: &[u8]) -> &[u8] {
    bytes.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(bytes)
}

/// The length of the line end that these bytes start with.
fn end_length(bytes: &[u8]) -> usize {
    if bytes.starts_with(b"\r\n") { 2 } else { 1 }
}

/// Cuts a text into pieces of about a size at ends of lines that the next line does not continue. So the lines of the
/// pieces are the lines of the text.
pub(super) fn cut(bytes: &[u8], size: usize) -> Vec<&[u8]> {
    let mut pieces = Vec::with_capacity(bytes.len() / size.max(1) + 1);
    let mut rest = bytes;
    while !rest.is_empty() {
        let (piece, after) = rest.split_at(border(rest, size));
        pieces.push(piece);
        rest = after;
    }
    pieces
}

/// The first place at or after a size where a text may be cut.
fn border(bytes: &[u8], size: usize) -> usize {
    let mut from = size.saturating_sub(1);
    while let Some(found) = bytes.get(from..).and_then(|tail| memchr2(b'\n', b'\r', tail)) {
        let mut end = from + found;
        let next = end + end_length(&bytes[end..]);
        if bytes[end] == b'\n' && end > 0 && bytes[end - 1] == b'\r' {
            end -= 1;
        }
        let start = memrchr2(b'\n', b'\r', &bytes[..end]).map_or(0, |i| i + 1);
        if !trim(without_comment(&bytes[start..end])).ends_with(b"\\") {
            return next;
        }
        from = next;
    }
    bytes.len()
}

/// Cuts a comment: `#` at the start or after a blank. Inside a word it belongs to a name.
fn without_comment(line: &[u8]) -> &[u8] {
    let mut from = 0;
    while let Some(found) = memchr(b'#', &line[from..]) {
        let i = from + found;
        if i == 0 || is_blank(line[i - 1]) {
            return &line[..i];
        }
        from = i + 1;
    }
    line
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

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

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
        assert_eq!(lines("a#b #c\na# #"), expected(&[(1, "a#b"), (2, "a#")]));
        assert_eq!(lines("f 1 \\\n 2\\\r\n3\nv"), expected(&[(1, "f 1  2 3"), (4, "v")]));
        assert_eq!(lines("f 1\\"), expected(&[(1, "f 1 ")]));
        assert_eq!(lines("# comment \\\nv 1"), expected(&[(2, "v 1")]));
        assert_eq!(lines("\u{feff}v 1"), expected(&[(1, "v 1")]));
    }

    #[test]
    fn cuts_leave_continued_lines_whole() {
        let cut = |text: &'static str, size| -> Vec<String> {
            super::cut(text.as_bytes(), size).iter().map(|p| String::from_utf8(p.to_vec()).unwrap()).collect()
        };
        assert_eq!(cut("a\nb\r\nc\rd", 1), ["a\n", "b\r\n", "c\r", "d"]);
        assert_eq!(cut("a\nb\r\nc\rd", 3), ["a\nb\r\n", "c\rd"]);
        // The border falls between the two bytes of a line end.
        assert_eq!(cut("a \\\r\nb\nc", 4), ["a \\\r\nb\n", "c"]);
        assert_eq!(cut("a \\ # x\nb\n# \\\nc", 1), ["a \\ # x\nb\n", "# \\\n", "c"]);
        assert_eq!(cut("", 4), Vec::<String>::new());
    }

    proptest! {
        #[test]
        fn pieces_have_the_lines_of_the_whole(
            parts in proptest::collection::vec(proptest::sample::select(vec![
                "a", " ", "#", "\\", "\n", "\r", "\r\n", "\\\n", "\\\r\n", "bc",
            ]), 0..40),
            size in 0..12usize,
        ) {
            let text = parts.concat();
            let whole: Vec<_> = Lines::after(text.as_bytes(), 0).collect();
            let mut pieced = Vec::new();
            let mut number = 0;
            for piece in cut(text.as_bytes(), size) {
                let mut lines = Lines::after(piece, number);
                pieced.extend(&mut lines);
                number = lines.number();
            }
            prop_assert_eq!(whole, pieced);
        }
    }
}
