//! What stands between a point and a light.

use super::support::*;
use eosphor_core::math::{Vec3, vec3};
use eosphor_core::settings::ShadowMode;
use eosphor_scene::{Instance, Light, MaterialKind, Mesh, Mtl, NO_INDEX, Scene, Transform, Triangle};

const RED: Vec3 = vec3(0.9, 0.4, 0.2);
const BLUE: Vec3 = vec3(0.3, 0.5, 0.8);

fn pane(scene: &mut Scene, color: Vec3, transparency: f32) -> u32 {
    let kind =
        MaterialKind::Transparent { color, transparency, reflection: 0.0, shininess: 1.0, diffuse: 1.0 };
    material(scene, kind)
}

/// A white floor under a point light at height 4, and coloured panes of these heights and colours between.
fn under_panes(panes: &[(f32, Vec3, f32)], shadows: ShadowMode) -> Scene {
    let mut scene = scene();
    let white = matte(&mut scene, Vec3::ONE);
    floor(&mut scene, 0.0, 2.0, white);
    scene.lights.push(Light::Point { position: vec3(0.5, 4.0, 0.25), color: Vec3::splat(16.0 * PI) });
    for &(height, color, transparency) in panes {
        let m = pane(&mut scene, color, transparency);
        // Away from the axis, so that the diagonal is not met.
        rectangle(&mut scene, vec3(0.3, height, 0.0), vec3(0.0, 0.0, 1.0), vec3(1.0, 0.0, 0.0), m);
    }
    scene.settings.shadows = shadows;
    scene
}

/// The colour of the floor straight under the light, where it is 1 without shadow.
fn under_light(scene: &Scene) -> Vec3 {
    probe(scene, vec3(1.5, 0.2, 1.0), vec3(0.5, 0.0, 0.25))
}

#[test]
fn without_shadows_panes_change_nothing() {
    let scene = under_panes(&[(2.0, RED, 0.5)], ShadowMode::None);
    assert_grey(under_light(&scene), 1.0, 1e-4);
}

#[test]
fn opaque_shadows_take_all_light_whatever_the_pane() {
    let scene = under_panes(&[(2.0, Vec3::ONE, 1.0)], ShadowMode::Opaque);
    assert_eq!(under_light(&scene), Vec3::ZERO);
}

#[test]
fn coloured_shadows_are_black_behind_opaque_surfaces() {
    let mut scene = under_panes(&[(2.0, RED, 0.5)], ShadowMode::Coloured);
    let black = matte(&mut scene, Vec3::ONE);
    rectangle(&mut scene, vec3(0.3, 1.0, 0.0), vec3(0.0, 0.0, 1.0), vec3(1.0, 0.0, 0.0), black);
    assert_eq!(under_light(&scene), Vec3::ZERO);
}

#[test]
fn one_pane_multiplies_by_its_filter() {
    let scene = under_panes(&[(2.0, RED, 0.5)], ShadowMode::Coloured);
    assert_near(under_light(&scene), double(RED * 0.5), 1e-4);
}

#[test]
fn two_panes_multiply_in_either_order() {
    let (one, other) = ((3.0, RED, 0.5), (1.0, BLUE, 0.75));
    let expected = double(RED * BLUE * 0.375);
    let scene = under_panes(&[one, other], ShadowMode::Coloured);
    assert_near(under_light(&scene), expected, 1e-4);
    let swapped = under_panes(&[(1.0, RED, 0.5), (3.0, BLUE, 0.75)], ShadowMode::Coloured);
    assert_eq!(under_light(&swapped), under_light(&scene));
    // The order in the scene does not matter either.
    let listed = under_panes(&[other, one], ShadowMode::Coloured);
    assert_eq!(under_light(&listed), under_light(&scene));
}

#[test]
fn coplanar_panes_multiply_once_each() {
    for panes in [
        vec![(2.0, RED, 0.5), (2.0, BLUE, 0.75)],
        vec![(2.0, BLUE, 0.75), (2.0, RED, 0.5)],
        vec![(2.0, RED, 0.5), (2.0, RED, 0.5), (2.0, RED, 0.5)],
    ] {
        let expected = panes.iter().fold([1.0; 3], |f, (_, color, t)| {
            let filter = double(*color * *t);
            [f[0] * filter[0], f[1] * filter[1], f[2] * filter[2]]
        });
        assert_near(under_light(&under_panes(&panes, ShadowMode::Coloured)), expected, 1e-4);
    }
}

#[test]
fn light_through_the_diagonal_of_a_pane_is_filtered_once() {
    // The light's ray meets the edge that the two halves of the parallelogram share.
    let mut scene = under_panes(&[], ShadowMode::Coloured);
    let m = pane(&mut scene, RED, 0.5);
    for (u, v) in [(vec3(0.0, 0.0, 0.7), vec3(0.9, 0.0, 0.0)), (vec3(0.3, 0.0, 0.5), vec3(0.5, 0.0, -0.3))] {
        let mut scene = scene.clone();
        rectangle(&mut scene, vec3(0.5, 2.0, 0.25), u, v, m);
        assert_near(under_light(&scene), double(RED * 0.5), 1e-4);
    }
}

