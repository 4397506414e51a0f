//! What lights send to a point: one sample, and one in each of several lanes.

use super::{Light, sphere};
use crate::intersect::precise::{dot64, double, minus64};
use crate::math::{Vec3, Vec3Lanes, fma, max, sqrt};
use crate::sampling::triangle_point;

/// A sampled point of a light, seen from a surface point.
#[derive(Clone, Copy, Debug)]
pub struct LightSample {
    /// Unit vector from the surface point to the light.
    pub to_light: Vec3,
    /// Distance of the light; infinite for directional ones.
    pub distance: f32,
    /// What reaches the point, as a share of [`Light::le`].
    pub weight: f32,
}

/// A light triangle, as its samples need it.
#[derive(Clone, Copy, Debug)]
pub struct TriangleLamp {
    /// First vertex, world space.
    pub v0: Vec3,
    /// Second vertex minus the first.
    pub e1: Vec3,
    /// Third vertex minus the first.
    pub e2: Vec3,
    /// Unit normal of the side that shines.
    pub normal: Vec3,
    /// Area over the number of samples.
    pub power: f32,
    /// It shines to the other side, too.
    pub is_two_sided: bool,
}

/// A triangle that is a light in each of several lanes.
#[derive(Clone, Copy, Debug)]
pub struct TriangleLampLanes<const W: usize> {
    v0: Vec3Lanes<W>,
    e1: Vec3Lanes<W>,
    e2: Vec3Lanes<W>,
    normal: Vec3Lanes<W>,
    power: [f32; W],
    is_two_sided: [bool; W],
}

impl<const W: usize> TriangleLampLanes<W> {
    /// Triangles without a size.
    pub const NONE: TriangleLampLanes<W> = TriangleLampLanes {
        v0: Vec3Lanes::ZERO,
        e1: Vec3Lanes::ZERO,
        e2: Vec3Lanes::ZERO,
        normal: Vec3Lanes::ZERO,
        power: [0.0; W],
        is_two_sided: [false; W],
    };

    /// Sets that of a lane.
    #[inline(always)]
    pub fn set(&mut self, lane: usize, lamp: &TriangleLamp) {
        self.v0.set(lane, lamp.v0);
        self.e1.set(lane, lamp.e1);
        self.e2.set(lane, lamp.e2);
        self.normal.set(lane, lamp.normal);
        self.power[lane] = lamp.power;
        self.is_two_sided[lane] = lamp.is_two_sided;
    }

    /// That of a lane.
    #[inline(always)]
    pub fn get(&self, lane: usize) -> TriangleLamp {
        TriangleLamp {
            v0: self.v0.get(lane),
            e1: self.e1.get(lane),
            e2: self.e2.get(lane),
            normal: self.normal.get(lane),
            power: self.power[lane],
            is_two_sided: self.is_two_sided[lane],
        }
    }
}

impl TriangleLamp {
    /// A sample of it, for a point of the unit square.
    #[inline(always)]
    fn sample_li(&self, from: Vec3, u: [f32; 2]) -> LightSample {
        let [b1, b2] = triangle_point(u);
        let offset = self.v0.plus_scaled(self.e1, b1).plus_scaled(self.e2, b2) - from;
        let sample = towards(offset, self.power, true);
        let cos = facing(-self.normal.dot(sample.to_light), self.is_two_sided);
        LightSample { weight: sample.weight * cos, ..sample }
    }

    /// [`TriangleLamp::power`] of a light with this area and so many samples.
    #[inline(always)]
    pub fn power(area: f32, samples: u32) -> f32 {
        area / samples as f32
    }

    /// What its samples may be off its plane by.
    #[inline(always)]
    fn off_plane(&self) -> f32 {
        let (a, b) = (self.e1.abs(), self.e2.abs());
        OFF_PLANE * ((a.x + a.y + a.z) + (b.x + b.y + b.z))
    }
}

impl Light {
    /// The light as a triangle, where it is one.
    #[inline(always)]
    pub fn triangle_lamp(&self) -> Option<TriangleLamp> {
        match *self {
            Light::Triangle { v0, e1, e2, normal, area, samples, is_two_sided, .. } => {
                let power = TriangleLamp::power(area, samples);
                Some(TriangleLamp { v0, e1, e2, normal, power, is_two_sided })
            }
            Light::Point { .. } | Light::Directional { .. } | Light::Spot { .. } | Light::Sphere { .. } => {
                None
            }
        }
    }

    /// The colour that it sends, which the weights of samples multiply.
    #[inline(always)]
    pub fn le(&self) -> Vec3 {
        match *self {
            Light::Point { color, .. }
            | Light::Directional { color, .. }
            | Light::Spot { color, .. }
            | Light::Triangle { color, .. }
            | Light::Sphere { color, .. } => color,
        }
    }

