//! Lights, in the form that shading reads.

mod sample;
mod sphere;
mod tree;
mod tree_lanes;
mod tree_top;

pub use sample::{LightSample, LightSampleLanes, TriangleLamp, TriangleLampLanes, triangle_sample};
pub use tree::{ChosenLight, LEAST_CHANCE, LightNode, LightReceiver, LightTree, light_of_primitive};
pub use tree_top::{TopWays, TreeTop};

use crate::math::Vec3;
use crate::ray::PrimitiveId;

/// One light. Emissive triangles are lights each; other emitters are only seen.
///
/// `color` is what a surface's colours are multiplied by: an intensity, irradiance or radiance, over pi where light is
/// physical, since a matte surface of colour rho reflects rho / pi of its irradiance. Whoever makes the light divides, so
/// that shading has one formula, and no factor in it.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(u32)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Light {
    /// Shines from a point in all directions.
    Point {
        /// World space.
        position: Vec3,
        /// Of the intensity; divided by the squared distance where [`crate::settings::Settings::light_falloff`].
        color: Vec3,
    },
    /// Shines from infinitely far.
    Directional {
        /// Unit vector towards the light.
        to_light: Vec3,
        /// Of the irradiance of a surface that faces the light.
        color: Vec3,
    },
    /// A point light with a cone: full inside the inner angle, none outside the outer, smoothstep between.
    Spot {
        /// World space.
        position: Vec3,
        /// Unit vector along the cone's axis, away from the light.
        axis: Vec3,
        /// As for a point light, on the axis.
        color: Vec3,
        /// Cosine of the half angle within which the light is full.
        cos_inner: f32,
        /// Cosine of the half angle outside which there is none; not above `cos_inner`.
        cos_outer: f32,
    },
    /// An emissive triangle, which shines to the side that its normal points to, or to both.
    Triangle {
        /// First vertex, world space.
        v0: Vec3,
        /// Second vertex minus the first.
        e1: Vec3,
        /// Third vertex minus the first.
        e2: Vec3,
        /// Unit normal of the side that shines.
        normal: Vec3,
        /// Area in world units squared.
        area: f32,
        /// Of the radiance, `Ke`.
        color: Vec3,
        /// Number of the texture that multiplies the colour, or [`crate::material::NONE`]: of path tracing.
        texture: u32,
        /// It shines to the other side, too: in path tracing.
        is_two_sided: bool,
        /// Points a shading point samples on it.
        samples: u32,
        /// Number of the instance that holds it (0 = world).
        instance: u32,
        /// Number of the triangle in its geometry.
        primitive: u32,
    },
    /// An emissive sphere, which shines outwards: of path tracing.
    Sphere {
        /// World space.
        center: Vec3,
        /// World units.
        radius: f32,
        /// Of the radiance, `Ke`.
        color: Vec3,
        /// Number of the instance that holds it (0 = world).
        instance: u32,
        /// Number of the sphere in its geometry, where triangles come first.
        primitive: u32,
    },
}

/// What a light is to those who sample it: a new one says it here, and every `match` on it names what it needs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LightKind {
    /// It shines from one point: rays that go on by chance never meet it.
    DeltaPosition,
    /// It shines from one direction, infinitely far.
    DeltaDirection,
    /// It is a surface of the scene that rays can hit. Its light must not be counted twice: by such a hit and by a
    /// light sample. (An area light that rays cannot hit would need a kind of its own.)
    Area,
    /// It surrounds the scene: rays that leave it bring it.
    Infinite,
}

impl Light {
    /// What it is to those who sample it.
    #[inline(always)]
    pub fn kind(&self) -> LightKind {
        match self {
            Light::Point { .. } | Light::Spot { .. } => LightKind::DeltaPosition,
            Light::Directional { .. } => LightKind::DeltaDirection,
            Light::Triangle { .. } | Light::Sphere { .. } => LightKind::Area,
        }
    }

    /// Whether it has an area, so that rays of lobes meet it, too.
    #[inline(always)]
    pub fn is_lamp(&self) -> bool {
        match self.kind() {
            LightKind::DeltaPosition | LightKind::DeltaDirection | LightKind::Infinite => false,
            LightKind::Area => true,
        }
    }

    /// The primitive that it is. Shadow rays towards a triangle leave it out.
    #[inline(always)]
    pub fn primitive(&self) -> PrimitiveId {
        match *self {
            Light::Triangle { instance, primitive, .. } | Light::Sphere { instance, primitive, .. } => {
                PrimitiveId { instance, primitive }
            }
            Light::Point { .. } | Light::Directional { .. } | Light::Spot { .. } => PrimitiveId::NONE,
        }
    }

    /// Shadow rays that a shading point sends to this light.
    #[inline(always)]
    pub fn samples(&self) -> u32 {
        match self {
            Light::Triangle { samples, .. } => *samples,
            Light::Point { .. } | Light::Directional { .. } | Light::Spot { .. } | Light::Sphere { .. } => 1,
        }
    }
}
