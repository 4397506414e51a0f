//! Known answers of scenes that begin with another file.

use crate::error::SceneError;
use crate::files::requests::scene_requests;
use crate::files::{LoadOptions, LoadedScene, load, load_from_memory};
use crate::flatten::SceneData;
use crate::model::{Camera, DeviceKind, Light, PixelSampling, Scene, Structure};
use eosphor_core::math::{Vec3, vec3};
use eosphor_core::settings::LightingModel;
use std::path::{Path, PathBuf};

const OBJ: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
const FAR: &str = "v 500000 5000000 0\nv 500001 5000000 0\nv 500000 5000001 0\nf 1 2 3\n";
const BASE: &str = r#"{"eosphor": 2, "spheres": [{"center": [0, 0, 0], "radius": 1}],
    "camera": {"position": [0, 0, 9], "lens": {"aperture-radius": 0.5, "focus-distance": 4}},
    "lights": [{"point": {"position": [1, 2, 3], "color": [4, 5, 6]}}], "output": "base.png",
    "device": {"backend": "cpu", "accel": "octree", "tree-depth": 3},
    "animation": {"frames": 7, "camera": {"orbit": {}}},
    "settings": {"size": [32, 16], "samples": 5, "max-distance": 3, "ambient": 0.1}}"#;
const MOVED: &str = r#"{"eosphor": 2, "spheres": [{"center": [0, 0, 0], "radius": 1}],
    "animation": {"frames": 5, "camera": {"keys": {"keys": [{"seconds": 0, "position": [0, 0, 8], "look-at": [0, 0, 0]},
    {"seconds": 1, "position": [0, 8, 8], "look-at": [0, 0, 0]}]}}}}"#;
const PG1: &str = r#"{"renderer": {"render_mode": "gpu", "max_depth": 2, "acceleratied_data_structure": {"name": "octree",
    "max_depth": 4}}, "output": {"filename": "pg1.ppm"}, "scene": {"source_file": "a.obj",
    "camera": {"pos": [0, 0, 5], "width": 8}, "point_lights": [{"pos": [0, 1, 5], "color": [1, 1, 1]}]}}"#;
const GLTF: &str = r#"{"asset": {"version": "2.0"}, "scenes": [{"nodes": [0]}], "nodes": [{"camera": 0}],
    "cameras": [{"type": "perspective", "perspective": {"yfov": 0.7, "znear": 1}}]}"#;

