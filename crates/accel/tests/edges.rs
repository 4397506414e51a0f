//! Closed meshes have no holes, and hits are where double precision says.

mod support;

use eosphor_accel::{BuildOptions, Bvh, Exhaustive};
use eosphor_core::hierarchy::{IgnoreWork, Tracer};
use eosphor_core::intersect::longest_edge_last;
use eosphor_core::math::{Vec3, vec3};
use eosphor_core::ray::{Hit, Ray, RayFilter};
use std::collections::HashMap;
use support::{Random, World};

type V = [f64; 3];

fn double(v: Vec3) -> V {
    [v.x as f64, v.y as f64, v.z as f64]
}
fn sub(a: V, b: V) -> V {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}
fn dot(a: V, b: V) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}
fn cross(a: V, b: V) -> V {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}
fn along(a: V, d: V, t: f64) -> V {
    [a[0] + d[0] * t, a[1] + d[1] * t, a[2] + d[2] * t]
}
fn length(v: V) -> f64 {
    dot(v, v).sqrt()
}
fn unit(v: V) -> V {
    v.map(|x| x / length(v))
}

// --- Closed meshes ---------------------------------------------------------------------------------------------------

/// A closed mesh, counter-clockwise from outside, with what is needed to aim at it.
struct Mesh {
    name: &'static str,
    positions: Vec<V>,
    triangles: Vec<[usize; 3]>,
    /// Points well inside.
    inside: Vec<V>,
}

