//! Environments: what a picture of all directions sends to surfaces, and what is seen of it.

use super::support::*;
use eosphor_core::math::{Vec3, vec3};
use eosphor_core::settings::Integrator;
use eosphor_scene::{EnvironmentMap, Image, MaterialKind, Mtl, PixelSampling, Scene, SceneData, Sky, Texels};
use std::f64::consts::PI;

/// One pixel of many samples, path tracing, in an environment of these radiances, row by row.
fn surrounded(samples: u32, width: u32, texels: &[Vec3]) -> Scene {
    let mut scene = scene();
    let settings = &mut scene.settings;
    settings.integrator = Integrator::Path;
    (settings.samples, settings.depth) = (samples, 64);
    settings.pixel_sampling = PixelSampling::Random;
    let texels: Vec<[f32; 4]> = texels.iter().map(|c| [c.x, c.y, c.z, 1.0]).collect();
    let height = texels.len() as u32 / width;
    scene.images.push(Image { name: "sky".into(), width, height, texels: Texels::rgba_floats(&texels) });
    scene.environment = Some(EnvironmentMap::of_image(0));
    scene
}

/// A matte square about 0 that faces +y.
fn matte_floor(scene: &mut Scene, albedo: f32) {
    let kind = Mtl { Kd: Vec3::splat(albedo), ..Mtl::default() };
    let matte = material(scene, MaterialKind::Mtl(kind));
    rectangle(scene, Vec3::ZERO, vec3(0.0, 0.0, 1.0), vec3(1.0, 0.0, 0.0), matte);
}

/// The colours of a picture whose lower half is black; the upper half has this colour.
fn upper_half(color: Vec3, width: u32, height: u32) -> Vec<Vec3> {
    let row = |y: u32| if 2 * y < height { color } else { Vec3::ZERO };
    (0..height).flat_map(|y| (0..width).map(move |_| row(y))).collect()
}

/// In a picture of one colour all is as in a background of it.
#[test]
fn white_things_in_a_white_picture_are_not_seen() {
    for (width, height) in [(1, 1), (4, 2), (61, 37)] {
        for kind in [
            MaterialKind::Matte { color: Vec3::ONE },
            MaterialKind::Mirror { reflectance: Vec3::ONE },
            MaterialKind::Dielectric { ior: 1.5, tint: Vec3::ONE },
        ] {
            let white = vec![Vec3::ONE; (width * height) as usize];
            let mut scene = surrounded(1 << 12, width, &white);
            let thing = material(&mut scene, kind);
            sphere(&mut scene, Vec3::ZERO, 1.0, thing);
            let got = probe(&scene, vec3(0.0, 0.6, 4.0), vec3(0.0, 0.3, 0.0));
            println!("{width} x {height}: {:.5}", got.x);
            assert_grey(got, 1.0, 4e-3);
        }
    }
}

/// A floor under the upper half of the sky reflects its albedo of it: the picture fades out about the horizon, where little
/// counts.
#[test]
fn a_floor_under_half_a_sky() {
    for (width, height) in [(64, 32), (512, 256)] {
        let mut scene = surrounded(1 << 16, width, &upper_half(vec3(2.0, 1.0, 0.5), width, height));
        matte_floor(&mut scene, 0.6);
        let got = probe(&scene, vec3(0.1, 2.0, 0.2), vec3(0.1, 0.0, 0.2));
        println!("{width}: {got:?}");
        // Over half a texel above the horizon it falls to a half, and counts by its cosine.
        let dark = (0.5 * PI / f64::from(height)).powi(2) / 6.0;
        for (channel, expected) in [(got.x, 1.2), (got.y, 0.6), (got.z, 0.3)] {
            assert!((f64::from(channel) / (expected * (1.0 - dark)) - 1.0).abs() < 5e-5, "{got:?}");
        }
    }
}

/// One bright texel is a sun: its irradiance is radiance times solid angle times cosine; the picture is seen where it should be.
#[test]
fn a_sun_of_one_texel() {
    let (width, height, column, row) = (128u32, 64u32, 70u32, 12u32);
    let mut texels = vec![Vec3::ZERO; (width * height) as usize];
    texels[(row * width + column) as usize] = Vec3::splat(1000.0);
    let mut scene = surrounded(1 << 14, width, &texels);
    matte_floor(&mut scene, 0.5);
    let got = probe(&scene, vec3(0.1, 2.0, 0.2), vec3(0.1, 0.0, 0.2));
    // The tent of a texel, by its two axes: a sum over fine steps.
    let (step, mut irradiance) = (1.0 / 512.0, 0.0);
    for k in -512..512 {
        let y = (f64::from(k) + 0.5) * step;
        let angle = (f64::from(row) + 0.5 + y) * PI / f64::from(height);
        irradiance += step * (1.0 - y.abs()) * angle.sin() * angle.cos();
    }
    irradiance *= 1000.0 * (PI / f64::from(height)) * (2.0 * PI / f64::from(width));
    println!("{:.5} of {:.5}", got.x, 0.5 / PI * irradiance);
    assert_grey(got, 0.5 / PI * irradiance, 1e-3);

    // Seen by the camera, in the middle of the texel.
    let around = (f64::from(column) + 0.5) / f64::from(width) * 2.0 * PI - PI;
    let down = (f64::from(row) + 0.5) / f64::from(height) * PI;
    let towards = |turn: f64| {
        let around = around - turn;
        let (x, y, z) = (down.sin() * around.cos(), down.cos(), down.sin() * around.sin());
        vec3(x as f32, y as f32, z as f32)
    };
    let mut sky = surrounded(1, width, &texels);
    sky.settings.pixel_sampling = PixelSampling::Center;
    assert_grey(probe(&sky, Vec3::ZERO, towards(0.0)), 1000.0, 1e-3);
    // Turned by a fourth, counter-clockwise from above.
    sky.environment.as_mut().unwrap().rotation_degrees = 90.0;
    assert_grey(probe(&sky, Vec3::ZERO, towards(0.5 * PI)), 1000.0, 1e-3);
    sky.environment.as_mut().unwrap().is_seen = false;
    sky.settings.background = Vec3::splat(0.25);
    assert_grey(probe(&sky, Vec3::ZERO, towards(0.5 * PI)), 0.25, 1e-6);
}

