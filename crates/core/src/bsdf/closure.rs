//! How a surface point scatters light in path tracing: all lobes of a material together.
//!
//! Directions are unit vectors in a frame whose z is the shading normal, on the viewer's side.

use super::{Ggx, Refracted, fresnel_exact, refract};
use crate::math::{Vec3, max, vec3};
use crate::sampling::cosine_lobe;

/// Lobes of a material at a point. Its shares, `opaque`, `metal` and `glass`, add up to no more than 1.
#[derive(Clone, Copy, Debug)]
pub struct Closure {
    /// Share that is matte below a reflecting layer.
    pub opaque: f32,
    /// Albedo of the matte base.
    pub diffuse: Vec3,
    /// Reflectance of the layer at normal incidence.
    pub f0: Vec3,
    /// The same at grazing incidence (Schlick 1994).
    pub f90: Vec3,
    /// Share of metal.
    pub metal: f32,
    /// Its reflectance at normal incidence; at grazing incidence it is 1.
    pub metal_f0: Vec3,
    /// Share of clear glass.
    pub glass: f32,
    /// What light that it lets through is multiplied by.
    pub glass_tint: Vec3,
    /// Index of refraction beyond the surface over that on the viewer's side.
    pub eta: f32,
    /// The other side of the glass is close: light leaves it in the direction in which it came.
    pub is_thin: bool,
    /// Roughness of everything that reflects ([`Ggx::alpha`]); below [`SMOOTH`] it is a mirror.
    pub alpha: f32,
}

/// Below this roughness a surface reflects into one direction.
pub const SMOOTH: f32 = 1e-3;

/// An index of refraction that is as close to 1 as this bends nothing that can be seen.
const SAME_INDEX: f32 = 1e-3;

/// What lobes make of light from a direction.
#[derive(Clone, Copy, Debug)]
pub struct Scattered {
    /// Radiance towards the viewer over that from the direction and solid angle: with the cosine.
    pub value: Vec3,
    /// How densely [`Closure::sample`] gives the direction, per steradian.
    pub pdf: f32,
}

/// A direction in which light may come.
#[derive(Clone, Copy, Debug)]
pub struct ScatterSample {
    /// The direction.
    pub to_light: Vec3,
    /// What light from there is multiplied by: value over density.
    pub weight: Vec3,
    /// Density per steradian; 0 for a single direction.
    pub pdf: f32,
    /// It is a single direction, which has no density.
    pub is_delta: bool,
    /// It is on the other side of the surface.
    pub is_transmitted: bool,
    /// It goes on straight, as if the surface were not there.
    pub is_straight: bool,
}

const NOTHING: Scattered = Scattered { value: Vec3::ZERO, pdf: 0.0 };

/// Chances of the lobes, which add up to 1 unless all are 0.
struct Chances {
    diffuse: f32,
    reflected: f32,
    glass: f32,
}

/// Schlick's approximation.
#[inline(always)]
fn schlick(f0: Vec3, f90: Vec3, cos: f32) -> Vec3 {
    let m = max(1.0 - cos, 0.0);
    let m2 = m * m;
    f0.plus_scaled(f90 - f0, m2 * m2 * m)
}

impl Closure {
    /// Whether all it reflects goes into one direction.
    #[inline(always)]
    fn is_smooth(&self) -> bool {
        self.alpha < SMOOTH
    }

    /// Whether glass sends light into single directions.
    #[inline(always)]
    fn is_clear(&self) -> bool {
        self.is_smooth() | (!self.is_thin & ((self.eta - 1.0).abs() < SAME_INDEX))
    }

    /// What the layer and the metal reflect at a facet.
    #[inline(always)]
    fn reflectance(&self, cos: f32) -> Vec3 {
        let layer = schlick(self.f0, self.f90, cos) * self.opaque;
        layer + schlick(self.metal_f0, Vec3::ONE, cos) * self.metal
    }

