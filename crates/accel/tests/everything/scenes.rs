//! Worlds that are hard on structures.

use crate::support::{Random, World, affine};
use eosphor_core::geometry::Sphere;
use eosphor_core::intersect::longest_edge_last;
use eosphor_core::math::{Affine, Vec3, vec3};

/// What the primitives of a geometry are like.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Kind {
    /// Anywhere, of one size.
    Soup,
    /// Corners on few planes: flat, coplanar, equal and degenerate things abound, and they lie between cells.
    OnPlanes,
    /// A tessellated square across an axis.
    AxisFlat,
    /// A tessellated surface: every edge is shared.
    Mesh,
    Slivers,
    /// Many times the same few triangles.
    Coincident,
    /// In one plane, slanted, one over the other.
    Coplanar,
    /// Points and lines, and hardly more than that.
    Degenerate,
    /// From very small to very large, all about one point.
    ManySizes,
    Spheres,
    Mixed,
    Single,
    Nothing,
}

impl Kind {
    pub(crate) const ALL: [Kind; 13] = [
        Kind::Soup,
        Kind::OnPlanes,
        Kind::AxisFlat,
        Kind::Mesh,
        Kind::Slivers,
        Kind::Coincident,
        Kind::Coplanar,
        Kind::Degenerate,
        Kind::ManySizes,
        Kind::Spheres,
        Kind::Mixed,
        Kind::Single,
        Kind::Nothing,
    ];
}

/// Triangles and spheres of a geometry.
pub(crate) type Primitives = (Vec<[Vec3; 3]>, Vec<Sphere>);

/// Of a kind, about `count` primitives in the cube from -1 to 1.
pub(crate) fn primitives(kind: Kind, count: usize, random: &mut Random) -> Primitives {
    let mut spheres = Vec::new();
    let mut triangles: Vec<[Vec3; 3]> = match kind {
        Kind::Soup => {
            let size = [0.05, 0.3, 1.5][random.below(3)];
            (0..count).map(|_| around(random.in_cube(), size, random)).collect()
        }
        Kind::OnPlanes => (0..count).map(|_| [0, 1, 2].map(|_| on_planes(random))).collect(),
        Kind::AxisFlat => {
            let (axis, height) = (random.below(3), [random.in_cube().x, 0.0, -0.0, 0.5][random.below(4)]);
            tessellated(count, |u, v| match axis {
                0 => vec3(height, u, v),
                1 => vec3(u, height, v),
                _ => vec3(u, v, height),
            })
        }
        Kind::Mesh => {
            let (a, b) = (random.unit() as f32 * 4.0, random.unit() as f32 * 4.0);
            tessellated(count, |u, v| vec3(u, v, 0.4 * (a * u + 0.3).sin() * (b * v).cos()))
        }
        Kind::Slivers => (0..count).map(|_| sliver(random)).collect(),
        Kind::Coincident => {
            let different: Vec<_> = (0..3).map(|_| around(Vec3::ZERO, 1.0, random)).collect();
            (0..count).map(|i| different[i * i % 3]).collect()
        }
        Kind::Coplanar => {
            let (origin, u, v) = (random.in_cube() * 0.2, random.in_cube(), random.in_cube());
            let mut point = || origin + u * (random.in_cube().x * 0.5) + v * (random.in_cube().x * 0.5);
            (0..count).map(|_| [point(), point(), point()]).collect()
        }
        Kind::Degenerate => (0..count).map(|_| degenerate(random)).collect(),
        Kind::ManySizes => {
            let at = [Vec3::ZERO, random.in_cube()][random.below(2)];
            (0..count).map(|_| around(at, 10f32.powf(-12.0 * random.unit() as f32), random)).collect()
        }
        Kind::Spheres => {
            spheres.extend((0..count).map(|_| sphere(random)));
            Vec::new()
        }
        Kind::Mixed => {
            let mut all = Vec::new();
            for kind in [Kind::Soup, Kind::OnPlanes, Kind::Slivers, Kind::Degenerate, Kind::Spheres] {
                let (t, s) = primitives(kind, count / 5 + 1, random);
                all.extend(t);
                spheres.extend(s);
            }
            all
        }
        Kind::Single => {
            if random.below(3) == 0 {
                spheres.push(sphere(random));
                Vec::new()
            } else {
                vec![around(Vec3::ZERO, 1.0, random)]
            }
        }
        Kind::Nothing => Vec::new(),
    };
    // As flattening leaves them, and as nobody does.
    if random.below(2) == 0 {
        for triangle in &mut triangles {
            let first = longest_edge_last(triangle);
            triangle.rotate_left(first);
        }
    }
    (triangles, spheres)
}

fn around(at: Vec3, size: f32, random: &mut Random) -> [Vec3; 3] {
    [0, 1, 2].map(|_| at + random.in_cube() * size)
}

/// A square from -1 to 1 in two numbers, of about `count` triangles.
fn tessellated(count: usize, at: impl Fn(f32, f32) -> Vec3) -> Vec<[Vec3; 3]> {
    let n = ((count / 2) as f64).sqrt().max(1.0) as usize;
    let at = |i: usize, j: usize| {
        let [u, v] = [i, j].map(|k| k as f32 * 2.0 / n as f32 - 1.0);
        at(u, v)
    };
    (0..n * n)
        .map(|k| (k / n, k % n))
        .flat_map(|(i, j)| {
            let corners = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
            [[corners[0], corners[1], corners[2]], [corners[0], corners[2], corners[3]]]
        })
        .collect()
}

