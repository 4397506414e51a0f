//! The best plane to cut primitives at.

use super::clip::{self, PART_SLACK, Slices};
use super::lanes::{Box4, Lanes};
use super::policy::Policy;
use super::reference::{CHUNK, Extent, Reference};
use eosphor_core::math::Vec3;
use rayon::prelude::*;

/// Slices of an axis.
const SLICES: usize = 16;

/// A plane that cuts.
#[derive(Clone, Copy)]
pub(super) struct Cut {
    pub(super) slices: Slices,
    /// The plane's number.
    pub(super) plane: usize,
    pub(super) cost: f32,
    /// Boxes and counts of both sides with all parts.
    pub(super) sides: [Box4; 2],
    pub(super) counts: [u32; 2],
}

/// Boxes and counts of the parts in all slices of the three axes.
#[derive(Clone)]
pub(super) struct SliceBins {
    boxes: [[Box4; SLICES]; 3],
    /// References that begin in a slice, and that end in it.
    begin: [[u32; SLICES]; 3],
    end: [[u32; SLICES]; 3],
}

/// What looks for planes.
pub(super) struct Cutter<'a> {
    pub(super) policy: &'a Policy,
    pub(super) triangles: &'a [[Vec3; 3]],
}

impl Cutter<'_> {
    /// The plane of least cost that takes no more than `spare` more references.
    pub(super) fn best(
        &self,
        references: &[Reference],
        extent: &Extent,
        spare: usize,
        bins: &mut SliceBins,
    ) -> Option<Cut> {
        let (low, high) = (extent.bounds.low.array(), extent.bounds.high.array());
        let slices: [Slices; 3] = std::array::from_fn(|axis| {
            let size = high[axis] - low[axis];
            // Sides too short for parts with their margins are not cut.
            let margin = PART_SLACK * low[axis].abs().max(high[axis].abs());
            let scale = SLICES as f32 / size;
            // Of a size next to 0 it is infinite, and slices would not be numbers.
            let is_cut = size > 4.0 * margin && size < f32::MAX && scale < f32::INFINITY;
            let scale = if is_cut { scale } else { 0.0 };
            Slices { axis, base: low[axis], scale, width: size / SLICES as f32 }
        });
        bins.clear();
        if references.len() <= 4 * CHUNK {
            self.fill(references, &slices, bins);
        } else {
            let parts: Vec<SliceBins> = references
                .par_chunks(CHUNK)
                .map(|chunk| {
                    let mut bins = SliceBins::empty();
                    self.fill(chunk, &slices, &mut bins);
                    bins
                })
                .collect();
            parts.iter().for_each(|part| bins.merge(part));
        }
        let (count, policy) = (references.len() as u32, self.policy);
        let mut best: Option<Cut> = None;
        for axis in (0..3).filter(|&a| slices[a].scale > 0.0) {
            let boxes = &bins.boxes[axis];
            let mut above = [(Box4::empty(), 0u32); SLICES];
            let (mut b, mut ends) = (Box4::empty(), 0);
            for k in (1..SLICES).rev() {
                b = b.union(boxes[k]);
                ends += bins.end[axis][k];
                above[k] = (b, ends);
            }
            let (mut b, mut begins) = (Box4::empty(), 0);
            for k in 1..SLICES {
                b = b.union(boxes[k - 1]);
                begins += bins.begin[axis][k - 1];
                let (right, ends) = above[k];
                let cost = b.half_area() * policy.tests(begins) + right.half_area() * policy.tests(ends);
                // Both sides must be smaller than the whole, or there would be no end.
                let parts = (1..count).contains(&begins) && (1..count).contains(&ends);
                if parts
                    && begins + ends <= count + spare as u32
                    && cost < best.map_or(f32::INFINITY, |c| c.cost)
                {
                    let (sides, counts) = ([b, right], [begins, ends]);
                    best = Some(Cut { slices: slices[axis], plane: k, cost, sides, counts });
                }
            }
        }
        best
    }

    fn fill(&self, references: &[Reference], slices: &[Slices; 3], bins: &mut SliceBins) {
        let pick = |f: fn(&Slices) -> f32| Lanes::new(f(&slices[0]), f(&slices[1]), f(&slices[2]), 0.0);
        let (base, scale) = (pick(|s| s.base), pick(|s| s.scale));
        let last = Lanes::splat((SLICES - 1) as f32);
        let slice = |x: Lanes| x.minus(base).times(scale).min(last).max(Lanes::splat(0.0)).whole();
        for r in references {
            let b = r.box4();
            let margin = Lanes::splat(clip::margin_of(r, self.triangles));
            // What reaches into a slice by less than the margin is not cut there.
            let (first, last) = (slice(b.low.xyz0().plus(margin)), slice(b.high.xyz0().minus(margin)));
            for axis in 0..3 {
                let (first, last) = (first[axis] as usize % SLICES, last[axis] as usize % SLICES);
                // Thin ones are seen inside out.
                let first = first.min(last);
                bins.begin[axis][first] += 1;
                bins.end[axis][last] += 1;
                let boxes = &mut bins.boxes[axis];
                match self.triangles.get(r.index() as usize) {
                    Some(triangle) if first != last => {
                        slices[axis].chop(triangle, r, (first, last), boxes);
                    }
                    _ => (first..=last).for_each(|k| boxes[k % SLICES] = boxes[k % SLICES].union(b)),
                }
            }
        }
    }
}

impl SliceBins {
    pub(super) fn empty() -> SliceBins {
        SliceBins { boxes: [[Box4::empty(); SLICES]; 3], begin: [[0; SLICES]; 3], end: [[0; SLICES]; 3] }
    }

    fn clear(&mut self) {
        *self = SliceBins::empty();
    }

    fn merge(&mut self, o: &SliceBins) {
        for axis in 0..3 {
            for k in 0..SLICES {
                self.boxes[axis][k] = self.boxes[axis][k].union(o.boxes[axis][k]);
                self.begin[axis][k] += o.begin[axis][k];
                self.end[axis][k] += o.end[axis][k];
            }
        }
    }
}
