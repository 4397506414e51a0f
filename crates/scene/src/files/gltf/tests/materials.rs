//! Materials, textures and pictures.

use super::{File, read, read_with, triangle, whitted};
use crate::files::{LoadOptions, LoadedScene};
use crate::model::{
    AlphaMode, Channel, Material, MaterialKind, Pbr, Texture, TextureChannel, TextureContent,
};
use eosphor_core::math::{Vec3, vec3};
use eosphor_core::settings::ShadowMode;
use eosphor_core::texture::{TextureFilter, TextureWrap};
use serde_json::{Value, json};

const RED: &[u8] = b"P3\n1 1\n255\n255 0 0\n";

/// A triangle in a material, with more keys of the root; `t.ppm` is a picture.
fn load(material: Value, more: Value) -> LoadedScene {
    load_with(material, more, &LoadOptions::default())
}

fn load_with(material: Value, more: Value, options: &LoadOptions) -> LoadedScene {
    let mut file = triangle(more);
    file.root["materials"] = json!([material]);
    file.root["meshes"][0]["primitives"][0]["material"] = 0.into();
    read_with(&[("a.glb", &file.glb()), ("t.ppm", RED), ("u.ppm", RED)], options).unwrap()
}

fn plain(material: Value) -> (Material, Pbr) {
    let material = load(material, json!({})).scene.materials.remove(0);
    let MaterialKind::Pbr(pbr) = material.kind else { panic!("{material:?}") };
    (material, pbr)
}

/// One texture of one picture.
fn textures() -> Value {
    json!({"images": [{"uri": "t.ppm"}], "textures": [{"source": 0}]})
}

#[test]
fn factors_and_extensions() {
    let (material, pbr) = plain(json!({"name": "m", "emissiveFactor": [0.5, 0.25, 0],
        "pbrMetallicRoughness": {"baseColorFactor": [0.1, 0.2, 2, 0.5], "metallicFactor": 0.25, "roughnessFactor": -1},
        "extensions": {
            "KHR_materials_emissive_strength": {"emissiveStrength": 8},
            "KHR_materials_ior": {"ior": 1.33},
            "KHR_materials_specular": {"specularFactor": 0.5, "specularColorFactor": [2, 1, 0]},
            "KHR_materials_transmission": {"transmissionFactor": 0.75},
            "KHR_materials_volume": {"thicknessFactor": 0.1, "attenuationDistance": 3, "attenuationColor": [1, 0.5, 0]}}}));
    assert_eq!((material.name.as_str(), material.alpha), ("m", AlphaMode::Opaque));
    let expected = Pbr {
        color: vec3(0.1, 0.2, 1.0),
        opacity: 0.5,
        metallic: 0.25,
        roughness: 0.0,
        emission: vec3(4.0, 2.0, 0.0),
        ior: 1.33,
        specular: 0.5,
        specular_color: vec3(2.0, 1.0, 0.0),
        transmission: 0.75,
        solid: true,
        attenuation_color: vec3(1.0, 0.5, 0.0),
        attenuation_distance: Some(3.0),
    };
    assert_eq!(pbr, expected);
    // Defaults: a rough white metal, thin, whatever is left out.
    let rough_metal = Pbr { metallic: 1.0, ..Pbr::default() };
    assert_eq!(plain(json!({})).1, rough_metal);
    let volume = json!({"extensions": {"KHR_materials_volume": {}, "KHR_materials_ior": {"ior": 0}}});
    assert_eq!(plain(volume).1, Pbr { ior: 100.0, ..rough_metal });
    let default = triangle(json!({})).load().scene.materials;
    assert_eq!((default.len(), default[0].kind), (1, MaterialKind::Pbr(rough_metal)));
}

#[test]
fn alpha_modes_and_coloured_shadows() {
    let alpha = |material: Value| {
        let scene = load_with(material, textures(), &whitted()).scene;
        (scene.materials[0].alpha, scene.materials[0].textures.opacity, scene.settings.shadows)
    };
    let base = json!({"baseColorTexture": {"index": 0}});
    let of_texture = Some(TextureChannel { texture: 0, channel: Channel::Alpha });
    assert_eq!(alpha(json!({"pbrMetallicRoughness": base})), (AlphaMode::Opaque, None, ShadowMode::Opaque));
    let mask = |cutoff| (AlphaMode::Mask { cutoff }, of_texture, ShadowMode::Coloured);
    assert_eq!(alpha(json!({"pbrMetallicRoughness": base, "alphaMode": "MASK"})), mask(0.5));
    assert_eq!(
        alpha(json!({"pbrMetallicRoughness": base, "alphaMode": "MASK", "alphaCutoff": 0.25})),
        mask(0.25)
    );
    assert_eq!(alpha(json!({"alphaMode": "BLEND"})), (AlphaMode::Blend, None, ShadowMode::Coloured));
    let glass = json!({"extensions": {"KHR_materials_transmission": {"transmissionFactor": 1}}});
    assert_eq!(alpha(glass), (AlphaMode::Opaque, None, ShadowMode::Coloured));
}

