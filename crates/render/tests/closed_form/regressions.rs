//! Defects that were found and mended.

use super::support::*;
use eosphor_core::math::{Vec3, vec3};
use eosphor_core::settings::{LightingModel, ShadowMode};
use eosphor_core::sums::MAX_RADIANCE;
use eosphor_render::{Accel, Backend, CpuBackend, CpuOptions, RenderControl};
use eosphor_scene::{
    Image, Instance, Light, MaterialKind, Mesh, NO_INDEX, RenderSettings, Scene, SceneData, Texels, Texture,
    Transform, Triangle,
};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

#[test]
fn many_glossy_rays_reflect_as_much_as_few_at_the_default_threshold() {
    // 0.5 / 600 is below the threshold: the lobe lives or dies as a whole.
    let threshold = RenderSettings::default().energy_threshold;
    assert!(0.5 / 600.0 < threshold && threshold < 0.5);
    for exponent in [1.0, 20.0] {
        for rays in [1, 4, 600] {
            let mut scene = scene();
            let reflectance = Vec3::splat(0.5);
            let kind = MaterialKind::Glossy { reflectance, exponent, rays, color: Vec3::ZERO };
            let m = material(&mut scene, kind);
            floor(&mut scene, 0.0, 1.0, m);
            scene.settings.background = Vec3::ONE;
            scene.settings.energy_threshold = threshold;
            // Straight from above no ray of the lobe goes under the surface.
            assert_grey(probe(&scene, vec3(0.0, 0.5, 0.0), Vec3::ZERO), 0.5, 1e-4);
            // Below the threshold the whole lobe dies, however few rays it has.
            scene.settings.energy_threshold = 0.6;
            assert_eq!(probe(&scene, vec3(0.0, 0.5, 0.0), Vec3::ZERO), Vec3::ZERO);
        }
    }
}

/// A closed sphere of radius 1 of triangles.
fn ball(n: u32, material: u32) -> Mesh {
    let mut mesh = Mesh { name: "ball".into(), ..Mesh::default() };
    let turn = |k: u32| k as f64 / n as f64 * std::f64::consts::PI;
    for i in 0..=n {
        let ring = if i == 0 || i == n { 0.0 } else { turn(i).sin() };
        for j in 0..2 * n {
            mesh.positions.push(single([ring * turn(j).cos(), turn(i).cos(), -ring * turn(j).sin()]));
        }
    }
    for i in 0..n {
        for j in 0..2 * n {
            let at = |di: u32, dj: u32| (i + di) * 2 * n + (j + dj) % (2 * n);
            for positions in [[at(0, 0), at(1, 0), at(1, 1)], [at(0, 0), at(1, 1), at(0, 1)]] {
                let none = [NO_INDEX; 3];
                mesh.triangles.push(Triangle { positions, normals: none, uvs: none, material });
            }
        }
    }
    mesh
}

#[test]
fn nested_bodies_are_as_transparent_with_culling_as_without() {
    let tint = vec3(0.9, 0.8, 0.7);
    let mut scene = scene();
    // Nothing bends and nothing is reflected.
    let m = material(&mut scene, MaterialKind::Dielectric { ior: 1.0, tint });
    scene.meshes.push(ball(16, m));
    let inner = |scale: f32, x: f32| Transform {
        scale: Vec3::splat(scale),
        ..Transform::translation(vec3(x, 0.05, 0.0))
    };
    for world_from_object in [Transform::default(), inner(0.6, 0.1), inner(0.2, 0.15)] {
        scene.instances.push(Instance::new(0, world_from_object));
    }
    scene.settings.background = Vec3::ONE;
    for cull_back_faces in [false, true] {
        scene.settings.cull_back_faces = cull_back_faces;
        // Six surfaces, four, two.
        for (x, y, surfaces) in [(0.16, 0.03, 6), (-0.2, 0.03, 4), (-0.8, 0.03, 2)] {
            let got = probe(&scene, vec3(x, y, 3.0), vec3(x, y, 0.0));
            assert_near(got, double(tint).map(|t| t.powi(surfaces)), 1e-5);
        }
    }
    scene.settings.size = [64, 64];
    scene.camera = Some(looking(vec3(0.3, 0.4, 4.0), Vec3::ZERO, 35.0));
    let culled = render(&scene);
    scene.settings.cull_back_faces = false;
    let open = render(&scene);
    let differing = open.pixels.iter().zip(&culled.pixels).filter(|(a, b)| a != b).count();
    assert_eq!(differing, 0, "{differing} of 4096 pixels");
}

