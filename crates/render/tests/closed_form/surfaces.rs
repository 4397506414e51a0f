//! Lighting models, textures and culling.

use super::support::*;
use eosphor_core::math::{Vec3, vec3};
use eosphor_core::settings::LightingModel;
use eosphor_core::texture::{TextureFilter, TextureWrap};
use eosphor_scene::{
    Image, Instance, Light, MaterialKind, Mesh, Mtl, NO_INDEX, Scene, Texels, Texture, Transform, Triangle,
};
use std::f64::consts::FRAC_1_PI;

const KD: Vec3 = vec3(0.8, 0.5, 0.25);
const KS: Vec3 = vec3(0.3, 0.6, 0.9);

fn shiny_floor(exponent: f32) -> Scene {
    let mut scene = scene();
    let mtl = Mtl { Kd: KD, Ks: KS, Ns: exponent, illum: 2, ..Mtl::default() };
    let m = material(&mut scene, MaterialKind::Mtl(mtl));
    floor(&mut scene, 0.0, 2.0, m);
    scene
}

#[test]
fn phong_and_blinn_phong_are_their_formulas() {
    let light = vec3(1.0, 2.0, -0.5);
    let color = vec3(6.0, 5.0, 4.0);
    let mut worst = 0f64;
    for exponent in [1.0, 10.0, 120.0, 1000.0] {
        let mut scene = shiny_floor(exponent);
        scene.lights.push(Light::Point { position: light, color });
        for (eye, at) in [
            (vec3(-0.8, 1.9, 0.6), vec3(0.1, 0.0, 0.05)),
            (vec3(-1.0, 2.0, 0.5), vec3(0.0, 0.0, 0.0)),
            (vec3(1.0, 0.3, 1.0), vec3(-0.5, 0.0, 0.4)),
            (vec3(1.1, 2.0, -0.6), vec3(1.0, 0.0, -0.45)),
        ] {
            let to_light = sub(double(light), double(at));
            let (l, v, n) = (unit(to_light), unit(sub(double(eye), double(at))), [0.0, 1.0, 0.0]);
            let cos = dot(n, l);
            let mirrored = along(l.map(|x| -x), n, 2.0 * cos);
            let half = unit(along(l, v, 1.0));
            let falloff = 1.0 / dot(to_light, to_light);
            for (model, lobe) in [
                (LightingModel::Lambert, 0.0),
                (LightingModel::Phong, dot(mirrored, v).max(0.0).powf(exponent as f64)),
                (LightingModel::BlinnPhong, dot(n, half).max(0.0).powf(exponent as f64)),
            ] {
                scene.settings.lighting = model;
                let (kd, ks, i) = (double(KD), double(KS), double(color));
                // Highlights are divided by pi as what is scattered is: their ratio is that of the file.
                let arriving = FRAC_1_PI * falloff;
                let expected = [0, 1, 2].map(|c| i[c] * arriving * (kd[c] * cos + ks[c] * lobe));
                let got = probe(&scene, eye, at);
                worst = worst.max((got.z as f64 / expected[2] - 1.0).abs());
                // An exponent multiplies relative errors.
                assert_near(got, expected, 1e-4 + 2e-6 * exponent as f64);
            }
        }
    }
    println!("Phong, Blinn-Phong: largest relative error {worst:.2e}");
}

#[test]
fn highlights_come_from_the_lit_side_only() {
    let mut scene = shiny_floor(1.0);
    scene.settings.lighting = LightingModel::BlinnPhong;
    scene.lights.push(Light::Point { position: vec3(0.0, -1.0, 0.0), color: Vec3::ONE });
    assert_eq!(probe(&scene, vec3(0.5, 1.0, 0.0), vec3(0.1, 0.0, 0.1)), Vec3::ZERO);
}

#[test]
fn ambient_is_its_share_of_kd_with_or_without_light() {
    let mut scene = shiny_floor(10.0);
    scene.settings.ambient = 0.15;
    scene.lights.push(Light::Directional { direction: vec3(0.0, 1.0, 0.0), color: Vec3::ONE });
    let (from, to) = (vec3(0.3, 1.0, 0.4), vec3(0.1, 0.0, 0.1));
    assert_near(probe(&scene, from, to), double(KD).map(|k| 0.15 * k), 1e-6);
    scene.lights.push(Light::Directional { direction: vec3(0.0, -1.0, 0.0), color: Vec3::splat(PI) });
    assert_near(probe(&scene, from, to), double(KD).map(|k| 1.15 * k), 1e-6);
}

#[test]
fn the_diffuse_model_is_kd_alone() {
    let mut scene = shiny_floor(10.0);
    scene.settings.lighting = LightingModel::Diffuse;
    scene.settings.ambient = 0.15;
    scene.lights.push(Light::Point { position: vec3(0.0, 1.0, 0.0), color: Vec3::splat(100.0) });
    assert_near(probe(&scene, vec3(0.3, 1.0, 0.4), vec3(0.1, 0.0, 0.1)), double(KD), 1e-6);
    assert_eq!(probe(&scene, vec3(0.3, 1.0, 0.4), vec3(0.1, 2.0, 0.1)), Vec3::ZERO);
}

#[test]
fn the_distance_model_is_one_minus_t_over_one_and_a_half_d() {
    let mut scene = shiny_floor(10.0);
    scene.settings.lighting = LightingModel::Distance;
    scene.settings.max_distance = Some(6.0);
    for t in [0.001f64, 0.5, 4.5, 8.9, 9.0, 12.0, 1000.0] {
        let got = probe(&scene, vec3(0.1, t as f32, 0.1), vec3(0.1, 0.0, 0.1));
        let expected = 1.0 - t.min(9.0) / 9.0;
        assert!((got.x as f64 - expected).abs() < 1e-6 && got.x == got.z, "{t}: {got:?}");
    }
    assert_eq!(probe(&scene, vec3(0.1, 1.0, 0.1), vec3(0.1, 2.0, 0.1)), Vec3::ZERO);
}

