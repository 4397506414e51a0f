//! What model files bring: holes, metallic-roughness, bodies, vertex colours, normal maps, other cameras.

use super::support::*;
use eosphor_core::math::{Vec3, vec3};
use eosphor_core::settings::{LightingModel, ShadowMode};
use eosphor_scene::{
    AlphaMode, Camera, Channel, Image, Instance, Light, MaterialKind, Mesh, NO_INDEX, Pbr, Scene, Texels,
    Texture, TextureChannel, TextureContent, Transform, Triangle,
};

const FRONT: Vec3 = vec3(0.0, 0.0, 5.0);
const X: Vec3 = vec3(1.0, 0.0, 0.0);
const Y: Vec3 = vec3(0.0, 1.0, 0.0);

/// A sheet at z that faces the viewer at +z.
fn sheet(scene: &mut Scene, z: f32, material: u32) {
    rectangle(scene, vec3(0.05, 0.1, z), X, Y, material);
}

fn pbr(scene: &mut Scene, pbr: Pbr) -> u32 {
    material(scene, MaterialKind::Pbr(pbr))
}

/// Straight at the middle.
fn seen(scene: &Scene) -> Vec3 {
    probe(scene, FRONT, Vec3::ZERO)
}

fn one_texel(scene: &mut Scene, texel: [f32; 4]) -> u32 {
    let texels = Texels::rgba_floats(&[texel]);
    scene.images.push(Image { name: "one".into(), width: 1, height: 1, texels });
    let texture =
        Texture { content: TextureContent::Data, ..Texture::of_image(scene.images.len() as u32 - 1) };
    scene.textures.push(texture);
    scene.textures.len() as u32 - 1
}

#[test]
fn veils_show_what_is_behind_in_proportion_at_no_bounce() {
    let mut scene = scene();
    scene.settings.depth = 0;
    scene.settings.background = vec3(0.1, 0.2, 0.4);
    let mut expected = [0.1f32, 0.2, 0.4].map(f64::from);
    for k in 0..70 {
        let m = emissive(&mut scene, vec3(0.5, 0.25, 0.0));
        scene.materials[m as usize].alpha = AlphaMode::Blend;
        let texture = one_texel(&mut scene, [0.0, 0.0, 0.0, 0.125]);
        scene.materials[m as usize].textures.opacity =
            Some(TextureChannel { texture, channel: Channel::Alpha });
        sheet(&mut scene, -0.01 * k as f32, m);
        expected = std::array::from_fn(|c| 0.125 * [0.5, 0.25, 0.0][c] + 0.875 * expected[c]);
    }
    assert_near(seen(&scene), expected, 1e-4);
}

#[test]
fn a_mask_has_holes_for_rays_and_for_light() {
    for (alpha, hole) in [(0.49f32, true), (0.5, false)] {
        let mut scene = scene();
        let white = matte(&mut scene, Vec3::ONE);
        floor(&mut scene, 0.0, 2.0, white);
        scene
            .lights
            .push(Light::Directional { direction: vec3(0.0, -1.0, 0.0), color: Vec3::splat(0.5 * PI) });
        let black = matte(&mut scene, Vec3::ZERO);
        let texture = one_texel(&mut scene, [1.0, alpha, 1.0, 1.0]);
        scene.materials[black as usize].alpha = AlphaMode::Mask { cutoff: 0.5 };
        scene.materials[black as usize].textures.opacity =
            Some(TextureChannel { texture, channel: Channel::Green });
        rectangle(&mut scene, vec3(0.0, 1.0, 0.0), vec3(0.0, 0.0, 3.0), vec3(3.0, 0.0, 0.0), black);
        scene.settings.shadows = ShadowMode::Coloured;
        let got = probe(&scene, vec3(0.3, 4.0, 0.2), vec3(0.31, 0.0, 0.21));
        assert_grey(got, if hole { 0.5 } else { 0.0 }, 1e-5);
    }
}

#[test]
fn a_single_sided_sheet_is_there_from_the_front_alone_and_casts_its_shadow_there() {
    let mut scene = scene();
    scene.settings.shadows = ShadowMode::Coloured;
    scene.settings.depth = 0;
    let white = matte(&mut scene, Vec3::ONE);
    floor(&mut scene, 0.0, 2.0, white);
    scene.lights.push(Light::Directional { direction: vec3(0.0, -1.0, 0.0), color: Vec3::splat(0.5 * PI) });
    let red = emissive(&mut scene, vec3(1.0, 0.0, 0.0));
    scene.materials[red as usize].single_sided = true;
    // Textured emitters are no lights.
    let texture = one_texel(&mut scene, [1.0; 4]);
    scene.materials[red as usize].textures.emission = Some(texture);
    // It faces down, 1 above the floor.
    rectangle(&mut scene, vec3(0.1, 1.0, 0.0), X * 0.3, vec3(0.0, 0.0, 0.3), red);
    assert_grey(probe(&scene, vec3(0.12, 3.0, 0.05), vec3(0.12, 0.0, 0.06)), 0.0, 0.0);
    assert_grey(probe(&scene, vec3(1.0, 3.0, 0.0), vec3(1.0, 0.0, 0.01)), 0.5, 1e-6);
    assert_near(probe(&scene, vec3(0.12, 0.1, 0.05), vec3(0.12, 1.0, 0.06)), [1.0, 0.0, 0.0], 1e-6);
}

