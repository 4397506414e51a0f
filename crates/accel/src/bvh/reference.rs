//! Primitives on their way into a tree.

use super::lanes::{Box4, Lanes};
use super::memory::room_for;
use eosphor_core::geometry::Bounds;
use eosphor_core::intersect::PackedTriangle;
use eosphor_core::math::Vec3;
use rayon::prelude::*;
use std::ops::Range;

/// A primitive's padded bounds and its number, 32 bytes: two SSE loads.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(32))]
pub(super) struct Reference {
    /// Smallest x, y, z; the primitive's number, as bits.
    low: [f32; 4],
    /// Largest x, y, z; nothing.
    high: [f32; 4],
}

impl Reference {
    pub(super) const NONE: Reference = Reference { low: [0.0; 4], high: [0.0; 4] };

    #[inline(always)]
    pub(super) fn new(bounds: &Bounds, index: u32) -> Reference {
        // Finite, so that the centre of a box without end is a number.
        let (l, h) = (bounds.min.max(Vec3::splat(f32::MIN)), bounds.max.min(Vec3::splat(f32::MAX)));
        Reference { low: [l.x, l.y, l.z, f32::from_bits(index)], high: [h.x, h.y, h.z, 0.0] }
    }

    #[inline(always)]
    pub(super) fn with_box(bounds: Box4, index: u32) -> Reference {
        let (mut low, high) = (bounds.low.array(), bounds.high.array());
        low[3] = f32::from_bits(index);
        Reference { low, high }
    }

    #[inline(always)]
    pub(super) fn index(&self) -> u32 {
        self.low[3].to_bits()
    }

    #[inline(always)]
    pub(super) fn box4(&self) -> Box4 {
        Box4 { low: Lanes::from_array(&self.low), high: Lanes::from_array(&self.high) }
    }

    /// Twice the centre of the box; the fourth lane is 0.
    #[inline(always)]
    pub(super) fn center2(&self) -> Lanes {
        let b = self.box4();
        b.low.xyz0().plus(b.high.xyz0())
    }

    /// [`Reference::center2`] on one axis.
    #[inline(always)]
    pub(super) fn center2_on(&self, axis: usize) -> f32 {
        self.low[axis & 3] + self.high[axis & 3]
    }

    #[inline(always)]
    pub(super) fn low_on(&self, axis: usize) -> f32 {
        self.low[axis & 3]
    }

    /// Several parts of one primitive in a leaf are the primitive once.
    pub(super) fn without_doubles(references: &mut [Reference]) -> &[Reference] {
        let mut kept = 0;
        for k in 0..references.len() {
            if references[..kept].iter().all(|r| r.index() != references[k].index()) {
                references[kept] = references[k];
                kept += 1;
            }
        }
        &references[..kept]
    }

    #[inline(always)]
    pub(super) fn high_on(&self, axis: usize) -> f32 {
        self.high[axis & 3]
    }
}

/// What is known about a set of references: the box around them, and the box around twice their centres.
#[derive(Clone, Copy)]
pub(super) struct Extent {
    pub(super) bounds: Box4,
    pub(super) centers2: Box4,
}

impl Extent {
    #[inline(always)]
    pub(super) fn empty() -> Extent {
        Extent { bounds: Box4::empty(), centers2: Box4::empty() }
    }

    #[inline(always)]
    pub(super) fn add(&mut self, r: &Reference) {
        self.bounds = self.bounds.union(r.box4());
        self.centers2 = self.centers2.including(r.center2());
    }

    pub(super) fn union(self, o: Extent) -> Extent {
        Extent { bounds: self.bounds.union(o.bounds), centers2: self.centers2.union(o.centers2) }
    }
}

/// For each [`CHUNK`] of triangles, the largest sizes of their boxes on the three axes.
pub(super) struct Largest(Vec<Lanes>);

impl Largest {
    /// Ranges that triangles with boxes of more than this share of the whole's area lie in.
    pub(super) fn above(&self, share: f32, extent: &Extent, triangles: usize) -> Vec<Range<usize>> {
        let limit = extent.bounds.half_area() * share;
        let may_be = |size: &Lanes| {
            let s = size.array();
            s[0] * s[1] + s[1] * s[2] + s[2] * s[0] > limit
        };
        let chunks = self.0.iter().enumerate().filter(|(_, size)| may_be(size));
        chunks.map(|(chunk, _)| chunk * CHUNK..((chunk + 1) * CHUNK).min(triangles)).collect()
    }
}

/// References are made, binned and moved in parallel in chunks of this many. Boxes and counts merge exactly and in
/// order, so the result does not depend on threads.
pub(super) const CHUNK: usize = 1 << 14;

/// References to triangles and then to other primitives, which `others` gives the bounds of, with `room` for so
/// many in all. Also tells what contains them, and how large triangles are.
pub(super) fn make_references(
    triangles: &[[Vec3; 3]],
    others: &[Bounds],
    room: usize,
) -> (Vec<Reference>, Extent, Largest) {
    let count = triangles.len() + others.len();
    let mut references: Vec<Reference> = room_for(room.max(count));
    let spare = &mut references.spare_capacity_mut()[..count];
    let (triangle_room, other_room) = spare.split_at_mut(triangles.len());
    let of_triangles = triangle_room
        .par_chunks_mut(CHUNK)
        .zip(triangles.par_chunks(CHUNK))
        .enumerate()
        .map(|(chunk, (room, triangles))| {
            let (mut extent, mut size) = (Extent::empty(), Lanes::splat(0.0));
            let first = (chunk * CHUNK) as u32;
            for ((place, triangle), index) in room.iter_mut().zip(triangles).zip(first..) {
                let reference = Reference::with_box(triangle_box(triangle), index);
                let b = reference.box4();
                extent.add(&reference);
                size = b.high.minus(b.low).max(size);
                place.write(reference);
            }
            (extent, size)
        })
        .collect::<Vec<_>>();
    let mut extent = of_triangles.iter().fold(Extent::empty(), |all, chunk| all.union(chunk.0));
    let largest = Largest(of_triangles.into_iter().map(|chunk| chunk.1).collect());
    for ((place, bounds), index) in other_room.iter_mut().zip(others).zip(triangles.len() as u32..) {
        let reference = Reference::new(bounds, index);
        extent.add(&reference);
        place.write(reference);
    }
    // SAFETY: written places: the two loops have written all `count` references.
    unsafe { references.set_len(count) };
    (references, extent, largest)
}

/// [`PackedTriangle::bounds`] without packing. A triangle without area has the bounds of its first corner there, which these
/// contain.
#[inline(always)]
pub(super) fn triangle_box(triangle: &[Vec3; 3]) -> Box4 {
    let [a, b, c] = triangle.map(|v| Lanes::new(v.x, v.y, v.z, 0.0));
    let bounds = Box4 { low: a.min(b.min(c)), high: a.max(b.max(c)) }.with_slack();
    let size = bounds.high.minus(bounds.low).array();
    if size[0] + size[1] + size[2] < f32::INFINITY {
        return bounds;
    }
    let b = PackedTriangle::new(*triangle, 0).bounds();
    Reference::new(&b, 0).box4()
}
