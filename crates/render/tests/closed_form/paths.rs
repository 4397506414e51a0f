//! Path tracing: enclosures, slabs and holes, whose radiance is known.

use super::support::*;
use super::units::{Measured, fixture, measured_in};
use eosphor_core::math::{Vec3, vec3};
use eosphor_core::settings::Integrator;
use eosphor_scene::{AlphaMode, Light, MaterialKind, Mtl, Pbr, PixelSampling, Scene};

/// One pixel of many samples, path tracing.
pub(crate) fn paths(samples: u32, depth: u32) -> Scene {
    let mut scene = scene();
    let settings = &mut scene.settings;
    settings.integrator = Integrator::Path;
    (settings.samples, settings.depth) = (samples, depth);
    settings.pixel_sampling = PixelSampling::Random;
    scene
}

/// A matte surface that shines.
pub(crate) fn shining(scene: &mut Scene, albedo: f32, radiance: f32) -> u32 {
    let kind = Mtl { Kd: Vec3::splat(albedo), Ke: Vec3::splat(radiance), ..Mtl::default() };
    material(scene, MaterialKind::Mtl(kind))
}

/// A closed box about 0, whose fronts are inside.
pub(crate) fn closed_box(scene: &mut Scene, half: Vec3, material: u32) {
    for axis in 0..3 {
        for sign in [-1.0, 1.0] {
            let of = |k: usize, x: f32| {
                let mut v = [0.0; 3];
                v[k] = x;
                vec3(v[0], v[1], v[2])
            };
            let sizes = [half.x, half.y, half.z];
            let (a, b) = ((axis + 1) % 3, (axis + 2) % 3);
            let (u, v) = (of(a, sizes[a]), of(b, sizes[b]));
            let center = of(axis, sign * sizes[axis]);
            match sign < 0.0 {
                true => rectangle(scene, center, u, v, material),
                false => rectangle(scene, center, v, u, material),
            }
        }
    }
}

/// The sum of what comes back after up to `depth` bounces.
pub(crate) fn series(radiance: f64, albedo: f64, depth: i32) -> f64 {
    radiance * (1.0 - albedo.powi(depth + 1)) / (1.0 - albedo)
}

/// Every place of a closed room that shines all over has the same radiance, whatever its form: light samples, rays of lobes,
/// their shares and roulette have to agree on it.
#[test]
fn closed_rooms_that_shine() {
    for (albedo, depth, roulette) in [
        (0.2, 0, 64),
        (0.2, 64, 4),
        (0.5, 1, 64),
        (0.5, 3, 64),
        (0.5, 64, 2),
        (0.8, 64, 64),
        (0.8, 64, 0),
        (0.95, 64, 4),
    ] {
        let mut room = paths(1 << 16, depth);
        room.settings.roulette = roulette;
        let walls = shining(&mut room, albedo, 0.5);
        closed_box(&mut room, vec3(1.0, 2.0, 3.0), walls);
        let got = probe(&room, vec3(0.2, -0.3, 0.4), vec3(1.0, 0.5, 0.0));
        let expected = series(0.5, f64::from(albedo), depth as i32);
        println!("box, albedo {albedo}, depth {depth}, roulette {roulette}: {:.5} of {expected:.5}", got.x);
        // Where paths end by chance, a path of many bounces is seldom and counts much.
        let relative = if roulette < 64 { 0.03 } else { 1.5e-3 };
        assert_grey(got, expected, relative);

        // A sphere is no light: rays of lobes find all.
        let mut room = paths(1 << 14, depth);
        room.settings.roulette = roulette;
        let walls = shining(&mut room, albedo, 0.5);
        sphere(&mut room, vec3(0.1, 0.2, -0.3), 2.0, walls);
        let got = probe(&room, vec3(0.2, -0.3, 0.4), vec3(1.0, 0.5, 0.0));
        println!("sphere: {:.5}", got.x);
        assert_grey(got, expected, relative);
    }
}

