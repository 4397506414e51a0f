//! The canonical hit: a function of ray and primitive alone, never of the hierarchy that led to it, and never of what else
//! is in the scene.
//!
//! A triangle is met where the ray's line passes within its edges. Single precision answers where its own rounding errors
//! cannot matter: the ray is *clear* of the edges, of its ends and of the triangle's plane, by bounds that follow from the
//! magnitudes in the test itself. Then `t`, `u` and `v` are those of one formula in one order of operations. What is not
//! clear is decided in double precision, close to the triangle ([`precise`]). Spheres always are.
//!
//! Hits are ordered by their `t` in double precision. For a clear hit single precision has bounds of that, which tell most
//! hits apart; double precision is asked where bounds overlap.
//!
//! Boxes of hierarchies have to let pass every ray that meets what is inside. The slab test is monotone in the planes, and
//! [`BOX_SLACK`], [`ORIGIN_SLACK`] and [`EXTENT_SLACK`] are larger than all rounding. So no hierarchy can cull a hit that
//! counts. A box may be larger than it needs to be: that costs time and changes no hit.

mod first_step;
mod local_ray;
pub mod precise;
mod slab;
mod sphere;
mod triangle;

pub use crate::geometry::BOX_SLACK;
pub use first_step::{FirstStep, Meeting};
pub use local_ray::{
    LARGEST_NUMBER, LocalRay, SHORTEST_DIRECTION, USUAL_LENGTH, USUAL_REACH, WORLD_FROM_OBJECT_ROUNDING,
};
pub use slab::{EXTENT_SLACK, ORIGIN_SLACK, SHORT, SMALLEST_DIRECTION, Slab};
pub use sphere::{SphereHit, intersect_sphere, may_meet_sphere, sphere_bounds};
pub use triangle::{
    PackedTriangle, T_ROUNDING, TriangleHit, intersect_precisely, intersect_triangle, longest_edge_last,
    t_rest,
};

/// Edge functions of single precision are wrong by at most this (8 · 2^-24) times the length of the direction, the distance
/// from the origin to the first vertex with the lengths of the edges, and the lengths of the edges.
///
/// With u = 2^-24, C the first vertex minus the origin, D the direction, E an edge, and sums of absolute coordinates for
/// lengths: C is rounded by u |C|, its cross product with D by 2u |C| |D| more, the product with E by 3u |C| |D| |E|, and E
/// itself by u |E|: 7u in all. The third edge function is the determinant less the other two; its own errors, 8u |E1| |E2|
/// |D|, are what the lengths beside the distance are for.
pub const EDGE_SLACK: f32 = 1.0 / 2_097_152.0;

/// More than underflow can make of edge functions.
pub const UNDERFLOW_SLACK: f32 = 1e-26;

/// The `t` of single precision is wrong by at most this (13 · 2^-24) times the lengths of the edges over the determinant,
/// times the distance from the origin to the first vertex and the distance along the ray, where the determinant is no less
/// than what edge functions may be wrong by.
///
/// The numerator is wrong by 8u of its product of lengths, the determinant by 7u, the quotient by 2u. What edge functions may
/// be wrong by has the lengths of the edges added up and squared,
/// so such a determinant is 32u of its product of lengths at
/// least, and right but for 7/32: 9 / (1 - 7/32) is below 12.
pub const T_SLACK: f32 = 13.0 / 16_777_216.0;

/// Distances from the origin to a triangle count as longer by this (2^-24) times the lengths of its edges and the distance from
/// 0 to the origin. A ray that passes an edge within the tolerance of double precision, 2^-48 of the magnitudes there, meets
/// the edge's closest point, and the plane elsewhere: that far away, over the sine of the angle between them. For hits right
/// at the origin the rounding errors of `t` are less than that; with this, [`T_SLACK`] covers it.
pub const EDGE_REACH: f32 = 1.0 / 16_777_216.0;

/// More than underflow can make of the numerator of `t`. (2^-100: much more, so that over a determinant of 2^26 it is no
/// denormal number yet, which CPUs may take a hundred cycles for.)
pub const T_UNDERFLOW: f32 = 7.888_609e-31;

/// A hit is clear where the bound of the error of `t` is at most this (512 · 2^-24) times the distances from 0 to the origin
/// and from there to the hit. With half of this, double precision would decide about 2.2 instead of 0.8 percent of what a
/// camera in Sponza sees.
pub const T_ERROR: f32 = 1.0 / 32_768.0;

/// And where the bounds of the errors of `u` and `v` are at most this. With a fourth of it, double precision would decide
/// about 4 instead of 0.2 percent of what a camera sees of a million small triangles.
pub const UV_ERROR: f32 = 1.0 / 64.0;
