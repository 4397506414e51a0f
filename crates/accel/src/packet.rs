//! Shadow rays from one point, many at a time.
//!
//! Rays from a surface point to the samples of one light go nearly the same way, so they share the walk through the tree.
//! Everything a lane computes is `core`'s own code, called in a loop over lanes that compiles to SIMD; a lane's answer is
//! the scalar one, bit for bit.

use eosphor_core::hierarchy::{BvhNode, BvhTracer, MAX_BVH_DEPTH, ShadowBatch, Stack, Tracer, Work};
use eosphor_core::intersect::{LocalRay, PackedTriangle, Slab};
use eosphor_core::math::vec3;
use eosphor_core::ray::{Hit, PrimitiveId, Ray, RayFilter};

/// A [`BvhTracer`] that traces shadow rays in packets.
#[derive(Clone, Copy, Debug)]
pub struct PacketTracer<'a, C> {
    /// Answers everything else.
    pub scalar: BvhTracer<'a, C>,
}

/// A batch with what the tests need of each lane.
struct Packet<const W: usize> {
    shared: LocalRay,
    direction: [[f32; W]; 3],
    inverse: [[f32; W]; 3],
    near_offset: [[f32; W]; 3],
    far_offset: [[f32; W]; 3],
    inverse_direction_squared: [f32; W],
    edge_tolerance: [f32; W],
    t_max: [f32; W],
}

impl<const W: usize> Packet<W> {
    #[inline(always)]
    fn new(batch: &ShadowBatch<W>, extent: f32) -> Packet<W> {
        let mut packet = Packet {
            shared: LocalRay::new(batch.origin, vec3(0.0, 0.0, 1.0), 0.0, extent),
            direction: [batch.x, batch.y, batch.z],
            inverse: [[0.0; W]; 3],
            near_offset: [[0.0; W]; 3],
            far_offset: [[0.0; W]; 3],
            inverse_direction_squared: [0.0; W],
            edge_tolerance: [0.0; W],
            t_max: batch.t_max,
        };
        for lane in 0..W {
            let d = vec3(batch.x[lane], batch.y[lane], batch.z[lane]);
            let ray = LocalRay::new(batch.origin, d, 0.0, extent);
            packet.inverse[0][lane] = ray.slab.inverse.x;
            packet.inverse[1][lane] = ray.slab.inverse.y;
            packet.inverse[2][lane] = ray.slab.inverse.z;
            packet.near_offset[0][lane] = ray.slab.near_offset.x;
            packet.far_offset[0][lane] = ray.slab.far_offset.x;
            packet.near_offset[1][lane] = ray.slab.near_offset.y;
            packet.far_offset[1][lane] = ray.slab.far_offset.y;
            packet.near_offset[2][lane] = ray.slab.near_offset.z;
            packet.far_offset[2][lane] = ray.slab.far_offset.z;
            packet.inverse_direction_squared[lane] = ray.inverse_direction_squared;
            packet.edge_tolerance[lane] = ray.edge_tolerance;
            // A ray with numbers out of range hits nothing.
            if ray.t_min.is_nan() {
                packet.t_max[lane] = f32::NAN;
            }
        }
        packet
    }

    #[inline(always)]
    fn slab(&self, lane: usize) -> Slab {
        let pick = |v: &[[f32; W]; 3]| vec3(v[0][lane], v[1][lane], v[2][lane]);
        Slab {
            inverse: pick(&self.inverse),
            near_offset: pick(&self.near_offset),
            far_offset: pick(&self.far_offset),
        }
    }

    /// One lane's ray.
    #[inline(always)]
    fn lane(&self, lane: usize) -> LocalRay {
        let pick = |v: &[[f32; W]; 3]| vec3(v[0][lane], v[1][lane], v[2][lane]);
        LocalRay {
            direction: pick(&self.direction),
            slab: self.slab(lane),
            inverse_direction_squared: self.inverse_direction_squared[lane],
            edge_tolerance: self.edge_tolerance[lane],
            ..self.shared
        }
    }

    /// Whether any lane that is still searching enters the box.
    #[inline(always)]
    fn enters(&self, node: &BvhNode, searching: &[u32; W]) -> bool {
        let bounds = node.bounds();
        let mut any = 0;
        for lane in 0..W {
            let (near, far) = self.slab(lane).interval(&bounds, 0.0);
            any |= Slab::passes(near, far, self.t_max[lane]) as u32 & searching[lane];
        }
        any != 0
    }