/// The colour under a textured pane of this kind: a white floor, a light that gives 1 there.
fn textured_shadow(kind: MaterialKind, texel: u32) -> Vec3 {
    let mut scene = scene();
    let white = matte(&mut scene, Vec3::ONE);
    floor(&mut scene, 0.0, 2.0, white);
    scene.lights.push(Light::Point { position: vec3(0.5, 4.0, 0.25), color: Vec3::splat(16.0 * PI) });
    let m = material(&mut scene, kind);
    scene.images.push(Image {
        name: "plain".into(),
        width: 1,
        height: 1,
        texels: Texels::rgba8(vec![texel]),
    });
    scene.textures.push(Texture::of_image(0));
    scene.materials[m as usize].textures.color = Some(0);
    rectangle(&mut scene, vec3(0.3, 2.0, 0.0), vec3(0.0, 0.0, 1.0), vec3(1.0, 0.0, 0.0), m);
    scene.settings.shadows = ShadowMode::Coloured;
    probe(&scene, vec3(1.5, 0.2, 1.0), vec3(0.5, 0.0, 0.25))
}

#[test]
fn a_textured_pane_casts_its_picture_even_where_a_channel_is_black() {
    let pane = |color| MaterialKind::Transparent {
        color,
        transparency: 0.5,
        reflection: 0.0,
        shininess: 1.0,
        diffuse: 1.0,
    };
    // The texel is (0.2, 0.4, 1).
    let texel = 0xffff_6633;
    assert_near(textured_shadow(pane(vec3(1.0, 0.0, 0.0)), texel), [0.1, 0.0, 0.0], 1e-4);
    assert_near(textured_shadow(pane(vec3(0.5, 1.0, 1.0)), texel), [0.05, 0.2, 0.5], 1e-4);
    assert_eq!(textured_shadow(pane(Vec3::ONE), 0xff00_0000), Vec3::ZERO);
}

#[test]
fn the_shadow_of_a_snell_pane_has_its_tint_and_no_texture() {
    let tint = vec3(0.9, 0.5, 0.0);
    for texel in [0xffff_ffff, 0xffff_6633, 0xff00_0000] {
        assert_near(textured_shadow(MaterialKind::Dielectric { ior: 1.5, tint }, texel), double(tint), 1e-4);
    }
}

/// The picture under each hierarchy: finite, limited and the same.
fn finite_and_equal(scene: &Scene) -> Vec<Vec3> {
    let (data, _) = SceneData::flatten(scene).unwrap();
    let data = Arc::new(data);
    let picture = |accel| {
        let backend = CpuBackend::new(CpuOptions { accel, ..CpuOptions::default() }).unwrap();
        let cancel = AtomicBool::new(false);
        let control = RenderControl { on_progress: &|_| {}, cancel: &cancel, count_work: false, frame: None };
        backend.prepare(Arc::clone(&data)).unwrap().render(&control).unwrap().film.pixels
    };
    let [none, bvh] = [Accel::None, Accel::Bvh].map(picture);
    let bits =
        |pixels: &[Vec3]| pixels.iter().map(|&p| <[f32; 3]>::from(p).map(f32::to_bits)).collect::<Vec<_>>();
    assert_eq!(bits(&none), bits(&bvh));
    for p in &none {
        assert!(p.is_finite() && p.min_component() >= 0.0 && p.max_component() <= MAX_RADIANCE, "{p:?}");
    }
    none
}

