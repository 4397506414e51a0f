//! Vertices in the same place.

use eosphor_core::math::Vec3;
use rayon::prelude::*;

/// Numbers positions so that vertices with equal coordinates (compared exactly; -0 is 0) share a number: the number of
/// each vertex's position, and how many positions there are.
pub(crate) fn merge_positions(vertices: &[Vec3]) -> (Vec<u32>, usize) {
    // Adding 0 turns -0 into 0.
    let bits = |p: Vec3| [p.x + 0.0, p.y + 0.0, p.z + 0.0].map(f32::to_bits);
    let mut order: Vec<([u32; 3], u32)> = vertices.iter().zip(0..).map(|(&p, v)| (bits(p), v)).collect();
    order.par_sort_unstable();
    let mut numbers = vec![0; vertices.len()];
    let mut count = 0;
    for (i, &(key, v)) in order.iter().enumerate() {
        if i == 0 || order[i - 1].0 != key {
            count += 1;
        }
        numbers[v as usize] = count as u32 - 1;
    }
    (numbers, count)
}
