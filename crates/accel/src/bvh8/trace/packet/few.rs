//! A block of triangles that few rays of a packet come to: not each triangle beside all sixteen rays, but some rays beside all
//! triangles, four lanes a ray.

use super::{LocalPacket, Query16};
use crate::bvh8::TriangleBlock;
use crate::bvh8::trace::lanes::{BlockV, Look, StepRays};
use crate::simd::{Simd, each};
use eosphor_core::ray::PrimitiveId;

/// At most so many rays of a packet are looked at so.
pub(super) const FEW: u32 = 8;

/// Blocks of a hierarchy that is so large that most leaves have few rays of a packet. (With a million triangles shadow rays are 1.1
/// times as fast; with 1,000 they would be 5 percent slower. Where assertions look for faults, some small ones are large.)
pub(super) const LARGE: usize = if cfg!(debug_assertions) { 40 } else { 150_000 };

/// Bits of the rays that a block hides for certain, and of the others that it may hide, of these. Triangles that are `skipped` hide
/// none.
#[inline(always)]
pub(super) fn hide<S: Simd>(
    query: &Query16<S>,
    leg: &LocalPacket<S>,
    block: &TriangleBlock,
    skipped: u32,
    rays: u32,
    end: &S::F16,
) -> (u32, u32) {
    let block_lanes = BlockV {
        v0: each!(k => S::repeat(&block.v0[k])),
        v1: each!(k => S::repeat(&block.v1[k])),
        v2: each!(k => S::repeat(&block.v2[k])),
        lengths: S::repeat(&block.lengths),
        product: S::repeat(&block.product),
    };
    let (mut hidden, mut unclear) = (0, 0);
    let mut part = 0;
    while part < 16 / S::PART {
        let first = part * S::PART;
        let mut left = rays >> first & (u32::MAX >> (32 - S::PART));
        while left != 0 {
            let rows = S::rows(left);
            macro_rules! pick {
                ($of:expr) => {
                    S::pick(S::part(&$of, part), rows)
                };
            }
            let rays = StepRays {
                direction: each!(k => pick!(leg.own.direction[k])),
                t_min: pick!(leg.local.t_min),
                t_max: pick!(leg.own.t_max),
                length: pick!(leg.local.length),
                edge_slack: pick!(leg.local.edge_slack),
                scale: pick!(leg.local.scale),
            };
            let origin = each!(k => pick!(leg.own.origin[k]));
            let look = Look::new(&rays, &origin, pick!(leg.local.reach), &block_lanes);
            let may_meet = look.may_meet(&rays, pick!(*end));
            let (certain, backs) = (look.is_certain(&rays) & may_meet, look.backs());
            let mut row = 0;
            while row < S::PART / 4 && left != 0 {
                let lane = first + left.trailing_zeros() as usize;
                left &= left - 1;
                let mut hits = certain >> (4 * row) & 0xf & !skipped;
                if query.lane_filters.is_some() {
                    hits = seen::<S>(query, leg.instance, block, lane, hits, backs >> (4 * row) & 0xf);
                }
                hidden |= u32::from(hits != 0) << lane;
                unclear |= u32::from((hits == 0) & (may_meet >> (4 * row) & 0xf & !skipped != 0)) << lane;
                row += 1;
            }
        }
        part += 1;
    }
    (hidden, unclear)
}

/// Those of these triangles that a ray's filter does not leave out.
#[inline(always)]
fn seen<S: Simd>(
    query: &Query16<S>,
    instance: u32,
    block: &TriangleBlock,
    lane: usize,
    mut triangles: u32,
    backs: u32,
) -> u32 {
    let filter = query.filters[lane & 15];
    if filter.cull_back_faces {
        triangles &= !backs;
    }
    let mut left = triangles;
    while left != 0 {
        let triangle = left.trailing_zeros() as usize & 3;
        left &= left - 1;
        let id = PrimitiveId { instance, primitive: block.primitive[triangle] };
        triangles &= !(u32::from(filter.skips(id)) << triangle);
    }
    triangles
}
