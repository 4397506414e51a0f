//! The header: which elements follow, and of what they are made.

use super::role::{Kind, Role};
use super::scalar::{NAMES, Scalar};
use crate::error::SceneError;
use crate::files::warnings::Warnings;
use std::path::Path;

/// Longer headers are no headers.
const MAX_BYTES: usize = 1 << 20;
const MAX_ELEMENTS: usize = 256;
/// Most properties of all elements together.
const MAX_PROPERTIES: usize = 4096;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Encoding {
    Ascii,
    LittleEndian,
    BigEndian,
}

#[derive(Debug)]
pub(super) struct Header {
    pub(super) encoding: Encoding,
    pub(super) elements: Vec<Element>,
    /// Pictures that comments name, as MeshLab writes them, with their lines.
    pub(super) textures: Vec<(Vec<u8>, u32)>,
    /// Where the header ends in the file.
    pub(super) size: usize,
    /// Its number of lines.
    pub(super) lines: u32,
    /// What ends a line: LF, which a CR may precede, or CR alone.
    pub(super) newline: u8,
}

/// So many rows, each with these properties.
#[derive(Debug)]
pub(super) struct Element {
    pub(super) name: String,
    pub(super) kind: Kind,
    pub(super) count: u64,
    pub(super) properties: Vec<Property>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Property {
    pub(super) role: Role,
    pub(super) shape: Shape,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Shape {
    One(Scalar),
    List { length: Scalar, item: Scalar },
}

impl Element {
    /// Rows in the file: an element without properties has none, whatever its count.
    pub(super) fn rows(&self) -> u64 {
        if self.properties.is_empty() { 0 } else { self.count }
    }

    /// Bytes of a row in a binary file, at least: with all lists empty.
    pub(super) fn least_size(&self) -> usize {
        let size = |p: &Property| match p.shape {
            Shape::One(scalar) => scalar.size(),
            Shape::List { length, .. } => length.size(),
        };
        self.properties.iter().map(size).sum()
    }

    pub(super) fn has(&self, role: Role) -> bool {
        self.properties.iter().any(|p| p.role == role)
    }
}

/// Reads the header of a file.
pub(super) fn parse(bytes: &[u8], path: &Path, warnings: &mut Warnings) -> Result<Header, SceneError> {
    let wrong = |message: &str| super::at(path, None, message);
    let newline = match bytes {
        [b'p', b'l', b'y', b'\r', b'\n', ..] | [b'p', b'l', b'y', b'\n' | b' ' | b'\t', ..] => b'\n',
        [b'p', b'l', b'y', b'\r', ..] => b'\r',
        _ => return Err(wrong("this is no PLY file: it does not start with the line \"ply\"")),
    };
    let mut reader =
        Reader { path, warnings, line: 0, encoding: None, elements: Vec::new(), textures: Vec::new() };
    let mut at = 0;
    loop {
        let rest = &bytes[at..bytes.len().min(MAX_BYTES)];
        let Some(length) = rest.iter().position(|&b| b == newline) else {
            return Err(wrong(match bytes.len() > MAX_BYTES {
                true => "the header is longer than 1 MiB; is this a PLY file?",
                false => "the header does not end: the line \"end_header\" is missing",
            }));
        };
        at += length + 1;
        reader.line += 1;
        if reader.line > 1 && reader.read_line(&rest[..length])? {
            break;
        }
    }
    let Reader { line: lines, encoding, elements, textures, .. } = reader;
    let encoding = encoding.ok_or_else(|| {
        wrong("the header has no \"format\"; it needs ascii, binary_little_endian or binary_big_endian")
    })?;
    Ok(Header { encoding, elements, textures, size: at, lines, newline })
}

struct Reader<'a> {
    path: &'a Path,
    warnings: &'a mut Warnings,
    line: u32,
    encoding: Option<Encoding>,
    elements: Vec<Element>,
    textures: Vec<(Vec<u8>, u32)>,
}

impl Reader<'_> {
    fn error<T>(&self, message: impl Into<String>) -> Result<T, SceneError> {
        Err(super::at(self.path, Some(self.line), message))
    }

