//! PLY, the Stanford triangle format: ASCII and binary, whatever elements and properties a file declares.

mod ascii;
mod binary;
mod color;
mod fast;
mod header;
mod part;
mod role;
mod rows;
mod scalar;
#[cfg(test)]
mod tests;

use super::loader::Loader;
use super::winding::follow_normals;
use crate::error::{Place, SceneError};
use crate::model::origin::of_triangles;
use crate::model::{
    AlphaMode, Instance, Material, MaterialKind, Mesh, Mtl, NO_INDEX, Texture, Transform, Triangle,
};
use eosphor_core::math::Vec3;
use header::{Encoding, Header};
use part::{Oddities, Part};
use role::{Kind, Plan};
use rows::Fault;
use std::path::Path;

/// The material of vertices that have colours.
const COLORS_NAME: &str = "vertex colors";

/// Adds the mesh of a file, placed as it is, with a material where it has colours or a picture.
pub(super) fn read_model(loader: &mut Loader, path: &Path) -> Result<Vec<Instance>, SceneError> {
    let bytes = loader.read(path)?;
    let header = header::parse(&bytes, path, &mut loader.warnings)?;
    let mut plan = Plan::of(&header);
    if !plan.positions {
        return Err(at(path, None, "there is no element \"vertex\" with the properties x, y and z"));
    }
    let body = &bytes[header.size..];
    let mut part = read_part(body, &header, &plan, path)?;
    // What lies far from 0 is read again about a point of its own; and once more where only that shows how small it is.
    for _ in 0..2 {
        let origin = of_triangles(&part.positions, &part.triangles, plan.origin, loader.apart);
        if origin == plan.origin {
            break;
        }
        drop(part);
        plan.origin = origin;
        part = read_part(body, &header, &plan, path)?;
    }
    say_oddities(loader, path, &header, &plan, &part);

    let Part { positions, normals, mut colors, uvs, corner_uvs, mut triangles, polygons, .. } = part;
    let opacity = opacity(&mut colors);
    if opacity == Opacity::None {
        loader.warnings.add(
            path,
            None,
            "every vertex is wholly transparent (alpha 0); they are taken as opaque",
        );
    }
    let has_uvs = plan.uvs || plan.corner_uvs;
    let materials = materials(loader, path, &header, plan.colors, opacity == Opacity::Some, has_uvs);
    number_materials(&mut triangles, &materials);
    let uvs = if plan.corner_uvs { corner_uvs } else { uvs };
    let name = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    let mut mesh = Mesh { name, positions, normals, uvs, colors, triangles, ..Mesh::default() };
    if let Some(note) = follow_normals(&mut mesh, &polygons, |_| false).note() {
        loader.warnings.add(path, None, note);
    }
    loader.scene.meshes.push(mesh);
    let placed = Transform { offset: plan.origin, ..Transform::default() };
    Ok(vec![Instance::new(loader.scene.meshes.len() as u32 - 1, placed)])
}

fn read_part(body: &[u8], header: &Header, plan: &Plan, path: &Path) -> Result<Part, SceneError> {
    let read = match header.encoding {
        Encoding::Ascii => ascii::read_body(body, header, plan),
        _ => binary::read_body(body, header, plan),
    };
    let part = read.map_err(|Fault { line, message }| at(path, line, message))?;
    check_indices(&part, path)?;
    Ok(part)
}

fn at(path: &Path, line: Option<u32>, message: impl Into<String>) -> SceneError {
    SceneError::invalid(Place { line, ..Place::file(path) }, message)
}

/// Faces may come before the vertices, so that indices are checked at the end.
fn check_indices(part: &Part, path: &Path) -> Result<(), SceneError> {
    let count = part.positions.len();
    match part.largest {
        Some((index, what, (line, number))) if index as usize >= count => {
            let message =
                format!("{what} {number}: vertex index {index} is out of range; there are {count} vertices");
            Err(at(path, line, message))
        }
        _ => Ok(()),
    }
}

