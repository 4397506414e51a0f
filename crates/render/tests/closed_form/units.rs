//! Units of light: lights and lamps of equal power light equally, whatever says them, and as Mitsuba's do.

use super::support::*;
use eosphor_core::math::Vec3;
use eosphor_core::settings::Integrator;
use eosphor_scene::{Light, LightSelection, LightUnits, LoadOptions, Scene, load};
use serde_json::{Value, json};
use std::fs;
use std::path::{Path, PathBuf};

/// Scenes, and what Mitsuba 3 makes of them (measure.py).
fn fixtures() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/closed_form/mitsuba")
}

pub(super) fn fixture(name: &str) -> Scene {
    let loaded = load(fixtures().join(name), &LoadOptions::default()).unwrap();
    assert!(loaded.warnings.is_empty(), "{:?}", loaded.warnings);
    let mut scene = loaded.scene;
    if scene.settings.integrator == Integrator::Whitted {
        // Without the noise of a choice.
        scene.settings.lights = Some(LightSelection::All);
    }
    scene
}

/// A line of measured.txt.
pub(super) struct Measured {
    pub(super) scene: String,
    pub(super) from: Vec3,
    pub(super) to: Vec3,
    pub(super) radiance: [f64; 3],
}

fn measured() -> Vec<Measured> {
    measured_in("measured.txt")
}

pub(super) fn measured_in(file: &str) -> Vec<Measured> {
    let text = fs::read_to_string(fixtures().join(file)).unwrap();
    let lines = text.lines().filter(|line| !line.starts_with('#'));
    let parse = |line: &str| {
        let (scene, numbers) = line.split_once(' ').unwrap();
        let n: Vec<f64> = numbers.split(' ').map(|n| n.parse().unwrap()).collect();
        let three = |first: usize| [n[first], n[first + 1], n[first + 2]];
        Measured { scene: scene.into(), from: single(three(0)), to: single(three(3)), radiance: three(6) }
    };
    lines.map(parse).collect()
}

/// Points of the plane that were measured, with what comes back from them.
fn on_plane(scene: &Scene, name: &str) -> Vec<Vec3> {
    let all = measured();
    all.iter().filter(|m| m.scene == name).map(|m| probe(scene, m.from, m.to)).collect()
}

#[test]
fn radiances_are_mitsubas() {
    let mut worst = [0f64; 2];
    let all = measured();
    for name in ["point", "sun", "spot", "ball", "room"] {
        let scene = fixture(&format!("{name}.json"));
        let probes: Vec<&Measured> = all.iter().filter(|m| m.scene == name).collect();
        assert!(probes.len() >= 2, "{name}");
        for Measured { from, to, radiance, .. } in probes {
            let got = probe(&scene, *from, *to);
            let error = |c: usize| (<[f32; 3]>::from(got)[c] as f64 / radiance[c] - 1.0).abs();
            // Where a lamp is sampled, Mitsuba's noise is most of the difference.
            let sampled = matches!(name, "ball" | "room");
            println!("{name} {to:?}: {got:?}, Mitsuba {radiance:?}");
            assert_near(got, *radiance, if sampled { 0.005 } else { 1e-4 });
            if radiance[0] > 0.0 {
                let most = error(0).max(error(1)).max(error(2));
                worst[sampled as usize] = worst[sampled as usize].max(most);
            }
        }
    }
    println!("against Mitsuba: {:.1e} without sampling, {:.1e} with", worst[0], worst[1]);
}

/// The point light of point.json, the lamp of ball.json by its MTL file, the same lamp as an instance of a glTF file, and
/// glTF's punctual light send the same power, and light a matte plane equally.
#[test]
fn lights_and_lamps_of_equal_power_light_equally() {
    let point = fixture("point.json");
    let lamp = fixture("ball.json");
    let candela = fixture_as_gltf(&lamp, Some(&point));
    let shining = fixture_as_gltf(&lamp, None);
    let expected = on_plane(&point, "point");
    for (name, scene, tolerance) in
        [("glTF's candela", &candela, 1e-6), ("Ke of an MTL", &lamp, 0.005), ("a glTF lamp", &shining, 0.005)]
    {
        let got = on_plane(scene, "point");
        assert!(got.len() == 5 && got.iter().all(|g| g.x > 0.0));
        let mean = |all: &[Vec3]| all.iter().map(|g| g.x as f64).sum::<f64>() / all.len() as f64;
        println!("{name}: mean of 5 points {:.4} of the point light's", mean(&got) / mean(&expected));
        for (got, expected) in got.iter().zip(&expected) {
            assert_near(*got, double(*expected), tolerance);
        }
    }
    // An OBJ's lamp and a glTF's are one lamp.
    for (obj, gltf) in on_plane(&lamp, "point").iter().zip(&on_plane(&shining, "point")) {
        assert_near(*gltf, double(*obj), 1e-5);
    }
}

