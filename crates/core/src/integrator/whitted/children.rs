//! Stage 4: rays that go on from a surface point.

use super::lobe_light::lamps_shine_through;
use super::{LampLobe, depth_limit};
use crate::bsdf::{CosinePower, Lobe, Refracted, fresnel_factor, mirror_above, refract, through_surface};
use crate::integrator::camera_ray::pixel_key;
use crate::integrator::{PathRay, RayKind, is_worth_tracing};
use crate::material::{FresnelUse, Refraction};
use crate::math::{Vec3, max};
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
    (x, y, sample): (u32, u32, u32),
    branch: u32,
) -> Option<PathRay> {
    let (settings, material_values) = (view.settings, &point.material_values);
    let d = parent.direction;
    let at_mirror = Mirror::new(settings, point, d);
    let Mirror { direction: mirror, normal: n, eta, factor, .. } = at_mirror;
    let reflected = reflected_rays(material_values, parent.depth);
    let key = |dimension: u32| hash_pair(hash_pair(pixel_key(settings.seed, x, y), parent.path), dimension);
    let mut spread = 1.0;
    let (mut density, mut travelled) = (0.0, 0.0);
    let (direction, share, kind, inside) = if branch < reflected {
        let kr = reflected_share(material_values, &at_mirror);
        let rays = material_values.lobe_rays(parent.depth);
        if rays == 0 {
            (mirror, kr, RayKind::Reflected, parent.inside)
        } else {
            let lobe = glossy_lobe(mirror, material_values);
            let index = sample.wrapping_mul(rays).wrapping_add(branch);
            let direction = lobe.sample(point_2d(index, key(GLOSSY_DIMENSION)));
            // Rays of the lobe that go under the surface count as black.
            if direction.dot(point.geometric_normal) <= 0.0 {
                return None;
            }
            spread = 1.0 / rays as f32;
            if LampLobe::new(view, point, parent, depth_limit(settings)).is_there() {
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
            let index = sample.wrapping_mul(rays).wrapping_add(branch - reflected);
            let spread_out = lobe.sample(point_2d(index, key(GLOSSY_TRANSMISSION_DIMENSION)));
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
    // Limited, so that no product of large colours becomes infinite: infinity times 0 would be NaN.
    // A lobe lives or dies as a whole, however many rays it is spread over.
    let carried = (parent.weight * share).min(Vec3::splat(MAX_RADIANCE));
    is_worth_tracing(view, carried).then_some(PathRay {
        origin: point.offset_origin(direction),
        path: hash_pair(parent.path, branch + 1),
        direction,
        depth: parent.depth + 1,
        weight: carried * spread,
        kind,
        start: point.id,
        inside,
        holes: 0,
        travelled,
        lobe_density: density,
    })
}

/// How a glossy material spreads light about the unit direction of its mirror or its glass. Rays and samples of lamps both
/// ask here.
#[inline(always)]
pub(super) fn glossy_lobe(axis: Vec3, material_values: &EvaluatedMaterial) -> Lobe {
    Lobe::CosinePower(CosinePower { axis, exponent: material_values.glossy_exponent })
}
