//! Rough matte surfaces: EON (Portsmouth, Kutz and Hill 2025, "EON: a practical energy-preserving rough diffuse BRDF", Journal of
//! Computer Graphics Techniques 14 (1)).
//!
//! Directions are unit vectors in the frame of the surface: z is its normal, on the viewer's side. With the roughness `r` light is
//! scattered once as by Fujii's form of Oren and Nayar's model, `albedo / pi A (1 + r s / t)`, where `A = 1 / (1 + FULL r)`. Of
//! white light this returns `E(cos) = A (1 + r G(cos) / pi)`; the rest is scattered again and leaves as `1 - E` of both directions
//! says, so that a white surface returns all light. With roughness 0 this is Lambert's surface.

use super::closure::Scattered;
use crate::math::elementary::atan2;
use crate::math::{Vec3, fma, max, min, sqrt};
use crate::sampling::{cosine_direction, hemisphere_direction};
use core::f32::consts::FRAC_1_PI;

/// `G / pi` at the horizon, where it is most: `1/2 - 2 / (3 pi)`.
pub(super) const FULL: f32 = 0.287_793_4;
/// Its mean over the hemisphere, weighted by the cosine: `2/3 - 28 / (15 pi)`.
pub(super) const MEAN: f32 = 0.072_488_21;

/// A rough matte base with nothing over it, towards one viewer.
#[derive(Clone, Copy, Debug)]
pub struct Eon {
    /// The viewer.
    pub to_viewer: Vec3,
    /// Roughness, 0 to 1.
    pub roughness: f32,
    /// Albedo over pi, of light that is scattered once, before `1 + r s / t`.
    pub once: Vec3,
    /// Of light that is scattered more often, where the light's `FULL - G / pi` is 1.
    pub again: Vec3,
    /// The probability that a path goes on: 1, or 0 where the surface is black.
    pub chance: f32,
}

impl Eon {
    /// Of an albedo, 0 to 1.
    #[inline(always)]
    pub fn new(albedo: Vec3, roughness: f32, to_viewer: Vec3) -> Eon {
        let part = once_part(roughness);
        // (1 - E) (1 - E') / (1 - mean of E), without the differences of numbers close to 1 and each other.
        let again = part * roughness * (held_back(to_viewer.z) * (FRAC_1_PI / (FULL - MEAN)));
        Eon {
            to_viewer,
            roughness,
            once: albedo * (FRAC_1_PI * part),
            again: albedo_again(albedo, roughness) * again,
            chance: if albedo.max_component() > 0.0 { 1.0 } else { 0.0 },
        }
    }

    /// Light from a direction above the surface.
    #[inline(always)]
    pub fn eval(&self, to_light: Vec3) -> Scattered {
        let cos = to_light.z;
        let turned_back = fma(self.roughness, turned_back(self.to_viewer, to_light), 1.0);
        let value = (self.once * max(turned_back, 0.0)).plus_scaled(self.again, held_back(cos));
        Scattered { value: value * cos, pdf: self.pdf(to_light) }
    }

    /// A direction above the surface for a point of the unit square.
    #[inline(always)]
    pub fn sample(&self, u: [f32; 2]) -> Vec3 {
        let even = even_part(self.roughness, self.to_viewer.z);
        if u[0] < even {
            return hemisphere_direction([min(u[0] / even, LAST_NUMBER), u[1]]);
        }
        cosine_direction([min((u[0] - even) / (1.0 - even), LAST_NUMBER), u[1]])
    }

    /// How densely [`Eon::sample`] gives a direction above the surface, per steradian.
    #[inline(always)]
    pub fn pdf(&self, to_light: Vec3) -> f32 {
        let even = even_part(self.roughness, self.to_viewer.z);
        FRAC_1_PI * self.chance * fma(1.0 - even, to_light.z, 0.5 * even)
    }
}

/// The largest number below 1.
const LAST_NUMBER: f32 = 1.0 - 1.0 / 16_777_216.0;

/// The part of samples that are spread evenly over the hemisphere. The others are as dense as the cosine: to a viewer near the
/// horizon a rough surface shines as much with light from near the horizon, where these are rare and would weigh much.
#[inline(always)]
pub(super) fn even_part(roughness: f32, cos: f32) -> f32 {
    0.5 * roughness * max(1.0 - cos, 0.0)
}

/// The model's `A`.
#[inline(always)]
pub(super) fn once_part(roughness: f32) -> f32 {
    1.0 / fma(FULL, roughness, 1.0)
}

/// `s / t`: how much more a rough surface scatters once in this pair of directions than a smooth one. Above 0 on the viewer's side.
#[inline(always)]
pub(super) fn turned_back(to_viewer: Vec3, to_light: Vec3) -> f32 {
    let s = fma(to_viewer.x, to_light.x, to_viewer.y * to_light.y);
    if s > 0.0 { s / max(to_viewer.z, to_light.z) } else { s }
}

