//! Wavefront OBJ: triangles, normals, texture coordinates and the names of materials.

use super::lines::{Lines, Number, number, split_key, text, words};
use crate::error::SceneError;
use crate::files::warnings::Warnings;
use crate::model::{MAX_COORDINATE, Mesh, NO_INDEX, Triangle};
use eosphor_core::math::vec3;
use std::collections::HashMap;
use std::path::Path;

/// The contents of an OBJ file. [`Triangle::material`] is a number into `materials` here; names are looked up after
/// the whole file is read, because `mtllib` may come late.
pub(super) struct ObjFile {
    pub(super) mesh: Mesh,
    /// Names given by `usemtl` with the line of their first use; empty for faces without.
    pub(super) materials: Vec<(Vec<u8>, u32)>,
    /// Arguments of `mtllib` with their lines.
    pub(super) libraries: Vec<(Vec<u8>, u32)>,
}

/// Reads an OBJ file. Polygons become fans; lines, points, curves and unknown words are passed over.
pub(super) fn parse(bytes: &[u8], path: &Path, warnings: &mut Warnings) -> Result<ObjFile, SceneError> {
    let mut reader = Reader::new(path, warnings);
    for (line, contents) in Lines::new(bytes) {
        reader.line = line;
        let (key, rest) = split_key(&contents);
        match key {
            b"v" => reader.position(rest)?,
            b"vn" => reader.normal(rest)?,
            b"vt" => reader.uv(rest)?,
            // `fo` is the old name of `f`.
            b"f" | b"fo" => reader.face(rest)?,
            b"usemtl" => reader.use_material(rest),
            b"mtllib" => reader.libraries.push((rest.to_vec(), line)),
            _ => {}
        }
    }
    reader.finish()
}

/// One corner of a face; indices count from 0.
#[derive(Clone, Copy)]
struct Corner {
    position: u32,
    uv: u32,
    normal: u32,
}

/// What the fields of a corner are numbers of.
const KINDS: [&str; 3] = ["vertex", "texture coordinate", "normal"];

/// The largest index of one kind and the line where it stood: vertices may follow the faces that use them, so that
/// positive indices are checked at the end.
#[derive(Clone, Copy, Default)]
struct Largest {
    index: u32,
    line: u32,
}

struct Reader<'a> {
    path: &'a Path,
    warnings: &'a mut Warnings,
    line: u32,
    mesh: Mesh,
    materials: Vec<(Vec<u8>, u32)>,
    material_numbers: HashMap<Vec<u8>, u32>,
    material: Option<u32>,
    libraries: Vec<(Vec<u8>, u32)>,
    corners: Vec<Corner>,
    largest: [Largest; 3],
}

