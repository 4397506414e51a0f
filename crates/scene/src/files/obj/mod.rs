//! Wavefront OBJ with its MTL materials.

mod lines;
mod mtl;
mod parse;
#[cfg(test)]
mod tests;

use super::loader::{Loader, unescaped};
use crate::error::SceneError;
use crate::model::{Instance, Material, MaterialKind, Texture, Transform};
use lines::{is_blank, text, trim};
use std::collections::HashMap;
use std::path::Path;

/// Adds the mesh, the materials and the textures of an OBJ file, placed as it is.
pub(super) fn read_model(loader: &mut Loader, path: &Path) -> Result<Vec<Instance>, SceneError> {
    let bytes = loader.read(path)?;
    let mut file = parse::parse(&bytes, path, &mut loader.warnings)?;
    let folder = path.parent().unwrap_or(Path::new(""));

    let mut known: HashMap<Vec<u8>, u32> = HashMap::new();
    for (arguments, line) in &file.libraries {
        libraries(loader, path, folder, arguments, *line, &mut known);
    }
    let mut numbers = Vec::with_capacity(file.materials.len());
    for (name, line) in &file.materials {
        numbers.push(match known.get(name) {
            Some(&number) => number,
            None => {
                if !name.is_empty() {
                    let message = format!("unknown material \"{}\"; the default is taken", text(name));
                    loader.warnings.add(path, Some(*line), message);
                }
                loader.default_material()
            }
        });
    }
    for triangle in &mut file.mesh.triangles {
        triangle.material = numbers[triangle.material as usize];
    }
    file.mesh.name = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    loader.scene.meshes.push(file.mesh);
    Ok(vec![Instance::new(loader.scene.meshes.len() as u32 - 1, Transform::default())])
}

/// Reads the files of an `mtllib` line. Names are divided by blanks and may themselves hold blanks, plain or
/// escaped: the longest run of words that names a file counts.
fn libraries(
    loader: &mut Loader,
    obj: &Path,
    folder: &Path,
    arguments: &[u8],
    line: u32,
    known: &mut HashMap<Vec<u8>, u32>,
) {
    // Longer lines are no lists of file names; trying all runs of their words would take too long.
    const MAX_WORDS: usize = 32;
    let mut rest = arguments;
    while !rest.is_empty() {
        let ends: Vec<usize> = word_ends(rest).take(MAX_WORDS).collect();
        let found = ends.iter().rev().find_map(|&end| {
            let file = loader.find(folder, &rest[..end])?;
            Some((end, file))
        });
        match found {
            Some((end, file)) => {
                library(loader, &file, known);
                rest = trim(&rest[end..]);
            }
            None => {
                let end = ends.first().copied().unwrap_or(rest.len());
                let message = format!("material file \"{}\" is missing", text(&unescaped(&rest[..end])));
                loader.warnings.add(obj, Some(line), message);
                rest = trim(&rest[end..]);
            }
        }
    }
}

fn library(loader: &mut Loader, path: &Path, known: &mut HashMap<Vec<u8>, u32>) {
    let bytes = match loader.read(path) {
        Ok(bytes) => bytes,
        Err(problem) => {
            loader.warnings.add(path, None, problem.to_string());
            return;
        }
    };
    let folder = path.parent().unwrap_or(Path::new(""));
    for entry in mtl::parse(&bytes, path, &mut loader.warnings) {
        if known.contains_key(&entry.name) {
            let message = format!("material \"{}\" is given twice; the first counts", text(&entry.name));
            loader.warnings.add(path, Some(entry.line), message);
            continue;
        }
        let color = entry.texture.as_ref().and_then(|map| map_kd(loader, path, folder, map));
        let name = String::from_utf8_lossy(&entry.name).into_owned();
        let mut material = Material::new(name, MaterialKind::Mtl(entry.mtl));
        material.textures.color = color;
        loader.scene.materials.push(material);
        known.insert(entry.name, loader.scene.materials.len() as u32 - 1);
    }
}

/// The texture of a material; what is missing or broken warns and leaves the surface untextured.
fn map_kd(loader: &mut Loader, mtl: &Path, folder: &Path, map: &mtl::MapKd) -> Option<u32> {
    if !loader.wants_textures() {
        return None;
    }
    let Some(file) = loader.find(folder, &map.file) else {
        let name = text(&map.file);
        let message = format!("texture \"{name}\" is missing; the surface is untextured");
        loader.warnings.add(mtl, Some(map.line), message);
        return None;
    };
    match loader.image(&file) {
        Ok(image) => {
            Some(loader.texture(Texture { wrap_u: map.wrap, wrap_v: map.wrap, ..Texture::of_image(image) }))
        }
        Err(problem) => {
            let message = format!("texture: {problem}; the surface is untextured");
            loader.warnings.add(mtl, Some(map.line), message);
            None
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
