//! Which extensions are read, and what is said of the others.

use super::document::Document;
use crate::files::warnings::Warnings;
use std::path::Path;

/// Read, as README.md beside this file says.
const READ: [&str; 11] = [
    "KHR_lights_punctual",
    "KHR_materials_emissive_strength",
    "KHR_materials_ior",
    "KHR_materials_pbrSpecularGlossiness",
    "KHR_materials_specular",
    "KHR_materials_transmission",
    "KHR_materials_unlit",
    "KHR_materials_volume",
    "KHR_mesh_quantization",
    "KHR_texture_transform",
    "EXT_mesh_gpu_instancing",
];

/// Not read, and the picture would be another; with what is done instead.
const NOT_RENDERED: [(&str, &str); 10] = [
    ("KHR_materials_clearcoat", "surfaces have no coat"),
    ("KHR_materials_sheen", "cloth has no sheen"),
    ("KHR_materials_iridescence", "thin films have no colours"),
    ("KHR_materials_anisotropy", "reflections are equally rough in all directions"),
    ("KHR_materials_dispersion", "all colours are refracted alike"),
    ("KHR_materials_diffuse_transmission", "no light comes through diffusely"),
    ("KHR_materials_volume_scatter", "bodies do not scatter light"),
    ("KHR_node_visibility", "hidden nodes are shown"),
    ("EXT_lights_image_based", "give the surroundings by other means"),
    ("EXT_lights_ies", "lights shine evenly"),
];

/// Not read; textures that have no other picture say so themselves.
const PICTURES: [&str; 4] =
    ["KHR_texture_basisu", "EXT_texture_webp", "EXT_texture_avif", "MSFT_texture_dds"];

/// Not read; the channels that need it say so themselves.
const POINTERS: &str = "KHR_animation_pointer";

/// Refuses what the file cannot be shown without.
pub(super) fn check(root: &Document) -> Result<(), String> {
    let is_known = |name: &str| {
        READ.contains(&name)
            || PICTURES.contains(&name)
            || name == POINTERS
            || NOT_RENDERED.iter().any(|(known, _)| *known == name)
    };
    match root.extensions_required.iter().find(|name| !is_known(name)) {
        Some(name) => {
            let name: String = super::clean(name).chars().take(100).collect();
            Err(format!("{name} is required and not supported; export without it"))
        }
        None => Ok(()),
    }
}

/// One warning for each extension that the picture lacks.
pub(super) fn warn(warnings: &mut Warnings, path: &Path, root: &Document) {
    let names = || root.extensions_used.iter().chain(&root.extensions_required);
    for (name, instead) in NOT_RENDERED {
        if names().any(|used| used == name) {
            warnings.add(path, None, format!("{name} is not rendered; {instead}"));
        }
    }
}
