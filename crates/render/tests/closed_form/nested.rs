//! Path tracing: bodies inside of bodies, as stacks of plates whose transmission is computed by hand.

use super::support::*;
use eosphor_core::math::{Vec3, vec3};
use eosphor_core::settings::Integrator;
use eosphor_scene::{Light, MaterialKind, Pbr, Scene};

const GLASS: f32 = 1.5;
const WATER: f32 = 1.33;
const ICE: f32 = 1.31;

/// One pixel of many samples, path tracing.
fn paths(samples: u32, depth: u32) -> Scene {
    let mut scene = scene();
    scene.settings.integrator = Integrator::Path;
    (scene.settings.samples, scene.settings.depth, scene.settings.roulette) = (samples, depth, 64);
    scene
}

/// A clear smooth body that takes `1 - left` of the light over a distance of 1.
fn clear(scene: &mut Scene, ior: f32, left: f32) -> u32 {
    let kind = Pbr {
        color: Vec3::ONE,
        metallic: 0.0,
        transmission: 1.0,
        ior,
        solid: true,
        roughness: 0.0,
        attenuation_color: Vec3::splat(left),
        attenuation_distance: Some(1.0),
        ..Pbr::default()
    };
    material(scene, MaterialKind::Pbr(kind))
}

/// A closed plate between two heights, as wide as `half` about 0, whose fronts are outside.
fn plate(scene: &mut Scene, [low, high]: [f32; 2], half: f32, material: u32) {
    let (middle, up) = (0.5 * (low + high), vec3(0.0, 0.0, 0.5 * (high - low)));
    let (x, y) = (vec3(half, 0.0, 0.0), vec3(0.0, half, 0.0));
    let center = vec3(0.0, 0.0, middle);
    for (u, v, away) in [(x, y, up), (y, up, x), (up, x, y)] {
        rectangle(scene, center + away, u, v, material);
        rectangle(scene, center - away, v, u, material);
    }
}

/// A lamp below everything.
fn lamp_below(scene: &mut Scene) {
    let lamp = emissive(scene, Vec3::ONE);
    let wide = 4096.0;
    rectangle(scene, vec3(0.0, 0.0, -64.0), vec3(wide, 0.0, 0.0), vec3(0.0, wide, 0.0), lamp);
}

/// What goes through layers (index, thickness, what is left over a distance of 1) at a cosine of incidence from air, with all light
/// that goes to and fro: layers are added one after the other.
fn through(layers: &[(f32, f64, f64)], cos: f64) -> f64 {
    let sine = (1.0 - cos * cos).sqrt();
    let cosine_in = |index: f64| (1.0 - (sine / index).powi(2)).sqrt();
    // Of all so far: what goes through down, what is reflected below.
    let (mut down, mut below, mut index) = (1.0, 0.0, 1.0);
    let mut meet = |next: f64, left: f64| {
        let (r, _) = fresnel(cosine_in(index), index / next);
        let (passed, sent_back) = (down * left, below * left * left);
        let to_and_fro = 1.0 / (1.0 - sent_back * r);
        down = passed * to_and_fro * (1.0 - r);
        below = r + (1.0 - r) * (1.0 - r) * sent_back * to_and_fro;
        index = next;
    };
    let mut left = 1.0;
    for &(next, thickness, taken) in layers {
        meet(f64::from(next), left);
        left = taken.powf(thickness / cosine_in(f64::from(next)));
    }
    meet(1.0, left);
    down
}

/// Looks down at the lamp through what is there, from angles up to 60 degrees, and from below up to a lamp.
#[track_caller]
fn compare(name: &str, make: impl Fn(&mut Scene), layers: &[(f32, f64, f64)]) {
    for slope in [0.0f32, 0.75, 1.7] {
        let mut scene = paths(1 << 14, 64);
        make(&mut scene);
        lamp_below(&mut scene);
        let height = 8.0;
        let from = vec3(slope * height, 0.01, height);
        let got = probe(&scene, from, vec3(0.0, 0.02, 0.0));
        let cos = 1.0 / f64::from(1.0 + slope * slope).sqrt();
        let expected = through(layers, cos);
        println!("{name}, cosine {cos:.3}: {:.5} of {expected:.5}", got.x);
        assert_grey(got, expected, 2e-3);
    }
}