fn icosphere(levels: u32) -> Mesh {
    let g = (1.0 + 5f64.sqrt()) / 2.0;
    let mut positions: Vec<V> = Vec::new();
    for (a, b) in [(1.0, g), (-1.0, g), (1.0, -g), (-1.0, -g)] {
        positions.extend([[0.0, a, b], [a, b, 0.0], [b, 0.0, a]].map(unit));
    }
    let edge = 2.0 / (1.0 + g * g).sqrt();
    let near = |a: V, b: V| length(sub(a, b)) < edge * 1.01;
    let mut triangles = Vec::new();
    for (i, &a) in positions.iter().enumerate() {
        for (j, &b) in positions.iter().enumerate().skip(i + 1).filter(|(_, b)| near(a, **b)) {
            for (k, &c) in
                positions.iter().enumerate().skip(j + 1).filter(|(_, c)| near(a, **c) && near(b, **c))
            {
                let outward = dot(cross(sub(b, a), sub(c, a)), a) > 0.0;
                triangles.push(if outward { [i, j, k] } else { [i, k, j] });
            }
        }
    }
    for _ in 0..levels {
        let mut middles = HashMap::new();
        let mut middle = |a: usize, b: usize, positions: &mut Vec<V>| {
            *middles.entry((a.min(b), a.max(b))).or_insert_with(|| {
                positions.push(unit(along(positions[a], positions[b], 1.0)));
                positions.len() - 1
            })
        };
        triangles = triangles
            .iter()
            .flat_map(|&[a, b, c]| {
                let [ab, bc, ca] = [(a, b), (b, c), (c, a)].map(|(x, y)| middle(x, y, &mut positions));
                [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
            })
            .collect();
    }
    Mesh { name: "icosphere", positions, triangles, inside: vec![[0.0; 3], [0.3, -0.2, 0.5]] }
}

/// A bumpy grid whose opposite sides are one: a torus.
fn bumpy_torus(around: usize, across: usize) -> Mesh {
    let mut random = Random(11);
    let mut positions = Vec::new();
    let turn = std::f64::consts::TAU;
    for i in 0..around {
        for j in 0..across {
            let (p, q) = (i as f64 / around as f64 * turn, j as f64 / across as f64 * turn);
            let tube = 0.3 * (1.0 + 0.25 * (random.unit() - 0.5));
            let ring = 0.7 + tube * q.cos();
            positions.push([ring * p.cos(), ring * p.sin(), tube * q.sin()]);
        }
    }
    let mut triangles = Vec::new();
    for i in 0..around {
        for j in 0..across {
            let at = |di: usize, dj: usize| (i + di) % around * across + (j + dj) % across;
            let (a, b, c, d) = (at(0, 0), at(1, 0), at(1, 1), at(0, 1));
            triangles.extend([[a, b, c], [a, c, d]]);
        }
    }
    let inside = (0..8).map(|k| k as f64 / 8.0 * turn).map(|p| [0.7 * p.cos(), 0.7 * p.sin(), 0.0]).collect();
    Mesh { name: "bumpy torus", positions, triangles, inside }
}

fn cube() -> Mesh {
    let sign = |i: usize, bit: usize| if i & bit == 0 { -1.0 } else { 1.0 };
    let positions = (0..8).map(|i| [sign(i, 1), sign(i, 2), sign(i, 4)]).collect();
    let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let triangles = quads.iter().flat_map(|q| [[q[0], q[1], q[2]], [q[0], q[2], q[3]]]).collect();
    Mesh { name: "cube", positions, triangles, inside: vec![[0.0; 3], [0.9, -0.7, 0.5]] }
}

/// A cube that is stretched into a blade: long thin triangles.
fn blade() -> Mesh {
    let mut mesh = cube();
    for p in &mut mesh.positions {
        *p = [p[0], p[1] * 0.01, p[2] * 0.2];
    }
    Mesh { name: "blade", inside: vec![[0.0; 3]], ..mesh }
}

/// Corners in the order that flattening gives them.
fn in_order(mut vertices: [Vec3; 3]) -> [Vec3; 3] {
    let first = longest_edge_last(&vertices);
    vertices.rotate_left(first);
    vertices
}

/// A mesh moved and rounded to single precision.
struct Placed {
    points: Vec<Vec3>,
    triangles: Vec<[usize; 3]>,
    /// Triangles at each vertex.
    around: Vec<Vec<usize>>,
    bvh: Bvh,
}

impl Placed {
    fn new(mesh: &Mesh, offset: V) -> Placed {
        let points: Vec<Vec3> = mesh
            .positions
            .iter()
            .map(|&p| along(p, offset, 1.0))
            .map(|p| vec3(p[0] as f32, p[1] as f32, p[2] as f32))
            .collect();
        let mut around = vec![Vec::new(); points.len()];
        for (number, triangle) in mesh.triangles.iter().enumerate() {
            triangle.iter().for_each(|&v| around[v].push(number));
        }
        let vertices = mesh.triangles.iter().map(|t| in_order(t.map(|v| points[v])));
        let world = World::new(vertices.collect(), vec![]);
        let bvh = Bvh::build(&world.geometry(), &BuildOptions::default());
        Placed { points, triangles: mesh.triangles.clone(), around, bvh }
    }

    /// Whether all these triangles show a ray clearly the same side, so that it must pass through one of them.
    fn crosses(&self, triangles: &[usize], direction: Vec3) -> bool {
        let facing = |&t: &usize| {
            let [a, b, c] = self.triangles[t].map(|v| double(self.points[v]));
            dot(unit(cross(sub(b, a), sub(c, a))), unit(double(direction)))
        };
        let clear: Vec<f64> = triangles.iter().map(facing).collect();
        clear.iter().all(|&f| f > 0.02) || clear.iter().all(|&f| f < -0.02)
    }

    /// Whether in double precision the ray hits any triangle no later than `end`.
    fn is_hit_in_double(&self, origin: Vec3, direction: Vec3, end: f32) -> bool {
        let (o, d) = (double(origin), double(direction));
        let corners = |t: &[usize; 3]| t.map(|v| double(self.points[v]));
        let t = self.triangles.iter().filter_map(|t| reference(o, d, corners(t)));
        t.fold(f64::INFINITY, f64::min) <= end as f64
    }

    fn hit(&self, origin: Vec3, direction: Vec3) -> Hit {
        let ray = Ray { origin, t_min: 0.0, direction, t_max: f32::INFINITY };
        self.bvh.tracer(IgnoreWork).closest_hit(&ray, &RayFilter::ALL)
    }
}

#[test]
fn rays_aimed_at_edges_and_vertices_of_closed_meshes_never_slip_through() {
    let meshes = [icosphere(3), bumpy_torus(48, 24), cube(), blade()];
    let (mut traced, mut missed, mut fell_through, mut passed_by) = (0u32, 0u32, 0u32, 0u32);
    let mut random = Random(1);
    for mesh in &meshes {
        let before = traced;
        for offset in [0.0, 1.0, 30.0, 1000.0] {
            let offset = [offset, -offset * 0.7, offset * 0.3];
            let placed = Placed::new(mesh, offset);
            for distance in [1.6, 30.0, 1000.0] {
                for k in 0..7000 {
                    let away = random.direction();
                    let middle = vec3(offset[0] as f32, offset[1] as f32, offset[2] as f32);
                    let eye = middle + away * (distance as f32);
                    let triangle = random.below(placed.triangles.len());
                    let [a, b, _] = placed.triangles[triangle];
                    let (target, neighbours) = if k % 3 == 0 {
                        (placed.points[a], placed.around[a].clone())
                    } else {
                        let shared = placed.around[a].iter().filter(|t| placed.around[b].contains(t));
                        let share = (placed.points[b] - placed.points[a]) * random.unit() as f32;
                        (placed.points[a] + share, shared.copied().collect())
                    };
                    // Now and then along an axis.
                    let eye = if k % 10 == 0 { axis_eye(target, &mut random, distance as f32) } else { eye };
                    let direction = (target - eye).normalize();
                    if !placed.crosses(&neighbours, direction) {
                        continue;
                    }
                    traced += 1;
                    let reach = (target - eye).length();
                    let hit = placed.hit(eye, direction);
                    // What lies before the target may be hit; what lies behind must not be.
                    let end = reach + 1e-4 * (distance + length(offset)) as f32;
                    if hit.is_miss() || hit.t > end {
                        // Targets are rounded too: of small triangles far from the origin, a ray may truly pass by.
                        if placed.is_hit_in_double(eye, direction, end) {
                            missed += hit.is_miss() as u32;
                            fell_through += (hit.t > end) as u32;
                        } else {
                            passed_by += 1;
                        }
                    }
                }
            }
        }
        println!("{}: {} rays", mesh.name, traced - before);
    }
    println!(
        "{traced} rays at edges and vertices: {missed} missed, {fell_through} fell through; {passed_by} passed by"
    );
    assert!(traced >= 200_000);
    assert!(passed_by < 10, "{passed_by}");
    assert_eq!((missed, fell_through), (0, 0));
}

/// A point from which an axis leads exactly to the target, where rounding allows.
fn axis_eye(target: Vec3, random: &mut Random, distance: f32) -> Vec3 {
    let mut eye: [f32; 3] = target.into();
    let side = if random.bits() & 1 == 0 { distance } else { -distance };
    eye[random.below(3)] += side * 2.0;
    eye.into()
}

#[test]
fn rays_from_inside_closed_meshes_never_get_out() {
    let meshes = [icosphere(3), bumpy_torus(48, 24), cube(), blade()];
    let (mut traced, mut missed) = (0u32, 0u32);
    let mut random = Random(2);
    for mesh in &meshes {
        for offset in [0.0, 1.0, 30.0, 1000.0] {
            let offset = [offset, -offset * 0.7, offset * 0.3];
            let placed = Placed::new(mesh, offset);
            for k in 0..15_000 {
                let p = along(mesh.inside[k % mesh.inside.len()], offset, 1.0);
                let eye = vec3(p[0] as f32, p[1] as f32, p[2] as f32);
                let [a, b, _] = placed.triangles[random.below(placed.triangles.len())];
                let share = random.unit() as f32;
                let at_edge = placed.points[a] + (placed.points[b] - placed.points[a]) * share;
                let direction = match k % 4 {
                    0 => (placed.points[a] - eye).normalize(),
                    1 => (at_edge - eye).normalize(),
                    _ => random.direction(),
                };
                traced += 1;
                missed += placed.hit(eye, direction).is_miss() as u32;
            }
        }
    }
    println!("{traced} rays from inside: {missed} missed");
    assert!(traced >= 200_000);
    assert_eq!(missed, 0);
}

// --- Double precision ------------------------------------------------------------------------------------------------

/// Möller and Trumbore in double precision on the same single-precision input.
fn reference(origin: V, direction: V, [a, b, c]: [V; 3]) -> Option<f64> {
    let (e1, e2) = (sub(b, a), sub(c, a));
    let p = cross(direction, e2);
    let determinant = dot(e1, p);
    if determinant == 0.0 {
        return None;
    }
    let from = sub(origin, a);
    let u = dot(from, p) / determinant;
    let q = cross(from, e1);
    let v = dot(direction, q) / determinant;
    let t = dot(e2, q) / determinant;
    (u >= 0.0 && v >= 0.0 && u + v <= 1.0 && t > 0.0).then_some(t)
}

/// How far a ray passes outside the edges of a triangle (negative: inside the nearest one): its moment about the edge,
/// which is its distance from the edge's line times the sine of the angle between both.
fn outside(origin: V, direction: V, [a, b, c]: [V; 3]) -> f64 {
    let facing = dot(cross(sub(b, a), sub(c, a)), direction);
    let moment = |a: V, b: V| dot(cross(sub(a, origin), sub(b, a)), direction) / length(sub(b, a));
    [(a, b), (b, c), (c, a)]
        .map(|(a, b)| -moment(a, b) * facing.signum())
        .into_iter()
        .fold(f64::MIN, f64::max)
}

/// What rays at a mesh showed. Errors of places are over the reach of coordinates: the largest of the mesh plus the
/// largest of the ray's origin.
#[derive(Default, Debug)]
struct Accuracy {
    hits: u32,
    /// Hits that the reference does not have, and how far outside an edge they are.
    widened: u32,
    outside: f64,
    /// Hits that only the reference has, and how far inside the edges they are.
    lost: u32,
    inside: f64,
    /// Relative error of t, and the same for rays that meet their triangle at more than 6 degrees.
    t_error: f64,
    steep_t_error: f64,
    /// Distance of the hit from the triangle's plane.
    off_plane: f64,
}

fn measure(triangles: &[[Vec3; 3]], rays: impl Iterator<Item = Ray>) -> Accuracy {
    let world = World::new(triangles.to_vec(), vec![]);
    let bvh = Bvh::build(&world.geometry(), &BuildOptions::default());
    let extent = world.extent();
    let wide: Vec<[V; 3]> = triangles.iter().map(|t| t.map(double)).collect();
    let mut accuracy = Accuracy::default();
    for ray in rays {
        let (origin, direction) = (double(ray.origin), double(ray.direction));
        let reach = (extent + ray.origin.abs().max_component()) as f64;
        let cos = |i: usize| {
            let [a, b, c] = wide[i];
            dot(unit(cross(sub(b, a), sub(c, a))), unit(direction)).abs()
        };
        let hit = bvh.tracer(IgnoreWork).closest_hit(&ray, &RayFilter::ALL);
        let found = (!hit.is_miss()).then_some(hit.id.primitive as usize);
        let found_t = found.and_then(|i| reference(origin, direction, wide[i]));
        let hits = wide.iter().enumerate().filter_map(|(i, t)| Some((reference(origin, direction, *t)?, i)));
        let best = hits.min_by(|a, b| a.0.total_cmp(&b.0));
        // Where triangles cross each other, rounding may choose either.
        let agrees = match (best, found_t) {
            (None, None) => found.is_none(),
            (Some((t, i)), Some(other)) => (other - t) * cos(i).min(cos(found.unwrap())) <= 2e-7 * reach,
            _ => false,
        };
        if !agrees {
            // Either what was found is not there, or what is there was not found.
            if let (Some(i), None) = (found, found_t) {
                accuracy.widened += 1;
                accuracy.outside = accuracy.outside.max(outside(origin, direction, wide[i]) / reach);
            } else {
                accuracy.lost += 1;
                let i = best.unwrap().1;
                accuracy.inside = accuracy.inside.max(-outside(origin, direction, wide[i]) / reach);
            }
        } else if let (Some(i), Some(t)) = (found, found_t) {
            accuracy.hits += 1;
            let error = (hit.t as f64 - t).abs();
            accuracy.t_error = accuracy.t_error.max(error / t);
            accuracy.off_plane = accuracy.off_plane.max(error * cos(i) / reach);
            if cos(i) > 0.1 {
                accuracy.steep_t_error = accuracy.steep_t_error.max(error / t);
            }
        }
    }
    accuracy
}

/// Rays between random points around a mesh, most of them towards it.
fn rays_at(points: Vec<Vec3>, distance: f32, count: usize, seed: u64) -> impl Iterator<Item = Ray> {
    let mut random = Random(seed);
    let middle = points.iter().fold(Vec3::ZERO, |s, p| s + *p * (1.0 / points.len() as f32));
    (0..count).map(move |_| {
        let origin = middle + random.direction() * distance;
        let target = points[random.below(points.len())] + random.in_cube() * 0.1;
        let direction = (target - origin).normalize();
        Ray { origin, t_min: 0.0, direction, t_max: f32::INFINITY }
    })
}

fn vertices_of(mesh: &Mesh, offset: f64) -> Vec<[Vec3; 3]> {
    let placed = Placed::new(mesh, [offset, 0.6 * offset, -0.3 * offset]);
    placed.triangles.iter().map(|t| in_order(t.map(|v| placed.points[v]))).collect()
}

#[test]
fn hits_are_those_of_double_precision() {
    let mut random = Random(4);
    let soup: Vec<[Vec3; 3]> = (0..600)
        .map(|_| {
            let at = random.in_cube();
            in_order([0, 1, 2].map(|_| at + random.in_cube() * 0.2))
        })
        .collect();
    let moved = |offset: f32| soup.iter().map(|t| t.map(|p| p + Vec3::splat(offset))).collect();
    let worlds: [(&str, Vec<[Vec3; 3]>, f32); 6] = [
        ("icosphere", vertices_of(&icosphere(3), 0.0), 2.0),
        ("bumpy torus", vertices_of(&bumpy_torus(32, 16), 0.0), 2.0),
        ("soup", soup.clone(), 2.0),
        ("soup from 1000 times its size", soup.clone(), 1000.0),
        ("soup 1000 times its size from the origin", moved(1000.0), 2.0),
        ("blade", vertices_of(&blade(), 0.0), 3.0),
    ];
    for (k, (name, triangles, distance)) in worlds.into_iter().enumerate() {
        let points: Vec<Vec3> = triangles.iter().flatten().copied().collect();
        let accuracy = measure(&triangles, rays_at(points, distance, 10_000, k as u64));
        println!("{name}: {accuracy:?}");
        assert!(accuracy.hits > 1000);
        // Far from the origin, coordinates themselves are coarser than this.
        let points_are_near = !name.ends_with("from the origin");
        // Edges are widened by 2^-21 = 4.8e-7 of the reach, the third by up to twice that.
        assert!(accuracy.outside < 1e-6 && accuracy.inside < 1e-7, "{name}: {accuracy:?}");
        // Two and a half units in the last place of the largest coordinate: `t` is that of single precision, as long as its
        // bound is within `T_ERROR`.
        assert!(accuracy.off_plane < 3e-7, "{name}: {accuracy:?}");
        if points_are_near {
            assert!(accuracy.t_error < 4e-6 && accuracy.steep_t_error < 1e-6, "{name}: {accuracy:?}");
        }
    }
}

#[test]
fn meshes_of_sizes_from_1e_minus_9_to_1e12_are_closed() {
    for exponent in -9..=12 {
        let size = 10f64.powi(exponent);
        let mut mesh = icosphere(1);
        mesh.positions.iter_mut().for_each(|p| *p = p.map(|x| x * size * 0.5));
        let placed = Placed::new(&mesh, [0.0; 3]);
        let mut random = Random((exponent + 9) as u64);
        let missed = (0..2000)
            .filter(|_| {
                let eye = random.direction() * (size as f32 * 0.9);
                placed.hit(eye, (random.in_cube() * (size as f32 * 0.1) - eye).normalize()).is_miss()
            })
            .count();
        assert_eq!(missed, 0, "size 1e{exponent}");
    }
}

// --- Slivers ---------------------------------------------------------------------------------------------------------

#[test]
fn rays_well_inside_slivers_hit_them() {
    let mut random = Random(1);
    for height in [1e-1, 1e-2, 1e-3, 1e-4, 1e-5] {
        let (mut rays, mut largest_error) = (0, 0.0f64);
        for case in 0..20_000 {
            // A long edge of length 1, the third corner above its middle or above one end.
            let (a, along_edge) = (double(random.in_cube()), double(random.direction()));
            let other = double(random.direction());
            let up = along(other, along_edge, -dot(other, along_edge));
            if length(up) < 0.1 {
                continue;
            }
            let foot = if case % 2 == 0 { 0.2 + 0.6 * random.unit() } else { 0.0 };
            let c = along(along(a, along_edge, foot), unit(up), height);
            let corners =
                [a, along(a, along_edge, 1.0), c].map(|p| vec3(p[0] as f32, p[1] as f32, p[2] as f32));
            let corners = in_order(corners);
            let [a, b, c] = corners.map(double);
            let (e1, e2) = (sub(b, a), sub(c, a));
            let normal = unit(cross(e1, e2));
            let direction = double(random.direction());
            if dot(direction, normal).abs() < 0.2 {
                continue;
            }
            let (u, v) = (0.1 + 0.4 * random.unit(), 0.1 + 0.3 * random.unit());
            let target = along(along(a, e1, u), e2, v);
            let from = along(target, direction, -0.5 - 3.0 * random.unit());
            let single = |p: V| vec3(p[0] as f32, p[1] as f32, p[2] as f32);
            let ray = Ray::new(single(from), single(direction));
            // What the rounded ray meets: its rounding moves it off the thinnest ones.
            let (o, d) = (double(ray.origin), double(ray.direction));
            let determinant = dot(cross(e1, e2), d);
            let r = cross(sub(a, o), d);
            let (u, v) = (dot(r, e2) / determinant, -dot(r, e1) / determinant);
            if u < 0.05 || v < 0.05 || u + v > 0.95 {
                continue;
            }
            let world = World::new(vec![corners], vec![]);
            let hit =
                Exhaustive::new(&world.geometry()).tracer(IgnoreWork).closest_hit(&ray, &RayFilter::ALL);
            assert!(!hit.is_miss(), "height {height}: {corners:?} {ray:?}");
            let t = dot(cross(e1, e2), sub(a, o)) / determinant;
            largest_error = largest_error.max((hit.t as f64 - t).abs());
            rays += 1;
        }
        println!("height {height}: {rays} rays, t is wrong by at most {largest_error:e}");
        assert!(rays > 1000 && largest_error < 2e-6);
    }
}
