//! Known answers of JSON scenes given inline.

use crate::error::SceneError;
use crate::files::source::Source;
use crate::files::{LoadOptions, LoadedScene, load_from};
use crate::flatten::{FrameStates, SceneData};
use crate::model::{AlphaMode, Channel, Light, LightUnits, MaterialKind, PixelSampling, TextureContent};
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
        file("dir/bad.obj", "v 0 0 0\nf 1 2 3\n"),
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
        "eosphor": 2,
        "$schema": "schema.json",
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
            {"mesh": "a", "material": "glass", "transform": {"rotate-degrees": [0, 90, 0]}}],
        "spheres": [{"center": [0, 0, 0], "radius": 0.5, "material": "glass"}, {"center": [1, 0, 0], "radius": 1}],
        "parallelograms": [{"corner": [0, 0, 0], "edge-u": [1, 0, 0], "edge-v": [0, 1, 0], "material": "lamp"}],
        "settings": {"size": [64, 32], "pixel-sampling": {"grid": 3}, "lighting": "phong", "shadows": "coloured",
                     "max-distance": 3.5}
    }"#,
    )
    .unwrap();
    let s = &loaded.scene;
    assert_eq!((s.lights.len(), s.textures.len(), s.meshes.len(), s.instances.len()), (3, 2, 1, 3));
    assert_eq!((s.textures[0].filter, s.textures[0].wrap_u), (TextureFilter::Nearest, TextureWrap::Clamp));
    assert_eq!((s.textures[1].filter, s.textures[1].wrap_v), (TextureFilter::Bilinear, TextureWrap::Repeat));
    assert_eq!(s.materials[4].kind, MaterialKind::Dielectric { ior: 1.52, tint: Vec3::ONE });
    assert!(matches!(s.lights[1], Light::Directional { color: Vec3::ONE, .. }));
    assert_eq!(s.settings.pixel_sampling, PixelSampling::Grid(3));
    assert_eq!((s.spheres[0].material, s.materials[s.spheres[1].material as usize].is_default()), (4, true));
    // The mesh's own transform comes first.
    let p = s.instances[0].world_from_object.affine().point(vec3(1.0, 0.0, 0.0));
    assert_eq!(p, vec3(3.0, 0.0, 0.0));
    // One file is read once, whatever its entries make of it.
    assert_eq!(
        s.instances.iter().map(|i| (i.mesh, i.material)).collect::<Vec<_>>(),
        [(0, Some(0)), (0, Some(4)), (0, None)]
    );
    assert_eq!(loaded.warnings.len(), 1, "the OBJ's own unknown material: {:?}", loaded.warnings);
}

#[test]
fn materials_take_textures_of_all_kinds() {
    let scene = read(
        r#"{"eosphor": 2, "materials": {
            "leaf": {"pbr": {"color": [1, 0.5, 0], "ior": "water", "solid": true, "attenuation-distance": 2},
                "textures": {"color": "t.ppm", "opacity": "t.ppm", "emission": "t.ppm", "specular": "t.ppm",
                    "metallic": "t.ppm", "roughness": {"file": "t.ppm", "channel": "red"}, "transmission": "t.ppm",
                    "normal": {"file": "t.ppm", "uv-set": 1}, "normal-scale": 0.5},
                "alpha": {"mask": {}}},
            "pane": {"matte": {"colour": [1, 1, 1]}, "alpha": "blend"},
            "short": {"matte": {"color": [1, 1, 1]}, "texture": "t.ppm"}}}"#,
    )
    .unwrap()
    .scene;
    let MaterialKind::Pbr(pbr) = scene.materials[0].kind else { panic!() };
    assert_eq!((pbr.ior, pbr.solid, pbr.attenuation_distance, pbr.metallic), (1.333, true, Some(2.0), 0.0));
    let t = scene.materials[0].textures;
    let channels = [t.opacity, t.metallic, t.roughness, t.transmission].map(|c| c.unwrap());
    assert_eq!(channels.map(|c| c.channel), [Channel::Alpha, Channel::Blue, Channel::Red, Channel::Red]);
    // One image, and of it a texture of colours, one of data and one by the second coordinates.
    assert_eq!((scene.images.len(), scene.textures.len()), (1, 3));
    let content = |number: u32| scene.textures[number as usize].content;
    assert_eq!([t.color, t.emission, t.specular].map(|t| content(t.unwrap())), [TextureContent::Color; 3]);
    assert_eq!(channels.map(|c| content(c.texture)), [TextureContent::Data; 4]);
    let normal = t.normal.unwrap();
    assert_eq!((content(normal), scene.textures[normal as usize].uv_set), (TextureContent::Data, 1));
    assert_eq!((t.normal_scale, scene.materials[0].alpha), (0.5, AlphaMode::Mask { cutoff: 0.5 }));
    assert_eq!((scene.materials[1].alpha, scene.materials[2].textures.color), (AlphaMode::Blend, t.color));
}

