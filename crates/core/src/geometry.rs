//! Geometry as devices read it: ranges of primitives, instances, and what shading needs of each primitive.
//!
//! A *geometry* is a set of triangles and spheres in one space. Geometry 0 is the world; others are placed by
//! instances and traced in their own space. A primitive's number is its place in its geometry: triangles first, then
//! spheres. Instance 0 is the world itself.

use crate::math::{Affine, Vec3, vec3};
use crate::out_of_line::on_cpus;

on_cpus! {
    /// Unit normals at the corners of a triangle that a map has placed, from those in its own space; `flat`
    /// where one has no length.
    pub fn placed_normals(object_from_world: &Affine, normals: &[Vec3; 3], flat: Vec3) -> [Vec3; 3] {
        let mut placed = *normals;
        for normal in &mut placed {
            *normal = object_from_world.transposed_direction(*normal).normalize_or(flat);
        }
        placed
    }
}

/// Planes of boxes lie further out by this (8 · 2^-24) times their own distance from 0: over the rounding errors that they
/// bring into the test, 2 · 2^-24 ([`Bounds::with_slack`]).
pub const BOX_SLACK: f32 = 1.0 / 2_097_152.0;

/// An axis-aligned box.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Bounds {
    /// Smallest coordinates.
    pub min: Vec3,
    /// Largest coordinates.
    pub max: Vec3,
}

impl Bounds {
    /// The box that holds nothing.
    pub const EMPTY: Bounds = Bounds { min: Vec3::splat(f32::INFINITY), max: Vec3::splat(f32::NEG_INFINITY) };

    /// The smallest box around both.
    #[inline(always)]
    pub fn union(&self, o: &Bounds) -> Bounds {
        Bounds { min: self.min.min(o.min), max: self.max.max(o.max) }
    }

    /// The smallest box around this one and a point.
    #[inline(always)]
    pub fn including(&self, p: Vec3) -> Bounds {
        Bounds { min: self.min.min(p), max: self.max.max(p) }
    }

    /// Grown by `margin` on every side.
    #[inline(always)]
    pub fn padded(&self, margin: f32) -> Bounds {
        let m = Vec3::splat(margin);
        Bounds { min: self.min - m, max: self.max + m }
    }

    /// Grown by [`BOX_SLACK`] of each plane's distance from 0, as boxes have to be that rays are tested
    /// against.
    #[inline(always)]
    pub fn with_slack(&self) -> Bounds {
        let (low, high) = (self.min.abs() * BOX_SLACK, self.max.abs() * BOX_SLACK);
        Bounds { min: self.min - low, max: self.max + high }
    }

    /// Half the surface area; 0 for the empty box.
    #[inline(always)]
    pub fn half_area(&self) -> f32 {
        let s = self.max - self.min;
        if s.x < 0.0 { 0.0 } else { s.x * s.y + s.y * s.z + s.z * s.x }
    }

    /// The middle.
    #[inline(always)]
    pub fn center(&self) -> Vec3 {
        (self.min + self.max) * 0.5
    }

    /// Whether nothing is inside.
    #[inline(always)]
    pub fn is_empty(&self) -> bool {
        self.min.x > self.max.x
    }

    /// The box around the images of all eight corners.
    pub fn transformed(&self, map: &Affine) -> Bounds {
        if self.is_empty() {
            return Bounds::EMPTY;
        }
        (0..8).fold(Bounds::EMPTY, |b, corner| {
            let pick = |bit: u32, low: f32, high: f32| if corner & bit == 0 { low } else { high };
            b.including(map.point(vec3(
                pick(1, self.min.x, self.max.x),
                pick(2, self.min.y, self.max.y),
                pick(4, self.min.z, self.max.z),
            )))
        })
    }

    /// The world box of an instance of what is in this box ([`Instance::world_bounds`]): that of the eight corners, and all
    /// points that the inverse map takes into the box. Both maps are rounded, so neither is quite the inverse of the other;
    /// that moves points by 2^-24 of what the two make of absolute numbers one after the other, and the box is grown by 16
    /// times that.
    pub fn placed(&self, world_from_object: &Affine, object_from_world: &Affine) -> Bounds {
        const SHARE: f32 = 1.0 / 1_048_576.0;
        let world = self.transformed(world_from_object);
        if world.is_empty() {
            return world;
        }
        let (back, forth) = (object_from_world.abs(), world_from_object.abs());
        let farthest = world.min.abs().max(world.max.abs());
        let own = self.min.abs().max(self.max.abs());
        let moved = forth.direction(back.point(farthest)) + forth.point(own) + farthest;
        let margin = moved * SHARE;
        Bounds { min: world.min - margin, max: world.max + margin }
    }

    /// The largest absolute coordinate; 0 for the empty box.
    #[inline(always)]
    pub fn extent(&self) -> f32 {
        if self.is_empty() { 0.0 } else { self.min.abs().max(self.max.abs()).max_component() }
    }
}

/// A sphere.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C, align(16))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Sphere {
    /// Centre.
    pub center: Vec3,
    /// Radius, over 0.
    pub radius: f32,
}

/// A range of triangles and a range of spheres in one space.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Geometry {
    /// Number of its first triangle among all.
    pub first_triangle: u32,
    /// How many it has.
    pub triangle_count: u32,
    /// Number of its first sphere among all.
    pub first_sphere: u32,
    /// How many it has.
    pub sphere_count: u32,
    /// The largest absolute coordinate in it. Traversals may take it for the scale of rounding errors; no hit depends on
    /// it.
    pub extent: f32,
    /// Number of the object that its first sphere is; the others follow.
    pub first_sphere_object: u32,
}

/// A placed geometry.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Instance {
    /// Takes rays into the geometry's space.
    pub object_from_world: Affine,
    /// Takes hits back.
    pub world_from_object: Affine,
    /// Its box in world space, grown for the rounding of both maps.
    pub world_bounds: Bounds,
    /// Number of the geometry.
    pub geometry: u32,
    /// Number of the material of all its primitives, or [`crate::material::NONE`]: each has its own.
    pub material: u32,
    /// Number of the object that it is.
    pub object: u32,
}

/// What shading needs of a triangle.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct TriangleShading {
    /// Unit shading normals at the corners, in the geometry's space.
    pub normals: [Vec3; 3],
    /// Texture coordinates at the corners.
    pub uvs: [[f32; 2]; 3],
    /// Number of the material.
    pub material: u32,
    /// Number of its [`TriangleExtra`], or [`crate::material::NONE`].
    pub extra: u32,
    /// Of triangles of the world, the number of the object that they are part of.
    pub object: u32,
}

/// What few triangles have.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct TriangleExtra {
    /// Linear R, G, B and alpha at the corners, which multiply the material's.
    pub colors: [[f32; 4]; 3],
    /// Second texture coordinates at the corners.
    pub uvs1: [[f32; 2]; 3],
}
