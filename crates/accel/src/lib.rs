//! Acceleration structures for ray tracing: BVHs of two and of eight children, octree, grid and kd-tree, with parallel
//! builders, SIMD traversals, instances, spheres and refitting.
//!
//! Every structure gives the same hits, bit for bit, whatever the SIMD level and the number of threads: a hit is
//! defined by ray and primitive alone. The README says which structure and builder to take.
//!
//! ```
//! use eosphor_accel::{
//!     BatchTracer, Bvh8, BuildOptions, Coherence, Filters, Hit, Ray, RayFilter, Scene, Tracer, vec3,
//! };
//!
//! // Two triangles, one behind the other.
//! let triangle = |z: f32| [vec3(-1.0, -1.0, z), vec3(1.0, -1.0, z), vec3(0.0, 1.0, z)];
//! let scene = Scene::new(&[triangle(0.0), triangle(-2.0)], &[])?;
//! let bvh = Bvh8::build(&scene.geometry(), &BuildOptions::default());
//! let tracer = bvh.tracer();
//!
//! // One ray.
//! let ray = Ray::new(vec3(0.0, 0.0, 5.0), vec3(0.0, 0.0, -1.0));
//! let hit = tracer.closest_hit(&ray, &RayFilter::ALL);
//! assert_eq!((hit.t, hit.id.primitive), (5.0, 0));
//! assert!(tracer.occluded(&ray, &RayFilter::ALL));
//!
//! // Many rays: faster, and the same hits.
//! let rays = [ray; 64];
//! let mut hits = [Hit::miss(f32::INFINITY); 64];
//! tracer.closest_hits(&rays, Filters::Shared(&RayFilter::ALL), Coherence::Auto, &mut hits);
//! assert_eq!(hits, [hit; 64]);
//! # Ok::<(), eosphor_accel::SceneError>(())
//! ```
//!
//! [`Scene`] makes the [`SceneGeometry`] that everything is built over; a renderer with arrays of its own makes one
//! itself. The structures implement or lend [`Tracer`] (one ray) and [`BatchTracer`] (many). Directions are of unit
//! length. `eosphor-core` has the arithmetic; what its users need of it is exported here.

//!
//! # Safety
//!
//! There is no `unsafe` to use. Traversals follow the numbers in a hierarchy unchecked, so what a hierarchy is made of is checked
//! ([`SceneGeometry::new`]), and nobody else changes it:
//!
//! ```compile_fail,E0451
//! # use eosphor_accel::SceneGeometry;
//! let lies = SceneGeometry { triangles: &[], spheres: &[], geometries: &[], instances: &[], named_geometries: 9 };
//! ```
//!
//! ```compile_fail,E0616
//! # fn of(mut bvh: eosphor_accel::Bvh) {
//! bvh.roots[0] = 500_000_000;
//! # }
//! ```
//!
//! ```compile_fail,E0616
//! # fn of(mut bvh: eosphor_accel::Bvh8) {
//! bvh.blocks.clear();
//! # }
//! ```

mod accepted;
mod batch;
mod bvh;
pub mod bvh8;
mod cells;
mod cost;
mod exhaustive;
#[cfg(feature = "glam")]
mod glam_types;
mod grid;
mod kdtree;
mod mesh;
mod octree;
mod packed;
mod pairs;
#[cfg(feature = "bytemuck")]
mod raw;
mod scene;
mod scene_geometry;
mod simd;
mod simd_level;
mod statistics;
mod structure;
mod wide;

pub use accepted::{closest_hit_where, occluded_where};
pub use batch::{BatchTracer, Coherence, Filters, OneByOne};
pub use bvh::{BuildOptions, Builder, Bvh, Quality, RefitError};
pub use bvh8::{Bvh8, Bvh8Tracer, MaskedTracer};
pub use exhaustive::Exhaustive;
#[cfg(feature = "glam")]
pub use glam_types::{FromGlam, ToGlam};
pub use grid::{Grid, GridOptions};
pub use kdtree::{KdTree, KdTreeOptions};
pub use octree::{Octree, OctreeOptions, Overlap};
pub use packed::PackedPrimitives;
pub use pairs::BvhPairs;
#[cfg(feature = "bytemuck")]
pub use raw::Raw;
pub use scene::{LARGEST_COORDINATE, MeshId, Scene, SceneError, indexed};
pub use scene_geometry::{GeometryError, SceneGeometry};
pub use simd_level::SimdLevel;
pub use statistics::HierarchyStatistics;
pub use structure::{
    Accel, Hierarchy, HierarchyOption, HierarchyOptions, MisfitKind, OptionMisfit, SahCosts, UseBatchTracer,
    UseTracer,
};
pub use wide::BvhWide;

pub use eosphor_core::geometry::{Bounds, Geometry, Instance, Sphere};
pub use eosphor_core::hierarchy::{CountWork, IgnoreWork, ShadowBatch, Tracer, Work};
pub use eosphor_core::math::{Affine, Vec3, vec3};
pub use eosphor_core::ray::{Hit, PrimitiveId, Ray, RayFilter};

/// The examples of the README are tests.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