#[test]
fn texture_coordinates_are_scaled_then_turned_then_moved() {
    let scene = read(
        r#"{"eosphor": 2, "materials": {"a": {"matte": {"color": [1, 1, 1]}, "texture": {"file": "t.ppm",
            "scale": [2, 3], "rotate-degrees": 90, "offset": [10, 20], "wrap-u": "mirror"}},
            "b": {"matte": {"color": [1, 1, 1]}, "texture": {"file": "t.ppm", "wrap": "mirror"}}}}"#,
    )
    .unwrap()
    .scene;
    let [u, v] = scene.textures[0].picture_from_mesh_uv;
    let at = |row: [f32; 3], u: f32, v: f32| row[0] * u + row[1] * v + row[2];
    // (1, 1) becomes (2, 3), a quarter turn takes that to (-3, 2), and (10, 20) is added.
    assert!((at(u, 1.0, 1.0) - 7.0).abs() < 1e-6 && (at(v, 1.0, 1.0) - 22.0).abs() < 1e-6);
    assert_eq!(
        (scene.textures[0].wrap_u, scene.textures[0].wrap_v),
        (TextureWrap::Mirror, TextureWrap::Repeat)
    );
    assert_eq!(
        (scene.textures[1].wrap_u, scene.textures[1].wrap_v),
        (TextureWrap::Mirror, TextureWrap::Mirror)
    );
}

