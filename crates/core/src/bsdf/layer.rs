//! A reflecting layer, with what it reflects more than once, and what it lets through.

use super::albedo::{Albedo, MeanAlbedo};
use super::schlick::Schlick;
use crate::math::Vec3;

/// A layer, and what it reflects more than once.
pub(super) struct Layer {
    pub(super) schlick: Schlick,
    pub(super) multiple: Vec3,
}

impl Layer {
    #[inline(always)]
    pub(super) fn new(schlick: Schlick, mean: MeanAlbedo) -> Layer {
        // Of what is lost nowhere, nothing is returned later.
        Layer { multiple: if mean.lost > 0.0 { schlick.multiple(mean) } else { Vec3::ZERO }, schlick }
    }

    #[inline(always)]
    pub(super) fn albedo(&self, albedo: Albedo) -> Vec3 {
        self.schlick.albedo(albedo, self.multiple)
    }

    /// Per channel, the share that is under the layer less what the layer reflects.
    #[inline(always)]
    pub(super) fn lets_through(&self, albedo: Vec3) -> Vec3 {
        (Vec3::splat(self.schlick.share) + -albedo).max(Vec3::ZERO)
    }
}