    /// Takes the lanes that the triangle hides out of the search.
    #[inline(always)]
    fn hide_behind(&self, triangle: &PackedTriangle, cull_back_faces: bool, searching: &mut [u32; W]) {
        let normal = triangle.normal();
        let (mut candidate, mut determinant, mut clear) = ([0u32; W], [0.0; W], [0u32; W]);
        let mut any = 0;
        for lane in 0..W {
            let edges = triangle.test_edges(&self.lane(lane), normal, cull_back_faces);
            determinant[lane] = edges.determinant;
            candidate[lane] = edges.candidate as u32 & searching[lane];
            clear[lane] = edges.clear as u32;
            any |= candidate[lane];
        }
        if any == 0 {
            return;
        }
        let mut unsure = 0;
        for lane in 0..W {
            let hit = triangle.confirm(&self.lane(lane), normal, determinant[lane]);
            let hides = (hit.counts & (hit.t <= self.t_max[lane])) as u32 & candidate[lane];
            candidate[lane] = hides;
            searching[lane] &= !(hides & clear[lane]);
            unsure |= hides & !clear[lane];
        }
        if unsure & 1 != 0 {
            for lane in 0..W {
                if candidate[lane] & !clear[lane] & 1 != 0 {
                    let ray = self.lane(lane);
                    let hides = triangle.holds_in_double(ray.origin, ray.direction) as u32;
                    searching[lane] &= !hides;
                }
            }
        }
    }
}

impl<C: Work> PacketTracer<'_, C> {
    #[inline(always)]
    fn occluded_in_world<const W: usize>(
        &self,
        batch: &ShadowBatch<W>,
        filter: &RayFilter,
        searching: &mut [u32; W],
    ) {
        let view = &self.scalar.bvh;
        let primitives = &view.primitives;
        let packet = Packet::new(batch, primitives.geometries[0].extent);
        let mut room = Stack::<u32, MAX_BVH_DEPTH>::room();
        let mut stack = Stack::new(&mut room);
        let mut node = &view.nodes[view.roots[0] as usize];
        loop {
            if node.is_inner() {
                let first = node.first as usize;
                let (left, right) = (&view.nodes[first], &view.nodes[first + 1]);
                self.scalar.work.nodes(2);
                let enters_left = packet.enters(left, searching);
                let enters_right = packet.enters(right, searching);
                if enters_left {
                    if enters_right {
                        // SAFETY: a walk puts aside one node a level, and builders keep trees below
                        // MAX_BVH_DEPTH levels.
                        unsafe { stack.push(first as u32 + 1) };
                    }
                    node = left;
                    continue;
                } else if enters_right {
                    node = right;
                    continue;
                }
            } else {
                let count = node.count & !BvhNode::SPHERES;
                self.scalar.work.primitives(count);
                if node.count & BvhNode::SPHERES == 0 {
                    for triangle in &primitives.triangles[node.first as usize..][..count as usize] {
                        let id = PrimitiveId { instance: 0, primitive: triangle.primitive };
                        if !filter.skips(id) {
                            packet.hide_behind(triangle, filter.cull_back_faces, searching);
                        }
                    }
                } else {
                    for sphere in &primitives.spheres[node.first as usize..][..count as usize] {
                        for lane in 0..W {
                            let [t0, t1] =
                                eosphor_core::intersect::intersect_sphere(&packet.lane(lane), sphere);
                            let t_max = packet.t_max[lane];
                            searching[lane] &= !(((t0 <= t_max) | (t1 <= t_max)) as u32);
                        }
                    }
                }
                if searching.iter().fold(0, |any, s| any | s) == 0 {
                    return;
                }
            }
            match stack.pop() {
                Some(index) => node = &view.nodes[index as usize],
                None => return,
            }
        }
    }
}

impl<C: Work> Tracer for PacketTracer<'_, C> {
    #[inline(always)]
    fn closest_hit(&self, ray: &Ray, filter: &RayFilter) -> Hit {
        self.scalar.closest_hit(ray, filter)
    }

    #[inline(always)]
    fn occluded(&self, ray: &Ray, filter: &RayFilter) -> bool {
        self.scalar.occluded(ray, filter)
    }

    #[inline(always)]
    fn next_hit(&self, ray: &Ray, filter: &RayFilter, after: &Hit) -> Hit {
        self.scalar.next_hit(ray, filter, after)
    }

    #[inline(always)]
    fn occluded_batch<const W: usize>(
        &self,
        batch: &ShadowBatch<W>,
        filter: &RayFilter,
        active: &[bool; W],
    ) -> [bool; W] {
        let mut searching = active.map(|a| a as u32);
        self.occluded_in_world(batch, filter, &mut searching);
        if self.scalar.bvh.primitives.instances.len() > 1 {
            for lane in 0..W {
                if searching[lane] != 0 && self.scalar.occluded_by_instances(&batch.ray(lane), filter) {
                    searching[lane] = 0;
                }
            }
        }
        searching.map(|s| s == 0)
    }
}
