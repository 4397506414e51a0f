//! A rough matte base (EON) under a reflecting layer.
//!
//! Of light at a cosine the layer lets `t` through, as it does on its way out. What the base scatters once leaves as
//! `t t' albedo / pi A (1 + r s / t)`, with the model's numbers ([`super::eon`]). Of white light from all sides a viewer gets
//! `t e` of that, where `e = A (mean of t + r (mean of t over what is turned back))`. The rest, `t (1 - e)`, is what base and layer
//! send to each other, and what the rough base scatters more than once: it leaves as the rest of both directions says (Kulla and
//! Conty 2017), so that a white base returns all that gets in.
//!
//! Without a layer that is EON. Without roughness it is Kelemen's and Szirmay-Kalos's coupling, which smooth bases have.

use super::albedo::{MeanAlbedo, TurnedPairs, turned_albedo};
use super::closure::Closure;
use super::eon::{Eon, FULL, MEAN, albedo_again, held_back, once_part, turned_back};
use super::layer::Layer;
use crate::math::{Vec3, clamp, fma, max, vec3};
use core::f32::consts::FRAC_1_PI;

/// What a rough base under a layer scatters to one viewer.
pub(super) struct RoughBase {
    /// Of light that is scattered once: over pi, before `1 + r s / t` and `t` of the light.
    once: Vec3,
    /// Of light that is scattered more often, where the light's [`rest`] is 1.
    again: Vec3,
    /// What the layer holds back of light from all sides: 1 less the mean of `t`.
    held: Vec3,
}

impl RoughBase {
    /// No base.
    pub(super) const NONE: RoughBase = RoughBase { once: Vec3::ZERO, again: Vec3::ZERO, held: Vec3::ZERO };

    /// Of a closure with a layer towards a viewer at a cosine; `through` is what the layer lets through there.
    #[inline(always)]
    pub(super) fn new(
        closure: &Closure,
        layer: &Layer,
        (mean, cos): (MeanAlbedo, f32),
        through: Vec3,
    ) -> RoughBase {
        let share = layer.schlick.share;
        if !(share > 0.0) {
            return RoughBase::NONE;
        }
        let (roughness, scale) = (closure.diffuse_roughness, 1.0 / share);
        let part = once_part(roughness);
        let mean = layer.lets_through(layer.schlick.mean_albedo(mean, layer.multiple)) * scale;
        let held = (Vec3::ONE + -mean).max(Vec3::ZERO);
        let albedo = (closure.diffuse * scale).min(Vec3::ONE);
        let albedo_again = albedo_again(albedo, roughness);
        let rest = rest(closure, layer, held, cos);

        // `t` is linear in what is lost and in Schlick's part of what is reflected.
        let all = Vec3::ONE + layer.schlick.f0 * -scale;
        let lost = (layer.schlick.f0 + -layer.multiple) * scale;
        let grazing = (layer.schlick.f0 + -layer.schlick.f90) * scale;
        let pairs = TurnedPairs::new(closure.alpha);
        let again = vec3(
            again(roughness, [albedo.x, albedo_again.x], mean.x, pairs.means([all.x, lost.x, grazing.x])),
            again(roughness, [albedo.y, albedo_again.y], mean.y, pairs.means([all.y, lost.y, grazing.y])),
            again(roughness, [albedo.z, albedo_again.z], mean.z, pairs.means([all.z, lost.z, grazing.z])),
        );
        let part = part * FRAC_1_PI;
        RoughBase {
            once: closure.diffuse * through * (part * scale * scale),
            again: again * rest * through * (part * scale),
            held,
        }
    }

    /// With no layer over it.
    #[inline(always)]
    pub(super) fn bare(eon: &Eon) -> RoughBase {
        RoughBase { once: eon.once, again: eon.again, held: Vec3::ZERO }
    }

    /// What [`RoughBase::bare`] is made of; `chance` is the probability that a path goes on.
    #[inline(always)]
    pub(super) fn eon(&self, roughness: f32, to_viewer: Vec3, chance: f32) -> Eon {
        Eon { to_viewer, roughness, once: self.once, again: self.again, chance }
    }

    /// The scattering function between two directions above the surface; `through` is what the layer lets through of the light.
    #[inline(always)]
    pub(super) fn eval(
        &self,
        closure: &Closure,
        layer: &Layer,
        [to_viewer, to_light]: [Vec3; 2],
        through: Vec3,
    ) -> Vec3 {
        let turned = max(fma(closure.diffuse_roughness, turned_back(to_viewer, to_light), 1.0), 0.0);
        (self.once * turned + self.again * rest(closure, layer, self.held, to_light.z)) * through
    }
}

/// The colour of what is scattered more often, over the mean of `t (1 - e) / A`. `mean` is that of `t` over all lights, `turned`
/// that over what is turned back, and that of `t t'` there; albedos are those of light that the base scatters once, and more often.
#[inline(always)]
fn again(roughness: f32, [albedo, albedo_again]: [f32; 2], mean: f32, turned: (f32, f32)) -> f32 {
    let (one, both) = turned;
    // Of `t (1 - E) / A`, and of `t (1 - e) / A`.
    let of_base = roughness * max(fma(FULL, mean, -MEAN * one), 0.0);
    let of_both = fma(mean, max(1.0 - mean, 0.0), roughness * max(fma(FULL, mean, -MEAN * both), 0.0));
    if !(of_both > LEAST) {
        return 0.0;
    }
    // What the base alone has kept has its colour more often.
    let share_of_base = clamp(of_base / of_both, 0.0, 1.0);
    fma(albedo_again - albedo, share_of_base, albedo) / of_both
}

/// `(1 - e) / A` at a cosine; `held` is 1 less the mean of `t`.
#[inline(always)]
fn rest(closure: &Closure, layer: &Layer, held: Vec3, cos: f32) -> Vec3 {
    let held_back = held_back(cos);
    let through = layer.lets_through(layer.albedo(turned_albedo(cos, closure.alpha)));
    let turned = through * ((FULL - held_back) / layer.schlick.share);
    held + (Vec3::splat(FULL) + -turned).max(Vec3::ZERO) * closure.diffuse_roughness
}

/// What is scattered more often is left out where it is less than this, or the layer lets next to nothing through.
const LEAST: f32 = 1e-5;
