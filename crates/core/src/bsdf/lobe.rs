//! Lobes: the ways in which a surface scatters light, a closed set.
//!
//! Each has its file, with three functions: `eval`, what it makes of light from a direction; `sample`, a direction in which light
//! may come; `pdf`, how densely `sample` gives a direction. Light and viewer are unit vectors that point away from the surface.

use super::{BlinnPhong, CosinePower, Delta, Lambert, Phong};
use crate::math::Vec3;
use crate::settings::LightingModel;

/// One way in which a surface scatters light. A lobe has no colour: what it gives is multiplied by that of the material.
#[derive(Clone, Copy, Debug)]
pub enum Lobe {
    /// Equally to all sides.
    Lambert(Lambert),
    /// A highlight about the mirrored viewer.
    Phong(Phong),
    /// A highlight about the normal, for the direction halfway between light and viewer.
    BlinnPhong(BlinnPhong),
    /// A glossy mirror or glossy glass: a power of the cosine about an axis.
    CosinePower(CosinePower),
    /// A sharp mirror or clear glass: one direction.
    Delta(Delta),
}

impl Lobe {
    /// The highlight of a lighting model, if it has any; `normal` and `to_viewer` are unit vectors.
    #[inline(always)]
    pub fn highlight(model: LightingModel, normal: Vec3, to_viewer: Vec3, exponent: f32) -> Option<Lobe> {
        match model {
            LightingModel::Distance | LightingModel::Diffuse | LightingModel::Lambert => None,
            LightingModel::Phong => Some(Lobe::Phong(Phong { normal, to_viewer, exponent })),
            LightingModel::BlinnPhong => Some(Lobe::BlinnPhong(BlinnPhong { normal, to_viewer, exponent })),
        }
    }

    /// What reaches the viewer of light from the direction `to_light`, with the cosine of its incidence where the lobe has one. The
    /// unit is that of [`crate::light::Light`], whose colours are over pi: [`Lambert`] gives the cosine itself.
    #[inline(always)]
    pub fn eval(&self, to_light: Vec3) -> f32 {
        match self {
            Lobe::Lambert(lobe) => lobe.eval(to_light),
            Lobe::Phong(lobe) => lobe.eval(to_light),
            Lobe::BlinnPhong(lobe) => lobe.eval(to_light),
            Lobe::CosinePower(lobe) => lobe.eval(to_light),
            Lobe::Delta(lobe) => lobe.eval(to_light),
        }
    }

    /// A direction in which light may come, a unit vector, for a point of the unit square. It may lie under the surface.
    #[inline(always)]
    pub fn sample(&self, u: [f32; 2]) -> Vec3 {
        match self {
            Lobe::Lambert(lobe) => lobe.sample(u),
            Lobe::Phong(lobe) => lobe.sample(u),
            Lobe::BlinnPhong(lobe) => lobe.sample(u),
            Lobe::CosinePower(lobe) => lobe.sample(u),
            Lobe::Delta(lobe) => lobe.sample(u),
        }
    }

    /// How densely [`Lobe::sample`] gives the direction `to_light`, per steradian; 0 for a single direction, which has no density.
    #[inline(always)]
    pub fn pdf(&self, to_light: Vec3) -> f32 {
        match self {
            Lobe::Lambert(lobe) => lobe.pdf(to_light),
            Lobe::Phong(lobe) => lobe.pdf(to_light),
            Lobe::BlinnPhong(lobe) => lobe.pdf(to_light),
            Lobe::CosinePower(lobe) => lobe.pdf(to_light),
            Lobe::Delta(lobe) => lobe.pdf(to_light),
        }
    }

    /// Whether all its light comes from one direction: then light that is sampled brings nothing.
    #[inline(always)]
    pub fn is_delta(&self) -> bool {
        match self {
            Lobe::Lambert(_) | Lobe::Phong(_) | Lobe::BlinnPhong(_) | Lobe::CosinePower(_) => false,
            Lobe::Delta(_) => true,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::{elementary, sqrt, vec3};
    use crate::sampling::{mix, point_2d};

    fn lobes() -> [Lobe; 6] {
        let normal = vec3(0.6, 0.0, 0.8);
        let to_viewer = vec3(-0.28, 0.0, 0.96);
        [
            Lobe::Lambert(Lambert { normal }),
            Lobe::Phong(Phong { normal, to_viewer, exponent: 8.0 }),
            Lobe::BlinnPhong(BlinnPhong { normal, to_viewer, exponent: 12.0 }),
            Lobe::BlinnPhong(BlinnPhong { normal, to_viewer: normal, exponent: 0.5 }),
            Lobe::CosinePower(CosinePower { axis: normal, exponent: 20.0 }),
            Lobe::Delta(Delta { direction: normal }),
        ]
    }

    /// Uniform over the sphere.
    fn direction(i: u32) -> Vec3 {
        let part = |k: u32| mix(2 * i + k) as f32 / 2f32.powi(32);
        let z = 2.0 * part(0) - 1.0;
        let (s, c) = elementary::sin_cos(core::f32::consts::TAU * part(1));
        let radius = sqrt(1.0 - z * z);
        vec3(radius * c, radius * s, z)
    }

    /// The mean of a function over a lobe's samples is its integral over all directions times the density.
    #[test]
    fn samples_are_as_dense_as_is_said() {
        let functions: [fn(Vec3) -> f32; 4] =
            [|_| 1.0, |d| d.x, |d| d.y * d.y, |d| (d.z > 0.7) as u32 as f32];
        for lobe in lobes() {
            for (number, function) in functions.iter().enumerate() {
                const COUNT: u32 = 1 << 18;
                let over = |f: &dyn Fn(u32) -> f32| {
                    (0..COUNT).map(|i| f64::from(f(i))).sum::<f64>() / f64::from(COUNT)
                };
                let sampled = over(&|i| function(lobe.sample(point_2d(i, 5))));
                let integral = over(&|i| {
                    let d = direction(i);
                    function(d) * lobe.pdf(d)
                }) * 4.0
                    * core::f64::consts::PI;
                if lobe.is_delta() {
                    assert_eq!(integral, 0.0);
                } else {
                    assert!(
                        (sampled - integral).abs() < 0.02,
                        "{lobe:?}, function {number}: {sampled} and {integral}"
                    );
                }
            }
        }
    }

    #[test]
    fn known_values() {
        let (normal, exponent) = (vec3(0.0, 0.0, 1.0), 3.0);
        let (to_light, to_viewer) = (vec3(0.6, 0.0, 0.8), vec3(-0.6, 0.0, 0.8));
        let near = |a: f32, b: f32| assert!((a - b).abs() < 1e-6, "{a} {b}");
        near(Lobe::Lambert(Lambert { normal }).eval(to_light), 0.8);
        near(Lobe::Lambert(Lambert { normal }).eval(-to_light), 0.0);
        // The light stands where the viewer is mirrored to, and the halfway direction is the normal.
        near(Lobe::Phong(Phong { normal, to_viewer, exponent }).eval(to_light), 1.0);
        near(Lobe::BlinnPhong(BlinnPhong { normal, to_viewer, exponent }).eval(to_light), 1.0);
        near(Lobe::Phong(Phong { normal, to_viewer, exponent }).eval(normal), 0.8f32.powi(3));
        let lobe = Lobe::CosinePower(CosinePower { axis: normal, exponent });
        near(lobe.eval(to_light), 4.0 / core::f32::consts::TAU * 0.8f32.powi(3));
        assert_eq!(Lobe::Delta(Delta { direction: normal }).sample([0.3, 0.4]), normal);
    }
}
