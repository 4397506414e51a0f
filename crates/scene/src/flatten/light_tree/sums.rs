//! What many lights are together.

use super::emitter::{Emitter, dot, minus};

/// Sums over lights by their power.
#[derive(Clone, Copy)]
pub(super) struct Sums {
    pub(super) count: usize,
    pub(super) power: f64,
    places: [f64; 3],
    squares: f64,
    normals: [f64; 3],
}

impl Sums {
    pub(super) const EMPTY: Sums =
        Sums { count: 0, power: 0.0, places: [0.0; 3], squares: 0.0, normals: [0.0; 3] };

    /// Of all of them, with places from `origin` on: one among them keeps the digits of small differences.
    pub(super) fn of(lights: &[Emitter], origin: [f64; 3]) -> Sums {
        lights.iter().fold(Sums::EMPTY, |sums, light| sums.and(&Sums::of_one(light, origin)))
    }

    pub(super) fn of_one(light: &Emitter, origin: [f64; 3]) -> Sums {
        let times = |v: [f64; 3]| v.map(|x| x * light.power);
        let place = minus(light.place, origin);
        Sums {
            count: 1,
            power: light.power,
            places: times(place),
            squares: light.power * (dot(place, place) + light.variance),
            normals: times(light.normal),
        }
    }

    pub(super) fn and(&self, other: &Sums) -> Sums {
        let add = |a: [f64; 3], b: [f64; 3]| [0, 1, 2].map(|axis| a[axis] + b[axis]);
        Sums {
            count: self.count + other.count,
            power: self.power + other.power,
            places: add(self.places, other.places),
            squares: self.squares + other.squares,
            normals: add(self.normals, other.normals),
        }
    }

    /// Their mean place, from the origin on.
    pub(super) fn center(&self) -> [f64; 3] {
        self.places.map(|x| x / self.power)
    }

    /// Their mean normal.
    pub(super) fn normal(&self) -> [f64; 3] {
        self.normals.map(|x| x / self.power)
    }

    /// The mean of their squared distances from the mean place.
    pub(super) fn variance(&self) -> f64 {
        let center = self.center();
        (self.squares / self.power - dot(center, center)).max(0.0)
    }

    /// How little is known of the lights when only their sums are: their power, by how far they are apart, by how much their
    /// directions differ. The latter is the solid angle that they shine into, from pi where all normals are one to 4 pi.
    pub(super) fn cost(&self) -> f64 {
        let mean = dot(self.normals, self.normals).sqrt() / self.power;
        self.power * self.variance() * (4.0 - 3.0 * mean.min(1.0))
    }
}