    /// What of the light the layer lets through to the base.
    #[inline(always)]
    fn below_layer(&self, cos: f32) -> Vec3 {
        (Vec3::ONE - schlick(self.f0, self.f90, cos)).max(Vec3::ZERO)
    }

    /// What glass reflects at a facet; light goes to and fro in thin glass.
    #[inline(always)]
    fn glass_reflectance(&self, cos: f32) -> f32 {
        let f = fresnel_exact(cos, 1.0 / self.eta);
        if self.is_thin { 2.0 * f / (1.0 + f) } else { f }
    }

    #[inline(always)]
    fn chances(&self, to_viewer: Vec3) -> Chances {
        let diffuse = (self.diffuse * self.below_layer(to_viewer.z)).max_component() * self.opaque;
        let reflected = self.reflectance(to_viewer.z).max_component();
        let sum = diffuse + reflected + self.glass;
        let scale = if sum > 0.0 { 1.0 / sum } else { 0.0 };
        Chances { diffuse: diffuse * scale, reflected: reflected * scale, glass: self.glass * scale }
    }

    /// What all lobes but mirrors and clear glass make of light from a direction.
    #[inline(always)]
    pub fn eval(&self, to_viewer: Vec3, to_light: Vec3) -> Scattered {
        let chances = self.chances(to_viewer);
        if to_light.z > 0.0 {
            self.reflected(&chances, to_viewer, to_light)
        } else if to_light.z < 0.0 {
            self.transmitted(&chances, to_viewer, to_light)
        } else {
            NOTHING
        }
    }

    #[inline(always)]
    fn reflected(&self, chances: &Chances, to_viewer: Vec3, to_light: Vec3) -> Scattered {
        let cosine = to_light.z * core::f32::consts::FRAC_1_PI;
        let base = self.diffuse * self.below_layer(to_viewer.z) * self.below_layer(to_light.z);
        let mut scattered = Scattered { value: base * (self.opaque * cosine), pdf: chances.diffuse * cosine };
        if self.is_smooth() {
            return scattered;
        }
        let facets = Ggx { alpha: self.alpha };
        let half = (to_viewer + to_light).normalize_or(vec3(0.0, 0.0, 1.0));
        let cos = max(to_viewer.dot(half), 0.0);
        let density = facets.density(half) / (4.0 * to_viewer.z);
        let seen = density * facets.masking_shadowing(to_viewer.z, to_light.z);
        let sampled = density * facets.masking(to_viewer.z);
        scattered.value += self.reflectance(cos) * seen;
        scattered.pdf += chances.reflected * sampled;
        if (self.glass > 0.0) & !self.is_clear() {
            let f = self.glass_reflectance(cos);
            scattered.value += Vec3::splat(self.glass * f * seen);
            scattered.pdf += chances.glass * f * sampled;
        }
        scattered
    }

    #[inline(always)]
    fn transmitted(&self, chances: &Chances, to_viewer: Vec3, to_light: Vec3) -> Scattered {
        if !(self.glass > 0.0) | self.is_clear() {
            return NOTHING;
        }
        let facets = Ggx { alpha: self.alpha };
        let masking = facets.masking(to_viewer.z);
        let both = facets.masking_shadowing(to_viewer.z, to_light.z.abs());
        let (seen, f);
        if self.is_thin {
            let mirrored = vec3(to_light.x, to_light.y, -to_light.z);
            let half = (to_viewer + mirrored).normalize_or(vec3(0.0, 0.0, 1.0));
            f = self.glass_reflectance(max(to_viewer.dot(half), 0.0));
            seen = facets.density(half) / (4.0 * to_viewer.z);
        } else {
            let sum = to_viewer + to_light * self.eta;
            let half = (if sum.z < 0.0 { -sum } else { sum }).normalize_or(vec3(0.0, 0.0, 1.0));
            let (cos_viewer, cos_light) = (to_viewer.dot(half), to_light.dot(half));
            // Both on their side of the facet.
            if (cos_viewer <= 0.0) | (cos_light >= 0.0) {
                return NOTHING;
            }
            f = self.glass_reflectance(cos_viewer);
            let root = cos_light + cos_viewer / self.eta;
            let squared = root * root;
            let per_half = if squared > 0.0 { cos_light.abs() / squared } else { 0.0 };
            seen = facets.density(half) * cos_viewer * per_half / to_viewer.z;
        }
        Scattered {
            value: self.glass_tint * (self.glass * (1.0 - f) * seen * both),
            pdf: chances.glass * (1.0 - f) * seen * masking,
        }
    }

