//! Known answers of flattening.

use super::materials::compose;
use super::{FrameStates, Note, SceneData};
use crate::Preset;
use crate::model::*;
use eosphor_core::geometry::Bounds;
use eosphor_core::light::Light as CoreLight;
use eosphor_core::material::{FresnelUse, NONE, Refraction, SurfaceModel};
use eosphor_core::math::{Affine, Vec3, vec3};
use eosphor_core::settings::LightingModel;

pub(super) fn flatten(scene: &Scene) -> (SceneData, Vec<Note>) {
    SceneData::flatten(scene).unwrap()
}

fn error(scene: &Scene) -> String {
    SceneData::flatten(scene).unwrap_err().to_string()
}

fn triangle(positions: [u32; 3]) -> Triangle {
    Triangle { positions, normals: [NO_INDEX; 3], uvs: [NO_INDEX; 3], material: 0 }
}

/// A mesh of `n` by `n` quads in the plane z = 0, from 0 to 1.
pub(super) fn grid(n: u32) -> Mesh {
    let mut mesh = Mesh { name: "grid".into(), ..Mesh::default() };
    for y in 0..=n {
        for x in 0..=n {
            mesh.positions.push(vec3(x as f32 / n as f32, y as f32 / n as f32, 0.0));
        }
    }
    for y in 0..n {
        for x in 0..n {
            let a = y * (n + 1) + x;
            let (b, c, d) = (a + 1, a + n + 2, a + n + 1);
            mesh.triangles.extend([triangle([a, b, c]), triangle([a, c, d])]);
        }
    }
    mesh
}

/// The cube from -1 to 1, its eight vertices shared, counter-clockwise from outside.
pub(super) fn cube() -> Mesh {
    let sign = |i: u32, bit: u32| if i & bit == 0 { -1.0 } else { 1.0 };
    let positions = (0..8).map(|i| vec3(sign(i, 1), sign(i, 2), sign(i, 4))).collect();
    let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let triangles =
        quads.iter().flat_map(|q| [triangle([q[0], q[1], q[2]]), triangle([q[0], q[2], q[3]])]).collect();
    Mesh { name: "cube".into(), positions, triangles, ..Mesh::default() }
}

/// A sphere of radius 1 whose triangles share no vertices.
pub(super) fn sphere_mesh(n: u32) -> Mesh {
    let mut mesh = Mesh { name: "sphere".into(), ..Mesh::default() };
    let point = |i: u32, j: u32| {
        let (theta, phi) = (
            i as f64 / n as f64 * std::f64::consts::PI,
            (j % (2 * n)) as f64 / n as f64 * std::f64::consts::PI,
        );
        let ring = if i == 0 || i == n { 0.0 } else { theta.sin() };
        vec3((ring * phi.cos()) as f32, theta.cos() as f32, (ring * -phi.sin()) as f32)
    };
    for i in 0..n {
        for j in 0..2 * n {
            let corners = [point(i, j), point(i + 1, j), point(i + 1, j + 1), point(i, j + 1)];
            for half in [[0, 1, 2], [0, 2, 3]] {
                let first = mesh.positions.len() as u32;
                mesh.positions.extend(half.map(|k| corners[k]));
                mesh.triangles.push(triangle([first, first + 1, first + 2]));
            }
        }
    }
    mesh
}

pub(super) fn placed(mesh: Mesh, transforms: &[Transform]) -> Scene {
    let instances = transforms.iter().map(|&t| Instance::new(0, t)).collect();
    let materials = vec![Material::default_material()];
    Scene { meshes: vec![mesh], instances, materials, ..Scene::default() }
}

fn material(kind: MaterialKind) -> Material {
    Material::new("m", kind)
}

#[test]
fn a_mesh_is_baked_unless_placed_twice_and_large() {
    let here = Transform::default();
    let there = Transform::translation(vec3(5.0, 0.0, 0.0));
    // 11 x 11 quads are 242 triangles, 12 x 12 are 288.
    let (small, _) = flatten(&placed(grid(11), &[here, there]));
    assert_eq!((small.instances.len(), small.geometries.len(), small.triangles.len()), (1, 1, 484));
    let (once, _) = flatten(&placed(grid(12), &[there]));
    assert_eq!((once.instances.len(), once.triangles.len()), (1, 288));
    assert_eq!((once.geometries[0].extent, once.instances[0].geometry), (6.0, 0));

    let (twice, _) = flatten(&placed(grid(12), &[here, there]));
    assert_eq!((twice.instances.len(), twice.geometries.len(), twice.triangles.len()), (3, 2, 288));
    assert_eq!((twice.geometries[0].triangle_count, twice.geometries[0].extent), (0, 0.0));
    assert!(twice.instances[0].world_bounds.is_empty());
    assert_eq!(twice.instances[0].world_from_object, Affine::IDENTITY);
    assert_eq!((twice.geometries[1].triangle_count, twice.geometries[1].extent), (288, 1.0));
    let bounds = twice.instances[2].world_bounds;
    let exact = Bounds { min: vec3(5.0, 0.0, 0.0), max: vec3(6.0, 1.0, 0.0) };
    // By 2^-20 of what both maps make of absolute numbers one after the other: 11 + 6 + 6 along x.
    let margins = [exact.min - bounds.min, bounds.max - exact.max];
    assert!(margins.iter().all(|m| m.min_component() >= 0.0), "{bounds:?}");
    assert!(margins.iter().all(|m| (22.0..24.0).contains(&(m.x * 1_048_576.0))), "{bounds:?}");
    assert_eq!(twice.instances[2].object_from_world.translation, vec3(-5.0, 0.0, 0.0));
}

