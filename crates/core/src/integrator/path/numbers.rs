//! Random numbers of a path.

use crate::integrator::{PathRay, camera_ray::pixel_key};
use crate::sampling::{hash_pair, mix, point_2d, with_digits};
use crate::settings::Settings;

/// Keys of the numbers of vertices, which follow those of the camera ray.
const FIRST_BOUNCE: u32 = 0x1000;

/// Two numbers each: the decisions of a path at a surface. Then what follows the digits of one of them, and a decision that few
/// surfaces have.
const ARRIVAL: u32 = 0;
const LIGHT: u32 = 1;
const DIRECTION: u32 = 2;
const DIGITS: u32 = 3;
const SIDE: u32 = 4;

/// The random numbers of a path where its ray has met a surface. They belong to the pixel, the bounces so far and the surfaces
/// passed since the last one, whatever else has happened: all samples of a pixel use the points of one well-spread sequence for one
/// decision, in the order of their numbers.
///
/// What is chosen first, a light or a lobe, takes a range of the first number of a pair; where in that range it lies is the first
/// coordinate of what is chosen then ([`place_within`](crate::sampling::place_within)). So the samples of each light and each lobe
/// are well spread, too: numbers of their own would leave to each a part of the points at random.
pub trait Numbers {
    /// Whether the ray passes the surface, and whether the path goes on.
    fn arrival(&self) -> [f32; 2];
    /// Which light is sampled and where, and the second coordinate of that.
    fn light(&self) -> (f64, f32);
    /// More digits of that second coordinate, for large tables.
    fn fine_place(&self) -> f64;
    /// Which lobe is sampled and the direction in it.
    fn direction(&self) -> [f32; 2];
    /// Which side of glass light comes from.
    fn side(&self) -> f32;
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
    fn light(&self) -> (f64, f32) {
        let [choice, place] = self.pair(LIGHT);
        (with_digits(choice, self.digits()), place)
    }

    #[inline(always)]
    fn fine_place(&self) -> f64 {
        let [_, place] = self.pair(LIGHT);
        with_digits(place, mix(self.digits()))
    }

    #[inline(always)]
    fn direction(&self) -> [f32; 2] {
        self.pair(DIRECTION)
    }

    #[inline(always)]
    fn side(&self) -> f32 {
        self.pair(SIDE)[0]
    }
}

/// The numbers of several paths, which are computed together, but for those that few surfaces have: loops over arrays, free of
/// branches.
pub struct NumberLanes<const W: usize> {
    pairs: [[[f32; W]; 2]; DIGITS as usize],
    digits: [u32; W],
    keys: [u32; W],
    samples: [u32; W],
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
        let mut lanes =
            NumberLanes { pairs: [[[0.0; W]; 2]; DIGITS as usize], digits: [0; W], keys, samples };
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
    /// [`Numbers::light`] of each.
    fn lights(&self) -> ([f64; W], [f32; W]);
    /// [`Numbers::fine_place`] of each.
    fn fine_places(&self) -> [f64; W];
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
    fn lights(&self) -> ([f64; W], [f32; W]) {
        let [first, place] = self.pairs[LIGHT as usize];
        let mut choice = [0.0; W];
        for lane in 0..W {
            choice[lane] = with_digits(first[lane], self.digits[lane]);
        }
        (choice, place)
    }

    #[inline(always)]
    fn fine_places(&self) -> [f64; W] {
        let mut places = [0.0; W];
        for lane in 0..W {
            places[lane] = with_digits(self.pairs[LIGHT as usize][1][lane], mix(self.digits[lane]));
        }
        places
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
    fn lights(&self) -> ([f64; 1], [f32; 1]) {
        let (choice, place) = self.light();
        ([choice], [place])
    }

    #[inline(always)]
    fn fine_places(&self) -> [f64; 1] {
        [self.fine_place()]
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
    fn light(&self) -> (f64, f32) {
        let [choice, place] = self.pair(LIGHT);
        (with_digits(choice, self.lanes.digits[self.lane]), place)
    }

    #[inline(always)]
    fn fine_place(&self) -> f64 {
        let [_, place] = self.pair(LIGHT);
        with_digits(place, mix(self.lanes.digits[self.lane]))
    }

    #[inline(always)]
    fn direction(&self) -> [f32; 2] {
        self.pair(DIRECTION)
    }

    #[inline(always)]
    fn side(&self) -> f32 {
        NumbersByKey { key: self.lanes.keys[self.lane], sample: self.lanes.samples[self.lane] }.side()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::integrator::RayKind;
    use crate::math::Vec3;
    use crate::ray::PrimitiveId;
    use crate::sampling::place_within;

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
            assert_eq!(one.light(), of_lane.light());
            assert_eq!(one.fine_place(), of_lane.fine_place());
            assert_eq!(one.direction(), of_lane.direction());
            assert_eq!(one.side(), of_lane.side());
            assert_eq!(place_within(one.light().0).to_bits(), one.pair(LIGHT)[0].to_bits());
            assert_eq!(place_within(one.fine_place()), one.light().1);
        }
    }
}