/// The file of each name: the bases in `dir/bases`, and the scene over them.
fn files(text: &str) -> Vec<(PathBuf, Vec<u8>)> {
    [
        ("dir/s.json", text),
        ("dir/bases/base.json", BASE),
        ("dir/bases/moved.json", MOVED),
        ("dir/bases/old.json", r#"{"eosphor": 1, "spheres": [{"center": [0, 0, 0], "radius": 1}]}"#),
        (
            "dir/bases/over.json",
            r#"{"eosphor": 2, "base": "base.json", "settings": {"samples": 7, "depth": 3}}"#,
        ),
        ("dir/bases/wrong.json", "{\"eosphor\": 2,\n \"settings\": {\"sampels\": 1}}"),
        ("dir/bases/c.json", PG1),
        ("dir/bases/a.obj", OBJ),
        ("dir/bases/far.obj", FAR),
        ("dir/bases/x.gltf", GLTF),
        ("dir/bases/broken.obj", "v 0 0 0\nf 1 2 9\n"),
        ("dir/bases/huge.obj", "v 0 0 0\nv 1e13 0 0\nv 0 1 0\nf 1 2 3\n"),
        ("dir/bases/room.stl", "solid"),
        ("dir/self.json", r#"{"eosphor": 2, "base": "self.json"}"#),
        ("dir/one.json", r#"{"eosphor": 2, "base": "two.json"}"#),
        ("dir/two.json", r#"{"eosphor": 2, "base": "one.json"}"#),
        ("dir/./dir.json", ""),
    ]
    .map(|(name, text)| (PathBuf::from(name), text.as_bytes().to_vec()))
    .to_vec()
}

fn read_with(text: &str, options: &LoadOptions) -> Result<LoadedScene, SceneError> {
    load_from_memory(files(text), "dir/s.json", options)
}

/// A scene that begins with a file of `dir/bases`, and has these keys, too.
fn over(base: &str, keys: &str) -> Result<Scene, SceneError> {
    read_with(&text_over(base, keys), &LoadOptions::default()).map(|loaded| loaded.scene)
}

fn text_over(base: &str, keys: &str) -> String {
    let base = if base.starts_with("builtin:") { base.to_owned() } else { format!("bases/{base}") };
    format!("{{\"eosphor\": 2, \"base\": \"{base}\"{keys}}}")
}

fn alone(base: &str) -> Scene {
    match base.starts_with("builtin:") {
        true => load(base, &LoadOptions::default()).unwrap().scene,
        false => {
            let path = format!("dir/bases/{base}");
            load_from_memory(files(""), path, &LoadOptions::default()).unwrap().scene
        }
    }
}

fn error(base: &str, keys: &str) -> String {
    over(base, keys).unwrap_err().to_string()
}

fn flat(scene: &Scene) -> String {
    format!("{:?}", SceneData::flatten(scene).unwrap().0)
}

#[test]
fn a_base_is_taken_whole() {
    for base in
        ["base.json", "moved.json", "over.json", "c.json", "a.obj", "far.obj", "x.gltf", "builtin:glass"]
            .into_iter()
            .chain(["builtin:cornell", "builtin:solids"])
    {
        let (scene, alone) = (over(base, "").unwrap(), alone(base));
        assert_eq!(format!("{scene:?}"), format!("{alone:?}"), "{base}");
        assert_eq!(flat(&scene), flat(&alone), "{base}");
    }
}

#[test]
fn settings_go_over_those_of_the_base_key_by_key() {
    let keys = r#", "description": "for readers", "settings": {"samples": 9, "max-distance": null, "background": [0, 0.5, 1],
        "pixel-sampling": {"grid": 3}, "lighting": "phong"}"#;
    let (scene, base) = (over("base.json", keys).unwrap(), alone("base.json"));
    let mut expected = base.settings;
    (expected.samples, expected.max_distance) = (9, None);
    (expected.background, expected.lighting) = (vec3(0.0, 0.5, 1.0), LightingModel::Phong);
    expected.pixel_sampling = PixelSampling::Grid(3);
    assert_eq!((scene.settings, scene.camera), (expected, base.camera));
    assert_eq!((base.settings.max_distance, base.settings.ambient), (Some(3.0), 0.1));
    // Over several.
    let settings = over("over.json", r#", "settings": {"depth": 1}"#).unwrap().settings;
    assert_eq!((settings.size, settings.samples, settings.depth, settings.ambient), ([32, 16], 7, 1, 0.1));
}

#[test]
fn what_is_dark_gets_no_grey_surroundings() {
    let settings = |keys: &str| over("a.obj", keys).unwrap().settings;
    assert!(settings("").headlight && settings("").ambient > 0.0);
    assert!(settings(r#", "settings": {"ambient": 0}"#).background != Vec3::ZERO);
    for keys in [r#", "settings": {"headlight": false}"#, r#", "lights": []"#] {
        let dark = settings(keys);
        assert_eq!((dark.headlight, dark.ambient, dark.background), (false, 0.0, Vec3::ZERO), "{keys}");
    }
    // What is asked for where files are loaded holds for bases, and for built-in ones.
    let options = LoadOptions { headlight: false, ..LoadOptions::default() };
    for base in ["a.obj", "builtin:cornell"] {
        let settings = read_with(&text_over(base, ""), &options).unwrap().scene.settings;
        assert!(!settings.headlight, "{base}");
    }
    let on = text_over("a.obj", r#", "settings": {"headlight": true}"#);
    assert!(!read_with(&on, &options).unwrap().scene.settings.headlight);
}

#[test]
fn a_camera_takes_the_place_of_that_of_the_base_and_of_its_motion() {
    let keys = r#", "camera": {"position": [1, 2, 3], "look-at": [0, 0, 0]}"#;
    let expected = Camera { position: vec3(1.0, 2.0, 3.0), look_at: Some(Vec3::ZERO), ..Camera::default() };
    for (base, frames) in [("base.json", Some(7)), ("moved.json", Some(5)), ("a.obj", None)] {
        let scene = over(base, keys).unwrap();
        assert_eq!((scene.camera_at(0), scene.camera_at(4)), (Some(expected), Some(expected)), "{base}");
        assert_eq!(scene.animation.as_ref().map(|animation| animation.frames), frames);
    }
    assert!(
        !over("builtin:solids", keys).unwrap().camera_is_led() && alone("builtin:solids").camera_is_led()
    );
}

#[test]
fn coordinates_are_those_of_the_base_with_all_their_digits() {
    let keys = r#", "camera": {"position": [500000.125, 5000000.375, 2], "look-at": [500000.75, 5000000.625, 0]},
        "lights": [{"point": {"position": [500000.625, 5000000.875, 3], "color": [1, 1, 1]}},
        {"directional": {"direction": [0, 0, -1], "color": [1, 1, 1]}}]"#;
    let scene = over("far.obj", keys).unwrap();
    assert!(scene.origin != [0.0; 3] && scene.origin == alone("far.obj").origin);
    let camera = scene.camera.unwrap();
    assert_eq!(scene.point_in_file(camera.position), [500_000.125, 5_000_000.375, 2.0]);
    assert_eq!(scene.point_in_file(camera.look_at.unwrap()), [500_000.75, 5_000_000.625, 0.0]);
    let Light::Point { position, .. } = scene.lights[0] else { panic!() };
    assert_eq!(scene.point_in_file(position), [500_000.625, 5_000_000.875, 3.0]);
    // What is not said is said in coordinates of the file, too.
    let scene = over("far.obj", r#", "camera": {"look-at": [500000, 5000000, 0]}"#).unwrap();
    assert_eq!(scene.point_in_file(scene.camera.unwrap().position), [0.0, 0.0, 5.0]);
    // Single precision takes these two for one point.
    let keys = r#", "camera": {"position": [500000, 5000000.125, 0], "look-at": [500000, 5000000, 0], "up": [0, 0, 1]}"#;
    over("far.obj", keys).unwrap();
}

#[test]
fn lights_devices_and_outputs_take_the_place_of_those_of_the_base() {
    let sun = Light::Directional { direction: vec3(0.0, -1.0, 0.0), color: Vec3::ONE };
    let keys = r#", "lights": [{"directional": {"direction": [0, -1, 0], "color": [1, 1, 1]}}], "output": "o.png",
        "device": {"accel": "grid", "tree-depth": null}"#;
    let scene = over("base.json", keys).unwrap();
    assert_eq!((scene.lights, scene.output.as_deref()), (vec![sun], Some("o.png")));
    let device = scene.device;
    assert_eq!((device.backend, device.accel), (Some(DeviceKind::Cpu), Some(Structure::Grid)));
    assert_eq!(device.tree_depth, None);
    let scene = over("base.json", r#", "lights": []"#).unwrap();
    assert!(scene.lights.is_empty() && !scene.settings.headlight);
}

#[test]
fn what_a_scene_is_made_of_belongs_into_the_base() {
    for (key, value) in [
        ("materials", "{}"),
        ("meshes", "[]"),
        ("instances", "[]"),
        ("spheres", "[]"),
        ("parallelograms", "[]"),
        ("quadrilaterals", "[]"),
        ("solids", "[]"),
        ("animation", r#"{"frames": 2}"#),
        ("origin", "[0, 0, 0]"),
    ] {
        let message = error("base.json", &format!(",\n  \"{key}\": {value}"));
        let expected = format!("dir/s.json:2:3: \"{key}\" does not stand beside \"base\"");
        assert!(message.starts_with(&expected) && message.contains("belongs into the base"), "{message}");
    }
    let old = read_with(r#"{"eosphor": 1, "base": "bases/base.json"}"#, &LoadOptions::default()).unwrap_err();
    assert!(old.to_string().starts_with("dir/s.json:1:13: version 1 of the format has no \"base\""), "{old}");
    // The base may be an old one.
    let loaded = read_with(&text_over("old.json", ""), &LoadOptions::default()).unwrap();
    assert_eq!(loaded.scene.settings.light_units, alone("old.json").settings.light_units);
}

#[test]
fn errors_are_said_where_they_are() {
    let at_key = |base: &str, words: &str| {
        let message = error(base, "");
        assert!(message.starts_with("dir/s.json:1:24: base: ") && message.contains(words), "{message}");
    };
    at_key("none.json", "dir/bases/none.json: cannot read: No such file");
    at_key("none.obj", "dir/bases/none.obj: cannot read: No such file");
    at_key("room.stl", "\"stl\" files are not read");
    at_key("builtin:glas", "there is no built-in scene \"glas\"");
    // Inside of the base.
    for (base, start) in [
        ("wrong.json", "dir/bases/wrong.json:2:15: unknown key \"sampels\"; did you mean \"samples\"?"),
        ("broken.obj", "dir/bases/broken.obj:2: "),
        ("huge.obj", "dir/bases/huge.obj:"),
    ] {
        assert!(error(base, "").starts_with(start), "{}", error(base, ""));
    }
    // In the keys over it.
    for (keys, start) in [
        (r#", "settings": {"depth": 65}"#, "dir/s.json:1:65: \"depth\" is 65; it must be 0 to 64"),
        (r#", "camera": {"direction": [0, 0, 0]}"#, "dir/s.json:1:67: \"direction\" has no length"),
        (r#", "camera": {"lens": {"aperture-radius": 1}}"#, "dir/s.json:1:62: camera.lens"),
        (r#", "base": "x""#, "dir/s.json:1:43: \"base\" is given twice"),
    ] {
        assert!(error("base.json", keys).starts_with(start), "{}", error("base.json", keys));
    }
}

#[test]
fn circles_and_long_chains_are_refused() {
    let read = |name: &str| {
        load_from_memory(files(""), name, &LoadOptions::default()).map(|_| ()).map_err(|e| e.to_string())
    };
    let itself = "dir/self.json:1:24: base: the file begins with itself; name another one";
    assert_eq!(read("dir/self.json").unwrap_err(), itself);
    let message = read("dir/one.json").unwrap_err();
    assert_eq!(
        message,
        "dir/two.json:1:24: base: the file begins with itself, by way of dir/one.json; name another one"
    );
    let chain = |length: usize| {
        let name = |i: usize| PathBuf::from(format!("{i}.json"));
        let file =
            |i: usize| (name(i), format!(r#"{{"eosphor": 2, "base": "{}.json"}}"#, i + 1).into_bytes());
        let mut files: Vec<_> = (0..length).map(file).collect();
        files.push((name(length), BASE.as_bytes().to_vec()));
        load_from_memory(files, "0.json", &LoadOptions::default()).map_err(|e| e.to_string())
    };
    assert_eq!(chain(16).unwrap().scene.settings.samples, 5);
    let message = chain(17).unwrap_err();
    assert!(message.starts_with("16.json:1:24: base: more than 16 files begin with each other"), "{message}");
}

/// A folder of these files, which goes at the end.
struct Folder(PathBuf);

impl Folder {
    fn new(name: &str) -> Folder {
        let root = std::env::temp_dir().join(format!("eosphor-base-{name}-{}", std::process::id()));
        for (path, bytes) in files(&text_over("over.json", "")) {
            let path = root.join(path);
            std::fs::create_dir_all(path.parent().unwrap()).unwrap();
            std::fs::write(path, bytes).unwrap();
        }
        Folder(root.join("dir"))
    }

    fn write(&self, text: &str) -> PathBuf {
        let path = self.0.join("s.json");
        std::fs::write(&path, text).unwrap();
        path
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(self.0.parent().unwrap());
    }
}

#[test]
fn all_files_are_read_once_and_missing_ones_have_a_hint() {
    let folder = Folder::new("files");
    let path = folder.write(&text_over("over.json", ""));
    let loaded = load(&path, &LoadOptions::default()).unwrap();
    let bases = ["over.json", "base.json"].map(|name| folder.0.join("bases").join(name));
    let [over, base] = bases;
    assert_eq!(loaded.files_read, [path, over, base]);
    let builtin = folder.write(r#"{"eosphor": 2, "base": "builtin:glass"}"#);
    assert_eq!(load(&builtin, &LoadOptions::default()).unwrap().files_read, [builtin]);
    let missing = folder.write(&text_over("bose.json", ""));
    let message = load(&missing, &LoadOptions::default()).unwrap_err().to_string();
    assert!(
        message.contains("s.json:1:24: base: ") && message.ends_with("did you mean base.json?"),
        "{message}"
    );
}

#[test]
fn bases_ask_for_devices_and_outputs_too() {
    let folder = Folder::new("requests");
    let asked = |text: &str| scene_requests(&folder.write(text));
    let loaded = |text: &str| load(folder.write(text), &LoadOptions::default()).unwrap().scene;
    for keys in ["", r#", "device": {"accel": "grid", "tree-depth": null}"#, r#", "output": "o.png""#] {
        for base in ["base.json", "over.json", "c.json", "a.obj", "builtin:glass"] {
            let text = text_over(base, keys);
            let (requests, scene) = (asked(&text), loaded(&text));
            assert_eq!((requests.device, requests.output), (scene.device, scene.output), "{text}");
            assert!(!requests.is_pg1);
        }
    }
    let requests = asked(&text_over("over.json", ""));
    assert_eq!(requests.device.accel, Some(Structure::Octree));
    assert_eq!(requests.output.as_deref(), Some("base.png"));
    assert!(scene_requests(&folder.0.join("bases/c.json")).is_pg1);
    // What cannot be loaded asks for nothing more, and in the end.
    for name in ["self.json", "one.json", "none.json"] {
        assert_eq!(scene_requests(&folder.0.join(Path::new(name))).output, None, "{name}");
    }
}

#[test]
fn textures_and_their_budget_are_as_asked() {
    let options = LoadOptions { textures: false, ..LoadOptions::default() };
    let read = |options: &LoadOptions| read_with(&text_over("builtin:solids", ""), options);
    let has_texture = |scene: &Scene| scene.materials.iter().any(|m| m.textures.color.is_some());
    assert!(!has_texture(&read(&options).unwrap().scene));
    assert!(has_texture(&read(&LoadOptions::default()).unwrap().scene));
    let little = LoadOptions { texture_memory_bytes: Some(1), ..LoadOptions::default() };
    assert!(matches!(read(&little), Err(SceneError::TextureMemory { .. })));
    // A choice of cameras is for glTF files that are opened themselves.
    let choice = LoadOptions { camera: Some("0".into()), ..LoadOptions::default() };
    assert!(matches!(read(&choice), Err(SceneError::NoSuchCamera { .. })));
}
