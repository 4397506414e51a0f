//! Wavefront OBJ with its MTL materials.
//!
//! The way of an OBJ file: bytes → pieces (`lines`) → chunks, read in parallel (`reader`, and `plain` for what is
//! written plainly) → one mesh (`join`). Then its materials are looked up (`materials`), which come from MTL files
//! (`mtl`, `map`). Last come winding (`files/winding.rs`), triangles of concave polygons (`triangulation`) and normals of
//! smoothing groups (`smoothing`).

mod chunk;
mod join;
mod lines;
mod map;
mod materials;
mod mtl;
mod number;
mod plain;
mod reader;
mod smoothing;
mod triangulation;

#[cfg(test)]
mod piece_tests;
#[cfg(test)]
mod tests;

use super::loader::Loader;
use crate::error::{Place, SceneError};
use crate::model::{Instance, Material, MaterialKind, Mtl, Transform};
use eosphor_core::math::Vec3;
use lines::text;
use materials::Library;
use memchr::memchr;
use rayon::prelude::*;
use std::path::Path;

/// What is said of a file that has a zero byte.
const ZERO_BYTE: &str =
    "this is not an OBJ text file: it has zero bytes; is it a binary model, or compressed?";

/// Adds the mesh, the materials and the textures of an OBJ file, placed as it is.
pub(super) fn read_model(loader: &mut Loader, path: &Path) -> Result<Vec<Instance>, SceneError> {
    let bytes = loader.read(path)?;
    check_text(&bytes).map_err(|message| SceneError::invalid(Place::file(path), message))?;
    let mut file = join::parse(&bytes, loader.apart, path, &mut loader.warnings)?;
    drop(bytes);

    let library = Library::read(loader, path, &file.libraries);
    let mut default = None;
    let mut numbers = Vec::with_capacity(file.materials.len());
    for (number, (name, line)) in file.materials.iter().enumerate() {
        let is_none = number == join::NO_MATERIAL as usize;
        let known = library.material(name).filter(|_| !is_none);
        if known.is_none() && !is_none {
            let message = format!("unknown material \"{}\"; the default is taken", text(name));
            loader.warnings.add(path, Some(*line), message);
        }
        numbers.push(match known {
            Some(known) => known,
            None if is_none && !file.uses_no_material => 0,
            None => *default.get_or_insert_with(|| default_material(loader, !file.mesh.colors.is_empty())),
        });
    }
    let shines: Vec<bool> = numbers.iter().map(|&n| shines(loader, n)).collect();
    let mended = file.finish_faces(|material| shines[material as usize]);
    if let Some(note) = mended.note() {
        loader.warnings.add(path, None, note);
    }
    if numbers.iter().enumerate().any(|(i, &number)| i != number as usize) {
        file.mesh.triangles.par_iter_mut().for_each(|t| t.material = numbers[t.material as usize]);
    }

    file.mesh.name = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    loader.scene.meshes.push(file.mesh);
    let placed = Transform { offset: file.origin, ..Transform::default() };
    Ok(vec![Instance::new(loader.scene.meshes.len() as u32 - 1, placed)])
}

/// Tells other files by their first bytes; what comes later is met by the readers of lines.
fn check_text(bytes: &[u8]) -> Result<(), &'static str> {
    if bytes.starts_with(b"\xFF\xFE") || bytes.starts_with(b"\xFE\xFF") {
        return Err("this is not an OBJ text file but UTF-16 text; save it as UTF-8");
    }
    match memchr(0, &bytes[..bytes.len().min(1 << 16)]) {
        Some(_) => Err(ZERO_BYTE),
        None => Ok(()),
    }
}

fn shines(loader: &Loader, material: u32) -> bool {
    match loader.scene.materials.get(material as usize).map(|m| &m.kind) {
        Some(MaterialKind::Mtl(mtl)) => mtl.Ke.max_component() > 0.0,
        _ => false,
    }
}

/// The number of the material of faces that have none. Colours of vertices multiply the material's: they are seen as
/// they are on white.
fn default_material(loader: &mut Loader, has_colors: bool) -> u32 {
    if !has_colors {
        return loader.default_material();
    }
    let white = Mtl { Kd: Vec3::ONE, ..Mtl::default() };
    loader.scene.materials.push(Material::new("vertex colors", MaterialKind::Mtl(white)));
    loader.scene.materials.len() as u32 - 1
}