/// Light samples, rays of lobes and both have one mean.
#[test]
fn all_ways_have_one_mean() {
    let (width, height) = (32, 16);
    let texels: Vec<Vec3> = (0..width * height)
        .map(|k| if k == 137 { Vec3::splat(20.0) } else { vec3(0.2, 0.3, 0.02 * (k % width) as f32) })
        .collect();
    let mut scene = surrounded(1 << 16, width, &texels);
    let kind = Mtl { Kd: Vec3::splat(0.5), Ks: Vec3::splat(0.9), Ns: 20.0, illum: 2, ..Mtl::default() };
    let glossy = material(&mut scene, MaterialKind::Mtl(kind));
    sphere(&mut scene, Vec3::ZERO, 1.0, glossy);
    let (eye, towards) = (vec3(0.3, 0.6, 4.0), vec3(0.2, 0.3, 0.0));
    let both = probe(&scene, eye, towards);
    let lobes = probe_data(&scene, eye, towards, |data: &mut SceneData| data.environment.chance = 0.0);
    let seldom = probe_data(&scene, eye, towards, |data: &mut SceneData| data.environment.chance = 0.1);
    println!("{both:?} {lobes:?} {seldom:?}");
    for channel in 0..3 {
        assert!((both[channel] / lobes[channel] - 1.0).abs() < 0.02);
        assert!((both[channel] / seldom[channel] - 1.0).abs() < 0.02);
    }
}

/// What an edge leaves of a disk of radius 1 whose brightness falls to 0.4 at its limb, as the sun's green does: the share beyond a
/// place.
fn share_beyond(place: f64) -> f64 {
    const DARKENING: f64 = 0.6;
    const STEPS: u32 = 10_000;
    let width = (1.0 - place) / f64::from(STEPS);
    let chord = |k: u32| {
        let x = place + (f64::from(k) + 0.5) * width;
        let squared = 1.0 - x * x;
        2.0 * (1.0 - DARKENING) * squared.sqrt() + DARKENING * 0.5 * PI * squared
    };
    (0..STEPS).map(chord).sum::<f64>() * width / (PI * (1.0 - DARKENING / 3.0))
}

/// The shadow of a wall's edge, 10 away, in a low sun: its penumbra is as wide as half a degree makes it.
#[test]
fn the_sun_of_a_sky_has_penumbras() {
    let (elevation, distance) = (10f64.to_radians(), 10.0);
    let mut scene = surrounded(1 << 13, 1, &[Vec3::ZERO]);
    scene.settings.pixel_sampling = PixelSampling::Center;
    scene.settings.depth = 1;
    // In the east, which is +x; so strong that the sky does not count.
    let sky = Sky {
        sun_elevation_degrees: 10.0,
        sun_azimuth_degrees: 90.0,
        turbidity: 2.0,
        sun_strength: 1e4,
        ..Sky::default()
    };
    scene.environment = Some(EnvironmentMap { strength: 1e-3, ..EnvironmentMap::of_sky(sky) });
    matte_floor(&mut scene, 0.5);
    let lit = f64::from(probe(&scene, vec3(-0.3, 2.0, 0.0), Vec3::ZERO).y);
    let black = material(&mut scene, MaterialKind::Matte { color: Vec3::ZERO });
    let wall = vec3(distance as f32, 0.0, 50.0);
    rectangle(&mut scene, wall, vec3(0.0, 50.0, 0.0), vec3(0.0, 0.0, 50.0), black);
    let radius = 0.2679f64.to_radians();
    for place in [-1.3, -0.5, 0.0, 0.7] {
        // Where the wall's edge covers this much of the disk.
        let z = (place * radius / elevation.cos() * distance) as f32;
        let got = f64::from(probe(&scene, vec3(-0.3, 2.0, z), vec3(0.0, 0.0, z)).y) / lit;
        let want = share_beyond(place.clamp(-1.0, 1.0));
        println!("{place}: {got:.4} of {want:.4}");
        assert!((got - want).abs() < 0.02, "{place}: {got} instead of {want}");
    }
}
