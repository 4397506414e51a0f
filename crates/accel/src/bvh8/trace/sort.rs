//! Orders of rays in which neighbours meet the same parts of a hierarchy.

use eosphor_core::math::Vec3;
use eosphor_core::ray::Ray;

/// Numbers of rays from `first` on, those of one octant next to each other; otherwise as they come.
#[inline(always)]
pub(super) fn by_octant(rays: &[Ray], first: u32, order: &mut [u32]) {
    let mut starts = [0u32; 9];
    for ray in rays {
        starts[octant(ray) + 1] += 1;
    }
    for k in 0..8 {
        starts[k + 1] += starts[k];
    }
    for (number, ray) in (first..).zip(rays) {
        let place = &mut starts[octant(ray)];
        order[*place as usize] = number;
        *place += 1;
    }
}

#[inline(always)]
fn octant(ray: &Ray) -> usize {
    let negative = |x: f32| (x.to_bits() >> 31) as usize;
    negative(ray.direction.x) | negative(ray.direction.y) << 1 | negative(ray.direction.z) << 2
}

/// Bits of a place along each axis.
const PLACE_BITS: u32 = 5;

/// Numbers of rays from `first` on by the place where they start, on a Morton curve over the box of all origins, and by
/// octant where they start at one place.
pub(super) fn by_place(rays: &[Ray], first: u32) -> Vec<u32> {
    let (mut low, mut high) = (Vec3::splat(f32::INFINITY), Vec3::splat(f32::NEG_INFINITY));
    for ray in rays {
        (low, high) = (low.min(ray.origin), high.max(ray.origin));
    }
    let size = (high - low).max_component();
    // Anything is a place to a number out of range: casts saturate, and NaN is 0.
    let scale = ((1 << PLACE_BITS) - 1) as f32 / if size > 0.0 { size } else { 1.0 };
    let key = |ray: &Ray| {
        let place = (ray.origin - low) * scale;
        let cell = spread(place.x) | spread(place.y) << 1 | spread(place.z) << 2;
        ((cell as usize) << 3) | octant(ray)
    };
    let keys: Vec<u32> = rays.iter().map(|ray| key(ray) as u32).collect();
    let mut starts = vec![0u32; (1 << (3 * PLACE_BITS + 3)) + 1];
    for key in &keys {
        starts[*key as usize + 1] += 1;
    }
    let mut sum = 0;
    for start in &mut starts {
        sum += *start;
        *start = sum;
    }
    let mut order = vec![0; rays.len()];
    for (number, key) in (first..).zip(&keys) {
        let place = &mut starts[*key as usize];
        order[*place as usize] = number;
        *place += 1;
    }
    order
}

/// The lowest bits of a coordinate, three apart.
#[inline(always)]
fn spread(x: f32) -> u32 {
    let x = (x as u32).min((1 << PLACE_BITS) - 1);
    let x = (x | x << 8) & 0x0000_100f;
    let x = (x | x << 4) & 0x0000_10c3;
    (x | x << 2) & 0x0000_1249
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bits_stand_three_apart() {
        for x in 0..32u32 {
            let expected = (0..5).fold(0, |bits, k| bits | (x >> k & 1) << (3 * k));
            assert_eq!(spread(x as f32), expected, "{x}");
        }
        assert_eq!((spread(1e9), spread(-1.0), spread(f32::NAN)), (0x1249, 0, 0));
    }

    #[test]
    fn orders_hold_every_ray_once() {
        let ray = |k: u32| {
            let x = |s: u32| ((k * 7919 + s) % 1013) as f32 / 500.0 - 1.0;
            let origin = Vec3 { x: x(0), y: x(311), z: if k.is_multiple_of(50) { f32::NAN } else { x(523) } };
            Ray { origin, t_min: 0.0, direction: Vec3 { x: x(77), y: x(99), z: x(5) }, t_max: 1.0 }
        };
        let rays: Vec<Ray> = (0..5000).map(ray).collect();
        let mut order = vec![0; rays.len()];
        by_octant(&rays, 10, &mut order);
        for mut order in [order, by_place(&rays, 10)] {
            order.sort_unstable();
            assert!(order.iter().copied().eq(10..5010));
        }
    }
}
