//! Files in: OBJ with MTL, our own JSON, and the built-in scenes.

mod builtin;
mod gltf;
mod images;
mod json;
mod loader;
mod obj;
mod pg1;
mod ply;
mod source;
mod warnings;

#[cfg(test)]
mod fuzz_tests;

use crate::error::{SceneError, Warning};
use crate::model::{Instance, Scene};
use loader::Loader;
use source::Source;
use std::path::{Path, PathBuf};

pub use builtin::{BUILTINS, Builtin};

/// What [`load`] reads, for help texts.
pub const READ_FORMATS: &str = "OBJ (.obj), Eosphor scenes (.json) and builtin:NAME";

/// How to load.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct LoadOptions {
    /// Reads and decodes textures; without, surfaces have their plain colour.
    pub textures: bool,
}

impl Default for LoadOptions {
    fn default() -> LoadOptions {
        LoadOptions { textures: true }
    }
}

/// A scene and what there is to say about its files.
#[derive(Clone, Debug)]
pub struct LoadedScene {
    /// The scene; it has passed [`Scene::validate`].
    pub scene: Scene,
    /// What was odd but did not stop the reading.
    pub warnings: Vec<Warning>,
    /// All files that were read, each once, in the order of reading; empty for built-in scenes.
    pub files_read: Vec<PathBuf>,
}

/// Reads a scene: an OBJ file, a JSON scene, or `builtin:NAME` (see [`BUILTINS`]).
///
/// # Errors
/// A message that names the file, where it can the line, what is wrong and what to do. Files that are merely
/// missing something (materials, textures of an OBJ) load with warnings.
pub fn load(path: impl AsRef<Path>, options: &LoadOptions) -> Result<LoadedScene, SceneError> {
    let path = path.as_ref();
    match path.to_str().and_then(|name| name.strip_prefix("builtin:")) {
        Some(name) => builtin::load(name, options),
        None => load_from(Source::Disk, path, options),
    }
}

fn load_from(source: Source, path: &Path, options: &LoadOptions) -> Result<LoadedScene, SceneError> {
    let mut loader = Loader::new(source, options);
    if extension(path).as_deref() == Some("json") {
        // PG1 configures by JSON too.
        match pg1::is_config(&loader.read(path)?) {
            true => pg1::read(&mut loader, path)?,
            false => json::read(&mut loader, path)?,
        }
    } else {
        let instances = read_model(&mut loader, path)?;
        loader.scene.instances.extend(instances);
    }
    loader.finish(path)
}

/// Adds the meshes and materials of a model file to the scene in the making; how the file places them.
fn read_model(loader: &mut Loader, path: &Path) -> Result<Vec<Instance>, SceneError> {
    match extension(path).as_deref() {
        Some("obj") => obj::read_model(loader, path),
        Some("gltf" | "glb") => gltf::read_model(loader, path),
        Some("ply") => ply::read_model(loader, path),
        other => Err(unknown_format(path, other)),
    }
}

/// The ending of a file's name, in small letters.
fn extension(path: &Path) -> Option<String> {
    path.extension().map(|e| e.to_string_lossy().to_ascii_lowercase())
}

fn unknown_format(path: &Path, extension: Option<&str>) -> SceneError {
    let problem = match extension {
        Some("gltf" | "glb") => "glTF is not yet read".to_string(),
        Some("ply") => "PLY is not yet read".to_string(),
        Some(e) => format!("\"{e}\" files are not read"),
        None => "what is it? The name has no extension".to_string(),
    };
    SceneError::UnknownFormat { path: path.to_path_buf(), message: format!("{problem}; give {READ_FORMATS}") }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn message(path: &str) -> String {
        load(path, &LoadOptions::default()).unwrap_err().to_string()
    }

    #[test]
    fn what_is_not_read_is_said() {
        assert!(message("a/b.glb").starts_with("a/b.glb: glTF is not yet read; give OBJ (.obj)"));
        assert!(message("x.ply").contains("PLY is not yet read"));
        assert!(message("x.stl").contains("\"stl\" files are not read"));
        assert!(message("scene").contains("no extension"));
        assert!(message("/nowhere/bunny.obj").starts_with("/nowhere/bunny.obj: cannot read: No such file"));
        assert_eq!(message("builtin:x"), "there is no built-in scene \"x\"; there is cornell");
    }
}