/// Surroundings of radiance 1 are all that there is to see of what takes nothing away.
#[test]
fn white_things_in_white_surroundings_are_not_seen() {
    let glass = |ior: f32, roughness: f32, solid: bool| {
        MaterialKind::Pbr(Pbr {
            color: Vec3::ONE,
            metallic: 0.0,
            transmission: 1.0,
            solid,
            ior,
            roughness,
            ..Pbr::default()
        })
    };
    let plastic = |roughness: f32| MaterialKind::Pbr(Pbr { roughness, ..Pbr::default() });
    for (name, kind, diffuse_roughness) in [
        ("matte", MaterialKind::Matte { color: Vec3::ONE }, 0.0),
        ("clay", MaterialKind::Matte { color: Vec3::ONE }, 1.0),
        ("polished clay", plastic(0.0), 1.0),
        ("clay under a dull layer", plastic(0.7), 0.7),
        ("mirror", MaterialKind::Mirror { reflectance: Vec3::ONE }, 0.0),
        ("glass", MaterialKind::Dielectric { ior: 1.5, tint: Vec3::ONE }, 0.0),
        ("water", glass(1.33, 0.0, true), 0.0),
        ("diamond", glass(2.4, 0.0, true), 0.0),
        ("a pane", glass(1.5, 0.0, false), 0.0),
        ("nothing", glass(1.0, 0.0, true), 0.0),
    ] {
        // Noise of 0.0006 where it is largest, under clay's polish.
        let mut scene = paths(1 << 16, 64);
        scene.settings.background = Vec3::ONE;
        let thing = material(&mut scene, kind);
        scene.materials[thing as usize].diffuse_roughness = diffuse_roughness;
        sphere(&mut scene, Vec3::ZERO, 1.0, thing);
        let got = probe(&scene, vec3(0.0, 0.6, 4.0), vec3(0.0, 0.3, 0.0));
        println!("{name}: {:.5}", got.x);
        assert_grey(got, 1.0, 2e-3);
    }
}

/// A rough floor under a sun, by the paper's formula of EON in double precision.
#[test]
fn rough_floors_are_the_papers() {
    use std::f64::consts::PI;
    let (r, rho) = (0.75, 0.5);
    let a = 1.0 / (1.0 + (0.5 - 2.0 / (3.0 * PI)) * r);
    let albedo = |mu: f64| {
        let si = (1.0 - mu * mu).sqrt();
        let g = si * (mu.acos() - si * mu) + 2.0 / 3.0 * (si / mu * (1.0 - si.powi(3)) - si);
        a + r * a / PI * g
    };
    let mean = a * (1.0 + (2.0 / 3.0 - 28.0 / (15.0 * PI)) * r);
    let again = rho * rho * mean / (1.0 - rho * (1.0 - mean));
    let mut scene = paths(1, 1);
    scene.settings.pixel_sampling = PixelSampling::Center;
    let ground = matte(&mut scene, Vec3::splat(rho as f32));
    scene.materials[ground as usize].diffuse_roughness = r as f32;
    floor(&mut scene, 0.0, 5.0, ground);
    let to_light = [0.6, 0.64, 0.48];
    let irradiance = 2.0;
    scene.lights.push(Light::Directional {
        direction: single(to_light.map(|x| -x)),
        color: Vec3::splat(irradiance as f32),
    });
    // The viewer stands where the light is, beside it, opposite, above.
    for to_viewer in [[0.6, 0.64, 0.48], [0.8, 0.36, -0.48], [-0.96, 0.28, 0.0], [0.0, 1.0, 0.0]] {
        let s = dot(to_light, to_viewer) - to_light[1] * to_viewer[1];
        let s_over_t = if s > 0.0 { s / f64::max(to_light[1], to_viewer[1]) } else { s };
        let once = rho / PI * a * (1.0 + r * s_over_t);
        let rest = (1.0 - albedo(to_light[1])) * (1.0 - albedo(to_viewer[1].min(1.0 - 1e-12)));
        let expected = irradiance * to_light[1] * (once + again / PI * rest / (1.0 - mean));
        let got = probe(&scene, single(to_viewer.map(|x| 4.0 * x)), Vec3::ZERO);
        assert_grey(got, expected, 2e-5);
    }
}