#[test]
fn padded_bounds_hold_mapped_points() {
    let transform = Transform {
        scale: vec3(3.0, -0.01, 1.0),
        rotate_degrees: vec3(10.0, 77.0, 200.0),
        translate: vec3(1e4, 2.0, -3.0),
        ..Transform::default()
    };
    let object = Bounds { min: vec3(-1.0, -2.0, -3.0), max: vec3(0.5, 7.0, 1.0) };
    let map = transform.affine();
    let world = object.placed(&map, &map.inverse().unwrap());
    for i in 0..=10 {
        let x = object.min + (object.max - object.min) * (i as f32 / 10.0);
        let p = transform.affine().point(x);
        assert_eq!(world, world.including(p));
    }
}

#[test]
fn mirrored_transforms_keep_fronts_in_front() {
    let mirror = Transform { scale: vec3(-1.0, 1.0, 1.0), ..Transform::translation(vec3(0.0, 0.0, 4.0)) };
    let mut scene = placed(cube(), &[mirror]);
    for mode in [NormalMode::Flat, NormalMode::Smooth, NormalMode::Generated] {
        scene.settings.normals = mode;
        let (data, _) = flatten(&scene);
        for (t, shading) in data.triangles.iter().zip(&data.triangle_shading) {
            let outward = (t[0] + t[1] + t[2]) * (1.0 / 3.0) - vec3(0.0, 0.0, 4.0);
            let front = (t[1] - t[0]).cross(t[2] - t[0]);
            assert!(front.dot(outward) > 0.0);
            assert!(shading.normals.iter().all(|n| (*n - front.normalize()).length() < 1e-6), "{mode:?}");
        }
    }
}

#[test]
fn normals_go_by_the_inverse_transpose() {
    let mut mesh = Mesh {
        positions: vec![vec3(0.0, 0.0, 0.0), vec3(1.0, -1.0, 0.0), vec3(0.0, 0.0, -1.0)],
        normals: vec![vec3(3.0, 3.0, 0.0)],
        ..Mesh::default()
    };
    mesh.triangles.push(Triangle { normals: [0; 3], ..triangle([0, 1, 2]) });
    let squash = Transform { scale: vec3(1.0, 0.5, 1.0), ..Transform::default() };
    let (data, _) = flatten(&placed(mesh, &[squash]));
    let expected = vec3(1.0, 2.0, 0.0).normalize();
    assert!(data.triangle_shading[0].normals.iter().all(|n| (*n - expected).length() < 1e-6));
}

#[test]
fn singular_transforms_are_an_error() {
    let flat = Transform { scale: vec3(1.0, 0.0, 1.0), ..Transform::default() };
    assert_eq!(
        error(&placed(cube(), &[Transform::default(), flat])),
        "instances[1] (mesh \"cube\"): its transform cannot be inverted: it squashes the mesh flat; no scale may be 0"
    );
    let far = Transform { scale: Vec3::splat(1e10), translate: vec3(1e12, 0.0, 0.0), ..Transform::default() };
    assert!(error(&placed(cube(), &[far])).starts_with("mesh \"cube\": its transform takes a vertex to"));
}

