//! The surface area heuristic at every place between two primitives (MacDonald and Booth 1990). Slow, and what the
//! others are measured against.

use super::binned::best_of_few;
use super::lanes::Box4;
use super::policy::Policy;
use super::reference::Reference;
use super::split::{MOST_RANKED, Rule, Split};

/// A number whose order among integers is that of the floats.
fn ordered(x: f32) -> u32 {
    // Zeros of both signs are one place.
    let bits = (x + 0.0).to_bits();
    if bits >> 31 == 1 { !bits } else { bits | 1 << 31 }
}

/// The best split, or `None` where areas are not numbers.
pub(super) fn best_split(references: &[Reference], policy: &Policy) -> Option<Split> {
    let n = references.len();
    if n <= MOST_RANKED {
        return best_of_few(references, policy);
    }
    let mut best: Option<Split> = None;
    let mut right_cost = vec![0.0f32; n];
    // By centre, then by number: the order does not depend on how it is reached.
    let mut sorted: Vec<(u64, u32)> = Vec::with_capacity(n);
    for axis in 0..3 {
        sorted.clear();
        sorted.extend(
            references
                .iter()
                .zip(0..)
                .map(|(r, at)| ((u64::from(ordered(r.center2_on(axis))) << 32) | u64::from(r.index()), at)),
        );
        sorted.sort_unstable();
        let box_at = |k: usize| references[sorted[k].1 as usize].box4();
        let mut b = Box4::empty();
        for k in (1..n).rev() {
            b = b.union(box_at(k));
            right_cost[k] = b.half_area() * policy.tests((n - k) as u32);
        }
        b = Box4::empty();
        for k in 1..n {
            b = b.union(box_at(k - 1));
            let cost = b.half_area() * policy.tests(k as u32) + right_cost[k];
            if cost < best.map_or(f32::INFINITY, |b| b.cost) {
                let last = &references[sorted[k - 1].1 as usize];
                let rule = Rule::UpTo { axis, center2: last.center2_on(axis), index: last.index() };
                best = Some(Split { rule, left_count: k, cost });
            }
        }
    }
    best
}
