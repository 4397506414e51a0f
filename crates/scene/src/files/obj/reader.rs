//! Reads a piece of an OBJ file. Plain lines go the fast way ([`super::plain`]), all others this one, which knows
//! everything.

use super::chunk::{Chunk, Corner, Counts, End, KINDS, Largest, Smoothing, triangle};
use super::lines::{Lines, split_key, text, words};
use super::number::{Number, exact_number, number, whole_number};
use crate::files::face_ranges::Polygon;
use crate::model::{MAX_COORDINATE, NO_INDEX};
use eosphor_core::math::{elementary64, vec3};
use memchr::memchr;
use std::borrow::Cow;
use std::collections::HashMap;

/// The colour of vertices without one.
pub(super) const WHITE: [f32; 4] = [1.0; 4];

/// Reads a piece; `before` is what stands before it in the file, where that is known. Positions are counted from
/// `origin`. Lines, points, curves and unknown words are passed over.
pub(super) fn read(bytes: &[u8], before: Option<Counts>, origin: [f64; 3]) -> Chunk {
    let mut reader = Reader::new(before, origin);
    if let Err(end) = reader.lines(bytes) {
        reader.chunk.end = end;
    }
    reader.chunk
}

/// How many vertices, texture coordinates and normals a piece has, if nothing in it is wrong.
pub(super) fn count(bytes: &[u8]) -> Counts {
    let mut counts = [0; 3];
    for (_, line) in Lines::after(bytes, 0) {
        match split_key(&line).0 {
            b"v" => counts[0] += 1,
            b"vt" => counts[1] += 1,
            b"vn" => counts[2] += 1,
            _ => {}
        }
    }
    counts
}

pub(super) struct Reader {
    pub(super) chunk: Chunk,
    before: Option<Counts>,
    /// Positions are counted from here, in double precision, where it is not 0.
    origin: Option<[f64; 3]>,
    /// The line that is being read.
    pub(super) line: u32,
    material_numbers: HashMap<Vec<u8>, u32>,
    corners: Vec<Corner>,
    /// Scratch for [`super::plain`].
    pub(super) indices: Vec<[i32; 3]>,
}

impl Reader {
    /// Whether positions are counted from 0, in single precision.
    #[inline(always)]
    pub(super) fn is_near(&self) -> bool {
        self.origin.is_none()
    }

    fn new(before: Option<Counts>, origin: [f64; 3]) -> Reader {
        Reader {
            chunk: Chunk::default(),
            before,
            origin: (origin != [0.0; 3]).then_some(origin),
            line: 0,
            material_numbers: HashMap::new(),
            corners: Vec::new(),
            indices: Vec::new(),
        }
    }

    fn lines(&mut self, bytes: &[u8]) -> Result<(), End> {
        let mut rest = bytes;
        loop {
            rest = self.plain_lines(rest)?;
            let mut lines = Lines::after(rest, self.chunk.lines);
            let next = lines.next();
            self.chunk.lines = lines.number();
            rest = lines.rest();
            let Some((line, contents)) = next else { return Ok(()) };
            self.line = line;
            self.any_line(&contents)?;
        }
    }

    fn any_line(&mut self, line: &[u8]) -> Result<(), End> {
        if memchr(0, line).is_some() {
            return self.error(super::ZERO_BYTE);
        }
        let (key, rest) = split_key(line);
        match key {
            b"v" => self.position(rest)?,
            b"vn" => {
                let [x, y, z] = self.numbers("vn", rest, 3)?;
                self.chunk.normals.push(vec3(x, y, z));
            }
            b"vt" => {
                let [u, v, _] = self.numbers("vt", rest, 1)?;
                self.chunk.uvs.push([u, v]);
            }
            // `fo` is the old name of `f`.
            b"f" | b"fo" => self.face(rest)?,
            b"usemtl" => self.use_material(rest),
            b"mtllib" => self.chunk.libraries.push((rest.to_vec(), self.line)),
            b"s" => self.smoothing(rest),
            _ => {}
        }
        Ok(())
    }

    fn error<T>(&self, message: impl Into<String>) -> Result<T, End> {
        Err(End::Error { line: self.line, message: message.into() })
    }

    fn warn(&mut self, message: impl Into<Cow<'static, str>>) {
        self.chunk.warnings.push((self.line, message.into()));
    }

