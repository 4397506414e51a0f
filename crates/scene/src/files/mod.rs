//! Files in: models (OBJ with MTL, glTF, PLY), our own JSON, the built-in scenes, and what is kept from the reference systems.

mod budget;
mod builtin;
mod components;
mod face_ranges;
mod gltf;
mod images;
mod json;
mod loader;
mod obj;
mod ply;
mod reference_systems;
mod requests;
mod source;
mod surroundings;
mod warnings;
mod winding;

#[cfg(test)]
mod far_tests;
#[cfg(test)]
mod fuzz_tests;
#[cfg(test)]
mod winding_tests;

use crate::error::{SceneError, Warning};
use crate::model::{Image, Instance, Scene};
use eosphor_core::settings::Integrator;
use loader::Loader;
use reference_systems::pg1;
use source::Source;
use std::path::{Path, PathBuf};

pub use builtin::{BUILTINS, Builtin};
pub use images::{PicturePixels, broken_picture, read_data, read_hdr, read_jpeg, read_png, read_ppm};
pub use json::{CannotSave, scene_over_base, scene_reference, scene_schema};
pub use reference_systems::course::{
    CourseBody, CourseFloor, CourseInput, CourseLight, CourseLines, CourseOptions, CoursePattern,
    MAX_COURSE_LIGHTS, WrongCoursePattern,
};
pub use reference_systems::pg1::{ConfigKey, KeyUse, config_keys};
pub use reference_systems::{Preset, UnknownPreset, course_settings};
pub use requests::{SceneRequests, scene_requests};
pub use source::near_name;

/// What [`load`] reads, for help texts.
pub const READ_FORMATS: &str = "OBJ (.obj), glTF (.gltf, .glb), PLY (.ply), Eosphor scenes (.json), PG1 configurations (.json) and builtin:NAME";

/// How scenes are loaded.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct LoadOptions {
    /// Reads and decodes textures; without, surfaces have their plain colour.
    pub textures: bool,
    /// Name or number (from 0, in the order of the nodes) of the camera to take, of files that may have several
    /// (glTF); `None`: the first.
    pub camera: Option<String>,
    /// What [`crate::RenderSettings::headlight`] is where the file does not say it; without, models without lights get no
    /// grey surroundings either.
    pub headlight: bool,
    /// How a glTF file is rendered, of which the format says nothing; `None`: by path tracing. The samples and the tone curve of
    /// the scene go with it. All other files say this themselves, or are rendered by Whitted's method.
    pub integrator: Option<Integrator>,
    /// Bytes that the texels of all textures together may take, in the depth that their files have; asked before a
    /// picture is decoded. More is [`SceneError::TextureMemory`]; `None`: no limit.
    pub texture_memory_bytes: Option<u64>,
}

impl Default for LoadOptions {
    fn default() -> LoadOptions {
        LoadOptions {
            textures: true,
            camera: None,
            headlight: true,
            integrator: None,
            texture_memory_bytes: None,
        }
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
    match builtin::name_of(path) {
        Some(name) => builtin::load(name, options),
        None => load_from(Source::Disk, path, options),
    }
}

/// Like [`load`], but reads from memory. `files` holds pairs of path and contents; paths must be spelled as the files refer to
/// each other. `path` is the entry of `files` to open first.
///
/// # Errors
/// As [`load`].
pub fn load_from_memory(
    files: Vec<(PathBuf, Vec<u8>)>,
    path: impl AsRef<Path>,
    options: &LoadOptions,
) -> Result<LoadedScene, SceneError> {
    let files = files.into_iter().map(|(path, bytes)| (path, bytes.into())).collect();
    load_from(Source::Memory(files), path.as_ref(), options)
}

/// Reads a picture, of any kind that textures may have. `memory_bytes` is as [`LoadOptions::texture_memory_bytes`].
///
/// # Errors
/// A message that names the file and says what is wrong with it.
pub fn load_image(path: impl AsRef<Path>, memory_bytes: Option<u64>) -> Result<Image, SceneError> {
    let options = LoadOptions { texture_memory_bytes: memory_bytes, ..LoadOptions::default() };
    Loader::new(Source::Disk, &options).only_image(path.as_ref())
}

fn load_from(source: Source, path: &Path, options: &LoadOptions) -> Result<LoadedScene, SceneError> {
    let mut loader = Loader::new(source, options);
    let is_gltf = matches!(extension(path).as_deref(), Some("gltf" | "glb"));
    if options.camera.is_some() && !is_gltf {
        let message = "only glTF files have cameras to choose from; leave the choice out".into();
        return Err(SceneError::NoSuchCamera { path: path.to_path_buf(), message });
    }
    read_scene(&mut loader, path, options.camera.as_deref())?;
    loader.finish(path)
}

/// Reads a scene file of any kind into a loader that has none yet. `camera` chooses one of a glTF file.
fn read_scene(loader: &mut Loader, path: &Path, camera: Option<&str>) -> Result<(), SceneError> {
    match extension(path).as_deref() {
        // PG1 configures by JSON too.
        Some("json") => match pg1::is_config(&loader.read(path)?) {
            true => pg1::read(loader, path),
            false => json::read(loader, path),
        },
        Some("gltf" | "glb") => gltf::read_scene(loader, path, camera),
        _ => {
            let instances = read_model(loader, path).map_err(|error| match error {
                // What is not there has no kind.
                SceneError::UnknownFormat { .. } => loader.why_missing(path).unwrap_or(error),
                error => error,
            })?;
            loader.scene.instances.extend(instances);
            loader.scene.settle_origin();
            let is_lit = surroundings::has_lamps(&loader.scene);
            surroundings::add(&mut loader.scene, is_lit);
            Ok(())
        }
    }
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
        let unread = |name: &str| {
            let files = vec![(name.into(), b"solid".to_vec())];
            load_from_memory(files, name, &LoadOptions::default()).unwrap_err().to_string()
        };
        assert!(unread("a/x.stl").starts_with("a/x.stl: \"stl\" files are not read; give OBJ (.obj), glTF"));
        assert!(unread("scene").contains("no extension"));
        assert!(message("/nowhere/x.stl").starts_with("/nowhere/x.stl: cannot read: No such file"));
        assert!(message("/nowhere/bunny.obj").starts_with("/nowhere/bunny.obj: cannot read: No such file"));
        assert_eq!(
            message("builtin:x"),
            "there is no built-in scene \"x\"; there is cornell, cornell-pg1, glass, hare, hills, lamps, solids"
        );
    }
}
