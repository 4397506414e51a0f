//! The disk of a sun, as a picture has it, which blurs its edge: directions to it, denser in its middle.
//!
//! On a plane that faces the disk, where its edge is at radius 1, the density at radius r is `4 / pi (1 - r^2)^3`: with that
//! the light of a blurred disk over its density is nearly the same everywhere, and small where there is little.

use super::Environment;
use crate::math::{Vec3, fma, max, sqrt};
use crate::sampling::{disk_point, orthonormal_basis};
use core::f32::consts::PI;

impl Environment {
    /// A direction to the disk, a unit vector of the picture's frame, for a point of the unit square.
    #[inline(always)]
    pub(super) fn sample_sun(&self, u: [f32; 2]) -> Vec3 {
        let point = disk_point(u);
        // The share of even points within a radius is its square, of these `1 - (1 - r^2)^4`.
        let within = fma(point[0], point[0], point[1] * point[1]);
        let squared = 1.0 - sqrt(sqrt(max(1.0 - within, 0.0)));
        let scale = self.sun_radius * if within > 0.0 { sqrt(squared / within) } else { 0.0 };
        let [a, b] = [point[0] * scale, point[1] * scale];
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
        let rest = 1.0 - across / radius_squared;
        let even = cos / (PI * radius_squared);
        if (cos > 0.0) & (rest > 0.0) { 4.0 * (rest * rest * rest) * even } else { 0.0 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::vec3;
    use crate::sampling::point_2d;

    /// Samples have the density that is said: the mean of what is even on the plane over it is the disk's area there.
    #[test]
    fn directions_are_as_dense_as_is_said() {
        for radius in [0.005f32, 0.3] {
            let to_sun = vec3(0.6, 0.48, -0.64);
            let sun = Environment { to_sun, sun_radius: radius, ..Environment::NOWHERE };
            let (count, mut area) = (1 << 14, 0.0);
            for i in 0..count {
                let direction = sun.sample_sun(point_2d(i, 5));
                let density = sun.sun_density(direction);
                assert!(density > 0.0 || direction.cross(to_sun).length() > 0.999 * radius);
                // With the cube of the rest as a weight, so that the sum converges.
                let across = f64::from(direction.cross(to_sun).length_squared());
                let weight = (1.0 - across / f64::from(radius).powi(2)).max(0.0).powi(3);
                let cos = f64::from(direction.dot(to_sun));
                area += if density > 0.0 { weight * cos / f64::from(density) } else { 0.0 };
            }
            let expected = std::f64::consts::PI * f64::from(radius).powi(2) / 4.0;
            assert!((area / f64::from(count) / expected - 1.0).abs() < 1e-3, "{radius}");
            assert_eq!(sun.sun_density(-to_sun), 0.0);
        }
    }
}