impl<'a> Reader<'a> {
    fn new(path: &'a Path, warnings: &'a mut Warnings) -> Reader<'a> {
        Reader {
            path,
            warnings,
            line: 0,
            mesh: Mesh::default(),
            materials: Vec::new(),
            material_numbers: HashMap::new(),
            material: None,
            libraries: Vec::new(),
            corners: Vec::new(),
            largest: [Largest::default(); 3],
        }
    }

    fn error<T>(&self, message: impl Into<String>) -> Result<T, SceneError> {
        Err(SceneError::at(self.path, self.line, message))
    }

    fn position(&mut self, rest: &[u8]) -> Result<(), SceneError> {
        // A weight or a colour may follow; both are passed over.
        let [x, y, z] = self.numbers("v", rest, 3)?;
        self.mesh.positions.push(vec3(x, y, z));
        self.fits("vertices", self.mesh.positions.len())
    }

    fn normal(&mut self, rest: &[u8]) -> Result<(), SceneError> {
        let [x, y, z] = self.numbers("vn", rest, 3)?;
        self.mesh.normals.push(vec3(x, y, z));
        self.fits("normals", self.mesh.normals.len())
    }

    fn uv(&mut self, rest: &[u8]) -> Result<(), SceneError> {
        let [u, v, _] = self.numbers("vt", rest, 1)?;
        self.mesh.uvs.push([u, v]);
        self.fits("texture coordinates", self.mesh.uvs.len())
    }

    fn fits(&self, what: &str, count: usize) -> Result<(), SceneError> {
        if count < NO_INDEX as usize {
            return Ok(());
        }
        self.error(format!("more than {} {what}; split the file", NO_INDEX - 1))
    }

    /// The first three numbers of a line, of which `required` must be there; the others are 0.
    fn numbers(&mut self, key: &str, rest: &[u8], required: usize) -> Result<[f32; 3], SceneError> {
        let mut values = [0.0; 3];
        let mut found = 0;
        for (value, word) in values.iter_mut().zip(words(rest)) {
            *value = match number(word) {
                Number::Good(x) => x,
                Number::Stray(x) => {
                    let message = format!("stray characters after a number: \"{}\", read as {x}", text(word));
                    self.warnings.add(self.path, Some(self.line), message);
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
        if name.is_empty() {
            self.material = None;
            return;
        }
        self.material = Some(self.material_number(name));
    }

    fn material_number(&mut self, name: &[u8]) -> u32 {
        if let Some(&number) = self.material_numbers.get(name) {
            return number;
        }
        let number = self.materials.len() as u32;
        self.materials.push((name.to_vec(), self.line));
        self.material_numbers.insert(name.to_vec(), number);
        number
    }

    fn face(&mut self, rest: &[u8]) -> Result<(), SceneError> {
        let mut corners = std::mem::take(&mut self.corners);
        corners.clear();
        for word in words(rest) {
            corners.push(self.corner(word)?);
        }
        if corners.len() < 3 {
            self.warnings.add(self.path, Some(self.line), "a face with fewer than 3 corners is left out");
        } else {
            let material = match self.material {
                Some(number) => number,
                None => self.material_number(b""),
            };
            let first = corners[0];
            for pair in corners[1..].windows(2) {
                let [b, c] = [pair[0], pair[1]];
                self.mesh.triangles.push(Triangle {
                    positions: [first.position, b.position, c.position],
                    normals: [first.normal, b.normal, c.normal],
                    uvs: [first.uv, b.uv, c.uv],
                    material,
                });
            }
            self.fits("triangles", self.mesh.triangles.len())?;
        }
        self.corners = corners;
        Ok(())
    }

    /// `p`, `p/t`, `p//n` or `p/t/n`.
    fn corner(&mut self, word: &[u8]) -> Result<Corner, SceneError> {
        let mut fields = word.split(|&b| b == b'/');
        let mut field = |kind: usize| -> Result<u32, SceneError> {
            match fields.next() {
                None | Some(b"") if kind > 0 => Ok(NO_INDEX),
                field => self.index(word, field.unwrap_or(b""), kind),
            }
        };
        let corner = Corner { position: field(0)?, uv: field(1)?, normal: field(2)? };
        if fields.next().is_some() {
            return self
                .error(format!("\"{}\" is not a corner; write v, v/vt, v//vn or v/vt/vn", text(word)));
        }
        Ok(corner)
    }

    /// Resolves an index of a kind (0 positions, 1 texture coordinates, 2 normals) to one from 0. Normals and texture
    /// coordinates that do not exist are done without; positions are not.
    fn index(&mut self, word: &[u8], field: &[u8], kind: usize) -> Result<u32, SceneError> {
        let count = [self.mesh.positions.len(), self.mesh.uvs.len(), self.mesh.normals.len()][kind];
        let Some(index) = whole_number(field) else {
            return self
                .error(format!("\"{}\" is not a corner; write v, v/vt, v//vn or v/vt/vn", text(word)));
        };
        if index > 0 && index < i64::from(NO_INDEX) {
            let index = index as u32 - 1;
            if index >= self.largest[kind].index {
                self.largest[kind] = Largest { index, line: self.line };
            }
            return Ok(index);
        }
        // Negative indices count back from the newest.
        let from_start = (count as i64).saturating_add(index);
        if index < 0 && from_start >= 0 {
            return Ok(from_start as u32);
        }
        let message = match index {
            0 => format!("{} index 0; indices count from 1", KINDS[kind]),
            _ => format!("{} index {index} is out of range; there are {count}", KINDS[kind]),
        };
        if kind == 0 {
            return self.error(message);
        }
        self.warnings.add(self.path, Some(self.line), message + "; the corner goes without");
        Ok(NO_INDEX)
    }

    fn finish(mut self) -> Result<ObjFile, SceneError> {
        let counts = [self.mesh.positions.len(), self.mesh.uvs.len(), self.mesh.normals.len()];
        for (kind, name) in KINDS.into_iter().enumerate() {
            let (Largest { index, line }, count) = (self.largest[kind], counts[kind]);
            if line == 0 || (index as usize) < count {
                continue;
            }
            let message = format!("{name} index {} is out of range; the file has {count}", index + 1);
            if kind == 0 {
                return Err(SceneError::at(self.path, line, message));
            }
            self.warnings.add(self.path, Some(line), message + "; such corners go without");
            for triangle in &mut self.mesh.triangles {
                let indices = if kind == 1 { &mut triangle.uvs } else { &mut triangle.normals };
                indices.iter_mut().filter(|i| **i as usize >= count).for_each(|i| *i = NO_INDEX);
            }
        }
        if self.mesh.triangles.is_empty() {
            self.warnings.add(self.path, None, "there is nothing to see: the file has no faces");
        }
        Ok(ObjFile { mesh: self.mesh, materials: self.materials, libraries: self.libraries })
    }
}

/// A whole number with an optional sign; saturates instead of overflowing.
fn whole_number(word: &[u8]) -> Option<i64> {
    let (negative, digits) = match word {
        [b'-', rest @ ..] => (true, rest),
        [b'+', rest @ ..] => (false, rest),
        _ => (false, word),
    };
    if digits.is_empty() {
        return None;
    }
    let mut value = 0i64;
    for &digit in digits {
        if !digit.is_ascii_digit() {
            return None;
        }
        value = value.saturating_mul(10).saturating_add(i64::from(digit - b'0'));
    }
    Some(if negative { -value } else { value })
}
