//! Stage 4: rays that go on from a surface point.

use super::lobe_light::lamps_shine_through;
use super::{LampLobe, depth_limit};
use crate::bsdf::{CosinePower, Lobe, Refracted, fresnel_factor, mirror_above, refract, through_surface};
use crate::integrator::camera_ray::pixel_key;
use crate::integrator::{PathRay, RayKind, is_worth_tracing};
use crate::material::{FresnelUse, Refraction};
use crate::math::{Vec3, Vec3Lanes, max};
use crate::sampling::{hash_pair, point_2d};
use crate::settings::Settings;
use crate::shading::{EvaluatedMaterial, SurfacePoint};
use crate::sums::MAX_RADIANCE;
use crate::view::SceneView;

/// Keys of the random numbers of lobes: about the mirrored ray, and about the transmitted one.
const GLOSSY_DIMENSION: u32 = 0x3;
const GLOSSY_TRANSMISSION_DIMENSION: u32 = 0x4;

/// Rays that go on from a surface after this many bounces: reflected ones first, then the transmitted ones.
#[inline(always)]
pub fn branch_count(material_values: &EvaluatedMaterial, depth: u32) -> u32 {
    reflected_rays(material_values, depth) + transmitted_rays(material_values, depth)
}

#[inline(always)]
fn reflected_rays(material_values: &EvaluatedMaterial, depth: u32) -> u32 {
    if material_values.reflects() { material_values.lobe_rays(depth).max(1) } else { 0 }
}

#[inline(always)]
fn transmitted_rays(material_values: &EvaluatedMaterial, depth: u32) -> u32 {
    if !material_values.transmits() {
        0
    } else if material_values.glossy_transmission {
        material_values.lobe_rays(depth).max(1)
    } else {
        1
    }
}

/// Where a surface point mirrors a ray to, and how much.
pub(super) struct Mirror {
    /// Unit vector.
    pub(super) direction: Vec3,
    /// Unit normal that it is mirrored at.
    normal: Vec3,
    /// Cosine of the angle between that and the ray.
    cos: f32,
    /// Index of refraction on this side over the index beyond.
    eta: f32,
    /// Fresnel's.
    factor: f32,
}

impl Mirror {
    /// For a ray of unit direction `d`.
    #[inline(always)]
    pub(super) fn new(settings: &Settings, point: &SurfacePoint, d: Vec3) -> Mirror {
        let material_values = &point.material_values;
        let (direction, normal) = mirror_above(d, point.normal, point.geometric_normal);
        let eta = if point.front { 1.0 / material_values.ior } else { material_values.ior };
        let cos = max(-d.dot(normal), 0.0);
        let is_ignored = material_values.fresnel == FresnelUse::Ignore;
        let factor = if is_ignored { 1.0 } else { fresnel_factor(settings.fresnel, cos, eta) };
        Mirror { direction, normal, cos, eta, factor }
    }
}

/// What is reflected.
#[inline(always)]
pub(super) fn reflected_share(material_values: &EvaluatedMaterial, mirror: &Mirror) -> Vec3 {
    let mut kr = material_values.reflection * mirror.factor;
    if material_values.metal > 0.0 {
        // Schlick's approximation for metal, whose colour fades to white at grazing angles.
        let m = 1.0 - mirror.cos;
        let m2 = m * m;
        kr += material_values
            .metal_color
            .plus_scaled(Vec3::splat(material_values.metal) - material_values.metal_color, m2 * m2 * m);
    }
    kr
}

/// Ray number `branch` (below [`branch_count`]) from a surface point that `parent` found, for sample `sample` of pixel
/// (x, y); `None` where it carries too little light or goes nowhere.
#[inline(always)]
pub fn child_ray(
    view: &SceneView,
    point: &SurfacePoint,
    parent: &PathRay,
    place: (u32, u32, u32),
    branch: u32,
) -> Option<PathRay> {
    Children::new(view, point, parent, place).ray(branch)
}

/// The rays that go on from a surface point that `parent` found, for sample `sample` of pixel (x, y).
pub struct Children<'a> {
    view: &'a SceneView<'a>,
    point: &'a SurfacePoint,
    parent: &'a PathRay,
    place: (u32, u32, u32),
    mirror: Mirror,
    /// How many are reflected; they come first.
    reflected: u32,
}

