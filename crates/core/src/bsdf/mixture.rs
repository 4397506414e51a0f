//! The lobes of a [`Closure`] towards one viewer, each with the probability that a path takes it.

use super::albedo::{white_albedo, white_glass_albedo, white_mean_albedo};
use super::closure::{Closure, ScatterSample, Scattered};
use super::eon::{Eon, even_part};
use super::ggx::Ggx;
use super::layer::Layer;
use super::matte::Matte;
use super::rough_base::RoughBase;
use super::schlick::Schlick;
use super::{Refracted, reflect, refract};
use crate::math::{Vec3, fma, max, min, vec3};
use crate::sampling::{cosine_direction, hemisphere_direction};

/// Four lobes: the base and what microfacets reflect more than once, both spread widely; mirror; glass.
pub struct Mixture {
    closure: Closure,
    to_viewer: Vec3,
    /// The base is all there is: other lobes are not looked at.
    is_matte: bool,
    ggx: Ggx,
    layer: Layer,
    metal: Layer,
    /// Base, over pi, with the part of the light that the layer lets out to the viewer, and normalised.
    base: Vec3,
    /// The base where it is rough.
    rough_base: RoughBase,
    /// What layer and metal reflect more than once, over pi, for a light whose [`Albedo::lost`](super::albedo::Albedo::lost) is 1.
    multiple: Vec3,
    /// A share of glass that makes up for light lost between its microfacets.
    glass: f32,
    /// What goes in the mirror's single direction, where mirrors are smooth.
    mirrored: Vec3,
    /// What goes through smooth glass.
    through: Vec3,
    chances: Chances,
}

/// Probabilities of the lobes, 1 in all.
struct Chances {
    base: f32,
    multiple: f32,
    mirror: f32,
    glass: f32,
}

impl Chances {
    /// A rough base is spread like what is reflected more than once, in part.
    #[inline(always)]
    fn spread_base(&mut self, roughness: f32, cos: f32) {
        let even = even_part(roughness, cos);
        self.multiple = fma(even, self.base, self.multiple);
        self.base *= 1.0 - even;
    }
}

impl Mixture {
    #[inline(always)]
    pub(super) fn new(closure: &Closure, to_viewer: Vec3) -> Mixture {
        let cos = to_viewer.z;
        if closure.is_matte() {
            return if closure.diffuse_roughness > 0.0 {
                Mixture::rough_matte(closure, to_viewer)
            } else {
                Mixture::matte(closure, to_viewer)
            };
        }
        let (is_smooth, is_glass_smooth) = (closure.is_smooth(), closure.is_glass_smooth());
        let (albedo, mean) = (white_albedo(cos, closure.alpha), white_mean_albedo(closure.alpha));
        let layer = Layer::new(closure.layer(), mean);
        let metal = Layer::new(closure.metal_layer(), mean);

        // Kelemen and Szirmay-Kalos 2001, "A microfacet based coupled specular-matte BRDF model": light enters and leaves the base
        // through the layer. What it holds back on average is made up for, as light that the layer returns to a white base is.
        let below = layer.lets_through(layer.albedo(albedo));
        let below_mean = layer.lets_through(layer.schlick.mean_albedo(mean, layer.multiple));
        let is_rough = closure.diffuse_roughness > 0.0;
        let (base, rough_base) = if is_rough {
            (Vec3::ZERO, RoughBase::new(closure, &layer, (mean, cos), below))
        } else {
            (closure.diffuse * below * reciprocal(below_mean, layer.schlick.share), RoughBase::NONE)
        };

        // Layer and metal apart: the mean of one colour for both would darken what is between metal and not.
        let multiple =
            (layer.multiple + metal.multiple) * (if mean.lost > 0.0 { albedo.lost / mean.lost } else { 0.0 });

        let single = layer.schlick.albedo(albedo, Vec3::ZERO) + metal.schlick.albedo(albedo, Vec3::ZERO);
        let (through, reflected_by_glass) = if is_glass_smooth && closure.glass > 0.0 {
            (closure.through(cos), closure.glass * closure.glass_reflectance(cos))
        } else {
            (Vec3::ZERO, 0.0)
        };
        let mirrored = if is_smooth { single + Vec3::splat(reflected_by_glass) } else { Vec3::ZERO };
        let glass = if is_glass_smooth {
            0.0
        } else if closure.is_thin || !(closure.glass > 0.0) {
            closure.glass / (1.0 - albedo.lost)
        } else {
            closure.glass / white_glass_albedo(cos, closure.alpha, closure.eta, albedo.lost)
        };

        let mut wish = Chances {
            base: (closure.diffuse * below).max_component() / max(layer.schlick.share, f32::MIN_POSITIVE),
            multiple: (layer.multiple + metal.multiple).max_component() * albedo.lost,
            mirror: if is_smooth { mirrored.max_component() } else { single.max_component() },
            glass: if is_glass_smooth { through.max_component() } else { closure.glass },
        };
        if is_rough {
            wish.spread_base(closure.diffuse_roughness, cos);
        }
        let sum = wish.base + wish.multiple + wish.mirror + wish.glass;
        let scale = if sum > 0.0 { 1.0 / sum } else { 0.0 };
        Mixture {
            closure: *closure,
            to_viewer,
            is_matte: false,
            ggx: Ggx { alpha: closure.alpha },
            layer,
            metal,
            base: base * core::f32::consts::FRAC_1_PI,
            rough_base,
            multiple: multiple * core::f32::consts::FRAC_1_PI,
            glass,
            mirrored,
            through,
            chances: Chances {
                base: wish.base * scale,
                multiple: wish.multiple * scale,
                mirror: wish.mirror * scale,
                glass: wish.glass * scale,
            },
        }
    }

