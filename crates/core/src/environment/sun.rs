//! The disk of a sun: directions to it, evenly spread over it as it is seen.

use super::Environment;
use crate::math::{Vec3, fma, max, sqrt};
use crate::sampling::{disk_point, orthonormal_basis};
use core::f32::consts::PI;

impl Environment {
    /// A direction to the disk, a unit vector of the picture's frame, for a point of the unit square.
    #[inline(always)]
    pub(super) fn sample_sun(&self, u: [f32; 2]) -> Vec3 {
        let [a, b] = disk_point(u).map(|x| x * self.sun_radius);
        let (x, y) = orthonormal_basis(self.to_sun);
        let along = sqrt(max(1.0 - fma(a, a, b * b), 0.0));
        (self.to_sun * along).plus_scaled(x, a).plus_scaled(y, b).normalize_or(self.to_sun)
    }

    /// How densely [`Environment::sample_sun`] gives a direction of the picture's frame, per steradian; 0 beside the disk.
    #[inline(always)]
    pub(super) fn sun_density(&self, direction: Vec3) -> f32 {
        let cos = direction.dot(self.to_sun);
        // The sine: the cosine of a small angle has no digits left.
        let across = direction.cross(self.to_sun).length_squared();
        let radius_squared = self.sun_radius * self.sun_radius;
        // Even over the disk's image on a plane that faces it.
        if (cos > 0.0) & (across <= radius_squared) { cos / (PI * radius_squared) } else { 0.0 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::vec3;
    use crate::sampling::point_2d;

    /// Samples have the density that is said, and the mean of one over it is the disk's solid angle.
    #[test]
    fn directions_are_as_dense_as_is_said() {
        for radius in [0.005f32, 0.3] {
            let to_sun = vec3(0.6, 0.48, -0.64);
            let sun = Environment { to_sun, sun_radius: radius, ..Environment::NOWHERE };
            let (count, mut angle) = (1 << 14, 0.0);
            for i in 0..count {
                let direction = sun.sample_sun(point_2d(i, 5));
                let density = sun.sun_density(direction);
                assert!(density > 0.0 || direction.cross(to_sun).length() > 0.9999 * radius);
                angle += if density > 0.0 { 1.0 / f64::from(density) } else { 0.0 };
            }
            let cos = (1.0 - f64::from(radius).powi(2)).sqrt();
            let expected = 2.0 * std::f64::consts::PI * f64::from(radius).powi(2) / (1.0 + cos);
            assert!((angle / f64::from(count) / expected - 1.0).abs() < 1e-3, "{radius}");
            assert_eq!(sun.sun_density(-to_sun), 0.0);
        }
    }
}
