//! Where the lights of a node are divided.

use super::emitter::Emitter;
use super::sums::Sums;

/// Parts along an axis in which splits are looked for.
const BINS: usize = 12;
/// Deeper nodes are divided in the middle of their lights.
const DEPTH_OF_SPLITS: u32 = 48;

/// The box around the places of lights.
#[derive(Clone, Copy)]
struct Extent {
    min: [f64; 3],
    max: [f64; 3],
}

impl Extent {
    fn of(lights: &[Emitter]) -> Extent {
        let each = |pick: fn(f64, f64) -> f64, start: f64| {
            [0, 1, 2].map(|axis| lights.iter().map(|light| light.place[axis]).fold(start, pick))
        };
        Extent { min: each(f64::min, f64::INFINITY), max: each(f64::max, f64::NEG_INFINITY) }
    }

    fn length(&self, axis: usize) -> f64 {
        self.max[axis] - self.min[axis]
    }

    /// The part along an axis in which a light lies.
    fn bin(&self, light: &Emitter, axis: usize) -> usize {
        let place = (light.place[axis] - self.min[axis]) / self.length(axis);
        ((place * BINS as f64) as usize).min(BINS - 1)
    }
}

/// Sorts lights into those of the first child, which come first, and the others. Returns how many the first has: at least one, as
/// the second.
pub(super) fn split(lights: &mut [Emitter], depth: u32) -> usize {
    let half = lights.len() / 2;
    if depth >= DEPTH_OF_SPLITS || lights.len() == 2 {
        return half;
    }
    let extent = Extent::of(lights);
    let longest = (0..3).map(|axis| extent.length(axis)).fold(0.0, f64::max);
    let mut best: Option<(f64, usize, usize)> = None;
    for axis in (0..3).filter(|&axis| extent.length(axis) > 0.0) {
        let mut bins = [Sums::EMPTY; BINS];
        for light in lights.iter() {
            let bin = &mut bins[extent.bin(light, axis)];
            *bin = bin.and(&Sums::of_one(light, extent.min));
        }
        let mut after = [Sums::EMPTY; BINS];
        for k in (0..BINS - 1).rev() {
            after[k] = after[k + 1].and(&bins[k + 1]);
        }
        let mut before = Sums::EMPTY;
        for k in 0..BINS - 1 {
            before = before.and(&bins[k]);
            if before.count == 0 || after[k].count == 0 {
                continue;
            }
            // Splits across a short side leave long nodes.
            let cost = (before.cost() + after[k].cost()) * (longest / extent.length(axis));
            if best.is_none_or(|(least, ..)| cost < least) {
                best = Some((cost, axis, k));
            }
        }
    }
    let Some((_, axis, last)) = best else { return half };
    let is_second = |light: &Emitter| extent.bin(light, axis) > last;
    lights.sort_by_key(is_second);
    lights.partition_point(|light| !is_second(light))
}
