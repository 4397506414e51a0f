//! Glass: Fresnel, Snell and total internal reflection, in pictures.

use super::support::*;
use eosphor_core::math::{Vec3, vec3};
use eosphor_core::settings::FresnelMode;
use eosphor_scene::{
    Composition, Instance, MaterialKind, Mesh, Mtl, NO_INDEX, NormalMode, Scene, Transform, Triangle,
};

fn glass(scene: &mut Scene, ior: f32, tint: Vec3) -> u32 {
    material(scene, MaterialKind::Dielectric { ior, tint })
}

/// The surface of a glass half space at height 0, a red glow around it above and a green one below; no further bounces.
fn half_space(ior: f32) -> Scene {
    let mut scene = scene();
    let m = glass(&mut scene, ior, Vec3::ONE);
    floor(&mut scene, 0.0, 2.0, m);
    let (red, green) = (emissive(&mut scene, vec3(1.0, 0.0, 0.0)), emissive(&mut scene, vec3(0.0, 1.0, 0.0)));
    sphere(&mut scene, vec3(0.0, 1000.0, 0.0), 999.0, red);
    sphere(&mut scene, vec3(0.0, -1000.0, 0.0), 999.0, green);
    // Nearly horizontal rays pass between the two.
    scene.settings.background = Vec3::ZERO;
    scene.settings.depth = 1;
    scene
}

#[test]
fn glass_shows_f_of_what_it_reflects_and_the_rest_of_what_it_transmits() {
    for ior in [1.1, 1.5, 2.419] {
        for mode in [FresnelMode::Exact, FresnelMode::Schlick, FresnelMode::Constant] {
            let mut scene = half_space(ior);
            scene.settings.fresnel = mode;
            let brewster = (ior as f64).atan().to_degrees();
            for degrees in [0.0, 20.0, 45.0, brewster, 75.0] {
                let (s, c) = (degrees.to_radians().sin(), degrees.to_radians().cos());
                let f0 = ((ior as f64 - 1.0) / (ior as f64 + 1.0)).powi(2);
                let f = match mode {
                    FresnelMode::Exact => fresnel(c, 1.0 / ior as f64).0,
                    FresnelMode::Schlick => f0 + (1.0 - f0) * (1.0 - c).powi(5),
                    FresnelMode::Constant => f0,
                };
                // Inside the sphere of red: less than 1 over the surface.
                let from = vec3((0.5 * s) as f32, (0.5 * c) as f32, 0.01);
                let got = probe(&scene, from, vec3(0.0, 0.0, 0.01));
                assert_near(got, [f, 1.0 - f, 0.0], 1e-4);
                if degrees == brewster && mode == FresnelMode::Exact {
                    let angle = (ior as f64).atan();
                    assert_near(got, [0.5 * (2.0 * angle).cos().powi(2), 1.0 - f, 0.0], 1e-4);
                }
            }
        }
    }
}

#[test]
fn beyond_the_critical_angle_glass_reflects_everything_in_every_mode() {
    let critical = (1.0f64 / 1.5).asin().to_degrees();
    for mode in [FresnelMode::Exact, FresnelMode::Schlick, FresnelMode::Constant] {
        let mut scene = half_space(1.5);
        scene.settings.fresnel = mode;
        for (degrees, total) in [(critical - 0.5, false), (critical + 0.1, true), (60.0, true)] {
            let (s, c) = (degrees.to_radians().sin(), degrees.to_radians().cos());
            // From inside the glass, which is below.
            let got = probe(&scene, vec3((-0.5 * s) as f32, (-0.5 * c) as f32, 0.01), vec3(0.0, 0.0, 0.01));
            if total {
                assert_eq!(got, vec3(0.0, 1.0, 0.0), "{mode:?} {degrees}");
            } else {
                assert!(got.x > 0.0 && (got.x + got.y - 1.0).abs() < 1e-6, "{mode:?} {degrees}: {got:?}");
                let f = fresnel(c, 1.5).0;
                // The curve is steep here.
                assert!(mode != FresnelMode::Exact || (got.y as f64 - f).abs() < 1e-4, "{got:?} {f}");
            }
        }
    }
}

