//! The body of an ASCII file: a line a row.

use super::header::{Element, Header, text};
use super::part::Part;
use super::role::Plan;
use super::rows::{Fault, Values, read};
use super::scalar::Scalar;
use rayon::prelude::*;

/// About this many bytes are read at a time, side by side.
const CHUNK: usize = 1 << 20;

/// Reads the rows of all elements.
pub(super) fn read_body(body: &[u8], header: &Header, plan: &Plan) -> Result<Part, Fault> {
    let newline = header.newline;
    let chunks = chunks(body, newline);
    let counts: Vec<Count> = chunks.par_iter().map(|chunk| count(chunk, newline)).collect();
    // Where each chunk begins: its first row and its first line.
    let mut starts = Vec::with_capacity(chunks.len());
    let (mut row, mut line) = (0u64, u64::from(header.lines));
    for count in &counts {
        starts.push((row, line));
        row += count.rows;
        line += count.lines;
    }
    let total = row;
    if let Some((element, number)) = first_missing(&header.elements, total) {
        let message = format!(
            "the file ends before {} {number} of {}; it is cut short, or its header is wrong",
            element.name, element.count
        );
        return Err(Fault { line: Some(u32::try_from(line).unwrap_or(u32::MAX)), message });
    }
    let read_chunk = |((chunk, count), &(first_row, first_line)): ((&&[u8], &Count), &(u64, u64))| {
        let mut values =
            Text { rest: chunk, newline, line: u32::try_from(first_line).unwrap_or(u32::MAX), long_rows: 0 };
        let mut part = Part::default();
        let mut element_start = 0u64;
        for element in &header.elements {
            let element_end = element_start.saturating_add(element.rows());
            let (from, to) = (first_row.max(element_start), (first_row + count.rows).min(element_end));
            if from < to {
                read(&mut values, element, from - element_start..to - element_start, plan, &mut part)?;
            }
            element_start = element_end;
        }
        part.oddities.long_rows = values.long_rows;
        Ok(part)
    };
    let parts: Vec<Result<Part, Fault>> =
        chunks.par_iter().zip(&counts).zip(&starts).map(read_chunk).collect();
    Part::joined(parts)
}

/// The first row that so many rows do not reach.
fn first_missing(elements: &[Element], mut rows: u64) -> Option<(&Element, u64)> {
    for element in elements {
        if rows < element.rows() {
            return Some((element, rows));
        }
        rows -= element.rows();
    }
    None
}

/// Cuts at ends of lines.
fn chunks(body: &[u8], newline: u8) -> Vec<&[u8]> {
    let mut chunks = Vec::new();
    let mut rest = body;
    while rest.len() > CHUNK {
        let Some(end) = memchr::memchr(newline, &rest[CHUNK..]) else { break };
        let (chunk, after) = rest.split_at(CHUNK + end + 1);
        chunks.push(chunk);
        rest = after;
    }
    chunks.push(rest);
    chunks
}

struct Count {
    /// Lines that are not blank.
    rows: u64,
    lines: u64,
}

fn count(chunk: &[u8], newline: u8) -> Count {
    let (mut lines, mut indented) = (0, chunk.first().is_none_or(|&b| b <= b' '));
    for end in memchr::memchr_iter(newline, chunk) {
        lines += 1;
        indented |= chunk.get(end + 1).is_some_and(|&b| b <= b' ');
    }
    // A blank line starts with white space: where none does, none is blank.
    if !indented {
        return Count { rows: lines + u64::from(chunk.last() != Some(&newline)), lines };
    }
    let is_row = |line: &&[u8]| !line.iter().all(|&b| is_blank(b));
    Count { rows: chunk.split(|&b| b == newline).filter(is_row).count() as u64, lines }
}

/// White space within a line. CR is one, where LF ends lines.
#[inline]
fn is_blank(b: u8) -> bool {
    matches!(b, b' ' | b'\t' | b'\r' | 0x0b | 0x0c)
}

/// A cursor in a text.
struct Text<'a> {
    rest: &'a [u8],
    newline: u8,
    /// Of the row, from 1.
    line: u32,
    long_rows: u64,
}

impl<'a> Text<'a> {
    #[inline]
    fn skip_blanks(&mut self) {
        while let [b, rest @ ..] = self.rest
            && is_blank(*b)
            && *b != self.newline
        {
            self.rest = rest;
        }
    }

    /// The next word of the line.
    fn word(&mut self) -> Result<&'a [u8], String> {
        self.skip_blanks();
        let end = self.rest.iter().position(|&b| is_blank(b) || b == self.newline).unwrap_or(self.rest.len());
        let (word, rest) = self.rest.split_at(end);
        self.rest = rest;
        if word.is_empty() { Err("the line ends too early: numbers are missing".into()) } else { Ok(word) }
    }

    fn at_word_end(&self, rest: &[u8]) -> bool {
        rest.first().is_none_or(|&b| is_blank(b) || b == self.newline)
    }
}

impl Text<'_> {
    #[inline(always)]
    fn float<F: fast_float2::FastFloat>(&mut self) -> Result<F, String> {
        self.skip_blanks();
        if let Ok((number, length)) = fast_float2::parse_partial::<F, _>(self.rest)
            && self.at_word_end(&self.rest[length..])
        {
            self.rest = &self.rest[length..];
            return Ok(number);
        }
        Err(format!("\"{}\" is not a number", text(self.word()?)))
    }
}

impl Values for Text<'_> {
    fn start_row(&mut self) -> Result<(), String> {
        loop {
            self.line = self.line.saturating_add(1);
            self.skip_blanks();
            match self.rest {
                [b, rest @ ..] if *b == self.newline => self.rest = rest,
                _ => return Ok(()),
            }
        }
    }

    #[inline]
    fn number(&mut self, _: Scalar) -> Result<f32, String> {
        self.float()
    }

    #[inline]
    fn exact(&mut self, _: Scalar) -> Result<f64, String> {
        self.float()
    }

    #[inline]
    fn whole(&mut self, _: Scalar) -> Result<i64, String> {
        self.skip_blanks();
        let (negative, digits) = match self.rest {
            [b'-', rest @ ..] => (true, rest),
            rest => (false, rest),
        };
        let mut value = 0i64;
        let mut length = 0;
        // Eighteen digits fit.
        while let Some(digit) = digits.get(length).filter(|b| b.is_ascii_digit())
            && length < 18
        {
            value = value * 10 + i64::from(digit - b'0');
            length += 1;
        }
        if length > 0 && self.at_word_end(&digits[length..]) {
            self.rest = &digits[length..];
            return Ok(if negative { -value } else { value });
        }
        // Some write whole numbers as 3.0 or +3.
        let word = self.word()?;
        match fast_float2::parse::<f64, _>(word) {
            Ok(number) if number == number.trunc() && number.abs() < 1e15 => Ok(number as i64),
            _ => Err(format!("\"{}\" is not a whole number", text(word))),
        }
    }

    #[inline]
    fn skip(&mut self, _: Scalar, count: u64) -> Result<(), String> {
        for _ in 0..count {
            self.word()?;
        }
        Ok(())
    }

    #[inline]
    fn end_row(&mut self) {
        self.skip_blanks();
        if let [b, rest @ ..] = self.rest
            && *b == self.newline
        {
            self.rest = rest;
            return;
        }
        self.long_rows += u64::from(!self.rest.is_empty());
        let end = self.rest.iter().position(|&b| b == self.newline);
        self.rest = end.map_or(&[], |end| &self.rest[end + 1..]);
    }

    fn line(&self) -> Option<u32> {
        Some(self.line)
    }
}
