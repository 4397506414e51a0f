//! The materials of the MTL files that an OBJ file names, with their textures.

use super::lines::{is_blank, text, trim};
use super::map::{Map, MapKind};
use super::mtl::{self, MtlEntry};
use crate::files::loader::{Loader, unescaped};
use crate::model::{
    AlphaMode, Channel, Material, MaterialKind, TexelLayout, Texture, TextureChannel, TextureContent,
};
use std::collections::HashMap;
use std::path::Path;

/// Materials by name; the numbers are those of the scene.
pub(super) struct Library {
    numbers: HashMap<Vec<u8>, u32>,
}

impl Library {
    /// Reads the files of all `mtllib` lines of an OBJ file, given with their numbers, and adds their materials to the
    /// scene. What is missing warns.
    pub(super) fn read(loader: &mut Loader, obj: &Path, mtllibs: &[(Vec<u8>, u32)]) -> Library {
        let mut library = Library { numbers: HashMap::new() };
        for (arguments, line) in mtllibs {
            library.read_line(loader, obj, arguments, *line);
        }
        library
    }

    pub(super) fn material(&self, name: &[u8]) -> Option<u32> {
        self.numbers.get(name).copied()
    }

    /// Reads the files of an `mtllib` line. Names are divided by blanks and may themselves hold blanks, plain or
    /// escaped: the longest run of words that names a file counts.
    fn read_line(&mut self, loader: &mut Loader, obj: &Path, arguments: &[u8], line: u32) {
        // Longer lines are no lists of file names; trying all runs of their words would take too long.
        const MAX_WORDS: usize = 32;
        const MAX_MISSING: u32 = 256;
        let mut missing = 0;
        let folder = obj.parent().unwrap_or(Path::new(""));
        let mut rest = arguments;
        while !rest.is_empty() {
            let ends: Vec<usize> = word_ends(rest).take(MAX_WORDS).collect();
            let found = ends.iter().rev().find_map(|&end| {
                let file = loader.find(folder, &rest[..end])?;
                Some((end, file))
            });
            match found {
                Some((end, file)) => {
                    self.read_file(loader, &file);
                    rest = trim(&rest[end..]);
                }
                None => {
                    let end = ends.first().copied().unwrap_or(rest.len());
                    let message = format!("material file \"{}\" is missing", text(&unescaped(&rest[..end])));
                    loader.warnings.add(obj, Some(line), message);
                    rest = trim(&rest[end..]);
                    missing += 1;
                    if missing == MAX_MISSING {
                        let message = "the rest of this mtllib line is left out: too many names are missing";
                        loader.warnings.add(obj, Some(line), message);
                        return;
                    }
                }
            }
        }
    }

    fn read_file(&mut self, loader: &mut Loader, path: &Path) {
        let bytes = match loader.read(path) {
            Ok(bytes) => bytes,
            Err(problem) => {
                loader.warnings.add(path, None, problem.to_string());
                return;
            }
        };
        for entry in mtl::parse(&bytes, path, &mut loader.warnings) {
            if self.numbers.contains_key(&entry.name) {
                let message = format!("material \"{}\" is given twice; the first counts", text(&entry.name));
                loader.warnings.add(path, Some(entry.line), message);
                continue;
            }
            let material = material(loader, path, &entry);
            loader.scene.materials.push(material);
            self.numbers.insert(entry.name, loader.scene.materials.len() as u32 - 1);
        }
    }
}

/// The ends of the words of a line; an escaped blank does not end one.
fn word_ends(line: &[u8]) -> impl Iterator<Item = usize> + '_ {
    (1..=line.len()).filter(|&i| {
        let ends = i == line.len() || (is_blank(line[i]) && line[i - 1] != b'\\');
        ends && !is_blank(line[i - 1])
    })
}

fn material(loader: &mut Loader, path: &Path, entry: &MtlEntry) -> Material {
    let name = String::from_utf8_lossy(&entry.name).into_owned();
    let mut material = Material::new(name, MaterialKind::Mtl(entry.mtl));
    let t = &mut material.textures;
    for map in &entry.maps {
        let Some(texture) = texture(loader, path, map) else { continue };
        let channel = |channel| Some(TextureChannel { texture, channel });
        match map.kind {
            MapKind::Color => t.color = Some(texture),
            MapKind::Specular => t.specular = Some(texture),
            MapKind::Emission => t.emission = Some(texture),
            MapKind::Roughness => t.roughness = channel(map.channel.unwrap_or(Channel::Red)),
            MapKind::Metallic => t.metallic = channel(map.channel.unwrap_or(Channel::Red)),
            MapKind::Opacity => {
                let of_picture = || opacity_channel(loader, texture);
                t.opacity = channel(map.channel.unwrap_or_else(of_picture));
                material.alpha = AlphaMode::Blend;
            }
            MapKind::Normal => {
                t.normal = Some(texture);
                t.normal_scale = map.bump_multiplier;
            }
        }
    }
    material
}

/// The texture of a map; what is missing or broken warns, and the surface goes without.
fn texture(loader: &mut Loader, mtl: &Path, map: &Map) -> Option<u32> {
    if !loader.wants_textures() {
        return None;
    }
    let without = match map.kind {
        MapKind::Color => "the surface is untextured",
        _ => "the surface goes without",
    };
    let folder = mtl.parent().unwrap_or(Path::new(""));
    let Some(file) = loader.find(folder, &map.file) else {
        let near = loader.near(folder, &map.file);
        let message = format!("texture \"{}\" is missing{near}; {without}", text(&map.file));
        loader.warnings.add(mtl, Some(map.line), message);
        return None;
    };
    let image = match loader.image(&file) {
        Ok(image) => image,
        Err(problem) => {
            loader.warnings.add(mtl, Some(map.line), format!("texture: {problem}; {without}"));
            return None;
        }
    };
    let content = match map.kind {
        MapKind::Color | MapKind::Specular | MapKind::Emission => TextureContent::Color,
        _ => TextureContent::Data,
    };
    Some(loader.texture(Texture {
        content,
        wrap_u: map.wrap,
        wrap_v: map.wrap,
        picture_from_mesh_uv: map.picture_from_mesh_uv,
        ..Texture::of_image(image)
    }))
}

/// Pictures of opacity have it in their alpha channel, or are grey.
fn opacity_channel(loader: &Loader, texture: u32) -> Channel {
    fn varies<T: PartialEq>(mut values: impl Iterator<Item = T>) -> bool {
        let first = values.next();
        values.any(|x| Some(x) != first)
    }
    let image = loader.scene.textures[texture as usize].image;
    let texels = &loader.scene.images[image as usize].texels;
    let alpha_varies = match texels.layout() {
        TexelLayout::Bytes(channels @ (2 | 4)) => {
            let channels = channels as usize;
            varies(texels.channel_bytes().take(texels.len() * channels).skip(channels - 1).step_by(channels))
        }
        TexelLayout::Floats(channels @ (2 | 4)) => {
            let channels = channels as usize;
            varies(texels.words().iter().skip(channels - 1).step_by(channels).map(|&x| f32::from_bits(x)))
        }
        TexelLayout::Halves(channels @ (2 | 4)) => {
            let halves = texels.words().iter().flat_map(|two| [two & 0xffff, two >> 16]);
            let channels = channels as usize;
            varies(halves.take(texels.len() * channels).skip(channels - 1).step_by(channels))
        }
        _ => false,
    };
    if alpha_varies { Channel::Alpha } else { Channel::Red }
}