    /// What [`Mixture::new`] gives where the base is alone, without looking at lobes that are not there: layers of nothing and no
    /// glass, which are 0 and let everything through.
    #[inline(always)]
    fn matte(closure: &Closure, to_viewer: Vec3) -> Mixture {
        let Matte { value, chance } = Matte::new(closure.diffuse);
        let layer = |share: f32| Layer {
            schlick: Schlick { f0: Vec3::ZERO, f90: Vec3::ZERO, share },
            multiple: Vec3::ZERO,
        };
        Mixture {
            closure: *closure,
            to_viewer,
            is_matte: true,
            ggx: Ggx { alpha: closure.alpha },
            layer: layer(1.0),
            metal: layer(0.0),
            base: value,
            rough_base: RoughBase::NONE,
            multiple: Vec3::ZERO,
            glass: 0.0,
            mirrored: Vec3::ZERO,
            through: Vec3::ZERO,
            chances: Chances { base: chance, multiple: 0.0, mirror: 0.0, glass: 0.0 },
        }
    }

    /// The same of a rough base.
    #[inline(always)]
    fn rough_matte(closure: &Closure, to_viewer: Vec3) -> Mixture {
        let mut mixture = Mixture::matte(closure, to_viewer);
        let eon = Eon::new(closure.diffuse, closure.diffuse_roughness, to_viewer);
        mixture.rough_base = RoughBase::bare(&eon);
        mixture.chances.spread_base(closure.diffuse_roughness, to_viewer.z);
        mixture
    }

    /// Whether light from behind the surface may be seen.
    #[inline(always)]
    pub fn has_glass(&self) -> bool {
        self.closure.glass > 0.0
    }

    /// As [`Closure::straight`], towards the viewer.
    #[inline(always)]
    pub fn straight(&self) -> Vec3 {
        self.closure.straight(self.to_viewer.z)
    }

    /// Light from `to_light` by all lobes but single directions.
    #[inline(always)]
    pub fn eval(&self, to_light: Vec3) -> Scattered {
        let cos = to_light.z;
        if cos > 0.0 {
            return self.reflected(to_light, cos);
        }
        if !(cos < 0.0 && self.glass > 0.0) {
            return Scattered::NOTHING;
        }
        let facets = if self.closure.is_thin {
            // A rough pane spreads what it transmits as it spreads what it reflects.
            self.ggx.reflection(self.to_viewer, vec3(to_light.x, to_light.y, -cos))
        } else {
            self.ggx.refraction(self.to_viewer, to_light, self.closure.eta)
        };
        let reflectance = self.closure.glass_reflectance(facets.cos);
        Scattered {
            value: self.closure.glass_tint * (self.glass * (1.0 - reflectance) * facets.value),
            pdf: self.chances.glass * (1.0 - self.reflection_chance(reflectance)) * facets.pdf,
        }
    }

    #[inline(always)]
    fn reflected(&self, to_light: Vec3, cos: f32) -> Scattered {
        let closure = &self.closure;
        let is_rough = closure.diffuse_roughness > 0.0;
        if self.is_matte {
            if is_rough {
                let chance = self.chances.base + self.chances.multiple;
                return self.rough_base.eon(closure.diffuse_roughness, self.to_viewer, chance).eval(to_light);
            }
            return Matte { value: self.base, chance: self.chances.base }.eval(cos);
        }
        let albedo = white_albedo(cos, closure.alpha);
        let through = self.layer.lets_through(self.layer.albedo(albedo));
        let base = if is_rough {
            self.rough_base.eval(closure, &self.layer, [self.to_viewer, to_light], through)
        } else {
            self.base * through
        };
        let wide = base.plus_scaled(self.multiple, albedo.lost) * cos;
        let wide_pdf =
            core::f32::consts::FRAC_1_PI * fma(self.chances.base, cos, 0.5 * self.chances.multiple);
        if closure.is_smooth() {
            return Scattered { value: wide, pdf: wide_pdf };
        }
        let facets = self.ggx.reflection(self.to_viewer, to_light);
        let mirror = self.layer.schlick.at(facets.cos) + self.metal.schlick.at(facets.cos);
        let of_glass = if self.glass > 0.0 { closure.glass_reflectance(facets.cos) } else { 0.0 };
        let chance = fma(self.chances.glass, self.reflection_chance(of_glass), self.chances.mirror);
        Scattered {
            value: wide.plus_scaled(mirror + Vec3::splat(self.glass * of_glass), facets.value),
            pdf: fma(chance, facets.pdf, wide_pdf),
        }
    }

