//! Far and huge things that no ray of a picture meets, added to its scene.
//!
//! Every query of the picture is written down. A thing is put into a ball that none of them comes near; when the scene with
//! it is traced, its queries are held against the ball again.

use eosphor_accel::{BuildOptions, Bvh, SceneGeometry};
use eosphor_core::hierarchy::{IgnoreWork, Tracer};
use eosphor_core::integrator::{RayCounts, render_pixel};
use eosphor_core::math::{Vec3, vec3};
use eosphor_core::ray::{Hit, Ray, RayFilter};
use eosphor_scene::{
    Instance, Material, MaterialKind, Mesh, NO_INDEX, Scene, SceneData, Sphere, Transform, Triangle,
};
use std::cell::RefCell;

/// A ray of the picture up to where its query ended.
#[derive(Clone, Copy)]
struct Segment {
    origin: [f64; 3],
    direction: [f64; 3],
    end: f64,
}

impl Segment {
    fn new(ray: &Ray, end: f32) -> Segment {
        Segment { origin: double(ray.origin), direction: double(ray.direction), end: end as f64 }
    }

    /// How near it comes to a point.
    fn distance(&self, point: [f64; 3]) -> f64 {
        let offset = [0, 1, 2].map(|i| point[i] - self.origin[i]);
        let dot = |a: [f64; 3], b: [f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
        let t = (dot(offset, self.direction) / dot(self.direction, self.direction)).clamp(0.0, self.end);
        let rest = [0, 1, 2].map(|i| offset[i] - t * self.direction[i]);
        dot(rest, rest).sqrt()
    }
}

fn double(v: Vec3) -> [f64; 3] {
    [v.x as f64, v.y as f64, v.z as f64]
}

/// Writes down what is asked.
struct Recorder<T> {
    tracer: T,
    segments: RefCell<Vec<Segment>>,
}

impl<T: Tracer> Tracer for Recorder<T> {
    fn closest_hit(&self, ray: &Ray, filter: &RayFilter) -> Hit {
        let hit = self.tracer.closest_hit(ray, filter);
        self.segments.borrow_mut().push(Segment::new(ray, hit.t));
        hit
    }

    fn occluded(&self, ray: &Ray, filter: &RayFilter) -> bool {
        self.segments.borrow_mut().push(Segment::new(ray, ray.t_max));
        self.tracer.occluded(ray, filter)
    }

    fn next_hit(&self, ray: &Ray, filter: &RayFilter, after: &Hit) -> Hit {
        let hit = self.tracer.next_hit(ray, filter, after);
        self.segments.borrow_mut().push(Segment::new(ray, hit.t));
        hit
    }
}

/// The queries of a picture.
pub(crate) struct Queries(Vec<Segment>);

impl Queries {
    pub(crate) fn of(data: &SceneData) -> Queries {
        let geometry = SceneGeometry::new(&data.triangles, &data.spheres, &data.geometries, &data.instances)
            .expect("arrays that hold together");
        let bvh = Bvh::build(&geometry, &BuildOptions::default());
        let recorder = Recorder { tracer: bvh.tracer(IgnoreWork), segments: RefCell::default() };
        let view = data.view();
        for y in 0..data.settings.height {
            for x in 0..data.settings.width {
                render_pixel::<_, 1>(&view, &recorder, x, y, &mut RayCounts::default());
            }
        }
        Queries(recorder.segments.into_inner())
    }

    pub(crate) fn count(&self) -> usize {
        self.0.len()
    }

    /// How many of them enter one of the balls.
    pub(crate) fn met(&self, balls: &[Ball]) -> usize {
        let enters = |s: &&Segment| balls.iter().any(|b| s.distance(double(b.center)) <= b.radius as f64);
        self.0.iter().filter(enters).count()
    }

    /// The largest ball about a point that is free of them by a good margin; small ones are none.
    fn free_ball(&self, center: Vec3, at_most: f64) -> Option<Ball> {
        let free = self.0.iter().fold(f64::INFINITY, |least, s| least.min(s.distance(double(center))));
        let radius = (0.8 * free).min(at_most);
        (radius > 1e-4 * at_most).then_some(Ball { center, radius: radius as f32 })
    }
}

/// What holds an added thing.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Ball {
    pub(crate) center: Vec3,
    pub(crate) radius: f32,
}

/// SplitMix64 (Steele et al. 2014).
pub(crate) struct Random(pub(crate) u64);

impl Random {
    pub(crate) fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    pub(crate) fn below(&mut self, n: usize) -> usize {
        (self.bits() % n as u64) as usize
    }

    pub(crate) fn unit(&mut self) -> f32 {
        (self.bits() >> 40) as f32 / (1u32 << 24) as f32
    }

    pub(crate) fn in_cube(&mut self) -> Vec3 {
        let mut part = || self.unit() * 2.0 - 1.0;
        vec3(part(), part(), part())
    }
}

/// A scene and what was added to it.
pub(crate) struct Extended {
    pub(crate) scene: Scene,
    pub(crate) balls: Vec<Ball>,
}

/// Adds a ball, triangles, and two instances of a new mesh, after all else: `times` the extent of the scene away, as large
/// as rays leave room for. `None` where they leave none.
pub(crate) fn add_far_things(
    scene: &Scene,
    queries: &Queries,
    extent: f32,
    times: f32,
    random: &mut Random,
) -> Option<Extended> {
    let mut scene = scene.clone();
    let mut balls = Vec::new();
    let mut place = |random: &mut Random| {
        let reach = (extent * times) as f64;
        let ball = (0..64).find_map(|_| {
            let away = random.in_cube();
            let outside = away.length() > 0.1;
            let center = away.normalize_or(Vec3::ONE) * (extent * times);
            queries.free_ball(center, 0.4 * reach).filter(|_| outside)
        })?;
        balls.push(ball);
        Some(ball)
    };
    let kind = MaterialKind::Matte { color: Vec3::splat(0.5) };
    scene.materials.push(Material::new("far", kind));
    let material = scene.materials.len() as u32 - 1;
    // Triangles that are baked: large ones from side to side of their ball.
    let ball = place(random)?;
    let soup: Vec<Vec3> = (0..36)
        .map(|_| ball.center + random.in_cube().normalize_or(Vec3::ONE) * (0.9 * ball.radius))
        .collect();
    add_mesh(&mut scene, soup, material);
    scene.instances.push(Instance::new(scene.meshes.len() as u32 - 1, Transform::default()));
    // More than are baked, placed twice.
    let cloud: Vec<Vec3> = (0..900).map(|_| random.in_cube() * 0.55).collect();
    add_mesh(&mut scene, cloud, material);
    for _ in 0..2 {
        let ball = place(random)?;
        let map = Transform {
            scale: Vec3::splat(ball.radius),
            rotate_degrees: random.in_cube() * 180.0,
            ..Transform::translation(ball.center)
        };
        scene.instances.push(Instance::new(scene.meshes.len() as u32 - 1, map));
    }
    let ball = place(random)?;
    scene.spheres.push(Sphere { center: ball.center, radius: ball.radius, material });
    Some(Extended { scene, balls })
}

/// Three points after the other are a triangle.
fn add_mesh(scene: &mut Scene, positions: Vec<Vec3>, material: u32) {
    let none = [NO_INDEX; 3];
    let triangles = (0..positions.len() as u32 / 3)
        .map(|k| Triangle { positions: [3 * k, 3 * k + 1, 3 * k + 2], normals: none, uvs: none, material })
        .collect();
    scene.meshes.push(Mesh { name: "far".into(), positions, triangles, ..Mesh::default() });
}