    /// What reaches `from` of it, for a point `u` of the unit square, which says where lights with an area are sampled. Point and
    /// spot lights fall off with `1 / d^2` where `falloff`. The weights of N samples of a triangle of area S are
    /// `S max(0, N_l.(-L)) / (N d^2)` each.
    #[inline(always)]
    pub fn sample_li(&self, from: Vec3, u: [f32; 2], falloff: bool) -> LightSample {
        match *self {
            Light::Point { position, .. } => towards(position - from, 1.0, falloff),
            Light::Directional { to_light, .. } => {
                LightSample { to_light, distance: f32::INFINITY, weight: 1.0 }
            }
            Light::Spot { position, axis, cos_inner, cos_outer, .. } => {
                let sample = towards(position - from, 1.0, falloff);
                let cos = -axis.dot(sample.to_light);
                let cone = if cos >= cos_inner {
                    1.0
                } else if cos <= cos_outer {
                    0.0
                } else {
                    let x = (cos - cos_outer) / (cos_inner - cos_outer);
                    x * x * (3.0 - 2.0 * x)
                };
                LightSample { weight: sample.weight * cone, ..sample }
            }
            Light::Triangle { v0, e1, e2, normal, area, samples, is_two_sided, .. } => {
                TriangleLamp { v0, e1, e2, normal, power: area / samples as f32, is_two_sided }
                    .sample_li(from, u)
            }
            Light::Sphere { center, radius, .. } => sphere::sample(from, center, radius, u),
        }
    }

    /// How densely [`Light::sample_li`] gives the unit direction `to_light` from a point, per steradian, where that meets the light
    /// at this distance; 0 for lights that shine from one point or direction.
    #[inline(always)]
    pub fn pdf_li(&self, from: Vec3, to_light: Vec3, distance: f32) -> f32 {
        match *self {
            Light::Point { .. } | Light::Directional { .. } | Light::Spot { .. } => 0.0,
            Light::Sphere { center, radius, .. } => sphere::density(from, center, radius),
            Light::Triangle { normal, area, is_two_sided, .. } => {
                let facing = facing(-normal.dot(to_light), is_two_sided) * area;
                if facing > 0.0 { distance * distance / facing } else { 0.0 }
            }
        }
    }
}

/// A point of a light triangle, `offset` away from the surface point: the weight of each of N samples is
/// `S max(0, N_l.(-L)) / (N d^2)` with `power` = S / N.
#[inline(always)]
pub fn triangle_sample(offset: Vec3, light_normal: Vec3, power: f32) -> LightSample {
    let sample = towards(offset, power, true);
    LightSample { weight: sample.weight * max(-light_normal.dot(sample.to_light), 0.0), ..sample }
}

/// The cosine by which a side that shines faces, of that for the front.
#[inline(always)]
fn facing(cos: f32, is_two_sided: bool) -> f32 {
    max(cos, if is_two_sided { -cos } else { 0.0 })
}

#[inline(always)]
fn towards(offset: Vec3, power: f32, falloff: bool) -> LightSample {
    let squared = offset.length_squared();
    let distance = sqrt(squared);
    let inverse = 1.0 / distance;
    // On the light itself there is no direction: it gives nothing.
    let reachable = (squared > f32::MIN_POSITIVE) & (squared < f32::INFINITY);
    let strength = if falloff { power * (inverse * inverse) } else { power };
    LightSample { to_light: offset * inverse, distance, weight: if reachable { strength } else { 0.0 } }
}

/// A sample of one light in each of several lanes. One short loop a step, each over arrays and free of branches: that is the form
/// in which compilers turn loops into SIMD code. With one lane it is plain scalar code, with the same bits.
#[derive(Clone, Copy, Debug)]
pub struct LightSampleLanes<const W: usize> {
    /// Unit vectors to the light's points: x of every lane, y, z.
    pub to_light: [[f32; W]; 3],
    /// Shadow rays end here, just before the light.
    pub t_max: [f32; W],
    /// What reaches the point, as a share of [`Light::le`].
    pub weight: [f32; W],
}

