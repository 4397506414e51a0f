//! Where to split: the surface area heuristic over bins (Wald 2007, "On fast construction of SAH-based bounding volume
//! hierarchies").

use super::build::Item;
use eosphor_core::geometry::Bounds;
use eosphor_core::math::Vec3;
use rayon::prelude::*;

pub(super) const BINS: usize = 32;

/// Nodes with more items than this are binned in parallel, in chunks of this size. Boxes and counts merge exactly, so
/// chunks do not change the result.
const PARALLEL_CHUNK: usize = 1 << 15;

/// A plane between two bins.
#[derive(Clone, Copy, Debug)]
pub(super) struct Split {
    pub(super) axis: usize,
    /// Items in bins below this go left.
    pub(super) bin: usize,
    /// Sum over both sides of half area times items.
    pub(super) cost: f32,
    pub(super) bins: BinMap,
}

/// From a centroid to its bin.
#[derive(Clone, Copy, Debug)]
pub(super) struct BinMap {
    low: Vec3,
    scale: Vec3,
}

impl BinMap {
    fn new(centroids: &Bounds) -> BinMap {
        let size = centroids.max - centroids.min;
        // A little under BINS, so that the largest centroid falls into the last bin.
        let scale = |s: f32| if s > 0.0 { (BINS as f32 * 0.99999) / s } else { 0.0 };
        BinMap { low: centroids.min, scale: Vec3 { x: scale(size.x), y: scale(size.y), z: scale(size.z) } }
    }

    pub(super) fn bin(&self, centroid: Vec3, axis: usize) -> usize {
        (((centroid[axis] - self.low[axis]) * self.scale[axis]) as usize).min(BINS - 1)
    }
}

#[derive(Clone, Copy)]
struct Bin {
    bounds: Bounds,
    count: u32,
}

type Bins = [[Bin; BINS]; 3];

const NO_BINS: Bins = [[Bin { bounds: Bounds::EMPTY, count: 0 }; BINS]; 3];

/// Box of the items and box of their centroids.
pub(super) fn bounds_of(items: &[Item]) -> (Bounds, Bounds) {
    let serial = |chunk: &[Item]| {
        chunk.iter().fold((Bounds::EMPTY, Bounds::EMPTY), |(all, centroids), item| {
            (all.union(&item.bounds), centroids.including(item.bounds.center()))
        })
    };
    if items.len() <= PARALLEL_CHUNK {
        return serial(items);
    }
    items
        .par_chunks(PARALLEL_CHUNK)
        .map(serial)
        .reduce(|| (Bounds::EMPTY, Bounds::EMPTY), |a, b| (a.0.union(&b.0), a.1.union(&b.1)))
}

/// The best split by bins, or `None` where all centroids are one point.
pub(super) fn best_split(items: &[Item], centroids: &Bounds) -> Option<Split> {
    let map = BinMap::new(centroids);
    let bins = fill(items, &map);
    let mut best: Option<Split> = None;
    for (axis, bins) in bins.iter().enumerate() {
        // Cost of all that lies right of each plane.
        let mut right_cost = [0.0f32; BINS];
        let (mut bounds, mut count) = (Bounds::EMPTY, 0u32);
        for k in (1..BINS).rev() {
            bounds = bounds.union(&bins[k].bounds);
            count += bins[k].count;
            right_cost[k] = bounds.half_area() * count as f32;
        }
        let total = count + bins[0].count;
        (bounds, count) = (Bounds::EMPTY, 0);
        for k in 1..BINS {
            bounds = bounds.union(&bins[k - 1].bounds);
            count += bins[k - 1].count;
            if count == 0 || count == total {
                continue;
            }
            let cost = bounds.half_area() * count as f32 + right_cost[k];
            if best.is_none_or(|b| cost < b.cost) {
                best = Some(Split { axis, bin: k, cost, bins: map });
            }
        }
    }
    best
}

fn fill(items: &[Item], map: &BinMap) -> Bins {
    let serial = |chunk: &[Item]| {
        let mut bins = NO_BINS;
        for item in chunk {
            let centroid = item.bounds.center();
            for (axis, bins) in bins.iter_mut().enumerate() {
                let bin = &mut bins[map.bin(centroid, axis)];
                bin.bounds = bin.bounds.union(&item.bounds);
                bin.count += 1;
            }
        }
        bins
    };
    if items.len() <= PARALLEL_CHUNK {
        return serial(items);
    }
    items.par_chunks(PARALLEL_CHUNK).map(serial).reduce(
        || NO_BINS,
        |mut a, b| {
            for (x, y) in a.iter_mut().flatten().zip(b.iter().flatten()) {
                x.bounds = x.bounds.union(&y.bounds);
                x.count += y.count;
            }
            a
        },
    )
}
