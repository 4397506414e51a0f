//! Random numbers of a path.

use crate::integrator::{PathRay, camera_ray::pixel_key};
use crate::sampling::{hash_pair, point_2d, with_digits};
use crate::settings::Settings;

/// Keys of the numbers of vertices, which follow those of the camera ray.
const FIRST_BOUNCE: u32 = 0x1000;

/// Two numbers each: the decisions of a path at a surface. Then what follows the digits of one of them.
const ARRIVAL: u32 = 0;
const CHOICE: u32 = 1;
const LIGHT: u32 = 2;
const DIRECTION: u32 = 3;
const ENVIRONMENT: u32 = 4;
const DIGITS: u32 = 5;

/// The random numbers of a path where its ray has met a surface. They belong to the pixel, the bounces so far and the surfaces
/// passed since the last one, whatever else has happened: all samples of a pixel use the points of one well-spread sequence for one
/// decision, in the order of their numbers.
pub trait Numbers {
    /// Whether the ray passes the surface, and whether the path goes on.
    fn arrival(&self) -> [f32; 2];
    /// Which light is sampled, and which lobe.
    fn choice(&self) -> (f64, f32);
    /// The point on the light.
    fn on_light(&self) -> [f32; 2];
    /// Where the environment is sampled, and between the digits of that.
    fn on_environment(&self) -> [[f32; 2]; 2];
    /// The direction in the lobe.
    fn direction(&self) -> [f32; 2];
}

/// Numbers that are computed where they are asked for.
#[derive(Clone, Copy, Debug)]
pub struct NumbersByKey {
    key: u32,
    sample: u32,
}

impl NumbersByKey {
    /// For sample `sample` of pixel (x, y).
    #[inline(always)]
    pub fn new(settings: &Settings, ray: &PathRay, (x, y, sample): (u32, u32, u32)) -> NumbersByKey {
        let bounce = hash_pair(pixel_key(settings.seed, x, y), FIRST_BOUNCE + ray.depth);
        NumbersByKey { key: hash_pair(bounce, ray.holes), sample }
    }

    #[inline(always)]
    fn pair(&self, dimension: u32) -> [f32; 2] {
        point_2d(self.sample, hash_pair(self.key, dimension))
    }

    /// Further digits, at random, for trees of many lights.
    #[inline(always)]
    fn digits(&self) -> u32 {
        hash_pair(hash_pair(self.key, DIGITS), self.sample)
    }
}

impl Numbers for NumbersByKey {
    #[inline(always)]
    fn arrival(&self) -> [f32; 2] {
        self.pair(ARRIVAL)
    }

    #[inline(always)]
    fn choice(&self) -> (f64, f32) {
        let [light, lobe] = self.pair(CHOICE);
        (with_digits(light, self.digits()), lobe)
    }

    #[inline(always)]
    fn on_light(&self) -> [f32; 2] {
        self.pair(LIGHT)
    }

    #[inline(always)]
    fn on_environment(&self) -> [[f32; 2]; 2] {
        [self.pair(LIGHT), self.pair(ENVIRONMENT)]
    }

    #[inline(always)]
    fn direction(&self) -> [f32; 2] {
        self.pair(DIRECTION)
    }
}

/// All numbers of several paths, which are computed together: loops over arrays, free of branches.
pub struct NumberLanes<const W: usize> {
    pairs: [[[f32; W]; 2]; DIGITS as usize],
    digits: [u32; W],
}

impl<const W: usize> NumberLanes<W> {
    /// Of the paths that `of` names, which have the numbers of [`NumbersByKey`].
    #[inline(always)]
    pub fn new(of: impl Fn(usize) -> NumbersByKey) -> NumberLanes<W> {
        let (mut keys, mut samples) = ([0; W], [0; W]);
        for lane in 0..W {
            let numbers = of(lane);
            (keys[lane], samples[lane]) = (numbers.key, numbers.sample);
        }
        let mut lanes = NumberLanes { pairs: [[[0.0; W]; 2]; DIGITS as usize], digits: [0; W] };
        for dimension in 0..DIGITS {
            let [x, y] = &mut lanes.pairs[dimension as usize];
            for lane in 0..W {
                [x[lane], y[lane]] = NumbersByKey { key: keys[lane], sample: samples[lane] }.pair(dimension);
            }
        }
        for lane in 0..W {
            lanes.digits[lane] = NumbersByKey { key: keys[lane], sample: samples[lane] }.digits();
        }
        lanes
    }

    /// Those of one path.
    #[inline(always)]
    pub fn lane(&self, lane: usize) -> NumbersInLane<'_, W> {
        NumbersInLane { lanes: self, lane }
    }
}

/// The numbers of one of several paths.
#[derive(Clone, Copy)]
pub struct NumbersInLane<'a, const W: usize> {
    lanes: &'a NumberLanes<W>,
    lane: usize,
}

impl<const W: usize> NumbersInLane<'_, W> {
    #[inline(always)]
    fn pair(&self, dimension: u32) -> [f32; 2] {
        let [x, y] = &self.lanes.pairs[dimension as usize];
        [x[self.lane], y[self.lane]]
    }
}

impl<const W: usize> Numbers for NumbersInLane<'_, W> {
    #[inline(always)]
    fn arrival(&self) -> [f32; 2] {
        self.pair(ARRIVAL)
    }

    #[inline(always)]
    fn choice(&self) -> (f64, f32) {
        let [light, lobe] = self.pair(CHOICE);
        (with_digits(light, self.lanes.digits[self.lane]), lobe)
    }

    #[inline(always)]
    fn on_light(&self) -> [f32; 2] {
        self.pair(LIGHT)
    }

    #[inline(always)]
    fn on_environment(&self) -> [[f32; 2]; 2] {
        [self.pair(LIGHT), self.pair(ENVIRONMENT)]
    }

    #[inline(always)]
    fn direction(&self) -> [f32; 2] {
        self.pair(DIRECTION)
    }
}