impl<const W: usize> LightSampleLanes<W> {
    /// Samples `light` once per lane. `origin(lane)` is the point that is lit; `random(lane)` is the point of the unit square that
    /// chooses where a light with an area is sampled. With `falloff`, point and spot lights are divided by the distance squared.
    #[inline(always)]
    pub fn new(
        light: &Light,
        falloff: bool,
        origin: impl Fn(usize) -> Vec3,
        random: impl Fn(usize) -> [f32; 2],
    ) -> LightSampleLanes<W> {
        let none = [0.0; W];
        let mut lanes = LightSampleLanes { to_light: [none; 3], t_max: none, weight: none };
        // An arm for each kind, so that none is chosen inside the loops.
        match *light {
            Light::Triangle { v0, e1, e2, normal, area, samples, is_two_sided, .. } => {
                let lamp = TriangleLamp { v0, e1, e2, normal, power: area / samples as f32, is_two_sided };
                return LightSampleLanes::of_triangles(|_| lamp, origin, random);
            }
            light @ Light::Point { position, .. } => {
                lanes.sample(&light, falloff, &origin, &[none; 2]);
                lanes.end_at(position, &origin);
            }
            light @ Light::Sphere { .. } => {
                let mut u = [none; 2];
                for lane in 0..W {
                    [u[0][lane], u[1][lane]] = random(lane);
                }
                lanes.sample(&light, falloff, &origin, &u);
            }
            light @ Light::Directional { .. } => lanes.sample(&light, falloff, &origin, &[none; 2]),
            light @ Light::Spot { position, .. } => {
                lanes.sample(&light, falloff, &origin, &[none; 2]);
                lanes.end_at(position, &origin);
            }
        }
        lanes
    }

    /// Samples a triangle in each lane; else as [`LightSampleLanes::new`].
    #[inline(always)]
    pub fn of_triangles(
        lamp: impl Fn(usize) -> TriangleLamp,
        origin: impl Fn(usize) -> Vec3,
        random: impl Fn(usize) -> [f32; 2],
    ) -> LightSampleLanes<W> {
        let none = [0.0; W];
        let mut lanes = LightSampleLanes { to_light: [none; 3], t_max: none, weight: none };
        let mut u = [none; 2];
        for lane in 0..W {
            [u[0][lane], u[1][lane]] = random(lane);
        }
        for lane in 0..W {
            lanes.set(lane, &lamp(lane).sample_li(origin(lane), [u[0][lane], u[1][lane]]));
        }
        for lane in 0..W {
            lanes.t_max[lane] = end_at_plane(origin(lane), lanes.direction(lane), &lamp(lane));
        }
        lanes
    }

    #[inline(always)]
    fn set(&mut self, lane: usize, sample: &LightSample) {
        self.to_light[0][lane] = sample.to_light.x;
        self.to_light[1][lane] = sample.to_light.y;
        self.to_light[2][lane] = sample.to_light.z;
        self.t_max[lane] = sample.distance;
        self.weight[lane] = sample.weight;
    }

    /// The unit vector to the light in a lane.
    #[inline(always)]
    pub fn direction(&self, lane: usize) -> Vec3 {
        let [x, y, z] = &self.to_light;
        Vec3 { x: x[lane], y: y[lane], z: z[lane] }
    }

    #[inline(always)]
    fn sample(&mut self, light: &Light, falloff: bool, origin: &impl Fn(usize) -> Vec3, u: &[[f32; W]; 2]) {
        for lane in 0..W {
            self.set(lane, &light.sample_li(origin(lane), [u[0][lane], u[1][lane]], falloff));
        }
    }

    /// Ends the rays at a point.
    #[inline(always)]
    fn end_at(&mut self, point: Vec3, origin: &impl Fn(usize) -> Vec3) {
        for lane in 0..W {
            self.t_max[lane] = end_at_point(origin(lane), self.direction(lane), point);
        }
    }
}

/// The plane of a light triangle is off its samples by less than this (4 · 2^-24) times the lengths of its edges.
const OFF_PLANE: f32 = 1.0 / 4_194_304.0;

/// Where a ray that goes to a light triangle ends: the last number before it meets the triangle's plane, so that what lies on
/// the light does not hide it and what stands before it does.
#[inline(always)]
fn end_at_plane(origin: Vec3, direction: Vec3, lamp: &TriangleLamp) -> f32 {
    let normal = double(lamp.normal);
    let height = dot64(normal, minus64(double(lamp.v0), double(origin))).abs() - lamp.off_plane() as f64;
    let t = (height / dot64(normal, double(direction)).abs()) as f32;
    fma(t, -1.0 / 16_777_216.0, t)
}

