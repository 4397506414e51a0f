//! Rays that are hard on hits.

use crate::check::Asked;
use crate::scenes::{Frame, on_planes, placed_spheres, placed_triangles};
use crate::support::{Random, World};
use eosphor_core::math::{Vec3, vec3};
use eosphor_core::ray::{PrimitiveId, Ray, RayFilter};

/// Aims rays at a world.
pub(crate) struct Aims<'a> {
    world: &'a World,
    frame: Frame,
    triangles: Vec<[Vec3; 3]>,
    spheres: Vec<[Vec3; 2]>,
}

/// How far rays depart from what a renderer asks: unit directions, `t_min` 0, origins near the scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Wildness {
    Tame,
    /// Ends anywhere, origins far away, directions of any length, numbers that are none.
    Wild,
}

impl<'a> Aims<'a> {
    pub(crate) fn new(world: &'a World, frame: Frame, random: &mut Random) -> Aims<'a> {
        let (triangles, spheres) = (placed_triangles(world, random), placed_spheres(world, random));
        Aims { world, frame, triangles, spheres }
    }

    /// Rays one by one, each on its own, and groups of neighbours; each with what it leaves out.
    pub(crate) fn rays(&self, count: usize, wildness: Wildness, random: &mut Random) -> Vec<Asked> {
        let mut asked: Vec<Asked> = Vec::new();
        while asked.len() < count {
            let ray = self.one(wildness, random);
            let filter = self.filter(random);
            asked.push((ray, filter));
            match random.below(3) {
                0 => self.neighbours(&(ray, filter), wildness, random, &mut asked),
                // The same ray again and again, which differs in one thing.
                1 if wildness == Wildness::Wild => asked.push((wild(&ray, self.frame.size, random), filter)),
                _ => {}
            }
        }
        asked.truncate(count);
        asked
    }

    /// Up to 40 rays close to one.
    fn neighbours(
        &self,
        (ray, filter): &Asked,
        wildness: Wildness,
        random: &mut Random,
        all: &mut Vec<Asked>,
    ) {
        let spread = 10f32.powi(-(random.below(7) as i32));
        let apart = [0.0, 0.0, 1e-3, 0.1][random.below(4)] * self.frame.size;
        let own_filters = random.below(3) == 0;
        let length = ray.direction.length();
        for _ in 0..random.below(40) {
            let mut near = *ray;
            near.origin += random.in_cube() * apart;
            near.direction += random.in_cube() * (spread * length);
            if wildness == Wildness::Wild && random.below(30) == 0 {
                near = wild(&near, self.frame.size, random);
            }
            all.push((near, if own_filters { self.filter(random) } else { *filter }));
        }
    }

    fn filter(&self, random: &mut Random) -> RayFilter {
        let mut any = || {
            if random.below(3) > 0 {
                return PrimitiveId::NONE;
            }
            let instance = random.below(self.world.instances.len());
            let geometry = &self.world.geometries[self.world.instances[instance].geometry as usize];
            let count = (geometry.triangle_count + geometry.sphere_count).max(1);
            PrimitiveId { instance: instance as u32, primitive: random.below(count as usize) as u32 }
        };
        let (start, target) = (any(), any());
        RayFilter { start, target, cull_back_faces: random.below(4) == 0 }
    }

    fn one(&self, wildness: Wildness, random: &mut Random) -> Ray {
        let (origin, direction) = self.aim(random);
        let t_max =
            if random.below(4) == 0 { random.unit() as f32 * 3.0 * self.frame.size } else { f32::INFINITY };
        let t_min = if random.below(8) == 0 { random.unit() as f32 * self.frame.size } else { 0.0 };
        let ray = Ray { origin, t_min, direction, t_max };
        if wildness == Wildness::Wild && random.below(3) == 0 {
            wild(&ray, self.frame.size, random)
        } else {
            ray
        }
    }

    fn aim(&self, random: &mut Random) -> (Vec3, Vec3) {
        let Frame { size, .. } = self.frame;
        let put = |p: Vec3| self.frame.put(p);
        let corners = match self.triangles.len() {
            0 => [0, 1, 2].map(|_| put(random.in_cube())),
            n => self.triangles[random.below(n)],
        };
        let [a, b, c] = corners;
        let (u, v) = (random.unit() as f32, random.unit() as f32);
        let on_edge = a + (b - a) * [0.5, u][random.below(2)];
        let inside = on_edge + (c - on_edge) * v;
        let axis = axis(random);
        let origin = match random.below(4) {
            0 => put(random.in_cube()),
            1 => put(on_planes(random)),
            2 => put(random.in_cube() * 3.0),
            _ => put(random.direction() * 10f32.powf(random.unit() as f32 * 4.0)),
        };
        let towards = |from: Vec3, to: Vec3| (to - from).normalize_or(vec3(0.0, -0.0, 1.0));
        let far = random.unit() as f32 * 3.0;
        match random.below(18) {
            0 => (origin, random.direction()),
            1 => (origin, axis),
            2 => (origin, towards(origin, corners[random.below(3)])),
            3 => (origin, towards(origin, a + (b - a) * 0.5)),
            4 => (origin, towards(origin, on_edge)),
            5 => (origin, towards(origin, inside)),
            // In the triangle's plane: from outside, along an edge, and nearly so.
            6 => (a + (a - inside) * far, towards(a, inside)),
            7 => (a + (a - b) * far, towards(a, b)),
            8 => (a + (a - inside) * far, (towards(a, inside) + random.in_cube() * 1e-6).normalize()),
            // From the surface, and from a corner.
            9 => (inside, random.direction()),
            10 => (b, axis),
            // Along an axis, exactly at a corner or an edge.
            11 => (on_edge - axis * (far * size), axis),
            12 => (a - axis * (far * size), axis),
            // Along planes between cells, and nearly so.
            13 => (put(on_planes(random)), towards(on_planes(random), on_planes(random))),
            14 => (put(on_planes(random)), (axis + random.direction() * 1e-7).normalize()),
            // In a plane across an axis.
            15 => (origin, in_plane(random)),
            // At spheres: from inside, past the surface, at the centre.
            kind => match self.spheres.len() {
                0 => (inside, axis),
                n => {
                    let [center, surface] = self.spheres[random.below(n)];
                    match (kind, random.below(3)) {
                        (16, _) => (center + (surface - center) * u, random.direction()),
                        (_, 0) => (origin, towards(origin, surface)),
                        (_, 1) => (surface, towards(surface, center)),
                        _ => {
                            let out = surface - center;
                            let along = out.cross(random.direction()).normalize_or(axis);
                            (surface - along * (far * size), along)
                        }
                    }
                }
            },
        }
    }
}

/// Along an axis, with zeros of both signs.
fn axis(random: &mut Random) -> Vec3 {
    let mut zero = || [0.0, -0.0][random.below(2)];
    let (a, b) = (zero(), zero());
    let one = [1.0, -1.0][random.below(2)];
    [vec3(one, a, b), vec3(a, one, b), vec3(a, b, one)][random.below(3)]
}

/// With one component 0.
fn in_plane(random: &mut Random) -> Vec3 {
    let d = random.direction();
    let zero = [0.0, -0.0, 1e-30, -1e-20][random.below(4)];
    [vec3(zero, d.y, d.z), vec3(d.x, zero, d.z), vec3(d.x, d.y, zero)][random.below(3)]
}

/// The ray with one thing that a renderer does not ask for.
pub(crate) fn wild(ray: &Ray, size: f32, random: &mut Random) -> Ray {
    let any = random.unit() as f32;
    let no_number = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, 1e18, -3e38, 1e19][random.below(6)];
    let poisoned = |v: Vec3, component: usize| {
        let mut parts: [f32; 3] = v.into();
        parts[component] = no_number;
        Vec3::from(parts)
    };
    match random.below(12) {
        0 => Ray { t_min: -any * 3.0 * size, ..*ray },
        1 => Ray { t_min: [f32::NEG_INFINITY, -0.0, f32::NAN, f32::INFINITY][random.below(4)], ..*ray },
        2 => Ray { t_min: 2.0 * any * size, t_max: any * size, ..*ray },
        3 => Ray { t_max: [f32::NEG_INFINITY, f32::NAN, 0.0, -0.0, -1.0][random.below(5)], ..*ray },
        4 => Ray { t_min: -2.0 * size, t_max: -any * size, ..*ray },
        // Far away, aimed at the same place.
        5 | 6 => {
            let far = 10f32.powf(2.0 + 15.0 * any);
            Ray { origin: ray.origin - ray.direction * far, ..*ray }
        }
        // Another length.
        7 => Ray { direction: ray.direction * 10f32.powf(16.0 * any), ..*ray },
        8 => Ray { direction: ray.direction * 10f32.powf(-14.0 * any), ..*ray },
        9 => Ray { direction: Vec3::ZERO, ..*ray },
        10 => Ray { origin: poisoned(ray.origin, random.below(3)), ..*ray },
        _ => Ray { direction: poisoned(ray.direction, random.below(3)), ..*ray },
    }
}