/// A pane that faces the light is not there for who looks up at it: neither is its shadow.
#[test]
fn a_single_sided_pane_that_cannot_be_seen_from_below_casts_no_shadow_there() {
    for (single_sided, transparency, expected) in [(false, 0.5, 0.25), (true, 0.5, 0.5), (true, 0.0, 0.5)] {
        for faces_up in [true, false] {
            let mut scene = scene();
            scene.settings.shadows = ShadowMode::Coloured;
            let white = matte(&mut scene, Vec3::ONE);
            floor(&mut scene, 0.0, 2.0, white);
            scene
                .lights
                .push(Light::Directional { direction: vec3(0.0, -1.0, 0.0), color: Vec3::splat(0.5 * PI) });
            let pane = matte(&mut scene, Vec3::ONE);
            scene.materials[pane as usize].kind = MaterialKind::Transparent {
                color: Vec3::ONE,
                transparency,
                reflection: 0.0,
                shininess: 1.0,
                diffuse: 0.0,
            };
            scene.materials[pane as usize].single_sided = single_sided;
            let [u, v] =
                if faces_up { [vec3(0.0, 0.0, 0.3), X * 0.3] } else { [X * 0.3, vec3(0.0, 0.0, 0.3)] };
            rectangle(&mut scene, vec3(0.1, 1.0, 0.0), u, v, pane);
            // From beside the pane, so that it is not looked through.
            let got = probe(&scene, vec3(0.6, 0.5, 0.05), vec3(0.2, 0.0, 0.1));
            let filtered = f64::from(0.5 * transparency);
            assert_grey(got, if faces_up { expected } else { filtered }, 1e-5);
        }
    }
}

#[test]
fn a_blended_sheet_casts_a_shadow_of_its_opacity() {
    let mut scene = scene();
    let white = matte(&mut scene, Vec3::ONE);
    floor(&mut scene, 0.0, 2.0, white);
    scene.lights.push(Light::Point { position: vec3(0.0, 4.0, 0.0), color: Vec3::splat(16.0 * PI) });
    let m = pbr(&mut scene, Pbr { opacity: 0.25, ..Pbr::default() });
    scene.materials[m as usize].alpha = AlphaMode::Blend;
    rectangle(&mut scene, vec3(0.0, 2.0, 0.0), vec3(0.0, 0.0, 1.0), X, m);
    scene.settings.shadows = ShadowMode::Coloured;
    // Seen from below the sheet, at a slant.
    let got = probe(&scene, vec3(0.9, 0.9, 0.9), vec3(0.01, 0.0, 0.02));
    let d2 = 16.0 + 0.01f64.powi(2) + 0.02f64.powi(2);
    assert_grey(got, 0.75 * 16.0 / d2 * 4.0 / d2.sqrt(), 1e-4);
}

#[test]
fn bodies_take_light_by_beers_law() {
    let mut scene = scene();
    scene.settings.background = Vec3::ONE;
    let body = Pbr {
        transmission: 1.0,
        solid: true,
        // As outside: no Fresnel, no bending.
        ior: 1.0,
        roughness: 0.0,
        color: vec3(0.9, 1.0, 1.0),
        attenuation_color: vec3(0.5, 0.25, 0.0),
        attenuation_distance: Some(0.4),
        ..Pbr::default()
    };
    let m = pbr(&mut scene, body);
    sphere(&mut scene, Vec3::ZERO, 0.5, m);
    // 1.0 through the ball: 2.5 times the distance; the base colour counts at both sides. The ray inside starts 4e-5 off
    // the surface.
    assert_near(seen(&scene), [0.81 * 0.5f64.powf(2.5), 0.25f64.powf(2.5), 0.0], 2e-4);
    // The same in its shadow.
    scene.settings.background = Vec3::ZERO;
    scene.settings.shadows = ShadowMode::Coloured;
    scene.lights.push(Light::Directional { direction: vec3(0.0, -1.0, 0.0), color: Vec3::splat(PI) });
    let white = matte(&mut scene, Vec3::ONE);
    floor(&mut scene, -0.6, 2.0, white);
    let got = probe(&scene, vec3(1.5, -0.3, 0.0), vec3(0.0, -0.6, 0.0));
    assert_near(got, [0.81 * 0.5f64.powf(2.5), 0.25f64.powf(2.5), 0.0], 1e-3);
}