#[test]
fn textures_by_channel_and_content() {
    let info = |index: u32| json!({"index": index});
    let material = json!({
        "pbrMetallicRoughness": {"baseColorTexture": info(0), "metallicRoughnessTexture": info(0)},
        "normalTexture": {"index": 1, "scale": 0.5}, "emissiveTexture": info(1), "emissiveFactor": [1, 1, 1],
        "occlusionTexture": info(0),
        "extensions": {"KHR_materials_transmission": {"transmissionFactor": 1, "transmissionTexture": info(0)},
            "KHR_materials_specular": {"specularTexture": info(0)}}});
    let more = json!({"images": [{"uri": "t.ppm"}, {"uri": "./t.ppm"}], "textures": [{"source": 0},
        {"source": 1, "sampler": 0}], "samplers": [{"magFilter": 9728, "wrapS": 33071, "wrapT": 33648}]});
    let loaded = load_with(material.clone(), more.clone(), &whitted());
    let scene = &loaded.scene;
    let (textures, all) = (scene.materials[0].textures, &scene.textures);
    let texture = |number: Option<u32>| all[number.unwrap() as usize];
    assert_eq!(texture(textures.color), Texture::of_image(0));
    let data = Texture { content: TextureContent::Data, ..Texture::of_image(0) };
    for (channel, expected) in [
        (textures.metallic, Channel::Blue),
        (textures.roughness, Channel::Green),
        (textures.transmission, Channel::Red),
    ] {
        let channel = channel.unwrap();
        assert_eq!((texture(Some(channel.texture)), channel.channel), (data, expected));
    }
    let sampled = Texture {
        filter: TextureFilter::Nearest,
        wrap_u: TextureWrap::Clamp,
        wrap_v: TextureWrap::Mirror,
        ..texture(textures.normal)
    };
    assert_eq!(texture(textures.normal), Texture { content: TextureContent::Data, ..sampled });
    assert_eq!(texture(textures.emission), Texture { content: TextureContent::Color, ..sampled });
    assert_eq!((textures.normal_scale, textures.specular, textures.opacity), (0.5, None, None));
    let warnings: Vec<String> = loaded.warnings.iter().map(|w| w.to_string()).collect();
    assert_eq!(
        warnings,
        [
            "a.glb: occlusion textures are not rendered",
            "a.glb: the textures of KHR_materials_specular are not rendered; its factors are",
        ]
    );
    // Without textures nothing is read, and nothing shines all over.
    let options = LoadOptions { textures: false, ..LoadOptions::default() };
    let scene = load_with(material, more, &options).scene;
    assert_eq!((scene.images.len(), scene.textures.len()), (0, 0));
    assert_eq!(scene.materials[0].emission(), Vec3::ZERO);
}

#[test]
fn texture_transforms_and_sets() {
    let transform = json!({"KHR_texture_transform": {"offset": [0.5, 0.25], "scale": [2, 4], "texCoord": 1}});
    let material = json!({
        "pbrMetallicRoughness": {"baseColorTexture": {"index": 0, "extensions": transform},
            "metallicRoughnessTexture": {"index": 0, "texCoord": 3}},
        "normalTexture": {"index": 0, "extensions": transform}, "emissiveTexture": {"index": 0, "texCoord": 1}});
    let loaded = load(material, textures());
    let textures = loaded.scene.materials[0].textures;
    let texture = |number: u32| loaded.scene.textures[number as usize];
    for number in [textures.color.unwrap(), textures.normal.unwrap()] {
        let t = texture(number);
        assert_eq!(t.uv_set, 1);
        // (0.25, 0.125) from the top goes to (1, 0.75) from the top.
        let [u, v] = t.picture_from_mesh_uv.map(|row| row[0] * 0.25 + row[1] * 0.875 + row[2]);
        assert_eq!([u, v], [1.0, 0.25]);
    }
    assert_eq!(texture(textures.emission.unwrap()).uv_set, 1);
    assert_eq!(texture(textures.metallic.unwrap().texture).uv_set, 0);
    assert_eq!(
        loaded.warnings[0].to_string(),
        "a.glb: texture coordinates 3 are not read, only 0 and 1; texture 0 takes 0"
    );
}