#[test]
fn huge_reflectances_stay_finite() {
    for reflectance in [Vec3::splat(5.0), Vec3::splat(1e12), vec3(1e12, 0.0, 5.0)] {
        for background in [Vec3::ONE, vec3(0.0, 1.0, 1e12)] {
            let mut scene = scene();
            let m = material(&mut scene, MaterialKind::Mirror { reflectance });
            floor(&mut scene, 0.0, 4.0, m);
            rectangle(&mut scene, vec3(0.0, 0.5, 0.0), vec3(4.0, 0.0, 0.0), vec3(0.0, 0.0, 4.0), m);
            scene.settings.background = background;
            scene.settings.depth = 64;
            scene.settings.size = [32, 32];
            scene.camera = Some(looking(vec3(0.1, 0.2, 3.0), vec3(0.0, 0.1, 0.0), 120.0));
            let pixels = finite_and_equal(&scene);
            assert!(pixels.iter().any(|p| p.z > 1.0));
            if background.x == 0.0 {
                // Any weight of nothing is nothing.
                assert!(pixels.iter().all(|p| p.x == 0.0));
            }
        }
    }
}

#[test]
fn huge_shadow_filters_stay_finite() {
    let mut scene = scene();
    let white = matte(&mut scene, Vec3::ONE);
    floor(&mut scene, 0.0, 2.0, white);
    scene.lights.push(Light::Point { position: vec3(0.5, 4.0, 0.25), color: Vec3::splat(16.0 * PI) });
    for k in 0..5 {
        // The last lets no green through.
        let color = if k < 4 { Vec3::splat(1e12) } else { vec3(1.0, 0.0, 1.0) };
        let kind = MaterialKind::Transparent {
            color,
            transparency: 1.0,
            reflection: 0.0,
            shininess: 1.0,
            diffuse: 1.0,
        };
        let m = material(&mut scene, kind);
        let center = vec3(0.3, 3.0 - 0.5 * k as f32, 0.0);
        rectangle(&mut scene, center, vec3(0.0, 0.0, 1.0), vec3(1.0, 0.0, 0.0), m);
    }
    scene.settings.shadows = ShadowMode::Coloured;
    scene.settings.size = [4, 4];
    scene.camera = Some(looking(vec3(1.5, 0.2, 1.0), vec3(0.5, 0.0, 0.25), 5.0));
    assert!(finite_and_equal(&scene).iter().all(|p| p.x > 1.0 && p.y == 0.0 && p.x == p.z));
}

#[test]
fn tiny_triangles_have_their_own_normal_and_back() {
    const EDGE: f32 = 1e-11;
    let mut scene = scene();
    let m = matte(&mut scene, Vec3::ONE);
    let positions = vec![Vec3::ZERO, vec3(EDGE, 0.0, 0.0), vec3(0.0, EDGE, 0.75 * EDGE)];
    let middle = (positions[1] + positions[2]) * 0.3;
    let normal = vec3(0.0, -0.6, 0.8);
    let none = [NO_INDEX; 3];
    let triangle = Triangle { positions: [0, 1, 2], normals: none, uvs: none, material: m };
    let mesh = Mesh { name: "tiny".into(), positions, triangles: vec![triangle], ..Mesh::default() };
    scene.meshes.push(mesh);
    scene.instances.push(Instance::new(0, Transform::default()));
    scene.settings.background = vec3(0.0, 0.0, 0.25);
    scene.settings.shadows = ShadowMode::None;
    let (front, back) = (middle + normal * (3.0 * EDGE), middle - normal * (3.0 * EDGE));
    for (direction, cosine) in
        [(vec3(0.0, 0.0, -1.0), 0.8), (vec3(0.0, 1.0, 0.0), 0.6), (vec3(0.0, 0.6, -0.8), 1.0)]
    {
        scene.lights = vec![Light::Directional { direction, color: Vec3::splat(PI) }];
        for cull_back_faces in [false, true] {
            scene.settings.cull_back_faces = cull_back_faces;
            scene.settings.lighting = LightingModel::Lambert;
            assert_grey(probe(&scene, front, middle), cosine, 1e-5);
            let from_behind = if cull_back_faces { scene.settings.background } else { Vec3::ZERO };
            assert_eq!(probe(&scene, back, middle), from_behind);
        }
    }
}
