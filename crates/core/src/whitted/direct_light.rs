//! Stage 3: light that reaches a surface point.

use super::MAX_RADIANCE;
use super::camera_ray::pixel_key;
use super::light_lanes::LightLanes;
use crate::hierarchy::{Tracer, item};
use crate::light::Light;
use crate::math::Vec3;
use crate::ray::{Hit, PrimitiveId, Ray, RayFilter};
use crate::sampling::hash_pair;
use crate::settings::ShadowMode;
use crate::shading::{SurfacePoint, emitted};
use crate::view::SceneView;

/// Key of the random numbers of the first light; the others follow.
const FIRST_LIGHT_DIMENSION: u32 = 0x100;

/// Light from all lights, shadowed, times the surface's colours. `path` keys the random numbers of the point within
/// sample `sample` of pixel (x, y); `shadow_rays` counts.
#[inline(always)]
pub fn direct_light<T: Tracer, const W: usize>(
    view: &SceneView,
    tracer: &T,
    point: &SurfacePoint,
    path: u32,
    (x, y, sample): (u32, u32, u32),
    shadow_rays: &mut u64,
) -> Vec3 {
    let point_key = hash_pair(pixel_key(view.settings.seed, x, y), path);
    let look = &point.look;
    let (specular, transmission) = (look.specular, look.transmission);
    let from_behind = view.settings.light_from_behind & (transmission.max_component() > 0.0);
    let mut sum = Vec3::ZERO;
    // Mirrors and glass answer no light by themselves: no ray need be traced to find that out.
    if look.diffuse.max_component() <= 0.0 && specular.max_component() <= 0.0 {
        return sum;
    }
    let mut number = 0;
    while number < view.lights.len() as u32 {
        let light = item(view.lights, number);
        let key = hash_pair(point_key, FIRST_LIGHT_DIMENSION + number);
        let color = emitted(light);
        let highlights = (specular.max_component() > 0.0)
            & (look.lamp_highlights | !matches!(light, Light::Triangle { .. }));
        let mut side = 0;
        while side <= from_behind as u32 {
            let sign = if side == 0 { 1.0 } else { -1.0 };
            let receiver = Receiver {
                view,
                point,
                normal: point.normal * sign,
                above: point.geometric_normal * sign,
                highlights,
            };
            let side_key = if side == 0 { key } else { hash_pair(key, side) };
            let got = receiver.gather::<T, W>(tracer, light, side_key, sample, shadow_rays);
            if side == 0 {
                sum += color * (look.diffuse * got.diffuse + specular * got.specular);
            } else {
                sum += color * (transmission * (look.diffuse * got.diffuse));
            }
            side += 1;
        }
        number += 1;
    }
    sum
}

/// One side of a surface point.
pub(super) struct Receiver<'a> {
    pub(super) view: &'a SceneView<'a>,
    pub(super) point: &'a SurfacePoint,
    /// Shading normal on this side.
    pub(super) normal: Vec3,
    /// Geometric normal on this side.
    pub(super) above: Vec3,
    /// The light throws a highlight.
    pub(super) highlights: bool,
}

/// Sums over the samples of a light, each weighted by what gets through: `N.L` and the highlight's lobe.
#[derive(Clone, Copy)]
struct Gathered {
    diffuse: Vec3,
    specular: Vec3,
}

/// Samples of a light at a point: their random numbers, and what the shadow rays leave out.
#[derive(Clone, Copy)]
struct Samples {
    key: u32,
    first: u32,
    count: u32,
    origin: Vec3,
    filter: RayFilter,
}

