//! Blocks that rays of a stream are at, as many at a time as fit into a register: a triangle a lane, of four rays or two.

use super::super::found::{ANY, Found, Query};
use super::super::lanes::{BlockV, Look, StepRays};
use super::super::single_leaf::{Clear, Compare, PrimitiveLeaves};
use super::{Slot, Stream};
use crate::bvh8::{PLACE, TriangleBlock};
use crate::simd::{Float, Mask, Simd, each};
use eosphor_core::ray::{Hit, PrimitiveId, UNKNOWN_REST};
use std::mem::offset_of;

/// The slots of a group, and the blocks that they are at.
struct Group<'a> {
    slots: [*mut Slot<'a>; 4],
    blocks: [*const TriangleBlock; 4],
}

/// Four expressions. (Closures cannot be made to be inlined.)
macro_rules! each_of {
    ($items:expr, |$item:ident| $of:expr) => {
        [
            {
                let $item = $items[0];
                $of
            },
            {
                let $item = $items[1];
                $of
            },
            {
                let $item = $items[2];
                $of
            },
            {
                let $item = $items[3];
                $of
            },
        ]
    };
}

/// Four floats of each block, from this many bytes on.
macro_rules! of_blocks {
    ($group:ident, $offset:expr) => {
        S::fours(each_of!($group.blocks, |block| block.byte_add($offset).cast()))
    };
}

/// Of each ray a field: four floats, or one four times.
macro_rules! of_rays {
    ($group:ident, $function:ident, $($field:tt)+) => {
        S::$function(each_of!($group.slots, |slot| (&raw const (*slot).$($field)+).cast()))
    };
}

/// What the first step says, a triangle a lane.
struct Looks {
    /// What may be hit, what is a certain hit, and what is a clear one that is nearer than what has been found.
    may_meet: u32,
    certain: u32,
    clear: u32,
    nearer: u32,
    /// What is met from behind.
    backs: u32,
}

/// The lanes of a slot.
#[inline(always)]
fn lanes_of(bits: u32, k: usize) -> u32 {
    bits >> (4 * k) & 0xf
}

/// What it says of hits, a triangle a lane.
struct Values {
    t: [f32; 16],
    /// By how much `t` may be wrong.
    error: [f32; 16],
    /// Bounds of `t`.
    low: [f32; 16],
    high: [f32; 16],
    u: [f32; 16],
    v: [f32; 16],
}

impl Values {
    const NONE: Values = Values {
        t: [0.0; 16],
        error: [0.0; 16],
        low: [0.0; 16],
        high: [0.0; 16],
        u: [0.0; 16],
        v: [0.0; 16],
    };
}

/// Those of a slot.
#[inline(always)]
fn values_of(values: &[f32; 16], k: usize) -> [f32; 4] {
    let k = 4 * (k & 3);
    [values[k], values[k + 1], values[k + 2], values[k + 3]]
}

