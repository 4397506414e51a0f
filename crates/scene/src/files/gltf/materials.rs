//! Materials of the file → materials of the model.

use super::buffers::Buffers;
use super::described::{Described, Maps};
use super::document::Document;
use super::images::Images;
use super::textures::Map;
use crate::files::images::Picture;
use crate::files::loader::Loader;
use crate::model::{
    AlphaMode, Channel, Material, MaterialKind, MaterialTextures, Pbr, Texture, TextureChannel,
};
use eosphor_core::math::Vec3;
use std::path::Path;

/// Adds all materials of the file, and after them that of what has none; textures only of those that are used.
pub(super) fn add(loader: &mut Loader, path: &Path, root: &Document, buffers: &Buffers<'_>, used: &[bool]) {
    let is_used = |number: usize| used.get(number).copied().unwrap_or(false);
    let described: Vec<Described> = (root.materials.iter().enumerate())
        .map(|(number, material)| Described::new(loader, path, number, material, is_used(number)))
        .collect();
    let mut wanted = Vec::new();
    if loader.wants_textures() {
        let of_used = described.iter().enumerate().filter(|(number, _)| is_used(*number));
        wanted = of_used.flat_map(|(_, d)| d.maps.all()).filter_map(|map| map.image(root)).collect();
        let mut seen = vec![false; root.images.len()];
        wanted.retain(|&image| !std::mem::replace(&mut seen[image], true));
    }
    let images = Images::read(loader, path, root, buffers, &wanted);
    let mut white = None;
    for (number, mut described) in described.into_iter().enumerate() {
        if !is_used(number) {
            described.maps = Maps::default();
        }
        let material = dress(loader, path, root, &images, described, &mut white);
        loader.scene.materials.push(material);
    }
    if is_used(root.materials.len()) {
        // The specification's default is a rough white metal.
        let pbr = Pbr { metallic: 1.0, ..Pbr::default() };
        loader.scene.materials.push(Material::new("glTF default", MaterialKind::Pbr(pbr)));
    }
}

/// Puts in the textures that could be read.
fn dress(
    loader: &mut Loader,
    path: &Path,
    root: &Document,
    images: &Images,
    described: Described,
    white: &mut Option<u32>,
) -> Material {
    let Described { name, mut pbr, alpha, double_sided, maps, unlit } = described;
    let mut resolve = |map: &Option<Map>| map.as_ref().and_then(|m| m.resolve(loader, path, root, images));
    let channel = |texture: Option<u32>, channel| texture.map(|texture| TextureChannel { texture, channel });
    let color = resolve(&maps.color);
    let metallic_roughness = resolve(&maps.metallic_roughness);
    let mut textures = MaterialTextures {
        color,
        opacity: if alpha == AlphaMode::Opaque { None } else { channel(color, Channel::Alpha) },
        emission: resolve(&maps.emission),
        metallic: channel(metallic_roughness, Channel::Blue),
        roughness: channel(metallic_roughness, Channel::Green),
        transmission: channel(resolve(&maps.transmission), Channel::Red),
        normal: resolve(&maps.normal),
        normal_scale: maps.normal_scale,
        ..MaterialTextures::NONE
    };
    if unlit {
        // A texture, if only a white one, keeps the triangles from becoming lights.
        textures.color = None;
        textures.emission =
            textures.emission.or_else(|| Some(*white.get_or_insert_with(|| add_white(loader))));
    } else if maps.emission.is_some() && textures.emission.is_none() {
        // Without its texture all of the surface would shine.
        pbr.emission = Vec3::ZERO;
    }
    // Bodies are left through their back.
    let single_sided = !double_sided && pbr.transmission == 0.0;
    Material { textures, alpha, single_sided, ..Material::new(name, MaterialKind::Pbr(pbr)) }
}

/// A texture of one white texel.
fn add_white(loader: &mut Loader) -> u32 {
    let image = loader.add_image(None, "white".into(), Picture::white());
    loader.texture(Texture::of_image(image))
}
