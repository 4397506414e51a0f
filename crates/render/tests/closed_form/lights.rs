//! Lights: what they give, and where they give nothing.

use super::support::*;
use eosphor_core::math::{Vec3, vec3};
use eosphor_core::settings::ShadowMode;
use eosphor_scene::{Light, MaterialKind, Scene};
use std::f64::consts::FRAC_1_PI;

const KD: Vec3 = vec3(0.8, 0.5, 0.25);

#[test]
fn sphere_under_a_point_light_is_kd_over_pi_times_i_cos_over_d_squared() {
    let mut scene = scene();
    let red = matte(&mut scene, KD);
    let (center, radius) = (vec3(0.3, -0.2, -1.0), 1.5);
    sphere(&mut scene, center, radius, red);
    let (position, color) = (vec3(2.0, 3.0, 2.5), vec3(10.0, 20.0, 30.0));
    scene.lights.push(Light::Point { position, color });
    scene.camera = Some(looking(vec3(0.5, 1.0, 5.0), vec3(0.3, -0.2, -1.0), 40.0));
    scene.settings.size = [41, 31];
    let film = render(&scene);
    let camera = scene.camera.unwrap();
    let (mut lit, mut worst) = (0, 0f64);
    for (x, y) in (0..31).flat_map(|y| (0..41).map(move |x| (x, y))) {
        let (o, d) =
            (double(camera.position), pixel_direction(&camera, [41, 31], x as f64 + 0.5, y as f64 + 0.5));
        let from_center = sub(o, double(center));
        let b = dot(from_center, d);
        let discriminant = b * b - dot(from_center, from_center) + (radius * radius) as f64;
        if discriminant.abs() < 1e-3 {
            continue;
        }
        let got = pixel(&film, x, y);
        if discriminant < 0.0 {
            assert_eq!(got, Vec3::ZERO);
            continue;
        }
        let p = along(o, d, -b - discriminant.sqrt());
        let normal = unit(sub(p, double(center)));
        let to_light = sub(double(position), p);
        let cos = dot(normal, unit(to_light));
        // Light is taken from where shadow rays start, a little off the surface: the error is a share of what a surface that
        // faces the light has.
        let facing = double(KD * color).map(|c| c * FRAC_1_PI / dot(to_light, to_light));
        if cos > 0.05 {
            lit += 1;
            for (got, facing) in <[f32; 3]>::from(got).into_iter().zip(facing) {
                worst = worst.max((got as f64 - facing * cos).abs() / facing);
            }
            assert_near(got, facing.map(|f| f * cos), 1e-4 * (1.0f64).max(0.5 / cos));
        } else if cos < -0.01 {
            assert_eq!(got, Vec3::ZERO);
        }
    }
    println!("sphere under a point light: {lit} pixels, largest error {worst:.2e}");
    assert!(lit > 300 && worst < 1e-4);
}

#[test]
fn falloff_can_be_switched_off() {
    let mut scene = lit_floor(Light::Point { position: vec3(0.0, 3.0, 0.0), color: Vec3::ONE });
    let to = vec3(4.0, 0.0, 0.0);
    assert_near(probe(&scene, vec3(1.0, 5.0, 1.0), to), double(KD).map(|k| k * FRAC_1_PI * 0.6 / 25.0), 1e-4);
    scene.settings.light_falloff = false;
    assert_near(probe(&scene, vec3(1.0, 5.0, 1.0), to), double(KD).map(|k| k * FRAC_1_PI * 0.6), 1e-4);
}

/// A floor at height 0 of [`KD`] and one light.
fn lit_floor(light: Light) -> Scene {
    let mut scene = scene();
    let ground = matte(&mut scene, KD);
    floor(&mut scene, 0.0, 5.0, ground);
    scene.lights.push(light);
    scene
}

#[test]
fn directional_light_is_kd_over_pi_times_e_cos_at_any_distance() {
    let scene = lit_floor(Light::Directional { direction: vec3(3.0, -4.0, 0.0), color: vec3(1.0, 2.0, 3.0) });
    for x in [-4.0, 0.1, 5.0] {
        let got = probe(&scene, vec3(x, 5.0, 1.0), vec3(x, 0.0, 0.0));
        assert_near(got, double(KD * vec3(1.0, 2.0, 3.0)).map(|k| k * FRAC_1_PI * 0.8), 1e-5);
    }
}

