//! Glossy lobes: means over `cos^n` in closed form.

use super::support::*;
use eosphor_core::math::{Vec3, vec3};
use eosphor_core::settings::ShadowMode;
use eosphor_scene::{MaterialKind, Scene};

/// A glossy square at height 0, looked at straight from above unless said otherwise.
fn glossy_floor(exponent: f32, reflectance: Vec3) -> Scene {
    let mut scene = scene();
    let kind = MaterialKind::Glossy { reflectance, exponent, rays: 64, color: Vec3::ZERO };
    let m = material(&mut scene, kind);
    rectangle(&mut scene, vec3(0.02, 0.0, 0.01), vec3(0.0, 0.0, 0.1), vec3(0.1, 0.0, 0.0), m);
    scene.settings.samples = 64;
    scene.settings.light_samples = 1;
    scene
}

/// A ceiling at height 1 that shines where x is over `from_x`, large enough for what a cosine lobe sees of it.
fn add_half_ceiling(scene: &mut Scene, from_x: f32) {
    let glow = emissive(scene, Vec3::ONE);
    let half = 20.0;
    rectangle(scene, vec3(from_x + half, 1.0, 0.0), vec3(half, 0.0, 0.0), vec3(0.0, 0.0, half), glow);
}

const ABOVE: Vec3 = vec3(0.0, 0.5, 0.0);

#[test]
fn a_narrow_lobe_shows_what_the_mirror_shows() {
    let tint = vec3(0.9, 0.5, 0.2);
    for (from_x, expected) in [(-0.05, 1.0), (0.05, 0.0)] {
        let mut scene = glossy_floor(100_000.0, tint);
        add_half_ceiling(&mut scene, from_x);
        assert_near(probe(&scene, ABOVE, Vec3::ZERO), double(tint).map(|t| t * expected), 1e-5);
    }
}

#[test]
fn a_half_bright_world_gives_one_half_at_every_exponent() {
    for exponent in [1.0, 5.0, 50.0, 1000.0] {
        let mut scene = glossy_floor(exponent, Vec3::splat(0.8));
        add_half_ceiling(&mut scene, 0.0);
        let got = probe(&scene, ABOVE, Vec3::ZERO);
        println!("glossy, exponent {exponent}: {} of 0.4", got.x);
        assert_grey(got, 0.4, 4e-3);
    }
}

#[test]
fn a_cosine_lobe_sees_a_half_space_by_one_plus_cosine_over_two() {
    // The half space beyond the plane through the point and the ceiling's border, whose normal is at angle a to the
    // lobe's axis: Lambert's form factor (1 + cos a) / 2.
    for border in [-2.0f64, -0.5, 0.3, 1.0, 3.0] {
        let mut scene = glossy_floor(1.0, Vec3::ONE);
        add_half_ceiling(&mut scene, border as f32);
        let cos = -border / (1.0 + border * border).sqrt();
        let (got, expected) = (probe(&scene, ABOVE, Vec3::ZERO), 0.5 * (1.0 + cos));
        println!("cosine lobe, border {border}: {} of {expected:.6}", got.x);
        // The ceiling ends: that takes up to 2e-3.
        assert!((got.x as f64 - expected).abs() < 2e-3, "{border}: {got:?} instead of {expected}");
    }
}

#[test]
fn rays_of_the_lobe_under_the_surface_count_as_black() {
    // In a white world a cosine lobe about the mirror direction at angle a to the normal keeps (1 + cos a) / 2.
    for degrees in [0.0f64, 30.0, 60.0, 80.0] {
        let mut scene = glossy_floor(1.0, Vec3::ONE);
        scene.settings.background = Vec3::ONE;
        let (s, c) = (degrees.to_radians().sin(), degrees.to_radians().cos());
        let got = probe(&scene, vec3(s as f32, c as f32, 0.0), Vec3::ZERO);
        assert_grey(got, 0.5 * (1.0 + c), 3e-3);
    }
}