#[test]
fn without_fresnel_total_reflection_sends_kt_along_the_mirror_direction() {
    let (ks, tf) = (vec3(0.2, 0.1, 0.3), vec3(0.5, 0.6, 0.7));
    let mut scene = half_space(1.5);
    scene.settings.composition = Composition::Pg1;
    let mtl = Mtl { Kd: Vec3::ZERO, Ks: ks, Tf: Some(tf), Ni: Some(1.5), illum: 4, ..Mtl::default() };
    scene.materials[0].kind = MaterialKind::Mtl(mtl);
    let at = |degrees: f64| {
        let (s, c) = (degrees.to_radians().sin(), degrees.to_radians().cos());
        probe(&scene, vec3((-0.5 * s) as f32, (-0.5 * c) as f32, 0.01), vec3(0.0, 0.0, 0.01))
    };
    assert_near(at(60.0), [0.0, (ks.y + tf.y) as f64, 0.0], 1e-6);
    assert_near(at(10.0), [tf.x as f64, ks.y as f64, 0.0], 1e-6);
}

/// A small shining square about `at` that a ray along `d` meets head-on.
fn add_target(scene: &mut Scene, at: V, d: V, half: f64) {
    let glow = emissive(scene, Vec3::ONE);
    let side = unit(cross(d, [0.31, 0.87, -0.2]));
    let other = cross(d, side);
    let scaled = |v: V| single(v.map(|x| x * half));
    rectangle(scene, single(at), scaled(side), scaled(other), glow);
}

/// Asserts that the probe sees a square of this half width about the point that theory says, at its full transmittance,
/// and does not see squares beside it.
#[track_caller]
fn assert_aims_at(
    scene: &Scene,
    (from, to): (Vec3, Vec3),
    (at, d): (V, V),
    half: f64,
    transmittance: f64,
    tolerance: f64,
) {
    let mut with = scene.clone();
    add_target(&mut with, at, d, half);
    assert_grey(probe(&with, from, to), transmittance, tolerance);
    let side = unit(cross(d, [0.31, 0.87, -0.2]));
    for (direction, sign) in [(side, 1.0), (side, -1.0), (cross(d, side), 1.0), (cross(d, side), -1.0)] {
        let mut without = scene.clone();
        add_target(&mut without, along(at, direction, sign * 2.0 * half), d, half * 0.98);
        assert_eq!(probe(&without, from, to), Vec3::ZERO);
    }
}

#[test]
fn a_slab_shifts_a_ray_sideways_and_keeps_its_direction() {
    // Shift = h sin a (1 - cos a / (n cos b)). Rays go on 2^-17 of the scene's extent off the surface, which moves them by
    // up to 3e-5 a surface.
    let h = 0.7;
    for ior in [1.0002f32, 1.333, 1.5, 2.419] {
        for degrees in [0.0f64, 20.0, 45.0, 70.0, 85.0] {
            if ior < 1.1 && degrees > 80.0 {
                // It would come out far away.
                continue;
            }
            let mut scene = scene();
            let m = glass(&mut scene, ior, Vec3::ONE);
            floor(&mut scene, 0.0, 2.5, m);
            let (u, v) = (vec3(2.5, 0.0, 0.0), vec3(0.0, 0.0, 2.5));
            rectangle(&mut scene, vec3(0.3, -h as f32, -0.4), u, v, m);
            scene.settings.depth = 2;
            let a = degrees.to_radians();
            let d = [a.sin(), -a.cos(), 0.0];
            let (reflected, cos_in) = fresnel(a.cos(), 1.0 / ior as f64);
            let n = ior as f64;
            let shift = h * a.sin() * (1.0 - a.cos() / (n * cos_in));
            // The straight ray, moved at right angles towards where the bent one comes out.
            let sideways = [-a.cos(), -a.sin(), 0.0];
            let inside = h / cos_in;
            let forward = (inside * inside - shift * shift).sqrt();
            let at = along(along([0.1, 0.0, 0.2], d, forward + 0.5), sideways, shift);
            let from = along([0.1, 0.0, 0.2], d, -1.0);
            let passed = (1.0 - reflected) * (1.0 - reflected);
            let to = vec3(0.1, 0.0, 0.2);
            assert_aims_at(&scene, (single(from), to), (at, d), 1e-4, passed, 1e-3);
        }
    }
}