#[test]
fn spot_light_is_full_inside_none_outside_and_smoothstep_between() {
    let (inner, outer) = (20f64, 40f64);
    let scene = lit_floor(Light::Spot {
        position: vec3(0.0, 2.0, 0.0),
        direction: vec3(0.0, -2.0, 0.0),
        inner_degrees: inner as f32,
        outer_degrees: outer as f32,
        color: Vec3::splat(100.0),
    });
    let (cos_inner, cos_outer) = (inner.to_radians().cos(), outer.to_radians().cos());
    let check = |cos: f64, cone: f64| {
        let x = 2.0 * (1.0 - cos * cos).sqrt() / cos;
        let expected = 100.0 * FRAC_1_PI * cos * cone / (4.0 + x * x);
        let got = probe(&scene, vec3(x as f32, 4.0, 2.0), vec3(x as f32, 0.0, 0.0));
        // The cone is steep in between.
        let tolerance = if cone == 1.0 { 1e-4 } else { 5e-4 };
        assert_near(got, double(KD).map(|k| k * expected), tolerance);
    };
    check(1.0, 1.0);
    check((inner - 0.1).to_radians().cos(), 1.0);
    check(cos_outer + 0.5 * (cos_inner - cos_outer), 0.5);
    check(cos_outer + 0.25 * (cos_inner - cos_outer), 0.15625);
    check(cos_outer + 0.75 * (cos_inner - cos_outer), 0.84375);
    check((outer + 0.1).to_radians().cos(), 0.0);
    check(70f64.to_radians().cos(), 0.0);
}

#[test]
fn lights_add_up() {
    let mut scene = lit_floor(Light::Directional { direction: vec3(0.0, -1.0, 0.0), color: Vec3::ONE });
    scene.lights.push(Light::Directional { direction: vec3(0.0, -3.0, 4.0), color: vec3(0.0, 5.0, 0.0) });
    let got = probe(&scene, vec3(0.0, 3.0, 1.0), vec3(0.0, 0.0, 0.0));
    assert_near(got, [0.8, 0.5 * 4.0, 0.25].map(|x| x * FRAC_1_PI), 1e-5);
}

#[test]
fn lights_behind_a_surface_give_nothing() {
    let below = vec3(0.3, -2.0, 0.1);
    let lights = [
        Light::Point { position: below, color: Vec3::ONE },
        Light::Directional { direction: vec3(0.1, 1.0, 0.0), color: Vec3::ONE },
        Light::Spot {
            position: below,
            direction: vec3(0.0, 1.0, 0.0),
            inner_degrees: 30.0,
            outer_degrees: 40.0,
            color: Vec3::ONE,
        },
    ];
    for light in lights {
        for shadows in [ShadowMode::None, ShadowMode::Opaque, ShadowMode::Coloured] {
            let mut scene = lit_floor(light);
            scene.settings.shadows = shadows;
            assert_eq!(probe(&scene, vec3(0.0, 3.0, 0.0), vec3(0.2, 0.0, 0.1)), Vec3::ZERO, "{light:?}");
            // The floor's other side has it.
            assert!(probe(&scene, vec3(0.0, -3.0, 0.0), vec3(0.2, 0.0, 0.1)).x > 0.0, "{light:?}");
        }
    }
    // A light with a back shows it to what is above it.
    let mut scene = scene();
    let (ground, glow) = (matte(&mut scene, KD), emissive(&mut scene, Vec3::ONE));
    floor(&mut scene, 0.0, 2.0, ground);
    rectangle(&mut scene, vec3(0.0, 2.0, 0.0), vec3(0.0, 0.0, 1.0), vec3(1.0, 0.0, 0.0), glow);
    assert_eq!(probe(&scene, vec3(5.0, 3.0, 0.0), vec3(1.2, 0.0, 0.1)), Vec3::ZERO);
}

// --- Area lights -----------------------------------------------------------------------------------------------------

/// The integral of cos cos / d^2 over a polygon, seen from `p` with normal `n`, all of it above the horizon
/// (Lambert 1760): half the sum of the edges' angles times n . the unit normal of edge and point.
fn lambert_integral(p: V, n: V, polygon: &[V]) -> f64 {
    let directions: Vec<V> = polygon.iter().map(|&q| unit(sub(q, p))).collect();
    let edge = |a: V, b: V| {
        let normal = cross(a, b);
        dot(a, b).clamp(-1.0, 1.0).acos() * dot(n, unit(normal))
    };
    let next = directions.iter().cycle().skip(1);
    0.5 * directions.iter().zip(next).map(|(&a, &b)| edge(a, b)).sum::<f64>()
}

const LIGHT_CENTER: Vec3 = vec3(0.25, 2.0, -0.5);
const LIGHT_U: Vec3 = vec3(0.9, 0.0, 0.0);
const LIGHT_V: Vec3 = vec3(0.0, 0.5, 0.6);

fn light_corners() -> [V; 4] {
    let (c, u, v) = (LIGHT_CENTER, LIGHT_U, LIGHT_V);
    [c - u - v, c + u - v, c + u + v, c - u + v].map(double)
}