#[test]
fn light_through_a_vertex_of_a_closed_mesh_is_filtered_twice() {
    // Six triangles meet where the ray comes in and six where it goes out.
    let mut scene = under_panes(&[], ShadowMode::Coloured);
    let m = pane(&mut scene, RED, 0.5);
    let mut mesh = Mesh { name: "double cone".into(), ..Mesh::default() };
    for k in 0..6u32 {
        let turn = k as f32 * std::f32::consts::FRAC_PI_3;
        mesh.positions.push(vec3(turn.cos(), 0.0, -turn.sin()) * 0.5);
    }
    mesh.positions.extend([vec3(0.0, 0.3, 0.0), vec3(0.0, -0.3, 0.0)]);
    for k in 0..6u32 {
        let next = (k + 1) % 6;
        for positions in [[k, next, 6], [next, k, 7]] {
            let triangle = Triangle { positions, normals: [NO_INDEX; 3], uvs: [NO_INDEX; 3], material: m };
            mesh.triangles.push(triangle);
        }
    }
    scene.meshes.push(mesh);
    let place = Transform::translation(vec3(0.5, 2.0, 0.25));
    scene.instances.push(Instance::new(0, place));
    assert_near(under_light(&scene), double(RED * RED * 0.25), 1e-4);
}

#[test]
fn a_closed_body_filters_light_twice() {
    let filter = vec3(0.9, 0.6, 0.5);
    let glass = MaterialKind::Dielectric { ior: 1.5, tint: filter };
    let mut with_sphere = under_panes(&[], ShadowMode::Coloured);
    let m = material(&mut with_sphere, glass);
    sphere(&mut with_sphere, vec3(0.5, 2.0, 0.25), 0.4, m);
    assert_near(under_light(&with_sphere), double(filter * filter), 1e-4);

    // Shadow rays go straight on: the box's top and bottom.
    let mut with_box = under_panes(&[], ShadowMode::Coloured);
    let m = material(&mut with_box, glass);
    let (x, y, z) = (vec3(0.45, 0.0, 0.0), vec3(0.0, 0.3, 0.0), vec3(0.0, 0.0, 0.4));
    let c = vec3(0.6, 2.0, 0.2);
    for (a, b, n) in [(x, y, z), (y, z, x), (z, x, y)] {
        rectangle(&mut with_box, c + n, a, b, m);
        rectangle(&mut with_box, c - n, b, a, m);
    }
    assert_near(under_light(&with_box), double(filter * filter), 1e-4);
}

#[test]
fn mtl_transparency_filters_by_kd_times_one_minus_d() {
    let mut scene = under_panes(&[], ShadowMode::Coloured);
    let m = material(&mut scene, MaterialKind::Mtl(Mtl { Kd: RED, d: 0.25, ..Mtl::default() }));
    rectangle(&mut scene, vec3(0.3, 2.0, 0.0), vec3(0.0, 0.0, 1.0), vec3(1.0, 0.0, 0.0), m);
    assert_near(under_light(&scene), double(RED * 0.75), 1e-4);
}

#[test]
fn what_lies_behind_the_light_casts_no_shadow() {
    for shadows in [ShadowMode::Opaque, ShadowMode::Coloured] {
        let scene = under_panes(&[(4.5, RED, 0.5), (-1.0, RED, 0.5)], shadows);
        assert_grey(under_light(&scene), 1.0, 1e-4);
    }
}

#[test]
fn opaque_and_coloured_modes_agree_where_everything_is_opaque() {
    // The first traces area lights in packets, the second ray by ray.
    let mut scene = scene();
    let (white, glow) = (matte(&mut scene, Vec3::splat(0.7)), emissive(&mut scene, Vec3::ONE));
    floor(&mut scene, 0.0, 2.0, white);
    sphere(&mut scene, vec3(0.1, 0.5, 0.0), 0.3, white);
    rectangle(&mut scene, vec3(-0.4, 0.4, 0.3), vec3(0.3, 0.1, 0.0), vec3(0.0, 0.2, 0.2), white);
    rectangle(&mut scene, vec3(0.2, 1.5, 0.0), vec3(0.4, 0.0, 0.0), vec3(0.0, 0.0, 0.4), glow);
    scene.camera = Some(looking(vec3(0.5, 1.5, 2.5), vec3(0.0, 0.2, 0.0), 50.0));
    scene.settings.size = [48, 48];
    let opaque = render(&scene);
    scene.settings.shadows = ShadowMode::Coloured;
    let coloured = render(&scene);
    // Sums of the samples are taken in one order in both.
    assert!(opaque.pixels == coloured.pixels);
}

#[test]
fn light_from_behind_is_kt_kd_over_pi_times_i_cos_when_switched_on_and_nothing_when_off() {
    let color = vec3(0.6, 0.4, 0.2);
    let mut scene = scene();
    let m = pane(&mut scene, color, 0.5);
    floor(&mut scene, 0.0, 2.0, m);
    scene.lights.push(Light::Point { position: vec3(0.0, -1.5, 0.0), color: Vec3::splat(10.0 * PI) });
    let (from, to) = (vec3(0.5, 1.0, 0.3), vec3(2.0, 0.0, 0.0));
    for shadows in [ShadowMode::None, ShadowMode::Opaque, ShadowMode::Coloured] {
        scene.settings.shadows = shadows;
        scene.settings.light_from_behind = false;
        assert_eq!(probe(&scene, from, to), Vec3::ZERO);
        scene.settings.light_from_behind = true;
        // cos 0.6 at distance 2.5.
        assert_near(probe(&scene, from, to), double(color).map(|c| 0.5 * c * 10.0 * 0.6 / 6.25), 1e-4);
        // From the lit side there is no share of the transmission, on or off.
        let below = vec3(0.5, -1.0, 0.3);
        assert_near(probe(&scene, below, to), double(color).map(|c| c * 10.0 * 0.6 / 6.25), 1e-4);
    }
    // Opaque surfaces let nothing through.
    let mut scene = under_panes(&[], ShadowMode::Opaque);
    scene.settings.light_from_behind = true;
    assert_eq!(probe(&scene, vec3(0.5, -1.0, 0.5), vec3(0.5, 0.0, 0.25)), Vec3::ZERO);
}
