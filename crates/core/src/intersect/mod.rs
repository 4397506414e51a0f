//! The canonical hit: a function of ray and primitive alone, never of the hierarchy that led to it.
//!
//! A hit counts when (a) the one intersection formula accepts it, (b) the ray passes the primitive's own padded bounds
//! no later than the hit, under the one slab function, and (c) the point on the ray and the point on the primitive
//! agree within a tolerance that follows from the scene's extent. Every node box contains those bounds and is tested
//! by the same slab function, which is monotone in the planes: so no hierarchy can cull a hit that counts. For
//! triangles (b) follows from (a) and (c), also for the bounds of a part of it that holds the point: so they may be cut.

/// Cosine of the angle between ray and normal from which on single precision is trusted (times the sine of the angle at
/// the triangle's first corner).
pub const STEEP: f32 = 1.0 / 32.0;

/// Determinants below this, 2^-90, may have lost bits at the end of the range of numbers.
pub const SMALLEST_DETERMINANT: f32 = 1.0 / (1u128 << 90) as f32;

mod first_look;
mod local_ray;
mod slab;
mod sphere;
mod triangle;

pub use first_look::{EDGE_SLACK, FirstLook, Meeting, T_SLACK, USUAL_LENGTH, USUAL_REACH};
pub use local_ray::{LARGEST_NUMBER, LocalRay, SHORTEST_DIRECTION};
pub use slab::{SLAB_SLACK, SMALLEST_DIRECTION, Slab};
pub(crate) use sphere::decide_sphere;
pub use sphere::{intersect_sphere, sphere_bounds};
pub use triangle::{Confirmed, EdgeTest, PackedTriangle, intersect_triangle, longest_edge_last};
pub(crate) use triangle::{decide_triangle, intersect_triangle_unless};

/// Bounds of primitives are padded by this times the extent of their geometry: over the rounding errors of the slab
/// test (2^-24 of the coordinates) and the tolerance of hits ([`HIT_TOLERANCE`]).
pub const PADDING: f32 = 1.0 / 131_072.0;

/// A hit's point on the ray and on the primitive may differ by this times the extent of the geometry.
pub const HIT_TOLERANCE: f32 = 1.0 / 262_144.0;

/// Triangles are tested as if their edges lay further out by this times the extent of geometry and ray, which covers
/// the rounding of the edge functions: rays aimed at a shared edge hit at least one of its triangles.
pub const EDGE_TOLERANCE: f32 = 1.0 / 2_097_152.0;
