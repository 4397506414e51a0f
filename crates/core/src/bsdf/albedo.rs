//! How much light rough surfaces return by single scattering, from tables: microfacets send the rest to each other.
//!
//! Tables are linear in the roughness `sqrt(alpha)` and, so that what is lost at grazing angles, a function of cos / alpha,
//! stays in place from row to row, in `sqrt(cos (1 + k) / (cos + k))` with `k = 4 alpha`; but see [`place_about_critical`].

use super::closure::SMOOTH;
use super::schlick::schlick_weight;
use super::{glass_tables, mirror_tables, turned_tables};
use crate::math::{clamp, fma, max, min, sqrt};

/// What a white GGX mirror does with light from one direction.
#[derive(Clone, Copy, Debug)]
pub struct Albedo {
    /// The part that a single reflection does not return: one minus the albedo.
    pub lost: f32,
    /// The part of the albedo that Schlick's `(1 - cos)^5` weighs: reflectances F0 and F90 give
    /// `F0 (1 - lost - grazing) + F90 grazing`.
    pub grazing: f32,
}

/// The same for light that comes equally from all sides: means of [`Albedo`] weighted by the cosine.
#[derive(Clone, Copy, Debug)]
pub struct MeanAlbedo {
    /// Mean of [`Albedo::lost`].
    pub lost: f32,
    /// Mean of [`Albedo::grazing`].
    pub grazing: f32,
}

/// A node of a table and the way from it to the next, 0 to 1.
#[derive(Clone, Copy)]
struct Place {
    node: usize,
    rest: f32,
}

impl Place {
    /// Of a coordinate from 0 to 1 in a table of `count` nodes.
    #[inline(always)]
    fn new(coordinate: f32, count: usize) -> Place {
        let last = (count - 1) as f32;
        let x = clamp(coordinate * last, 0.0, last);
        let node = (x as usize).min(count - 2);
        Place { node, rest: x - node as f32 }
    }

    /// Between two values.
    #[inline(always)]
    fn between(self, a: f32, b: f32) -> f32 {
        fma(self.rest, b - a, a)
    }
}

/// Over the cosine, in a row for a roughness.
#[inline(always)]
fn place_of_cosine(cos: f32, alpha: f32, count: usize) -> Place {
    let k = 4.0 * alpha;
    Place::new(sqrt(cos * (1.0 + k) / (cos + k)), count)
}

/// Over the cosine towards a thinner medium: nodes are dense on both sides of the critical angle, which is the middle of the
/// table, and at the horizon. Beyond the critical angle light that just escapes is lost between microfacets.
#[inline(always)]
fn place_about_critical(cos: f32, eta: f32, count: usize) -> Place {
    let critical = sqrt(max((1.0 - eta) * (1.0 + eta), 0.0));
    if cos >= critical {
        return Place::new(fma(0.5, sqrt((cos - critical) / max(1.0 - critical, 1e-6)), 0.5), count);
    }
    let part = cos / critical;
    let half = if part < 0.5 { sqrt(0.5 * part) } else { 1.0 - sqrt(0.5 * (1.0 - part)) };
    Place::new(0.5 * half, count)
}

/// Bilinear.
#[inline(always)]
fn look_up<const N: usize, const M: usize>(table: &[[f32; N]; M], [cos, roughness]: [Place; 2]) -> f32 {
    let (a, b) = (&table[roughness.node.min(M - 1)], &table[(roughness.node + 1).min(M - 1)]);
    roughness.between(look_up_row(a, cos), look_up_row(b, cos))
}

/// Linear. No closure, which would be compiled without the caller's instruction set where it is not inlined.
#[inline(always)]
fn look_up_row<const N: usize>(row: &[f32; N], cos: Place) -> f32 {
    cos.between(row[cos.node.min(N - 1)], row[(cos.node + 1).min(N - 1)])
}

/// Of a white mirror of roughness `alpha`, for light at a cosine of incidence above 0.
#[inline(always)]
pub fn white_albedo(cos: f32, alpha: f32) -> Albedo {
    let smooth = schlick_weight(cos);
    if alpha < SMOOTH {
        return Albedo { lost: 0.0, grazing: smooth };
    }
    let place = [
        place_of_cosine(cos, alpha, mirror_tables::COSINES),
        Place::new(sqrt(alpha), mirror_tables::ROUGHNESSES),
    ];
    let lost = look_up(&mirror_tables::LOST, place);
    Albedo { lost, grazing: fma(1.0 - lost, smooth, look_up(&mirror_tables::GRAZING, place)) }
}

/// The same for light from all sides.
#[inline(always)]
pub fn white_mean_albedo(alpha: f32) -> MeanAlbedo {
    if alpha < SMOOTH {
        // The mean of (1 - cos)^5 over the hemisphere, weighted by the cosine.
        return MeanAlbedo { lost: 0.0, grazing: 1.0 / 21.0 };
    }
    let place = Place::new(sqrt(alpha), mirror_tables::ROUGHNESSES);
    let of = |table: &[f32; mirror_tables::ROUGHNESSES]| {
        place.between(table[place.node.min(table.len() - 1)], table[(place.node + 1).min(table.len() - 1)])
    };
    MeanAlbedo { lost: of(&mirror_tables::MEAN_LOST), grazing: of(&mirror_tables::MEAN_GRAZING) }
}