fn say_oddities(loader: &mut Loader, path: &Path, header: &Header, plan: &Plan, part: &Part) {
    let Oddities { small_faces, not_finite, long_rows } = part.oddities;
    let mut say = |message: String| loader.warnings.add(path, None, message);
    if small_faces > 0 {
        say(format!("{small_faces} faces with fewer than 3 corners are left out"));
    }
    if not_finite > 0 {
        say(format!(
            "{not_finite} normals, colours or texture coordinates are not finite numbers; they are left out"
        ));
    }
    if long_rows > 0 {
        say(format!(
            "{long_rows} lines have more numbers than the header says; the rest of them is left out"
        ));
    }
    if plan.face_colors {
        say("colours of faces are not read; only those of vertices are".into());
    }
    if part.triangles.is_empty() {
        let faces =
            header.elements.iter().any(|e| matches!(e.kind, Kind::Face | Kind::Strips) && e.count > 0);
        say(match faces {
            true => "there is nothing to see: no face has 3 corners in a list \"vertex_indices\"".into(),
            false => "there is nothing to see: the file has points without faces".into(),
        });
    }
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum Opacity {
    All,
    Some,
    None,
}

/// How opaque vertices are. Scanners leave alpha 0 everywhere: that is made opaque, for no file is wholly invisible.
fn opacity(colors: &mut [[f32; 4]]) -> Opacity {
    if colors.iter().all(|c| c[3] == 1.0) {
        return Opacity::All;
    }
    if colors.iter().any(|c| c[3] != 0.0) {
        return Opacity::Some;
    }
    colors.iter_mut().for_each(|c| c[3] = 1.0);
    Opacity::None
}

/// The materials of the file's pictures by number; without pictures one for all.
fn materials(
    loader: &mut Loader,
    path: &Path,
    header: &Header,
    colors: bool,
    blend: bool,
    has_uvs: bool,
) -> Vec<u32> {
    let mut plain = None;
    let mut plain = |loader: &mut Loader| {
        *plain.get_or_insert_with(|| match colors {
            true => white(loader, COLORS_NAME.into(), None, blend),
            false => loader.default_material(),
        })
    };
    if header.textures.is_empty() || !loader.wants_textures() {
        return vec![plain(loader)];
    }
    if !has_uvs {
        let message = "the file names a picture but has no texture coordinates; the surface is untextured";
        loader.warnings.add(path, Some(header.textures[0].1), message);
        return vec![plain(loader)];
    }
    let mut numbers = Vec::with_capacity(header.textures.len());
    for (name, line) in &header.textures {
        numbers.push(match texture(loader, path, name, *line) {
            Some(texture) => white(loader, header::text(name), Some(texture), blend),
            None => plain(loader),
        });
    }
    numbers
}

/// Adds a white material, for a picture or the colours of vertices to show.
fn white(loader: &mut Loader, name: String, texture: Option<u32>, blend: bool) -> u32 {
    let mut material = Material::new(name, MaterialKind::Mtl(Mtl { Kd: Vec3::ONE, ..Mtl::default() }));
    material.textures.color = texture;
    if blend {
        material.alpha = AlphaMode::Blend;
    }
    loader.scene.materials.push(material);
    loader.scene.materials.len() as u32 - 1
}

/// The texture of a picture; what is missing or broken warns and leaves the surface untextured.
fn texture(loader: &mut Loader, path: &Path, name: &[u8], line: u32) -> Option<u32> {
    let folder = path.parent().unwrap_or(Path::new(""));
    let Some(file) = loader.find(folder, name) else {
        let near = loader.near(folder, name);
        let message =
            format!("texture \"{}\" is missing{near}; the surface is untextured", header::text(name));
        loader.warnings.add(path, Some(line), message);
        return None;
    };
    match loader.image(&file) {
        Ok(image) => Some(loader.texture(Texture::of_image(image))),
        Err(problem) => {
            let message = format!("texture: {problem}; the surface is untextured");
            loader.warnings.add(path, Some(line), message);
            None
        }
    }
}

/// From numbers of pictures to numbers of materials; what names no picture shows the first.
fn number_materials(triangles: &mut [Triangle], materials: &[u32]) {
    debug_assert!(!materials.is_empty() && materials.len() < NO_INDEX as usize);
    for triangle in triangles {
        let number = materials.get(triangle.material as usize).or(materials.first());
        triangle.material = number.copied().unwrap_or(0);
    }
}
