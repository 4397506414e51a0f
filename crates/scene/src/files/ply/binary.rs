//! The body of a binary file.

use super::fast;
use super::header::{Element, Encoding, Header, Shape};
use super::part::Part;
use super::role::{Kind, Plan, Role};
use super::rows::{Fault, Values, read};
use super::scalar::Scalar;
use rayon::prelude::*;
use std::ops::Range;

/// About this many bytes are read at a time, side by side, where rows have one size.
const CHUNK: usize = 1 << 20;

/// Reads the rows of all elements. The body begins right after the line `end_header`: a byte that looks like the end
/// of a line is part of the first number.
pub(super) fn read_body(body: &[u8], header: &Header, plan: &Plan) -> Result<Part, Fault> {
    let mut whole = Part::default();
    let mut rest = body;
    for element in &header.elements {
        let (part, after) = match header.encoding {
            Encoding::BigEndian => read_element::<false>(rest, element, plan)?,
            _ => read_element::<true>(rest, element, plan)?,
        };
        whole.append(part)?;
        rest = after;
    }
    Ok(whole)
}

/// Reads the rows of an element; what comes after them.
fn read_element<'a, const LITTLE: bool>(
    bytes: &'a [u8],
    element: &Element,
    plan: &Plan,
) -> Result<(Part, &'a [u8]), Fault> {
    let rows = element.rows();
    let least = element.least_size();
    // Before anything is allocated: are the rows there at all?
    if rows.checked_mul(least as u64).is_none_or(|size| size > bytes.len() as u64) {
        let message = format!(
            "the header promises {rows} rows \"{}\" of at least {least} bytes, but {} bytes are left: the file is cut \
             short, or its header is wrong",
            element.name,
            bytes.len()
        );
        return Err(Fault { line: None, message });
    }
    let mut part = Part::default();
    let Some(size) = row_size(bytes, element) else {
        let mut values = Bytes::<LITTLE> { rest: bytes };
        read(&mut values, element, 0..rows, plan, &mut part)?;
        return Ok((part, values.rest));
    };
    let (own, after) = bytes.split_at(rows as usize * size);
    if element.kind == Kind::Other || rows == 0 {
        return Ok((part, after));
    }
    if LITTLE
        && plan.is_near()
        && let Some(part) = fast::read(own, element, size, plan)?
    {
        return Ok((part, after));
    }
    let rows_a_chunk = (CHUNK / size).max(1);
    let read_chunk = |(number, chunk): (usize, &[u8])| {
        let first = (number * rows_a_chunk) as u64;
        let rows: Range<u64> = first..first + (chunk.len() / size) as u64;
        let mut part = Part::default();
        read(&mut Bytes::<LITTLE> { rest: chunk }, element, rows, plan, &mut part)?;
        Ok(part)
    };
    let parts: Vec<Result<Part, Fault>> =
        own.par_chunks(rows_a_chunk * size).enumerate().map(read_chunk).collect();
    Ok((Part::joined(parts)?, after))
}

/// The size that all rows of an element have: it has no list, or one list of bytes for lengths, and every one of them
/// is 3. `None` where sizes differ.
fn row_size(bytes: &[u8], element: &Element) -> Option<usize> {
    let mut lists = element.properties.iter().filter(|p| matches!(p.shape, Shape::List { .. }));
    let least = element.least_size();
    let Some(list) = lists.next() else { return Some(least) };
    let Shape::List { length, item } = list.shape else { return None };
    if lists.next().is_some() || length.size() != 1 || list.role != Role::Indices {
        return None;
    }
    let before = element.properties.iter().take_while(|p| *p != list);
    let offset: usize = before.map(|p| if let Shape::One(s) = p.shape { s.size() } else { 0 }).sum();
    let size = least + 3 * item.size();
    let own = bytes.get(..size.checked_mul(usize::try_from(element.rows()).ok()?)?)?;
    own.par_chunks(size * 65_536)
        .all(|rows| rows.chunks_exact(size).all(|row| row[offset] == 3))
        .then_some(size)
}

/// A cursor in bytes.
struct Bytes<'a, const LITTLE: bool> {
    rest: &'a [u8],
}

const CUT_SHORT: &str = "the file ends within it; it is cut short, or its header is wrong";

impl<const LITTLE: bool> Bytes<'_, LITTLE> {
    #[inline]
    fn take<const N: usize>(&mut self) -> Result<[u8; N], String> {
        let Some((bytes, rest)) = self.rest.split_first_chunk::<N>() else { return Err(CUT_SHORT.into()) };
        self.rest = rest;
        let mut bytes = *bytes;
        if !LITTLE {
            bytes.reverse();
        }
        Ok(bytes)
    }
}

impl<const LITTLE: bool> Values for Bytes<'_, LITTLE> {
    fn start_row(&mut self) -> Result<(), String> {
        Ok(())
    }

    #[inline]
    fn number(&mut self, scalar: Scalar) -> Result<f32, String> {
        Ok(match scalar {
            Scalar::F32 => f32::from_le_bytes(self.take()?),
            Scalar::F64 => f64::from_le_bytes(self.take()?) as f32,
            _ => self.whole(scalar)? as f32,
        })
    }

    #[inline]
    fn exact(&mut self, scalar: Scalar) -> Result<f64, String> {
        Ok(match scalar {
            Scalar::F64 => f64::from_le_bytes(self.take()?),
            Scalar::F32 => f32::from_le_bytes(self.take()?).into(),
            _ => self.whole(scalar)? as f64,
        })
    }

    #[inline]
    fn whole(&mut self, scalar: Scalar) -> Result<i64, String> {
        Ok(match scalar {
            Scalar::I8 => i8::from_le_bytes(self.take()?).into(),
            Scalar::U8 => u8::from_le_bytes(self.take()?).into(),
            Scalar::I16 => i16::from_le_bytes(self.take()?).into(),
            Scalar::U16 => u16::from_le_bytes(self.take()?).into(),
            Scalar::I32 => i32::from_le_bytes(self.take()?).into(),
            Scalar::U32 => u32::from_le_bytes(self.take()?).into(),
            // The header lets no floats be indices or lengths.
            Scalar::F32 | Scalar::F64 => return Err("a float where a whole number must be".into()),
        })
    }

    #[inline]
    fn skip(&mut self, scalar: Scalar, count: u64) -> Result<(), String> {
        let size = usize::try_from(count).ok().and_then(|count| count.checked_mul(scalar.size()));
        match size.and_then(|size| self.rest.get(size..)) {
            Some(rest) => self.rest = rest,
            None => return Err(CUT_SHORT.into()),
        }
        Ok(())
    }

    fn end_row(&mut self) {}

    fn line(&self) -> Option<u32> {
        None
    }
}