    /// Probability that rough glass reflects where its microfacets have this reflectance.
    #[inline(always)]
    fn reflection_chance(&self, reflectance: f32) -> f32 {
        let transmitted = (1.0 - reflectance) * self.closure.glass_tint.max_component();
        if self.glass > 0.0 && reflectance > 0.0 { reflectance / (reflectance + transmitted) } else { 0.0 }
    }

    /// A direction in which light may come, by two numbers in [0, 1): the first one chooses a lobe, too, and is spread again over
    /// what chooses this. `side` gives another number, which is asked for where glass decides between its sides. `None` where the
    /// chosen microfacet would send light through the surface that it is part of, or nothing is scattered.
    #[inline(always)]
    pub fn sample(&self, u: [f32; 2], side: impl FnOnce() -> f32) -> Option<ScatterSample> {
        let chances = &self.chances;
        let pick = u[0];
        let after_base = chances.base;
        let after_multiple = after_base + chances.multiple;
        let after_mirror = after_multiple + chances.mirror;
        let within = |low: f32, chance: f32| [min((pick - low) / chance, LAST_NUMBER), u[1]];
        let to_light = if pick < after_base {
            cosine_direction(within(0.0, chances.base))
        } else if pick < after_multiple {
            // Evenly: lost light is spread more towards the horizon than the cosine, by which weights would be large there.
            hemisphere_direction(within(after_base, chances.multiple))
        } else if pick < after_mirror {
            if self.closure.is_smooth() {
                return single(mirror_image(self.to_viewer), self.mirrored, chances.mirror);
            }
            let u = within(after_multiple, chances.mirror);
            above(reflect(-self.to_viewer, self.ggx.sample_visible_normal(self.to_viewer, u)))
        } else if self.glass > 0.0 {
            self.sample_rough_glass(within(after_mirror, chances.glass), side())
        } else {
            return self.sample_smooth_glass();
        };
        let scattered = self.eval(to_light);
        if !(scattered.pdf > 0.0) {
            return None;
        }
        Some(ScatterSample {
            to_light,
            weight: scattered.value * (1.0 / scattered.pdf),
            pdf: scattered.pdf,
            is_delta: false,
            is_transmitted: to_light.z < 0.0,
            is_straight: false,
        })
    }

    /// `side`, in [0, 1), decides between reflection and transmission. A direction on the wrong side stands for nothing.
    #[inline(always)]
    fn sample_rough_glass(&self, u: [f32; 2], side: f32) -> Vec3 {
        let h = self.ggx.sample_visible_normal(self.to_viewer, u);
        let chance = self.reflection_chance(self.closure.glass_reflectance(self.to_viewer.dot(h)));
        let reflected = reflect(-self.to_viewer, h);
        if side < chance {
            return above(reflected);
        }
        if self.closure.is_thin {
            let d = above(reflected);
            return vec3(d.x, d.y, -d.z);
        }
        match refract(-self.to_viewer, h, 1.0 / self.closure.eta) {
            Refracted::Through(d) if d.z < 0.0 => d,
            _ => Vec3::ZERO,
        }
    }

    #[inline(always)]
    fn sample_smooth_glass(&self) -> Option<ScatterSample> {
        let to_light = if self.closure.is_thin || self.closure.is_clear() {
            -self.to_viewer
        } else {
            match refract(-self.to_viewer, vec3(0.0, 0.0, 1.0), 1.0 / self.closure.eta) {
                Refracted::Through(d) => d,
                Refracted::TotalReflection => return None,
            }
        };
        let sample = single(to_light, self.through, self.chances.glass)?;
        Some(ScatterSample { is_transmitted: true, is_straight: self.closure.is_straight(), ..sample })
    }
}

/// The largest number below 1.
const LAST_NUMBER: f32 = 1.0 - 1.0 / 16_777_216.0;

/// The direction, or nothing where it is not above the surface.
#[inline(always)]
fn above(d: Vec3) -> Vec3 {
    if d.z > 0.0 { d } else { Vec3::ZERO }
}

/// The viewer's direction, mirrored at the surface.
#[inline(always)]
fn mirror_image(to_viewer: Vec3) -> Vec3 {
    vec3(-to_viewer.x, -to_viewer.y, to_viewer.z)
}

/// All of a lobe's light from one direction; `chance` is the probability of the lobe.
#[inline(always)]
fn single(to_light: Vec3, value: Vec3, chance: f32) -> Option<ScatterSample> {
    if !(chance > 0.0) {
        return None;
    }
    let weight = value * (1.0 / chance);
    Some(ScatterSample {
        to_light,
        weight,
        pdf: 0.0,
        is_delta: true,
        is_transmitted: false,
        is_straight: false,
    })
}

/// `1 / (share * below)` per channel; 0 where the layer lets next to nothing through.
#[inline(always)]
fn reciprocal(below: Vec3, share: f32) -> Vec3 {
    let of = |below: f32| if below > 1e-5 * share { 1.0 / (below * share) } else { 0.0 };
    vec3(of(below.x), of(below.y), of(below.z))
}
