//! Normals that are not those of the surface: nothing is black, nothing leaks, no energy is made.

use super::support::*;
use eosphor_core::math::{Vec3, vec3};
use eosphor_scene::{Instance, Light, MaterialKind, Mesh, NO_INDEX, NormalMode, Scene, Transform, Triangle};

/// A level square of half width 2 that faces up, with the normal `n` all over.
fn add_square(scene: &mut Scene, n: V, material: u32) {
    let positions = [[-2.0, -2.0], [-2.0, 2.0], [2.0, 2.1], [2.0, -2.0]].map(|[x, z]| vec3(x, 0.0, z));
    let triangle = |positions| Triangle { positions, normals: [0; 3], uvs: [NO_INDEX; 3], material };
    scene.meshes.push(Mesh {
        name: "square".into(),
        positions: positions.to_vec(),
        normals: vec![single(n)],
        triangles: vec![triangle([0, 1, 2]), triangle([0, 2, 3])],
        ..Mesh::default()
    });
    scene.instances.push(Instance::new(scene.meshes.len() as u32 - 1, Transform::default()));
    scene.settings.normals = NormalMode::Smooth;
}

/// The normal that lies `degrees` off the vertical.
fn tilted(degrees: f64) -> V {
    let angle = degrees.to_radians();
    [angle.sin() * 0.6, angle.cos(), angle.sin() * 0.8]
}

#[test]
fn a_matte_surface_is_lit_by_what_both_normals_see() {
    // Under a sky of equal lights the integral of max(0, N.L) over the surface's own half space is (1 + cos a) pi / 2 for
    // a normal at the angle a, which is taken from the front: 180 degrees are 0.
    let lights: i32 = 20_000;
    let sky = |scene: &mut Scene| {
        for i in 0..lights {
            // Equal areas of the upper half of the sphere, in a spiral by the golden angle.
            let up = (f64::from(i) + 0.5) / f64::from(lights);
            let (around, out) = (f64::from(i) * 2.399_963_229_728_653, (1.0 - up * up).sqrt());
            let to_light = [out * around.cos(), up, out * around.sin()];
            let color = Vec3::splat(1.0 / 4096.0);
            scene.lights.push(Light::Directional { direction: single(to_light.map(|x| -x)), color });
        }
    };
    let lit = |degrees: f64| {
        let mut scene = scene();
        let white = matte(&mut scene, Vec3::ONE);
        add_square(&mut scene, tilted(degrees), white);
        sky(&mut scene);
        f64::from(probe(&scene, vec3(0.3, 1.0, 0.2), vec3(0.1, 0.0, 0.3)).x)
    };
    let level = lit(0.0);
    for degrees in [30.0f64, 60.0, 85.0, 95.0, 120.0, 150.0, 180.0] {
        let expected = level * (1.0 + degrees.to_radians().cos().abs()) / 2.0;
        let got = lit(degrees);
        assert!((got - expected).abs() < 2e-3 * level, "{degrees}: {got} instead of {expected}");
        assert!(got < level * 1.001);
    }
}

#[test]
fn a_normal_that_points_behind_the_surface_looks_like_the_surface() {
    let kinds = [
        MaterialKind::Matte { color: vec3(0.7, 0.5, 0.3) },
        MaterialKind::Mirror { reflectance: vec3(0.9, 0.6, 0.3) },
        MaterialKind::Dielectric { ior: 1.5, tint: Vec3::ONE },
    ];
    for kind in kinds {
        let picture = |degrees: f64, eye: V| {
            let mut scene = scene();
            let m = material(&mut scene, kind);
            add_square(&mut scene, tilted(degrees), m);
            let (red, blue) =
                (emissive(&mut scene, vec3(1.0, 0.2, 0.1)), emissive(&mut scene, vec3(0.1, 0.2, 1.0)));
            sphere(&mut scene, vec3(0.0, 105.0, 0.0), 100.0, red);
            sphere(&mut scene, vec3(0.0, -105.0, 0.0), 100.0, blue);
            let light = Light::Point { position: vec3(1.0, 2.0, 0.0), color: Vec3::ONE };
            scene.lights.push(light);
            scene.settings.depth = 2;
            probe(&scene, single(eye), vec3(0.1, 0.0, 0.3))
        };
        for eye in [[0.3, 1.0, 0.2], [1.5, 0.4, 0.0], [0.0, -1.0, 0.5]] {
            let (right, opposed) = (picture(0.0, eye), picture(180.0, eye));
            assert_near(opposed, double(right), 1e-5);
        }
    }
}

/// An octahedron of radius 1 whose normals are those of the sphere through its corners: they differ from its faces' own
/// by up to 55 degrees.
fn add_octahedron(scene: &mut Scene, material: u32) {
    let mut mesh = Mesh { name: "octahedron".into(), ..Mesh::default() };
    for axis in 0..3 {
        for sign in [1.0, -1.0] {
            mesh.positions.push(single([0, 1, 2].map(|k| if k == axis { sign } else { 0.0 })));
        }
    }
    mesh.normals = mesh.positions.clone();
    for signs in 0..8u32 {
        let mut t = [0, 1, 2].map(|axis| 2 * axis + (signs >> axis & 1));
        if signs.count_ones() % 2 == 1 {
            t.swap(1, 2);
        }
        mesh.triangles.push(Triangle { positions: t, normals: t, uvs: [NO_INDEX; 3], material });
    }
    scene.meshes.push(mesh);
    scene.instances.push(Instance::new(0, Transform::default()));
    scene.settings.normals = NormalMode::Smooth;
    scene.camera = Some(looking(vec3(0.8, 1.7, 2.5), vec3(0.02, 0.01, 0.0), 50.0));
    scene.settings.size = [96, 96];
}

#[test]
fn a_coarse_mirror_in_a_white_world_is_white() {
    // A ray that went below the surface would be reflected inside for ever, and lost.
    let mut scene = scene();
    let mirror = material(&mut scene, MaterialKind::Mirror { reflectance: Vec3::ONE });
    add_octahedron(&mut scene, mirror);
    scene.settings.background = Vec3::ONE;
    // One bounce: the body is convex.
    scene.settings.depth = 1;
    assert!(render(&scene).pixels.iter().all(|p| *p == Vec3::ONE));
}

#[test]
fn coarse_glass_in_a_white_world_makes_no_light_and_loses_little() {
    let mut scene = scene();
    let glass = material(&mut scene, MaterialKind::Dielectric { ior: 1.5, tint: Vec3::ONE });
    add_octahedron(&mut scene, glass);
    scene.settings.background = Vec3::ONE;
    let missing = |scene: &mut Scene, depth: u32| {
        scene.settings.depth = depth;
        let film = render(scene);
        assert!(film.pixels.iter().all(|p| p.x <= 1.0 + 1e-6));
        let sum: f64 = film.pixels.iter().map(|p| f64::from(p.x)).sum();
        1.0 - sum / film.pixels.len() as f64
    };
    // What is reflected inside more often is missing, and, of rays that run in a circle of total reflections, everything.
    let of_depths = [6, 12, 24].map(|depth| missing(&mut scene, depth));
    println!("a glass octahedron in a white world is darker by {of_depths:?}");
    assert!(of_depths.is_sorted_by(|a, b| a > b) && of_depths[2] < 0.02, "{of_depths:?}");
    let film = render(&scene);
    // Nothing inside is ever met as if from outside.
    scene.settings.cull_back_faces = true;
    assert_eq!(render(&scene).pixels, film.pixels);
}
