//! What gets through the surfaces between a point and a light: coloured shadows.

use crate::hierarchy::Tracer;
use crate::material::{Material, NONE};
use crate::math::{Vec3, fma};
use crate::out_of_line::out_of_line_on_gpus;
use crate::ray::{Hit, PrimitiveId, Ray, RayFilter, UNKNOWN_REST};
use crate::shading::{EvaluatedMaterial, MaterialValues, SurfacePoint};
use crate::sums::MAX_RADIANCE;
use crate::view::{SceneView, item};

/// What gets through all surfaces on the way, per channel: the product of their shadow filters.
#[inline(always)]
pub fn transmittance<T: Tracer>(view: &SceneView, tracer: &T, ray: &Ray, filter: &RayFilter) -> Vec3 {
    through_crossings(view, tracer, ShadowFilter, ray, filter)
}

/// [`transmittance`] of a ray whose closest hit is known. Most that hides light lets none of it through, whatever its textures
/// say: then no point need be computed.
#[inline(always)]
pub fn transmittance_beyond<T: Tracer>(
    view: &SceneView,
    tracer: &T,
    ray: &Ray,
    filter: &RayFilter,
    closest: &Hit,
) -> Vec3 {
    if closest.is_miss() {
        return Vec3::ONE;
    }
    if item(view.materials, material_of(view, closest.id)).stops_all_light() {
        return Vec3::ZERO;
    }
    let first = if closest.t_rest == UNKNOWN_REST { None } else { Some(*closest) };
    Crossings::NONE.go_on(view, tracer, ShadowFilter, (ray, filter), first)
}

/// The number of the material of what was hit.
#[inline(always)]
pub(super) fn material_of(view: &SceneView, id: PrimitiveId) -> u32 {
    let instance = item(view.instances, id.instance);
    if instance.material != NONE {
        return instance.material;
    }
    let geometry = item(view.geometries, instance.geometry);
    if id.primitive < geometry.triangle_count {
        item(view.triangle_shading, geometry.first_triangle + id.primitive).material
    } else {
        *item(view.sphere_materials, geometry.first_sphere + (id.primitive - geometry.triangle_count))
    }
}

/// What surfaces do with light that crosses them.
pub trait Crossing: Copy {
    /// Whether no light gets through a surface of this material, whatever its textures say.
    fn stops_all(self, material: &Material) -> bool;

    /// Crosses the next surface, at this hit.
    fn cross(self, before: &Crossings, view: &SceneView, ray: &Ray, hit: &Hit) -> Crossings;
}

/// The share of light that gets through surfaces.
pub(super) trait CrossedShare {
    /// What is known of their material.
    type Material: MaterialValues;

    /// The share that gets through one, per channel, without what its body takes.
    fn share(point: &SurfacePoint<Self::Material>) -> Vec3;
}

/// Whitted's: a filter, whether rays bend there or not.
#[derive(Clone, Copy, Debug)]
pub struct ShadowFilter;

impl CrossedShare for ShadowFilter {
    type Material = EvaluatedMaterial;

    #[inline(always)]
    fn share(point: &SurfacePoint) -> Vec3 {
        point.material_values.shadow_filter * point.coverage + Vec3::splat(1.0 - point.coverage)
    }
}

impl Crossing for ShadowFilter {
    #[inline(always)]
    fn stops_all(self, material: &Material) -> bool {
        material.stops_all_light()
    }

    #[inline(always)]
    fn cross(self, before: &Crossings, view: &SceneView, ray: &Ray, hit: &Hit) -> Crossings {
        cross_filter(before, view, ray, hit)
    }
}

out_of_line_on_gpus! {
    fn cross_filter(before: &Crossings, view: &SceneView, ray: &Ray, hit: &Hit) -> Crossings {
        before.crossed::<ShadowFilter>(view, ray, hit)
    }
}

/// What gets through all surfaces on the way, per channel: the product of their shares in the order of the hits, each surface
/// once.
#[inline(always)]
pub fn through_crossings<T: Tracer>(
    view: &SceneView,
    tracer: &T,
    crossing: impl Crossing,
    ray: &Ray,
    filter: &RayFilter,
) -> Vec3 {
    Crossings::NONE.go_on(view, tracer, crossing, (ray, filter), None)
}

/// The surfaces that a ray has crossed.
#[derive(Clone, Copy, Debug)]
pub struct Crossings {
    /// What got through all of them.
    through: Vec3,
    /// The last hit, and whether it was of a front.
    after: Hit,
    after_front: bool,
}

impl Crossings {
    const NONE: Crossings = Crossings {
        through: Vec3::ONE,
        after: Hit { t: f32::NEG_INFINITY, t_rest: 0.0, u: 0.0, v: 0.0, id: PrimitiveId::NONE },
        after_front: false,
    };

    /// Crosses all that follow; the next one is `known`, where it is.
    #[inline(always)]
    fn go_on<T: Tracer>(
        mut self,
        view: &SceneView,
        tracer: &T,
        crossing: impl Crossing,
        (ray, filter): (&Ray, &RayFilter),
        mut known: Option<Hit>,
    ) -> Vec3 {
        loop {
            if self.through.max_component() <= 0.0 {
                return Vec3::ZERO;
            }
            let hit = match known {
                Some(hit) => hit,
                None => tracer.next_hit(ray, filter, &self.after),
            };
            known = None;
            if hit.is_miss() {
                return self.through;
            }
            // Then no point need be computed.
            if crossing.stops_all(item(view.materials, material_of(view, hit.id))) {
                return Vec3::ZERO;
            }
            self = crossing.cross(&self, view, ray, &hit);
        }
    }

    /// Those and the next one.
    #[inline(always)]
    pub(super) fn crossed<C: CrossedShare>(&self, view: &SceneView, ray: &Ray, hit: &Hit) -> Crossings {
        let Crossings { mut through, after, after_front } = *self;
        let point = SurfacePoint::<C::Material>::new(view, ray, hit);
        let again = !after.is_miss()
            && is_close(&after, hit, &point)
            && point.front == after_front
            && meet_at_corner(view, after.id, hit.id);
        // What a body takes between its front and its back; a ray that starts inside one begins at its start.
        let before = if after.is_miss() || !after_front { 0.0 } else { after.t };
        if !again {
            // Where a ray does not see a surface, that casts no shadow to where the ray starts.
            let mut surface = C::share(&point);
            if !point.front {
                surface *= point.left_by_body(view, hit.t - before);
            }
            // Limited, so that no product becomes infinite: infinity times 0 would be NaN.
            through = (through * surface).min(Vec3::splat(MAX_RADIANCE));
        }
        Crossings { through, after: *hit, after_front: point.front }
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