    /// Reads a line; whether it was the last.
    fn read_line(&mut self, line: &[u8]) -> Result<bool, SceneError> {
        let (key, rest) = split_word(line.trim_ascii());
        match key {
            b"end_header" => return Ok(true),
            b"format" => self.format(rest)?,
            b"element" => self.element(rest)?,
            b"property" => self.property(rest)?,
            b"comment" => {
                let (word, name) = split_word(rest);
                if word.eq_ignore_ascii_case(b"TextureFile") && !name.is_empty() {
                    self.textures.push((name.to_vec(), self.line));
                }
            }
            b"obj_info" | b"" => {}
            _ => {
                let message = format!("unknown header line \"{}\"; passed over", text(line.trim_ascii()));
                self.warnings.add(self.path, Some(self.line), message);
            }
        }
        Ok(false)
    }

    fn format(&mut self, rest: &[u8]) -> Result<(), SceneError> {
        let (name, version) = split_word(rest);
        self.encoding = Some(match name {
            b"ascii" => Encoding::Ascii,
            b"binary_little_endian" => Encoding::LittleEndian,
            b"binary_big_endian" => Encoding::BigEndian,
            _ => {
                return self.error(format!(
                    "unknown format \"{}\"; there are ascii, binary_little_endian and binary_big_endian",
                    text(name)
                ));
            }
        });
        if version != b"1.0" {
            let message = format!("version \"{}\" of PLY is read as 1.0", text(version));
            self.warnings.add(self.path, Some(self.line), message);
        }
        Ok(())
    }

    fn element(&mut self, rest: &[u8]) -> Result<(), SceneError> {
        let (name, rest) = split_word(rest);
        let count = std::str::from_utf8(rest).ok().and_then(|count| count.parse().ok());
        let Some(count) = count.filter(|_| !name.is_empty()) else {
            return self.error(format!("\"{}\" is no count; write: element NAME COUNT", text(rest)));
        };
        if self.elements.len() == MAX_ELEMENTS {
            return self.error(format!("more than {MAX_ELEMENTS} elements are too many"));
        }
        let kind = Kind::of_name(name);
        if kind == Kind::Vertex && self.elements.iter().any(|e| e.kind == kind) {
            return self.error("a second element \"vertex\"; there can be one only");
        }
        if kind == Kind::Vertex && count >= u64::from(u32::MAX) {
            return self.error(format!("{count} vertices are too many; the limit is 2^32 - 2"));
        }
        self.elements.push(Element { name: text(name), kind, count, properties: Vec::new() });
        Ok(())
    }

    fn property(&mut self, rest: &[u8]) -> Result<(), SceneError> {
        let (first, rest) = split_word(rest);
        let (shape, name) = if first == b"list" {
            let (length, rest) = split_word(rest);
            let (item, name) = split_word(rest);
            let (length, item) = (self.scalar(length)?, self.scalar(item)?);
            if !length.is_whole() {
                return self.error("the length of a list must be a whole number: uchar, int, ...");
            }
            (Shape::List { length, item }, name)
        } else {
            (Shape::One(self.scalar(first)?), rest)
        };
        if name.is_empty() {
            return self.error(
                "a property without a name; write: property TYPE NAME, or: property list TYPE TYPE NAME",
            );
        }
        if self.elements.iter().map(|e| e.properties.len()).sum::<usize>() == MAX_PROPERTIES {
            return self.error(format!("more than {MAX_PROPERTIES} properties are too many"));
        }
        let Some(element) = self.elements.last_mut() else {
            return self.error("a property before the first element");
        };
        // Where two names mean the same, the first counts.
        let role =
            Some(Role::of(element.kind, name, shape)).filter(|&r| !element.has(r)).unwrap_or(Role::Skip);
        element.properties.push(Property { role, shape });
        Ok(())
    }

    fn scalar(&self, name: &[u8]) -> Result<Scalar, SceneError> {
        match Scalar::of_name(name) {
            Some(scalar) => Ok(scalar),
            None => self.error(format!("unknown type \"{}\"; there are {NAMES}", text(name))),
        }
    }
}

/// The first word and the trimmed rest.
fn split_word(line: &[u8]) -> (&[u8], &[u8]) {
    let end = line.iter().position(u8::is_ascii_whitespace).unwrap_or(line.len());
    (&line[..end], line[end..].trim_ascii())
}

/// Bytes for messages, cut to a bearable length.
pub(super) fn text(bytes: &[u8]) -> String {
    const MAX: usize = 80;
    let cut = String::from_utf8_lossy(&bytes[..bytes.len().min(MAX)]).into_owned();
    if bytes.len() > MAX { cut + "..." } else { cut }
}
