//! Materials, their textures and extensions.

use super::{known, same};
use crate::files::gltf::document::{Document, Material, MaterialExtensions, TextureInfo, TextureTransform};
use gltf::json::extensions::material::Material as CrateExtensions;
use gltf::json::extensions::texture::TextureTransform as CrateTransform;
use gltf::json::material::Material as CrateMaterial;
use gltf::json::texture::Info;
use gltf::json::{Root, deserialize};

pub(super) fn agree(ours: &Document, theirs: &Root) {
    for (i, (a, b)) in ours.materials.iter().zip(&theirs.materials).enumerate() {
        let place = &format!("material {i}");
        core(place, a, b);
        same(place, a.extensions.is_some(), b.extensions.is_some());
        if let (Some(a), Some(b)) = (&a.extensions, &b.extensions) {
            reflection(place, a, b);
            transmission(place, a, b);
        }
    }
}

fn core(place: &str, a: &Material, b: &CrateMaterial) {
    same(
        place,
        (
            &a.name,
            a.alpha_mode,
            a.alpha_cutoff,
            a.double_sided,
            a.emissive_factor,
            a.occlusion_texture.is_some(),
        ),
        (
            &b.name,
            known(&b.alpha_mode),
            b.alpha_cutoff.map(|x| x.0),
            b.double_sided,
            b.emissive_factor.0,
            b.occlusion_texture.is_some(),
        ),
    );
    info(place, &a.emissive_texture, &b.emissive_texture);
    let normal = a.normal_texture.as_ref();
    let normal = normal.map(|t| {
        let transform = t.extensions.as_ref().and_then(|e| e.transform.as_ref());
        (t.index.value(), t.tex_coord, t.scale, transform.map(parts))
    });
    let of_crate = b.normal_texture.as_ref().map(|t| {
        // The crate knows this extension of other textures only.
        let transform = t.extensions.as_ref().and_then(|e| e.others.get("KHR_texture_transform"));
        let transform: Option<CrateTransform> =
            transform.map(|value| deserialize::from_value(value.clone()).unwrap());
        (t.index.value(), t.tex_coord, t.scale, transform.as_ref().map(crate_parts))
    });
    same(place, normal, of_crate);
    let (a, b) = (&a.pbr_metallic_roughness, &b.pbr_metallic_roughness);
    same(
        place,
        (a.base_color_factor, a.metallic_factor, a.roughness_factor),
        (b.base_color_factor.0, b.metallic_factor.0, b.roughness_factor.0),
    );
    info(place, &a.base_color_texture, &b.base_color_texture);
    info(place, &a.metallic_roughness_texture, &b.metallic_roughness_texture);
}

fn reflection(place: &str, a: &MaterialExtensions, b: &CrateExtensions) {
    same(
        place,
        (
            a.emissive_strength.as_ref().map(|e| e.emissive_strength),
            a.ior.as_ref().map(|e| e.ior),
            a.unlit.is_some(),
        ),
        (
            b.emissive_strength.as_ref().map(|e| e.emissive_strength.0),
            b.ior.as_ref().map(|e| e.ior.0),
            b.unlit.is_some(),
        ),
    );
    let specular = a.specular.as_ref().map(|e| {
        let has_textures = (e.specular_texture.is_some(), e.specular_color_texture.is_some());
        (e.specular_factor, e.specular_color_factor, has_textures)
    });
    let of_crate = b.specular.as_ref().map(|e| {
        let has_textures = (e.specular_texture.is_some(), e.specular_color_texture.is_some());
        (e.specular_factor.0, e.specular_color_factor.0, has_textures)
    });
    same(place, specular, of_crate);
    let glossy = a.specular_glossiness.as_ref();
    let of_crate = b.pbr_specular_glossiness.as_ref();
    same(
        place,
        glossy.map(|e| (e.diffuse_factor, e.specular_factor, e.glossiness_factor)),
        of_crate.map(|e| (e.diffuse_factor.0, e.specular_factor.0, e.glossiness_factor.0)),
    );
    if let (Some(a), Some(b)) = (glossy, of_crate) {
        info(place, &a.diffuse_texture, &b.diffuse_texture);
    }
}

fn transmission(place: &str, a: &MaterialExtensions, b: &CrateExtensions) {
    same(
        place,
        a.volume.as_ref().map(|e| (e.thickness_factor, e.attenuation_distance, e.attenuation_color)),
        b.volume.as_ref().map(|e| (e.thickness_factor.0, e.attenuation_distance.0, e.attenuation_color.0)),
    );
    let (a, b) = (a.transmission.as_ref(), b.transmission.as_ref());
    same(place, a.map(|e| e.transmission_factor), b.map(|e| e.transmission_factor.0));
    if let (Some(a), Some(b)) = (a, b) {
        info(place, &a.transmission_texture, &b.transmission_texture);
    }
}

fn info(place: &str, ours: &Option<TextureInfo>, theirs: &Option<Info>) {
    let ours = ours.as_ref().map(|t| {
        let transform = t.extensions.as_ref().and_then(|e| e.transform.as_ref());
        (t.index.value(), t.tex_coord, transform.map(parts))
    });
    let theirs = theirs.as_ref().map(|t| {
        let transform = t.extensions.as_ref().and_then(|e| e.texture_transform.as_ref());
        (t.index.value(), t.tex_coord, transform.map(crate_parts))
    });
    same(place, ours, theirs);
}

type TransformParts = ([f32; 2], f32, [f32; 2], Option<u32>);

fn parts(transform: &TextureTransform) -> TransformParts {
    (transform.offset, transform.rotation, transform.scale, transform.tex_coord)
}

fn crate_parts(transform: &CrateTransform) -> TransformParts {
    (transform.offset.0, transform.rotation.0, transform.scale.0, transform.tex_coord)
}
