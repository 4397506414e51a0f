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
        NumbersByKey::of_pixel(pixel_key(settings.seed, x, y), [ray.depth, ray.holes], sample)
    }

    #[inline(always)]
    fn of_pixel(pixel_key: u32, [depth, holes]: [u32; 2], sample: u32) -> NumbersByKey {
        NumbersByKey { key: hash_pair(hash_pair(pixel_key, FIRST_BOUNCE + depth), holes), sample }
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
    /// Of several paths: `of(lane)` gives the key of the pixel ([`pixel_key`]), the sample and the ray. They are the numbers of
    /// [`NumbersByKey`].
    #[inline(always)]
    pub fn new<'a>(of: impl Fn(usize) -> (u32, u32, &'a PathRay)) -> NumberLanes<W> {
        let (mut keys, mut samples, mut places) = ([0; W], [0; W], [[0; 2]; W]);
        for lane in 0..W {
            let (pixel_key, sample, ray) = of(lane);
            (keys[lane], samples[lane], places[lane]) = (pixel_key, sample, [ray.depth, ray.holes]);
        }
        for lane in 0..W {
            keys[lane] = NumbersByKey::of_pixel(keys[lane], places[lane], samples[lane]).key;
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
}

/// Numbers of several paths.
pub trait NumbersOfLanes<const W: usize> {
    /// Those of one path.
    type Lane<'a>: Numbers
    where
        Self: 'a;

    /// What decides whether each path goes on: the second number of [`Numbers::arrival`].
    fn survival(&self) -> [f32; W];
    /// Which light each samples: the first number of [`Numbers::choice`].
    fn light_choice(&self) -> [f64; W];
    /// The points on lights.
    fn on_lights(&self) -> [[f32; W]; 2];
    /// The directions in lobes.
    fn directions(&self) -> [[f32; W]; 2];
    /// Those of one path.
    fn lane(&self, lane: usize) -> Self::Lane<'_>;
}

impl<const W: usize> NumbersOfLanes<W> for NumberLanes<W> {
    type Lane<'a> = NumbersInLane<'a, W>;

    #[inline(always)]
    fn survival(&self) -> [f32; W] {
        self.pairs[ARRIVAL as usize][1]
    }

    #[inline(always)]
    fn light_choice(&self) -> [f64; W] {
        let mut choice = [0.0; W];
        for lane in 0..W {
            choice[lane] = with_digits(self.pairs[CHOICE as usize][0][lane], self.digits[lane]);
        }
        choice
    }

    #[inline(always)]
    fn on_lights(&self) -> [[f32; W]; 2] {
        self.pairs[LIGHT as usize]
    }

    #[inline(always)]
    fn directions(&self) -> [[f32; W]; 2] {
        self.pairs[DIRECTION as usize]
    }

    #[inline(always)]
    fn lane(&self, lane: usize) -> NumbersInLane<'_, W> {
        NumbersInLane { lanes: self, lane }
    }
}

/// One path is a lane by itself.
impl NumbersOfLanes<1> for NumbersByKey {
    type Lane<'a> = NumbersByKey;

    #[inline(always)]
    fn survival(&self) -> [f32; 1] {
        [self.arrival()[1]]
    }

    #[inline(always)]
    fn light_choice(&self) -> [f64; 1] {
        [self.choice().0]
    }

    #[inline(always)]
    fn on_lights(&self) -> [[f32; 1]; 2] {
        self.on_light().map(|u| [u])
    }

    #[inline(always)]
    fn directions(&self) -> [[f32; 1]; 2] {
        self.direction().map(|u| [u])
    }

    #[inline(always)]
    fn lane(&self, _: usize) -> NumbersByKey {
        *self
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::integrator::RayKind;
    use crate::math::Vec3;
    use crate::ray::PrimitiveId;

    #[test]
    fn lanes_have_the_numbers_of_keys() {
        let ray = |depth, holes| PathRay {
            origin: Vec3::ZERO,
            path: 0,
            direction: Vec3::ONE,
            depth,
            weight: Vec3::ONE,
            kind: RayKind::Glossy,
            start: PrimitiveId::NONE,
            inside: 0,
            holes,
            travelled: 0.0,
            lobe_density: 0.0,
        };
        let rays: Vec<PathRay> = (0..8).map(|k| ray(k / 3, k % 3)).collect();
        let lanes =
            NumberLanes::<8>::new(|lane| (pixel_key(5, lane as u32, 9), 70 + lane as u32, &rays[lane]));
        for (lane, ray) in rays.iter().enumerate() {
            let pixel = pixel_key(5, lane as u32, 9);
            let (one, of_lane) =
                (NumbersByKey::of_pixel(pixel, [ray.depth, ray.holes], 70 + lane as u32), lanes.lane(lane));
            assert_eq!(one.arrival(), of_lane.arrival());
            assert_eq!(one.choice(), of_lane.choice());
            assert_eq!(one.on_light(), of_lane.on_light());
            assert_eq!(one.on_environment(), of_lane.on_environment());
            assert_eq!(one.direction(), of_lane.direction());
        }
    }
}
