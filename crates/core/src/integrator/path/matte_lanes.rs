//! Paths that have met matte triangles, bounced several at a time: the bits of [`bounce`](super::bounce), of which this is the
//! common case.
//!
//! What lanes do alike stands in short loops over arrays, free of branches, which become SIMD code; each calls the functions that
//! one path calls. What differs from lane to lane (textures, which light, other kinds of lights, lamps that are met) is done lane
//! by lane.

use super::arrive::{after_roulette, lamp_share, ray_from};
use super::light::LightDraw;
use super::light_lanes::DrawLanes;
use super::{
    Bounce, BounceLanes, LightRequest, Media, NumbersOfLanes, PathState, frame, in_frame, limited,
    out_of_frame,
};
use crate::bsdf::{Matte, Scattered};
use crate::integrator::coverage::MAX_HOLES;
use crate::integrator::{MAX_DEPTH, PathRay, RayKind};
use crate::light::LightReceiver;
use crate::math::{Vec3, Vec3Lanes};
use crate::ray::{Hit, Ray, RayFilter};
use crate::sampling::cosine_direction;
use crate::shading::{FoundTriangle, PathMaterial, PointLanes};
use crate::sums::MAX_RADIANCE;
use crate::view::{SceneView, item};

/// Whether [`bounce_matte`] takes what a ray found: a matte triangle of the world, met by a ray that is in no body.
#[inline(always)]
pub fn is_matte_triangle(view: &SceneView, ray: &PathRay, hit: &Hit) -> bool {
    Media::of(ray).is_nowhere() && is_matte_outside(view, hit)
}

/// The same of a ray that is in no body.
#[inline(always)]
pub fn is_matte_outside(view: &SceneView, hit: &Hit) -> bool {
    if hit.is_miss() | (hit.id.instance != 0) {
        return false;
    }
    let instance = item(view.instances, 0);
    let geometry = item(view.geometries, instance.geometry);
    if hit.id.primitive >= geometry.triangle_count {
        return false;
    }
    let shading = item(view.triangle_shading, geometry.first_triangle + hit.id.primitive);
    PathMaterial::is_matte(item(view.materials, shading.material))
}

/// What `count` rays of paths found, which [`is_matte_triangle`] takes: `met(lane)` gives the path and the hit of each of W lanes,
/// of which those after the first `count` may repeat others.
#[inline(always)]
pub fn bounce_matte<'a, const W: usize, B: BounceLanes>(
    view: &SceneView,
    count: usize,
    met: impl Fn(usize) -> (&'a PathState, &'a Hit),
    numbers: &impl NumbersOfLanes<W>,
    to: &mut B,
) {
    let settings = view.settings;
    let first = item(view.geometries, item(view.instances, 0).geometry).first_triangle;
    let points = PointLanes::<W>::new(|lane| {
        let (path, hit) = met(lane);
        let number = first + hit.id.primitive;
        let normals = &item(view.triangle_shading, number).normals;
        let PathRay { origin, direction, .. } = &path.ray;
        FoundTriangle { origin, direction, hit, corners: item(view.triangles, number), normals }
    });
    let zero = Vec3Lanes::<W>::ZERO;
    let (mut albedo, mut weight, mut depth) = (zero, zero, [0; W]);
    let mut is_alive = [false; W];
    for lane in 0..W {
        let (path, hit) = met(lane);
        let number = first + hit.id.primitive;
        let number_of_material = item(view.triangle_shading, number).material;
        let material = item(view.materials, number_of_material);
        let (base, emission) = PathMaterial::matte_at(view, number, material, hit);
        albedo.set(lane, base);
        weight.set(lane, path.ray.weight.min(Vec3::splat(MAX_RADIANCE)));
        depth[lane] = path.ray.depth;
        let front = points.front[lane];
        // Backs that are not there are passed.
        let is_there = front | !material.single_sided;
        is_alive[lane] = is_there & (lane < count);
        if lane >= count {
            continue;
        }
        if !is_there {
            if path.ray.holes < MAX_HOLES {
                let origin = points.offset_origin(lane, path.ray.direction);
                let ray = ray_from(origin, hit.id, &path.ray, weight.get(lane), hit.t);
                to.lane(lane).go_on(PathState { ray, ..*path });
            }
        } else if emission.max_component() > 0.0 {
            let lamp = (hit.id, number_of_material, front);
            let share = lamp_share(view, lamp, path, path.ray.travelled + hit.t);
            let found = limited(settings, path.ray.depth > 1, weight.get(lane) * emission * share);
            to.lane(lane).add(found);
        }
    }
    let most = if settings.max_depth < MAX_DEPTH { settings.max_depth } else { MAX_DEPTH };
    let mut goes_on = [false; W];
    let mut is_by_chance = false;
    for lane in 0..W {
        is_by_chance |= depth[lane] >= settings.roulette_depth;
    }
    if is_by_chance {
        let survival = numbers.survival();
        for lane in 0..W {
            let old = weight.get(lane);
            let new = after_roulette(old, survival[lane]);
            weight.set(lane, if depth[lane] >= settings.roulette_depth { new } else { old });
        }
    }
    for lane in 0..W {
        is_alive[lane] &= weight.get(lane).max_component() > 0.0;
        goes_on[lane] = is_alive[lane] & (depth[lane] < most);
    }
    let mut axes = [zero; 3];
    for lane in 0..W {
        let of_lane =
            frame(points.normal.get(lane), points.to_viewer.get(lane), points.geometric_normal.get(lane));
        for axis in 0..3 {
            axes[axis].set(lane, of_lane[axis]);
        }
    }
    let surfaces = MatteLanes { points, albedo, weight, depth, axes };
    surfaces.sample_lights(view, &goes_on, &met, numbers, to);
    surfaces.scatter(&goes_on, &met, numbers, to);
}

