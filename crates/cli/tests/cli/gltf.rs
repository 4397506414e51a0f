//! glTF files are path-traced, unless something says otherwise.

use crate::place::{Place, Run};
use std::fs;

/// A triangle without light, and scenes over it.
fn files(place: &Place) {
    let corners = [-1f32, -1.0, 0.0, 1.0, -1.0, 0.0, 0.0, 1.0, 0.0];
    fs::write(place.path("t.bin"), corners.map(f32::to_le_bytes).concat()).unwrap();
    let text = r#"{"asset": {"version": "2.0"}, "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "material": 0}]}],
        "materials": [{"pbrMetallicRoughness": {"baseColorFactor": [0.9, 0.2, 0.1, 1], "metallicFactor": 0}}],
        "accessors": [{"bufferView": 0, "componentType": 5126, "type": "VEC3", "count": 3}],
        "bufferViews": [{"buffer": 0, "byteLength": 36}], "buffers": [{"uri": "t.bin", "byteLength": 36}]}"#;
    fs::write(place.path("t.gltf"), text).unwrap();
    for (name, settings) in [
        ("none.json", "{}"),
        ("path.json", r#"{"integrator": "path"}"#),
        ("whitted.json", r#"{"integrator": "whitted"}"#),
    ] {
        let text = format!(r#"{{"eosphor": 2, "base": "t.gltf", "settings": {settings}}}"#);
        fs::write(place.path(name), text).unwrap();
    }
}

fn render(place: &Place, scene: &str, flags: &[&str]) -> Run {
    let usual = ["render", scene, "--size", "20x15", "--no-metadata", "-o", "a.png"];
    place.run(&[&usual[..], flags].concat())
}

fn picture(place: &Place, scene: &str, flags: &[&str]) -> Vec<u8> {
    render(place, scene, flags).succeeded();
    fs::read(place.path("a.png")).unwrap()
}

#[test]
fn gltf_is_path_traced_by_default() {
    let place = Place::new();
    files(&place);
    let run = render(&place, "t.gltf", &[]).succeeded();
    assert!(run.stderr.contains("no light: uniform surroundings of radiance 0.5"), "{}", run.stderr);
    let alone = fs::read(place.path("a.png")).unwrap();
    let said = ["--integrator", "path", "--samples", "32", "--tone-curve", "neutral", "--depth", "8"];
    assert!(picture(&place, "t.gltf", &said) == alone);
    assert!(picture(&place, "path.json", &[]) == alone);
    for other in [["--samples", "1"], ["--tone-curve", "none"], ["--integrator", "whitted"]] {
        assert!(picture(&place, "t.gltf", &other) != alone, "{other:?}");
    }
}

/// Whitted's method by a flag, and where a scene file names no integrator or that one.
#[test]
fn the_other_method_has_its_own_settings() {
    let place = Place::new();
    files(&place);
    let flag = picture(&place, "t.gltf", &["--integrator", "whitted"]);
    let said = ["--integrator", "whitted", "--samples", "1", "--tone-curve", "none", "--ambient", "0.25"];
    assert!(picture(&place, "t.gltf", &[&said[..], &["--background", "0.25,0.25,0.25"]].concat()) == flag);
    assert!(picture(&place, "none.json", &[]) == flag);
    assert!(picture(&place, "whitted.json", &[]) == flag);
}

/// Flags of Whitted's method are for that alone. Presets are of it.
#[test]
fn flags_that_paths_lack_are_wrong_usage() {
    let place = Place::new();
    files(&place);
    for flags in
        [["--shadows", "none"], ["--light-samples", "2"], ["--lighting", "diffuse"], ["--fresnel", "schlick"]]
    {
        let words = [flags[0], "would do nothing here", "--integrator whitted"];
        render(&place, "t.gltf", &flags).is_wrong_usage(&words);
        for whitted in [["--integrator", "whitted"], ["--preset", "eos"]] {
            render(&place, "t.gltf", &[flags, whitted].concat()).succeeded();
        }
    }
    render(&place, "t.gltf", &["--preset", "pg1", "--roulette", "3"]).is_wrong_usage(&["--integrator path"]);
}