#[test]
fn pictures_in_files_views_and_uris() {
    let mut file = triangle(json!({}));
    let view = file.view(RED, None);
    file.root["images"] = json!([{"uri": "dir/t%20t.ppm"}, {"bufferView": view}, {"uri": "dir/t t.ppm"},
        {"uri": "data:image/x,P3%0A1%201%0A255%0A0%200%20255%0A"}, {"uri": "no.png", "name": "gone"},
        {"bufferView": view, "name": "view"}, {"bufferView": 0}, {}, {"uri": "dir/t%20t.ppm"}]);
    let textures: Vec<Value> = (0..9).map(|i| json!({"source": i})).collect();
    file.root["textures"] = textures.into();
    push_texture(&mut file, json!({"extensions": {"KHR_texture_basisu": {"source": 0}}}));
    push_texture(&mut file, json!({}));
    let of = |i: u32| json!({"pbrMetallicRoughness": {"baseColorTexture": {"index": i}}});
    let all: Vec<Value> = (0..12).map(of).collect();
    file.root["materials"] = all.into();
    let primitives: Vec<Value> =
        (0..12).map(|i| json!({"attributes": {"POSITION": 0}, "material": i})).collect();
    file.root["meshes"][0]["primitives"] = primitives.into();
    let loaded = read(&[("a.glb", &file.glb()), ("dir/t t.ppm", RED)]).unwrap();
    let scene = &loaded.scene;
    let image = |m: &Material| m.textures.color.map(|t| scene.textures[t as usize].image);
    let images: Vec<Option<u32>> = scene.materials.iter().map(image).collect();
    let none = [None; 3];
    assert_eq!(images[..6], [Some(0), Some(1), Some(0), Some(2), None, Some(1)]);
    assert_eq!(images[6..], [none[0], none[1], Some(0), none[0], none[1], none[2]]);
    let names: Vec<&str> = scene.images.iter().map(|i| i.name.as_str()).collect();
    assert_eq!(names, ["t t.ppm", "image 1", "image 3"]);
    let warnings: Vec<String> = loaded.warnings.iter().map(|w| w.to_string()).collect();
    let not_a_picture =
        warnings.iter().position(|w| w.starts_with("a.glb: image 6: this is no picture")).unwrap();
    let others: Vec<&str> =
        warnings.iter().enumerate().filter(|(i, _)| *i != not_a_picture).map(|(_, w)| w.as_str()).collect();
    assert_eq!(
        others,
        [
            "a.glb: image \"gone\": \"no.png\" is missing; put it beside the glTF; the surface is untextured",
            "a.glb: image 7: it has neither a uri nor a bufferView; the surface is untextured",
            "a.glb: texture 9 is there as KHR_texture_basisu only, which is not read; the surface is untextured; \
             export it as PNG or JPEG",
            "a.glb: texture 10 has no picture; the surface is untextured",
            "a.glb: texture 11 does not exist; the surface is untextured",
        ]
    );
}

fn push_texture(file: &mut File, texture: Value) {
    super::push(&mut file.root["textures"], texture);
}

#[test]
fn unlit_shines_without_being_a_light() {
    let material = |more: Value| {
        let mut material = json!({"pbrMetallicRoughness": {"baseColorFactor": [1, 0.5, 0, 1]},
                                  "extensions": {"KHR_materials_unlit": {}}});
        for (key, value) in more.as_object().unwrap() {
            material["pbrMetallicRoughness"][key] = value.clone();
        }
        load_with(material, textures(), &whitted()).scene
    };
    for (more, images) in [(json!({}), ["white"]), (json!({"baseColorTexture": {"index": 0}}), ["t.ppm"])] {
        let scene = material(more);
        let MaterialKind::Pbr(pbr) = scene.materials[0].kind else { panic!() };
        assert_eq!((pbr.color, pbr.emission, pbr.specular), (Vec3::ZERO, vec3(1.0, 0.5, 0.0), 0.0));
        let texture = scene.textures[scene.materials[0].textures.emission.unwrap() as usize];
        assert_eq!(scene.images[texture.image as usize].name, images[0]);
        // It is no light, so the surroundings are lit.
        assert_eq!(scene.settings.ambient, 0.25);
    }
}

#[test]
fn specular_glossiness_is_converted_where_it_stands_alone() {
    let glossy = json!({"KHR_materials_pbrSpecularGlossiness": {"diffuseFactor": [0.5, 1, 0, 0.5],
        "specularFactor": [0.2, 0, 0], "glossinessFactor": 0.75, "diffuseTexture": {"index": 0}}});
    let loaded = load(json!({"extensions": glossy}), textures());
    let MaterialKind::Pbr(pbr) = loaded.scene.materials[0].kind else { panic!() };
    assert_eq!((pbr.opacity, pbr.metallic, pbr.roughness), (0.5, 0.0, 0.25));
    assert!((pbr.color - vec3(0.4, 0.8, 0.0)).length() < 1e-6);
    // 0.04 of a reflectance times this is the specular colour.
    assert!((pbr.specular_color - vec3(5.0, 0.0, 0.0)).length() < 1e-5);
    assert_eq!(loaded.scene.materials[0].textures.color, Some(0));
    assert_eq!(loaded.warnings.len(), 1);
    let both = json!({"extensions": glossy, "pbrMetallicRoughness": {"metallicFactor": 0.5}});
    let loaded = load(both, textures());
    let MaterialKind::Pbr(pbr) = loaded.scene.materials[0].kind else { panic!() };
    assert_eq!((pbr, loaded.warnings.len()), (Pbr { metallic: 0.5, ..Pbr::default() }, 0));
}
