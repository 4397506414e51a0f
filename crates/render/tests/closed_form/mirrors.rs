//! Mirrors: geometric series, cut by depth and by energy.

use super::support::*;
use eosphor_core::math::{Vec3, vec3};
use eosphor_core::settings::ShadowMode;
use eosphor_scene::{MaterialKind, Mtl, Scene};

/// A closed box whose walls shine by `e` and reflect `k`.
fn mirror_box(e: Vec3, k: Vec3, depth: u32) -> Scene {
    let mut scene = scene();
    let wall = Mtl { Kd: Vec3::ZERO, Ks: k, Ke: e, illum: 3, ..Mtl::default() };
    let wall = material(&mut scene, MaterialKind::Mtl(wall));
    let (x, y, z) = (vec3(1.0, 0.0, 0.0), vec3(0.0, 1.5, 0.0), vec3(0.0, 0.0, 2.0));
    for (a, b, n) in [(x, y, z), (y, z, x), (z, x, y)] {
        rectangle(&mut scene, n, b, a, wall);
        rectangle(&mut scene, -n, a, b, wall);
    }
    scene.settings.depth = depth;
    scene.settings.light_samples = 1;
    scene.settings.shadows = ShadowMode::None;
    scene
}

fn series(k: f64, terms: u32) -> f64 {
    (0..terms).map(|i| k.powi(i as i32)).sum()
}

#[test]
fn a_mirror_box_shows_the_geometric_series_up_to_the_depth_limit() {
    let (e, k) = (vec3(1.0, 2.0, 0.5), vec3(0.9, 0.5, 0.97));
    for depth in [0, 1, 5, 20, 64] {
        let scene = mirror_box(e, k, depth);
        let terms = depth + 1;
        let expected = [
            e.x as f64 * series(k.x as f64, terms),
            e.y as f64 * series(k.y as f64, terms),
            e.z as f64 * series(k.z as f64, terms),
        ];
        for to in [vec3(1.0, 0.3, 0.2), vec3(-0.5, 1.5, 1.1), vec3(0.3, -0.4, 2.0), vec3(0.9, 0.1, -1.7)] {
            // Contributions are rounded down to multiples of 2^-28.
            assert_near(probe(&scene, vec3(0.1, -0.2, 0.3), to), expected, 1e-5);
        }
    }
}

#[test]
fn parallel_mirrors_multiply_once_a_bounce_and_need_the_depth() {
    // Between two mirrors at z = -1 and 1, straight along z: each bounce adds one k, and nothing else shines.
    let mut scene = scene();
    let mirror = material(&mut scene, MaterialKind::Mirror { reflectance: Vec3::splat(0.8) });
    let glow = emissive(&mut scene, Vec3::ONE);
    let (x, y) = (vec3(1.0, 0.0, 0.0), vec3(0.0, 1.0, 0.0));
    rectangle(&mut scene, vec3(0.1, 0.2, -1.0), x, y, mirror);
    rectangle(&mut scene, vec3(0.1, 0.2, 1.0), y, x, mirror);
    // The ray climbs by 0.25 from wall to wall: after bounces at 0.25, 0.5, 0.75 and 1 it passes over the mirror's top, at
    // 1.2, and meets the light behind it.
    rectangle(&mut scene, vec3(0.1, 1.35, -1.5), x, y * 0.2, glow);
    for depth in 0..8 {
        scene.settings.depth = depth;
        let got = probe(&scene, vec3(0.3, 0.125, 0.0), vec3(0.3, 0.25, -1.0));
        let expected = if depth < 4 { 0.0 } else { 0.8f64.powi(4) };
        assert_grey(got, expected, 1e-6);
    }
}

#[test]
fn the_energy_threshold_ends_the_series_where_the_largest_component_falls_below_it() {
    let (e, k) = (Vec3::ONE, vec3(0.5, 0.25, 0.125));
    for (threshold, terms) in [(0.0, 21), (0.1, 4), (0.125, 4), (0.126, 3), (0.5, 2), (0.51, 1), (1.0, 1)] {
        let mut scene = mirror_box(e, k, 20);
        scene.settings.energy_threshold = threshold;
        let expected = [0.5, 0.25, 0.125].map(|k| series(k, terms));
        assert_near(probe(&scene, vec3(0.1, -0.2, 0.3), vec3(1.0, 0.3, 0.2)), expected, 1e-6);
    }
}

#[test]
fn a_coloured_mirror_multiplies_what_it_shows() {
    let mut scene = scene();
    let tint = vec3(0.9, 0.6, 0.3);
    let mirror = material(&mut scene, MaterialKind::Mirror { reflectance: tint });
    floor(&mut scene, 0.0, 2.0, mirror);
    scene.settings.background = vec3(0.2, 0.4, 0.6);
    let got = probe(&scene, vec3(0.0, 1.0, 1.0), vec3(0.1, 0.0, 0.0));
    assert_near(got, double(tint * vec3(0.2, 0.4, 0.6)), 1e-6);
}

#[test]
fn a_mirror_sphere_shows_the_direction_of_its_normal() {
    // Edges of a square in the mirror: seen where the mirrored ray meets it, gone where it does not.
    let (center, eye) = ([0.2, 0.1, -3.0], [0.0, 0.0, 2.0]);
    for target in [[0.5, 0.4, -2.0], [0.2, 0.9, -2.2], [-0.3, -0.2, -2.1]] {
        let d = unit(sub(target, eye));
        let from = sub(eye, center);
        let b = dot(from, d);
        let p = along(eye, d, -b - (b * b - dot(from, from) + 1.0).sqrt());
        let n = sub(p, center);
        let mirrored = along(d, n, -2.0 * dot(d, n));
        // A square across the mirrored ray, 2 units on.
        let (at, side) = (along(p, mirrored, 2.0), unit(cross(mirrored, [0.0, 1.0, 0.3])));
        let other = cross(mirrored, side);
        for (shift, seen) in [(0.0, true), (0.0018, true), (0.0022, false), (-0.0018, true), (-0.0022, false)]
        {
            for across in [side, other] {
                let mut scene = scene();
                let mirror = material(&mut scene, MaterialKind::Mirror { reflectance: Vec3::ONE });
                let glow = emissive(&mut scene, Vec3::ONE);
                sphere(&mut scene, single(center), 1.0, mirror);
                let half = |v: V| single(v.map(|x| x * 0.002));
                rectangle(&mut scene, single(along(at, across, shift)), half(side), half(other), glow);
                let got = probe(&scene, single(eye), single(target));
                assert_eq!(got, if seen { Vec3::ONE } else { Vec3::ZERO }, "{target:?} {shift}");
            }
        }
    }
}
