//! Known answers of JSON scenes given inline.

use crate::error::SceneError;
use crate::files::source::Source;
use crate::files::{LoadOptions, LoadedScene, load_from};
use crate::model::{Light, MaterialKind, PixelSampling};
use eosphor_core::math::{Vec3, vec3};
use eosphor_core::texture::{TextureFilter, TextureWrap};
use std::borrow::Cow;
use std::path::{Path, PathBuf};

const OBJ: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl x\nf 1 2 3\n";

fn read(text: &str) -> Result<LoadedScene, SceneError> {
    let file = |name: &str, bytes: &str| (PathBuf::from(name), Cow::Owned(bytes.as_bytes().to_vec()));
    let files = vec![
        file("dir/s.json", text),
        file("dir/models/tri.obj", OBJ),
        file("dir/t.ppm", "P3\n1 1\n255\n1 2 3\n"),
    ];
    load_from(Source::Memory(files), Path::new("dir/s.json"), &LoadOptions::default())
}

fn error(text: &str) -> String {
    read(text).unwrap_err().to_string()
}

#[test]
fn every_key() {
    let loaded = read(
        r#"{
        "eosphor": 1,
        "description": "all keys",
        "camera": {"position": [1, 2, 3], "look-at": [0, 0, 0], "fov-x-degrees": 30,
                   "lens": {"aperture-radius": 0.1}},
        "lights": [
            {"point": {"position": [0, 1, 0], "color": [1, 1, 1]}},
            {"directional": {"direction": [0, -1, 0], "colour": [1, 1, 1]}},
            {"spot": {"position": [0, 5, 0], "direction": [0, -1, 0], "inner-degrees": 10, "outer-degrees": 20,
                      "color": [9, 9, 9]}}],
        "materials": {
            "red": {"matte": {"color": [1, 0, 0]}},
            "tiles": {"texture": {"file": "t.ppm", "filter": "nearest", "wrap": "clamp"},
                      "mtl": {"Kd": [1, 1, 1], "illum": 3, "Ks": [0.5, 0.5, 0.5]}},
            "wood": {"matte": {"color": [1, 1, 1]}, "texture": "t.ppm"},
            "mirror": {"mirror": {"reflectance": [0.9, 0.9, 0.9]}},
            "glass": {"dielectric": {"ior": "crown-glass"}},
            "ice": {"dielectric": {"ior": 1.31, "tint": [0.9, 1, 1]}},
            "brushed": {"glossy": {"reflectance": [0.5, 0.5, 0.5], "exponent": 50}},
            "pane": {"transparent": {"color": [0, 1, 0], "transparency": 0.5}},
            "lamp": {"emissive": {"radiance": [5, 5, 5]}}},
        "meshes": [
            {"file": "models/tri.obj", "name": "a", "material": "red", "transform": {"scale": [2, 2, 2]}},
            {"file": "models/tri.obj", "transform": {"translate": [0, 0, -1]}}],
        "instances": [
            {"mesh": "a", "transform": {"translate": [1, 0, 0]}},
            {"mesh": "a", "transform": {"rotate-degrees": [0, 90, 0]}}],
        "spheres": [{"center": [0, 0, 0], "radius": 0.5, "material": "glass"}, {"center": [1, 0, 0], "radius": 1}],
        "parallelograms": [{"corner": [0, 0, 0], "edge-u": [1, 0, 0], "edge-v": [0, 1, 0], "material": "lamp"}],
        "settings": {"size": [64, 32], "pixel-sampling": {"grid": 3}, "lighting": "phong", "shadows": "coloured",
                     "max-distance": 3.5}
    }"#,
    )
    .unwrap();
    let s = &loaded.scene;
    assert_eq!((s.lights.len(), s.textures.len(), s.meshes.len(), s.instances.len()), (3, 2, 2, 3));
    assert_eq!((s.textures[0].filter, s.textures[0].wrap_u), (TextureFilter::Nearest, TextureWrap::Clamp));
    assert_eq!((s.textures[1].filter, s.textures[1].wrap_v), (TextureFilter::Bilinear, TextureWrap::Repeat));
    assert_eq!(s.materials[4].kind, MaterialKind::Dielectric { ior: 1.52, tint: Vec3::ONE });
    assert!(matches!(s.lights[1], Light::Directional { color: Vec3::ONE, .. }));
    assert_eq!(s.settings.pixel_sampling, PixelSampling::Grid(3));
    assert_eq!((s.spheres[0].material, s.materials[s.spheres[1].material as usize].is_default()), (4, true));
    // The mesh's own transform comes first.
    let p = s.instances[0].world_from_object.affine().point(vec3(1.0, 0.0, 0.0));
    assert_eq!(p, vec3(3.0, 0.0, 0.0));
    assert_eq!(s.meshes[1].name, "tri");
    assert_eq!(s.meshes[0].triangles[0].material, 0);
    assert_eq!(loaded.warnings.len(), 1, "the OBJ's own unknown material: {:?}", loaded.warnings);
}