/// Some of the rays of a glossy reflection.
pub struct GlossyLanes<const W: usize> {
    /// Unit vectors.
    direction: Vec3Lanes<W>,
    /// As [`PathRay::lobe_density`].
    density: [f32; W],
}

impl<'a> Children<'a> {
    /// What they have in common.
    #[inline(always)]
    pub fn new(
        view: &'a SceneView<'a>,
        point: &'a SurfacePoint,
        parent: &'a PathRay,
        place: (u32, u32, u32),
    ) -> Children<'a> {
        let mirror = Mirror::new(view.settings, point, parent.direction);
        let reflected = reflected_rays(&point.material_values, parent.depth);
        Children { view, point, parent, place, mirror, reflected }
    }

    /// Ray number `branch`; `None` where it carries too little light or goes nowhere.
    #[inline(always)]
    pub fn ray(&self, branch: u32) -> Option<PathRay> {
        let Children { view, point, parent, .. } = *self;
        let (settings, material_values) = (view.settings, &point.material_values);
        let d = parent.direction;
        let Mirror { direction: mirror, normal: n, eta, factor, .. } = self.mirror;
        let mut spread = 1.0;
        let (mut density, mut travelled) = (0.0, 0.0);
        let (direction, share, kind, inside) = if branch < self.reflected {
            let kr = reflected_share(material_values, &self.mirror);
            let rays = material_values.lobe_rays(parent.depth);
            if rays == 0 {
                (mirror, kr, RayKind::Reflected, parent.inside)
            } else {
                let lobe = glossy_lobe(mirror, material_values);
                let direction = lobe.sample(self.random(GLOSSY_DIMENSION, rays, branch));
                // Rays of the lobe that go under the surface count as black.
                if direction.dot(point.geometric_normal) <= 0.0 {
                    return None;
                }
                spread = 1.0 / rays as f32;
                if self.meets_lamps() {
                    density = rays as f32 * lobe.pdf(direction);
                }
                (direction, kr, RayKind::Glossy, parent.inside)
            }
        } else {
            if (parent.lobe_density > 0.0) & lamps_shine_through(settings) {
                density = parent.lobe_density;
                travelled = parent.travelled + (point.position - parent.origin).length();
            }
            let passed = if material_values.fresnel == FresnelUse::Both { 1.0 - factor } else { 1.0 };
            let kt = material_values.transmission * passed;
            let beyond =
                if point.front { parent.inside.saturating_add(1) } else { parent.inside.saturating_sub(1) };
            let (direction, kind, inside) = match material_values.refraction {
                Refraction::Straight => (d, RayKind::Refracted, beyond),
                Refraction::Snell => match refract(d, n, eta) {
                    Refracted::Through(direction) => {
                        (through_surface(direction, point.geometric_normal), RayKind::Refracted, beyond)
                    }
                    // All of it is reflected. With Fresnel the share is 0: the reflected ray has it.
                    Refracted::TotalReflection => (mirror, RayKind::Reflected, parent.inside),
                },
            };
            let rays =
                if material_values.glossy_transmission { material_values.lobe_rays(parent.depth) } else { 0 };
            if rays > 0 {
                let lobe = glossy_lobe(direction, material_values);
                let random = self.random(GLOSSY_TRANSMISSION_DIMENSION, rays, branch - self.reflected);
                let spread_out = lobe.sample(random);
                // As above: what ends on the wrong side counts as black.
                if direction.dot(point.geometric_normal) * spread_out.dot(point.geometric_normal) <= 0.0 {
                    return None;
                }
                spread = 1.0 / rays as f32;
                (spread_out, kt, kind, inside)
            } else {
                (direction, kt, kind, inside)
            }
        };
        let weight = self.weight(share, spread)?;
        Some(PathRay {
            origin: point.offset_origin(direction),
            path: hash_pair(parent.path, branch + 1),
            direction,
            depth: parent.depth + 1,
            weight,
            kind,
            start: point.id,
            inside,
            holes: 0,
            travelled,
            lobe_density: density,
        })
    }

    /// How many rays there are of a glossy reflection; the first ones.
    #[inline(always)]
    pub fn glossy_rays(&self) -> u32 {
        let rays = self.point.material_values.lobe_rays(self.parent.depth);
        if rays == 0 { 0 } else { self.reflected }
    }

    /// What carries the rays of a glossy reflection, all of them alike; `None` where that is too little light.
    #[inline(always)]
    pub fn glossy_weight(&self) -> Option<Vec3> {
        let material_values = &self.point.material_values;
        let rays = material_values.lobe_rays(self.parent.depth);
        self.weight(reflected_share(material_values, &self.mirror), 1.0 / rays as f32)
    }

    /// Ways of the rays of a glossy reflection, of which there are some, from number `first` on: what is beyond the last one goes
    /// nowhere.
    #[inline(always)]
    pub fn glossy<const W: usize>(&self, first: u32) -> GlossyLanes<W> {
        let material_values = &self.point.material_values;
        let rays = material_values.lobe_rays(self.parent.depth);
        let lobe = cosine_power(self.mirror.direction, material_values);
        let mut lanes = GlossyLanes { direction: Vec3Lanes::ZERO, density: [0.0; W] };
        for lane in 0..W {
            let random = self.random(GLOSSY_DIMENSION, rays, first + lane as u32);
            lanes.direction.set(lane, lobe.sample(random));
        }
        if self.meets_lamps() {
            for lane in 0..W {
                lanes.density[lane] = rays as f32 * lobe.pdf(lanes.direction.get(lane));
            }
        }
        lanes
    }

    /// [`Children::ray`] number `branch` of a glossy reflection, whose way is in a lane, and that is carried by `weight`.
    #[inline(always)]
    pub fn glossy_ray<const W: usize>(
        &self,
        lanes: &GlossyLanes<W>,
        lane: usize,
        branch: u32,
        weight: Vec3,
    ) -> Option<PathRay> {
        let Children { point, parent, .. } = *self;
        let direction = lanes.direction.get(lane);
        if direction.dot(point.geometric_normal) <= 0.0 {
            return None;
        }
        Some(PathRay {
            origin: point.offset_origin(direction),
            path: hash_pair(parent.path, branch + 1),
            direction,
            depth: parent.depth + 1,
            weight,
            kind: RayKind::Glossy,
            start: point.id,
            inside: parent.inside,
            holes: 0,
            travelled: 0.0,
            lobe_density: lanes.density[lane],
        })
    }

    /// Random numbers of ray number `branch` of a lobe that so many rays are of.
    #[inline(always)]
    fn random(&self, dimension: u32, rays: u32, branch: u32) -> [f32; 2] {
        let (x, y, sample) = self.place;
        let point = hash_pair(pixel_key(self.view.settings.seed, x, y), self.parent.path);
        point_2d(sample.wrapping_mul(rays).wrapping_add(branch), hash_pair(point, dimension))
    }

    /// Whether samples of lamps are weighed against rays of the reflection.
    #[inline(always)]
    fn meets_lamps(&self) -> bool {
        LampLobe::new(self.view, self.point, self.parent, depth_limit(self.view.settings)).is_there()
    }

    /// What carries a ray that is one of `1 / spread`; `None` where that is too little light.
    #[inline(always)]
    fn weight(&self, share: Vec3, spread: f32) -> Option<Vec3> {
        // Limited, so that no product of large colours becomes infinite: infinity times 0 would be NaN.
        // A lobe lives or dies as a whole, however many rays it is spread over.
        let carried = (self.parent.weight * share).min(Vec3::splat(MAX_RADIANCE));
        is_worth_tracing(self.view, carried).then_some(carried * spread)
    }
}

/// How a glossy material spreads light about the unit direction of its mirror or its glass. Rays and samples of lamps both
/// ask here.
#[inline(always)]
pub(super) fn glossy_lobe(axis: Vec3, material_values: &EvaluatedMaterial) -> Lobe {
    Lobe::CosinePower(cosine_power(axis, material_values))
}

#[inline(always)]
fn cosine_power(axis: Vec3, material_values: &EvaluatedMaterial) -> CosinePower {
    CosinePower { axis, exponent: material_values.glossy_exponent }
}