/// Matte surfaces that paths have met, and are to be scattered by.
struct MatteLanes<const W: usize> {
    points: PointLanes<W>,
    albedo: Vec3Lanes<W>,
    /// What paths are multiplied by there.
    weight: Vec3Lanes<W>,
    depth: [u32; W],
    /// Of the frames of their directions: z is the shading normal.
    axes: [Vec3Lanes<W>; 3],
}

impl<const W: usize> MatteLanes<W> {
    #[inline(always)]
    fn axes(&self, lane: usize) -> [Vec3; 3] {
        [self.axes[0].get(lane), self.axes[1].get(lane), self.axes[2].get(lane)]
    }

    #[inline(always)]
    fn receiver(&self, lane: usize) -> LightReceiver {
        LightReceiver { position: self.points.position.get(lane), normal: self.axes[2].get(lane) }
    }

    /// Where shadow rays start.
    #[inline(always)]
    fn origin(&self, lane: usize) -> Vec3 {
        self.points
            .position
            .get(lane)
            .plus_scaled(self.points.geometric_normal.get(lane), self.points.offset[lane])
    }

    /// As [`super::sample_light`], where lanes go on.
    #[inline(always)]
    fn sample_lights<'a, B: BounceLanes>(
        &self,
        view: &SceneView,
        goes_on: &[bool; W],
        met: &impl Fn(usize) -> (&'a PathState, &'a Hit),
        numbers: &impl NumbersOfLanes<W>,
        to: &mut B,
    ) {
        let settings = view.settings;
        let mut origin = Vec3Lanes::<W>::ZERO;
        for lane in 0..W {
            origin.set(lane, self.origin(lane));
        }
        let draws = DrawLanes::new(view, goes_on, |lane| self.receiver(lane), &origin, numbers);
        let (mut contribution, mut is_lit) = (Vec3Lanes::<W>::ZERO, [false; W]);
        for lane in 0..W {
            let LightDraw { to_light, strength, .. } = draws.get(lane);
            let cos = in_frame(&self.axes(lane), to_light).z;
            let scattered = Matte::new(self.albedo.get(lane)).eval(cos);
            let found = strength.contribution(
                settings,
                (self.weight.get(lane), self.depth[lane]),
                scattered,
                Vec3::ONE,
            );
            contribution.set(lane, found);
            is_lit[lane] = draws.is_there(lane)
                & strength.is_any()
                & (to_light.dot(self.points.geometric_normal.get(lane)) > 0.0)
                & (cos > 0.0)
                & (found.max_component() > 0.0);
        }
        for lane in 0..W {
            if is_lit[lane] {
                let (_, hit) = met(lane);
                let LightDraw { to_light: direction, t_max, target, .. } = draws.get(lane);
                to.lane(lane).ask(LightRequest {
                    ray: Ray { origin: origin.get(lane), t_min: 0.0, direction, t_max },
                    filter: RayFilter { start: hit.id, target, cull_back_faces: false },
                    contribution: contribution.get(lane),
                });
            }
        }
    }

    /// As [`super::scatter`], where lanes go on.
    #[inline(always)]
    fn scatter<'a, B: BounceLanes>(
        &self,
        goes_on: &[bool; W],
        met: &impl Fn(usize) -> (&'a PathState, &'a Hit),
        numbers: &impl NumbersOfLanes<W>,
        to: &mut B,
    ) {
        let zero = Vec3Lanes::<W>::ZERO;
        let (mut local, mut direction, mut origin, mut next_weight) = (zero, zero, zero, zero);
        let (mut density, mut is_scattered) = ([0.0; W], *goes_on);
        let u = numbers.directions();
        for lane in 0..W {
            local.set(lane, cosine_direction([u[0][lane], u[1][lane]]));
        }
        for lane in 0..W {
            let cos = local.get(lane).z;
            let matte = Matte::new(self.albedo.get(lane));
            let Scattered { value, pdf } = matte.eval(cos);
            let weight = (self.weight.get(lane) * (value * (1.0 / pdf))).min(Vec3::splat(MAX_RADIANCE));
            next_weight.set(lane, weight);
            density[lane] = pdf;
            is_scattered[lane] &=
                (matte.chance > 0.0) & (cos > 0.0) & (pdf > 0.0) & (weight.max_component() > 0.0);
        }
        for lane in 0..W {
            let geometric_normal = self.points.geometric_normal.get(lane);
            let to_world = out_of_frame(&self.axes(lane), local.get(lane));
            direction.set(lane, to_world);
            // What goes on does so above the surface.
            origin.set(lane, self.origin(lane));
            is_scattered[lane] &= to_world.dot(geometric_normal) > 0.0;
        }
        for lane in 0..W {
            if is_scattered[lane] {
                let (path, hit) = met(lane);
                let ray = &path.ray;
                to.lane(lane).go_on(PathState {
                    ray: PathRay {
                        origin: origin.get(lane),
                        path: ray.path,
                        direction: direction.get(lane),
                        depth: ray.depth + 1,
                        weight: next_weight.get(lane),
                        kind: RayKind::Glossy,
                        start: hit.id,
                        inside: ray.inside,
                        holes: 0,
                        travelled: 0.0,
                        lobe_density: density[lane],
                    },
                    left: self.receiver(lane),
                });
            }
        }
    }
}