/// A floor under a tilted rectangle that shines down; the camera sees the floor only.
fn under_a_rectangle(light_samples: u32) -> Scene {
    let mut scene = scene();
    let (ground, glow) = (matte(&mut scene, KD), emissive(&mut scene, vec3(2.0, 1.0, 0.5)));
    floor(&mut scene, 0.0, 2.0, ground);
    rectangle(&mut scene, LIGHT_CENTER, LIGHT_U, LIGHT_V, glow);
    scene.camera = Some(looking(vec3(1.0, 1.2, 3.0), vec3(0.2, 0.0, 0.1), 15.0));
    scene.settings.size = [8, 8];
    scene.settings.light_samples = light_samples;
    scene
}

/// Where a pixel's ray meets the floor.
fn on_floor(scene: &Scene, x: u32, y: u32) -> V {
    let camera = scene.camera.unwrap();
    let d = pixel_direction(&camera, [8, 8], x as f64 + 0.5, y as f64 + 0.5);
    let o = double(camera.position);
    along(o, d, -o[1] / d[1])
}

/// Mean relative error (root of squares) over the pixels.
fn rectangle_error(scene: &Scene) -> f64 {
    let film = render(scene);
    let mut sum = 0.0;
    for (x, y) in (0..8).flat_map(|y| (0..8).map(move |x| (x, y))) {
        let integral = lambert_integral(on_floor(scene, x, y), [0.0, 1.0, 0.0], &light_corners()).abs();
        let expected = KD.x as f64 * FRAC_1_PI * 2.0 * integral;
        sum += (pixel(&film, x, y).x as f64 / expected - 1.0).powi(2);
    }
    (sum / 64.0).sqrt()
}

/// The same with plain random points in double precision.
fn plain_random_error(count: u32, seed: u64) -> f64 {
    let (scene, mut random) = (under_a_rectangle(1), Random(seed));
    let (center, u, v) = (double(LIGHT_CENTER), double(LIGHT_U), double(LIGHT_V));
    let facing = unit(cross(u, v));
    let area = 4.0 * length(cross(u, v));
    let mut sum = 0.0;
    for (x, y) in (0..8).flat_map(|y| (0..8).map(move |x| (x, y))) {
        let p = on_floor(&scene, x, y);
        let mut total = 0.0;
        for _ in 0..count {
            let q = along(along(center, u, random.unit() * 2.0 - 1.0), v, random.unit() * 2.0 - 1.0);
            let to = sub(q, p);
            total += unit(to)[1] * dot(facing, unit(to)).abs() / dot(to, to);
        }
        let expected = lambert_integral(p, [0.0, 1.0, 0.0], &light_corners()).abs();
        sum += (area * total / count as f64 / expected - 1.0).powi(2);
    }
    (sum / 64.0).sqrt()
}

#[test]
fn lamberts_polygon_formula_is_the_integral_of_the_renderers_formula() {
    let p = on_floor(&under_a_rectangle(1), 3, 5);
    let (center, u, v) = (double(LIGHT_CENTER), double(LIGHT_U), double(LIGHT_V));
    let (facing, steps) = (unit(cross(u, v)), 400);
    let mut sum = 0.0;
    for (i, j) in (0..steps).flat_map(|i| (0..steps).map(move |j| (i, j))) {
        let at = |k: i32| (2.0 * k as f64 + 1.0) / steps as f64 - 1.0;
        let to = sub(along(along(center, u, at(i)), v, at(j)), p);
        sum += unit(to)[1] * dot(facing, unit(to)).abs() / dot(to, to);
    }
    let quadrature = sum * 4.0 * length(cross(u, v)) / (steps * steps) as f64;
    let formula = lambert_integral(p, [0.0, 1.0, 0.0], &light_corners()).abs();
    assert!((quadrature / formula - 1.0).abs() < 1e-5, "{quadrature} {formula}");
}

#[test]
fn plane_under_a_rectangle_converges_to_the_form_factor_and_beats_plain_random() {
    let mut errors = Vec::new();
    for n in [16, 64, 256, 1024] {
        let mut squares = 0.0;
        for seed in 0..4 {
            let mut scene = under_a_rectangle(n);
            scene.settings.seed = seed;
            squares += rectangle_error(&scene).powi(2);
        }
        // Both triangles have n samples.
        let (error, plain) = ((squares / 4.0).sqrt(), plain_random_error(2 * n, n as u64));
        println!("rectangle, {n} samples a triangle: relative error {error:.2e}, plain random {plain:.2e}");
        assert!(error < 0.5 * plain);
        errors.push((error, plain));
    }
    for pair in errors.windows(2) {
        // Four times the samples: plain random halves its error.
        assert!(pair[1].0 < pair[0].0 / 2.5, "{errors:?}");
    }
    assert!(errors[3].0 < 1e-4, "{errors:?}");
    assert!(errors[3].0 < errors[3].1 / 20.0, "{errors:?}");
}