/// `FULL - G(cos) / pi`: 0 at the horizon.
#[inline(always)]
pub(super) fn held_back(cos: f32) -> f32 {
    let sine = sqrt(max((1.0 - cos) * (1.0 + cos), 0.0));
    // The paper's ((1 - sine^3) / cos), which has no digits near the horizon, is cos (1 + sine + sine^2) / (1 + sine).
    let rest = cos * (fma(sine, sine, 1.0 + sine) / (1.0 + sine)) - 1.0;
    let g = sine * fma(-sine, cos, fma(rest, 2.0 / 3.0, atan2(sine, cos)));
    max(fma(g, -FRAC_1_PI, FULL), 0.0)
}

/// Albedo of what is scattered more than once.
#[inline(always)]
pub(super) fn albedo_again(albedo: Vec3, roughness: f32) -> Vec3 {
    let part = once_part(roughness);
    let mean = part * fma(MEAN, roughness, 1.0);
    let lost = part * roughness * (FULL - MEAN);
    let of = |albedo: f32| albedo * albedo * mean / (1.0 - albedo * lost);
    Vec3 { x: of(albedo.x), y: of(albedo.y), z: of(albedo.z) }
}

#[cfg(test)]
mod tests {
    use super::super::Matte;
    use super::*;
    use crate::math::vec3;
    use crate::sampling::{mix, sobol_2d};
    use core::f64::consts::PI;

    const ROUGHNESSES: [f32; 4] = [0.0, 0.25, 0.5, 1.0];
    const COSINES: [f32; 5] = [0.02, 0.2, 0.5, 0.8, 1.0];

    fn random(i: u32) -> f32 {
        (mix(i) >> 8) as f32 * (1.0 / 16_777_216.0)
    }

    fn at(cos: f32, turn: f32) -> Vec3 {
        let (sine, (s, c)) = (sqrt((1.0 - cos) * (1.0 + cos)), turn.sin_cos());
        vec3(sine * c, sine * s, cos)
    }

    fn any_direction(i: u32) -> Vec3 {
        at(random(2 * i).max(1e-3), std::f32::consts::TAU * random(2 * i + 1))
    }

    /// The directional albedo of Fujii's model, as the paper's listing has it ("exact").
    fn paper_albedo(mu: f64, r: f64) -> f64 {
        let a = 1.0 / (1.0 + (0.5 - 2.0 / (3.0 * PI)) * r);
        let si = (1.0 - mu * mu).sqrt();
        let g = si * (mu.acos() - si * mu) + (2.0 / 3.0) * ((si / mu) * (1.0 - si * si * si) - si);
        a + (r * a / PI) * g
    }

    /// The paper's scattering function of one channel in double precision.
    fn paper(rho: f64, r: f64, wi: [f64; 3], wo: [f64; 3]) -> f64 {
        let (mu_i, mu_o) = (wi[2], wo[2]);
        let s = wi[0] * wo[0] + wi[1] * wo[1] + wi[2] * wo[2] - mu_i * mu_o;
        let s_over_t = if s > 0.0 { s / mu_i.max(mu_o) } else { s };
        let a = 1.0 / (1.0 + (0.5 - 2.0 / (3.0 * PI)) * r);
        let once = (rho / PI) * a * (1.0 + r * s_over_t);
        let (of_o, of_i) = (paper_albedo(mu_o, r), paper_albedo(mu_i, r));
        let mean = a * (1.0 + (2.0 / 3.0 - 28.0 / (15.0 * PI)) * r);
        let rho_again = (rho * rho) * mean / (1.0 - rho * (1.0 - mean));
        let floor = 1e-7f64;
        once + (rho_again / PI) * (1.0 - of_o).max(floor) * (1.0 - of_i).max(floor) / (1.0 - mean).max(floor)
    }

    #[test]
    fn values_are_the_papers() {
        let mut worst = 0.0f64;
        for i in 0..20_000 {
            let roughness = [0.05, 0.3, 0.7, 1.0][i as usize % 4];
            let albedo = vec3(random(9 * i + 1), 1.0, 0.5 * random(9 * i + 2));
            let (a, b) = (any_direction(2 * i), any_direction(2 * i + 1));
            let wide = |d: Vec3| <[f32; 3]>::from(d).map(f64::from);
            let got = wide(Eon::new(albedo, roughness, a).eval(b).value);
            for (got, albedo) in got.into_iter().zip(wide(albedo)) {
                let want = paper(albedo, roughness.into(), wide(b), wide(a)) * f64::from(b.z);
                // Where both directions are opposite and near the horizon, nothing is scattered once.
                worst = worst.max((got - want).abs() / (want + 1e-2 * f64::from(b.z)));
            }
        }
        println!("off by {worst:e} at most");
        assert!(worst < 2e-5, "{worst:e}");
    }