#[test]
fn metallic_roughness_at_normal_incidence() {
    let color = vec3(0.8, 0.4, 0.2);
    let base = Pbr { color, roughness: 0.0, ..Pbr::default() };
    let f0 = 0.04;
    for (kind, expected) in [
        // A sharp dielectric: 4 % of the background, the rest lit. The background does not light.
        (base, [0.8, 0.4, 0.2].map(|c| f0 * 0.5 + c * (1.0 - f0) * 0.7)),
        // A sharp metal.
        (Pbr { metallic: 1.0, ..base }, [0.8, 0.4, 0.2].map(|c| c * 0.5)),
        // Half of each.
        (
            Pbr { metallic: 0.5, ..base },
            [0.8, 0.4, 0.2].map(|c| 0.5 * (f0 * 0.5 + c * (1.0 - f0) * 0.7) + 0.5 * c * 0.5),
        ),
        // A thin pane: what is behind it through the base colour.
        (Pbr { transmission: 1.0, ..base }, [0.8, 0.4, 0.2].map(|c| f0 * 0.5 + c * (1.0 - f0) * 0.5)),
        // Twice the reflection at normal incidence by a denser medium.
        (
            Pbr { ior: 2.0, specular: 0.5, ..base },
            [0.8, 0.4, 0.2].map(|c| 0.5 / 9.0 * 0.5 + c * (1.0 - 0.5 / 9.0) * 0.7),
        ),
    ] {
        let mut scene = scene();
        scene.settings.background = Vec3::splat(0.5);
        scene
            .lights
            .push(Light::Directional { direction: vec3(0.0, 0.0, -1.0), color: Vec3::splat(0.7 * PI) });
        let m = pbr(&mut scene, kind);
        sheet(&mut scene, 0.0, m);
        assert_near(seen(&scene), expected, 1e-3);
    }
}

#[test]
fn a_rough_metal_in_a_uniform_surrounding_keeps_its_colour() {
    let mut scene = scene();
    scene.settings.background = Vec3::splat(0.5);
    scene.settings.samples = 64;
    let m =
        pbr(&mut scene, Pbr { metallic: 1.0, roughness: 0.3, color: vec3(0.9, 0.6, 0.3), ..Pbr::default() });
    sheet(&mut scene, 0.0, m);
    assert_near(seen(&scene), [0.45, 0.3, 0.15], 1e-3);
}

/// A right triangle with corners at the origin, x = 1 and y = 1.
fn corner_triangle() -> Mesh {
    let t = Triangle { positions: [0, 1, 2], normals: [NO_INDEX; 3], uvs: [0, 1, 2], material: 0 };
    Mesh {
        name: "corner".into(),
        positions: vec![Vec3::ZERO, X, Y],
        uvs: vec![[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]],
        triangles: vec![t],
        ..Mesh::default()
    }
}

#[test]
fn vertex_colours_are_interpolated_also_where_the_mesh_is_mirrored() {
    for scale in [1.0, -1.0] {
        let mut scene = scene();
        scene.settings.lighting = LightingModel::Diffuse;
        matte(&mut scene, vec3(0.5, 1.0, 1.0));
        let mut mesh = corner_triangle();
        mesh.colors = vec![[1.0, 0.0, 0.0, 1.0], [0.0, 1.0, 0.0, 1.0], [0.0, 0.0, 1.0, 1.0]];
        scene.meshes.push(mesh);
        let place = Transform { scale: vec3(scale, 1.0, 1.0), ..Transform::default() };
        scene.instances.push(Instance::new(0, place));
        let at = vec3(0.2 * scale, 0.5, 0.0);
        let got = probe(&scene, at + vec3(0.0, 0.0, 3.0), at);
        assert_near(got, [0.5 * 0.3, 0.2, 0.5], 1e-5);
    }
}

