//! Vertices in the same place.

use eosphor_core::math::Vec3;
use rayon::prelude::*;

/// Equal for vertices in the same place: their coordinates are compared exactly, and -0 is 0.
pub(crate) fn place_key(p: Vec3) -> [u32; 3] {
    // Adding 0 turns -0 into 0.
    [p.x + 0.0, p.y + 0.0, p.z + 0.0].map(f32::to_bits)
}

/// Numbers the places of vertices in the order in which they come first: the number of each vertex's place, and how many
/// there are.
pub(crate) fn merge_positions(vertices: &[Vec3]) -> (Vec<u32>, usize) {
    // The key and the vertex in one number, which sorts fast.
    let packed = |(v, &p): (usize, &Vec3)| {
        let [x, y, z] = place_key(p).map(u128::from);
        x << 96 | y << 64 | z << 32 | v as u128
    };
    let mut order: Vec<u128> = vertices.par_iter().enumerate().with_min_len(1 << 14).map(packed).collect();
    order.par_sort_unstable();
    // First the lowest vertex of each place, then its number.
    let mut numbers = vec![0; vertices.len()];
    for same in order.chunk_by(|a, b| a >> 32 == b >> 32) {
        same.iter().for_each(|&vertex| numbers[vertex as u32 as usize] = same[0] as u32);
    }
    let mut count = 0;
    for v in 0..numbers.len() {
        if numbers[v] as usize == v {
            numbers[v] = count;
            count += 1;
        } else {
            numbers[v] = numbers[numbers[v] as usize];
        }
    }
    (numbers, count as usize)
}