#[test]
fn smooth_normals_light_a_triangle_by_their_interpolation() {
    let mut scene = scene();
    let white = matte(&mut scene, Vec3::ONE);
    let normals = [vec3(0.3, 1.0, 0.0), vec3(-0.2, 1.0, 0.4), vec3(0.0, 1.0, -0.5)];
    let positions = [vec3(-1.0, 0.0, 1.0), vec3(1.0, 0.0, 1.0), vec3(0.0, 0.0, -1.0)];
    scene.meshes.push(Mesh {
        name: "t".into(),
        positions: positions.to_vec(),
        normals: normals.to_vec(),
        triangles: vec![Triangle {
            positions: [0, 1, 2],
            normals: [0, 1, 2],
            uvs: [NO_INDEX; 3],
            material: white,
        }],
        ..Mesh::default()
    });
    scene.instances.push(Instance::new(0, Transform::default()));
    scene.settings.normals = eosphor_scene::NormalMode::Smooth;
    scene.lights.push(Light::Directional { direction: vec3(-0.48, -0.8, 0.36), color: Vec3::splat(PI) });
    for [a, b, c] in [[0.2, 0.3, 0.5], [0.9, 0.05, 0.05], [0.1, 0.6, 0.3]] {
        let mix = |v: [V; 3]| along(along(v[0].map(|x| x * a), v[1], b), v[2], c);
        let at = mix(positions.map(double));
        let n = unit(mix(normals.map(|n| unit(double(n)))));
        let expected = dot(n, unit([0.48, 0.8, -0.36]));
        assert_grey(probe(&scene, vec3(0.4, 2.0, 0.3), single(at)), expected, 1e-5);
    }
}

#[test]
fn a_checker_on_a_parallelogram_is_tinted_by_kd() {
    // Upper row red, green; lower row blue, grey.
    let texels = vec![0xff00_00ff, 0xff00_ff00, 0xffff_0000, 0xff80_8080];
    for (srgb, grey) in [(false, 128.0 / 255.0), (true, ((128.0 / 255.0 + 0.055) / 1.055f64).powf(2.4))] {
        let mut scene = scene();
        scene.settings.srgb_textures = srgb;
        scene.settings.lighting = LightingModel::Diffuse;
        let m = matte(&mut scene, KD);
        scene.materials[m as usize].textures.color = Some(0);
        let texels = Texels::rgba8(texels.clone());
        scene.images.push(Image { name: "checker".into(), width: 2, height: 2, texels });
        let wrap = TextureWrap::Clamp;
        let filter = TextureFilter::Nearest;
        scene.textures.push(Texture { filter, wrap_u: wrap, wrap_v: wrap, ..Texture::of_image(0) });
        // u runs right and v up, seen from +z.
        rectangle(&mut scene, Vec3::ZERO, vec3(1.0, 0.0, 0.0), vec3(0.0, 1.0, 0.0), m);
        let kd = double(KD);
        for (x, y, texel) in [
            (-0.3, 0.4, [1.0, 0.0, 0.0]),
            (-0.001, 0.001, [1.0, 0.0, 0.0]),
            (0.7, 0.2, [0.0, 1.0, 0.0]),
            (-0.9, -0.2, [0.0, 0.0, 1.0]),
            (0.4, -0.8, [grey; 3]),
            (0.001, -0.001, [grey; 3]),
        ] {
            let got = probe(&scene, vec3(0.2, 0.1, 3.0), vec3(x, y, 0.0));
            assert_near(got, [0, 1, 2].map(|c| kd[c] * texel[c]), 1e-6);
        }
    }
}

#[test]
fn culling_hides_a_triangle_from_behind_only() {
    let mut scene = scene();
    let m = matte(&mut scene, KD);
    scene.settings.lighting = LightingModel::Diffuse;
    scene.settings.background = vec3(0.1, 0.2, 0.3);
    floor(&mut scene, 0.0, 2.0, m);
    let (above, below, at) = (vec3(0.3, 1.0, 0.2), vec3(0.3, -1.0, 0.2), vec3(0.1, 0.0, 0.1));
    for culling in [false, true] {
        scene.settings.cull_back_faces = culling;
        assert_eq!(probe(&scene, above, at), KD);
        assert_eq!(probe(&scene, below, at), if culling { vec3(0.1, 0.2, 0.3) } else { KD });
    }
}

#[test]
fn culled_triangles_still_cast_shadows() {
    let mut scene = shiny_floor(1.0);
    scene.settings.cull_back_faces = true;
    scene.lights.push(Light::Directional { direction: vec3(0.0, -1.0, 0.0), color: Vec3::splat(PI) });
    let m = matte(&mut scene, KD);
    // Faces down: the camera looks through it, the light does not.
    rectangle(&mut scene, vec3(0.05, 0.5, 0.0), vec3(0.5, 0.0, 0.0), vec3(0.0, 0.0, 0.5), m);
    assert_eq!(probe(&scene, vec3(0.1, 2.0, 0.1), vec3(0.1, 0.0, 0.15)), Vec3::ZERO);
    rectangle(&mut scene, vec3(0.05, -0.5, 0.0), vec3(0.5, 0.0, 0.0), vec3(0.0, 0.0, 0.5), m);
    assert_near(probe(&scene, vec3(0.1, 2.0, 0.1), vec3(1.1, 0.0, 0.15)), double(KD), 1e-6);
}
