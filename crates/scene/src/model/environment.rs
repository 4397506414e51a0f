//! Light from infinitely far, in all directions: a picture of them.

use super::Sky;
use eosphor_core::math::{Vec3, elementary64};

/// A picture of all directions, from which light comes, or a sky that becomes one. Path tracing alone knows it.
///
/// The picture is equirectangular: its upper border is one direction, up, and its lower border the opposite one. With +y up, the
/// middle of the picture lies towards +x, and +z a fourth of its width right of that, as in Blender and three.js.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EnvironmentMap {
    /// What it shows.
    pub source: EnvironmentSource,
    /// The radiance is the picture's colour times this; 0 to 1e6.
    pub strength: f32,
    /// Turns the picture counter-clockwise, seen from above.
    pub rotation_degrees: f32,
    /// Where the picture's upper border is; any length but 0.
    pub up: Vec3,
    /// Whether cameras see it; where not, they see the background.
    pub is_seen: bool,
}

/// What an environment shows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum EnvironmentSource {
    /// A picture: index into [`super::Scene::images`].
    Image(u32),
    /// A clear sky. Its north is where a picture has -z.
    Sky(Sky),
}

impl EnvironmentMap {
    /// An image as it is, with +y up.
    pub fn of_image(image: u32) -> EnvironmentMap {
        EnvironmentMap::of_source(EnvironmentSource::Image(image))
    }

    /// A sky with +y up.
    pub fn of_sky(sky: Sky) -> EnvironmentMap {
        EnvironmentMap::of_source(EnvironmentSource::Sky(sky))
    }

    fn of_source(source: EnvironmentSource) -> EnvironmentMap {
        let up = Vec3 { x: 0.0, y: 1.0, z: 0.0 };
        EnvironmentMap { source, strength: 1.0, rotation_degrees: 0.0, up, is_seen: true }
    }

    /// Takes directions of the world into the picture's frame, whose y is up: rows of a rotation. Of an `up` that is not +y, the
    /// picture is turned the shortest way there, from -y about x.
    pub fn picture_from_world(&self) -> [Vec3; 3] {
        let [a, b, c] = [self.up.x, self.up.y, self.up.z].map(f64::from);
        let length = (a * a + b * b + c * c).sqrt();
        let [a, b, c] = if length > 0.0 { [a, b, c].map(|x| x / length) } else { [0.0, 1.0, 0.0] };
        let up = Vec3 { x: a as f32, y: b as f32, z: c as f32 };
        // Where +x and +z come to lie. 1 / (1 + b), with all digits where b is next to -1.
        let level = a * a + c * c;
        let k = if b > 0.0 { 1.0 / (1.0 + b) } else { (1.0 - b) / level };
        let (x, z) = if k.is_finite() {
            ([1.0 - a * a * k, -a, -a * c * k], [-a * c * k, -c, 1.0 - c * c * k])
        } else {
            ([1.0, 0.0, 0.0], [0.0, 0.0, -1.0])
        };
        let angle = f64::from(self.rotation_degrees % 360.0) * (std::f64::consts::PI / 180.0);
        let (sin, cos) = if angle == 0.0 { (0.0, 1.0) } else { elementary64::sin_cos(angle) };
        let turned = |p: f64, q: f64| {
            let at = |k: usize| (x[k] * p + z[k] * q) as f32;
            Vec3 { x: at(0), y: at(1), z: at(2) }
        };
        [turned(cos, -sin), up, turned(sin, cos)]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use eosphor_core::math::vec3;

    fn rows(up: Vec3, rotation_degrees: f32) -> [Vec3; 3] {
        EnvironmentMap { up, rotation_degrees, ..EnvironmentMap::of_image(0) }.picture_from_world()
    }

    #[test]
    fn up_is_up_and_rotations_turn_counter_clockwise_from_above() {
        let (x, y, z) = (vec3(1.0, 0.0, 0.0), vec3(0.0, 1.0, 0.0), vec3(0.0, 0.0, 1.0));
        assert_eq!(rows(y, 0.0), [x, y, z]);
        // As Blender has it: x stays, and the picture's z is -y.
        assert_eq!(rows(z, 0.0), [x, z, -y]);
        assert_eq!(rows(-y, 0.0), [x, -y, -z]);
        // What was towards +x goes towards -z, which is left of it.
        let turned = rows(y, 90.0);
        assert!((turned[0] - -z).length() < 1e-7 && (turned[2] - x).length() < 1e-7);
        for up in [vec3(1.0, 2.0, -3.0), vec3(0.1, -5.0, 0.01), -y] {
            let [a, b, c] = rows(up, 33.0);
            assert!((a.cross(b) - c).length() < 1e-6 && (b.cross(c) - a).length() < 1e-6);
            assert!((b - up.normalize()).length() < 1e-6);
        }
    }
}