#[test]
fn creases_keep_a_cube_flat_and_smooth_a_sphere() {
    let mut scene = placed(cube(), &[Transform::default()]);
    scene.settings.normals = NormalMode::Generated;
    let (data, _) = flatten(&scene);
    for (t, shading) in data.triangles.iter().zip(&data.triangle_shading) {
        let front = (t[1] - t[0]).cross(t[2] - t[0]).normalize();
        assert_eq!(shading.normals, [front; 3]);
    }
    // Without a crease the corners of a cube look outward; which diagonals meet there tilts them a little.
    scene.settings.crease_degrees = 180.0;
    let (data, _) = flatten(&scene);
    for (t, shading) in data.triangles.iter().zip(&data.triangle_shading) {
        for (p, n) in t.iter().zip(shading.normals) {
            assert!(p.normalize().dot(n) > 0.9);
        }
    }

    let scene = placed(sphere_mesh(32), &[Transform::default()]);
    let (data, _) = flatten(&scene);
    for (t, shading) in data.triangles.iter().zip(&data.triangle_shading) {
        let degenerate = t[0] == t[1] || t[1] == t[2] || t[2] == t[0];
        for (p, n) in t.iter().zip(shading.normals) {
            assert!(degenerate || p.dot(n) > 0.998, "{p:?} {n:?}");
        }
    }
}

#[test]
fn generated_normals_weigh_by_area_and_do_not_depend_on_shared_vertices() {
    // Two planes that meet at 30 degrees along the y axis, one twice as wide.
    let (cos, sin) = (30f64.to_radians().cos() as f32, 30f64.to_radians().sin() as f32);
    let positions = vec![
        vec3(0.0, 0.0, 0.0),
        vec3(2.0, 0.0, 0.0),
        vec3(0.0, 1.0, 0.0),
        vec3(-cos, 0.0, sin),
        // Equal to the first and third, but for the sign of zero.
        vec3(-0.0, 0.0, 0.0),
        vec3(0.0, 1.0, -0.0),
    ];
    let triangles = vec![triangle([0, 1, 2]), triangle([4, 5, 3])];
    let mesh = Mesh { name: "roof".into(), positions, triangles, ..Mesh::default() };
    let (data, _) = flatten(&placed(mesh, &[Transform::default()]));
    let (flat, slope) = (vec3(0.0, 0.0, 1.0), vec3(sin, 0.0, cos));
    let ridge = (flat * 2.0 + slope).normalize();
    let mut seen = 0;
    for (t, shading) in data.triangles.iter().zip(&data.triangle_shading) {
        for (p, n) in t.iter().zip(shading.normals) {
            if p.x.abs() < 1e-6 {
                assert!((n - ridge).length() < 1e-6, "{n:?} {ridge:?}");
                seen += 1;
            }
        }
    }
    assert_eq!(seen, 4);
}

#[test]
fn degenerate_triangles_stay_with_a_harmless_normal() {
    let mesh = Mesh {
        positions: vec![Vec3::ZERO, vec3(1.0, 1.0, 1.0), vec3(2.0, 2.0, 2.0)],
        triangles: vec![triangle([0, 1, 2]), triangle([0, 0, 0])],
        ..Mesh::default()
    };
    let mut scene = placed(mesh, &[Transform::default()]);
    for mode in [NormalMode::Flat, NormalMode::Smooth, NormalMode::Auto, NormalMode::Generated] {
        scene.settings.normals = mode;
        let (data, _) = flatten(&scene);
        assert_eq!(data.triangles.len(), 2);
        assert!(data.triangle_shading.iter().all(|s| s.normals == [vec3(0.0, 0.0, 1.0); 3]));
    }
}

#[test]
fn parallelograms_are_two_triangles_on_one_diagonal() {
    let p = Parallelogram {
        corner: vec3(1.0, 0.0, 0.0),
        edge_u: vec3(2.0, 0.0, 0.0),
        edge_v: vec3(0.0, 3.0, 0.0),
        material: 0,
    };
    let scene =
        Scene { parallelograms: vec![p], materials: vec![Material::default_material()], ..Scene::default() };
    let (data, _) = flatten(&scene);
    assert_eq!(data.triangles.len(), 2);
    for (t, shading) in data.triangles.iter().zip(&data.triangle_shading) {
        assert!((t[1] - t[0]).cross(t[2] - t[0]).z > 0.0);
        assert_eq!(shading.normals, [vec3(0.0, 0.0, 1.0); 3]);
        for (v, uv) in t.iter().zip(shading.uvs) {
            assert_eq!(uv, [(v.x - 1.0) / 2.0, v.y / 3.0]);
        }
        assert!(t.contains(&vec3(1.0, 0.0, 0.0)) && t.contains(&vec3(3.0, 3.0, 0.0)));
    }
}