/// Means of [`white_albedo`] over the light that a rough base turns back (`s / t` of [`super::eon`]) to a viewer at a cosine.
#[inline(always)]
pub fn turned_albedo(cos: f32, alpha: f32) -> Albedo {
    let place =
        [Place::new(cos, turned_tables::COSINES), Place::new(sqrt(alpha), turned_tables::ROUGHNESSES)];
    Albedo { lost: look_up(&turned_tables::LOST, place), grazing: look_up(&turned_tables::GRAZING, place) }
}

/// Means of products of [`white_albedo`] over all pairs of directions that a rough base turns light back between.
#[derive(Clone, Copy, Debug)]
pub struct TurnedPairs {
    lost: f32,
    grazing: f32,
    lost_twice: f32,
    grazing_twice: f32,
    one_each: f32,
}

impl TurnedPairs {
    /// Of a layer of roughness `alpha`.
    #[inline(always)]
    pub fn new(alpha: f32) -> TurnedPairs {
        let place = Place::new(sqrt(alpha), turned_tables::ROUGHNESSES);
        let row = |row: usize| &turned_tables::PAIRS[row.min(turned_tables::ROUGHNESSES - 1)];
        let (a, b) = (row(place.node), row(place.node + 1));
        TurnedPairs {
            lost: place.between(a[0], b[0]),
            grazing: place.between(a[1], b[1]),
            lost_twice: place.between(a[2], b[2]),
            grazing_twice: place.between(a[3], b[3]),
            one_each: place.between(a[4], b[4]),
        }
    }

    /// Means of `t = one + lost * (the lost part) + grazing * (Schlick's part)` of one direction of a pair, and of the product of
    /// both.
    #[inline(always)]
    pub fn means(&self, [one, lost, grazing]: [f32; 3]) -> (f32, f32) {
        let varied = fma(lost, self.lost, grazing * self.grazing);
        let squares = fma(lost * lost, self.lost_twice, grazing * grazing * self.grazing_twice);
        let both = fma(one, fma(2.0, varied, one), fma(2.0 * lost * grazing, self.one_each, squares));
        (one + varied, both)
    }
}

/// The tables of rough glass, by the names that they have in the text of the kernels. That has them without contents: they are
/// large, and drivers take seconds to read them as a text.
pub fn large_tables() -> [(&'static str, &'static [i16]); 2] {
    [
        ("glass_denser", glass_tables::DENSER.as_flattened().as_flattened()),
        ("glass_thinner", glass_tables::THINNER.as_flattened().as_flattened()),
    ]
}

/// What rough glass reflects and transmits in all by single scattering, of light at a cosine of incidence above 0; `eta` is the
/// index beyond over that on the viewer's side, and is taken as 2/5 or 5/2
/// beyond these; `mirror_lost` is [`Albedo::lost`].
#[inline(always)]
pub fn white_glass_albedo(cos: f32, alpha: f32, eta: f32, mirror_lost: f32) -> f32 {
    // Close to 1 the critical angle goes with the square root of the contrast, and the loss changes fast: a third of the layers
    // lies in the first eighth.
    let contrast = (eta - 1.0).abs() / (eta + 1.0);
    let root = sqrt(min(contrast * (7.0 / 3.0), 1.0));
    let coordinate = min(root * (8.0 / 3.0), fma(16.0 / 21.0, root, 5.0 / 21.0));
    let lost = if eta > 1.0 {
        look_up_glass(&glass_tables::DENSER, alpha, coordinate, |count| place_of_cosine(cos, alpha, count))
    } else {
        mirror_lost
            + look_up_glass(&glass_tables::THINNER, alpha, coordinate, |count| {
                place_about_critical(cos, eta, count)
            })
    };
    1.0 - max(lost, 0.0)
}