#[test]
fn textures_take_the_second_coordinates_and_their_map() {
    let mut scene = scene();
    scene.settings.lighting = LightingModel::Diffuse;
    let m = matte(&mut scene, Vec3::ONE);
    let ramp: Vec<[f32; 4]> = (0..4).map(|i| [i as f32, 0.0, 0.0, 1.0]).collect();
    scene.images.push(Image { name: "ramp".into(), width: 4, height: 1, texels: Texels::rgba_floats(&ramp) });
    // u' = v / 2 + 1/4: from texel 1 to 3 as v goes from 0 to 1.
    let map = [[0.0, 0.5, 0.25], [1.0, 0.0, 0.0]];
    scene.textures.push(Texture { uv_set: 1, picture_from_mesh_uv: map, ..Texture::of_image(0) });
    scene.materials[m as usize].textures.color = Some(0);
    let mut mesh = corner_triangle();
    mesh.uvs1 = vec![[0.3, 0.0], [0.3, 0.0], [0.3, 1.0]];
    scene.meshes.push(mesh);
    scene.instances.push(Instance::new(0, Transform::default()));
    for y in [0.3, 0.5, 0.7] {
        let at = vec3(0.1, y, 0.0);
        let got = probe(&scene, at + vec3(0.0, 0.0, 3.0), at);
        assert_near(got, [(y as f64 * 0.5 + 0.25) * 4.0 - 0.5, 0.0, 0.0], 1e-4);
    }
}

#[test]
fn a_normal_map_tilts_what_light_meets() {
    let (nx, ny, nz) = (0.48f64, -0.36f64, 0.8f64);
    for (tilted, expected) in [(false, [0.0, 0.0, 1.0]), (true, [nx, ny, nz])] {
        let mut scene = scene();
        let light = [0.6f64, 0.0, 0.8];
        let direction = -single(light);
        scene.lights.push(Light::Directional { direction, color: Vec3::splat(PI) });
        let m = matte(&mut scene, Vec3::ONE);
        let texel = expected.map(|n: f64| (n * 0.5 + 0.5) as f32);
        let texture = one_texel(&mut scene, [texel[0], texel[1], texel[2], 1.0]);
        if tilted {
            scene.materials[m as usize].textures.normal = Some(texture);
        }
        scene.meshes.push(corner_triangle());
        scene.instances.push(Instance::new(0, Transform::default()));
        let at = vec3(0.2, 0.2, 0.0);
        let got = probe(&scene, at + vec3(0.0, 0.0, 3.0), at);
        assert_grey(got, dot(expected, light), 1e-5);
    }
}

#[test]
fn an_instance_may_have_a_material_of_its_own_baked_or_not() {
    for quads in [1u32, 300] {
        let mut scene = scene();
        scene.settings.lighting = LightingModel::Diffuse;
        matte(&mut scene, vec3(1.0, 0.0, 0.0));
        let green = matte(&mut scene, vec3(0.0, 1.0, 0.0));
        let mut mesh = corner_triangle();
        mesh.triangles = vec![mesh.triangles[0]; quads as usize];
        scene.meshes.push(mesh);
        let place = |x: f32| Transform::translation(vec3(x, 0.0, 0.0));
        scene.instances.push(Instance::new(0, place(-2.0)));
        scene.instances.push(Instance { material: Some(green), ..Instance::new(0, place(2.0)) });
        let look = |x: f32| probe(&scene, vec3(x + 0.2, 0.2, 3.0), vec3(x + 0.2, 0.2, 0.0));
        assert_near(look(-2.0), [1.0, 0.0, 0.0], 1e-6);
        assert_near(look(2.0), [0.0, 1.0, 0.0], 1e-6);
    }
}

#[test]
fn parallel_rays_and_vertical_fields_of_view() {
    let mut scene = scene();
    let glow = emissive(&mut scene, Vec3::ONE);
    sphere(&mut scene, Vec3::ZERO, 1.0, glow);
    scene.settings.size = [120, 60];
    let area = |scene: &Scene| render(scene).pixels.iter().filter(|p| p.x > 0.0).count() as f64;
    // The ball's disk in a picture 4 high, from near and far.
    for distance in [1.5f32, 400.0] {
        let camera = looking(vec3(0.0, 0.0, distance), Vec3::ZERO, 45.0);
        scene.camera = Some(Camera { orthographic_height: Some(4.0), ..camera });
        let expected = std::f64::consts::PI * (60.0f64 / 4.0).powi(2);
        assert!((area(&scene) - expected).abs() < 0.02 * expected, "{distance}: {}", area(&scene));
    }
    // 2 atan(2 tan(fov_y / 2)) is the horizontal one of a picture twice as wide as high.
    let fov_x = 2.0 * (2.0 * 15.0f64.to_radians().tan()).atan().to_degrees();
    let camera = looking(vec3(0.0, 0.0, 6.0), Vec3::ZERO, fov_x as f32);
    scene.camera = Some(camera);
    let horizontal = area(&scene);
    scene.camera = Some(Camera { fov_y_degrees: Some(30.0), fov_x_degrees: 1.0, ..camera });
    assert_eq!(horizontal, area(&scene));
    assert!(horizontal > 500.0);
}