#[test]
fn composition_table() {
    let (ks, tf) = (vec3(0.5, 0.4, 0.3), vec3(0.1, 0.2, 0.3));
    let base = Mtl { Kd: Vec3::splat(0.6), Ks: ks, Ns: 30.0, ..Mtl::default() };
    let (zero, one) = (Vec3::ZERO, Vec3::ONE);
    use Composition::{Eos, Native, Pg1};
    use FresnelUse::{Both, Ignore, Reflection};
    use Refraction::{Snell, Straight};
    for (composition, mtl, kr, kt, fresnel, refraction, filter) in [
        (Native, Mtl { illum: 2, ..base }, zero, zero, Ignore, Straight, zero),
        (Native, Mtl { illum: 2, Tf: Some(one), ..base }, zero, zero, Ignore, Straight, zero),
        (
            Native,
            Mtl { illum: 2, d: 0.25, ..base },
            zero,
            Vec3::splat(0.75),
            Ignore,
            Straight,
            Vec3::splat(0.6) * 0.75,
        ),
        (Native, Mtl { illum: 3, ..base }, ks, zero, Ignore, Straight, zero),
        (Native, Mtl { illum: 5, ..base }, ks, zero, Ignore, Straight, zero),
        (Native, Mtl { illum: 5, Ni: Some(1.0), ..base }, ks, zero, Ignore, Straight, zero),
        (Native, Mtl { illum: 5, Ni: Some(1.5), ..base }, ks, zero, Reflection, Straight, zero),
        (Native, Mtl { illum: 4, ..base }, one, one, Both, Snell, one),
        (Native, Mtl { illum: 6, Tf: Some(tf), ..base }, one, tf, Both, Snell, tf),
        (Native, Mtl { illum: 7, d: 0.1, ..base }, one, one, Both, Snell, one),
        (Native, Mtl { illum: 9, Tf: Some(tf), ..base }, one, tf, Both, Snell, tf),
        (Pg1, Mtl { illum: 2, ..base }, ks, zero, Ignore, Straight, zero),
        (Pg1, Mtl { illum: 2, Tf: Some(one), ..base }, ks, zero, Ignore, Straight, zero),
        (Pg1, Mtl { illum: 7, ..base }, ks, zero, Ignore, Snell, zero),
        (Pg1, Mtl { illum: 7, Tf: Some(tf), ..base }, ks, tf, Ignore, Snell, tf),
        (Eos, Mtl { illum: 2, ..base }, zero, zero, Ignore, Straight, zero),
        (Eos, Mtl { illum: 3, ..base }, Vec3::splat(0.4), zero, Ignore, Straight, zero),
    ] {
        let m = compose(&material(MaterialKind::Mtl(mtl)), composition);
        let found = (m.reflection, m.transmission, m.fresnel, m.refraction, m.shadow_filter);
        assert_eq!(found, (kr, kt, fresnel, refraction, filter), "{composition:?} {mtl:?}");
        let visible = if mtl.d < 1.0 && mtl.illum == 2 { mtl.d } else { 1.0 };
        assert_eq!((m.diffuse, m.specular, m.shininess), (base.Kd * visible, ks * visible, 30.0));
        assert_eq!(m.diffuse_texture, NONE);
    }
    let plain = compose(&material(MaterialKind::Mtl(Mtl { illum: 1, ..base })), Native);
    assert_eq!(plain.specular, zero);
    let glass = Mtl { illum: 7, Ni: Some(2.5), ..base };
    assert_eq!(compose(&material(MaterialKind::Mtl(glass)), Native).ior, 2.5);
    assert_eq!(compose(&material(MaterialKind::Mtl(Mtl { illum: 7, ..base })), Native).ior, 1.5);
}

/// A material that is called a mirror and says how strong stays one, however rough.
#[test]
fn mirrors_with_roughness_stay_mirrors() {
    let of = |mtl| compose(&material(MaterialKind::Mtl(mtl)), Composition::Native);
    let (diffuse, reflection) = (vec3(0.1, 0.2, 0.3), vec3(0.6, 0.7, 0.8));
    for illum in [3, 5, 8] {
        let sharp = Mtl { Kd: diffuse, Ks: reflection, illum, ..Mtl::default() };
        let rough = of(Mtl { Pr: Some(0.5), ..sharp });
        assert_eq!((rough.model, rough.diffuse, rough.reflection), (of(sharp).model, diffuse, reflection));
        // alpha = 0.25: (2 / 0.0625 - 2) / 4.
        assert_eq!((rough.glossy_rays, rough.glossy_exponent), (1, 7.5));
        assert_eq!(of(Mtl { Pr: Some(0.0), ..sharp }), of(sharp));
        for roughness in [f32::MIN_POSITIVE, 1e-4, 1.0] {
            assert!((0.0..=1e6).contains(&of(Mtl { Pr: Some(roughness), ..sharp }).glossy_exponent));
        }
        // What says that it is metal, or is no mirror, is a metallic-roughness material.
        let metallic = SurfaceModel::MetallicRoughness;
        assert_eq!(of(Mtl { Pr: Some(0.5), Pm: Some(1.0), ..sharp }).model, metallic);
        assert_eq!(of(Mtl { Pr: Some(0.5), Ks: Vec3::ZERO, ..sharp }).model, metallic);
        assert_eq!(of(Mtl { Pr: Some(0.5), illum: 2, ..sharp }).model, metallic);
    }
}

