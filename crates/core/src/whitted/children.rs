//! Stage 4: rays that go on from a surface point.

use super::camera_ray::pixel_key;
use super::{MAX_RADIANCE, PathRay, RayKind};
use crate::material::{FresnelUse, Material, Refraction};
use crate::math::{Vec3, max};
use crate::sampling::{cosine_lobe, hash_pair, orthonormal_basis, point_2d};
use crate::shading::{Refracted, SurfacePoint, fresnel_factor, reflect, refract};
use crate::view::SceneView;

/// Key of the random numbers of a glossy lobe.
const GLOSSY_DIMENSION: u32 = 0x3;

/// Rays that go on from a surface of this material: reflected ones first, then the transmitted one.
#[inline(always)]
pub fn branch_count(material: &Material) -> u32 {
    reflected_rays(material) + transmits(material) as u32
}

#[inline(always)]
fn reflected_rays(material: &Material) -> u32 {
    if material.reflection.max_component() > 0.0 { material.glossy_rays.max(1) } else { 0 }
}

#[inline(always)]
fn transmits(material: &Material) -> bool {
    material.transmission.max_component() > 0.0
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
    let (settings, material) = (view.settings, point.material);
    let d = parent.direction;
    let n = point.normal;
    // Index on this side over the index beyond.
    let eta = if point.front { 1.0 / material.ior } else { material.ior };
    let factor = if material.fresnel == FresnelUse::Ignore {
        1.0
    } else {
        fresnel_factor(settings.fresnel, max(-d.dot(n), 0.0), eta)
    };
    let reflected = reflected_rays(material);
    let mirror = mirror_direction(point, d);
    let mut spread = 1.0;
    let (direction, share, kind, inside) = if branch < reflected {
        let kr = material.reflection * factor;
        if material.glossy_rays == 0 {
            (mirror, kr, RayKind::Reflected, parent.inside)
        } else {
            let rays = material.glossy_rays;
            let seed = hash_pair(hash_pair(pixel_key(settings.seed, x, y), parent.path), GLOSSY_DIMENSION);
            let index = sample.wrapping_mul(rays).wrapping_add(branch);
            let local = cosine_lobe(material.glossy_exponent, point_2d(index, seed));
            let (tangent, bitangent) = orthonormal_basis(mirror);
            let direction = (mirror * local.z).along(tangent, local.x).along(bitangent, local.y).normalize();
            // Rays of the lobe that go under the surface count as black.
            if direction.dot(point.geometric_normal) <= 0.0 {
                return None;
            }
            spread = 1.0 / rays as f32;
            (direction, kr, RayKind::Glossy, parent.inside)
        }
    } else {
        let passed = if material.fresnel == FresnelUse::Both { 1.0 - factor } else { 1.0 };
        let kt = material.transmission * passed;
        let beyond =
            if point.front { parent.inside.saturating_add(1) } else { parent.inside.saturating_sub(1) };
        match material.refraction {
            Refraction::Straight => (d, kt, RayKind::Refracted, beyond),
            Refraction::Snell => match refract(d, n, eta) {
                Refracted::Through(direction) => {
                    // Interpolated normals can bend a ray back to where it came from: it goes straight on then.
                    let through = direction.dot(point.geometric_normal) < 0.0;
                    (if through { direction } else { d }, kt, RayKind::Refracted, beyond)
                }
                // All of it is reflected. With Fresnel the share is 0: the reflected ray has it.
                Refracted::TotalReflection => (mirror, kt, RayKind::Reflected, parent.inside),
            },
        }
    };
    // Limited, so that no product of large colours becomes infinite: infinity times 0 would be NaN.
    let limit = |weight: Vec3| weight.min(Vec3::splat(MAX_RADIANCE));
    // A lobe lives or dies as a whole, however many rays it is spread over.
    let carried = limit(parent.weight * share);
    let energy = carried.max_component();
    let alive = (energy > 0.0) & (energy >= settings.energy_threshold);
    alive.then_some(PathRay {
        origin: point.leave(direction),
        path: hash_pair(parent.path, branch + 1),
        direction,
        depth: parent.depth + 1,
        weight: carried * spread,
        kind,
        start: point.id,
        inside,
    })
}

/// The mirror direction, on the viewer's side of the surface: where the interpolated normal would send it below, it is
/// mirrored up again at the surface itself.
#[inline(always)]
fn mirror_direction(point: &SurfacePoint, d: Vec3) -> Vec3 {
    let mirrored = reflect(d, point.normal);
    let height = mirrored.dot(point.geometric_normal);
    let above = if height > 0.0 { mirrored } else { mirrored.along(point.geometric_normal, -2.0 * height) };
    above.normalize_or(-d)
}
