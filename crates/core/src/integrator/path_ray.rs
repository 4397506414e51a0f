//! A ray on its way, with what the pixel gives for what it finds.

use crate::math::Vec3;
use crate::ray::{PrimitiveId, Ray, RayFilter};
use crate::settings::Settings;

/// Kinds of rays, for statistics.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u32)]
pub enum RayKind {
    /// From the camera.
    Camera,
    /// Mirrored.
    Reflected,
    /// Through a surface.
    Refracted,
    /// One of a glossy lobe.
    Glossy,
}

/// A ray with its place in the tree of a sample.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct PathRay {
    /// Where it starts, world space.
    pub origin: Vec3,
    /// Hash of the branches taken from the camera: keys its random numbers. Of paths, more of what `inside` has.
    pub path: u32,
    /// Unit vector.
    pub direction: Vec3,
    /// Bounces so far; 0 for camera rays.
    pub depth: u32,
    /// What it finds is multiplied by this.
    pub weight: Vec3,
    /// Kind.
    pub kind: RayKind,
    /// The triangle it starts on.
    pub start: PrimitiveId,
    /// Bodies it runs inside of, where back faces are what there is to see: surfaces entered less surfaces left. Of paths, which
    /// bodies (`path/media.rs`).
    pub inside: u32,
    /// Holes it has come through since it last left a surface.
    pub holes: u32,
    /// How far it had come when it passed the last of them.
    pub travelled: f32,
    /// Of a lobe that lamps are sampled by as well: how densely all its rays sample this direction, per steradian; else 0.
    pub lobe_density: f32,
}

impl PathRay {
    /// The ray for a query.
    #[inline(always)]
    pub fn ray(&self) -> Ray {
        Ray { origin: self.origin, t_min: 0.0, direction: self.direction, t_max: f32::INFINITY }
    }

    /// What its query leaves out.
    #[inline(always)]
    pub fn filter(&self, settings: &Settings) -> RayFilter {
        RayFilter {
            start: self.start,
            target: PrimitiveId::NONE,
            cull_back_faces: settings.cull_back_faces & (self.inside == 0),
        }
    }
}
