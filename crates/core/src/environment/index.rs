//! One of several parts by its weight, found by running sums and an index into them.
//!
//! Of `count` parts there are `count + 1` sums, from 0 to [`TABLE_UNIT`], and then the index: for each of `count` equal ranges of a
//! number, which part holds the range's first one. Two of these stand in a word, the lower half first. Without the index a search
//! reads as many places as the count has digits, and each may be far away in memory.

use crate::memory::prefetch;
use crate::sampling::place_within;

/// The last sum.
pub const TABLE_UNIT: u32 = 1 << 24;

/// The number of words for so many parts.
pub fn index_length(count: usize) -> usize {
    count + 1 + count.div_ceil(2)
}

/// Gives the words of the index of these sums, of fewer than 2^16 parts, to `add`.
pub fn for_index_words(sums: &[u32], mut add: impl FnMut(u32)) {
    let count = sums.len() - 1;
    let mut after = 0;
    let mut held = |range: usize| {
        let start = (range as u64 * TABLE_UNIT as u64).div_ceil(count as u64) as u32;
        while after < count && sums[after] <= start {
            after += 1;
        }
        if range < count { after.saturating_sub(1) as u32 } else { 0 }
    };
    for word in 0..count.div_ceil(2) {
        add(held(2 * word) | (held(2 * word + 1) << 16));
    }
}

/// A place among running sums.
#[derive(Clone, Copy)]
pub(super) struct Pick {
    /// Number of the part.
    pub(super) number: u32,
    /// Place in the part, 0 to 1.
    pub(super) rest: f32,
    /// Its weight.
    pub(super) weight: u32,
}

impl Pick {
    /// None yet.
    pub(super) const NONE: Pick = Pick { number: 0, rest: 0.0, weight: 0 };
}

/// Sums from a word of a table on, and the index into them.
#[derive(Clone, Copy)]
pub(super) struct Sums<'a> {
    pub(super) table: &'a [u32],
    pub(super) first: usize,
    /// The number of parts.
    pub(super) count: u32,
}

impl Sums<'_> {
    /// The part that holds `u`, in [0, 1] of double precision: digits after the first 24 are a place between two of the whole
    /// numbers.
    #[inline(always)]
    pub(super) fn pick(&self, u: f64) -> Pick {
        let (exact, target) = target(u);
        // The last sum that is no larger: the part after it has a weight.
        let (mut low, mut high) = self.held(target);
        while high - low > WINDOW {
            let middle = (low + high) / 2;
            (low, high) = if self.sum(middle) <= target { (middle, high) } else { (low, middle) };
        }
        // Without branches: how many of those that are left is known only when they have come from memory.
        let mut before = 0;
        if let Some(window) = self.window(low) {
            let mut k = 1;
            while k < WINDOW {
                before += u32::from((low + k < high) & (window[k as usize] <= target));
                k += 1;
            }
        } else {
            for k in 1..WINDOW {
                let number = low + k;
                before += u32::from((number < high) & (self.sum(number) <= target));
            }
        }
        let number = low + before;
        let (from, to) = (self.sum(number), self.sum(number + 1));
        let weight = to.wrapping_sub(from);
        Pick { number, rest: place_within((exact - from as f64) / weight as f64), weight }
    }

    /// Tells memory that [`Sums::pick`] will read the index.
    #[inline(always)]
    pub(super) fn prefetch_index(&self, u: f64) {
        prefetch(self.table, self.index_word(self.range(target(u).1)));
    }

    /// Tells memory that it will read sums. The index should have come.
    #[inline(always)]
    pub(super) fn prefetch_sums(&self, u: f64) {
        let (low, _) = self.held(target(u).1);
        prefetch(self.table, self.first + low as usize);
    }

    #[inline(always)]
    fn range(&self, target: u32) -> u32 {
        ((target as u64 * self.count as u64) / TABLE_UNIT as u64) as u32
    }

    /// The word of the index that has a range.
    #[inline(always)]
    fn index_word(&self, range: u32) -> usize {
        self.first + self.count as usize + 1 + range as usize / 2
    }

    /// The first and the last part, the latter not included, that a number may lie in.
    #[inline(always)]
    fn held(&self, target: u32) -> (u32, u32) {
        let range = self.range(target);
        let held = |range: u32| {
            // By `get`, which has no panic for GPUs.
            let word = self.table.get(self.index_word(range)).copied().unwrap_or(0);
            if range.is_multiple_of(2) { word & 0xffff } else { word >> 16 }
        };
        (held(range), if range + 1 < self.count { held(range + 1) + 1 } else { self.count })
    }

    /// Sums from a number on, where there are as many words: one read on CPUs, with registers of as many numbers.
    #[inline(always)]
    fn window(&self, low: u32) -> Option<&[u32; WINDOW as usize]> {
        if cfg!(target_arch = "nvptx64") {
            return None;
        }
        self.table.get(self.first + low as usize..)?.first_chunk()
    }

    #[inline(always)]
    fn sum(&self, number: u32) -> u32 {
        self.table.get(self.first + number as usize).copied().unwrap_or(TABLE_UNIT)
    }
}

/// A number among sums, exact and rounded down.
#[inline(always)]
pub(super) fn target(u: f64) -> (f64, u32) {
    let exact = u * TABLE_UNIT as f64;
    (exact, (exact as u32).min(TABLE_UNIT - 1))
}

/// So many parts are looked at without a search.
const WINDOW: u32 = 8;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampling::mix;

    /// The part that a search through all sums finds.
    #[test]
    fn parts_are_those_of_a_search_without_index() {
        for (count, power) in [(1usize, 0), (2, 0), (7, 1), (100, 3), (1023, 0), (2048, 8)] {
            let weight = |k: u32| (mix(k) >> 8).checked_shr(power * (mix(k + 9) % 3)).unwrap_or(0);
            let weights: Vec<u64> =
                (0..count as u32).map(|k| u64::from(weight(k)) * u64::from(mix(k + 5) % 3)).collect();
            let total: u64 = weights.iter().sum::<u64>().max(1);
            let mut sums = vec![0u32];
            let mut sum = 0u64;
            for weight in &weights {
                sum += weight;
                sums.push((u128::from(sum) * u128::from(TABLE_UNIT) / u128::from(total)) as u32);
            }
            if sum == 0 {
                sums[count] = TABLE_UNIT;
            }
            let mut table = vec![77; 3];
            table.extend(&sums);
            for_index_words(&sums, |word| table.push(word));
            assert_eq!(table.len(), 3 + index_length(count));
            for k in 0..20_000u32 {
                let target = if k < 100 { k } else { mix(k) >> 8 };
                let of_table = Sums { table: &table, first: 3, count: count as u32 };
                let found = of_table.pick((target as f64 + 0.5) / TABLE_UNIT as f64);
                let expected = sums.partition_point(|sum| *sum <= target) as u32 - 1;
                assert_eq!(
                    (found.number, found.weight),
                    (expected, sums[expected as usize + 1] - sums[expected as usize])
                );
                assert!(found.rest >= 0.0 && found.rest < 1.0);
            }
        }
    }
}