/// The way through a glass sphere of radius 1 about the origin in double precision: where it comes out, along what, and
/// how much of the light.
fn through_sphere(o: V, d: V, ior: f64) -> (V, V, f64) {
    let b = dot(o, d);
    let p = along(o, d, -b - (b * b - dot(o, o) + 1.0).sqrt());
    let inside = refract(d, p, 1.0 / ior);
    let q = along(p, inside, -2.0 * dot(p, inside));
    let (first, second) = (fresnel(-dot(d, p), 1.0 / ior).0, fresnel(dot(inside, q), ior).0);
    (q, refract(inside, q.map(|x| -x), ior), (1.0 - first) * (1.0 - second))
}

const SPHERE_EYES: [(V, V); 4] = [
    ([0.0, 0.0, 3.0], [0.0, 0.0, 0.0]),
    ([0.2, -0.1, 3.0], [0.4, 0.3, 0.0]),
    ([2.0, 1.0, 1.0], [-0.3, 0.3, 0.4]),
    ([0.0, 3.0, 0.5], [0.0, 0.0, -0.7]),
];

#[test]
fn a_glass_sphere_bends_rays_by_snell_twice() {
    for ior in [1.333f32, 1.5, 2.419] {
        for (o, to) in SPHERE_EYES {
            let mut scene = scene();
            let m = glass(&mut scene, ior, Vec3::ONE);
            sphere(&mut scene, Vec3::ZERO, 1.0, m);
            scene.settings.depth = 2;
            let (q, out, passed) = through_sphere(o, unit(sub(to, o)), ior as f64);
            assert_aims_at(&scene, (single(o), single(to)), (along(q, out, 1.5), out), 2e-4, passed, 1e-3);
        }
    }
}

/// A sphere of radius 1 of 2 n x n squares with exact normals.
fn add_sphere_mesh(scene: &mut Scene, n: u32, material: u32) {
    let mut mesh = Mesh { name: "sphere".into(), ..Mesh::default() };
    for i in 0..=n {
        for j in 0..2 * n {
            let (theta, phi) =
                (i as f64 / n as f64 * std::f64::consts::PI, j as f64 / n as f64 * std::f64::consts::PI);
            let ring = if i == 0 || i == n { 0.0 } else { theta.sin() };
            mesh.positions.push(single([ring * phi.cos(), theta.cos(), -ring * phi.sin()]));
        }
    }
    mesh.normals = mesh.positions.clone();
    for i in 0..n {
        for j in 0..2 * n {
            let at = |di: u32, dj: u32| (i + di) * 2 * n + (j + dj) % (2 * n);
            for t in [[at(0, 0), at(1, 0), at(1, 1)], [at(0, 0), at(1, 1), at(0, 1)]] {
                mesh.triangles.push(Triangle { positions: t, normals: t, uvs: [NO_INDEX; 3], material });
            }
        }
    }
    scene.meshes.push(mesh);
    scene.instances.push(Instance::new(0, Transform::default()));
    scene.settings.normals = NormalMode::Smooth;
}