#[test]
fn kinds_of_the_model() {
    let of = |kind| compose(&material(kind), Composition::Native);
    let c = vec3(0.2, 0.4, 0.6);
    assert_eq!(of(MaterialKind::Matte { color: c }).diffuse, c);
    let mirror = of(MaterialKind::Mirror { reflectance: c });
    assert_eq!((mirror.reflection, mirror.diffuse, mirror.fresnel), (c, Vec3::ZERO, FresnelUse::Ignore));
    let glass = of(MaterialKind::Dielectric { ior: 1.3, tint: c });
    assert_eq!(
        (glass.reflection, glass.transmission, glass.shadow_filter, glass.ior),
        (Vec3::ONE, c, c, 1.3)
    );
    assert_eq!((glass.fresnel, glass.refraction), (FresnelUse::Both, Refraction::Snell));
    let glossy = of(MaterialKind::Glossy { reflectance: c, exponent: 9.0, rays: 4, color: Vec3::ONE });
    assert_eq!((glossy.glossy_rays, glossy.glossy_exponent, glossy.reflection), (4, 9.0, c));
    let pane = of(MaterialKind::Transparent {
        color: c,
        transparency: 0.5,
        reflection: 0.25,
        shininess: 64.0,
        diffuse: 0.5,
    });
    assert_eq!((pane.transmission, pane.shadow_filter), (Vec3::splat(0.5), c * 0.5));
    assert_eq!(
        (pane.reflection, pane.specular, pane.diffuse),
        (Vec3::splat(0.25), Vec3::splat(0.25), c * 0.5)
    );
    assert_eq!(of(MaterialKind::Emissive { radiance: c }).emission, c);
}

#[test]
fn lights_of_the_scene_come_before_emissive_triangles() {
    let lamp = material(MaterialKind::Emissive { radiance: vec3(5.0, 6.0, 7.0) });
    // Two placements of 288 triangles are instances; one is mirrored.
    let mirrored = Transform { scale: vec3(1.0, 1.0, -2.0), ..Transform::translation(vec3(0.0, 0.0, 3.0)) };
    let mut scene = placed(grid(12), &[Transform::default(), mirrored]);
    scene.materials.push(lamp);
    scene.meshes[0].triangles[5].material = 1;
    scene.lights.push(Light::Spot {
        position: Vec3::ONE,
        direction: vec3(0.0, -4.0, 0.0),
        inner_degrees: 60.0,
        outer_degrees: 90.0,
        color: Vec3::ONE,
    });
    scene.lights.push(Light::Directional { direction: vec3(0.0, 0.0, -3.0), color: Vec3::ONE });
    // Degenerate emitters and spheres light nothing.
    scene.parallelograms.push(Parallelogram {
        corner: Vec3::ONE,
        edge_u: Vec3::ONE,
        edge_v: Vec3::ONE,
        material: 1,
    });
    scene.spheres.push(Sphere { center: Vec3::ONE, radius: 1.0, material: 1 });
    let (data, notes) = flatten(&scene);
    assert_eq!(data.lights.len(), 4);
    let CoreLight::Spot { axis, cos_inner, cos_outer, .. } = data.lights[0] else { panic!() };
    assert_eq!(axis, vec3(0.0, -1.0, 0.0));
    assert!((cos_inner - 0.5).abs() < 1e-7 && cos_outer.abs() < 1e-7);
    assert!(
        matches!(data.lights[1], CoreLight::Directional { to_light, .. } if to_light == vec3(0.0, 0.0, 1.0))
    );
    for (light, number, side, z) in [(2, 1, 1.0, 0.0), (3, 2, -1.0, 3.0)] {
        let CoreLight::Triangle { v0, e1, e2, normal, area, color, samples, instance, primitive, .. } =
            data.lights[light]
        else {
            panic!()
        };
        assert_eq!((normal, v0.z, instance, primitive), (vec3(0.0, 0.0, side), z, number, 5));
        assert_eq!((color, samples), (over_pi(vec3(5.0, 6.0, 7.0)), 16));
        assert!((area - 0.5 / 144.0).abs() < 1e-7 && e1.cross(e2).dot(normal) > 0.0);
    }
    assert!(notes.contains(&Note::EmissiveSpheres { count: 1 }));
}

fn over_pi(color: Vec3) -> Vec3 {
    <[f32; 3]>::from(color).map(|x| (f64::from(x) / std::f64::consts::PI) as f32).into()
}

