//! The octrees on the Cornell box: every ray of its picture.

use crate::fused::Fused;
use crate::support::World;
use eosphor_accel::{Exhaustive, Octree, OctreeOptions};
use eosphor_core::hierarchy::{IgnoreWork, Tracer};
use eosphor_core::math::{Vec3, vec3};
use eosphor_core::ray::{Hit, PrimitiveId, Ray, RayFilter};

/// The triangles of a file of `v` and `f` lines, as the Cornell box has.
fn read(obj: &str) -> Vec<[Vec3; 3]> {
    let (mut points, mut triangles): (Vec<Vec3>, Vec<[Vec3; 3]>) = (Vec::new(), Vec::new());
    for line in obj.lines() {
        let mut words = line.split_whitespace();
        match words.next() {
            Some("v") => {
                let [x, y, z] = [0, 1, 2].map(|_| words.next().unwrap().parse().unwrap());
                points.push(vec3(x, y, z));
            }
            Some("f") => {
                let corners: Vec<Vec3> = words
                    .map(|w| match w.split('/').next().unwrap().parse::<isize>().unwrap() {
                        k if k < 0 => points[(points.len() as isize + k) as usize],
                        k => points[k as usize - 1],
                    })
                    .collect();
                triangles.extend((1..corners.len() - 1).map(|k| [corners[0], corners[k], corners[k + 1]]));
            }
            _ => {}
        }
    }
    triangles
}

/// The box with spheres that is built into the program.
fn cornell_box() -> Vec<[Vec3; 3]> {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../scene/builtin/cornell/CornellBox-Sphere.obj");
    let triangles = read(&std::fs::read_to_string(path).expect("the workspace has the Cornell box"));
    assert_eq!(triangles.len(), 2188);
    triangles
}

/// The lamp: the last two triangles.
const LAMP: u32 = 2186;
/// Triangles of the two balls come first.
const BALLS: u32 = 2176;
/// Width and height of the picture: 100, or 200 where more cases are asked for.
fn size() -> usize {
    if crate::times() > 1 { 200 } else { 100 }
}

/// A picture's worth of rays: at every point one to the lamp, leaving its triangle out, and a mirrored
/// one; at the balls a refracted one too. They start as shading starts them.
fn trace_picture(triangles: &[[Vec3; 3]], mut trace: impl FnMut(&Ray, &RayFilter) -> Hit) {
    let unit = |v: Vec3| v.normalize_or(vec3(0.0, 1.0, 0.0));
    let size = size();
    for pixel in 0..size * size {
        let at = |k: usize| (k as f32 + 0.5 - size as f32 * 0.5) * (0.618_67 / size as f32);
        let direction = unit(vec3(at(pixel % size), -at(pixel / size), -1.0));
        let camera = Ray { origin: vec3(0.0, 0.795, 4.42), t_min: 0.0, direction, t_max: f32::INFINITY };
        let mut pending = vec![(camera, RayFilter::ALL, 0)];
        while let Some((ray, filter, depth)) = pending.pop() {
            let hit = trace(&ray, &filter);
            if hit.is_miss() || hit.id.primitive >= LAMP {
                continue;
            }
            let [a, b, c] = triangles[hit.id.primitive as usize];
            let normal = unit((b - a).cross(c - a));
            let facing = if normal.dot(ray.direction) < 0.0 { normal } else { -normal };
            let point = a.plus_scaled(b - a, hit.u).plus_scaled(c - a, hit.v);
            let offset = (2.0 + hit.t) / 131_072.0;
            let from = RayFilter { start: hit.id, ..RayFilter::ALL };
            let start = |side: Vec3, direction: Vec3, t_max: f32| Ray {
                origin: point.plus_scaled(side, offset),
                t_min: 0.0,
                direction,
                t_max,
            };
            let lamp = LAMP + (pixel % 2) as u32;
            let [a, b, c] = triangles[lamp as usize];
            let share = (pixel * 7 % 64) as f32 / 64.0;
            let to = a + (b - a) * (share * 0.5) + (c - a) * (0.5 - share * 0.5) - point;
            let target = PrimitiveId { instance: 0, primitive: lamp };
            let t_max = to.length() * (1.0 - 1.0 / 8192.0);
            trace(&start(facing, unit(to), t_max), &RayFilter { target, ..from });
            let is_ball = hit.id.primitive < BALLS;
            if depth >= if is_ball { 4 } else { 1 } {
                continue;
            }
            let d = ray.direction;
            let mirrored = d.plus_scaled(facing, -2.0 * d.dot(facing));
            pending.push((start(facing, unit(mirrored), f32::INFINITY), from, depth + 1));
            if is_ball {
                let eta = if normal.dot(d) < 0.0 { 1.0 / 1.52 } else { 1.52 };
                let cos = -d.dot(facing);
                let k = 1.0 - eta * eta * (1.0 - cos * cos);
                if k > 0.0 {
                    let refracted = (d * eta).plus_scaled(facing, eta * cos - k.sqrt());
                    pending.push((start(-facing, unit(refracted), f32::INFINITY), from, depth + 1));
                }
            }
        }
    }
}

#[test]
fn octrees_find_every_hit_of_the_cornell_box_picture() {
    let triangles = cornell_box();
    let world = World::new(triangles.clone(), vec![]);
    // The renderer's own octree, and one as fine as PG1's.
    let usual = OctreeOptions::default();
    let fine = OctreeOptions { only_if_cheaper: false, max_leaf_primitives: 8, ..usual };
    let octrees = [usual, fine].map(|options| Octree::build(&world.geometry(), &options));
    let exhaustive = Exhaustive::new(&world.geometry());
    let reference = Fused(exhaustive.tracer(IgnoreWork));
    let bits = |h: Hit| (h.t.to_bits(), h.u.to_bits(), h.v.to_bits(), h.id);
    let mut count = 0;
    trace_picture(&triangles, |ray, filter| {
        count += 1;
        let expected = reference.closest_hit(ray, filter);
        for octree in &octrees {
            let basic = Fused(octree.tracer(IgnoreWork));
            let parametric = Fused(octree.parametric_tracer(IgnoreWork));
            for (name, hit, hidden) in [
                ("basic", basic.closest_hit(ray, filter), basic.occluded(ray, filter)),
                ("parametric", parametric.closest_hit(ray, filter), parametric.occluded(ray, filter)),
            ] {
                assert_eq!(bits(hit), bits(expected), "{name}: {hit:?} instead of {expected:?} for {ray:?}");
                assert_eq!(hidden, !expected.is_miss(), "{name}: {ray:?}");
            }
        }
        expected
    });
    println!("{count} rays");
    assert!(count > 3 * size() * size());
}
