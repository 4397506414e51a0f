//! Faces as runs of triangles.

use std::ops::Range;

/// A face of more than three corners: a run of triangles, made as a fan.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Polygon {
    pub(super) first_triangle: u32,
    /// Two less than its corners.
    pub(super) triangles: u32,
}

/// The faces that a mesh's triangles are of.
pub(super) struct Faces {
    /// The first triangle of each face, and the number of triangles; empty where every triangle is a face.
    starts: Vec<u32>,
    triangles: usize,
}

impl Faces {
    /// The faces of a mesh of so many triangles; `polygons` are in the order of the triangles.
    pub(super) fn new(polygons: &[Polygon], triangles: usize) -> Faces {
        let mut starts = Vec::new();
        if !polygons.is_empty() {
            let saved: usize = polygons.iter().map(|p| p.triangles as usize - 1).sum();
            starts.reserve_exact(triangles - saved + 1);
            let mut next = 0;
            for p in polygons {
                starts.extend(next..=p.first_triangle);
                next = p.first_triangle + p.triangles;
            }
            starts.extend(next..=triangles as u32);
        }
        Faces { starts, triangles }
    }

    pub(super) fn len(&self) -> usize {
        if self.starts.is_empty() { self.triangles } else { self.starts.len() - 1 }
    }

    /// The triangles of a face: one at least.
    pub(super) fn triangles(&self, face: usize) -> Range<usize> {
        match self.starts.get(face..face + 2) {
            Some(ends) => ends[0] as usize..ends[1] as usize,
            None => face..face + 1,
        }
    }
}
