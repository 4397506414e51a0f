//! From the unit square to triangles, disks and lobes. All maps are continuous and straight-line, so that
//! well-spread points stay well spread.

use crate::math::{Vec3, elementary, fma, sqrt, vec3};

/// Barycentric weights of the second and third vertex of a triangle, uniform by area; neither is negative and their
/// sum is at most one.
///
/// Heitz, "A low-distortion map between triangle and square", 2019: no square root, and neighbours stay neighbours.
#[inline(always)]
pub fn triangle_point(u: [f32; 2]) -> [f32; 2] {
    let (half_x, half_y) = (0.5 * u[0], 0.5 * u[1]);
    if u[1] > u[0] { [half_x, u[1] - half_x] } else { [u[0] - half_y, half_y] }
}

/// Signed radius of a concentric map of the square to the disk, and cosine and sine of its angle.
///
/// Shirley and Chiu, "A low distortion map between disk and square", 1997.
#[inline(always)]
fn concentric(u: [f32; 2]) -> (f32, [f32; 2]) {
    let (a, b) = (fma(2.0, u[0], -1.0), fma(2.0, u[1], -1.0));
    let wide = a.abs() > b.abs();
    let (radius, other) = if wide { (a, b) } else { (b, a) };
    let angle = other / (if radius == 0.0 { 1.0 } else { radius }) * core::f32::consts::FRAC_PI_4;
    let (s, c) = elementary::sin_cos(angle);
    // In the upper and lower quarters the angle is measured from the second axis.
    (radius, if wide { [c, s] } else { [s, c] })
}

/// A point of the unit disk, uniform by area.
#[inline(always)]
pub fn disk_point(u: [f32; 2]) -> [f32; 2] {
    let (radius, [c, s]) = concentric(u);
    [radius * c, radius * s]
}

/// A unit direction about +z with density `(n + 1) / (2 pi) * cos^n` for `exponent` n >= 0, z never negative.
///
/// n = 0 is uniform on the hemisphere, n = 1 the diffuse lobe (there this is Malley's method), larger n the lobe of
/// Phong's highlight (Lafortune and Willems 1994). Beyond about n = 100,000 the lobe is narrower than the rounding
/// of z resolves.
#[inline(always)]
pub fn cosine_lobe(exponent: f32, u: [f32; 2]) -> Vec3 {
    let (radius, [c, s]) = concentric(u);
    // The squared radius is uniform in [0, 1]: its distribution is inverted.
    let z = elementary::pow((1.0 - radius) * (1.0 + radius), 1.0 / (exponent + 1.0));
    // (1 - z) is exact for z >= 1/2. The sign of the radius picks the side of the axis.
    let sine = sqrt((1.0 - z) * (1.0 + z));
    let sine = if radius < 0.0 { -sine } else { sine };
    vec3(sine * c, sine * s, z)
}

/// A unit direction about +z with density `cos / pi`, z never negative: a point of the disk, raised (Malley's method).
#[inline(always)]
pub fn cosine_direction(u: [f32; 2]) -> Vec3 {
    let (radius, [c, s]) = concentric(u);
    vec3(radius * c, radius * s, sqrt((1.0 - radius) * (1.0 + radius)))
}

/// A unit direction about +z, uniform on the hemisphere, z never negative.
#[inline(always)]
pub fn hemisphere_direction(u: [f32; 2]) -> Vec3 {
    let (radius, [c, s]) = concentric(u);
    // The square of the sine is 1 - z^2.
    let z = (1.0 - radius) * (1.0 + radius);
    let sine = radius * sqrt(1.0 + z);
    vec3(sine * c, sine * s, z)
}

/// Two unit vectors that make a right-handed orthonormal frame `(first, second, n)` with `n` of unit length.
///
/// Duff et al., "Building an orthonormal basis, revisited", JCGT 6(1), 2017. The sign is taken by comparison, not
/// from the bit, because targets may differ in the sign of zero.
#[inline(always)]
pub fn orthonormal_basis(n: Vec3) -> (Vec3, Vec3) {
    let sign = if n.z < 0.0 { -1.0 } else { 1.0 };
    let a = -1.0 / (sign + n.z);
    let b = n.x * n.y * a;
    (vec3(fma(sign * n.x * n.x, a, 1.0), sign * b, -sign * n.x), vec3(b, fma(n.y * n.y, a, sign), -n.y))
}