/// Glass holds water, water holds ice: each boundary refracts and reflects by the indices on its two sides, and each body takes its
/// part. Between glass and water less than 0.4 % is reflected straight on; 4 % and 2 % if each were in air.
#[test]
fn glass_water_and_ice() {
    let make = |scene: &mut Scene| {
        let materials = [(GLASS, 0.9), (WATER, 0.8), (ICE, 0.7)].map(|(ior, left)| clear(scene, ior, left));
        for (material, half) in materials.into_iter().zip([3.0, 2.0, 1.0]) {
            plate(scene, [-half, half], 512.0 + half, material);
        }
    };
    let layers =
        [(GLASS, 1.0, 0.9), (WATER, 1.0, 0.8), (ICE, 2.0, 0.7), (WATER, 1.0, 0.8), (GLASS, 1.0, 0.9)];
    compare("nested", make, &layers);
}

/// A bubble of air in ice, and glass in glass, which is not seen.
#[test]
fn bubbles_and_what_is_not_there() {
    let bubble = |scene: &mut Scene| {
        let (ice, air) = (clear(scene, ICE, 0.7), clear(scene, 1.0, 1.0));
        plate(scene, [-2.0, 2.0], 512.0, ice);
        plate(scene, [-1.0, 1.0], 500.0, air);
    };
    compare("bubble", bubble, &[(ICE, 1.0, 0.7), (1.0, 2.0, 1.0), (ICE, 1.0, 0.7)]);
    let same = |scene: &mut Scene| {
        let glass = clear(scene, GLASS, 0.9);
        plate(scene, [-2.0, 2.0], 512.0, glass);
        plate(scene, [-1.0, 1.0], 500.0, glass);
    };
    compare("glass in glass", same, &[(GLASS, 4.0, 0.9)]);
}

/// Water that reaches into the glass that holds it touches it without a gap, whether light comes through the glass or through the
/// water: where they overlap it is in the one that it entered last.
#[test]
fn overlapping_bodies_touch() {
    for (water, glass, layers) in [
        ([-1.0, 0.25], [0.0, 1.0], [(GLASS, 0.75, 0.9), (WATER, 1.25, 0.8)]),
        ([-0.25, 1.0], [-1.0, 0.0], [(WATER, 1.0, 0.8), (GLASS, 1.0, 0.9)]),
    ] {
        let make = |scene: &mut Scene| {
            let materials = [clear(scene, WATER, 0.8), clear(scene, GLASS, 0.9)];
            plate(scene, water, 512.0, materials[0]);
            plate(scene, glass, 500.0, materials[1]);
        };
        let mut scene = paths(1 << 14, 64);
        make(&mut scene);
        lamp_below(&mut scene);
        let got = probe(&scene, vec3(0.01, 0.01, 8.0), vec3(0.02, 0.02, 0.0));
        // Straight down; what is reflected to and fro runs through the overlap both ways, which is up to 1 in 1000.
        let expected = through(&layers, 1.0);
        println!("overlap: {:.5} of {expected:.5}", got.x);
        assert_grey(got, expected, 2e-3);
    }
}

/// A lamp in water is dimmed on its way by the water that it is in, and nothing else.
#[test]
fn lamps_in_water() {
    let mut scene = paths(1 << 14, 2);
    let water = clear(&mut scene, WATER, 0.5);
    plate(&mut scene, [-4.0, 4.0], 64.0, water);
    let white = matte(&mut scene, Vec3::ONE);
    rectangle(&mut scene, Vec3::ZERO, vec3(8.0, 0.0, 0.0), vec3(0.0, 8.0, 0.0), white);
    scene.lights.push(Light::Point { position: vec3(0.0, 0.0, 3.0), color: Vec3::splat(9.0 * PI) });
    // Straight down from air: 4 units of water to the matte plane, 3 more to the lamp.
    let got = probe(&scene, vec3(0.01, 0.01, 8.0), Vec3::ZERO);
    let (r, _) = fresnel(1.0, 1.0 / f64::from(WATER));
    let expected = (1.0 - r) * 0.5f64.powf(4.0) * 0.5f64.powf(3.0);
    println!("a lamp in water: {:.6} of {expected:.6}", got.x);
    // Of so many samples so much is reflected by chance.
    assert_grey(got, expected, 1e-3);
}
