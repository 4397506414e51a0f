//! Random numbers of a path.

use crate::integrator::PathRay;
use crate::integrator::camera_ray::pixel_key;
use crate::sampling::{hash_pair, mix, point_2d, point_8d, points_8d, with_digits};
use crate::settings::Settings;

/// Keys of the numbers of vertices, which follow those of the camera ray.
const FIRST_BOUNCE: u32 = 0x1000;

/// Keys of the points of eight dimensions: of the first two bounces, of the two after them, and so on.
const FIRST_SET: u32 = 0x2000;

/// Decisions of a path at a surface that have numbers of their own: two of its arrival, the light of the first surface, what
/// follows the digits of a number that chooses a light, and one that few surfaces have.
const ARRIVAL: u32 = 0;
const FIRST_LIGHT: u32 = 1;
const DIGITS: u32 = 3;
const SIDE: u32 = 4;

/// The random numbers of a path where its ray has met a surface. They belong to the pixel, the bounces so far and the surfaces
/// passed since the last one, whatever else has happened: all samples of a pixel use the points of one well-spread sequence for one
/// decision, in the order of their numbers.
///
/// What is chosen first, a light or a lobe, takes a range of the first number of a pair; where in that range it lies is the first
/// coordinate of what is chosen then ([`place_within`](crate::sampling::place_within)). So the samples of each light and each lobe
/// are well spread, too: numbers of their own would leave to each a part of the points at random.
///
/// Where a path goes at two surfaces one after the other, and which lights are sampled at the surfaces that it gets to, are points
/// of eight dimensions: what a path brings depends on all of them, so they are spread together. At each bounce there is one
/// direction and one light, so their keys need not say which surfaces were passed.
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
    pixel_key: u32,
    /// Of the bounces so far and the surfaces passed.
    key: u32,
    depth: u32,
    sample: u32,
}

/// The points of eight dimensions that hold the light of a surface that a bounce led to, and whether it is the second one there.
#[inline(always)]
fn set_of_light(pixel_key: u32, depth: u32) -> (u32, bool) {
    (hash_pair(pixel_key, FIRST_SET + depth.wrapping_sub(1) / 2), depth.is_multiple_of(2))
}

/// The light of the first surface: of two dimensions, which are more even by themselves than later ones of eight.
#[inline(always)]
fn first_light(key: u32, sample: u32) -> [f32; 2] {
    point_2d(sample, hash_pair(key, FIRST_LIGHT))
}

/// The same of the direction in which a path goes on.
#[inline(always)]
fn set_of_direction(pixel_key: u32, depth: u32) -> (u32, bool) {
    (hash_pair(pixel_key, FIRST_SET + depth / 2), depth % 2 == 1)
}

impl NumbersByKey {
    /// For sample `sample` of pixel (x, y).
    #[inline(always)]
    pub fn new(settings: &Settings, ray: &PathRay, (x, y, sample): (u32, u32, u32)) -> NumbersByKey {
        NumbersByKey::of_pixel(pixel_key(settings.seed, x, y), [ray.depth, ray.holes], sample)
    }

    #[inline(always)]
    fn of_pixel(pixel_key: u32, [depth, holes]: [u32; 2], sample: u32) -> NumbersByKey {
        let key = hash_pair(hash_pair(pixel_key, FIRST_BOUNCE + depth), holes);
        NumbersByKey { pixel_key, key, depth, sample }
    }

    /// The first number of a light, of 24 bits, and its second one.
    #[inline(always)]
    fn light_pair(&self) -> [f32; 2] {
        if self.depth == 0 {
            return first_light(self.key, self.sample);
        }
        let (set, is_second) = set_of_light(self.pixel_key, self.depth);
        point_8d(self.sample, set, if is_second { 3 } else { 2 })
    }

    /// Further digits, at random, for trees of many lights.
    #[inline(always)]
    fn digits(&self) -> u32 {
        hash_pair(hash_pair(self.key, DIGITS), self.sample)
    }
}

#[inline(always)]
fn arrival(key: u32, sample: u32) -> [f32; 2] {
    point_2d(sample, hash_pair(key, ARRIVAL))
}

#[inline(always)]
fn side(key: u32, sample: u32) -> f32 {
    point_2d(sample, hash_pair(key, SIDE))[0]
}

impl Numbers for NumbersByKey {
    #[inline(always)]
    fn arrival(&self) -> [f32; 2] {
        arrival(self.key, self.sample)
    }

    #[inline(always)]
    fn light(&self) -> (f64, f32) {
        let [choice, place] = self.light_pair();
        (with_digits(choice, self.digits()), place)
    }