#[test]
fn a_sphere_of_smooth_triangles_bends_rays_nearly_as_the_sphere_does() {
    for (o, to) in SPHERE_EYES {
        let mut scene = scene();
        let m = glass(&mut scene, 1.5, Vec3::ONE);
        add_sphere_mesh(&mut scene, 128, m);
        scene.settings.depth = 2;
        let (q, out, passed) = through_sphere(o, unit(sub(to, o)), 1.5);
        assert_aims_at(&scene, (single(o), single(to)), (along(q, out, 1.5), out), 3e-3, passed, 2e-3);
    }
}

#[test]
fn a_tint_is_taken_once_a_surface() {
    let tint = vec3(0.9, 0.5, 0.2);
    let mut scene = scene();
    let m = glass(&mut scene, 1.5, tint);
    sphere(&mut scene, Vec3::ZERO, 1.0, m);
    scene.settings.depth = 2;
    scene.settings.background = Vec3::ONE;
    // Straight through the middle: 0.96 a surface. What is reflected inside dies at the depth limit; outside 0.04.
    let passed = double(tint * tint).map(|t| 0.96 * 0.96 * t + 0.04);
    assert_near(probe(&scene, vec3(0.0, 0.0, 3.0), Vec3::ZERO), passed, 1e-4);
}

#[test]
fn clear_glass_in_a_white_world_is_white() {
    // Energy: with enough bounces every ray's shares add up to one.
    let mut scene = scene();
    let m = glass(&mut scene, 1.5, Vec3::ONE);
    sphere(&mut scene, Vec3::ZERO, 1.0, m);
    scene.settings.depth = 24;
    scene.settings.background = Vec3::ONE;
    for (o, to) in SPHERE_EYES {
        let got = probe(&scene, single(o), single(to));
        // Each of some dozen contributions is rounded down to 2^-28, and fractions of the weight stay inside.
        assert_grey(got, 1.0, 1e-6);
    }
}

#[test]
fn a_straight_pane_lets_rays_through_unbent() {
    let mut scene = scene();
    let kind = MaterialKind::Transparent {
        color: Vec3::ZERO,
        transparency: 0.75,
        reflection: 0.0,
        shininess: 1.0,
        diffuse: 1.0,
    };
    let m = material(&mut scene, kind);
    floor(&mut scene, 0.0, 2.0, m);
    let d = unit([0.5, -0.6, 0.2]);
    let at = along([0.1, 0.0, 0.2], d, 2.0);
    let from = along([0.1, 0.0, 0.2], d, -1.0);
    assert_aims_at(&scene, (single(from), vec3(0.1, 0.0, 0.2)), (at, d), 1e-4, 0.75, 1e-5);
}

#[test]
fn culling_does_not_change_refraction_through_a_closed_body() {
    let mut scene = scene();
    let m = glass(&mut scene, 1.5, vec3(0.9, 0.95, 1.0));
    add_sphere_mesh(&mut scene, 24, m);
    let (red, blue) = (emissive(&mut scene, vec3(1.0, 0.3, 0.1)), emissive(&mut scene, vec3(0.1, 0.3, 1.0)));
    rectangle(&mut scene, vec3(-1.0, 0.5, -3.0), vec3(1.5, 0.0, 0.0), vec3(0.0, 1.5, 0.0), red);
    rectangle(&mut scene, vec3(1.5, -1.0, -2.5), vec3(1.0, 0.0, 0.0), vec3(0.0, 1.0, 0.0), blue);
    scene.settings.background = Vec3::splat(0.2);
    scene.settings.size = [64, 64];
    scene.settings.depth = 12;
    scene.settings.light_samples = 1;
    scene.camera = Some(looking(vec3(0.3, 0.4, 4.0), vec3(0.1, 0.0, 0.0), 40.0));
    let open = render(&scene);
    scene.settings.cull_back_faces = true;
    let culled = render(&scene);
    // The squares face the camera's side; inner reflections may send rays to their backs, which culling hides.
    let differing = open.pixels.iter().zip(&culled.pixels).filter(|(a, b)| a != b).count();
    assert_eq!(differing, 0, "{differing} of 4096 pixels");
}
