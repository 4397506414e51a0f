//! A light, as the tree sees it.

use eosphor_core::light::Light;
use eosphor_core::math::Vec3;

/// A light, as the tree sees it.
#[derive(Clone, Copy)]
pub(super) struct Emitter {
    pub(super) number: u32,
    /// Its corners, as often as there are fewer than three.
    corners: [Vec3; 3],
    /// How far it reaches around them.
    radius: f64,
    /// Where it is on average.
    pub(super) place: [f64; 3],
    /// The mean of squared distances from there.
    pub(super) variance: f64,
    /// Along its normal, of the strongest light; four times that where it shines into all directions. Never 0.
    pub(super) power: f64,
    /// Unit vector, or 0.
    pub(super) normal: [f64; 3],
}

impl Emitter {
    /// `None` for lights that shine from infinitely far.
    pub(super) fn new(number: u32, light: &Light, texel_share: f64) -> Option<Emitter> {
        let brightness = |c: Vec3| f64::from(c.x) + f64::from(c.y) + f64::from(c.z);
        let at = |position: Vec3, power: f64, normal: [f64; 3]| Emitter {
            number,
            corners: [position; 3],
            radius: 0.0,
            place: double(position),
            variance: 0.0,
            power,
            normal,
        };
        match *light {
            Light::Triangle { v0, e1, e2, normal, area, color, is_two_sided, .. } => {
                let corners = [v0, v0 + e1, v0 + e2];
                let [a, b, c] = corners.map(double);
                let place = [0, 1, 2].map(|axis| (a[axis] + b[axis] + c[axis]) / 3.0);
                let squared = |p| dot(minus(p, place), minus(p, place));
                // A fourth of that of its corners.
                let variance = (squared(a) + squared(b) + squared(c)) / 12.0;
                let power = brightness(color) * texel_share * f64::from(area);
                // Cosines to both sides are a half on average, twice what all directions have.
                let (power, normal) =
                    if is_two_sided { (2.0 * power, [0.0; 3]) } else { (power, double(normal)) };
                Some(Emitter { number, corners, radius: 0.0, place, variance, power, normal })
            }
            Light::Sphere { center, radius, color, .. } => {
                let radius = f64::from(radius);
                let squared = radius * radius;
                // As seen from anywhere it is a disk.
                let power = 4.0 * brightness(color) * std::f64::consts::PI * squared;
                let at = at(center, power, [0.0; 3]);
                Some(Emitter { radius, variance: squared, ..at })
            }
            Light::Point { position, color } => Some(at(position, 4.0 * brightness(color), [0.0; 3])),
            Light::Spot { position, axis, color, cos_outer, .. } if cos_outer > 0.0 => {
                Some(at(position, brightness(color), double(axis)))
            }
            Light::Spot { position, color, .. } => Some(at(position, 4.0 * brightness(color), [0.0; 3])),
            Light::Directional { .. } => None,
        }
    }

    /// How far it reaches from a point.
    pub(super) fn reach(&self, from: [f64; 3]) -> f64 {
        let squared = |corner: Vec3| {
            let offset = minus(double(corner), from);
            dot(offset, offset)
        };
        self.corners.into_iter().map(squared).fold(0.0, f64::max).sqrt() + self.radius
    }
}

pub(super) fn double(v: Vec3) -> [f64; 3] {
    [v.x, v.y, v.z].map(f64::from)
}

pub(super) fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

pub(super) fn minus(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}
