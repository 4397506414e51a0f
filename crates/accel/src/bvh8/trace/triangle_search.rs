//! Where the triangle is that a hit names.

use crate::bvh8::view::Bvh8View;
use crate::bvh8::{EMPTY, INSTANCE, LEAF, PLACE, SPHERE};
use eosphor_core::geometry::Bounds;
use eosphor_core::hierarchy::{FarRay, is_far};
use eosphor_core::intersect::{LocalRay, Slab, intersect_triangle};
use eosphor_core::math::vec3;
use eosphor_core::ray::{Hit, Ray};

/// The place of the triangle that the ray meets at the hit's `t`, as `Found::place` has it. Looks along the whole ray, box by
/// box: seldom asked for, and not worth vectors.
pub(super) fn find_triangle(bvh: &Bvh8View, ray: &Ray, hit: &Hit) -> Option<u32> {
    let number = hit.id.instance as usize;
    let instance = bvh.instances.get(number)?;
    let map = (number != 0).then_some(&instance.object_from_world);
    let geometry = instance.geometry as usize;
    let extent = bvh.geometries[geometry].extent;
    let mut local = match map {
        None => LocalRay::new(ray, extent),
        Some(map) => LocalRay::mapped(ray, map, extent),
    };
    if local.t_min.is_nan() {
        return None;
    }
    let bounds = &bvh.bounds[geometry];
    if is_far(local.origin, bounds.extent()) {
        local = FarRay::new(ray, map, bounds)?.ray;
    }
    let mut waiting = vec![if number == 0 { bvh.world_root } else { bvh.roots[geometry] }];
    while let Some(child) = waiting.pop() {
        if (child == EMPTY) | (child & LEAF != 0 && child & (SPHERE | INSTANCE) != 0) {
            continue;
        }
        if child & LEAF == 0 {
            let node = &bvh.nodes[child as usize];
            let [x0, x1, y0, y1, z0, z1] = &node.planes;
            for (k, &child) in node.children.iter().enumerate() {
                let bounds = Bounds { min: vec3(x0[k], y0[k], z0[k]), max: vec3(x1[k], y1[k], z1[k]) };
                let (near, far) = local.slab.interval(&bounds, local.t_min);
                if child != EMPTY && Slab::passes(near, far, f32::INFINITY) {
                    waiting.push(child);
                }
            }
            continue;
        }
        let block = &bvh.blocks[(child & PLACE) as usize];
        for lane in 0..4 {
            if block.primitive[lane] == hit.id.primitive
                && intersect_triangle(&block.get(lane), ray, map, extent).t == hit.t
            {
                return Some((child & PLACE) << 2 | lane as u32);
            }
        }
    }
    None
}
