//! An environment of lamps with soft edges around a model, made by plain arithmetic: the same bytes on every machine.

use crate::double::{Vec3d, cross, dot, unit};
use crate::model::{Image, Texels};
use eosphor_core::math::elementary64;
use std::f64::consts::{PI, TAU};

/// What names it where the file of an environment is asked for.
pub(crate) const STUDIO: &str = "builtin:studio";

/// Texels around, and half as many down.
const WIDTH: u32 = 256;

/// Radiance straight below and straight above, where no lamp is.
const GROUND: f64 = 0.06;
const CEILING: f64 = 0.3;

/// A rectangle on the plane at distance 1 that faces the middle.
struct Lamp {
    towards: Vec3d,
    /// Half its sides, across and up.
    half_sides: [f64; 2],
    radiance: f64,
}

/// One that lights from the upper left of who looks along -z, a tall one at the right, and one behind, for edges.
const LAMPS: [Lamp; 3] = [
    Lamp { towards: [-0.7, 0.75, 0.6], half_sides: [0.55, 0.45], radiance: 3.6 },
    Lamp { towards: [0.95, 0.25, 0.35], half_sides: [0.25, 0.75], radiance: 1.5 },
    Lamp { towards: [0.2, 0.5, -1.0], half_sides: [0.9, 0.18], radiance: 2.4 },
];

/// Over which distance, on that plane, a lamp's edge fades.
const EDGE: f64 = 0.12;

/// The picture: equirectangular, +y up, its middle towards +x, and +z right of that.
pub(crate) fn studio() -> Image {
    let height = WIDTH / 2;
    let texels: Vec<[f32; 4]> = (0..WIDTH * height)
        .map(|n| {
            let (column, row) = (f64::from(n % WIDTH) + 0.5, f64::from(n / WIDTH) + 0.5);
            let (sine, up) = elementary64::sin_cos(row * PI / f64::from(height));
            let (z, x) = elementary64::sin_cos((column / f64::from(WIDTH) - 0.5) * TAU);
            let radiance = radiance([sine * x, up, sine * z]) as f32;
            [radiance, radiance, radiance, 1.0]
        })
        .collect();
    Image { name: "studio".into(), width: WIDTH, height, texels: Texels::rgba_floats(&texels) }
}

fn radiance(way: Vec3d) -> f64 {
    let lamps: f64 = LAMPS.iter().map(|lamp| lamp.radiance * lamp.coverage(way)).sum();
    GROUND + (CEILING - GROUND) * smooth(0.5 * (way[1] + 1.0)) + lamps
}

impl Lamp {
    /// 1 where it is, 0 beside it.
    fn coverage(&self, way: Vec3d) -> f64 {
        let middle = unit(self.towards);
        let depth = dot(way, middle);
        if depth <= 0.0 {
            return 0.0;
        }
        let right = unit(cross([0.0, 1.0, 0.0], middle));
        let sides = [right, cross(middle, right)];
        let within = |k: usize| {
            let place = dot(way, sides[k]).abs() / depth;
            smooth((self.half_sides[k] - place) / EDGE + 0.5)
        };
        within(0) * within(1)
    }
}

/// From 0 to 1 without a kink.
fn smooth(x: f64) -> f64 {
    let x = x.clamp(0.0, 1.0);
    x * x * (3.0 - 2.0 * x)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Lamps are where they are said to be, with their radiance over that of the room.
    #[test]
    fn lamps_shine_from_where_they_stand() {
        for lamp in &LAMPS {
            let way = unit(lamp.towards);
            let room = GROUND + (CEILING - GROUND) * smooth(0.5 * (way[1] + 1.0));
            assert!((radiance(way) - room - lamp.radiance).abs() < 1e-12);
        }
        assert!((radiance([0.0, -1.0, 0.0]) - GROUND).abs() < 1e-12);
    }

    /// White things are on average about as bright as in the uniform surroundings of scenes without light.
    #[test]
    fn its_mean_is_that_of_uniform_surroundings() {
        let image = studio();
        let texel = |n: u32| f32::from_bits(image.texels.words()[4 * n as usize]);
        let (mut sum, mut weights) = (0.0, 0.0);
        for n in 0..WIDTH * WIDTH / 2 {
            let weight = ((f64::from(n / WIDTH) + 0.5) * PI / f64::from(WIDTH / 2)).sin();
            sum += weight * f64::from(texel(n));
            weights += weight;
        }
        assert!((sum / weights - 0.5).abs() < 0.1, "{}", sum / weights);
    }
}