impl<'s, const QUERY: Query> Stream<'_, 's, QUERY> {
    /// Tests the blocks that some slots are at, and goes on to what waits for them. The numbers after the first
    /// `count` are any of slots that are at blocks.
    ///
    /// # Safety
    /// Instruction set: the CPU has it. Closed view: the slots are at blocks of triangles, and in no list.
    #[inline(always)]
    pub(super) unsafe fn test_blocks<S: Simd>(&mut self, numbers: &[u32; 4], count: usize) {
        // SAFETY: instruction set and closed view: promised to this function.
        unsafe {
            let blocks = self.bvh.blocks.as_ptr();
            let slots = each_of!(numbers, |number| self.slot(number));
            let group =
                Group { slots, blocks: each_of!(slots, |slot| blocks.add(((*slot).at & PLACE) as usize)) };
            let mut values = Values::NONE;
            let looks = self.look::<S>(&group, &mut values);
            let mut k = 0;
            while k < count {
                let slot = &mut *group.slots[k];
                let block = &*group.blocks[k];
                let lanes = lanes_of(looks.may_meet, k);
                let mut is_over = false;
                if lanes != 0 {
                    let backs = lanes_of(looks.backs, k);
                    let candidates = if QUERY == ANY { lanes_of(looks.certain, k) & lanes } else { lanes };
                    let lane = candidates.trailing_zeros() as usize & 3;
                    let id = PrimitiveId { instance: 0, primitive: block.primitive[lane] };
                    let is_left_out =
                        slot.filter.skips(id) | (slot.filter.cull_back_faces & (backs >> lane & 1 == 1));
                    let is_alone = lanes & (lanes - 1) == 0;
                    let at = (4 * k + lane) & 15;
                    if QUERY == ANY && (candidates != 0) & !is_left_out {
                        slot.found.any = true;
                        is_over = true;
                    } else if QUERY != ANY && is_alone & (looks.nearer >> at & 1 == 1) {
                        if !is_left_out {
                            let (t, low, high) = (values.t[at], values.low[at], values.high[at]);
                            let hit = Hit { t, t_rest: UNKNOWN_REST, u: values.u[at], v: values.v[at], id };
                            slot.found.take(hit, (slot.at & PLACE) << 2 | lane as u32, low, high);
                        }
                    } else if QUERY == ANY || !(is_alone & (slot.found.best.id == id)) {
                        // (What has been cut is met again.)
                        let hits = if QUERY == ANY {
                            Clear::NONE
                        } else {
                            Clear {
                                bits: lanes_of(looks.clear, k),
                                t: values_of(&values.t, k),
                                error: values_of(&values.error, k),
                                u: values_of(&values.u, k),
                                v: values_of(&values.v, k),
                            }
                        };
                        let (bvh, ray, filter) = (self.bvh, &slot.ray, slot.filter);
                        let leaves = PrimitiveLeaves { bvh, ray, instance: 0, filter };
                        let found: &mut Found = &mut slot.found;
                        let number = slot.at & PLACE;
                        is_over =
                            S::run(Compare::<QUERY> { leaves, number, lanes, hits: &hits, backs, found });
                    }
                }
                self.leave::<S>(slot, numbers[k], is_over);
                k += 1;
            }
        }
    }

    /// The first step, as in [`PrimitiveLeaves`] for one ray.
    ///
    /// # Safety
    /// Instruction set: the CPU has it. Closed view: the slots have rays, and are at these blocks.
    #[inline(always)]
    unsafe fn look<S: Simd>(&self, group: &Group, values: &mut Values) -> Looks {
        // SAFETY: instruction set and closed view: promised to this function.
        unsafe {
            let block = BlockV {
                v0: each!(k => of_blocks!(group, offset_of!(TriangleBlock, v0) + 16 * k)),
                v1: each!(k => of_blocks!(group, offset_of!(TriangleBlock, v1) + 16 * k)),
                v2: each!(k => of_blocks!(group, offset_of!(TriangleBlock, v2) + 16 * k)),
                lengths: of_blocks!(group, offset_of!(TriangleBlock, lengths)),
                product: of_blocks!(group, offset_of!(TriangleBlock, product)),
            };
            let (o, d) = (of_rays!(group, fours, ray.origin), of_rays!(group, fours, ray.direction));
            let origin = [S::lane_of_fours::<0>(o), S::lane_of_fours::<1>(o), S::lane_of_fours::<2>(o)];
            let rays = StepRays {
                direction: [S::lane_of_fours::<0>(d), S::lane_of_fours::<1>(d), S::lane_of_fours::<2>(d)],
                t_min: S::lane_of_fours::<3>(o),
                t_max: of_rays!(group, four_times, ray.t_max),
                length: S::lane_of_fours::<3>(d),
                edge_slack: of_rays!(group, four_times, ray.edge_slack),
                scale: of_rays!(group, four_times, ray.scale),
            };
            let look = Look::new(&rays, &origin, of_rays!(group, four_times, ray.reach), &block);
            let mut looks = Looks {
                may_meet: look.may_meet(&rays, of_rays!(group, four_times, found.end)),
                certain: 0,
                clear: 0,
                nearer: 0,
                backs: look.backs(),
            };
            if QUERY == ANY {
                looks.certain = look.is_certain(&rays);
                return looks;
            }
            let Look { determinant, edges, planes, slack } = &look;
            let clear = planes.is_clear(&rays, edges, *slack, determinant.size);
            let before = of_rays!(group, four_times, found.before);
            looks.clear = clear.bits();
            looks.nearer = clear.and(planes.high.lt(before)).bits();
            planes.t.store(values.t.as_mut_ptr());
            planes.error.store(values.error.as_mut_ptr());
            planes.low.store(values.low.as_mut_ptr());
            planes.high.store(values.high.as_mut_ptr());
            edges.u.mul(planes.inverse).store(values.u.as_mut_ptr());
            edges.v.mul(planes.inverse).store(values.v.as_mut_ptr());
            looks
        }
    }
}
