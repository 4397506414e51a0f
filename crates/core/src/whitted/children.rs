//! Stage 4: rays that go on from a surface point.

use super::camera_ray::pixel_key;
use super::{MAX_RADIANCE, PathRay, RayKind};
use crate::material::{FresnelUse, Refraction};
use crate::math::{Vec3, max};
use crate::sampling::{cosine_lobe, hash_pair, orthonormal_basis, point_2d};
use crate::shading::{
    Appearance, Refracted, SurfacePoint, fresnel_factor, mirror_above, refract, through_surface,
};
use crate::view::SceneView;

/// Keys of the random numbers of lobes: about the mirrored ray, and about the transmitted one.
const GLOSSY_DIMENSION: u32 = 0x3;
const GLOSSY_TRANSMISSION_DIMENSION: u32 = 0x4;

/// Rays that go on from a surface after this many bounces: reflected ones first, then the transmitted ones.
#[inline(always)]
pub fn branch_count(look: &Appearance, depth: u32) -> u32 {
    reflected_rays(look, depth) + transmitted_rays(look, depth)
}

#[inline(always)]
fn reflected_rays(look: &Appearance, depth: u32) -> u32 {
    if look.reflects() { look.lobe_rays(depth).max(1) } else { 0 }
}

#[inline(always)]
fn transmitted_rays(look: &Appearance, depth: u32) -> u32 {
    if !look.transmits() {
        0
    } else if look.glossy_transmission {
        look.lobe_rays(depth).max(1)
    } else {
        1
    }
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
    let (settings, look) = (view.settings, &point.look);
    let d = parent.direction;
    let (mirror, n) = mirror_above(d, point.normal, point.geometric_normal);
    // Index on this side over the index beyond.
    let eta = if point.front { 1.0 / look.ior } else { look.ior };
    let cos = max(-d.dot(n), 0.0);
    let factor =
        if look.fresnel == FresnelUse::Ignore { 1.0 } else { fresnel_factor(settings.fresnel, cos, eta) };
    let reflected = reflected_rays(look, parent.depth);
    let key = |dimension: u32| hash_pair(hash_pair(pixel_key(settings.seed, x, y), parent.path), dimension);
    let mut spread = 1.0;
    let (direction, share, kind, inside) = if branch < reflected {
        let mut kr = look.reflection * factor;
        if look.metal > 0.0 {
            // Schlick's approximation for metal, whose colour fades to white at grazing angles.
            let m = 1.0 - cos;
            let m2 = m * m;
            kr += look.metal_color.along(Vec3::splat(look.metal) - look.metal_color, m2 * m2 * m);
        }
        let rays = look.lobe_rays(parent.depth);
        if rays == 0 {
            (mirror, kr, RayKind::Reflected, parent.inside)
        } else {
            let index = sample.wrapping_mul(rays).wrapping_add(branch);
            let direction = lobe_direction(mirror, look.glossy_exponent, index, key(GLOSSY_DIMENSION));
            // Rays of the lobe that go under the surface count as black.
            if direction.dot(point.geometric_normal) <= 0.0 {
                return None;
            }
            spread = 1.0 / rays as f32;
            (direction, kr, RayKind::Glossy, parent.inside)
        }
    } else {
        let passed = if look.fresnel == FresnelUse::Both { 1.0 - factor } else { 1.0 };
        let kt = look.transmission * passed;
        let beyond =
            if point.front { parent.inside.saturating_add(1) } else { parent.inside.saturating_sub(1) };
        let (direction, kind, inside) = match look.refraction {
            Refraction::Straight => (d, RayKind::Refracted, beyond),
            Refraction::Snell => match refract(d, n, eta) {
                Refracted::Through(direction) => {
                    (through_surface(direction, point.geometric_normal), RayKind::Refracted, beyond)
                }
                // All of it is reflected. With Fresnel the share is 0: the reflected ray has it.
                Refracted::TotalReflection => (mirror, RayKind::Reflected, parent.inside),
            },
        };
        let rays = if look.glossy_transmission { look.lobe_rays(parent.depth) } else { 0 };
        if rays > 0 {
            let index = sample.wrapping_mul(rays).wrapping_add(branch - reflected);
            let spread_out =
                lobe_direction(direction, look.glossy_exponent, index, key(GLOSSY_TRANSMISSION_DIMENSION));
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
    is_alive(view, carried).then_some(PathRay {
        origin: point.leave(direction),
        path: hash_pair(parent.path, branch + 1),
        direction,
        depth: parent.depth + 1,
        weight: carried * spread,
        kind,
        start: point.id,
        inside,
        holes: 0,
        travelled: 0.0,
    })
}

/// Whether a ray of this weight is worth tracing.
#[inline(always)]
pub(super) fn is_alive(view: &SceneView, weight: Vec3) -> bool {
    let energy = weight.max_component();
    (energy > 0.0) & (energy >= view.settings.energy_threshold)
}

/// A direction of the lobe `cos^exponent` about a unit vector.
#[inline(always)]
fn lobe_direction(axis: Vec3, exponent: f32, index: u32, key: u32) -> Vec3 {
    let local = cosine_lobe(exponent, point_2d(index, key));
    let (tangent, bitangent) = orthonormal_basis(axis);
    (axis * local.z).along(tangent, local.x).along(bitangent, local.y).normalize()
}