#[test]
fn errors_name_the_place() {
    for (text, expected) in [
        ("{}", "dir/s.json: this is no Eosphor scene; it needs the key \"eosphor\": 1"),
        ("{\n\"eosphor\": 2}", "dir/s.json:2: \"eosphor\" is 2; this program reads version 1"),
        ("{\"eosphor\": 1,\n \"x\": }", "dir/s.json:2:7: expected value"),
        (
            "{\"eosphor\": 1,\n \"fov\": 3}",
            "dir/s.json:2:6: unknown field \"fov\", expected one of \"eosphor\", ",
        ),
        (
            "{\"eosphor\": 1,\n\"camera\": {\"fov\": 3}}",
            "dir/s.json:2:16: unknown field \"fov\", expected one of \"position\"",
        ),
        (
            "{\"eosphor\": 1,\n\"settings\": {\"depth\": 65}}",
            "dir/s.json:2: settings.depth: 65 is out of range; it must be 0 to 64",
        ),
        (
            "{\"eosphor\": 1,\n\"settings\": {\"size\": [0, 5]}}",
            "dir/s.json:2: settings.size (width): 0 is out of range; it must be 1 to 65535",
        ),
        (
            "{\"eosphor\": 1, \"materials\": {\"glass\": {\"mirror\": {\"reflectance\": [1,1,1]}}},\n\"spheres\": [{\"center\": [0,0,0], \"radius\": 1,\n\"material\": \"glas\"}]}",
            "dir/s.json:3: unknown material \"glas\"; did you mean \"glass\"?",
        ),
        (
            "{\"eosphor\": 1,\n\"instances\": [{\"mesh\": \"a\"}]}",
            "dir/s.json:2: unknown mesh \"a\"; the file has none",
        ),
        (
            "{\"eosphor\": 1,\n\"meshes\": [{\"file\": \"no.obj\"}]}",
            "dir/s.json:2: mesh: dir/no.obj: cannot read: No such file",
        ),
        (
            "{\"eosphor\": 1,\n\"meshes\": [{\"file\": \"a.glb\"}]}",
            "dir/s.json:2: mesh \"a.glb\": only OBJ meshes are read so far",
        ),
        (
            "{\"eosphor\": 1,\n\"materials\": {\"a\": {\"matte\": {\"color\": [1,1,1]}, \"texture\": \"no.png\"}}}",
            "dir/s.json:2: texture: dir/no.png: cannot read: No such file",
        ),
        (
            "{\"eosphor\": 1, \"spheres\": [{\"center\": [0,0,0], \"radius\": 0}]}",
            "dir/s.json: spheres[0].radius: 0 must be over 0",
        ),
        (
            "{\"eosphor\": 1,\n \"spheres\": [{\"center\": [0,0,1e39], \"radius\": 1}]}",
            "dir/s.json:2:30: 1e39 is out of range; numbers must be within 1e12",
        ),
        ("{\"eosphor\": 1, \"materials\": {\"a\": {}}}", "dir/s.json:1:36: the material has no kind"),
        (
            "{\"eosphor\": 1, \"materials\": {\"a\": {\"matt\": {\"color\": [1,1,1]}}}}",
            "dir/s.json:1:43: unknown variant \"matt\", expected one of \"mtl\", \"matte\"",
        ),
        (
            "{\"eosphor\": 1, \"materials\": {\"a\": {\"dielectric\": {\"ior\": \"cheese\"}}}}",
            "dir/s.json:1:65: invalid value: string \"cheese\", expected an index of refraction",
        ),
        (
            "{\"eosphor\": 1, \"materials\": {\"a\": {\"matte\": {\"color\": [1,1,1]}}, \"a\": {\"matte\": {\"color\": [1,1,1]}}}}",
            "dir/s.json:1:68: the name \"a\" is given twice",
        ),
        (
            "{\"eosphor\": 1,\n\"materials\": {\"a\":\n{\"dielectric\": {\"ior\": 0}}}}",
            "dir/s.json:2: material \"a\", ior: 0 is no index of refraction",
        ),
        (
            "{\"eosphor\": 1,\n\"camera\": {\"position\": [0,0,0],\n\"fov-x-degrees\": 180}}",
            "dir/s.json:3: camera.fov-x-degrees: 180 must be over 0 and under 180",
        ),
        (
            "{\"eosphor\": 1, \"camera\": {\"lens\": {\"aperture-radius\": 1}}}",
            "dir/s.json:1: camera.lens: which distance is sharp?",
        ),
        (
            "{\"eosphor\": 1, \"meshes\": [{\"file\": \"models/tri.obj\"}, {\"file\": \"models/tri.obj\"}],\n\"instances\": [{\"mesh\": \"tri\"}]}",
            "dir/s.json:2: two meshes are named \"tri\"",
        ),
    ] {
        let message = error(text);
        assert!(message.starts_with(expected), "{text}\n  says     {message}\n  expected {expected}");
    }
}
