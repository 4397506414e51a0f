//! Where to put the plane: the surface area heuristic (MacDonald and Booth 1990), over all sides of the primitives'
//! boxes where there are few (Wald and Havran 2006, "On building fast kd-trees for ray tracing, and on doing that in
//! O(N log N)"), and over equally spaced planes where there are many (Shevtsov et al. 2007).

use super::KdTreeOptions;
use crate::cells::Item;
use eosphor_core::geometry::Bounds;
use rayon::prelude::*;

/// Nodes with more items than this are binned.
const EXACT_ITEMS: usize = 1024;
const BINS: usize = 128;
/// Nodes with more items than this are binned in parallel, in chunks of this size. Counts add up exactly, so chunks do
/// not change the result.
const PARALLEL_CHUNK: usize = 1 << 14;

/// A plane between two cells.
#[derive(Clone, Copy, Debug)]
pub(super) struct Split {
    pub(super) axis: usize,
    pub(super) plane: f32,
    /// Expected cost of a ray through the node, in primitive tests.
    pub(super) cost: f32,
}

/// Both parts of a cell.
pub(super) fn cut(bounds: &Bounds, axis: usize, plane: f32) -> (Bounds, Bounds) {
    let (mut lower, mut upper) = (*bounds, *bounds);
    let (low, high) = match axis {
        0 => (&mut upper.min.x, &mut lower.max.x),
        1 => (&mut upper.min.y, &mut lower.max.y),
        _ => (&mut upper.min.z, &mut lower.max.z),
    };
    (*low, *high) = (plane, plane);
    (lower, upper)
}

/// The cheapest plane strictly inside the cell, or `None` where there is none to choose.
pub(super) fn best_split(items: &[Item], bounds: &Bounds, options: &KdTreeOptions) -> Option<Split> {
    let mut search = Search { bounds, options, best: None };
    if items.len() <= EXACT_ITEMS {
        search.exact(items);
    } else {
        search.binned(items);
    }
    search.best
}

struct Search<'a> {
    bounds: &'a Bounds,
    options: &'a KdTreeOptions,
    best: Option<Split>,
}

impl Search<'_> {
    fn offer(&mut self, axis: usize, plane: f32, below: usize, above: usize) {
        if !(plane > self.bounds.min[axis] && plane < self.bounds.max[axis]) {
            return;
        }
        let (lower, upper) = cut(self.bounds, axis, plane);
        let tests = lower.half_area() * below as f32 + upper.half_area() * above as f32;
        let discount = if below == 0 || above == 0 { 1.0 - self.options.empty_bonus } else { 1.0 };
        let cost = self.options.traversal_cost + discount * tests / self.bounds.half_area();
        if self.best.is_none_or(|b| cost < b.cost) {
            self.best = Some(Split { axis, plane, cost });
        }
    }

    /// All sides of boxes.
    fn exact(&mut self, items: &[Item]) {
        let (mut starts, mut ends) = (Vec::with_capacity(items.len()), Vec::with_capacity(items.len()));
        for axis in 0..3 {
            starts.clear();
            ends.clear();
            starts.extend(items.iter().map(|item| item.bounds.min[axis]));
            ends.extend(items.iter().map(|item| item.bounds.max[axis]));
            starts.sort_unstable_by(f32::total_cmp);
            ends.sort_unstable_by(f32::total_cmp);
            let (mut started, mut ended) = (0, 0);
            while started < starts.len() || ended < ends.len() {
                let plane = match (starts.get(started), ends.get(ended)) {
                    (Some(&s), Some(&e)) => s.min(e),
                    (Some(&s), None) => s,
                    (None, Some(&e)) => e,
                    (None, None) => break,
                };
                // Those that start at the plane are above it, those that end there below.
                let below = started;
                while starts.get(started).is_some_and(|&s| s <= plane) {
                    started += 1;
                }
                while ends.get(ended).is_some_and(|&e| e <= plane) {
                    ended += 1;
                }
                self.offer(axis, plane, below, items.len() - ended);
            }
        }
    }

    /// Equally spaced planes.
    fn binned(&mut self, items: &[Item]) {
        let (low, size) = (self.bounds.min, self.bounds.max - self.bounds.min);
        let bin = |x: f32, axis: usize| (((x - low[axis]) / size[axis] * BINS as f32) as usize).min(BINS - 1);
        let count = |chunk: &[Item]| {
            let mut counts = Counts { starts: [[0; BINS]; 3], ends: [[0; BINS]; 3] };
            for item in chunk {
                for axis in 0..3 {
                    counts.starts[axis][bin(item.bounds.min[axis], axis)] += 1;
                    counts.ends[axis][bin(item.bounds.max[axis], axis)] += 1;
                }
            }
            counts
        };
        let counts = if items.len() <= PARALLEL_CHUNK {
            count(items)
        } else {
            let parts: Vec<Counts> = items.par_chunks(PARALLEL_CHUNK).map(count).collect();
            parts.into_iter().reduce(Counts::plus).expect("there are items")
        };
        for axis in 0..3 {
            let (mut below, mut above) = (0, items.len());
            for k in 1..BINS {
                below += counts.starts[axis][k - 1];
                above -= counts.ends[axis][k - 1];
                self.offer(axis, low[axis] + size[axis] * (k as f32 / BINS as f32), below, above);
            }
        }
    }
}

/// How many boxes start and end in each bin.
struct Counts {
    starts: [[usize; BINS]; 3],
    ends: [[usize; BINS]; 3],
}

impl Counts {
    fn plus(mut self, o: Counts) -> Counts {
        for (sums, more) in [(&mut self.starts, &o.starts), (&mut self.ends, &o.ends)] {
            for (sum, n) in sums.iter_mut().flatten().zip(more.iter().flatten()) {
                *sum += n;
            }
        }
        self
    }
}