#[test]
fn physical_light_is_divided_by_pi_once_and_plain_light_and_headlights_are_not() {
    let color = vec3(3.0, 2.0, 1.0);
    let (position, direction) = (Vec3::ZERO, vec3(0.0, -1.0, 0.0));
    let of = |scene: &Scene| -> Vec<Vec3> { flatten(scene).0.lights.iter().map(CoreLight::le).collect() };
    let mut scene = placed(cube(), &[Transform::default()]);
    assert_eq!(scene.settings.light_units, LightUnits::Physical);
    let headlight = of(&scene);
    scene.materials[0] = material(MaterialKind::Emissive { radiance: color });
    scene.lights = vec![
        Light::Point { position, color },
        Light::Directional { direction, color },
        Light::Spot { position, direction, inner_degrees: 10.0, outer_degrees: 20.0, color },
    ];
    assert_eq!(of(&scene), [over_pi(color); 3 + 12]);
    // What lamps look like does not depend on it.
    assert_eq!(flatten(&scene).0.materials[0].emission, color);
    // Animations have it from the same place.
    let (data, _) = flatten(&scene);
    assert_eq!(FrameStates::new(&scene, &data).at(0).unwrap().lights, data.lights);
    scene.settings.light_units = LightUnits::Plain;
    assert_eq!(of(&scene), [color; 3 + 12]);
    for preset in Preset::ALL {
        preset.apply(&mut scene);
        assert_eq!(of(&scene), [color; 3 + 12], "{preset}");
    }
    let mut dark = placed(cube(), &[Transform::default()]);
    dark.settings.light_units = LightUnits::Plain;
    assert_eq!(of(&dark), headlight);
}

#[test]
fn a_scene_without_camera_is_framed() {
    for size in [[800, 600], [300, 900], [1000, 100]] {
        let mut scene = placed(
            cube(),
            &[Transform { scale: vec3(3.0, 1.0, 0.1), ..Transform::translation(vec3(100.0, 0.0, 0.0)) }],
        );
        scene.settings.size = size;
        let (data, notes) = flatten(&scene);
        assert!(matches!(notes[0], Note::FramedCamera { .. }) && matches!(notes[1], Note::Headlight { .. }));
        let c = data.camera;
        let mut fill = 0.0f32;
        for &p in data.triangles.iter().flatten() {
            let d = p - c.eye;
            let depth = d.dot(c.forward);
            let (x, y) = (d.dot(c.right) / depth / c.half_width, d.dot(c.up) / depth / c.half_height);
            assert!(depth > 0.0 && x.abs() <= 1.0 && y.abs() <= 1.0);
            fill = fill.max(x.abs()).max(y.abs());
        }
        assert!(fill > 0.85, "{fill}");
    }
}

#[test]
fn the_headlight_has_no_falloff() {
    let mut scene = placed(cube(), &[Transform::default()]);
    let (data, _) = flatten(&scene);
    let CoreLight::Point { position, color } = data.lights[0] else { panic!() };
    assert_eq!((position, color, data.settings.light_falloff), (data.camera.eye, Vec3::splat(0.8), false));
    scene.settings.lighting = LightingModel::Diffuse;
    // Only the headlight of scenes without lights is left.
    assert!(!flatten(&scene).0.lights.iter().any(|light| matches!(light, CoreLight::Triangle { .. })));
}

#[test]
fn empty_scenes_flatten() {
    let (data, notes) = flatten(&Scene::default());
    assert_eq!(notes, [Note::Empty]);
    assert_eq!((data.triangles.len(), data.instances.len(), data.settings.max_distance), (0, 1, 1.0));
}

#[test]
fn cameras_and_lenses() {
    let camera = Camera {
        position: vec3(0.0, 0.0, 4.0),
        look_at: Some(vec3(0.0, 3.0, 0.0)),
        lens: Some(Lens { aperture_radius: 0.1, focus_distance: None }),
        ..Camera::default()
    };
    let mut scene = placed(cube(), &[Transform::default()]);
    scene.camera = Some(camera);
    let (data, _) = flatten(&scene);
    assert_eq!((data.camera.aperture_radius, data.camera.focus_distance), (0.1, 5.0));
    // From (0, 0, 4) the far corners are at (1, 1, -1): sqrt(27) away.
    assert!((data.settings.max_distance - 27f32.sqrt() / 1.5).abs() < 1e-6);
    scene.camera = Some(Camera { look_at: Some(camera.position), ..camera });
    assert!(error(&scene).starts_with("camera: it looks nowhere"));
    scene.camera = Some(Camera { look_at: None, direction: vec3(0.0, -1.0, 0.0), lens: None, ..camera });
    assert!(error(&scene).starts_with("camera: it spans no view: up must"));
}

