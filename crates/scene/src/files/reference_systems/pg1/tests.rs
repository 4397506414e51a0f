//! Small configurations.

use super::is_config;
use crate::files::reference_systems::Preset;
use crate::files::source::Source;
use crate::files::{LoadOptions, LoadedScene, load_from};
use crate::model::{DeviceKind, DeviceSettings, Light, NormalMode, PixelSampling, RenderSettings, Structure};
use eosphor_core::math::{Vec3, vec3};
use eosphor_core::settings::LightingModel;
use std::borrow::Cow;
use std::path::{Path, PathBuf};

const OBJ: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";

fn load(text: &str) -> Result<LoadedScene, String> {
    let files = vec![
        (PathBuf::from("dir/c.json"), Cow::Owned(text.as_bytes().to_vec())),
        (PathBuf::from("dir/a.obj"), Cow::Borrowed(OBJ.as_bytes())),
        (PathBuf::from("dir/models/b.obj"), Cow::Borrowed(OBJ.as_bytes())),
    ];
    load_from(Source::Memory(files), Path::new("dir/c.json"), &LoadOptions::default())
        .map_err(|e| e.to_string())
}

#[test]
fn configurations_are_told_from_scenes() {
    assert!(is_config(br#"{"renderer": {}, "scene": {"source_file": "a.obj"}}"#));
    assert!(is_config("\u{feff}{\"scene\": 1, \"renderer\": 2}".as_bytes()));
    assert!(!is_config(br#"{"eosphor": 2, "renderer": {}, "scene": {}}"#));
    assert!(!is_config(br#"{"eosphor": 2}"#) && !is_config(b"{") && !is_config(br#"{"scene": {}}"#));
}

#[test]
fn what_is_left_open_is_the_preset() {
    let loaded = load(r#"{"renderer": {}, "scene": {"source_file": "a.obj"}}"#).unwrap();
    assert!(loaded.warnings.is_empty(), "{:?}", loaded.warnings);
    let mut same = crate::Scene::default();
    Preset::Pg1.apply(&mut same);
    assert_eq!((loaded.scene.settings, loaded.scene.camera), (same.settings, same.camera));
    assert_eq!(loaded.scene.instances.len(), 1);
}

#[test]
fn every_key() {
    let text = r#"{
        "seed": 7,
        "obj_loader": {"triangulate": true, "basepath": "models\\"},
        "renderer": {"render_mode": "gpu", "max_depth": 3, "samples_per_triangle": 5, "render_type": "distance",
            "max_distance": 9.5, "shading_type": "flat", "cull_backfaces": false, "background_color": [0, 0.5, 1],
            "acceleratied_data_structure": {
                "name": "octee_parametric", "max_triangles_per_BB": 16, "max_depth": 10
            },
            "output": {"filename": "out.ppm"}
        },
        "scene": {"source_file": "b.obj",
            "camera": {"pos": [1, 2, 3], "up": [0, 0, 1], "dir": [1, 0, 0], "fov": 1.5707963267948966,
                "width": 64, "height": 48, "samples_per_pixel": 4},
            "point_lights": [{"pos": [0, 5, 0], "color": [1, 2, 3]}]}
    }"#;
    let loaded = load(text).unwrap();
    assert!(loaded.warnings.is_empty(), "{:?}", loaded.warnings);
    let device = DeviceSettings {
        backend: Some(DeviceKind::Cuda),
        accel: Some(Structure::OctreeParametric),
        leaf_size: Some(16),
        tree_depth: Some(10),
        ..DeviceSettings::default()
    };
    assert_eq!((loaded.scene.device, loaded.scene.output.as_deref()), (device, Some("out.ppm")));
    let requests = super::requests(text.as_bytes());
    assert_eq!((requests.device, requests.output.as_deref()), (device, Some("out.ppm")));
    let expected = RenderSettings {
        seed: 7,
        size: [64, 48],
        samples: 4,
        pixel_sampling: PixelSampling::Random,
        depth: 3,
        light_samples: 5,
        lighting: LightingModel::Distance,
        max_distance: Some(9.5),
        normals: NormalMode::Flat,
        cull_back_faces: false,
        background: vec3(0.0, 0.5, 1.0),
        ..Preset::Pg1.settings()
    };
    assert_eq!(loaded.scene.settings, expected);
    let camera = loaded.scene.camera.unwrap();
    assert_eq!(
        (camera.position, camera.direction, camera.up),
        (vec3(1.0, 2.0, 3.0), vec3(1.0, 0.0, 0.0), vec3(0.0, 0.0, 1.0))
    );
    assert_eq!(camera.fov_x_degrees, 90.0);
    assert!(matches!(loaded.scene.lights[..], [Light::Point { position, color }]
        if position == vec3(0.0, 5.0, 0.0) && color == vec3(1.0, 2.0, 3.0)));
    assert_ne!(loaded.scene.settings.background, Vec3::ZERO);

    let right = text.replace("acceleratied", "accelerated").replace("octee", "octree");
    assert_eq!(format!("{:?}", load(&right).unwrap().scene), format!("{:?}", loaded.scene));
    for (name, model) in [
        ("diffusion", LightingModel::Diffuse),
        ("phong", LightingModel::Phong),
        ("blinn_phong", LightingModel::BlinnPhong),
    ] {
        assert_eq!(
            load(&text.replace("distance\",", &format!("{name}\","))).unwrap().scene.settings.lighting,
            model
        );
    }
}

#[test]
fn limits_belong_to_a_structure() {
    let text = r#"{"renderer": {"render_mode": "cpu", "acceleratied_data_structure": {"name": "none", "max_depth": 10}},
        "scene": {"source_file": "a.obj"}}"#;
    let device = load(text).unwrap().scene.device;
    assert_eq!((device.backend, device.accel), (Some(DeviceKind::Cpu), Some(Structure::None)));
    assert_eq!((device.leaf_size, device.tree_depth), (None, None));
}

#[test]
fn errors_say_line_and_nearest_name() {
    let text = "{\n\"renderer\": {\"max_depth\": 3},\n\"scene\": {\"source_file\": \"a.obj\",\n\"camera\": {\"fov\": 1}}\n}";
    for (from, to, expected) in [
        ("max_depth", "max_dept", "dir/c.json:2: unknown key \"max_dept\"; did you mean \"max_depth\"?"),
        (
            "\"max_depth\": 3",
            "\"render_type\": \"phon\"",
            "dir/c.json:2: unknown value \"phon\"; did you mean \"phong\"?",
        ),
        (
            "\"max_depth\": 3",
            "\"shading_type\": \"x\"",
            "dir/c.json:2: unknown value \"x\"; PG1 has \"flat\", \"smooth\" here",
        ),
        (
            "\"max_depth\": 3",
            "\"max_depth\": 65",
            "dir/c.json:2: max_depth: 65 is out of range; it must be 0 to 64",
        ),
        (
            "\"max_depth\": 3",
            "\"max_depth\": -1",
            "dir/c.json:2: invalid value: integer \"-1\", expected u32",
        ),
        (
            "\"fov\": 1",
            "\"fov\": 34.4",
            "dir/c.json:4: fov: 34.4 must be over 0 and under 3.1415; it is in radians",
        ),
        ("\"fov\": 1", "\"width\": 0", "dir/c.json:4: width: 0 is out of range; it must be 1 to 65535"),
        (
            "a.obj",
            "c.obj",
            "dir/c.json:3: the model \"c.obj\" is missing; source_file is relative to this file or to",
        ),
        ("\"source_file\": \"a.obj\",", "", "dir/c.json:4: missing field \"source_file\""),
    ] {
        let message = load(&text.replace(from, to)).unwrap_err();
        assert!(message.starts_with(expected), "{message}");
    }
}
