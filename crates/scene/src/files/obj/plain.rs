//! The fast way through an OBJ file, for lines as exporters write them: a key, blanks, decimals or corners. Whatever a
//! line has besides ends the fast way before that line, and [`super::reader`] takes it.

use super::chunk::End;
use super::number::{eight_digits, leading_number, plain_number};
use super::reader::Reader;
use crate::model::MAX_COORDINATE;
use eosphor_core::math::vec3;

impl Reader {
    /// Reads as many lines as are plain; the rest.
    pub(super) fn plain_lines<'a>(&mut self, bytes: &'a [u8]) -> Result<&'a [u8], End> {
        let mut rest = bytes;
        loop {
            self.line = self.chunk.lines.saturating_add(1);
            match self.plain_line(rest)? {
                Some(after) => rest = after,
                None => return Ok(rest),
            }
            self.chunk.lines = self.line;
        }
    }

    /// What follows a plain line; `None` where it is none, and then nothing of it is taken.
    #[inline(always)]
    fn plain_line<'a>(&mut self, line: &'a [u8]) -> Result<Option<&'a [u8]>, End> {
        Ok(match *line {
            [b'v', b' ' | b'\t', ..] if self.is_near() => self.plain_position(&line[1..]),
            [b'v', b't', b' ' | b'\t', ..] => self.plain_uv(&line[2..]),
            [b'v', b'n', b' ' | b'\t', ..] => self.plain_normal(&line[2..]),
            [b'f', b' ' | b'\t', ..] => return self.plain_face(&line[1..]),
            _ => None,
        })
    }

    #[inline(always)]
    fn plain_position<'a>(&mut self, rest: &'a [u8]) -> Option<&'a [u8]> {
        let (p, rest) = three(rest)?;
        if let Some(after) = line_end(rest) {
            self.push_position(p, None);
            return Some(after);
        }
        let (color, rest) = three(rest)?;
        let after = line_end(rest)?;
        self.push_position(p, Some(color));
        Some(after)
    }

    #[inline(always)]
    fn plain_uv<'a>(&mut self, rest: &'a [u8]) -> Option<&'a [u8]> {
        let (u, rest) = coordinate(rest)?;
        let (v, rest) = coordinate(rest)?;
        let after = match line_end(rest) {
            Some(after) => after,
            None => line_end(coordinate(rest)?.1)?,
        };
        self.chunk.uvs.push([u, v]);
        Some(after)
    }

    #[inline(always)]
    fn plain_normal<'a>(&mut self, rest: &'a [u8]) -> Option<&'a [u8]> {
        let ([x, y, z], rest) = three(rest)?;
        let after = line_end(rest)?;
        self.chunk.normals.push(vec3(x, y, z));
        Some(after)
    }

    #[inline(always)]
    fn plain_face<'a>(&mut self, rest: &'a [u8]) -> Result<Option<&'a [u8]>, End> {
        let mut rest = rest;
        self.indices.clear();
        let after = loop {
            if let Some(after) = line_end(rest) {
                break after;
            }
            let Some((corner, next)) = corner(rest) else { return Ok(None) };
            self.indices.push(corner);
            rest = next;
        };
        if self.indices.len() < 3 {
            return Ok(None);
        }
        self.push_plain_face()?;
        Ok(Some(after))
    }
}

/// One blank or more, and what follows.
#[inline(always)]
fn blanks(bytes: &[u8]) -> Option<&[u8]> {
    let [b' ' | b'\t', rest @ ..] = bytes else { return None };
    let mut rest = rest;
    while let [b' ' | b'\t', after @ ..] = rest {
        rest = after;
    }
    Some(rest)
}

/// What follows the end of a line, which blanks may come before.
#[inline(always)]
fn line_end(bytes: &[u8]) -> Option<&[u8]> {
    match bytes {
        [b'\n', rest @ ..] | [b'\r', b'\n', rest @ ..] => Some(rest),
        [b'\r', rest @ ..] => Some(rest),
        _ => match blanks(bytes)? {
            [b'\n', rest @ ..] | [b'\r', b'\n', rest @ ..] => Some(rest),
            [b'\r', rest @ ..] => Some(rest),
            _ => None,
        },
    }
}

/// Whether a word ends before these bytes.
#[inline(always)]
fn ends_word(bytes: &[u8]) -> bool {
    matches!(bytes, [b' ' | b'\t' | b'\n' | b'\r', ..])
}

#[inline(always)]
fn three(bytes: &[u8]) -> Option<([f32; 3], &[u8])> {
    let (x, rest) = coordinate(bytes)?;
    let (y, rest) = coordinate(rest)?;
    let (z, rest) = coordinate(rest)?;
    Some(([x, y, z], rest))
}

/// Blanks, a number within the range of coordinates, and what follows.
#[inline(always)]
fn coordinate(bytes: &[u8]) -> Option<(f32, &[u8])> {
    let word = blanks(bytes)?;
    let (x, length) = match plain_number(word) {
        Some(number) => number,
        None => leading_number(word)?,
    };
    let rest = &word[length..];
    (x.abs() <= MAX_COORDINATE && ends_word(rest)).then_some((x, rest))
}

/// Blanks, a corner as in the file with 0 for what it does not have, and what follows.
#[inline(always)]
fn corner(bytes: &[u8]) -> Option<([i32; 3], &[u8])> {
    let (position, rest) = index(blanks(bytes)?)?;
    let [b'/', rest @ ..] = rest else { return end_of_corner([position, 0, 0], rest) };
    let (uv, rest) = if rest.starts_with(b"/") { (0, rest) } else { index(rest)? };
    let [b'/', rest @ ..] = rest else { return end_of_corner([position, uv, 0], rest) };
    let (normal, rest) = index(rest)?;
    end_of_corner([position, uv, normal], rest)
}

#[inline(always)]
fn end_of_corner(corner: [i32; 3], rest: &[u8]) -> Option<([i32; 3], &[u8])> {
    ends_word(rest).then_some((corner, rest))
}

/// An index of at most eight digits other than 0, and what follows.
#[inline(always)]
fn index(bytes: &[u8]) -> Option<(i32, &[u8])> {
    let negative = *bytes.first()? == b'-';
    let digits = &bytes[usize::from(negative)..];
    let (value, length) = eight_digits(*digits.first_chunk()?);
    let value = if negative { -(value as i32) } else { value as i32 };
    (value != 0).then_some((value, &digits[length..]))
}