#[test]
fn the_mean_of_a_lobe_does_not_depend_on_how_samples_and_rays_share_it() {
    let value = |rays: u32, samples: u32| {
        let mut scene = glossy_floor(3.0, Vec3::ONE);
        let kind = MaterialKind::Glossy { reflectance: Vec3::ONE, exponent: 3.0, rays, color: Vec3::ZERO };
        scene.materials[0].kind = kind;
        scene.settings.samples = samples;
        // Half of a white world: what lamps give depends on how many rays there are of them.
        let black = matte(&mut scene, Vec3::ZERO);
        rectangle(&mut scene, vec3(20.4, 1.0, 0.0), vec3(20.0, 0.0, 0.0), vec3(0.0, 0.0, 20.0), black);
        scene.settings.background = Vec3::ONE;
        probe(&scene, ABOVE, Vec3::ZERO).x
    };
    // The same 1024 points.
    assert_eq!(value(1, 1024), value(16, 64));
    assert_eq!(value(1024, 1), value(16, 64));
}

/// A square of sides 0.02 at height 1 that shines down, 0.5 aside: what a floor gives that is looked at from above.
fn small_lamp(scene: &mut Scene, radiance: f32) {
    let glow = emissive(scene, Vec3::splat(radiance));
    rectangle(scene, vec3(0.5, 1.0, 0.0), vec3(0.01, 0.0, 0.0), vec3(0.0, 0.0, 0.01), glow);
}

#[test]
fn a_small_bright_lamp_makes_no_bright_dots() {
    // One ray of the lobe in some thousand meets the lamp, and would bring 8000.
    let mut scene = glossy_floor(20.0, Vec3::ONE);
    scene.materials[0].kind =
        MaterialKind::Glossy { reflectance: Vec3::splat(0.8), exponent: 20.0, rays: 1, color: Vec3::ZERO };
    small_lamp(&mut scene, 1e4);
    scene.settings.size = [64, 64];
    scene.settings.samples = 1;
    scene.camera = Some(looking(ABOVE, Vec3::ZERO, 0.01));
    let cos = 1.0 / 1.25f64.sqrt();
    let expected = 0.8 * 1e4 * 21.0 / std::f64::consts::TAU * cos.powi(20) * 4e-4 * cos / 1.25;
    let film = render(&scene);
    let mean = film.pixels.iter().map(|p| p.x as f64).sum::<f64>() / 4096.0;
    let most = film.pixels.iter().map(|p| p.x as f64).fold(0.0, f64::max);
    println!("small lamp: mean {mean}, expected {expected}, most {most}");
    assert!((mean / expected - 1.0).abs() < 3e-3, "{mean} instead of {expected}");
    assert!(most < 2.5 * expected, "{most} is a bright dot");
}

/// Lamps are sampled through panes where these cast coloured shadows: nothing counts twice, and nothing is left out.
#[test]
fn lamps_behind_panes_count_once() {
    let value = |shadows| {
        let mut scene = glossy_floor(8.0, Vec3::splat(0.8));
        let pane = material(
            &mut scene,
            MaterialKind::Transparent {
                color: Vec3::ONE,
                transparency: 0.7,
                reflection: 0.0,
                shininess: 1.0,
                diffuse: 0.0,
            },
        );
        rectangle(&mut scene, vec3(0.0, 0.8, 0.0), vec3(8.0, 0.0, 0.0), vec3(0.0, 0.0, 8.0), pane);
        let glow = emissive(&mut scene, Vec3::splat(4.0));
        rectangle(&mut scene, vec3(0.3, 1.0, 0.1), vec3(0.4, 0.0, 0.0), vec3(0.0, 0.0, 0.3), glow);
        scene.settings.shadows = shadows;
        scene.settings.samples = 256;
        probe(&scene, ABOVE, Vec3::ZERO)
    };
    let (opaque, coloured) = (value(ShadowMode::Opaque), value(ShadowMode::Coloured));
    println!("through a pane: {opaque:?} by rays alone, {coloured:?} both ways");
    assert!(opaque.x > 0.1);
    assert_near(coloured, double(opaque), 1e-2);
}
