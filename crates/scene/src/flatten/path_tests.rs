//! Known answers of flattening for path tracing.

use super::Note;
use super::tests::{cube, flatten, placed};
use crate::model::{AlphaMode, MaterialKind, Transform};
use eosphor_core::math::Vec3;
use eosphor_core::settings::{Integrator, ShadowMode};

/// Path tracing has surroundings in place of a headlight, and lamps that light samples can know.
#[test]
fn lights_of_path_tracing() {
    let mut scene = placed(cube(), &[Transform::default()]);
    scene.settings.integrator = Integrator::Path;
    let (data, notes) = flatten(&scene);
    assert!(notes.contains(&Note::Surroundings { radiance: 0.5 }), "{notes:?}");
    assert_eq!((data.lights.len(), data.settings.background), (0, Vec3::splat(0.5)));
    assert_eq!(data.settings.shadow_mode, ShadowMode::Opaque);
    scene.settings.ambient = 0.1;
    let (data, notes) = flatten(&scene);
    assert_eq!((data.settings.background, notes.len()), (Vec3::ZERO, 1));
    scene.materials[0].kind = MaterialKind::Emissive { radiance: Vec3::ONE };
    let (data, _) = flatten(&scene);
    assert_eq!(data.lights.len(), 12);
    assert!(data.lights.iter().all(|light| light.samples() == 1));
    // What has holes is found by rays alone.
    scene.materials[0].alpha = AlphaMode::Blend;
    let (data, _) = flatten(&scene);
    assert_eq!((data.lights.len(), data.settings.shadow_mode), (0, ShadowMode::Coloured));
}

/// What encloses its inside is a body; what is open, inside out, or full of holes is none.
#[test]
fn bodies() {
    use crate::model::Mesh;
    let glass = MaterialKind::Dielectric { ior: 1.5, tint: Vec3::ONE };
    let is_body = |mesh: Mesh, change: &dyn Fn(&mut crate::model::Scene)| {
        let mut scene = placed(mesh, &[Transform::default()]);
        scene.settings.integrator = Integrator::Path;
        scene.materials[0].kind = glass;
        change(&mut scene);
        flatten(&scene).0.materials[0].is_body
    };
    assert!(is_body(cube(), &|_| {}));
    assert!(is_body(super::tests::sphere_mesh(6), &|_| {}));
    assert!(!is_body(cube(), &|scene| scene.settings.integrator = Integrator::Whitted));
    assert!(!is_body(cube(), &|scene| scene.materials[0].kind = MaterialKind::Matte { color: Vec3::ONE }));
    assert!(!is_body(cube(), &|scene| scene.materials[0].alpha = AlphaMode::Blend));
    assert!(!is_body(cube(), &|scene| scene.materials[0].single_sided = true));
    let mut open = cube();
    open.triangles.pop();
    assert!(!is_body(open, &|_| {}));
    let mut turned = cube();
    turned.triangles.iter_mut().for_each(|t| t.positions.swap(1, 2));
    assert!(!is_body(turned, &|_| {}));
    // One open thing of a material makes all of it open; instances with a material of their own count for that.
    let second = |scene: &mut crate::model::Scene, mesh: Mesh, material: Option<u32>| {
        scene.meshes.push(mesh);
        let mut instance = scene.instances[0].clone();
        (instance.mesh, instance.material) = (1, material);
        scene.instances.push(instance);
    };
    let plane = || super::tests::grid(2);
    assert!(!is_body(cube(), &|scene| second(scene, plane(), None)));
    assert!(is_body(cube(), &|scene| {
        let kind = MaterialKind::Matte { color: Vec3::ONE };
        scene.materials.push(crate::model::Material::new("other", kind));
        second(scene, plane(), Some(1));
    }));
}
