//! An order of rays in which neighbours meet the same parts of a hierarchy.

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

#[cfg(test)]
mod tests {
    use super::*;
    use eosphor_core::math::Vec3;

    #[test]
    fn an_order_holds_every_ray_once() {
        let ray = |k: u32| {
            let x = |s: u32| ((k * 7919 + s) % 1013) as f32 / 500.0 - 1.0;
            let origin = Vec3 { x: x(0), y: x(311), z: if k.is_multiple_of(50) { f32::NAN } else { x(523) } };
            Ray { origin, t_min: 0.0, direction: Vec3 { x: x(77), y: x(99), z: x(5) }, t_max: 1.0 }
        };
        let rays: Vec<Ray> = (0..5000).map(ray).collect();
        let mut order = vec![0; rays.len()];
        by_octant(&rays, 10, &mut order);
        assert!(
            order.windows(2).all(|k| octant(&rays[k[0] as usize - 10]) <= octant(&rays[k[1] as usize - 10]))
        );
        order.sort_unstable();
        assert!(order.iter().copied().eq(10..5010));
    }
}
