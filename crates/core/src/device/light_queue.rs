//! Shadow rays of points between two kernels: what queues hold of them.

use super::path_queue::{Row, last, row, vector};
use crate::integrator::whitted::{LightProgress, LightSums};
use crate::math::Vec3;
use core::ptr::null_mut;

/// Rows of how far the light of a point is added up.
pub const PROGRESS_ROWS: usize = 3;

/// In place of a light: there is no ray.
pub const NO_LIGHT: u32 = u32::MAX;

/// In the number of a light: the ray starts from the second side.
const SECOND_SIDE: u32 = 1 << 31;

/// Shadow rays in a queue, as many of each point at a time as there is room for. Those of a group's points to one sample of a light
/// follow each other, sample after sample: in groups of one, all of a point do.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct LightQueue {
    /// Directions, and where rays end.
    pub directions: *mut Row,
    /// Which lights they go to, from which side ([`light_word`]).
    pub lights: *mut u32,
    /// What lights bring where nothing is in the way: diffuse and specular weight. Of what is hidden both become 0.
    pub weights: *mut [f32; 2],
    /// What gets through, per channel; null where shadows have no colour.
    pub through: *mut Row,
    /// How far light is added up: [`PROGRESS_ROWS`] arrays.
    pub progress: *mut Row,
    /// The first ray of each point that is traced.
    pub first: u32,
    /// How many of each point are traced together.
    pub window: u32,
    /// How many a point has at most.
    pub all: u32,
    /// A group has 2 to the power of so many points.
    pub group_bits: u32,
}

impl LightQueue {
    /// None: of paths.
    pub const NONE: LightQueue = LightQueue {
        directions: null_mut(),
        lights: null_mut(),
        weights: null_mut(),
        through: null_mut(),
        progress: null_mut(),
        first: 0,
        window: 0,
        all: 0,
        group_bits: 0,
    };

    /// How many rays there are of so many points: of full groups.
    #[inline(always)]
    pub fn rays(&self, points: u32) -> u32 {
        let last = (1u32 << self.group_bits).wrapping_sub(1);
        (points.wrapping_add(last) & !last).wrapping_mul(self.window)
    }

    /// Which ray a point's is, by its number among those of the point that are traced.
    #[inline(always)]
    pub fn ray(&self, point: u32, number: u32) -> u32 {
        let of_group = point & (1u32 << self.group_bits).wrapping_sub(1);
        let row = (point >> self.group_bits).wrapping_mul(self.window).wrapping_add(number);
        (row << self.group_bits) | of_group
    }

    /// The point that a ray is of, and its number among those of the point that are traced.
    #[inline(always)]
    pub fn point(&self, ray: u32) -> (u32, u32) {
        let of_group = ray & (1u32 << self.group_bits).wrapping_sub(1);
        let row = ray >> self.group_bits;
        let window = if self.window > 1 { self.window } else { 1 };
        let group = row / window;
        ((group << self.group_bits) | of_group, row.wrapping_sub(group.wrapping_mul(window)))
    }
}

/// A light's number with a side.
#[inline(always)]
pub fn light_word(light: u32, side: u32) -> u32 {
    light | if side == 0 { 0 } else { SECOND_SIDE }
}

/// Number and side that were put together as [`light_word`].
#[inline(always)]
pub fn light_of_word(word: u32) -> (u32, u32) {
    (word & !SECOND_SIDE, word >> 31)
}

/// Progress in rows.
#[inline(always)]
pub fn rows_of_progress(progress: &LightProgress) -> [Row; PROGRESS_ROWS] {
    let LightProgress { sum, got: LightSums { diffuse, specular }, light } = *progress;
    [row(sum, light.unwrap_or(NO_LIGHT)), row(diffuse, 0), row(specular, 0)]
}

/// What was written as [`rows_of_progress`].
#[inline(always)]
pub fn progress_of_rows([sum, diffuse, specular]: [Row; PROGRESS_ROWS]) -> LightProgress {
    let got = LightSums { diffuse: vector(diffuse), specular: vector(specular) };
    let light = last(sum);
    LightProgress { sum: vector(sum), got, light: if light == NO_LIGHT { None } else { Some(light) } }
}

/// A vector in a row, with a number.
#[inline(always)]
pub fn row_of_vector(v: Vec3, number: f32) -> Row {
    row(v, number.to_bits())
}

/// The vector of a row, and its number.
#[inline(always)]
pub fn vector_of_row(of: Row) -> (Vec3, f32) {
    (vector(of), f32::from_bits(of.0[3]))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::vec3;

    #[test]
    fn each_ray_of_each_point_has_a_place() {
        for (group_bits, window) in [(0, 1), (0, 7), (5, 1), (5, 7), (5, 100)] {
            let queue = LightQueue { window, group_bits, ..LightQueue::NONE };
            for points in [0, 1, 31, 32, 33, 70] {
                let rays = queue.rays(points);
                assert!(rays >= points * window && rays < (points + (1 << group_bits)) * window);
                let mut seen = vec![false; rays as usize];
                for (point, number) in (0..points).flat_map(|p| (0..window).map(move |n| (p, n))) {
                    let ray = queue.ray(point, number);
                    assert_eq!(queue.point(ray), (point, number));
                    assert!(!std::mem::replace(&mut seen[ray as usize], true));
                }
                // The others are of points that the last group lacks.
                let lacking = (0..rays).filter(|&ray| !seen[ray as usize]);
                assert!(lacking.map(|ray| queue.point(ray).0).all(|point| point >= points));
            }
        }
        let first = |group_bits| {
            let queue = LightQueue { window: 3, group_bits, ..LightQueue::NONE };
            [0, 1, 2, 31, 32].map(|ray| queue.point(ray))
        };
        assert_eq!(first(0), [(0, 0), (0, 1), (0, 2), (10, 1), (10, 2)]);
        assert_eq!(first(5), [(0, 0), (1, 0), (2, 0), (31, 0), (0, 1)]);
    }

    #[test]
    fn what_was_written_is_read() {
        for (light, side) in [(0, 0), (7, 1), ((1 << 31) - 2, 1)] {
            assert_eq!(light_of_word(light_word(light, side)), (light, side));
            assert_ne!(light_word(light, side), NO_LIGHT);
        }
        let got = LightSums { diffuse: vec3(1.0, 2.0, 3.0), specular: vec3(4.0, 5.0, 1e-40) };
        for light in [None, Some(0), Some(12)] {
            let progress = LightProgress { sum: vec3(6.0, 7.0, 8.0), got, light };
            let read = progress_of_rows(rows_of_progress(&progress));
            assert_eq!(format!("{read:?}"), format!("{progress:?}"));
        }
        let (v, number) = vector_of_row(row_of_vector(vec3(1.0, -0.0, 2.0), f32::INFINITY));
        assert_eq!((v.x, v.y.to_bits(), v.z, number), (1.0, 1 << 31, 2.0, f32::INFINITY));
    }
}