/// Trilinear.
#[inline(always)]
fn look_up_glass<const N: usize, const M: usize, const K: usize>(
    table: &[[[i16; N]; M]; K],
    alpha: f32,
    coordinate: f32,
    place_of_cosine: impl Fn(usize) -> Place,
) -> f32 {
    let (cos, roughness, index) = (place_of_cosine(N), Place::new(sqrt(alpha), M), Place::new(coordinate, K));
    let row = |layer: usize, row: usize| {
        let row = &table[layer.min(K - 1)][row.min(M - 1)];
        cos.between(f32::from(row[cos.node.min(N - 1)]), f32::from(row[(cos.node + 1).min(N - 1)]))
    };
    let layer = |layer: usize| roughness.between(row(layer, roughness.node), row(layer, roughness.node + 1));
    index.between(layer(index.node), layer(index.node + 1)) * (1.0 / 32768.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What a surface reflects, of Schlick's part too, and transmits, in double precision: over all microfacets in equal parts,
    /// with masking and shadowing by Smith's lambda. The tables are made from visible microfacets.
    fn reference(cos: f64, alpha: f64, eta: f64) -> [f64; 3] {
        const STEPS: usize = 800;
        let sine = (1.0 - cos * cos).sqrt();
        let lambda = |c: f64| 0.5 * ((1.0 + alpha * alpha * (1.0 / (c * c) - 1.0)).sqrt() - 1.0);
        let mut sums = [0.0; 3];
        for i in 0..STEPS {
            let s = (i as f64 + 0.5) / STEPS as f64;
            let slope = alpha * (1.0 - s * s).sqrt() / s;
            let z = 1.0 / (1.0 + slope * slope).sqrt();
            for j in 0..STEPS {
                let angle = std::f64::consts::PI * (j as f64 + 0.5) / STEPS as f64;
                let seen = cos + slope * sine * angle.cos();
                if seen <= 0.0 {
                    continue;
                }
                let part = 2.0 * s / (STEPS * STEPS) as f64 * seen / cos;
                let c = seen * z;
                let both =
                    |light: f64| if light > 0.0 { 1.0 / (1.0 + lambda(cos) + lambda(light)) } else { 0.0 };
                let up = part * both(2.0 * c * z - cos);
                let sine2 = (1.0 - c * c) / (eta * eta);
                let (r, down) = if sine2 >= 1.0 {
                    (1.0, 0.0)
                } else {
                    let t = (1.0 - sine2).sqrt();
                    let r = 0.5
                        * (((c - eta * t) / (c + eta * t)).powi(2) + ((t - eta * c) / (t + eta * c)).powi(2));
                    (r, part * both(cos / eta - (c / eta - t) * z))
                };
                sums[0] += up;
                sums[1] += up * (1.0 - c).powi(5);
                sums[2] += r * up + (1.0 - r) * down;
            }
        }
        sums
    }

    #[test]
    fn tables_are_those_of_another_quadrature() {
        let mut worst = [0f64; 4];
        for roughness in [0.11f32, 0.2, 0.33, 0.5, 0.62, 0.81, 1.0] {
            for cos in [0.07f32, 0.2, 0.37, 0.66, 0.93, 1.0] {
                let alpha = roughness * roughness;
                for eta in [1.52f32, 1.2, 0.7] {
                    let [all, grazing, glass] = reference(cos.into(), alpha.into(), eta.into());
                    let got = white_albedo(cos, alpha);
                    let errors = [
                        (1.0 - f64::from(got.lost) - all).abs(),
                        (f64::from(got.grazing) - grazing).abs(),
                        (f64::from(white_glass_albedo(cos, alpha, eta, got.lost)) - glass).abs(),
                    ];
                    let of_glass = if eta > 1.0 { 2 } else { 3 };
                    for (error, slot, bound) in
                        [(errors[0], 0, 6e-4), (errors[1], 1, 6e-4), (errors[2], of_glass, 2e-3)]
                    {
                        worst[slot] = worst[slot].max(error);
                        assert!(
                            error < bound,
                            "roughness {roughness}, cosine {cos}, index {eta}: {errors:?}"
                        );
                    }
                }
            }
        }
        println!(
            "worst: mirror {:.5}, its Schlick part {:.5}, glass {:.5} and {:.5}",
            worst[0], worst[1], worst[2], worst[3]
        );
    }

    /// Means over what a rough base turns back, by steps of the angles.
    #[test]
    fn tables_of_what_is_turned_back_are_those_of_another_quadrature() {
        const STEPS: usize = 1000;
        let mut worst = 0f64;
        for roughness in [0.0f32, 0.1, 0.33, 0.62, 0.87, 1.0] {
            let alpha = roughness * roughness;
            let lights: Vec<(f64, f64, Albedo)> = (0..STEPS)
                .map(|i| {
                    let angle = std::f64::consts::FRAC_PI_2 * (i as f64 + 0.5) / STEPS as f64;
                    (angle.cos(), angle.sin(), white_albedo(angle.cos() as f32, alpha))
                })
                .collect();
            for cos in [0.01f64, 0.13, 0.4, 0.72, 0.99] {
                let mut sums = [0.0; 3];
                for &(c, s, albedo) in &lights {
                    let weight = c * s * s * (1.0 / c.max(cos) - 1.0);
                    for (sum, value) in sums.iter_mut().zip([1.0, albedo.lost.into(), albedo.grazing.into()])
                    {
                        *sum += weight * value;
                    }
                }
                let got = turned_albedo(cos as f32, alpha);
                let errors = [
                    (f64::from(got.lost) - sums[1] / sums[0]).abs(),
                    (f64::from(got.grazing) - sums[2] / sums[0]).abs(),
                ];
                worst = worst.max(errors[0]).max(errors[1]);
                assert!(worst < 1.5e-3, "roughness {roughness}, cosine {cos}: {errors:?}");
            }
        }
        println!("off by {worst:.5} at most");
    }
}