/// A direction that was made about +z, turned so that it lies about the unit vector `axis`; of unit length.
#[inline(always)]
pub fn onto_axis(axis: Vec3, direction: Vec3) -> Vec3 {
    let (tangent, bitangent) = orthonormal_basis(axis);
    (axis * direction.z).plus_scaled(tangent, direction.x).plus_scaled(bitangent, direction.y).normalize()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampling::{mix, point_2d};

    /// Corners and edges of the square, then well-spread points.
    fn squares() -> impl Iterator<Item = [f32; 2]> {
        let ends = [0.0, f32::MIN_POSITIVE, 0.25, 0.5, 1.0 - f32::EPSILON / 2.0];
        let corners = ends.into_iter().flat_map(move |x| ends.map(|y| [x, y]));
        corners.chain((0..1 << 16).map(|i| point_2d(i, 3)))
    }

    /// Mean of `f` over well-spread points: exact to about 1e-4 for the smooth `f` used here.
    fn mean(f: impl Fn([f32; 2]) -> f32) -> f64 {
        (0..1 << 16).map(|i| f(point_2d(i, 17)) as f64).sum::<f64>() / 65536.0
    }

    fn assert_near(got: f64, want: f64) {
        assert!((got - want).abs() < 2e-4, "{got} instead of {want}");
    }

    #[test]
    fn triangle_points_are_inside_and_uniform() {
        for u in squares() {
            let [b1, b2] = triangle_point(u);
            assert!(b1 >= 0.0 && b2 >= 0.0 && b1 + b2 <= 1.0, "{u:?}");
        }
        // Moments of the uniform density on the triangle: 1/3, 1/6, 1/12; and an area by itself.
        assert_near(mean(|u| triangle_point(u)[0]), 1.0 / 3.0);
        assert_near(mean(|u| triangle_point(u)[1]), 1.0 / 3.0);
        assert_near(mean(|u| triangle_point(u)[0].powi(2)), 1.0 / 6.0);
        assert_near(mean(|u| triangle_point(u)[0] * triangle_point(u)[1]), 1.0 / 12.0);
        assert_near(mean(|u| (triangle_point(u)[0] < 0.25) as u32 as f32), 7.0 / 16.0);
    }

    #[test]
    fn disk_points_are_inside_and_uniform() {
        for u in squares() {
            let [x, y] = disk_point(u);
            assert!(x * x + y * y <= 1.0 + 2.0 * f32::EPSILON, "{u:?}");
        }
        assert_eq!(disk_point([0.5, 0.5]), [0.0, 0.0]);
        assert_near(mean(|u| disk_point(u)[0]), 0.0);
        assert_near(mean(|u| disk_point(u)[1]), 0.0);
        assert_near(mean(|u| disk_point(u)[0].powi(2)), 0.25);
        assert_near(mean(|u| disk_point(u)[1].powi(2)), 0.25);
        assert_near(mean(|u| disk_point(u)[0] * disk_point(u)[1]), 0.0);
        assert_near(mean(|u| disk_point(u)[0].powi(4)), 0.125);
    }

    #[test]
    fn lobes_have_their_moments() {
        for n in [0.0, 0.5, 1.0, 2.0, 20.0, 1000.0, 100_000.0] {
            for u in squares() {
                let d = cosine_lobe(n, u);
                assert!(d.z >= 0.0 && d.z <= 1.0 && (d.length_squared() - 1.0).abs() < 1e-6, "{n} {u:?}");
            }
            let m = n as f64;
            assert_near(mean(|u| cosine_lobe(n, u).z), (m + 1.0) / (m + 2.0));
            assert_near(mean(|u| cosine_lobe(n, u).z.powi(2)), (m + 1.0) / (m + 3.0));
            // The relative width of a narrow lobe, which moments of z near one do not show.
            assert_near(mean(|u| 1.0 - cosine_lobe(n, u).z) * (m + 2.0), 1.0);
            assert_near(mean(|u| cosine_lobe(n, u).x), 0.0);
            assert_near(mean(|u| cosine_lobe(n, u).x.powi(2)), 1.0 / (m + 3.0));
            assert_near(mean(|u| cosine_lobe(n, u).x * cosine_lobe(n, u).y), 0.0);
        }
    }

    #[test]
    fn directions_are_those_of_lobes_of_their_exponents() {
        for (direction, exponent) in
            [(hemisphere_direction as fn([f32; 2]) -> Vec3, 0.0), (cosine_direction, 1.0)]
        {
            for u in squares() {
                let (d, lobe) = (direction(u), cosine_lobe(exponent, u));
                assert!(
                    d.z >= 0.0 && (d.length() - 1.0).abs() < 1e-6 && (d.z - lobe.z).abs() < 1e-6,
                    "{u:?}: {d:?}"
                );
                // The lobe's sine comes from its z, which about the axis has few digits of it.
                assert!((d - lobe).length() < 4e-4, "{u:?}: {d:?} {lobe:?}");
            }
        }
    }

    #[test]
    fn bases_are_orthonormal_and_right_handed() {
        let axes = [vec3(0.0, 0.0, 1.0), vec3(0.0, 0.0, -1.0), vec3(1.0, 0.0, -0.0), vec3(0.0, -1.0, 0.0)];
        let near_pole = vec3(1e-4, -1e-4, -1.0).normalize();
        let random = (0..10_000u32).map(|i| {
            let part = |k: u32| mix(i * 3 + k) as f32 / 2f32.powi(31) - 1.0;
            vec3(part(0), part(1), part(2)).normalize()
        });
        for n in axes.into_iter().chain([near_pole]).chain(random) {
            let (a, b) = orthonormal_basis(n);
            for error in [a.dot(b), a.dot(n), b.dot(n), a.length() - 1.0, b.length() - 1.0] {
                assert!(error.abs() < 1e-6, "{n:?}");
            }
            assert!((a.cross(b) - n).length() < 1e-6, "{n:?}");
        }
        assert_eq!(orthonormal_basis(vec3(1.0, 0.0, -0.0)), orthonormal_basis(vec3(1.0, 0.0, 0.0)));
    }
}