#[test]
fn cameras_and_transforms_have_short_forms() {
    let camera =
        |text: &str| read(&format!("{{\"eosphor\": 2, \"camera\": {text}}}")).unwrap().scene.camera.unwrap();
    assert_eq!(camera(r#"{"fov-y-degrees": 30}"#).fov_y_degrees, Some(30.0));
    assert_eq!(
        camera(r#"{"orthographic-height": 3, "look-at": null, "direction": [1, 0, 0]}"#).direction.x,
        1.0
    );
    let scene = read(r#"{"eosphor": 2, "meshes": [{"file": "models/tri.obj", "transform": {"scale": -2}}]}"#);
    assert_eq!(scene.unwrap().scene.instances[0].world_from_object.scale, vec3(-2.0, -2.0, -2.0));
}

/// Scenes of the first version keep their look, and are told so once, where it makes a difference.
#[test]
fn the_old_version_has_its_old_units_of_light() {
    const LIT: &str = r#""lights": [{"point": {"position": [0, 1, 0], "color": [1, 1, 1]}}]"#;
    const LAMP: &str = r#""materials": {"lamp": {"emissive": {"radiance": [5, 5, 5]}}},
        "parallelograms": [{"corner": [0, 0, 0], "edge-u": [1, 0, 0], "edge-v": [0, 1, 0], "material": "lamp"}]"#;
    const BALL: &str = r#""spheres": [{"center": [0, 0, 0], "radius": 1}]"#;
    let units = |version: u32, part: &str| {
        let loaded = read(&format!("{{\n\"eosphor\": {version}, {part}}}")).unwrap();
        let notes: Vec<String> = loaded.warnings.iter().map(ToString::to_string).collect();
        (loaded.scene.settings.light_units, notes)
    };
    for part in [LIT, LAMP] {
        let (old, notes) = units(1, part);
        assert_eq!((old, notes.len()), (LightUnits::Plain, 1), "{notes:?}");
        let start = "dir/s.json:2: version 1 of the format: its light looks as it did";
        assert!(notes[0].starts_with(start) && notes[0].contains("docs/units.md"), "{notes:?}");
        assert_eq!(units(2, part), (LightUnits::Physical, vec![]));
    }
    assert_eq!(units(1, BALL), (LightUnits::Plain, vec![]));
    // Who says it needs no telling.
    for (word, units_said) in [("plain", LightUnits::Plain), ("physical", LightUnits::Physical)] {
        for version in [1, 2] {
            let said = format!(r#"{LIT}, "settings": {{"light-units": "{word}"}}"#);
            assert_eq!(units(version, &said), (units_said, vec![]));
        }
    }
}

/// A scene with a part in its second line.
fn scene_of(part: &str) -> String {
    format!("{{\"eosphor\": 2,\n{part}}}")
}

/// Reads a scene with such a part, in which a mark stands at the place of the error.
fn assert_wrong(marked: &str, message: &str) {
    let marked = scene_of(marked);
    let (before, after) = marked.split_once('§').unwrap();
    let problem = read(&format!("{before}{after}")).unwrap_err();
    let (lines, last) = before.rsplit_once('\n').unwrap();
    let (line, column) = (lines.lines().count() + 1, last.len() + 1);
    let expected = format!("dir/s.json:{line}:{column}: {message}");
    assert!(problem.to_string().starts_with(&expected), "{marked}\nsays     {problem}\nexpected {expected}");
    assert!(problem.snippet().is_some(), "{problem}");
}

#[test]
fn files_that_are_no_scenes() {
    for (text, expected) in [
        ("{}", "dir/s.json:1:1: this is no Eosphor scene; it needs the key \"eosphor\": 2"),
        ("[]", "dir/s.json:1:1: this is no Eosphor scene; it needs the key \"eosphor\": 2"),
        ("", "dir/s.json:1:1: the file is empty"),
        (
            "{\n\"eosphor\": 3, \"new\": 1}",
            "dir/s.json:2:12: this is version 3 of the format; the program reads versions 1 and 2",
        ),
        ("{\n\"eosphor\": \"1\"}", "dir/s.json:2:12: \"eosphor\" must be the version of the format, 2"),
        ("{\"eosphor\": 2,\n \"x\": }", "dir/s.json:2:7: a value is missing here"),
        ("\u{feff}{\"eosphor\": 2,\n}", "dir/s.json:2:1: the comma before this } is one too many"),
    ] {
        assert_eq!(error(text), expected, "{text}");
    }
    assert!(read("\u{feff}{\"eosphor\": 2}").is_ok());
    let files = vec![(PathBuf::from("s.json"), Cow::Borrowed(&b"{\n\"a\xff"[..]))];
    let problem = load_from(Source::Memory(files), Path::new("s.json"), &LoadOptions::default()).unwrap_err();
    assert_eq!(problem.to_string(), "s.json:2:3: the file is not UTF-8 text; save it as UTF-8");
}

/// Parts of a scene, with a mark at the place of the error, and the message.
const WRONG_FORM: &[(&str, &str)] = &[
    (r#"§"fov": 3"#, r#"unknown key "fov"; there are "eosphor", "$schema", "#),
    (r#""camera": {§"fov": 3}"#, r#"unknown key "fov"; did you mean "fov-x-degrees"?"#),
    (r#""camera": {§"lookAt": [0, 0, 0]}"#, r#"unknown key "lookAt"; did you mean "look-at"?"#),
    (r#""lights": [{§"spotlight": {}}]"#, r#"unknown key "spotlight"; did you mean "spot"?"#),
    (r#""lights": [{§"pont": {}}]"#, r#"unknown key "pont"; did you mean "point"?"#),
    (r#""lights": [§{}]"#, r#"one of "lights" is empty; give it "point", "directional" or "spot""#),
    (
        r#""lights": [{"spot": {}, §"point": {}}]"#,
        r#""spot" and "point" exclude each other; drop one of them"#,
    ),
    (r#""lights": [{"spot": {}, §"pint": {}}]"#, r#"unknown key "pint"; did you mean "point"?"#),
    (r#""lights": [{"point": §{"position": [0,0,0]}}]"#, r#""point" needs the key "color""#),
    (r#""settings": {"shadows": §"opaqe"}"#, r#""shadows" is "opaqe"; did you mean "opaque"?"#),
    (r#""settings": {"shadows": §"x"}"#, r#""shadows" is "x"; it must be "none", "opaque" or "coloured""#),
    (r#""settings": {"pixel-sampling": §"grid"}"#, r#""grid" needs contents: {"grid": ...}"#),
    (
        r#""settings": {"pixel-sampling": §""}"#,
        r#""pixel-sampling" is ""; it must be "center" or "random" or {"grid": ...}"#,
    ),
    (
        r#""settings": {"pixel-sampling": {§"center": 1}}"#,
        r#""center" stands alone, without { }: "pixel-sampling" is "center""#,
    ),
    (r#""settings": {"depth": 1, §"depth": 2}"#, r#""depth" is given twice"#),
    (r#""camera": §3"#, r#""camera" must be an object, not a number"#),
    (r#""lights": §{}"#, r#""lights" must be a list, not an object"#),
    (r#""materials": §[]"#, r#""materials" must be an object of names, not a list"#),
    (r#""spheres": [§7]"#, r#"one of "spheres" must be an object, not a number"#),
    (r#""spheres": §null"#, r#""spheres" must be a list, not null"#),
    (r#""settings": {"background": §"red"}"#, r#""background" must be 3 numbers, not a string"#),
    (r#""settings": {"background": §[1, 2]}"#, r#""background" must be 3 numbers, not 2"#),
    (
        r#""settings": {"background": [1, 2, §true]}"#,
        r#"one of "background" must be a number, not true or false"#,
    ),
    (r#""settings": {"size": §5}"#, r#""size" must be 2 whole numbers, not a number"#),
    (r#""settings": {"depth": §1.5}"#, r#""depth" must be a whole number, not 1.5"#),
    (r#""settings": {"depth": §1e1}"#, r#""depth" must be a whole number, not 1e1"#),
    (r#""settings": {"cull-back-faces": §1}"#, r#""cull-back-faces" must be true or false, not a number"#),
    (
        r#""settings": {"tone-curve": §"filmic"}"#,
        r#""tone-curve" is "filmic"; it must be "none", "aces", "agx" or "neutral""#,
    ),
    (r#""settings": {"transfer": §1}"#, r#""transfer" must be "srgb" or "linear", not a number"#),
    (
        r#""meshes": [{"file": "a.obj", "transform": {"scale": §"2"}}]"#,
        r#""scale" must be a number or 3 numbers, not a string"#,
    ),
    (
        r#""meshes": [{"file": "a.obj", "transform": {"matrix": §[1]}}]"#,
        r#""matrix" must be a list of 3 times 4 numbers, not 1"#,
    ),
    (r#""meshes": [§{"name": "a"}]"#, r#"one of "meshes" needs the key "file""#),
    (r#""settings": {"depth": §65}"#, r#""depth" is 65; it must be 0 to 64"#),
    (r#""settings": {"depth": §-1}"#, r#""depth" is -1; it must be 0 to 64"#),
    (r#""settings": {"seed": §4294967296}"#, r#""seed" is 4294967296; it must be 0 to 4294967295"#),
    (r#""settings": {"size": [§0, 5]}"#, r#"one of "size" is 0; it must be 1 to 65535"#),
    (r#""camera": {"fov-x-degrees": §180}"#, r#""fov-x-degrees" is 180; it must be over 0 and under 180"#),
    (r#""camera": {"orthographic-height": §0}"#, r#""orthographic-height" is 0; it must be over 0"#),
    (r#""spheres": [{"center": [0, 0, 0], "radius": §0}]"#, r#""radius" is 0; it must be over 0"#),
    (
        r#""spheres": [{"center": [0, 0, §1e39], "radius": 1}]"#,
        "1e39 is out of range; numbers must be within 1e12",
    ),
    (
        r#""spheres": [{"center": [0, 0, §-2e12], "radius": 1}]"#,
        "-2e12 is out of range; numbers must be within 1e12",
    ),
    (r#""settings": {"background": [0, §-1, 0]}"#, r#"one of "background" is -1; it must be 0 or more"#),
    (
        r#""camera": {§"direction": [0,0,1], "look-at": [0,0,0]}"#,
        r#""direction" does nothing beside "look-at"; drop "direction""#,
    ),
    (
        r#""camera": {"fov-y-degrees": 9, §"fov-x-degrees": 9}"#,
        r#""fov-x-degrees" does nothing beside "fov-y-degrees"; drop "fov-x-degrees""#,
    ),
    (
        r#""camera": {§"fov-y-degrees": 9, "orthographic-height": 9}"#,
        r#""fov-y-degrees" does nothing beside "orthographic-height"; drop "fov-y-degrees""#,
    ),
    (
        r#""camera": {§"fov-x-degrees": 9, "orthographic-height": 9}"#,
        r#""fov-x-degrees" does nothing beside "orthographic-height"; drop "fov-x-degrees""#,
    ),
];

#[test]
fn wrong_forms_name_the_place() {
    WRONG_FORM.iter().for_each(|(part, message)| assert_wrong(part, message));
}

/// Materials, with a mark at the place of the error, and the message.
const WRONG_MATERIALS: &[(&str, &str)] = &[
    ("§{}", r#""a" is of no kind; give it "mtl", "pbr", "#),
    (r#"§{"texture": "t.ppm"}"#, r#""a" is of no kind; give it "mtl", "pbr", "#),
    (r#"{§"matt": {"color": [1,1,1]}}"#, r#"unknown key "matt"; did you mean "matte"?"#),
    (r#"{"matte": §{}}"#, r#""matte" needs the key "color""#),
    (
        r#"{"matte": {"color": [1,1,1]}, §"mirror": {"reflectance": [1,1,1]}}"#,
        r#""matte" and "mirror" exclude each other; drop one of them"#,
    ),
    (r#"{"dielectric": {"ior": §"cheese"}}"#, r#""ior" is "cheese"; it must be "vacuum", "air", "#),
    (r#"{"dielectric": {"ior": §"watr"}}"#, r#""ior" is "watr"; did you mean "water"?"#),
    (
        r#"{"dielectric": {"ior": §true}}"#,
        r#""ior" must be a number or a name such as "vacuum", not true or false"#,
    ),
    (r#"{"dielectric": {"ior": §0}}"#, r#""ior" is 0; it must be 0.01 to 100"#),
    (r#"{"pbr": {§"rough": 0}}"#, r#"unknown key "rough"; did you mean "roughness"?"#),
    (r#"{"pbr": {"roughness": §2}}"#, r#""roughness" is 2; it must be 0 to 1"#),
    (
        r#"{"pbr": {}, "alpha": §"masked"}"#,
        r#""alpha" is "masked"; it must be "opaque" or "blend" or {"mask": ...}"#,
    ),
    (r#"{"pbr": {}, "alpha": {"mask": {"cutoff": §2}}}"#, r#""cutoff" is 2; it must be 0 to 1"#),
    (r#"{"pbr": {}, "texture": §5}"#, r#""texture" must be a string or an object, not a number"#),
    (r#"{"pbr": {}, "texture": {§"files": "t.ppm"}}"#, r#"unknown key "files"; did you mean "file"?"#),
    (
        r#"{"pbr": {}, "texture": {"file": "t.ppm", §"channel": "red"}}"#,
        r#"unknown key "channel"; there are "file", "filter", "wrap", "wrap-u", "wrap-v", "uv-set", "scale", "rotate-degrees" and "offset""#,
    ),
    (
        r#"{"pbr": {}, "texture": {"file": "t.ppm", §"wrap": "clamp", "wrap-u": "clamp"}}"#,
        r#""wrap" does nothing beside "wrap-u"; drop "wrap""#,
    ),
    (r#"{"pbr": {}, "texture": {"file": "t.ppm", "uv-set": §2}}"#, r#""uv-set" is 2; it must be 0 to 1"#),
    (
        r#"{"pbr": {}, "textures": {§"diffuse": "t.ppm"}}"#,
        r#"unknown key "diffuse"; there are "color", "opacity", "specular", "emission", "metallic", "roughness", "transmission", "normal" and "normal-scale""#,
    ),
    (
        r#"{"pbr": {}, "textures": {"color": "t.ppm"}, "texture": §"t.ppm"}"#,
        r#""texture" says the same as "color" of "textures"; drop one of them"#,
    ),
    (r#"{"pbr": {}, "texture": §"no.png"}"#, "texture: dir/no.png: cannot read: No such file"),
    (
        r#"{"pbr": {}, "textures": {"normal": {"file": §"no.png"}}}"#,
        "texture: dir/no.png: cannot read: No such file",
    ),
    (
        r#"{"pbr": {}, "texture": §"s.json"}"#,
        "texture: dir/s.json: this is no picture of a kind that is read: PNG, JPEG, PPM, HDR, EXR, BMP, TGA and .data",
    ),
];

#[test]
fn wrong_materials_name_the_place() {
    for (material, message) in WRONG_MATERIALS {
        assert_wrong(&format!("\"materials\": {{\"a\": {material}}}"), message);
    }
}

/// Parts of the right form that cannot be, with a mark at the place of the error, and the message.
const WRONG_CONTENTS: &[(&str, &str)] = &[
    (
        "\"materials\": {\"glass\": {\"pbr\": {}}},\n\"spheres\": [{\"center\": [0,0,0], \"radius\": 1,\n\"material\": §\"glas\"}]",
        r#"unknown material "glas"; did you mean "glass"?"#,
    ),
    (
        r#""spheres": [{"center": [0,0,0], "radius": 1, "material": §"x"}]"#,
        r#"unknown material "x"; there is none"#,
    ),
    (
        r#""parallelograms": [{"corner": [0,0,0], "edge-u": [1,0,0], "edge-v": [0,1,0], "material": §"x"}]"#,
        r#"unknown material "x"; there is none"#,
    ),
    (r#""instances": [{"mesh": §"a"}]"#, r#"unknown mesh "a"; there is none"#),
    (r#""meshes": [{"file": §"no.obj"}]"#, "mesh: dir/no.obj: cannot read: No such file"),
    (
        r#""meshes": [{"file": §"a.stl"}]"#,
        "a mesh must be an OBJ, glTF or PLY file: .obj, .gltf, .glb or .ply",
    ),
    (
        r#""meshes": [{"file": §"s.json"}]"#,
        "a mesh must be an OBJ, glTF or PLY file: .obj, .gltf, .glb or .ply",
    ),
    (r#""meshes": [{"file": "models/tri.obj", "material": §"x"}]"#, r#"unknown material "x"; there is none"#),
    (
        "\"meshes\": [{\"file\": \"models/tri.obj\", \"name\": \"a\"},\n{\"file\": \"models/tri.obj\", \"name\": §\"a\"}]",
        r#"another mesh has the name "a"; names must differ"#,
    ),
    (
        "\"meshes\": [{\"file\": \"models/tri.obj\"}, {\"file\": \"models/tri.obj\"}],\n\"instances\": [{\"mesh\": §\"tri\"}]",
        r#"two meshes are called "tri"; give each a "name" of its own"#,
    ),
    (
        "\"meshes\": [{\"file\": \"models/tri.obj\"}],\n\"instances\": [{\"mesh\": \"tri\", \"material\": §\"x\"}]",
        r#"unknown material "x"; there is none"#,
    ),
    (
        r#""meshes": [{"file": "models/tri.obj", "transform": §{"scale": 0}}]"#,
        "the transform squashes the mesh flat; no scale may be 0",
    ),
    (
        "\"meshes\": [{\"file\": \"models/tri.obj\"}],\n\"instances\": [{\"mesh\": \"tri\"}, {\"mesh\": \"tri\", \"transform\": §{\"scale\": [1,0,1]}}]",
        "the transform squashes the mesh flat; no scale may be 0",
    ),
    (
        "\"meshes\": [{\"file\": \"models/tri.obj\", \"transform\": {\"scale\": 1e12, \"matrix\": [[1e12,0,0,0],[0,1e12,0,0],[0,0,1e12,0]]}}],\n\"instances\": [§{\"mesh\": \"tri\", \"transform\": {\"scale\": 1e12, \"matrix\": [[1e12,0,0,0],[0,1e12,0,0],[0,0,1e12,0]]}}]",
        "instances[0]: its transform is not finite; use smaller numbers",
    ),
    (r#""frame": §3"#, "frame: there is no frame 3: nothing moves, so there is no animation"),
    (r#""frame": §3, "animation": {"frames": 3}"#, "frame: 3 is out of range; it must be 0 to 2"),
    (
        r#""camera": {"lens": §{"aperture-radius": 1}}"#,
        "camera.lens: which distance is sharp? Give focus-distance, or let the camera look-at a point",
    ),
    (
        r#""camera": {"position": [1,2,3], "look-at": §[1,2,3]}"#,
        r#""look-at" is the camera's own position; give a point before it"#,
    ),
    (
        r#""camera": {"up": §[1,0,0]}, "animation": {"frames": 2, "camera": {"laws": {"position": {"r": 2}, "look-at": {}}}}"#,
        r#""up" is parallel to the way the camera looks; give another"#,
    ),
    (
        r#""camera": {}, "animation": {"frames": 2, "camera": §{"laws": {"position": {"r": 2}, "look-at": {"r": 2}}}}"#,
        "in the first frame the camera looks at its own position; give another point",
    ),
    (
        r#""solids": [{"shape": §"ball", "center": [0,0,0], "radius": 1}]"#,
        r#""shape" is "ball"; it must be "tetrahedron", "cube", "octahedron", "dodecahedron" or "icosahedron""#,
    ),
    (
        r#""solids": [{"shape": "cube", "center": [0,0,0], "radius": 1, "lit-by": §{"edges": {}}}]"#,
        r#""lit-by" does nothing without lights along the edges"#,
    ),
    (
        r#""solids": [{"shape": "cube", "center": [0,0,0], "radius": 1, "lights-per-edge": §1001}]"#,
        r#""lights-per-edge" is 1001; it must be 0 to 1000"#,
    ),
    (
        r#""solids": [{"shape": "cube", "center": [1e12,0,0], "radius": §1e12}]"#,
        "cube: radius: the radius must be over 0, and the body within 1e12 of the origin",
    ),
    (
        r#""quadrilaterals": [{"corners": §[[0,0,0], [1,0,0], [2,0,0], [3,0,0]]}]"#,
        "the corners lie on one line; they must span a surface",
    ),
    (
        r#""quadrilaterals": [{"corners": §[[0,0,0], [1,0,0], [2,0,0]]}]"#,
        r#""corners" must be a list of 4 times 3 numbers, not 3"#,
    ),
    (
        r#""materials": {"a": {"matte": {"color": [1,1,1]}, "texture": §"builtin:marble"}}"#,
        r#"texture: builtin:marble: there is no built-in picture "marble"; there are parquet and studio"#,
    ),
    (r#""camera": {"direction": §[0,0,0]}"#, r#""direction" has no length; give the way the camera looks"#),
    (r#""camera": {"up": §[0,0,0]}"#, r#""up" has no length; give the way to the top of the picture"#),
    (r#""camera": {"up": §[0,0,2]}"#, r#""up" is parallel to the way the camera looks; give another"#),
    (r#""camera": §{"direction": [0,1,0]}"#, r#""up" is parallel to the way the camera looks; give another"#),
    (
        r#""lights": [{"directional": {"direction": §[0,0,0], "color": [1,1,1]}}]"#,
        "lights[0].direction: it has no length; give the way the light goes",
    ),
    (
        r#""lights": [{"spot": {"position": [0,0,0], "direction": [1,0,0], "inner-degrees": 0, "outer-degrees": §0, "color": [1,1,1]}}]"#,
        r#""outer-degrees" is 0; it must be over 0 and at most 180"#,
    ),
    (
        r#""lights": [{"spot": {"position": [0,0,0], "direction": [1,0,0], "inner-degrees": §30, "outer-degrees": 20, "color": [1,1,1]}}]"#,
        "lights[0].inner-degrees: 30 is out of range; it must be 0 to 20",
    ),
    (
        r#""parallelograms": [{"corner": [0,0,0], "edge-u": [1,0,0], "edge-v": §[-2,0,0]}]"#,
        r#""edge-v" is parallel to "edge-u"; the edges must span a surface"#,
    ),
    (
        r#""parallelograms": [{"corner": [0,0,0], "edge-u": §[0,0,0], "edge-v": [2,0,0]}]"#,
        r#""edge-u" has no length; give the way from the corner to the next"#,
    ),
];

#[test]
fn wrong_contents_name_the_place() {
    WRONG_CONTENTS.iter().for_each(|(part, message)| assert_wrong(part, message));
    // What is wrong inside another file is said with its place there.
    let message = error(&scene_of("\"meshes\": [{\"file\": \"bad.obj\"}]"));
    assert!(message.starts_with("dir/bad.obj:2: "), "{message}");
}

#[test]
fn errors_show_the_line() {
    let text = "{\n  \"eosphor\": 2,\n\t\"settings\": {\"depth\": 65}\n}";
    let problem = read(text).unwrap_err();
    let shown = problem.snippet().unwrap().to_string();
    assert_eq!(shown, " 3 |  \"settings\": {\"depth\": 65}\n   |                        ^");
}

#[test]
fn names_of_the_file_stay_in_one_line() {
    let message = error(&scene_of("\"a\\nb\\u001b\": 1"));
    assert!(message.contains("unknown key \"a b \"; "), "{message}");
    let message = error(&scene_of(&format!("\"{}\": 1", "x".repeat(5000))));
    assert!(message.len() < 400, "{message}");
}

#[test]
fn without_textures_none_are_read() {
    let text = scene_of(
        "\"materials\": {\"a\": {\"pbr\": {}, \"textures\": {\"color\": \"no.png\", \"opacity\": \"no.png\"}}}",
    );
    let files = vec![(PathBuf::from("s.json"), Cow::Owned(text.into_bytes()))];
    let scene = load_from(
        Source::Memory(files),
        Path::new("s.json"),
        &LoadOptions { textures: false, ..LoadOptions::default() },
    )
    .unwrap()
    .scene;
    assert!(scene.textures.is_empty() && scene.images.is_empty());
}

/// A mesh's own motion comes before the transform and the motion of what places it.
#[test]
fn moves_are_applied_in_order() {
    let mesh = r#""meshes": [{"file": "models/tri.obj", "moves": [{"keys": [
        {"seconds": 0, "translate": [1, 0, 0]}, {"seconds": 1, "translate": [2, 0, 0]}]}]}]"#;
    let scene = read(&format!(
        r#"{{"eosphor": 2, {mesh}, "animation": {{"frames": 2, "fps": 1}},
        "instances": [{{"mesh": "tri", "transform": {{"scale": 3}},
                        "moves": [{{"keys": [{{"seconds": 0, "scale": 2, "rotate-degrees": [0, 0, 90]}}]}}]}}]}}"#
    ))
    .unwrap()
    .scene;
    let origin_in = |frame| {
        let (data, _) = SceneData::flatten(&scene).unwrap();
        let places = FrameStates::new(&scene, &data).at(frame).unwrap().places.unwrap();
        places.instances[1].world_from_object.translation
    };
    assert!((origin_in(0) - vec3(0.0, 6.0, 0.0)).length() < 1e-5, "{:?}", origin_in(0));
    assert!((origin_in(1) - vec3(0.0, 12.0, 0.0)).length() < 1e-5);
    for (moves, reason) in [
        (r#"[{"keys": [{"seconds": 1}, {"seconds": 1}]}]"#, "in the order of their seconds"),
        (r#"[{"keys": [{"seconds": 1, "rotation": [0, 0, 0, 0]}]}]"#, "says no rotation"),
        (r#"[{"keys": [{"seconds": 1, "translate": [1e12, 0, 0]}]}]"#, "out of range"),
        (r#"[{"transform": {"scale": 0}}]"#, "squashes things flat"),
        (r#"[{"key": []}]"#, "unknown key \"key\""),
    ] {
        let text = format!(
            "{{\"eosphor\": 2,\n\"meshes\": [{{\"file\": \"models/tri.obj\"}}],\n\
             \"instances\": [{{\"mesh\": \"tri\", \"moves\": {moves}}}]}}"
        );
        let message = error(&text);
        assert!(message.contains(reason) && message.contains("s.json:3"), "{moves}: {message}");
    }
}
