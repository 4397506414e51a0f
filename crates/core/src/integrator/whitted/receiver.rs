//! What lights need to know of surface points.

use super::LampLobe;
use crate::math::Vec3;

/// What [`super::LightLanes`] are made of: for each lane the point that a light is sampled at, and which sample.
pub trait Receivers {
    /// Where shadow rays start.
    fn origin(&self, lane: usize) -> Vec3;
    /// Unit normal for shading, on the side that is lit.
    fn normal(&self, lane: usize) -> Vec3;
    /// Unit normal of the surface itself, on the side that is lit.
    fn above(&self, lane: usize) -> Vec3;
    /// Unit vector to the viewer.
    fn to_viewer(&self, lane: usize) -> Vec3;
    /// Exponent of the highlight.
    fn shininess(&self, lane: usize) -> f32;
    /// Whether the light throws a highlight.
    fn highlights(&self, lane: usize) -> bool;
    /// Whether it throws one in any lane.
    fn any_highlights(&self) -> bool;
    /// By what a lamp is reflected.
    fn lobe(&self, lane: usize) -> &LampLobe;
    /// Whether there is a lobe in any lane.
    fn any_lobes(&self) -> bool;
    /// Key of the light's samples.
    fn key(&self, lane: usize) -> u32;
    /// Number of the sample.
    fn index(&self, lane: usize) -> u32;
    /// What weights are multiplied by.
    fn scale(&self) -> f32;
}

/// One side of a surface point, in all lanes; they take samples that follow each other.
#[derive(Clone, Copy, Debug)]
pub struct Receiver {
    /// Where shadow rays start.
    pub origin: Vec3,
    /// Unit normal for shading.
    pub normal: Vec3,
    /// Unit normal of the surface itself.
    pub above: Vec3,
    /// Unit vector to the viewer.
    pub to_viewer: Vec3,
    /// Exponent of the highlight.
    pub shininess: f32,
    /// The light throws a highlight.
    pub highlights: bool,
    /// By what lamps are reflected.
    pub lobe: LampLobe,
    /// Key of the light's samples.
    pub key: u32,
    /// Number of the first lane's sample.
    pub first: u32,
    /// What weights are multiplied by: one over the chance of the light, where it was drawn.
    pub scale: f32,
}

/// Normals of a side are the point's times this.
#[inline(always)]
pub fn side_sign(side: u32) -> f32 {
    if side == 0 { 1.0 } else { -1.0 }
}

/// Where shadow rays start on the side that `above` points to.
#[inline(always)]
pub fn shadow_origin(position: Vec3, above: Vec3, offset: f32) -> Vec3 {
    position.plus_scaled(above, offset)
}

impl Receivers for Receiver {
    #[inline(always)]
    fn origin(&self, _: usize) -> Vec3 {
        self.origin
    }
    #[inline(always)]
    fn normal(&self, _: usize) -> Vec3 {
        self.normal
    }
    #[inline(always)]
    fn above(&self, _: usize) -> Vec3 {
        self.above
    }
    #[inline(always)]
    fn to_viewer(&self, _: usize) -> Vec3 {
        self.to_viewer
    }
    #[inline(always)]
    fn shininess(&self, _: usize) -> f32 {
        self.shininess
    }
    #[inline(always)]
    fn highlights(&self, _: usize) -> bool {
        self.highlights
    }
    #[inline(always)]
    fn any_highlights(&self) -> bool {
        self.highlights
    }
    #[inline(always)]
    fn lobe(&self, _: usize) -> &LampLobe {
        &self.lobe
    }
    #[inline(always)]
    fn any_lobes(&self) -> bool {
        self.lobe.is_there()
    }
    #[inline(always)]
    fn key(&self, _: usize) -> u32 {
        self.key
    }
    #[inline(always)]
    fn index(&self, lane: usize) -> u32 {
        self.first.wrapping_add(lane as u32)
    }
    #[inline(always)]
    fn scale(&self) -> f32 {
        self.scale
    }
}
