//! The surface area heuristic between bins (Wald 2007), and exactly for few references.

use super::lanes::{Box4, Lanes};
use super::policy::Policy;
use super::reference::{CHUNK, Extent, Reference};
use super::split::{MOST_RANKED, Rule, Split};
use rayon::prelude::*;

/// Most bins of an axis.
const MOST_BINS: usize = 32;

/// Boxes and counts of all bins of the three axes.
#[derive(Clone)]
pub(super) struct Bins {
    boxes: [[Box4; MOST_BINS]; 3],
    counts: [[u32; MOST_BINS]; 3],
}

/// From twice a centre to its bin.
#[derive(Clone, Copy)]
struct BinMap {
    base: Lanes,
    scale: Lanes,
    last: Lanes,
    count: usize,
}

impl BinMap {
    fn new(centers2: &Box4, references: usize) -> BinMap {
        let count = (4 + references / 4).min(MOST_BINS);
        // A little under the number of bins, so that the largest centre falls into the last one.
        let full = count as f32 * 0.99999;
        let scale = |e: f32| if e > 1e-36 { full / e } else { 0.0 };
        let size = centers2.high.minus(centers2.low).array();
        BinMap {
            base: centers2.low.xyz0(),
            scale: Lanes::new(scale(size[0]), scale(size[1]), scale(size[2]), 0.0),
            last: Lanes::splat((count - 1) as f32),
            count,
        }
    }

    /// Where overflow makes it NaN, it is the last bin.
    #[inline(always)]
    fn bins(&self, center2: Lanes) -> [u32; 4] {
        center2.minus(self.base).times(self.scale).min(self.last).max(Lanes::splat(0.0)).whole()
    }
}

impl Bins {
    pub(super) fn empty() -> Bins {
        Bins { boxes: [[Box4::empty(); MOST_BINS]; 3], counts: [[0; MOST_BINS]; 3] }
    }

    /// Empties the first `count` bins of each axis.
    #[inline(always)]
    fn clear(&mut self, count: usize) {
        for axis in 0..3 {
            self.boxes[axis][..count].fill(Box4::empty());
            self.counts[axis][..count].fill(0);
        }
    }

    #[inline(always)]
    fn fill(&mut self, references: &[Reference], map: &BinMap) {
        for r in references {
            let b = r.box4();
            let places = map.bins(r.center2());
            for axis in 0..3 {
                let k = places[axis] as usize % MOST_BINS;
                let bin = &mut self.boxes[axis][k];
                *bin = bin.union(b);
                self.counts[axis][k] += 1;
            }
        }
    }

    fn merge(&mut self, o: &Bins, map: &BinMap) {
        for axis in 0..3 {
            for k in 0..map.count {
                self.boxes[axis][k] = self.boxes[axis][k].union(o.boxes[axis][k]);
                self.counts[axis][k] += o.counts[axis][k];
            }
        }
    }
}

/// The best split, or `None` where there is none between bins.
pub(super) fn best_split(
    references: &[Reference],
    extent: &Extent,
    policy: &Policy,
    bins: &mut Bins,
) -> Option<Split> {
    let map = BinMap::new(&extent.centers2, references.len());
    bins.clear(map.count);
    if references.len() <= 4 * CHUNK {
        bins.fill(references, &map);
    } else {
        let parts: Vec<Bins> = references
            .par_chunks(CHUNK)
            .map(|chunk| {
                let mut bins = Bins::empty();
                bins.fill(chunk, &map);
                bins
            })
            .collect();
        for part in &parts {
            bins.merge(part, &map);
        }
    }
    let (base, scale) = (map.base.array(), map.scale.array());
    let mut best: Option<Split> = None;
    for axis in 0..3 {
        if scale[axis] == 0.0 {
            continue;
        }
        let (boxes, counts) = (&bins.boxes[axis], &bins.counts[axis]);
        // Cost of all that lies right of each plane.
        let mut right_cost = [0.0f32; MOST_BINS];
        let (mut b, mut count) = (Box4::empty(), 0u32);
        for k in (1..map.count).rev() {
            b = b.union(boxes[k]);
            count += counts[k];
            right_cost[k] = b.half_area() * policy.tests(count);
        }
        let total = references.len() as u32;
        (b, count) = (Box4::empty(), 0);
        for k in 1..map.count {
            b = b.union(boxes[k - 1]);
            count += counts[k - 1];
            // Empty sides have boxes of NaN or infinite area.
            let cost = b.half_area() * policy.tests(count) + right_cost[k];
            if cost < best.map_or(f32::INFINITY, |b| b.cost) && count > 0 && count < total {
                let rule = Rule::Below { axis, base: base[axis], scale: scale[axis], limit: k as f32 };
                best = Some(Split { rule, left_count: count as usize, cost });
            }
        }
    }
    best
}

/// The best split of few references, by all places between two of them on every axis.
pub(super) fn best_of_few(references: &[Reference], policy: &Policy) -> Option<Split> {
    let n = references.len();
    debug_assert!((2..=MOST_RANKED).contains(&n));
    let mut best: Option<Split> = None;
    for axis in 0..3 {
        // Rank by comparing all pairs: no branches to mispredict. Equal ones keep their order.
        let mut ranks = [0u8; MOST_RANKED];
        let mut keys = [0.0f32; MOST_RANKED];
        for (key, r) in keys.iter_mut().zip(references) {
            *key = r.center2_on(axis);
        }
        for i in 1..n {
            for j in 0..i {
                let before = u8::from(keys[i] < keys[j]);
                ranks[j] += before;
                ranks[i] += 1 - before;
            }
        }
        let mut sorted = [Box4::empty(); MOST_RANKED];
        for (r, rank) in references.iter().zip(ranks) {
            sorted[rank as usize % MOST_RANKED] = r.box4();
        }
        let mut right_cost = [0.0f32; MOST_RANKED];
        let mut b = sorted[n - 1];
        right_cost[n - 1] = b.half_area() * policy.tests(1);
        for k in (1..n - 1).rev() {
            b = b.union(sorted[k]);
            right_cost[k] = b.half_area() * policy.tests((n - k) as u32);
        }
        b = Box4::empty();
        for k in 1..n {
            b = b.union(sorted[k - 1]);
            let cost = b.half_area() * policy.tests(k as u32) + right_cost[k];
            if cost < best.map_or(f32::INFINITY, |b| b.cost) {
                best = Some(Split { rule: Rule::Ranks(ranks), left_count: k, cost });
            }
        }
    }
    best
}