/// As many planes as there are, each covered by half, let that power of a half through: of what is behind, and of light.
#[test]
fn half_of_each_plane() {
    let half = Pbr { color: Vec3::ZERO, opacity: 0.5, specular: 0.0, ..Pbr::default() };
    for count in 0..5 {
        let mut scene = paths(1 << 14, 4);
        scene.settings.background = Vec3::ONE;
        let plane = material(&mut scene, MaterialKind::Pbr(half));
        scene.materials[plane as usize].alpha = AlphaMode::Blend;
        for k in 0..count {
            let center = vec3(0.0, 0.0, k as f32);
            rectangle(&mut scene, center, vec3(9.0, 0.0, 0.0), vec3(0.0, 9.0, 0.0), plane);
        }
        let got = probe(&scene, vec3(0.1, 0.3, 9.0), vec3(0.0, 0.2, 0.0));
        let share = 0.5f64.powi(count);
        // Each ray passes all of them or not: the mean of as many is off by some 1 in 60 there.
        assert_grey(got, share, 0.05);

        scene.settings.background = Vec3::ZERO;
        let white = matte(&mut scene, Vec3::ONE);
        rectangle(&mut scene, vec3(0.0, 0.0, -1.0), vec3(9.0, 0.0, 0.0), vec3(0.0, 9.0, 0.0), white);
        scene.lights.push(Light::Directional { direction: vec3(0.0, 0.0, -1.0), color: Vec3::splat(PI) });
        // Seen from between the lowest plane and the wall.
        let got = probe(&scene, vec3(0.1, 0.3, -0.5), vec3(0.3, 0.2, -1.0));
        assert_grey(got, share, 1e-5);
    }
}

/// A smooth pane whose sides reflect R each reflects 2 R / (1 + R) of the light.
#[test]
fn panes() {
    for ior in [1.1, 1.5, 2.0] {
        for (x, name) in [(0.0, "straight"), (3.0, "slanting")] {
            let mut scene = paths(1 << 14, 4);
            let kind = Pbr {
                color: Vec3::ONE,
                metallic: 0.0,
                transmission: 1.0,
                ior,
                roughness: 0.0,
                ..Pbr::default()
            };
            let pane = material(&mut scene, MaterialKind::Pbr(kind));
            let lamp = emissive(&mut scene, Vec3::ONE);
            rectangle(&mut scene, Vec3::ZERO, vec3(40.0, 0.0, 0.0), vec3(0.0, 40.0, 0.0), pane);
            rectangle(&mut scene, vec3(0.0, 0.0, -1.0), vec3(40.0, 0.0, 0.0), vec3(0.0, 40.0, 0.0), lamp);
            scene.settings.pixel_sampling = PixelSampling::Center;
            let got = probe(&scene, vec3(x, 0.1, 4.0), Vec3::ZERO);
            let cos = 4.0 / f64::from(x * x + 0.01 + 16.0).sqrt();
            let (r, _) = fresnel(cos, 1.0 / f64::from(ior));
            println!("{name}, {ior}: {:.5}", got.x);
            assert_grey(got, (1.0 - r) / (1.0 + r), 2e-3);
        }
    }
}

/// Light that goes through a body is reduced by Beer's law.
#[test]
fn a_slab_takes_its_part() {
    let mut scene = paths(16, 8);
    scene.settings.background = Vec3::ONE;
    let kind = Pbr {
        color: Vec3::ONE,
        metallic: 0.0,
        transmission: 1.0,
        ior: 1.0,
        solid: true,
        roughness: 0.0,
        attenuation_color: vec3(0.5, 0.25, 1.0),
        attenuation_distance: Some(2.0),
        ..Pbr::default()
    };
    let body = material(&mut scene, MaterialKind::Pbr(kind));
    let (u, v) = (vec3(9.0, 0.0, 0.0), vec3(0.0, 9.0, 0.0));
    rectangle(&mut scene, vec3(0.0, 0.0, 1.0), u, v, body);
    rectangle(&mut scene, vec3(0.0, 0.0, -1.0), v, u, body);
    scene.settings.pixel_sampling = PixelSampling::Center;
    assert_near(probe(&scene, vec3(0.1, 0.2, 5.0), vec3(0.1, 0.2, 0.0)), [0.5, 0.25, 1.0], 1e-5);
    let got = probe(&scene, vec3(3.0, 0.0, 4.0), Vec3::ZERO);
    assert_near(got, [0.5f64.powf(1.25), 0.25f64.powf(1.25), 1.0], 1e-5);
}