impl Receiver<'_> {
    #[inline(always)]
    fn gather<T: Tracer, const W: usize>(
        &self,
        tracer: &T,
        light: &Light,
        key: u32,
        sample: u32,
        shadow_rays: &mut u64,
    ) -> Gathered {
        let target = match *light {
            Light::Triangle { instance, primitive, .. } => PrimitiveId { instance, primitive },
            _ => PrimitiveId::NONE,
        };
        let count = light.samples();
        let samples = Samples {
            key,
            first: sample.wrapping_mul(count),
            count,
            origin: self.point.position.along(self.above, self.point.offset),
            // A light is not lit by itself: its samples lie in its own plane.
            filter: RayFilter { start: self.point.id, target, cull_back_faces: false },
        };
        if W > 1 && count > 1 {
            self.gather_lanes::<T, W>(tracer, light, &samples, shadow_rays)
        } else {
            self.gather_lanes::<T, 1>(tracer, light, &samples, shadow_rays)
        }
    }

    /// `W` samples at a time. Weights are added sample by sample, so `W` does not change the sums.
    #[inline(always)]
    fn gather_lanes<T: Tracer, const W: usize>(
        &self,
        tracer: &T,
        light: &Light,
        samples: &Samples,
        shadow_rays: &mut u64,
    ) -> Gathered {
        let mode = self.view.settings.shadow_mode;
        let mut sum = Gathered { diffuse: Vec3::ZERO, specular: Vec3::ZERO };
        let mut start = 0;
        while start < samples.count {
            let first = samples.first.wrapping_add(start);
            let lanes = LightLanes::<W>::new(self, light, samples.key, first, samples.origin);
            let mut active = [false; W];
            let mut any = 0;
            for lane in 0..W {
                active[lane] = (start + (lane as u32) < samples.count) & (lanes.diffuse[lane] > 0.0);
                any += active[lane] as u32;
            }
            start += W as u32;
            if any == 0 {
                continue;
            }
            let mut hidden = [false; W];
            if mode != ShadowMode::None {
                *shadow_rays += any as u64;
                hidden = tracer.occluded_batch(&lanes.rays, &samples.filter, &active);
            }
            for lane in 0..W {
                if !active[lane] {
                    continue;
                }
                let through = if !hidden[lane] {
                    Vec3::ONE
                } else if mode == ShadowMode::Coloured {
                    transmittance(self.view, tracer, &lanes.rays.ray(lane), &samples.filter)
                } else {
                    continue;
                };
                sum.diffuse += through * lanes.diffuse[lane];
                sum.specular += through * lanes.specular[lane];
            }
        }
        sum
    }
}

/// What gets through all surfaces on the way, per channel: the product of their shadow filters in the order of the hits,
/// each surface once.
#[inline(always)]
fn transmittance<T: Tracer>(view: &SceneView, tracer: &T, ray: &Ray, filter: &RayFilter) -> Vec3 {
    let mut through = Vec3::ONE;
    let mut after = Hit::miss(f32::NEG_INFINITY);
    let mut after_front = false;
    loop {
        let hit = tracer.next_hit(ray, filter, &after);
        if hit.is_miss() {
            return through;
        }
        let point = SurfacePoint::new(view, ray, &hit);
        let again = !after.is_miss()
            && hit.t - after.t <= point.offset
            && point.front == after_front
            && meet_at_corner(view, after.id, hit.id);
        // What a body takes between its front and its back; a ray that starts inside one begins at its start.
        let before = if after.is_miss() || !after_front { 0.0 } else { after.t };
        after = hit;
        after_front = point.front;
        if again {
            continue;
        }
        let look = &point.look;
        let mut surface = look.shadow_filter * look.opacity + Vec3::splat(1.0 - look.opacity);
        if !point.front {
            surface *= point.left_by_body(view, hit.t - before);
        }
        // Limited, so that no product becomes infinite: infinity times 0 would be NaN.
        through = (through * surface).min(Vec3::splat(MAX_RADIANCE));
        if through.max_component() <= 0.0 {
            return Vec3::ZERO;
        }
    }
}

/// Whether two triangles of one material are neighbours: they share a corner or two. A ray through an edge that
/// neighbours share hits both, but crosses their surface once. (Triangles that share all corners lie on each other.)
#[inline(always)]
fn meet_at_corner(view: &SceneView, a: PrimitiveId, b: PrimitiveId) -> bool {
    let geometry = item(view.geometries, item(view.instances, a.instance).geometry);
    let triangles = geometry.triangle_count;
    if a.instance != b.instance || a.primitive >= triangles || b.primitive >= triangles {
        return false;
    }
    let (a, b) = (geometry.first_triangle + a.primitive, geometry.first_triangle + b.primitive);
    let [p, q, r] = *item(view.triangles, b);
    let shared = |v: Vec3| ((v == p) | (v == q) | (v == r)) as u32;
    let [x, y, z] = *item(view.triangles, a);
    let count = shared(x) + shared(y) + shared(z);
    let one_material = item(view.triangle_shading, a).material == item(view.triangle_shading, b).material;
    one_material & (count > 0) & (count < 3)
}
