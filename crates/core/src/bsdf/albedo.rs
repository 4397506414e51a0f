//! How much light rough surfaces return by single scattering, from tables: microfacets send the rest to each other.
//!
//! Tables are linear in the roughness `sqrt(alpha)` and, so that what is lost at grazing angles, a function of cos / alpha,
//! stays in place from row to row, in `sqrt(cos (1 + k) / (cos + k))` with `k = 4 alpha`.

use super::closure::SMOOTH;
use super::schlick::schlick_weight;
use super::{glass_tables, mirror_tables};
use crate::math::{clamp, fma, min, sqrt};

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

/// Places over the cosine and the roughness.
#[inline(always)]
fn places(cos: f32, alpha: f32, counts: [usize; 2]) -> [Place; 2] {
    let k = 4.0 * alpha;
    [Place::new(sqrt(cos * (1.0 + k) / (cos + k)), counts[0]), Place::new(sqrt(alpha), counts[1])]
}

/// Bilinear.
#[inline(always)]
fn look_up<const N: usize, const M: usize>(table: &[[f32; N]; M], [cos, roughness]: [Place; 2]) -> f32 {
    let row = |row: usize| {
        let row = &table[row.min(M - 1)];
        cos.between(row[cos.node.min(N - 1)], row[(cos.node + 1).min(N - 1)])
    };
    roughness.between(row(roughness.node), row(roughness.node + 1))
}

/// Of a white mirror of roughness `alpha`, for light at a cosine of incidence above 0.
#[inline(always)]
pub fn white_albedo(cos: f32, alpha: f32) -> Albedo {
    let smooth = schlick_weight(cos);
    if alpha < SMOOTH {
        return Albedo { lost: 0.0, grazing: smooth };
    }
    let place = places(cos, alpha, [mirror_tables::COSINES, mirror_tables::ROUGHNESSES]);
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

/// What rough glass reflects and transmits in all by single scattering, of light at a cosine of incidence above 0; `eta` is the
/// index beyond over that on the viewer's side, and is taken as 2/5 or 5/2 beyond these.
#[inline(always)]
pub fn white_glass_albedo(cos: f32, alpha: f32, eta: f32) -> f32 {
    let place = places(cos, alpha, [glass_tables::COSINES, glass_tables::ROUGHNESSES]);
    // Close to 1 the critical angle goes with the square root of the contrast.
    let contrast = (eta - 1.0).abs() / (eta + 1.0);
    let coordinate = sqrt(min(contrast * (7.0 / 3.0), 1.0));
    let lost = if eta > 1.0 {
        look_up_glass(&glass_tables::DENSER, place, coordinate)
    } else {
        look_up_glass(&glass_tables::THINNER, place, coordinate)
    };
    1.0 - lost * (1.0 / 65535.0)
}

/// Trilinear.
#[inline(always)]
fn look_up_glass<const K: usize>(
    table: &[[[u16; glass_tables::COSINES]; glass_tables::ROUGHNESSES]; K],
    [cos, roughness]: [Place; 2],
    coordinate: f32,
) -> f32 {
    const COSINES: usize = glass_tables::COSINES;
    let index = Place::new(coordinate, K);
    let row = |layer: usize, row: usize| {
        let row = &table[layer.min(K - 1)][row.min(glass_tables::ROUGHNESSES - 1)];
        cos.between(
            f32::from(row[cos.node.min(COSINES - 1)]),
            f32::from(row[(cos.node + 1).min(COSINES - 1)]),
        )
    };
    let layer = |layer: usize| roughness.between(row(layer, roughness.node), row(layer, roughness.node + 1));
    index.between(layer(index.node), layer(index.node + 1))
}