/// With one bounce, matte surfaces look as Whitted's integrator has them.
#[test]
fn matte_scenes_at_depth_1_are_those_of_whitted() {
    let mut scene = paths(1 << 16, 1);
    scene.settings.pixel_sampling = PixelSampling::Center;
    let ground = matte(&mut scene, vec3(0.8, 0.5, 0.25));
    floor(&mut scene, 0.0, 5.0, ground);
    let lamp = emissive(&mut scene, vec3(3.0, 4.0, 5.0));
    rectangle(&mut scene, vec3(0.5, 2.0, 0.0), vec3(0.7, 0.0, 0.0), vec3(0.0, 0.0, 0.5), lamp);
    sphere(&mut scene, vec3(-0.4, 0.5, 0.3), 0.4, ground);
    scene.lights.push(Light::Point { position: vec3(2.0, 3.0, 1.0), color: vec3(9.0, 8.0, 7.0) });
    scene.lights.push(Light::Directional { direction: vec3(1.0, -2.0, 0.5), color: vec3(0.5, 0.7, 0.9) });
    let mut whitted = scene.clone();
    whitted.settings.integrator = Integrator::Whitted;
    whitted.settings.light_samples = 64;
    whitted.settings.samples = 256;
    whitted.settings.depth = 0;
    for to in [vec3(0.0, 0.0, 0.0), vec3(-0.4, 0.5, 0.3), vec3(1.5, 0.0, -1.0), vec3(0.5, 2.0, 0.0)] {
        let from = vec3(0.0, 1.0, 4.0);
        let expected = probe(&whitted, from, to);
        let mut got = Vec3::ZERO;
        for seed in 0..4 {
            scene.settings.seed = seed;
            got += probe(&scene, from, to) * 0.25;
        }
        println!("{got:?} {expected:?}");
        assert_near(got, double(expected), 6e-3);
    }
}

/// Colours that are cut keep their hue, and what comes straight from a light is not cut.
#[test]
fn what_bounces_can_be_cut() {
    let mut room = paths(4096, 1);
    let walls = shining(&mut room, 0.5, 8.0);
    closed_box(&mut room, Vec3::ONE, walls);
    room.settings.clamp_indirect = Some(0.01);
    let straight = probe(&room, Vec3::ZERO, vec3(1.0, 0.5, 0.0));
    assert_grey(straight, series(8.0, 0.5, 1), 5e-3);
    room.settings.depth = 2;
    let bounced = probe(&room, Vec3::ZERO, vec3(1.0, 0.5, 0.0));
    let more = f64::from(bounced.x - straight.x);
    assert!(more > 0.0 && more < 0.021, "{more}");
}

/// Light that bounces up to 8 times in a room with a matte ball, and with a glass ball, and below a sky, is Mitsuba's
/// (mitsuba/measure.py).
#[test]
fn rooms_are_mitsubas() {
    let mut total = [0.0f64; 2];
    for Measured { scene: name, from, to, radiance } in measured_in("measured-paths.txt") {
        let mut scene = fixture(&format!("{name}.json"));
        let matte = fixture("glass-room.json").settings;
        scene.settings = matte;
        scene.settings.samples = 1 << 16;
        scene.settings.pixel_sampling = PixelSampling::Center;
        let got = probe(&scene, from, to);
        println!("{name} {to:?}: {got:?}, Mitsuba {radiance:?}");
        // Caustics, and what is dark, are noisy on both sides.
        let is_noisy = name == "glass-room" || radiance[0] < 0.05;
        for (got, expected) in <[f32; 3]>::from(got).into_iter().zip(radiance) {
            let error = (f64::from(got) - expected).abs();
            assert!(
                error <= (if is_noisy { 0.1 } else { 0.02 }) * expected,
                "{name} {to:?}: {got} {expected}"
            );
        }
        if radiance[0] < 1.0 {
            total[0] += f64::from(got.y);
            total[1] += radiance[1];
        }
    }
    let ratio = total[0] / total[1];
    println!("all of it: {ratio:.5} of Mitsuba's");
    assert!((ratio - 1.0).abs() < 0.01, "{ratio}");
}
