//! Where samples lie, and what a lens does to them.

use super::support::*;
use eosphor_core::math::{Vec3, vec3};
use eosphor_scene::{Lens, PixelSampling, Scene};

/// A camera at (0, 0, 1) that sees -1 to 1 at z = 0, and a shining half plane there left of the line through
/// (`at`, 0) that leans right by `slope`, in pixels of an 8 x 8 picture.
fn half_plane(at: f64, slope: f64) -> Scene {
    let mut scene = scene();
    let glow = emissive(&mut scene, Vec3::ONE);
    scene.camera = Some(looking(vec3(0.0, 0.0, 1.0), Vec3::ZERO, 90.0));
    scene.settings.size = [8, 8];
    scene.settings.light_samples = 1;
    // Pixels (x right, y down, from the upper left) to the plane.
    let plane = |x: f64, y: f64| vec3((x / 4.0 - 1.0) as f32, (1.0 - y / 4.0) as f32, 0.0);
    let (top, bottom) = (plane(at - slope * 20.0, -20.0), plane(at + slope * 20.0, 20.0));
    let left = vec3(-8.0, 0.0, 0.0);
    scene.parallelograms.push(eosphor_scene::Parallelogram {
        corner: bottom + left,
        edge_u: -left,
        edge_v: top - bottom,
        material: glow,
    });
    scene
}

#[test]
fn a_sample_grid_gives_exact_multiples_of_a_half_planes_coverage() {
    for side in [1u32, 2, 3, 4, 7] {
        for (at, slope) in [(3.3, 0.0), (4.61, 0.0), (3.87, 0.37), (2.2, -0.81)] {
            let mut scene = half_plane(at, slope);
            scene.settings.pixel_sampling = PixelSampling::Grid(side);
            let film = render(&scene);
            for (x, y) in (0..8).flat_map(|y| (0..8).map(move |x| (x, y))) {
                let place = |k: u32| (k as f64 + 0.5) / side as f64;
                let samples = (0..side).flat_map(|i| (0..side).map(move |j| (place(i), place(j))));
                let inside = samples.filter(|(dx, dy)| x as f64 + dx < at + slope * (y as f64 + dy)).count();
                let expected = inside as f64 / (side * side) as f64;
                assert_grey(pixel(&film, x, y), expected, 1e-7);
            }
        }
    }
}

/// Area of a pixel left of the line.
fn coverage(at: f64, slope: f64, x: u32, y: u32) -> f64 {
    let steps = 4000;
    let part =
        |k: u32| (at + slope * (y as f64 + (k as f64 + 0.5) / steps as f64) - x as f64).clamp(0.0, 1.0);
    (0..steps).map(part).sum::<f64>() / steps as f64
}

#[test]
fn random_samples_converge_to_a_half_planes_coverage_faster_than_plain_random() {
    let (at, slope) = (3.87, 0.37);
    let mut errors = Vec::new();
    for samples in [16, 64, 256, 1024, 4096] {
        let mut scene = half_plane(at, slope);
        scene.settings.pixel_sampling = PixelSampling::Random;
        scene.settings.samples = samples;
        let (mut squares, mut plain, mut count) = (0.0, 0.0, 0);
        for seed in 0..4 {
            scene.settings.seed = seed;
            let film = render(&scene);
            for (x, y) in (0..8).flat_map(|y| (0..8).map(move |x| (x, y))) {
                let expected = coverage(at, slope, x, y);
                let error = pixel(&film, x, y).x as f64 - expected;
                if expected == 0.0 || expected == 1.0 {
                    assert!(error.abs() < 1e-7);
                } else {
                    squares += error * error;
                    plain += expected * (1.0 - expected) / samples as f64;
                    count += 1;
                }
            }
        }
        let (error, plain) = ((squares / count as f64).sqrt(), (plain / count as f64).sqrt());
        println!("half plane, {samples} samples: error {error:.2e}, plain random {plain:.2e}");
        assert!(error < 0.6 * plain);
        errors.push(error);
    }
    // Sobol at an edge falls with about N^-3/4: 16 times the samples give 8 times less.
    assert!(errors[4] < errors[2] / 5.0 && errors[2] < errors[0] / 5.0, "{errors:?}");
}