    #[inline(always)]
    fn fine_place(&self) -> f64 {
        let [_, place] = self.light_pair();
        with_digits(place, mix(self.digits()))
    }

    #[inline(always)]
    fn direction(&self) -> [f32; 2] {
        let (set, is_second) = set_of_direction(self.pixel_key, self.depth);
        point_8d(self.sample, set, u32::from(is_second))
    }

    #[inline(always)]
    fn side(&self) -> f32 {
        side(self.key, self.sample)
    }
}

/// The numbers of several paths. Those that every surface needs are computed together: loops over arrays, free of branches.
pub struct NumberLanes<const W: usize> {
    lights: [[f32; W]; 2],
    directions: [[f32; W]; 2],
    digits: [u32; W],
    keys: [u32; W],
    samples: [u32; W],
}

impl<const W: usize> NumberLanes<W> {
    /// Of several paths: `of(lane)` gives the key of the pixel ([`pixel_key`]), the sample and the ray. They are the numbers of
    /// [`NumbersByKey`].
    #[inline(always)]
    pub fn new<'a>(of: impl Fn(usize) -> (u32, u32, &'a PathRay)) -> NumberLanes<W> {
        let (mut pixel_keys, mut samples, mut places) = ([0; W], [0; W], [[0; W]; 2]);
        for lane in 0..W {
            let (pixel_key, sample, ray) = of(lane);
            (pixel_keys[lane], samples[lane]) = (pixel_key, sample);
            (places[0][lane], places[1][lane]) = (ray.depth, ray.holes);
        }
        let mut keys = [0; W];
        let mut digits = [0; W];
        for lane in 0..W {
            let place = [places[0][lane], places[1][lane]];
            let numbers = NumbersByKey::of_pixel(pixel_keys[lane], place, samples[lane]);
            keys[lane] = numbers.key;
            digits[lane] = numbers.digits();
        }
        let (mut sets, mut is_second) = ([0; W], [false; W]);
        for lane in 0..W {
            (sets[lane], is_second[lane]) = set_of_light(pixel_keys[lane], places[0][lane]);
        }
        let mut lights = points_8d(&samples, &sets, true, &is_second);
        if places[0].contains(&0) {
            for lane in 0..W {
                let [choice, place] = first_light(keys[lane], samples[lane]);
                let is_first = places[0][lane] == 0;
                lights[0][lane] = if is_first { choice } else { lights[0][lane] };
                lights[1][lane] = if is_first { place } else { lights[1][lane] };
            }
        }
        for lane in 0..W {
            (sets[lane], is_second[lane]) = set_of_direction(pixel_keys[lane], places[0][lane]);
        }
        let directions = points_8d(&samples, &sets, false, &is_second);
        NumberLanes { lights, directions, digits, keys, samples }
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
        let mut survival = [0.0; W];
        for lane in 0..W {
            let [_, number] = arrival(self.keys[lane], self.samples[lane]);
            survival[lane] = number;
        }
        survival
    }

    #[inline(always)]
    fn lights(&self) -> ([f64; W], [f32; W]) {
        let [first, place] = self.lights;
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
            places[lane] = with_digits(self.lights[1][lane], mix(self.digits[lane]));
        }
        places
    }

    #[inline(always)]
    fn directions(&self) -> [[f32; W]; 2] {
        self.directions
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

impl<const W: usize> Numbers for NumbersInLane<'_, W> {
    #[inline(always)]
    fn arrival(&self) -> [f32; 2] {
        arrival(self.lanes.keys[self.lane], self.lanes.samples[self.lane])
    }

    #[inline(always)]
    fn light(&self) -> (f64, f32) {
        let [choice, place] = self.lanes.lights.map(|number| number[self.lane]);
        (with_digits(choice, self.lanes.digits[self.lane]), place)
    }

    #[inline(always)]
    fn fine_place(&self) -> f64 {
        with_digits(self.lanes.lights[1][self.lane], mix(self.lanes.digits[self.lane]))
    }

    #[inline(always)]
    fn direction(&self) -> [f32; 2] {
        self.lanes.directions.map(|number| number[self.lane])
    }

    #[inline(always)]
    fn side(&self) -> f32 {
        side(self.lanes.keys[self.lane], self.lanes.samples[self.lane])
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
            assert_eq!(place_within(one.light().0).to_bits(), one.light_pair()[0].to_bits());
            assert_eq!(place_within(one.fine_place()), one.light().1);
        }
    }
}