    /// By the rule of the middle in both the cosine, with short steps near the horizon, and the turn about the normal.
    fn albedo(albedo: Vec3, roughness: f32, cos: f32) -> f64 {
        const STEPS: [usize; 2] = [1500, 60];
        let eon = Eon::new(albedo, roughness, at(cos, 0.3));
        let mut sum = 0.0;
        for i in 0..STEPS[0] {
            let s = (i as f64 + 0.5) / STEPS[0] as f64;
            for j in 0..STEPS[1] {
                // Half a turn is like the other.
                let turn = PI * (j as f64 + 0.5) / STEPS[1] as f64;
                let value = eon.eval(at((s * s) as f32, 0.3 + turn as f32)).value.x;
                sum += f64::from(value) * 2.0 * s * 2.0 * PI;
            }
        }
        sum / (STEPS[0] * STEPS[1]) as f64
    }

    #[test]
    fn white_returns_all_light_and_colours_what_the_paper_says() {
        for roughness in ROUGHNESSES {
            for cos in COSINES {
                let white = albedo(Vec3::ONE, roughness, cos);
                assert!((white - 1.0).abs() < 3e-4, "roughness {roughness}, cosine {cos}: {white}");
                let (r, rho) = (f64::from(roughness), 0.5);
                let mean =
                    (1.0 + (2.0 / 3.0 - 28.0 / (15.0 * PI)) * r) / (1.0 + (0.5 - 2.0 / (3.0 * PI)) * r);
                let again = rho * rho * mean / (1.0 - rho * (1.0 - mean));
                let once = paper_albedo(cos.into(), r);
                let (got, want) =
                    (albedo(Vec3::splat(0.5), roughness, cos), rho * once + again * (1.0 - once));
                assert!((got - want).abs() < 3e-4, "roughness {roughness}, cosine {cos}: {got} {want}");
            }
        }
    }

    #[test]
    fn both_ways_are_alike() {
        let albedo = vec3(0.9, 0.4, 0.1);
        for i in 0..20_000 {
            let (a, b) = (any_direction(2 * i), any_direction(2 * i + 1));
            let roughness = random(7 * i);
            let there = Eon::new(albedo, roughness, a).eval(b).value * (1.0 / b.z);
            let back = Eon::new(albedo, roughness, b).eval(a).value * (1.0 / a.z);
            assert!((there + -back).abs().max_component() <= 1e-5 * there.max_component(), "{a:?} {b:?}");
        }
    }

    #[test]
    fn without_roughness_it_is_lamberts_to_the_bit() {
        let albedo = vec3(0.8, 0.3, 0.0);
        for i in 0..2000 {
            let to_light = any_direction(i);
            let (eon, matte) = (Eon::new(albedo, 0.0, any_direction(i + 5000)), Matte::new(albedo));
            let (eon, matte) = (eon.eval(to_light), matte.eval(to_light.z));
            assert_eq!((eon.value, eon.pdf), (matte.value, matte.pdf));
        }
    }

    /// Means of functions over samples are integrals over the hemisphere of the function times the density.
    #[test]
    fn samples_are_as_dense_as_is_said() {
        const COUNT: u32 = 1 << 16;
        let functions: [fn(Vec3) -> f32; 4] =
            [|_| 1.0, |d| d.x, |d| d.y * d.y, |d| (d.z > 0.7) as u32 as f32];
        for (roughness, cos) in [(0.0, 0.3), (0.5, 0.1), (1.0, 0.1), (1.0, 0.9)] {
            let eon = Eon::new(Vec3::ONE, roughness, at(cos, 0.3));
            for (number, function) in functions.iter().enumerate() {
                let (mut sampled, mut integral) = (0.0, 0.0);
                for i in 0..COUNT {
                    let u = sobol_2d(i).map(|x| (x >> 8) as f32 * (1.0 / 16_777_216.0));
                    sampled += f64::from(function(eon.sample(u)));
                    let d = hemisphere_direction(u);
                    integral += f64::from(function(d) * eon.pdf(d)) * 2.0 * PI;
                }
                let error = (sampled - integral).abs() / f64::from(COUNT);
                assert!(error < 1e-3, "roughness {roughness}, cosine {cos}, function {number}: {error}");
            }
        }
    }

    /// Near the horizon samples by the cosine alone would weigh up to one over the viewer's.
    #[test]
    fn no_sample_weighs_much() {
        let (mut most, mut squares) = (0.0f32, [[0.0; 5]; 4]);
        for (row, roughness) in ROUGHNESSES.into_iter().enumerate() {
            for (column, cos) in COSINES.into_iter().enumerate() {
                let eon = Eon::new(Vec3::ONE, roughness, at(cos, 0.3));
                for i in 0..4096 {
                    let u = sobol_2d(i).map(|x| (x >> 8) as f32 * (1.0 / 16_777_216.0));
                    let scattered = eon.eval(eon.sample(u));
                    // Level directions are not taken.
                    let weight = if scattered.pdf > 0.0 { scattered.value.x / scattered.pdf } else { 0.0 };
                    most = most.max(weight);
                    squares[row][column] += f64::from(weight * weight) / 4096.0;
                }
            }
        }
        println!("largest weight {most}; means of squares {squares:.3?}");
        assert!(most < 3.5, "{most}");
        // By the cosine alone the first of the last row is 1.95, and the largest weight 17.
        assert!(squares.as_flattened().iter().all(|&square| square < 1.5), "{squares:?}");
    }
}
