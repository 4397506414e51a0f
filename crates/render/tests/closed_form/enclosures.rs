//! Path tracing: closed rooms and squares that face each other, with lamps found by samples of lights alone, by rays of lobes
//! alone, and by both, each without its share for the other. Samples are taken until the mean's standard deviation is as small as
//! is asked for: `EOSPHOR_TEST_DEVIATION=0.0005`.

use super::paths::{closed_box, paths, series, shining};
use super::support::*;
use eosphor_core::hierarchy::{ExhaustiveTracer, IgnoreWork, PrimitivesView, Tracer};
use eosphor_core::integrator::path::{
    Bounce, LightRequest, NumbersByKey, PathPoint, PathState, ScatterPoint, bounce,
};
use eosphor_core::integrator::{PathRay, camera_ray};
use eosphor_core::intersect::PackedTriangle;
use eosphor_core::light::light_of_primitive;
use eosphor_core::math::{Vec3, vec3};
use eosphor_core::ray::Hit;
use eosphor_core::sampling::sobol_2d;
use eosphor_core::view::SceneView;
use eosphor_scene::{Scene, SceneData};

/// How lamps are found.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Way {
    Both,
    /// Lamps that rays of lobes meet do not count.
    Lights,
    /// The scene has no lights.
    Lobes,
}

/// The relative standard deviation of a mean that is asked for.
fn goal() -> f64 {
    std::env::var("EOSPHOR_TEST_DEVIATION").map_or(0.02, |goal| goal.parse().unwrap())
}

/// What a path finds in one step.
#[derive(Default)]
struct Step {
    found: Vec3,
    request: Option<LightRequest>,
    next: Option<PathState>,
}

impl Bounce for Step {
    fn add(&mut self, found: Vec3) {
        self.found = found;
    }

    fn ask(&mut self, request: LightRequest) {
        self.request = Some(request);
    }

    fn go_on(&mut self, next: PathState) {
        self.next = Some(next);
    }
}

/// The share that a light sample was given for what lobes find, too.
fn share(view: &SceneView, path: &PathState, hit: &Hit, request: &LightRequest) -> f64 {
    let point = PathPoint::new(view, &path.ray.ray(), hit);
    let at = ScatterPoint::new(&point);
    let lobes = at.mixture.eval(at.to_frame(request.ray.direction)).pdf;
    let number = light_of_primitive(view.lights, request.filter.target).unwrap();
    let light = &view.lights[number as usize];
    let density = light.pdf_li(point.position, request.ray.direction, request.ray.t_max);
    let own = density * view.light_tree().chance(&at.receiver(&point), number);
    // A sample that grazes the lamp may have none, by another rounding.
    if own > 0.0 { 1.0 / (1.0 + (f64::from(lobes) / f64::from(own)).powi(2)) } else { 1.0 }
}

/// What a path brings.
fn radiance(view: &SceneView, tracer: &impl Tracer, first: PathRay, sample: u32, way: Way) -> f64 {
    let mut path = PathState::new(first);
    let mut sum = 0.0;
    loop {
        let hit = tracer.closest_hit(&path.ray.ray(), &path.ray.filter(view.settings));
        let numbers = NumbersByKey::new(view.settings, &path.ray, (0, 0, sample));
        let mut step = Step::default();
        bounce(view, &path, &hit, &numbers, &mut step);
        if way != Way::Lights || path.ray.depth == 0 {
            sum += f64::from(step.found.x);
        }
        if let Some(request) = step.request.filter(|request| !tracer.occluded(&request.ray, &request.filter))
        {
            let share = if way == Way::Lights { share(view, &path, &hit, &request) } else { 1.0 };
            sum += f64::from(request.contribution.x) / share;
        }
        path = match step.next {
            Some(next) => next,
            None => return sum,
        };
    }
}

/// The mean over samples of rays that `first` gives, its standard deviation over the mean, and how many there were: until that is
/// small enough, or there are `most`.
fn mean(scene: &Scene, way: Way, most: u32, first: impl Fn(&SceneView, u32) -> PathRay) -> (f64, f64, u32) {
    let (mut data, _) = SceneData::flatten(scene).unwrap();
    if way == Way::Lobes {
        (data.lights, data.light_nodes, data.light_places) = Default::default();
    }
    let triangles: Vec<_> = (0..).zip(&data.triangles).map(|(i, v)| PackedTriangle::new(*v, i)).collect();
    let sphere_primitives: Vec<_> =
        (0..data.spheres.len() as u32).map(|i| triangles.len() as u32 + i).collect();
    let view = data.view();
    let primitives = PrimitivesView {
        triangles: &triangles,
        spheres: view.spheres,
        sphere_primitives: &sphere_primitives,
        geometries: view.geometries,
        instances: view.instances,
    };
    // SAFETY: closed views: flattening made the arrays, of one geometry.
    let tracer = unsafe { ExhaustiveTracer::new(primitives, IgnoreWork) };
    let (mut sum, mut squares, mut count) = (0.0, 0.0, 0);
    loop {
        for sample in count..count + 1024 {
            let got = radiance(&view, &tracer, first(&view, sample), sample, way);
            (sum, squares) = (sum + got, squares + got * got);
        }
        count += 1024;
        let n = f64::from(count);
        let mean = sum / n;
        let deviation = ((squares / n - mean * mean).max(0.0) / n).sqrt() / mean;
        if deviation < goal() || count >= most {
            return (mean, deviation, count);
        }
    }
}

