//! A document with every member that is read, and every value of every enumeration.

use serde_json::{Value, json};

/// The document. `raw` says whether it has the extensions that the crate keeps as they are.
pub(super) fn document(raw: bool) -> Value {
    let mut document = json!({
        "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}],
        "extensionsUsed": ["KHR_materials_ior"], "extensionsRequired": ["KHR_texture_transform"],
        "accessors": all((0..42).map(accessor)), "animations": [animation()],
        "buffers": [{"name": "b", "uri": "b.bin", "byteLength": 9}],
        "bufferViews": [{"name": "v", "buffer": 0, "byteOffset": 4, "byteLength": 5, "byteStride": 12}],
        "cameras": all(["perspective", "orthographic"].map(camera)),
        "images": [{"name": "i", "uri": "i.png", "bufferView": 1}],
        "materials": all(["OPAQUE", "MASK", "BLEND"].map(|mode| material(mode, raw))),
        "meshes": [{"name": "m", "weights": [0.5, 0.25], "primitives": all((0..7).map(|mode| primitive(mode, raw)))}],
        "nodes": [node()],
        "skins": [{"name": "s", "joints": [2, 1], "inverseBindMatrices": 6, "skeleton": 1}],
        "samplers": [{"magFilter": 9728, "wrapS": 33_071, "wrapT": 33_648},
            {"magFilter": 9729, "wrapS": 33_648, "wrapT": 10_497}, {"magFilter": 9729, "wrapS": 10_497, "wrapT": 33_071}],
        "textures": [{"name": "t", "sampler": 0, "source": 1,
            "extensions": {"KHR_texture_basisu": {"source": 2}, "EXT_texture_webp": {"source": 3}}}],
        "extensions": {"KHR_lights_punctual": {"lights": all(["directional", "point", "spot"].map(light))}},
    });
    if raw {
        document["nodes"][0]["extensions"]["EXT_mesh_gpu_instancing"] =
            json!({"attributes": {"TRANSLATION": 5, "ROTATION": 6, "SCALE": 7}});
    }
    document
}

/// The number of an accessor chooses among the types.
fn accessor(number: usize) -> Value {
    let kind = ["SCALAR", "VEC2", "VEC3", "VEC4", "MAT2", "MAT3", "MAT4"][number % 7];
    let component = [5120, 5121, 5122, 5123, 5125, 5126][number / 7];
    let index = [5121, 5123, 5125][number % 3];
    json!({"name": "a", "bufferView": 1, "byteOffset": 8, "count": number, "componentType": component, "type": kind,
        "normalized": number < 21, "sparse": {"count": 2,
            "indices": {"bufferView": 3, "byteOffset": 4, "componentType": index},
            "values": {"bufferView": 5, "byteOffset": 6}}})
}

fn all(items: impl IntoIterator<Item = Value>) -> Value {
    items.into_iter().collect()
}

fn animation() -> Value {
    let channel = |path| json!({"sampler": 1, "target": {"node": 2, "path": path}});
    let sampler = |name| json!({"input": 1, "output": 2, "interpolation": name});
    json!({"name": "walk", "channels": all(["translation", "rotation", "scale", "weights"].map(channel)),
        "samplers": all(["LINEAR", "STEP", "CUBICSPLINE"].map(sampler))})
}

fn camera(kind: &str) -> Value {
    json!({"name": kind, "type": kind, "perspective": {"yfov": 0.7, "znear": 0.1},
        "orthographic": {"xmag": 3, "ymag": 2.5, "zfar": 2, "znear": 1}})
}

fn light(kind: &str) -> Value {
    json!({"name": kind, "type": kind, "color": [1, 0.5, 0.25], "intensity": 4.5,
        "spot": {"innerConeAngle": 0.25, "outerConeAngle": 0.5}})
}

fn primitive(mode: u32, raw: bool) -> Value {
    let mut primitive = json!({"attributes": {"POSITION": 0, "NORMAL": 1, "TEXCOORD_0": 2, "TEXCOORD_1": 3, "COLOR_0": 4, "TANGENT": 5,
            "JOINTS_0": 10, "WEIGHTS_0": 11, "JOINTS_1": 12, "WEIGHTS_1": 13},
        "indices": 6, "material": 1, "mode": mode, "targets": [{"POSITION": 7, "NORMAL": 8, "TANGENT": 9}]});
    if raw {
        primitive["extensions"] = json!({"KHR_draco_mesh_compression": {}});
    }
    primitive
}

fn node() -> Value {
    json!({"name": "n", "children": [1, 2], "mesh": 3, "camera": 4, "skin": 5, "weights": [0.5, 1],
        "matrix": [1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16], "translation": [0.1, 2, -0.0],
        "rotation": [0.1, 0.2, 0.3, 0.9], "scale": [1, 2.5, 1e-3], "extensions": {"KHR_lights_punctual": {"light": 1}}})
}

fn material(alpha_mode: &str, raw: bool) -> Value {
    let texture = |index: u32| {
        json!({"index": index, "texCoord": 1, "extensions": {"KHR_texture_transform": {
            "offset": [0.5, 0.25], "rotation": 0.75, "scale": [2, 3], "texCoord": 1}}})
    };
    let mut normal = json!({"index": 2, "texCoord": 1, "scale": 0.5});
    if raw {
        normal["extensions"] = texture(0)["extensions"].clone();
    }
    json!({"name": "m", "alphaMode": alpha_mode, "alphaCutoff": 0.25, "doubleSided": true,
        "emissiveFactor": [0.1, 0.2, 0.3], "emissiveTexture": texture(1), "normalTexture": normal,
        "occlusionTexture": {"index": 3, "strength": 0.5},
        "pbrMetallicRoughness": {"baseColorFactor": [0.1, 0.2, 0.3, 0.4], "baseColorTexture": texture(4),
            "metallicFactor": 0.3, "roughnessFactor": 0.4, "metallicRoughnessTexture": texture(5)},
        "extensions": {
            "KHR_materials_emissive_strength": {"emissiveStrength": 8},
            "KHR_materials_ior": {"ior": 1.33},
            "KHR_materials_pbrSpecularGlossiness": {"diffuseFactor": [0.5, 0.6, 0.7, 0.8],
                "diffuseTexture": texture(6), "specularFactor": [0.2, 0.3, 0.4], "glossinessFactor": 0.9},
            "KHR_materials_specular": {"specularFactor": 0.5, "specularTexture": texture(7),
                "specularColorFactor": [2, 1, 0], "specularColorTexture": texture(8)},
            "KHR_materials_transmission": {"transmissionFactor": 0.75, "transmissionTexture": texture(9)},
            "KHR_materials_unlit": {},
            "KHR_materials_volume": {"thicknessFactor": 0.1, "thicknessTexture": texture(10),
                "attenuationDistance": 3, "attenuationColor": [1, 0.5, 0.25]}}})
}