fn sliver(random: &mut Random) -> [Vec3; 3] {
    let (a, b, part) = (random.in_cube(), random.in_cube(), random.unit() as f32);
    let off = random.in_cube() * 10f32.powi(-2 - random.below(8) as i32);
    [a, b, a + (b - a) * part + off]
}

fn degenerate(random: &mut Random) -> [Vec3; 3] {
    let (a, b) = (random.in_cube(), random.in_cube());
    match random.below(6) {
        0 => [a, a, a],
        1 => [a, b, a],
        2 => [a, a, b],
        3 => [a, b, a + (b - a) * 0.5],
        4 => [a, vec3(a.x.next_up(), a.y, a.z), vec3(a.x, a.y.next_down(), a.z)],
        _ => sliver(random),
    }
}

fn sphere(random: &mut Random) -> Sphere {
    if random.below(2) == 0 {
        Sphere { center: random.in_cube(), radius: 10f32.powf(random.unit() as f32 * 4.0 - 4.0) }
    } else {
        Sphere { center: on_planes(random), radius: [0.25, 0.5, 1.0][random.below(3)] }
    }
}

/// A point with coordinates that are multiples of a quarter, where halving the unit cube puts planes.
pub(crate) fn on_planes(random: &mut Random) -> Vec3 {
    let mut part = || (random.below(9) as f32 - 4.0) * 0.25;
    vec3(part(), part(), part())
}

/// Where the cube from -1 to 1 is put: size and centre.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Frame {
    pub(crate) size: f32,
    pub(crate) center: Vec3,
}

impl Frame {
    pub(crate) const UNIT: Frame = Frame { size: 1.0, center: Vec3::ZERO };

    pub(crate) fn put(&self, p: Vec3) -> Vec3 {
        p * self.size + self.center
    }

    fn put_all(&self, (triangles, spheres): Primitives) -> Primitives {
        let sphere = |s: &Sphere| Sphere { center: self.put(s.center), radius: s.radius * self.size };
        (triangles.iter().map(|t| t.map(|p| self.put(p))).collect(), spheres.iter().map(sphere).collect())
    }

    fn place(&self, map: &Affine) -> Affine {
        Affine { columns: map.columns.map(|v| v * self.size), translation: self.put(map.translation) }
    }
}

/// A world of one kind in a frame, with `instances` placements of up to three geometries of another kind.
pub(crate) fn world(
    kinds: [Kind; 2],
    counts: [usize; 2],
    instances: usize,
    frame: &Frame,
    random: &mut Random,
) -> World {
    let (triangles, spheres) = frame.put_all(primitives(kinds[0], counts[0], random));
    let mut world = World::new(triangles, spheres);
    if instances > 0 {
        let geometries: Vec<u32> = (0..1 + random.below(3))
            .map(|_| {
                let (triangles, spheres) = primitives(kinds[1], counts[1], random);
                world.add_geometry(&triangles, &spheres)
            })
            .collect();
        let mut map = placement(random);
        for _ in 0..instances {
            // Now and then twice at the same place.
            if random.below(5) > 0 {
                map = placement(random);
            }
            world.add_instance(geometries[random.below(geometries.len())], frame.place(&map));
        }
    }
    world
}

/// Scale, rotation and place of an instance: uneven, mirrored, one over the other.
fn placement(random: &mut Random) -> Affine {
    let even = [1.0, 0.3, -1.0][random.below(3)];
    let mut scale = || [1.0, -1.0, 0.01, 0.4, 2.5, -0.7][random.below(6)];
    let uneven = vec3(scale(), scale(), scale());
    let scale = if random.below(2) == 0 { Vec3::splat(even) } else { uneven };
    let mut angle = || [0.0, std::f64::consts::FRAC_PI_2, random.unit() * 6.0][random.below(3)];
    let angles = [angle(), angle(), angle()];
    let at = match random.below(3) {
        0 => Vec3::ZERO,
        1 => on_planes(random),
        _ => random.in_cube(),
    };
    affine(scale, angles, at)
}

/// All triangles where they are in the world, but no more than a few of each instance.
pub(crate) fn placed_triangles(world: &World, random: &mut Random) -> Vec<[Vec3; 3]> {
    let mut all = Vec::new();
    for instance in &world.instances {
        let g = &world.geometries[instance.geometry as usize];
        let triangles = &world.triangles[g.first_triangle as usize..][..g.triangle_count as usize];
        let map = &instance.world_from_object;
        if !triangles.is_empty() {
            all.extend((0..40).map(|_| triangles[random.below(triangles.len())].map(|p| map.point(p))));
        }
    }
    all
}

/// As [`placed_triangles`], centres and a point on each sphere's surface.
pub(crate) fn placed_spheres(world: &World, random: &mut Random) -> Vec<[Vec3; 2]> {
    let mut all = Vec::new();
    for instance in &world.instances {
        let g = &world.geometries[instance.geometry as usize];
        let spheres = &world.spheres[g.first_sphere as usize..][..g.sphere_count as usize];
        let map = &instance.world_from_object;
        if !spheres.is_empty() {
            all.extend((0..10).map(|_| {
                let s = &spheres[random.below(spheres.len())];
                [s.center, s.center + random.direction() * s.radius].map(|p| map.point(p))
            }));
        }
    }
    all
}