    /// `v x y z`, and after it a weight, which is passed over, or a colour, or both.
    fn position(&mut self, rest: &[u8]) -> Result<(), End> {
        let mut p = self.numbers("v", rest, 3)?;
        if let Some(origin) = self.origin {
            let about = |(word, origin): (&[u8], f64)| (exact_number(word) - origin) as f32;
            let mut exact = words(rest).zip(origin).map(about);
            p = p.map(|rounded| exact.next().unwrap_or(rounded));
        }
        let mut extra = [0.0; 4];
        let mut count = 0;
        for word in words(rest).skip(3).take(4) {
            extra[count] = match number(word) {
                Number::Good(x) | Number::Stray(x) => x,
                Number::NotFinite => f32::NAN,
                Number::Bad => break,
            };
            count += 1;
        }
        let [a, b, c, d] = extra;
        let color = match count {
            3 => Some([a, b, c]),
            4 => Some([b, c, d]),
            _ => None,
        };
        self.push_position(p, color);
        Ok(())
    }

    #[inline(always)]
    pub(super) fn push_position(&mut self, [x, y, z]: [f32; 3], color: Option<[f32; 3]>) {
        if let Some(color) = color {
            self.color(color);
        } else if !self.chunk.colors.is_empty() {
            self.chunk.colors.push(WHITE);
        }
        self.chunk.positions.push(vec3(x, y, z));
    }

    /// The colour of the position that comes next. MeshLab, who began it, and others write what a screen shows: sRGB
    /// codes from 0 to 1.
    #[inline(never)]
    fn color(&mut self, color: [f32; 3]) {
        self.chunk.colors.resize(self.chunk.positions.len(), WHITE);
        let linear = color.map(|x| elementary64::srgb_to_linear(f64::from(x.clamp(0.0, 1.0))) as f32);
        if color.iter().all(|x| (0.0..=1.0).contains(x)) {
            self.chunk.colors.push([linear[0], linear[1], linear[2], 1.0]);
        } else if color.iter().any(|x| x.is_nan()) {
            self.warn("a vertex colour is not a finite number; the vertex is white");
            self.chunk.colors.push(WHITE);
        } else {
            self.warn("a vertex colour is not within 0 to 1; it is cut to that");
            self.chunk.colors.push([linear[0], linear[1], linear[2], 1.0]);
        }
    }

    /// The first three numbers of a line, of which `required` must be there; the others are 0.
    fn numbers(&mut self, key: &str, rest: &[u8], required: usize) -> Result<[f32; 3], End> {
        let mut values = [0.0; 3];
        let mut found = 0;
        for (value, word) in values.iter_mut().zip(words(rest)) {
            *value = match number(word) {
                Number::Good(x) => x,
                Number::Stray(x) => {
                    self.warn(format!("stray characters after a number: \"{}\", read as {x}", text(word)));
                    x
                }
                Number::NotFinite => {
                    return self.error(format!("\"{}\" is not a finite number; mend the file", text(word)));
                }
                // What is no number after the required ones is passed over.
                Number::Bad if found >= required => break,
                Number::Bad => return self.error(format!("\"{}\" is not a number", text(word))),
            };
            if value.abs() > MAX_COORDINATE {
                return self
                    .error(format!("{value:e} is out of range; numbers must be within {MAX_COORDINATE:e}"));
            }
            found += 1;
        }
        if found < required {
            return self.error(format!("\"{key}\" needs {required} numbers, found {found}"));
        }
        Ok(values)
    }

    fn use_material(&mut self, name: &[u8]) {
        let next = self.chunk.materials.len() as u32 + 1;
        self.chunk.material = match self.material_numbers.get(name) {
            Some(&number) => number,
            None => {
                self.chunk.materials.push((name.to_vec(), self.line));
                self.material_numbers.insert(name.to_vec(), next);
                next
            }
        };
    }

    fn smoothing(&mut self, rest: &[u8]) {
        let group = match (rest, whole_number(rest)) {
            (b"off", _) => 0,
            (b"on", _) => 1,
            (_, Some(group)) if group >= 0 && group <= i64::from(u32::MAX) => group as u32,
            _ => {
                let name = text(rest);
                return self
                    .warn(format!("\"s {name}\" is passed over; write s and a group's number, or s off"));
            }
        };
        self.chunk.smoothing.push(Smoothing { first_triangle: self.chunk.triangles.len() as u32, group });
    }

