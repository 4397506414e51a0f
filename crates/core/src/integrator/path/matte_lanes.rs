//! Paths that have met matte triangles, bounced several at a time: the bits of [`bounce`](super::bounce), of which this is the
//! common case.
//!
//! What lanes do alike stands in short loops over arrays, free of branches, which become SIMD code; each calls the functions that
//! one path calls. What differs from lane to lane (textures, which light, other kinds of lights, lamps that are met) is done lane
//! by lane.

use super::arrive::{after_roulette, lamp_share, ray_from};
use super::light::{LightDraw, Strength, choose_lanes, draw_environment, draw_light};
use super::{Bounce, LightRequest, Media, NumbersOfLanes, PathState, frame, in_frame, limited, out_of_frame};
use crate::bsdf::{Matte, Scattered};
use crate::integrator::coverage::MAX_HOLES;
use crate::integrator::{MAX_DEPTH, PathRay, RayKind};
use crate::light::{Light, LightReceiver, LightSampleLanes, TriangleLamp};
use crate::material::NONE;
use crate::math::{Vec3, Vec3Lanes};
use crate::ray::{Hit, PrimitiveId, Ray, RayFilter};
use crate::sampling::cosine_direction;
use crate::shading::{FoundTriangle, PathMaterial, PointLanes};
use crate::sums::MAX_RADIANCE;
use crate::view::{SceneView, item};

/// Takes what several paths find at surfaces.
pub trait BounceLanes {
    /// Takes what one of them finds.
    type Lane<'a>: Bounce
    where
        Self: 'a;