#[track_caller]
fn compare(name: &str, expected: f64, (got, deviation, count): (f64, f64, u32)) {
    let off = got / expected - 1.0;
    println!("{name}: {got:.6} of {expected:.6}, off by {off:.1e}; sigma {deviation:.1e} of {count}");
    // Some bits are lost in single precision.
    assert!(off.abs() < 4.0 * deviation + 1e-5, "{name}: {got} of {expected}");
}

/// Le / (1 - albedo) in a box and in a sphere, and the geometric sum where paths are cut.
#[test]
fn closed_rooms_by_each_way() {
    let albedos: &[f32] = if goal() < 0.01 { &[0.2, 0.5, 0.8, 0.95] } else { &[0.5, 0.95] };
    for &albedo in albedos {
        for (depth, roulette) in [(64, 64), (64, 2), (3, 64)] {
            let room = |make: &dyn Fn(&mut Scene, u32)| {
                let mut room = paths(1, depth);
                room.settings.roulette = roulette;
                let walls = shining(&mut room, albedo, 0.5);
                make(&mut room, walls);
                room.camera = Some(looking(vec3(0.2, -0.3, 0.4), vec3(1.0, 0.5, 0.0), 10.0));
                room
            };
            let flat = room(&|room, walls| closed_box(room, vec3(1.0, 2.0, 3.0), walls));
            let round = room(&|room, walls| sphere(room, vec3(0.1, 0.2, -0.3), 2.0, walls));
            let expected = series(0.5, f64::from(albedo), depth as i32);
            // A sphere is no light from within.
            let cases = [(&flat, Way::Both), (&flat, Way::Lobes), (&flat, Way::Lights), (&round, Way::Lobes)];
            for (shape, (scene, way)) in ["box", "box", "box", "sphere"].into_iter().zip(cases) {
                let most = if way == Way::Lights { 1 << 20 } else { 1 << 24 };
                let got = mean(scene, way, most, |view, sample| camera_ray(view, 0, 0, sample));
                let name = format!("{shape}, albedo {albedo}, depth {depth}, roulette {roulette}, {way:?}");
                compare(&name, expected, got);
            }
        }
    }
}

/// Opposite and adjacent sides of a cube see 0.199825 and 0.200044 of each other (Howell, "A catalog of radiation heat transfer
/// configuration factors", C-11 and C-14).
#[test]
fn squares_see_their_part_of_each_other() {
    let half = 0.5;
    for (name, center, u, v, expected) in [
        ("opposite", vec3(0.0, 0.0, 1.0), vec3(0.0, half, 0.0), vec3(half, 0.0, 0.0), 0.199_825),
        ("adjacent", vec3(half, 0.0, half), vec3(0.0, 0.0, half), vec3(0.0, half, 0.0), 0.200_044),
    ] {
        let mut scene = paths(1, 1);
        let white = matte(&mut scene, Vec3::ONE);
        rectangle(&mut scene, Vec3::ZERO, vec3(half, 0.0, 0.0), vec3(0.0, half, 0.0), white);
        let lamp = emissive(&mut scene, Vec3::ONE);
        rectangle(&mut scene, center, u, v, lamp);
        scene.camera = Some(looking(vec3(0.1, 0.1, 0.3), Vec3::ZERO, 10.0));
        // Straight down on all of the square.
        let first = |view: &SceneView, sample: u32| {
            let [x, y] = sobol_2d(sample).map(|x| x as f32 / 4_294_967_296.0 - half);
            let down = vec3(0.0, 0.0, -1.0);
            PathRay { origin: vec3(x, y, 0.25), direction: down, ..camera_ray(view, 0, 0, sample) }
        };
        for way in [Way::Both, Way::Lobes, Way::Lights] {
            // Samples of a lamp that stands on the square have an infinite variance where they meet.
            if name == "opposite" || way != Way::Lights {
                compare(&format!("{name}, {way:?}"), expected, mean(&scene, way, 1 << 23, first));
            }
        }
    }
}

/// A small lamp straight above a point, as a parallelogram: the point's form factor, by samples of the lamp, by lobes and by both.
#[test]
fn lamps_light_points() {
    let (a, b, height) = (0.7f64, 0.4f64, 1.5f64);
    let mut scene = paths(1, 1);
    let white = matte(&mut scene, Vec3::ONE);
    floor(&mut scene, 0.0, 5.0, white);
    let lamp = emissive(&mut scene, Vec3::ONE);
    let (u, v) = (vec3(a as f32, 0.0, 0.0), vec3(0.0, 0.0, b as f32));
    rectangle(&mut scene, vec3(0.0, height as f32, 0.0), u, v, lamp);
    scene.camera = Some(looking(vec3(0.0, 1.0, 3.0), Vec3::ZERO, 10.0));
    scene.settings.size = [1, 1];
    // Four quarters, each seen from below its corner.
    let (x, y) = (a / height, b / height);
    let part = |x: f64, y: f64| x / (1.0 + x * x).sqrt() * (y / (1.0 + x * x).sqrt()).atan();
    let expected = 4.0 * (part(x, y) + part(y, x)) / (2.0 * std::f64::consts::PI);
    scene.settings.pixel_sampling = eosphor_scene::PixelSampling::Center;
    for way in [Way::Both, Way::Lobes, Way::Lights] {
        let got = mean(&scene, way, 1 << 23, |view, sample| camera_ray(view, 0, 0, sample));
        compare(&format!("a lamp above a point, {way:?}"), expected, got);
    }
}