    fn face(&mut self, rest: &[u8]) -> Result<(), End> {
        self.corners.clear();
        for word in words(rest) {
            let corner = self.corner(word)?;
            self.corners.push(corner);
        }
        if self.corners.len() < 3 {
            self.warn("a face with fewer than 3 corners is left out");
        } else {
            self.push_face();
        }
        Ok(())
    }

    /// Adds a face of three or more corners, given as in `indices`.
    #[inline(always)]
    pub(super) fn push_plain_face(&mut self) -> Result<(), End> {
        self.corners.clear();
        for i in 0..self.indices.len() {
            let [position, uv, normal] = self.indices[i];
            let position = self.index(i64::from(position), 0)?;
            let uv = if uv == 0 { NO_INDEX } else { self.index(i64::from(uv), 1)? };
            let normal = if normal == 0 { NO_INDEX } else { self.index(i64::from(normal), 2)? };
            self.corners.push(Corner { position, uv, normal });
        }
        self.push_face();
        Ok(())
    }

    /// Adds the face of three or more corners that are at hand.
    #[inline(always)]
    fn push_face(&mut self) {
        let chunk = &mut self.chunk;
        let material = chunk.material;
        if material == Chunk::BEFORE {
            chunk.uses_material_before = true;
        } else if chunk.materials[material as usize - 1].0.is_empty() {
            chunk.uses_no_material = true;
        }
        let first_triangle = chunk.triangles.len() as u32;
        let [first, second, third, ref others @ ..] = self.corners[..] else { return };
        chunk.triangles.push(triangle([first, second, third], material));
        if !others.is_empty() {
            let mut last = third;
            for &next in others {
                chunk.triangles.push(triangle([first, last, next], material));
                last = next;
            }
            chunk.polygons.push(Polygon { first_triangle, triangles: others.len() as u32 + 1 });
        }
    }

    /// `p`, `p/t`, `p//n` or `p/t/n`.
    fn corner(&mut self, word: &[u8]) -> Result<Corner, End> {
        let mut fields = word.split(|&b| b == b'/');
        let mut field = |kind: usize| -> Result<u32, End> {
            match fields.next() {
                None | Some(b"") if kind > 0 => Ok(NO_INDEX),
                field => self.field(word, field.unwrap_or(b""), kind),
            }
        };
        let corner = Corner { position: field(0)?, uv: field(1)?, normal: field(2)? };
        if fields.next().is_some() {
            return self.no_corner(word);
        }
        Ok(corner)
    }

    fn no_corner<T>(&self, word: &[u8]) -> Result<T, End> {
        self.error(format!("\"{}\" is not a corner; write v, v/vt, v//vn or v/vt/vn", text(word)))
    }

    fn field(&mut self, word: &[u8], field: &[u8], kind: usize) -> Result<u32, End> {
        match whole_number(field) {
            Some(index) => self.index(index, kind),
            None => self.no_corner(word),
        }
    }

    /// How many of a kind there are so far in the file.
    fn so_far(&self, kind: usize) -> Result<usize, End> {
        Ok(self.before.ok_or(End::NeedsCounts)?[kind] + self.chunk.counts()[kind])
    }

    /// Resolves an index of a kind to one from 0. Normals and texture coordinates that do not exist are done without;
    /// positions are not.
    #[inline(always)]
    fn index(&mut self, index: i64, kind: usize) -> Result<u32, End> {
        if index > 0 && index < i64::from(NO_INDEX) {
            if index > i64::from(self.chunk.largest[kind].index) {
                self.chunk.largest[kind] = Largest { index: index as u32, line: self.line };
            }
            return Ok(index as u32 - 1);
        }
        self.unusual_index(index, kind)
    }

    #[inline(never)]
    fn unusual_index(&mut self, index: i64, kind: usize) -> Result<u32, End> {
        let message = if index == 0 {
            format!("{} index 0; indices count from 1", KINDS[kind])
        } else {
            // Negative indices count back from the newest.
            let count = self.so_far(kind)?;
            let from_start = (count as i64).saturating_add(index);
            if index < 0 && from_start >= 0 {
                return Ok(from_start as u32);
            }
            format!("{} index {index} is out of range; there are {count}", KINDS[kind])
        };
        if kind == 0 {
            return self.error(message);
        }
        self.warn(message + "; the corner goes without");
        Ok(NO_INDEX)
    }
}