#[test]
fn textures_lie_one_after_another() {
    use eosphor_core::texture::TexelFormat;
    let image = |texels: Texels| Image { name: "t".into(), width: texels.len() as u32, height: 1, texels };
    let images = vec![
        image(Texels::rgba8(vec![0, 1])),
        image(Texels::rgba_floats(&[[1.0, 2.0, 3.0, 4.0]])),
        image(Texels::rgba8(vec![0, 1, 2])),
    ];
    let texture = |image, content| Texture { content, ..Texture::of_image(image) };
    let textures = vec![
        texture(2, TextureContent::Color),
        texture(0, TextureContent::Data),
        texture(1, TextureContent::Color),
        texture(2, TextureContent::Data),
    ];
    let scene = Scene { images, textures, ..Scene::default() };
    let (data, _) = flatten(&scene);
    assert_eq!(data.texture_words[..2], [0, 1]);
    assert_eq!(data.texture_words[2..6], [1.0f32, 2.0, 3.0, 4.0].map(f32::to_bits));
    assert_eq!(data.texture_words[6..], [0, 1, 2]);
    let headers: Vec<_> = data.textures.iter().map(|t| (t.first_word, t.width, t.format)).collect();
    let (srgb, linear) = (TexelFormat::Srgb8, TexelFormat::Linear8);
    assert_eq!(headers, [(6, 3, srgb), (0, 2, linear), (2, 1, TexelFormat::Float), (6, 3, linear)]);
    assert_eq!(data.textures.iter().map(|t| t.channels).collect::<Vec<_>>(), [4; 4]);
    assert_eq!((data.srgb_decode[0], data.srgb_decode[255]), (0.0, 1.0));
    assert!((data.srgb_decode[128] - 0.215_860_5).abs() < 1e-6);
}

/// Pictures of a loaded scene are there once, however often it is flattened; others are copied.
#[test]
fn texels_are_not_copied() {
    use crate::{LoadOptions, TexelLayout, load_from_memory};
    let scene = r#"{ "eosphor": 2, "materials": {
        "a": { "matte": { "color": [1, 1, 1] }, "texture": "a.pgm" },
        "b": { "matte": { "color": [1, 1, 1] }, "texture": "b.ppm" } },
        "spheres": [{ "center": [0, 0, 0], "radius": 1, "material": "a" },
                    { "center": [0, 0, 3], "radius": 1, "material": "b" }] }"#;
    let files = [
        ("s.json", scene.as_bytes()),
        ("a.pgm", b"P5 3 1 255\n\x01\x02\x03"),
        ("b.ppm", b"P6 2 1 255\n\x04\x05\x06\x07\x08\x09"),
    ];
    let files = files.map(|(name, bytes)| (name.into(), bytes.to_vec())).to_vec();
    let mut scene = load_from_memory(files, "s.json", &LoadOptions::default()).unwrap().scene;
    let [first, second] = [flatten(&scene).0, flatten(&scene.clone()).0];
    assert!(std::sync::Arc::ptr_eq(&first.texture_words, &second.texture_words));
    assert!(std::sync::Arc::ptr_eq(&first.texture_words, scene.images[0].texels.shared()));
    assert_eq!(*first.texture_words, [0x0706_0504, 0x0908, 0x0003_0201]);
    let headers: Vec<_> = first.textures.iter().map(|t| (t.first_word, t.channels)).collect();
    assert_eq!(headers, [(2, 1), (0, 3)]);

    let texels = Texels::new(TexelLayout::Bytes(2), 1, vec![0x0b0a]);
    scene.images.push(Image { name: "c".into(), width: 1, height: 1, texels });
    scene.textures.push(Texture::of_image(2));
    let (data, _) = flatten(&scene);
    assert_eq!(*data.texture_words, [0x0003_0201, 0x0706_0504, 0x0908, 0x0b0a]);
    let headers: Vec<_> = data.textures.iter().map(|t| (t.first_word, t.channels)).collect();
    assert_eq!(headers, [(0, 1), (1, 3), (3, 2)]);
}

#[test]
fn settings_reach_the_pixel() {
    let mut scene = Scene::default();
    scene.settings.pixel_sampling = PixelSampling::Grid(4);
    let (data, _) = flatten(&scene);
    assert_eq!((data.settings.samples, data.settings.grid_side), (16, 4));
    for (change, expected) in [
        (
            RenderSettings { size: [800, 65_536], ..scene.settings },
            "settings.size (height): 65536 is out of range",
        ),
        (
            RenderSettings { samples: 0, ..scene.settings },
            "settings.samples: 0 is out of range; it must be 1 to 65536",
        ),
        (
            RenderSettings { depth: 65, ..scene.settings },
            "settings.depth: 65 is out of range; it must be 0 to 64",
        ),
        (
            RenderSettings { pixel_sampling: PixelSampling::Grid(257), ..scene.settings },
            "settings.pixel-sampling (grid): 257 is out of range; it must be 1 to 256",
        ),
        (RenderSettings { ambient: f32::NAN, ..scene.settings }, "settings.ambient: NaN is out of range"),
        (
            RenderSettings { max_distance: Some(0.0), ..scene.settings },
            "settings.max-distance: 0 must be over 0",
        ),
    ] {
        let message = error(&Scene { settings: change, ..Scene::default() });
        assert!(message.starts_with(expected), "{message}");
    }
}

