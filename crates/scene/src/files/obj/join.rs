//! Reads the pieces of an OBJ file in parallel and joins them in the file's order. What comes out depends neither on
//! the number of threads nor on where the file is cut.

use super::chunk::{Chunk, Counts, End, KINDS, Largest, Smoothing};
use super::reader::{self, WHITE};
use super::{lines, smoothing, triangulation};
use crate::error::{Place, SceneError};
use crate::files::face_ranges::Polygon;
use crate::files::warnings::Warnings;
use crate::files::winding::{Mended, follow_normals};
use crate::model::origin::of_triangles;
use crate::model::{Mesh, NO_INDEX, Triangle};
use rayon::prelude::*;
use std::collections::HashMap;
use std::path::Path;

/// Bytes of a piece: so few that what is made of them stays in the cache until it is joined.
const CHUNK: usize = 256 << 10;

/// The contents of an OBJ file. [`Triangle::material`] is a number into `materials` here; names are looked up after
/// the whole file is read, because `mtllib` may come late.
#[derive(Debug)]
pub(super) struct ObjFile {
    pub(super) mesh: Mesh,
    /// Names given by `usemtl` with the line of their first use. The first, without a name, is none.
    pub(super) materials: Vec<(Vec<u8>, u32)>,
    /// Some faces have no material.
    pub(super) uses_no_material: bool,
    /// Arguments of `mtllib` with their lines.
    pub(super) libraries: Vec<(Vec<u8>, u32)>,
    /// Where the mesh's coordinates are counted from, in those of the file.
    pub(super) origin: [f64; 3],
    /// Faces of more than three corners, until [`ObjFile::finish_faces`].
    polygons: Vec<Polygon>,
    smoothing: Vec<Smoothing>,
}

impl ObjFile {
    /// What can be done with faces only when all is read: winding, concave polygons, normals. `is_lamp` tells whether the
    /// material of a number here shines.
    pub(super) fn finish_faces(&mut self, is_lamp: impl Fn(u32) -> bool + Sync) -> Mended {
        let (polygons, smoothing) = (std::mem::take(&mut self.polygons), std::mem::take(&mut self.smoothing));
        let mended = follow_normals(&mut self.mesh, &polygons, is_lamp);
        triangulation::triangulate(&polygons, &self.mesh.positions, &mut self.mesh.triangles);
        smoothing::add_normals(&smoothing, &polygons, &mut self.mesh);
        mended
    }
}

/// The number of no material.
pub(super) const NO_MATERIAL: u32 = 0;

/// Reads an OBJ file. What lies more than so many of its own sizes from 0 keeps its digits.
pub(super) fn parse(
    bytes: &[u8],
    sizes: f64,
    path: &Path,
    warnings: &mut Warnings,
) -> Result<ObjFile, SceneError> {
    parse_pieces(bytes, CHUNK, sizes, path, warnings)
}

/// Reads an OBJ file in pieces of about a size. One that lies more than so many of its own sizes from 0 is read again, in
/// double precision and about a point of its own; and once more where only that shows how small it is.
pub(super) fn parse_pieces(
    bytes: &[u8],
    size: usize,
    sizes: f64,
    path: &Path,
    warnings: &mut Warnings,
) -> Result<ObjFile, SceneError> {
    let mut file = parse_about([0.0; 3], bytes, size, path, warnings)?;
    for _ in 0..2 {
        let origin = of_triangles(&file.mesh.positions, &file.mesh.triangles, file.origin, sizes);
        if origin == file.origin {
            break;
        }
        drop(file);
        // All that is odd has been said.
        file = parse_about(origin, bytes, size, path, &mut Warnings::default())?;
    }
    Ok(file)
}

fn parse_about(
    origin: [f64; 3],
    bytes: &[u8],
    size: usize,
    path: &Path,
    warnings: &mut Warnings,
) -> Result<ObjFile, SceneError> {
    let pieces = lines::cut(lines::without_mark(bytes), size);
    let mut join = Join::new(path, warnings, origin);
    let mut counts = Counts::default();
    let mut chunks = Vec::new();
    let mut joined_pieces = 0;
    // Pieces come in waves, so that no more of the file than a wave is held twice. While one is read, the one before
    // it is joined.
    for wave in pieces.chunks(16 * rayon::current_num_threads()) {
        joined_pieces += chunks.len();
        join.growth = pieces.len() as f64 / joined_pieces.max(1) as f64;
        let (joined, next) = rayon::join(|| join.append(chunks), || read_wave(wave, counts, origin));
        joined?;
        chunks = next;
        for chunk in &chunks {
            counts = sum(counts, chunk.counts());
        }
    }
    join.growth = 1.0;
    join.append(chunks)?;
    join.finish()
}