/// The plane of a scene under its lamp, or under a punctual light with the power of another's light, by way of a glTF file.
fn fixture_as_gltf(lamp: &Scene, light: Option<&Scene>) -> Scene {
    let folder = tempfile::tempdir().unwrap();
    let mesh = &lamp.meshes[0];
    let plane = lamp.parallelograms[0];
    let color: [f32; 3] = plane_color(lamp);
    let mut file = Gltf::default();
    let (corner, u, v) = (plane.corner, plane.edge_u, plane.edge_v);
    file.add_mesh(&[corner, corner + u, corner + u + v, corner + v], &[0, 1, 2, 0, 2, 3], Vec3::ZERO);
    let black = json!({ "baseColorFactor": [0, 0, 0, 1], "metallicFactor": 0 });
    let dull = json!({ "KHR_materials_specular": { "specularFactor": 0 } });
    let matte = json!({ "baseColorFactor": [color[0], color[1], color[2], 1.0], "metallicFactor": 0 });
    file.root["materials"] = json!([{ "pbrMetallicRoughness": matte, "extensions": dull }]);
    file.root["extensionsUsed"] = json!(["KHR_lights_punctual", "KHR_materials_specular"]);
    match light.map(|scene| scene.lights[0]) {
        Some(Light::Point { position, color }) => {
            let lights = json!({ "lights": [{ "type": "point", "intensity": color.x }] });
            file.root["extensions"] = json!({ "KHR_lights_punctual": lights });
            file.add_node(json!({ "extensions": { "KHR_lights_punctual": { "light": 0 } } }), position);
        }
        Some(other) => panic!("{other:?}"),
        None => {
            let radiance = lamp.materials[mesh.triangles[0].material as usize].emission();
            let strength = json!({ "KHR_materials_emissive_strength": { "emissiveStrength": radiance.x } });
            let shining =
                json!({ "pbrMetallicRoughness": black, "emissiveFactor": [1, 1, 1], "extensions": strength });
            file.root["materials"].as_array_mut().unwrap().push(shining);
            file.root["extensionsUsed"]
                .as_array_mut()
                .unwrap()
                .push("KHR_materials_emissive_strength".into());
            let corners: Vec<u32> = mesh.triangles.iter().flat_map(|t| t.positions).collect();
            let place = lamp.instances[0].world_from_object.affine().point(Vec3::ZERO);
            file.add_mesh(&mesh.positions, &corners, place);
        }
    }
    let path = file.write(folder.path());
    let mut scene = load(&path, &LoadOptions::default()).unwrap().scene;
    assert_eq!(scene.settings.light_units, LightUnits::Physical);
    scene.settings = lamp.settings;
    scene
}

fn plane_color(scene: &Scene) -> [f32; 3] {
    let material = &scene.materials[scene.parallelograms[0].material as usize];
    let eosphor_scene::MaterialKind::Matte { color } = material.kind else { panic!("{material:?}") };
    color.into()
}

/// A glTF file in the making: a node and a material for each mesh.
struct Gltf {
    root: Value,
    bytes: Vec<u8>,
}

impl Default for Gltf {
    fn default() -> Gltf {
        let none = || json!([]);
        let root = json!({ "asset": { "version": "2.0" }, "nodes": none(), "meshes": none(), "accessors": none(),
            "bufferViews": none() });
        Gltf { root, bytes: Vec::new() }
    }
}

impl Gltf {
    /// The number of the new entry.
    fn push(&mut self, list: &str, entry: Value) -> usize {
        let list = self.root[list].as_array_mut().unwrap();
        list.push(entry);
        list.len() - 1
    }

    fn accessor(&mut self, bytes: &[u8], kind: &str, component: u32, count: usize) -> usize {
        let view = json!({ "buffer": 0, "byteOffset": self.bytes.len(), "byteLength": bytes.len() });
        self.bytes.extend(bytes);
        let view = self.push("bufferViews", view);
        let entry = json!({ "bufferView": view, "type": kind, "componentType": component, "count": count });
        self.push("accessors", entry)
    }

    fn add_node(&mut self, mut node: Value, place: Vec3) {
        node["translation"] = json!(<[f32; 3]>::from(place));
        self.push("nodes", node);
    }

    fn add_mesh(&mut self, positions: &[Vec3], corners: &[u32], place: Vec3) {
        let xyz: Vec<u8> =
            positions.iter().flat_map(|&p| <[f32; 3]>::from(p)).flat_map(f32::to_le_bytes).collect();
        let corner_bytes: Vec<u8> = corners.iter().flat_map(|c| c.to_le_bytes()).collect();
        let position = self.accessor(&xyz, "VEC3", 5126, positions.len());
        let indices = self.accessor(&corner_bytes, "SCALAR", 5125, corners.len());
        let material = self.root["meshes"].as_array().unwrap().len();
        let primitive =
            json!({ "attributes": { "POSITION": position }, "indices": indices, "material": material });
        let mesh = self.push("meshes", json!({ "primitives": [primitive] }));
        self.add_node(json!({ "mesh": mesh }), place);
    }

    fn write(mut self, folder: &Path) -> PathBuf {
        self.root["buffers"] = json!([{ "uri": "all.bin", "byteLength": self.bytes.len() }]);
        fs::write(folder.join("all.bin"), &self.bytes).unwrap();
        let path = folder.join("all.gltf");
        fs::write(&path, self.root.to_string()).unwrap();
        path
    }
}

/// Units are of lights alone: what shines by itself, what surrounds, and what reflects do not depend on them. A plain light
/// lights pi times as much.
#[test]
fn plain_light_is_pi_times_physical_light() {
    let mut scene = fixture("point.json");
    scene.settings.ambient = 0.25;
    let only_ambient =
        Scene { lights: vec![Light::Point { position: Vec3::ZERO, color: Vec3::ZERO }], ..scene.clone() };
    let [physical, plain, ambient] =
        [(&scene, LightUnits::Physical), (&scene, LightUnits::Plain), (&only_ambient, LightUnits::Physical)]
            .map(|(scene, light_units)| {
                let mut scene = scene.clone();
                scene.settings.light_units = light_units;
                on_plane(&scene, "point")
            });
    for ((physical, plain), ambient) in physical.iter().zip(&plain).zip(&ambient) {
        // A white furnace of radiance L shows rho L.
        assert_near(*ambient, plane_color(&scene).map(|rho| 0.25 * f64::from(rho)), 1e-6);
        let expected = double(*physical - *ambient).map(|x| x * std::f64::consts::PI);
        assert_near(*plain - *ambient, expected, 1e-5);
    }
}
