//! What a piece of an OBJ file holds.

use crate::files::face_ranges::Polygon;
use crate::model::Triangle;
use eosphor_core::math::Vec3;
use std::borrow::Cow;

/// What the fields of a corner are numbers of.
pub(super) const KINDS: [&str; 3] = ["vertex", "texture coordinate", "normal"];

/// How many vertices, texture coordinates and normals there are.
pub(super) type Counts = [usize; 3];

/// The contents of a piece of an OBJ file. Lines are numbered from 1 within it; triangles, too, count from the piece's
/// start. Indices of corners are those of the whole file, from 0.
#[derive(Debug, Default, PartialEq)]
pub(super) struct Chunk {
    pub(super) positions: Vec<Vec3>,
    /// One for each position, or none at all.
    pub(super) colors: Vec<[f32; 4]>,
    pub(super) normals: Vec<Vec3>,
    pub(super) uvs: Vec<[f32; 2]>,
    /// Polygons as fans. [`Triangle::material`] is [`Chunk::BEFORE`], or 1 more than a number into `materials`.
    pub(super) triangles: Vec<Triangle>,
    /// Faces of more than three corners.
    pub(super) polygons: Vec<Polygon>,
    /// Names given by `usemtl` with the line of their first use; empty where it names none.
    pub(super) materials: Vec<(Vec<u8>, u32)>,
    /// [`Triangle::material`] of a face that would follow.
    pub(super) material: u32,
    /// Some faces take the material in force before the piece; some take none by an empty `usemtl`.
    pub(super) uses_material_before: bool,
    pub(super) uses_no_material: bool,
    pub(super) smoothing: Vec<Smoothing>,
    /// Arguments of `mtllib` with their lines.
    pub(super) libraries: Vec<(Vec<u8>, u32)>,
    pub(super) largest: [Largest; 3],
    pub(super) warnings: Vec<(u32, Cow<'static, str>)>,
    pub(super) end: End,
    /// How many lines were read.
    pub(super) lines: u32,
}

/// The smoothing group of the triangles from here on; 0 is none.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Smoothing {
    pub(super) first_triangle: u32,
    pub(super) group: u32,
}

/// The largest index of one kind, from 1, and the line where it first stood: vertices may follow the faces that use
/// them, so that positive indices are checked at the end.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Largest {
    pub(super) index: u32,
    pub(super) line: u32,
}

/// How reading a piece ended.
#[derive(Debug, Default, PartialEq)]
pub(super) enum End {
    #[default]
    Whole,
    /// The file is wrong here.
    Error { line: u32, message: String },
    /// The piece has indices that count back, and where they lead depends on how much stands before it.
    NeedsCounts,
}

impl Chunk {
    /// The material in force before the piece.
    pub(super) const BEFORE: u32 = 0;

    pub(super) fn counts(&self) -> Counts {
        [self.positions.len(), self.uvs.len(), self.normals.len()]
    }
}

/// One corner of a face; indices count from 0.
#[derive(Clone, Copy)]
pub(super) struct Corner {
    pub(super) position: u32,
    pub(super) uv: u32,
    pub(super) normal: u32,
}

/// The triangle of three corners.
#[inline(always)]
pub(super) fn triangle([a, b, c]: [Corner; 3], material: u32) -> Triangle {
    Triangle {
        positions: [a.position, b.position, c.position],
        normals: [a.normal, b.normal, c.normal],
        uvs: [a.uv, b.uv, c.uv],
        material,
    }
}

/// A corner of a triangle.
pub(super) fn corner(t: &Triangle, number: usize) -> Corner {
    Corner { position: t.positions[number], uv: t.uvs[number], normal: t.normals[number] }
}