#[test]
fn instances_out_of_range_are_an_error() {
    let here = Transform::default();
    let scaled = |s: f32| Transform { scale: Vec3::splat(s), ..here };
    let matrix = |x: f32| Transform {
        matrix: Some([[1.0, 0.0, 0.0, x], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]]),
        ..here
    };
    let out_of_range = [
        Transform::translation(vec3(0.0, -2e12, 0.0)),
        Transform { scale: Vec3::splat(1e9), translate: vec3(1e12, 0.0, 0.0), ..here },
        scaled(1e12 * 1.5),
        matrix(1e13),
        Transform { translate: vec3(1e12, 0.0, 0.0), ..matrix(1e12) },
    ];
    for transform in out_of_range {
        let said = error(&placed(grid(12), &[here, transform]));
        let expected = "instances[1] (mesh \"grid\"): its transform takes the mesh out of range";
        assert!(said.starts_with(expected), "{said}");
    }
    // Neither can be undone.
    for transform in [scaled(1e30), scaled(f32::INFINITY), scaled(f32::NAN), matrix(f32::INFINITY)] {
        let said = error(&placed(grid(12), &[here, transform]));
        println!("{said}");
        assert!(said.starts_with("instances[1]"), "{said}");
    }
    let (data, _) = flatten(&placed(grid(12), &[here, Transform::translation(vec3(9e11, 0.0, 0.0))]));
    assert_eq!(data.instances.len(), 3);
}

#[test]
fn large_meshes_are_placed_many_times() {
    // 158 x 158 quads are 49,928 triangles, of which two shine.
    let mut mesh = grid(158);
    mesh.triangles[17].material = 1;
    mesh.triangles[40_000].material = 1;
    let transforms: Vec<_> = (0..200).map(|k| Transform::translation(vec3(0.0, 0.0, k as f32))).collect();
    let mut scene = placed(mesh, &transforms);
    scene.materials.push(material(MaterialKind::Emissive { radiance: Vec3::ONE }));
    let (data, _) = flatten(&scene);
    assert_eq!((data.geometries.len(), data.instances.len(), data.triangles.len()), (2, 201, 49_928));
    let lights: Vec<_> = data
        .lights
        .iter()
        .map(|light| match light {
            CoreLight::Triangle { instance, primitive, .. } => (*instance, *primitive),
            other => panic!("{other:?}"),
        })
        .collect();
    assert_eq!(lights, (1..=200).flat_map(|i| [(i, 17), (i, 40_000)]).collect::<Vec<_>>());
    scene.materials[1] = material(MaterialKind::Matte { color: Vec3::ONE });
    // Only the headlight of scenes without lights is left.
    assert!(!flatten(&scene).0.lights.iter().any(|light| matches!(light, CoreLight::Triangle { .. })));
}

#[test]
fn creases_of_thousands_of_triangles_around_a_vertex_are_flat() {
    // A pleated fan: each triangle is steep the other way than the next. Pleats grow, so that smooth normals lean.
    let flat_corners = |count: u32| {
        let mut mesh = Mesh { name: "fan".into(), positions: vec![Vec3::ZERO], ..Mesh::default() };
        for k in 0..count {
            let turn = k as f64 / count as f64 * std::f64::consts::TAU;
            let height = (if k % 2 == 0 { 0.1 } else { -0.1 }) * (1.0 + k as f32 / count as f32);
            mesh.positions.push(vec3(turn.cos() as f32, turn.sin() as f32, height));
            mesh.triangles.push(triangle([0, k + 1, (k + 1) % count + 1]));
        }
        let mut scene = placed(mesh, &[Transform::default()]);
        scene.settings.normals = NormalMode::Generated;
        let (data, _) = flatten(&scene);
        let is_flat = |(t, shading): (&[Vec3; 3], &eosphor_core::geometry::TriangleShading)| {
            let own = super::normals::of_triangle(t).unwrap();
            shading.normals.iter().all(|n| (*n - own).length() < 1e-6)
        };
        data.triangles.iter().zip(&data.triangle_shading).filter(|&pair| is_flat(pair)).count()
    };
    assert_eq!(flat_corners(4098), 4098);
    assert_eq!(flat_corners(20_000), 20_000);
}
