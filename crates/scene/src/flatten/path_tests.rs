//! Known answers of flattening for path tracing.

use super::Note;
use super::tests::{cube, flatten, placed};
use crate::files::{LoadOptions, load_from_memory};
use crate::model::{AlphaMode, Material, MaterialKind, Pbr, Transform};
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

/// It is a number of any material with a ground, for path tracing; without it materials are what they were.
#[test]
fn roughness_of_the_ground() {
    let kind = MaterialKind::Matte { color: Vec3::ONE };
    let mut scene = placed(cube(), &[Transform::default()]);
    scene.settings.integrator = Integrator::Path;
    let error = |scene: &crate::model::Scene| super::SceneData::flatten(scene).err().unwrap().to_string();
    for kind in [kind, MaterialKind::Pbr(Pbr::default())] {
        scene.materials[0] = Material::new("moon", kind);
        assert_eq!(flatten(&scene).0.materials[0].diffuse_roughness, 0.0);
        scene.materials[0].diffuse_roughness = 0.75;
        assert_eq!(flatten(&scene).0.materials[0].diffuse_roughness, 0.75);
    }
    for wrong in [-0.1, 1.5, f32::NAN, f32::INFINITY] {
        scene.materials[0].diffuse_roughness = wrong;
        let expected =
            format!("material \"moon\", diffuse-roughness: {wrong} is out of range; it must be 0 to 1");
        assert_eq!(error(&scene), expected);
    }
    scene.materials[0].diffuse_roughness = 0.5;
    scene.settings.integrator = Integrator::Whitted;
    let refused =
        "material \"moon\", diffuse-roughness: the integrator whitted has none; use the integrator path";
    assert!(error(&scene).starts_with(refused), "{}", error(&scene));
    scene.settings.integrator = Integrator::Path;
    scene.materials[0].kind = MaterialKind::Mirror { reflectance: Vec3::ONE };
    assert!(error(&scene).contains("diffuse-roughness: this kind has no ground"), "{}", error(&scene));
}

#[test]
fn roughness_of_the_ground_in_scene_files() {
    let read = |material: &str| {
        let text = format!(r#"{{ "eosphor": 2, "materials": {{ "moon": {{ {material} }} }} }}"#);
        load_from_memory(vec![("s.json".into(), text.into_bytes())], "s.json", &LoadOptions::default())
    };
    let roughness = |material: &str| read(material).unwrap().scene.materials[0].diffuse_roughness;
    let matte = r#""matte": { "color": [1, 1, 1] }"#;
    assert_eq!(roughness(matte), 0.0);
    assert_eq!(roughness(&format!(r#"{matte}, "diffuse-roughness": 0.25"#)), 0.25);
    assert_eq!(roughness(r#""diffuse-roughness": 1, "pbr": {}"#), 1.0);
    for (number, message) in [("1.01", "must be 0 to 1"), ("-1", "must be 0 to 1"), ("\"much\"", "number")] {
        let error = read(&format!(r#"{matte}, "diffuse-roughness": {number}"#)).unwrap_err().to_string();
        assert!(error.contains("diffuse-roughness") && error.contains(message), "{error}");
        assert!(error.lines().next().is_some_and(|line| line.starts_with("s.json:1")), "{error}");
    }
    let error = read(r#""dielectric": { "ior": 1.5 }, "diffuse-roughness": 0.5"#).unwrap_err().to_string();
    assert!(error.contains("this kind has no ground"), "{error}");
}
