//! Codes along a Morton curve, sorted, and where to split them.

use super::filled;
use super::lanes::{Box4, Lanes};
use super::reference::CHUNK;
use rayon::prelude::*;

/// Bits of a code on each axis; three times this in all.
const AXIS_BITS: u32 = 10;

/// Sets of at most so many are split so that blocks of four are full: a sixth less memory and a tenth less time, for
/// 4 % more cost.
const FEW: usize = 16;

/// Code and place of a centre: ordered by code, and then as they were.
pub(crate) type Key = u64;

/// Sorted codes of `count` centres, which `center2` gives twice; `centers2` is the box around them.
pub(super) fn sorted(count: usize, centers2: &Box4, center2: impl Fn(usize) -> Lanes + Sync) -> Vec<Key> {
    let size = centers2.high.minus(centers2.low).array();
    let cells = (1 << AXIS_BITS) as f32;
    let scale = |e: f32| if e > 1e-30 { cells * 0.99999 / e } else { 0.0 };
    let (base, scale) =
        (centers2.low.xyz0(), Lanes::new(scale(size[0]), scale(size[1]), scale(size[2]), 0.0));
    let last = Lanes::splat(cells - 1.0);
    let mut keys = filled(0, count);
    keys.par_chunks_mut(CHUNK).enumerate().for_each(|(chunk, keys)| {
        for (key, at) in keys.iter_mut().zip(chunk * CHUNK..) {
            let cell = center2(at).minus(base).times(scale).min(last).max(Lanes::splat(0.0));
            let [x, y, z, _] = cell.spread_whole();
            *key = u64::from(x << 2 | y << 1 | z) << 32 | at as u64;
        }
    });
    sort(&mut keys);
    keys
}

/// Bits that are sorted at once.
const DIGIT: u32 = 10;

/// At most so many keys are sorted by one thread, all digits over all of them: two such arrays lie in its cache.
const FEW_KEYS: usize = 1 << 17;

/// Radix sort, by the highest digit for all and then each of those groups by the two others, lowest first.
fn sort(keys: &mut Vec<Key>) {
    let mut other = filled(0, keys.len());
    let mut starts = [0u32; DIGITS + 1];
    if keys.len() <= FEW_KEYS {
        sort_few(keys, &mut other);
        std::mem::swap(keys, &mut other);
        return;
    }
    scatter(keys, &mut other, 32 + 2 * DIGIT, &mut starts);
    let (mut rest, mut room) = (&mut other[..], &mut keys[..]);
    let mut groups = Vec::new();
    for pair in starts.windows(2).filter(|p| p[1] > p[0]) {
        let size = (pair[1] - pair[0]) as usize;
        let (group, others) = rest.split_at_mut(size);
        let (group_room, other_room) = room.split_at_mut(size);
        (rest, room) = (others, other_room);
        groups.push((group, group_room));
    }
    groups.into_par_iter().for_each(|(group, room)| {
        if group.len() < 256 {
            group.sort_unstable();
        } else {
            let mut starts = [0u32; DIGITS + 1];
            scatter(group, room, 32, &mut starts);
            scatter(room, group, 32 + DIGIT, &mut starts);
        }
    });
    std::mem::swap(keys, &mut other);
}

const DIGITS: usize = 1 << DIGIT;

/// By all three digits, which are counted together; the result is in `other`.
fn sort_few(keys: &mut [Key], other: &mut [Key]) {
    let digit = |key: Key, d: usize| (key >> (32 + d as u32 * DIGIT)) as usize % DIGITS;
    // Neighbours have equal digits, and counting one up must wait for the last time: so two are counted apart.
    let mut counts = [[[0u32; DIGITS]; 3]; 2];
    for pair in keys.chunks(2) {
        for (key, counts) in pair.iter().zip(&mut counts) {
            for d in 0..3 {
                counts[d][digit(*key, d)] += 1;
            }
        }
    }
    let [mut next, more] = counts;
    let (mut from, mut to) = (keys, other);
    for d in 0..3 {
        let mut start = 0;
        for (next, more) in next[d].iter_mut().zip(&more[d]) {
            let count = *next + more;
            *next = start;
            start += count;
        }
        for key in &*from {
            let place = &mut next[d][digit(*key, d)];
            to[*place as usize] = *key;
            *place += 1;
        }
        (from, to) = (to, from);
    }
}

/// Sorts by one digit, keeping the order of equal ones; tells where each digit's keys start, and the end.
fn scatter(from: &[Key], to: &mut [Key], shift: u32, starts: &mut [u32; DIGITS + 1]) {
    starts.fill(0);
    let digit = |key: Key| (key >> shift) as usize % DIGITS;
    for key in from {
        starts[digit(*key) + 1] += 1;
    }
    for d in 0..DIGITS {
        starts[d + 1] += starts[d];
    }
    let mut next = [0u32; DIGITS];
    next.copy_from_slice(&starts[..DIGITS]);
    for key in from {
        let place = &mut next[digit(*key)];
        to[*place as usize] = *key;
        *place += 1;
    }
}

/// Where to split for blocks of so many, so that few keys make full ones, as near to where the code changes as that
/// allows.
#[inline(always)]
pub(super) fn split_for_blocks(keys: &[Key], block: usize) -> usize {
    if keys.len() <= 2 * block {
        return block;
    }
    let place = split(keys);
    if keys.len() > FEW {
        return place;
    }
    let whole = (place + block / 2) / block * block;
    whole.clamp(block, (keys.len() - 1) / block * block)
}

/// Where the highest bit changes that differs among the codes; the middle where none does.
#[inline(always)]
pub(super) fn split(keys: &[Key]) -> usize {
    let (first, last) = ((keys[0] >> 32) as u32, (keys[keys.len() - 1] >> 32) as u32);
    if first == last {
        return keys.len() / 2;
    }
    let bit = 31 - (first ^ last).leading_zeros();
    // All codes share the bits above: those with the bit set come last.
    let limit = u64::from(last >> bit << bit) << 32;
    if keys.len() <= FEW {
        // Counting needs no branches.
        return keys.iter().map(|k| usize::from(*k < limit)).sum();
    }
    keys.partition_point(|k| *k < limit)
}
