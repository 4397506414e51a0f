//! One of several parts by its weight, found by running sums and an index into them.
//!
//! Of `count` parts there are `count + 1` sums, from 0 to [`TABLE_UNIT`], and then the index: for each of `count` equal ranges of a
//! number, which part holds the range's first one. Two of these stand in a word, the lower half first. Without the index a search
//! reads as many places as the count has digits, and each may be far away in memory.

/// The last sum.
pub const TABLE_UNIT: u32 = 1 << 24;

/// The number of words for so many parts.
pub fn index_length(count: usize) -> usize {
    count + 1 + count.div_ceil(2)
}

/// A word of the index of these sums, of fewer than 2^16 parts.
pub fn index_word(sums: &[u32], word: usize) -> u32 {
    let count = sums.len() - 1;
    let held = |range: usize| {
        let start = (range as u64 * TABLE_UNIT as u64).div_ceil(count as u64) as u32;
        let after = sums[..count].partition_point(|sum| *sum <= start);
        if range < count { after.saturating_sub(1) as u32 } else { 0 }
    };
    held(2 * word) | (held(2 * word + 1) << 16)
}

/// A place among running sums.
pub(super) struct Pick {
    /// Number of the part.
    pub(super) number: u32,
    /// Place in the part, 0 to 1.
    pub(super) rest: f32,
    /// Its weight.
    pub(super) weight: u32,
}

/// The part of `count` whose sums, from word `first` of the table on, hold `u`; `jitter` is its place between two of the whole
/// numbers. Both are in [0, 1).
#[inline(always)]
pub(super) fn pick(table: &[u32], first: usize, count: u32, u: f32, jitter: f32) -> Pick {
    // By `get`, which has no panic for GPUs.
    let sum = |number: u32| table.get(first + number as usize).copied().unwrap_or(TABLE_UNIT);
    let target = (u * TABLE_UNIT as f32) as u32;
    let range = ((target as u64 * count as u64) / TABLE_UNIT as u64) as u32;
    let held = |range: u32| {
        let at = first + count as usize + 1 + range as usize / 2;
        let word = table.get(at).copied().unwrap_or(0);
        if range.is_multiple_of(2) { word & 0xffff } else { word >> 16 }
    };
    // The last sum that is no larger: the part after it has a weight.
    let (mut low, mut high) = (held(range), if range + 1 < count { held(range + 1) + 1 } else { count });
    while low + 1 < high {
        let middle = (low + high) / 2;
        (low, high) = if sum(middle) <= target { (middle, high) } else { (low, middle) };
    }
    let (from, to) = (sum(low), sum(low + 1));
    let weight = to.wrapping_sub(from);
    Pick { number: low, rest: ((target.wrapping_sub(from)) as f32 + jitter) / weight as f32, weight }
}

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
            table.extend((0..count.div_ceil(2)).map(|word| index_word(&sums, word)));
            assert_eq!(table.len(), 3 + index_length(count));
            for k in 0..20_000u32 {
                let target = if k < 100 { k } else { mix(k) >> 8 };
                let found = pick(&table, 3, count as u32, target as f32 / TABLE_UNIT as f32, 0.5);
                let expected = sums.partition_point(|sum| *sum <= target) as u32 - 1;
                assert_eq!(
                    (found.number, found.weight),
                    (expected, sums[expected as usize + 1] - sums[expected as usize])
                );
                assert!(found.rest > 0.0 && found.rest < 1.0);
            }
        }
    }
}