fn sum(a: Counts, b: Counts) -> Counts {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

/// Reads pieces that follow so many vertices. Few files count back, so that pieces are read without knowing what stands
/// before them; those which need to know are read again.
fn read_wave(pieces: &[&[u8]], before: Counts, origin: [f64; 3]) -> Vec<Chunk> {
    let mut chunks: Vec<Chunk> = pieces
        .par_iter()
        .enumerate()
        .map(|(i, piece)| reader::read(piece, (i == 0).then_some(before), origin))
        .collect();
    if chunks.iter().all(|chunk| chunk.end != End::NeedsCounts) {
        return chunks;
    }
    let counts: Vec<Counts> = chunks
        .par_iter()
        .zip(pieces)
        .map(|(chunk, piece)| match chunk.end {
            End::NeedsCounts => reader::count(piece),
            _ => chunk.counts(),
        })
        .collect();
    let starts = counts.iter().scan(before, |next, &count| {
        let start = *next;
        *next = sum(start, count);
        Some(start)
    });
    let starts: Vec<Counts> = starts.collect();
    chunks.par_iter_mut().zip(pieces).zip(starts).for_each(|((chunk, piece), start)| {
        if chunk.end == End::NeedsCounts {
            *chunk = reader::read(piece, Some(start), origin);
        }
    });
    chunks
}

/// Makes room for so many more items and, where there is none yet, for what is to be expected of the rest of a file: moving what is
/// there to larger and larger room takes longer than joining it. At most four times of what there will be, since files may lie, and
/// never so little more that a file whose faces come last is moved with each wave.
fn make_room<T>(items: &mut Vec<T>, more: usize, growth: f64) {
    let needed = items.len() + more;
    if needed > items.capacity() {
        items.reserve((needed as f64 * growth.clamp(1.0, 4.0)) as usize - items.len());
    }
}

/// The file as far as it is joined.
struct Join<'a> {
    path: &'a Path,
    warnings: &'a mut Warnings,
    file: ObjFile,
    material_numbers: HashMap<Vec<u8>, u32>,
    /// In force; into `file.materials`.
    material: u32,
    largest: [Largest; 3],
    lines: u32,
    /// The file's size over what of it is joined.
    growth: f64,
}

