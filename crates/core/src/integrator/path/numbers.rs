//! Random numbers of a path.

use crate::integrator::{PathRay, camera_ray::pixel_key};
use crate::sampling::{hash_pair, point_2d, with_digits};
use crate::settings::Settings;

/// Keys of the numbers of vertices, which follow those of the camera ray.
const FIRST_BOUNCE: u32 = 0x1000;

/// Two numbers each: the decisions of a path at a surface.
const ARRIVAL: u32 = 0;
const CHOICE: u32 = 1;
const LIGHT: u32 = 2;
const DIRECTION: u32 = 3;
const ENVIRONMENT: u32 = 4;
const DIGITS: u32 = 5;

/// The random numbers of a path where its ray has met a surface. They belong to the pixel, the bounces so far and the surfaces
/// passed since the last one, whatever else has happened: all samples of a pixel use the points of one well-spread sequence for one
/// decision, in the order of their numbers.
#[derive(Clone, Copy, Debug)]
pub struct Numbers {
    key: u32,
    sample: u32,
}

impl Numbers {
    /// For sample `sample` of pixel (x, y).
    #[inline(always)]
    pub fn new(settings: &Settings, ray: &PathRay, (x, y, sample): (u32, u32, u32)) -> Numbers {
        let bounce = hash_pair(pixel_key(settings.seed, x, y), FIRST_BOUNCE + ray.depth);
        Numbers { key: hash_pair(bounce, ray.holes), sample }
    }

    #[inline(always)]
    fn pair(&self, dimension: u32) -> [f32; 2] {
        point_2d(self.sample, hash_pair(self.key, dimension))
    }

    /// Whether the ray passes the surface, and whether the path goes on.
    #[inline(always)]
    pub fn arrival(&self) -> [f32; 2] {
        self.pair(ARRIVAL)
    }

    /// Which light is sampled, and which lobe.
    #[inline(always)]
    pub fn choice(&self) -> (f64, f32) {
        let [light, lobe] = self.pair(CHOICE);
        // Further digits, at random, for trees of many lights.
        let digits = hash_pair(hash_pair(self.key, DIGITS), self.sample);
        (with_digits(light, digits), lobe)
    }

    /// Index and key of the point on the light.
    #[inline(always)]
    pub fn on_light(&self) -> (u32, u32) {
        (self.sample, hash_pair(self.key, LIGHT))
    }

    /// Where the environment is sampled, and between the digits of that.
    #[inline(always)]
    pub fn on_environment(&self) -> [[f32; 2]; 2] {
        [self.pair(LIGHT), self.pair(ENVIRONMENT)]
    }

    /// The direction in the lobe.
    #[inline(always)]
    pub fn direction(&self) -> [f32; 2] {
        self.pair(DIRECTION)
    }
}