/// Where a ray that goes to a point ends. Its direction is rounded, and its length is not quite 1.
#[inline(always)]
fn end_at_point(origin: Vec3, direction: Vec3, point: Vec3) -> f32 {
    let (way, direction) = (minus64(double(point), double(origin)), double(direction));
    (dot64(way, direction) / dot64(direction, direction)) as f32
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::vec3;
    use crate::sampling::point_2d;

    /// The mean of one over the density of samples is the solid angle of what is sampled, which van Oosterom and Strackee (1983)
    /// give in closed form.
    #[test]
    fn triangles_are_as_dense_as_is_said() {
        let (v0, e1, e2) = (vec3(-0.5, -0.5, 2.0), vec3(0.0, 1.5, 0.25), vec3(1.25, 0.0, 0.0));
        let across = e1.cross(e2);
        let area = 0.5 * across.length();
        let light = Light::Triangle {
            v0,
            e1,
            e2,
            normal: across.normalize(),
            area,
            color: Vec3::ONE,
            texture: crate::material::NONE,
            is_two_sided: false,
            samples: 1,
            instance: 0,
            primitive: 0,
        };
        let mean = |f: &dyn Fn(&LightSample) -> f32| {
            let sample = |i| light.sample_li(Vec3::ZERO, point_2d(i, 9), true);
            (0..1 << 16).map(|i| f64::from(f(&sample(i)))).sum::<f64>() / f64::from(1 << 16)
        };
        let by_density = mean(&|s| 1.0 / light.pdf_li(Vec3::ZERO, s.to_light, s.distance));
        let by_weight = mean(&|s| s.weight);
        let [a, b, c] = [v0, v0 + e1, v0 + e2];
        let triple = a.dot(b.cross(c));
        let lengths = [a, b, c].map(|v| v.length());
        let below = lengths[0] * lengths[1] * lengths[2]
            + a.dot(b) * lengths[2]
            + b.dot(c) * lengths[0]
            + c.dot(a) * lengths[1];
        let solid_angle = 2.0 * f64::from(triple.abs()).atan2(f64::from(below));
        assert!((by_density - solid_angle).abs() < 1e-4 * solid_angle, "{by_density} {solid_angle}");
        assert!((by_weight - solid_angle).abs() < 1e-4 * solid_angle, "{by_weight} {solid_angle}");
        // Nothing to the other side.
        assert_eq!(light.pdf_li(Vec3::ZERO, vec3(0.0, 0.0, -1.0), 1.0), 0.0);
    }

    /// Directions to a sphere meet it, from near and far: the weight is the solid angle, and the mean direction is the axis times
    /// the mean cosine.
    #[test]
    fn spheres_are_as_dense_as_is_said() {
        for (distance, radius) in [(1.001f32, 1.0f32), (1.5, 1.0), (20.0, 1.0), (1e4, 1.0), (1e6, 1e-3)] {
            let light = Light::Sphere {
                center: vec3(0.0, 0.0, distance),
                radius,
                color: Vec3::ONE,
                instance: 0,
                primitive: 0,
            };
            let sine_squared = (f64::from(radius) / f64::from(distance)).powi(2);
            let cos = (1.0 - sine_squared).sqrt();
            let angle = 2.0 * std::f64::consts::PI * sine_squared / (1.0 + cos);
            let (mut sum, count) = ([0.0f64; 3], 1 << 14);
            for i in 0..count {
                let sample = light.sample_li(Vec3::ZERO, point_2d(i, 3), true);
                assert!(
                    (f64::from(sample.weight) / angle - 1.0).abs()
                        < 1e-3 * f64::from(distance / (distance - radius)).min(3.0)
                );
                let density = light.pdf_li(Vec3::ZERO, sample.to_light, sample.distance);
                assert!((density * sample.weight - 1.0).abs() < 1e-5);
                // On the sphere, as far as single precision has it.
                let point = sample.to_light * sample.distance;
                let off = (point - vec3(0.0, 0.0, distance)).length() - radius;
                assert!(off.abs() <= 4e-3 * radius + 1e-6 * distance, "{off} {distance}");
                sum[0] += f64::from(sample.to_light.x);
                sum[1] += f64::from(sample.to_light.y);
                sum[2] += f64::from(sample.to_light.z);
            }
            let [x, y, z] = sum.map(|s| s / f64::from(count));
            assert!(x.abs() < 1e-3 && y.abs() < 1e-3 && (z - 0.5 * (1.0 + cos)).abs() < 1e-3, "{x} {y} {z}");
        }
        let around =
            Light::Sphere { center: Vec3::ZERO, radius: 2.0, color: Vec3::ONE, instance: 0, primitive: 0 };
        assert_eq!(around.sample_li(vec3(0.5, 0.0, 0.0), [0.5; 2], true).weight, 0.0);
        assert_eq!(around.pdf_li(vec3(0.5, 0.0, 0.0), vec3(0.0, 1.0, 0.0), 1.0), 0.0);
    }
}