impl<'a> Join<'a> {
    fn new(path: &'a Path, warnings: &'a mut Warnings, origin: [f64; 3]) -> Join<'a> {
        Join {
            path,
            warnings,
            file: ObjFile {
                mesh: Mesh::default(),
                materials: vec![(Vec::new(), 0)],
                uses_no_material: false,
                libraries: Vec::new(),
                origin,
                polygons: Vec::new(),
                smoothing: Vec::new(),
            },
            material_numbers: HashMap::from([(Vec::new(), NO_MATERIAL)]),
            material: NO_MATERIAL,
            largest: [Largest::default(); 3],
            lines: 0,
            growth: 1.0,
        }
    }

    fn append(&mut self, chunks: Vec<Chunk>) -> Result<(), SceneError> {
        let (mesh, growth) = (&mut self.file.mesh, self.growth);
        make_room(&mut mesh.positions, chunks.iter().map(|chunk| chunk.positions.len()).sum(), growth);
        make_room(&mut mesh.normals, chunks.iter().map(|chunk| chunk.normals.len()).sum(), growth);
        make_room(&mut mesh.uvs, chunks.iter().map(|chunk| chunk.uvs.len()).sum(), growth);
        make_room(&mut mesh.triangles, chunks.iter().map(|chunk| chunk.triangles.len()).sum(), growth);
        chunks.into_iter().try_for_each(|chunk| self.append_one(chunk))
    }

    fn append_one(&mut self, chunk: Chunk) -> Result<(), SceneError> {
        let first_line = self.lines;
        let line_of = |line: u32| first_line.saturating_add(line);
        for (line, message) in chunk.warnings {
            self.warnings.add(self.path, Some(line_of(line)), message);
        }
        if let End::Error { line, message } = chunk.end {
            return Err(SceneError::at(self.path, line_of(line), message));
        }
        let first_triangle = self.file.mesh.triangles.len();

        // Materials: numbers of the piece become numbers of the file.
        self.file.uses_no_material |=
            chunk.uses_no_material || (chunk.uses_material_before && self.material == NO_MATERIAL);
        let mut numbers = vec![self.material];
        for (name, line) in &chunk.materials {
            numbers.push(self.material_number(name, line_of(*line)));
        }
        self.material = numbers[chunk.material as usize];
        let libraries = chunk.libraries.into_iter().map(|(names, line)| (names, line_of(line)));
        self.file.libraries.extend(libraries);

        // Geometry.
        let mesh = &mut self.file.mesh;
        if !chunk.colors.is_empty() || !mesh.colors.is_empty() {
            mesh.colors.resize(mesh.positions.len(), WHITE);
            mesh.colors.extend_from_slice(&chunk.colors);
            mesh.colors.resize(mesh.positions.len() + chunk.positions.len(), WHITE);
        }
        mesh.positions.extend_from_slice(&chunk.positions);
        mesh.normals.extend_from_slice(&chunk.normals);
        mesh.uvs.extend_from_slice(&chunk.uvs);
        let in_file = |t: &Triangle| Triangle { material: numbers[t.material as usize], ..*t };
        mesh.triangles.extend(chunk.triangles.iter().map(in_file));
        self.fits()?;
        let first_triangle = first_triangle as u32;
        self.file.polygons.extend(
            chunk
                .polygons
                .iter()
                .map(|p| Polygon { first_triangle: first_triangle + p.first_triangle, ..*p }),
        );
        self.file.smoothing.extend(
            chunk
                .smoothing
                .iter()
                .map(|s| Smoothing { first_triangle: first_triangle + s.first_triangle, ..*s }),
        );
        for (largest, of_chunk) in self.largest.iter_mut().zip(chunk.largest) {
            if of_chunk.index > largest.index {
                *largest = Largest { line: line_of(of_chunk.line), ..of_chunk };
            }
        }
        self.lines = line_of(chunk.lines);
        Ok(())
    }

    fn material_number(&mut self, name: &[u8], line: u32) -> u32 {
        if let Some(&number) = self.material_numbers.get(name) {
            return number;
        }
        let number = self.file.materials.len() as u32;
        self.file.materials.push((name.to_vec(), line));
        self.material_numbers.insert(name.to_vec(), number);
        number
    }

    fn error<T>(&self, message: impl Into<String>) -> Result<T, SceneError> {
        Err(SceneError::invalid(Place::file(self.path), message))
    }

    fn fits(&self) -> Result<(), SceneError> {
        let mesh = &self.file.mesh;
        for (what, count) in [
            ("vertices", mesh.positions.len()),
            ("normals", mesh.normals.len()),
            ("texture coordinates", mesh.uvs.len()),
            ("triangles", mesh.triangles.len()),
        ] {
            if count >= NO_INDEX as usize {
                return self.error(format!("more than {} {what}; split the file", NO_INDEX - 1));
            }
        }
        Ok(())
    }

    /// What can be done only when all is read.
    fn finish(mut self) -> Result<ObjFile, SceneError> {
        self.check_indices()?;
        let mesh = &mut self.file.mesh;
        if mesh.triangles.is_empty() && mesh.positions.is_empty() {
            return self.error("there are no vertices and no faces; is this an OBJ file?");
        }
        if mesh.triangles.is_empty() {
            self.warnings.add(self.path, None, "there is nothing to see: the file has no faces");
        }
        Ok(self.file)
    }

    /// Positions that do not exist are an error; corners do without other things that do not.
    fn check_indices(&mut self) -> Result<(), SceneError> {
        let mesh = &mut self.file.mesh;
        let counts = [mesh.positions.len(), mesh.uvs.len(), mesh.normals.len()];
        for (kind, name) in KINDS.into_iter().enumerate() {
            let (Largest { index, line }, count) = (self.largest[kind], counts[kind]);
            if index as usize <= count {
                continue;
            }
            let message = format!("{name} index {index} is out of range; the file has {count}");
            if kind == 0 {
                return Err(SceneError::at(self.path, line, message));
            }
            self.warnings.add(self.path, Some(line), message + "; such corners go without");
            mesh.triangles.par_iter_mut().for_each(|triangle| {
                let indices = if kind == 1 { &mut triangle.uvs } else { &mut triangle.normals };
                indices.iter_mut().filter(|i| **i as usize >= count).for_each(|i| *i = NO_INDEX);
            });
        }
        Ok(())
    }
}