    /// What goes straight through, per channel, seen at this cosine: smooth thin glass alone.
    #[inline(always)]
    pub fn straight(&self, cos: f32) -> Vec3 {
        if self.is_thin & (self.glass > 0.0) & self.is_smooth() {
            self.glass_tint * (self.glass * (1.0 - self.glass_reflectance(cos)))
        } else {
            Vec3::ZERO
        }
    }

    /// A direction in which light may come: `pick` chooses the lobe and `u` the direction, all of [0, 1). `None` where that goes
    /// nowhere.
    #[inline(always)]
    pub fn sample(&self, to_viewer: Vec3, pick: f32, u: [f32; 2]) -> Option<ScatterSample> {
        let chances = self.chances(to_viewer);
        let facet = if self.is_smooth() {
            vec3(0.0, 0.0, 1.0)
        } else {
            Ggx { alpha: self.alpha }.visible_normal(to_viewer, u)
        };
        let cos = to_viewer.dot(facet);
        let mirrored = (-to_viewer).plus_scaled(facet, 2.0 * cos);
        let first_glass = chances.diffuse + chances.reflected;
        let mut single = self.is_smooth();
        let (mut to_light, mut weight) = (mirrored, Vec3::ZERO);
        let (mut is_transmitted, mut is_straight) = (false, false);
        if pick < chances.diffuse {
            to_light = cosine_lobe(1.0, u);
            single = false;
        } else if (pick < first_glass) | !(chances.glass > 0.0) {
            weight = self.reflectance(to_viewer.z) * (1.0 / max(chances.reflected, f32::MIN_POSITIVE));
        } else {
            single = self.is_clear();
            let facet = if single { vec3(0.0, 0.0, 1.0) } else { facet };
            let cos = to_viewer.dot(facet);
            let f = self.glass_reflectance(max(cos, 0.0));
            let share = self.glass / chances.glass;
            if pick - first_glass < f * chances.glass {
                to_light = (-to_viewer).plus_scaled(facet, 2.0 * cos);
                weight = Vec3::splat(share);
            } else {
                is_transmitted = true;
                weight = self.glass_tint * share;
                if self.is_thin {
                    is_straight = single;
                    to_light = (-to_viewer).plus_scaled(facet, 2.0 * cos);
                    to_light.z = -to_light.z;
                } else {
                    match refract(-to_viewer, facet, 1.0 / self.eta) {
                        Refracted::Through(direction) => to_light = direction,
                        Refracted::TotalReflection => return None,
                    }
                }
            }
        }
        // A facet may send light to the wrong side of the surface: it is lost there.
        if (to_light.z > 0.0) == is_transmitted {
            return None;
        }
        if single {
            return Some(ScatterSample {
                to_light,
                weight,
                pdf: 0.0,
                is_delta: true,
                is_transmitted,
                is_straight,
            });
        }
        let Scattered { value, pdf } = self.eval(to_viewer, to_light);
        if !(pdf > 0.0) {
            return None;
        }
        let weight = value * (1.0 / pdf);
        Some(ScatterSample { to_light, weight, pdf, is_delta: false, is_transmitted, is_straight })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::{elementary, sqrt};
    use crate::sampling::{mix, point_2d};

    const BLACK: Closure = Closure {
        opaque: 0.0,
        diffuse: Vec3::ZERO,
        f0: Vec3::ZERO,
        f90: Vec3::ZERO,
        metal: 0.0,
        metal_f0: Vec3::ZERO,
        glass: 0.0,
        glass_tint: Vec3::ONE,
        eta: 1.5,
        is_thin: false,
        alpha: 0.0,
    };

    fn viewer(cos: f32) -> Vec3 {
        vec3(sqrt(1.0 - cos * cos), 0.0, cos)
    }

    /// White things of every kind, at some roughness.
    fn white(alpha: f32) -> Vec<(&'static str, Closure)> {
        let layer = |opaque, diffuse| Closure {
            opaque,
            diffuse: Vec3::splat(diffuse),
            f0: Vec3::splat(0.04),
            f90: Vec3::ONE,
            alpha,
            ..BLACK
        };
        let metal = |metal| Closure { metal, metal_f0: Vec3::ONE, ..layer(1.0 - metal, 1.0) };
        let glass = |eta, is_thin| Closure { glass: 1.0, eta, is_thin, alpha, ..BLACK };
        let matte = Closure { f0: Vec3::ZERO, f90: Vec3::ZERO, ..layer(1.0, 1.0) };
        vec![
            ("matte", matte),
            ("layer", layer(1.0, 0.0)),
            ("layer over white", layer(1.0, 1.0)),
            ("half metal", metal(0.5)),
            ("metal", metal(1.0)),
            ("glass", glass(1.5, false)),
            ("from within glass", glass(1.0 / 1.5, false)),
            ("diamond", glass(2.4, false)),
            ("pane", glass(1.5, true)),
            ("no glass", glass(1.0, false)),
            ("half glass", Closure { glass: 0.5, ..layer(0.5, 0.8) }),
        ]
    }

    /// The mean of the weights of samples is the albedo: no more than 1, and 1 where nothing is lost between facets.
    #[test]
    fn nothing_is_brighter_than_white() {
        for roughness in [0.0, 0.1, 0.3, 0.5, 1.0f32] {
            for (name, closure) in white(roughness * roughness) {
                for cos in [0.01, 0.2, 0.5, 0.9, 1.0] {
                    const COUNT: u32 = 1 << 14;
                    let to_viewer = viewer(cos);
                    let sum: f64 = (0..COUNT)
                        .filter_map(|i| closure.sample(to_viewer, point_2d(i, 7)[0], point_2d(i, 8)))
                        .map(|s| {
                            assert!(s.weight.is_finite() && s.weight.min_component() >= 0.0, "{name} {s:?}");
                            assert!((s.to_light.length() - 1.0).abs() < 1e-5, "{name} {s:?}");
                            f64::from(s.weight.x)
                        })
                        .sum();
                    let albedo = sum / f64::from(COUNT);
                    assert!(albedo < 1.002, "{name}, roughness {roughness}, {cos}: {albedo}");
                    let is_lossless = name == "matte"
                        || roughness == 0.0 && !name.contains("layer") && !name.contains("half")
                        || name == "no glass";
                    assert!(!is_lossless || albedo > 0.998, "{name}, {roughness}, {cos}: {albedo}");
                }
            }
        }
    }

    /// Uniform over the sphere.
    fn direction(i: u32) -> Vec3 {
        let [a, b] = point_2d(i, 77);
        let z = 2.0 * a - 1.0;
        let (s, c) = elementary::sin_cos(core::f32::consts::TAU * b);
        let radius = sqrt(1.0 - z * z);
        vec3(radius * c, radius * s, z)
    }

    /// Densities say how often samples come into each part of the sphere, and weights are value over density.
    #[test]
    fn samples_are_as_dense_as_is_said() {
        const COUNT: u32 = 1 << 19;
        for alpha in [0.2, 0.5, 1.0] {
            for (name, closure) in white(alpha) {
                for cos in [0.3, 0.8] {
                    let to_viewer = viewer(cos);
                    // Boxes of the sphere: 6 of z by 4 around.
                    let part = |d: Vec3| {
                        let around = (d.x > 0.0) as usize + 2 * (d.y > 0.0) as usize;
                        ((d.z * 3.0 + 3.0) as usize).min(5) * 4 + around
                    };
                    let (mut sampled, mut said) = ([0f64; 24], [0f64; 24]);
                    let (mut value, mut light) = (0f64, 0f64);
                    for i in 0..COUNT {
                        if let Some(s) = closure.sample(to_viewer, point_2d(i, 3)[0], point_2d(i, 4))
                            && !s.is_delta
                        {
                            sampled[part(s.to_light)] += 1.0 / f64::from(COUNT);
                            light += f64::from(s.weight.x) / f64::from(COUNT);
                        }
                        let d = direction(i);
                        let there = closure.eval(to_viewer, d);
                        assert!(there.pdf.is_finite() && there.value.is_finite() && there.pdf >= 0.0);
                        let area = 4.0 * core::f64::consts::PI / f64::from(COUNT);
                        said[part(d)] += f64::from(there.pdf) * area;
                        value += f64::from(there.value.x) * area;
                    }
                    for k in 0..24 {
                        let (a, b) = (sampled[k], said[k]);
                        assert!((a - b).abs() < 4e-3, "{name}, {alpha}, {cos}, part {k}: {a} {b}");
                    }
                    assert!((value - light).abs() < 5e-3, "{name}, {alpha}, {cos}: {value} {light}");
                }
            }
        }
    }

    /// Light goes the same way in both directions.
    #[test]
    fn what_reflects_is_reciprocal() {
        for (name, closure) in white(0.3).into_iter().take(5) {
            for i in 0..1000 {
                let (mut a, mut b) = (direction(mix(i) >> 8), direction(mix(i + 9999) >> 8));
                (a.z, b.z) = (a.z.abs().max(1e-3), b.z.abs().max(1e-3));
                let (there, back) = (closure.eval(a, b).value.x / b.z, closure.eval(b, a).value.x / a.z);
                assert!((there - back).abs() <= 2e-5 * there.max(1e-3), "{name}: {there} {back}");
            }
        }
    }

    /// Whatever the numbers are, nothing is lost to what is no number.
    #[test]
    fn samples_are_finite_for_all_parameters() {
        let part = |i: u32, k: u32| mix(i.wrapping_mul(31).wrapping_add(k)) as f32 / 4_294_967_296.0;
        for i in 0..200_000 {
            let color = |k| vec3(part(i, k), part(i, k + 1), part(i, k + 2));
            let edge = |k: u32| [0.0, 1.0, part(i, k), part(i, k)][(mix(i + k) & 3) as usize];
            let metal = edge(1);
            let glass = (1.0 - metal) * edge(2);
            let closure = Closure {
                opaque: 1.0 - metal - glass,
                diffuse: color(3),
                f0: color(6),
                f90: Vec3::ONE,
                metal,
                metal_f0: color(9),
                glass,
                glass_tint: color(12),
                eta: [1.0, 1.5, 1.0 / 1.5, 0.4 + 2.1 * part(i, 15)][(mix(i + 15) & 3) as usize],
                is_thin: i & 1 == 1,
                alpha: edge(16),
            };
            let to_viewer = viewer([1.0, 1e-4, part(i, 17).max(1e-6)][(mix(i + 17) % 3) as usize]);
            if let Some(s) = closure.sample(to_viewer, part(i, 18), [part(i, 19), part(i, 20)]) {
                assert!(s.weight.is_finite() && s.weight.min_component() >= 0.0, "{closure:?} {s:?}");
                assert!(s.pdf.is_finite() && s.to_light.is_finite(), "{closure:?} {s:?}");
            }
        }
    }
}