    /// For the path of a lane.
    fn lane(&mut self, lane: usize) -> Self::Lane<'_>;
}

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
        FoundTriangle { ray: path.ray.ray(), hit, corners: item(view.triangles, number), normals }
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
    let survival = numbers.survival();
    for lane in 0..W {
        let old = weight.get(lane);
        let new = after_roulette(old, survival[lane]);
        weight.set(lane, if depth[lane] >= settings.roulette_depth { new } else { old });
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
        let mut draws = DrawLanes::<W>::new();
        let mut origin = Vec3Lanes::<W>::ZERO;
        for lane in 0..W {
            origin.set(lane, self.origin(lane));
        }
        let mut lamps = LampLanes::<W>::new();
        let choice = numbers.light_choice();
        let chosen = choose_lanes(view, |lane| self.receiver(lane), &choice);
        for lane in 0..W {
            if !goes_on[lane] {
                continue;
            }
            let Some((light, chance)) = chosen[lane] else { continue };
            let of_lane = numbers.lane(lane);
            match light {
                Some(light) => {
                    if !lamps.take(lane, light, chance) {
                        draws.set(lane, draw_light(view, light, chance, origin.get(lane), &of_lane));
                    }
                }
                None => draws.set(lane, draw_environment(view, choice[lane], &of_lane)),
            }
        }
        if lamps.is_any {
            let on_light = numbers.on_lights();
            let samples = LightSampleLanes::<W>::of_triangles(
                |lane| lamps.lamp(lane),
                |lane| origin.get(lane),
                |lane| [on_light[0][lane], on_light[1][lane]],
            );
            for lane in 0..W {
                let weight = samples.weight[lane] / lamps.chance[lane];
                let strength = Strength::new(settings, lamps.color.get(lane), weight, true);
                if lamps.is_there[lane] {
                    let (to_light, t_max) = (samples.direction(lane), samples.t_max[lane]);
                    draws.set(lane, LightDraw { to_light, t_max, target: lamps.target[lane], strength });
                }
            }
        }
        let (mut contribution, mut is_lit) = (Vec3Lanes::<W>::ZERO, [false; W]);
        for lane in 0..W {
            let to_light = draws.to_light.get(lane);
            let strength = Strength { radiance: draws.radiance.get(lane), density: draws.density[lane] };
            let cos = in_frame(&self.axes(lane), to_light).z;
            let scattered = Matte::new(self.albedo.get(lane)).eval(cos);
            let found = strength.contribution(
                settings,
                (self.weight.get(lane), self.depth[lane]),
                scattered,
                Vec3::ONE,
            );
            contribution.set(lane, found);
            is_lit[lane] = draws.is_there[lane]
                & (strength.radiance.max_component() > 0.0)
                & (to_light.dot(self.points.geometric_normal.get(lane)) > 0.0)
                & (cos > 0.0)
                & (found.max_component() > 0.0);
        }
        for lane in 0..W {
            if is_lit[lane] {
                let (_, hit) = met(lane);
                let (direction, t_max) = (draws.to_light.get(lane), draws.t_max[lane]);
                to.lane(lane).ask(LightRequest {
                    ray: Ray { origin: origin.get(lane), t_min: 0.0, direction, t_max },
                    filter: RayFilter { start: hit.id, target: draws.target[lane], cull_back_faces: false },
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

/// Samples of lights that were drawn.
struct DrawLanes<const W: usize> {
    to_light: Vec3Lanes<W>,
    radiance: Vec3Lanes<W>,
    density: [f32; W],
    t_max: [f32; W],
    target: [PrimitiveId; W],
    is_there: [bool; W],
}

impl<const W: usize> DrawLanes<W> {
    #[inline(always)]
    fn new() -> DrawLanes<W> {
        DrawLanes {
            to_light: Vec3Lanes::ZERO,
            radiance: Vec3Lanes::ZERO,
            density: [0.0; W],
            t_max: [0.0; W],
            target: [PrimitiveId::NONE; W],
            is_there: [false; W],
        }
    }

    #[inline(always)]
    fn set(&mut self, lane: usize, draw: LightDraw) {
        self.to_light.set(lane, draw.to_light);
        self.radiance.set(lane, draw.strength.radiance);
        self.density[lane] = draw.strength.density;
        self.t_max[lane] = draw.t_max;
        self.target[lane] = draw.target;
        self.is_there[lane] = true;
    }
}

/// Triangles without textures that were chosen as lights.
struct LampLanes<const W: usize> {
    corner: Vec3Lanes<W>,
    edges: [Vec3Lanes<W>; 2],
    normal: Vec3Lanes<W>,
    color: Vec3Lanes<W>,
    power: [f32; W],
    is_two_sided: [bool; W],
    chance: [f32; W],
    target: [PrimitiveId; W],
    is_there: [bool; W],
    is_any: bool,
}

impl<const W: usize> LampLanes<W> {
    #[inline(always)]
    fn new() -> LampLanes<W> {
        let zero = Vec3Lanes::ZERO;
        LampLanes {
            corner: zero,
            edges: [zero; 2],
            normal: zero,
            color: zero,
            power: [0.0; W],
            is_two_sided: [false; W],
            chance: [1.0; W],
            target: [PrimitiveId::NONE; W],
            is_there: [false; W],
            is_any: false,
        }
    }

    /// Takes a light that was chosen with this chance, where it is such a triangle.
    #[inline(always)]
    fn take(&mut self, lane: usize, light: &Light, chance: f32) -> bool {
        let Light::Triangle { texture: NONE, color, .. } = *light else { return false };
        let Some(lamp) = light.triangle_lamp() else { return false };
        self.corner.set(lane, lamp.v0);
        self.edges[0].set(lane, lamp.e1);
        self.edges[1].set(lane, lamp.e2);
        self.normal.set(lane, lamp.normal);
        self.color.set(lane, color);
        self.power[lane] = lamp.power;
        self.is_two_sided[lane] = lamp.is_two_sided;
        self.chance[lane] = chance;
        self.target[lane] = light.primitive();
        self.is_there[lane] = true;
        self.is_any = true;
        true
    }

    #[inline(always)]
    fn lamp(&self, lane: usize) -> TriangleLamp {
        TriangleLamp {
            v0: self.corner.get(lane),
            e1: self.edges[0].get(lane),
            e2: self.edges[1].get(lane),
            normal: self.normal.get(lane),
            power: self.power[lane],
            is_two_sided: self.is_two_sided[lane],
        }
    }
}
