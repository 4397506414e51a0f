//! What gets through the surfaces between a point and a light: coloured shadows.

use crate::hierarchy::Tracer;
use crate::math::{Vec3, fma};
use crate::ray::{Hit, PrimitiveId, Ray, RayFilter};
use crate::shading::{EvaluatedMaterial, MaterialValues, SurfacePoint};
use crate::sums::MAX_RADIANCE;
use crate::view::{SceneView, item};

/// What gets through all surfaces on the way, per channel: the product of their shadow filters.
#[inline(always)]
pub fn transmittance<T: Tracer>(view: &SceneView, tracer: &T, ray: &Ray, filter: &RayFilter) -> Vec3 {
    through_crossings::<T, ShadowFilter>(view, tracer, ray, filter)
}

/// What surfaces do with light that crosses them.
pub(super) trait Crossing {
    /// What is known of their material.
    type Material: MaterialValues;

    /// The share that gets through a surface, per channel, without what its body takes.
    fn share(point: &SurfacePoint<Self::Material>) -> Vec3;
}

/// Whitted's: a filter, whether rays bend there or not.
struct ShadowFilter;

impl Crossing for ShadowFilter {
    type Material = EvaluatedMaterial;

    #[inline(always)]
    fn share(point: &SurfacePoint) -> Vec3 {
        point.material_values.shadow_filter * point.coverage + Vec3::splat(1.0 - point.coverage)
    }
}

/// What gets through all surfaces on the way, per channel: the product of their shares in the order of the hits, each surface
/// once.
#[inline(always)]
pub(super) fn through_crossings<T: Tracer, C: Crossing>(
    view: &SceneView,
    tracer: &T,
    ray: &Ray,
    filter: &RayFilter,
) -> Vec3 {
    let mut through = Vec3::ONE;
    let mut after = Hit::miss(f32::NEG_INFINITY);
    let mut after_front = false;
    loop {
        let hit = tracer.next_hit(ray, filter, &after);
        if hit.is_miss() {
            return through;
        }
        let point = SurfacePoint::<C::Material>::new(view, ray, &hit);
        let again = !after.is_miss()
            && is_close(&after, &hit, &point)
            && point.front == after_front
            && meet_at_corner(view, after.id, hit.id);
        // What a body takes between its front and its back; a ray that starts inside one begins at its start.
        let before = if after.is_miss() || !after_front { 0.0 } else { after.t };
        after = hit;
        after_front = point.front;
        if again {
            continue;
        }
        // Where a ray does not see a surface, that casts no shadow to where the ray starts.
        let mut surface = C::share(&point);
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

/// Whether the second of two hits is no farther behind the first than where a ray meets the edge that two triangles share:
/// to one of them it may have passed it at a grazing angle.
#[inline(always)]
fn is_close<M>(first: &Hit, second: &Hit, point: &SurfacePoint<M>) -> bool {
    let p = point.position.abs();
    let apart = (second.t as f64 + second.t_rest as f64) - (first.t as f64 + first.t_rest as f64);
    apart <= fma(SAME_POINT, (p.x + p.y) + p.z, 4.0 * point.offset) as f64
}

/// Hits this share of their coordinates apart may be one crossing of an edge.
const SAME_POINT: f32 = 1.0 / 1_048_576.0;

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