#[test]
fn samples_of_a_pixel_and_of_a_light_are_one_sequence() {
    // Grid samples would move; in the middle only the light's points differ, and those go on from sample to sample.
    let whole = under_a_rectangle(1024);
    let mut parts = under_a_rectangle(16);
    parts.settings.samples = 64;
    for (a, b) in render(&whole).pixels.iter().zip(&render(&parts).pixels) {
        assert_near(*a, double(*b), 1e-5);
    }
}

#[test]
fn a_light_that_is_seen_shows_its_radiance_on_both_sides() {
    let scene = under_a_rectangle(4);
    assert_eq!(probe(&scene, vec3(0.3, 0.5, 0.2), LIGHT_CENTER), vec3(2.0, 1.0, 0.5));
    assert_eq!(probe(&scene, vec3(0.3, 5.0, -2.0), LIGHT_CENTER + vec3(0.1, 0.0, 0.0)), vec3(2.0, 1.0, 0.5));
}

/// An empty room with a rectangle of light at this height under the ceiling, which is at 2.
fn room(light_height: f32) -> Scene {
    let mut scene = scene();
    let (white, glow) = (matte(&mut scene, Vec3::splat(0.7)), emissive(&mut scene, Vec3::ONE));
    let (x, y, z) = (vec3(1.0, 0.0, 0.0), vec3(0.0, 1.0, 0.0), vec3(0.0, 0.0, 1.0));
    rectangle(&mut scene, vec3(0.0, 0.0, 0.0), z, x, white);
    rectangle(&mut scene, vec3(0.0, 2.0, 0.0), x, z, white);
    rectangle(&mut scene, vec3(-1.0, 1.0, 0.0), y, z, white);
    rectangle(&mut scene, vec3(1.0, 1.0, 0.0), z, y, white);
    rectangle(&mut scene, vec3(0.0, 1.0, -1.0), x, y, white);
    rectangle(&mut scene, vec3(0.0, 1.0, 1.0), y, x, white);
    rectangle(&mut scene, vec3(0.0, light_height, 0.0), x * 0.3, z * 0.25, glow);
    scene.settings.light_samples = 16;
    scene.settings.size = [48, 48];
    scene
}

#[test]
fn an_area_light_does_not_shadow_itself_in_an_empty_room() {
    for light_height in [2.0, 1.999, 1.9, 1.0] {
        for camera in [
            looking(vec3(0.0, 0.9, 0.95), vec3(0.1, 0.8, 0.0), 100.0),
            looking(vec3(0.6, 0.3, -0.7), vec3(-0.3, 1.9, 0.3), 110.0),
            looking(vec3(0.3, 1.6, 0.6), vec3(0.01, 0.0, 0.02), 100.0),
        ] {
            let mut scene = room(light_height);
            scene.camera = Some(camera);
            let shadowed = render(&scene);
            scene.settings.shadows = ShadowMode::None;
            let free = render(&scene);
            let differing = shadowed.pixels.iter().zip(&free.pixels).filter(|(a, b)| a != b).count();
            assert_eq!(differing, 0, "light at {light_height}: {differing} of 2304 pixels lost samples");
        }
    }
}

#[test]
fn straight_below_an_area_light_no_sample_is_lost() {
    // On the axis, by symmetry 4 F of a corner: the closed form of a centred rectangle.
    let mut scene = room(1.9);
    scene.settings.light_samples = 1024;
    let got = probe(&scene, vec3(0.5, 0.5, 0.5), vec3(0.0, 0.0, 0.0));
    let corners = [[-0.3, 1.9, -0.25], [0.3, 1.9, -0.25], [0.3, 1.9, 0.25], [-0.3, 1.9, 0.25]];
    let integral = lambert_integral([0.0; 3], [0.0, 1.0, 0.0], &corners).abs();
    assert_grey(got, 0.7 * FRAC_1_PI * integral, 1e-4);
}

#[test]
fn emissive_surfaces_add_their_radiance_to_what_they_reflect() {
    let mut scene = scene();
    let mtl = eosphor_scene::Mtl { Kd: KD, Ke: vec3(0.5, 0.0, 0.0), ..Default::default() };
    let glowing = material(&mut scene, MaterialKind::Mtl(mtl));
    floor(&mut scene, 0.0, 2.0, glowing);
    scene.lights.push(Light::Directional { direction: vec3(0.0, -1.0, 0.0), color: Vec3::splat(PI) });
    scene.settings.light_samples = 1;
    // Its own light is one-sided and in its own plane: it does not light itself.
    assert_near(probe(&scene, vec3(0.0, 3.0, 1.0), vec3(0.0, 0.0, 0.0)), [1.3, 0.5, 0.25], 1e-5);
}