/// A lens of radius `aperture` at (0, 0, 0), sharp at `focus`, and a small shining square at `distance`, seen by 33 x 33
/// pixels; returns (largest distance from the picture's middle, mean square of it, energy) in pixels.
fn blur(aperture: f32, focus: f32, distance: f32) -> (f64, f64, f64) {
    let mut scene = scene();
    let glow = emissive(&mut scene, Vec3::ONE);
    scene.settings.light_samples = 1;
    scene.settings.size = [33, 33];
    scene.settings.pixel_sampling = PixelSampling::Random;
    scene.settings.samples = 4096;
    let mut camera = looking(Vec3::ZERO, vec3(0.0, 0.0, -1.0), 2.0 * 0.25f32.atan().to_degrees());
    camera.lens = Some(Lens { aperture_radius: aperture, focus_distance: Some(focus) });
    scene.camera = Some(camera);
    // One pixel wide in the middle of the picture, where the picture is 0.5 wide at distance 1.
    let half = distance * 0.25 / 33.0;
    let center = vec3(0.0, 0.0, -distance);
    rectangle(&mut scene, center, vec3(half, 0.0, 0.0), vec3(0.0, half, 0.0), glow);
    let film = render(&scene);
    let (mut reach, mut squares, mut energy) = (0f64, 0.0, 0.0);
    for (x, y) in (0..33).flat_map(|y| (0..33).map(move |x| (x, y))) {
        let value = pixel(&film, x, y).x as f64;
        let (dx, dy) = (x as f64 - 16.0, y as f64 - 16.0);
        let r2 = dx * dx + dy * dy;
        if value > 0.0 {
            reach = reach.max(r2.sqrt());
        }
        squares += value * r2;
        energy += value;
    }
    (reach, squares / energy, energy)
}

#[test]
fn what_is_in_focus_is_sharp_whatever_the_aperture() {
    for aperture in [0.0, 0.02, 0.1] {
        let (reach, _, energy) = blur(aperture, 3.0, 3.0);
        // The square is exactly one pixel; rounding at its border may fall into the next.
        assert!(reach <= 1.5, "{reach}");
        assert!((energy - 1.0).abs() < 0.01, "{energy}");
    }
}

#[test]
fn what_is_out_of_focus_spreads_over_the_circle_of_confusion() {
    // A lens point a sends the ray through (X, d) to a (1/f - 1/d) + X/d on the picture at distance 1: a disk of radius
    // A |1/f - 1/d|. Its mean square radius is R^2 / 2, that of the pixels' own squares 1/6 twice.
    for (aperture, focus, distance) in
        [(0.2, 3.0f32, 2.0f32), (0.3, 3.0, 4.5), (0.4, 2.0, 3.0), (0.15, 1.0, 5.0), (0.1, 5.0, 1.0)]
    {
        let radius = aperture as f64 * (1.0 / focus as f64 - 1.0 / distance as f64).abs() * 33.0 / 0.5;
        let (reach, mean_square, energy) = blur(aperture, focus, distance);
        println!("circle of confusion {radius:.2} pixels: reaches {reach:.2}, mean square {mean_square:.3}");
        assert!((reach - radius).abs() < 1.5, "{reach} instead of {radius}");
        let expected = radius * radius / 2.0 + 1.0 / 3.0;
        assert!((mean_square / expected - 1.0).abs() < 0.03, "{mean_square} instead of {expected}");
        assert!((energy - 1.0).abs() < 0.03, "energy is spread, not lost: {energy}");
    }
}

#[test]
fn a_pin_hole_has_no_circle_of_confusion() {
    let (reach, _, energy) = blur(0.0, 3.0, 1.0);
    assert!(reach <= 1.5 && (energy - 1.0).abs() < 0.01, "{reach} {energy}");
}

#[test]
fn pixels_look_where_the_field_of_view_says() {
    // A square that covers pixels 2..6 by 3..4 of 8 x 6 exactly, at fov 60 degrees.
    let mut scene = scene();
    let glow = emissive(&mut scene, Vec3::ONE);
    scene.settings.light_samples = 1;
    scene.settings.size = [8, 6];
    scene.camera = Some(looking(vec3(1.0, 2.0, 3.0), vec3(1.0, 2.0, 0.0), 60.0));
    let half = 30f64.to_radians().tan();
    let at = |x: f64, y: f64| {
        vec3((1.0 + (x / 4.0 - 1.0) * half) as f32, (2.0 + (1.0 - y / 3.0) * half * 0.75) as f32, 2.0)
    };
    let (low, high) = (at(2.0, 4.0), at(6.0, 3.0));
    let u = vec3((high.x - low.x) * 0.5, 0.0, 0.0);
    let v = vec3(0.0, (high.y - low.y) * 0.5, 0.0);
    rectangle(&mut scene, low + u + v, u * 0.999, v * 0.999, glow);
    let film = render(&scene);
    for (x, y) in (0..6).flat_map(|y| (0..8).map(move |x| (x, y))) {
        let expected = if (2..6).contains(&x) && y == 3 { Vec3::ONE } else { Vec3::ZERO };
        assert_eq!(pixel(&film, x, y), expected, "{x} {y}");
    }
}
