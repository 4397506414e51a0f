//! Builds one scene from several files.

use super::budget::Budget;
use super::json::quoted;
use super::source::Source;
use super::warnings::Warnings;
use super::{LoadOptions, LoadedScene, builtin, images};
use crate::error::{Place, Problem, SceneError, Warning};
use crate::model::origin::APART;
use crate::model::{Image, Material, RenderSettings, Scene, Texture, share_words};
use crate::solids::{PARQUET, parquet};
use crate::studio::{STUDIO, studio};
use eosphor_core::settings::Integrator;
use std::borrow::Cow;
use std::collections::HashMap;
use std::path::{Path, PathBuf};

/// Longest chain of scene files of which each is the base of the one before.
pub(super) const MAX_BASES: usize = 16;

/// A scene in the making.
pub(super) struct Loader {
    pub(super) scene: Scene,
    pub(super) warnings: Warnings,
    /// Meshes more of their sizes than this from 0 are counted from a point of their own.
    pub(super) apart: f64,
    /// How a glTF file is to be rendered, where it is the scene or the base of one.
    pub(super) integrator: Integrator,
    source: Source,
    options: LoadOptions,
    budget: Budget,
    files_read: Vec<PathBuf>,
    /// Scene files of which each is the base of the one before; the last one is being read.
    chain: Vec<PathBuf>,
    images: HashMap<PathBuf, u32>,
    default_material: Option<u32>,
}

impl Loader {
    pub(super) fn new(source: Source, options: &LoadOptions) -> Loader {
        let settings = RenderSettings { headlight: options.headlight, ..RenderSettings::default() };
        Loader {
            scene: Scene { settings, ..Scene::default() },
            warnings: Warnings::default(),
            apart: APART,
            integrator: options.integrator.unwrap_or(Integrator::Path),
            source,
            options: options.clone(),
            budget: Budget::new(options.texture_memory_bytes),
            files_read: Vec::new(),
            chain: Vec::new(),
            images: HashMap::new(),
            default_material: None,
        }
    }

    /// The finished scene, validated. What moves has an animation.
    pub(super) fn finish(mut self, path: &Path) -> Result<LoadedScene, SceneError> {
        self.budget.check()?;
        share_words(&mut self.scene.images);
        if self.scene.animation.is_none() {
            self.scene.animate(None, Vec::new());
        }
        let invalid = |problem: Problem| SceneError::invalid(Place::file(path), problem.to_string());
        self.scene.validate().map_err(invalid)?;
        let files_read = if matches!(self.source, Source::Disk) { self.files_read } else { Vec::new() };
        Ok(LoadedScene { scene: self.scene, warnings: self.warnings.finish(path), files_read })
    }

    pub(super) fn read(&mut self, path: &Path) -> Result<Cow<'static, [u8]>, SceneError> {
        let bytes = self.source.read(path).map_err(|reason| {
            let reason = self.source.explain(path, reason);
            SceneError::Read { path: path.to_path_buf(), reason }
        })?;
        if !self.files_read.iter().any(|p| p == path) {
            self.files_read.push(path.to_path_buf());
        }
        Ok(bytes)
    }

    /// Notes the base of a scene file. Fails where bases lead in a circle, or are too many.
    pub(super) fn begin_with(&mut self, file: &Path, base: &Path) -> Result<(), String> {
        self.chain.push(file.to_path_buf());
        let shown = |path: &PathBuf| path.display().to_string();
        if let Some(first) = self.chain.iter().position(|path| path == base) {
            let circle: Vec<String> = self.chain[first..].iter().map(shown).collect();
            let message = "the base leads back to the file itself";
            return Err(match circle.as_slice() {
                [_] => format!("{message}; name another one"),
                _ => {
                    format!("{message}, through {}; name another one", circle[..circle.len() - 1].join(", "))
                }
            });
        }
        if self.chain.len() > MAX_BASES {
            return Err(format!("more than {MAX_BASES} bases of bases; merge some of these files"));
        }
        Ok(())
    }

    /// Takes a built-in scene as what the loader has; `headlight` as in [`LoadOptions`].
    pub(super) fn take_builtin(&mut self, name: &str, headlight: bool) -> Result<(), SceneError> {
        let options = LoadOptions { headlight, camera: None, ..self.options.clone() };
        let LoadedScene { scene, warnings, .. } = builtin::load(name, &options)?;
        self.scene = scene;
        for Warning { place, message, .. } in warnings {
            self.warnings.add(&place.path, place.line, message);
        }
        Ok(())
    }

    /// The number of the material of what has none.
    pub(super) fn default_material(&mut self) -> u32 {
        if let Some(number) = self.default_material {
            return number;
        }
        self.scene.materials.push(Material::default_material());
        let number = self.scene.materials.len() as u32 - 1;
        self.default_material = Some(number);
        number
    }

    /// The path of a file that another names: as written, with escaped blanks, with `\` for `/`, or, for paths of
    /// another machine, the bare name beside the file that names it.
    pub(super) fn find(&self, folder: &Path, name: &[u8]) -> Option<PathBuf> {
        let slashes: Vec<u8> = name.iter().map(|&b| if b == b'\\' { b'/' } else { b }).collect();
        let bare = slashes.rsplit(|&b| b == b'/').next().unwrap_or_default().to_vec();
        [name.to_vec(), unescaped(name), slashes, bare]
            .into_iter()
            .filter(|candidate| !candidate.is_empty() && !candidate.contains(&0))
            .map(|candidate| folder.join(path_of(candidate)))
            .find(|path| self.source.exists(path))
    }

    /// What to say beside "missing" of a file that [`Loader::find`] has not found: the nearest name, where one is near.
    pub(super) fn near(&self, folder: &Path, name: &[u8]) -> String {
        let slashes = String::from_utf8_lossy(name).replace('\\', "/");
        let near = self.source.near(&folder.join(slashes));
        near.map(|near| format!(" (did you mean {near}?)")).unwrap_or_default()
    }

    /// The error of a file that is not there.
    pub(super) fn why_missing(&self, path: &Path) -> Option<SceneError> {
        let reason = self.source.why_missing(path)?;
        Some(SceneError::Read { path: path.to_path_buf(), reason: self.source.explain(path, reason) })
    }

    /// The number of a picture that a file names: one in a folder, or a built-in one.
    pub(super) fn image_beside(&mut self, folder: &Path, file: &Path) -> Result<u32, SceneError> {
        let builtin = file.to_str().and_then(|name| name.strip_prefix("builtin:"));
        let Some(name) = builtin else { return self.image(&folder.join(file)) };
        if let Some(&number) = self.images.get(file) {
            return Ok(number);
        }
        let picture = match file {
            file if file == Path::new(PARQUET) => parquet(),
            file if file == Path::new(STUDIO) => studio(),
            _ => {
                let message =
                    format!("there is no built-in picture {}; there are parquet and studio", quoted(name));
                return Err(SceneError::invalid(Place::file(file), message));
            }
        };
        self.budget.admits(picture.texels.bytes(), || picture.name.clone());
        self.scene.images.push(picture);
        let number = self.scene.images.len() as u32 - 1;
        self.images.insert(file.to_path_buf(), number);
        Ok(number)
    }

    /// Reads a picture once; the number of the image.
    pub(super) fn image(&mut self, path: &Path) -> Result<u32, SceneError> {
        if let Some(&number) = self.images.get(path) {
            return Ok(number);
        }
        let bytes = self.read(path)?;
        let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        let wrong = |message: String| SceneError::invalid(Place::file(path), message);
        let header = images::header(&bytes, &name).map_err(wrong)?;
        let picture = match self.admits(&header, || path.display().to_string()) {
            true => images::decode(&bytes, &name).map_err(|message| {
                self.release(&header);
                wrong(message)
            })?,
            false => images::Picture::white(),
        };
        Ok(self.add_image(Some(path), name, picture))
    }

    /// Reads one picture, and nothing else.
    pub(super) fn only_image(mut self, path: &Path) -> Result<Image, SceneError> {
        let number = self.image_beside(Path::new(""), path)?;
        self.budget.check()?;
        Ok(self.scene.images.swap_remove(number as usize))
    }

    /// The number of a picture that was read before.
    pub(super) fn known_image(&self, path: &Path) -> Option<u32> {
        self.images.get(path).copied()
    }

    /// Adds a picture that is decoded, and from which file, if it is one; the number of the image.
    pub(super) fn add_image(&mut self, path: Option<&Path>, name: String, picture: images::Picture) -> u32 {
        let images::Picture { width, height, texels } = picture;
        self.scene.images.push(Image { name, width, height, texels });
        let number = self.scene.images.len() as u32 - 1;
        if let Some(path) = path {
            self.images.insert(path.to_path_buf(), number);
        }
        number
    }

    /// Counts a picture that is about to be decoded. Where the budget does not admit it, a white one stands for it
    /// until [`Loader::finish`] fails.
    pub(super) fn admits(&mut self, header: &images::Header, name: impl FnOnce() -> String) -> bool {
        self.budget.admits(header.bytes, name)
    }

    /// Takes back what was counted for a picture that is broken.
    pub(super) fn release(&mut self, header: &images::Header) {
        self.budget.release(header.bytes);
    }

    /// The number of a texture; equal ones share it.
    pub(super) fn texture(&mut self, texture: Texture) -> u32 {
        let textures = &mut self.scene.textures;
        let number = textures.iter().position(|t| *t == texture).unwrap_or_else(|| {
            textures.push(texture);
            textures.len() - 1
        });
        number as u32
    }

    pub(super) fn wants_textures(&self) -> bool {
        self.options.textures
    }
}

/// A name as the system has it: any bytes, where it takes any.
#[cfg(unix)]
fn path_of(name: Vec<u8>) -> PathBuf {
    use std::os::unix::ffi::OsStringExt;
    std::ffi::OsString::from_vec(name).into()
}

#[cfg(not(unix))]
fn path_of(name: Vec<u8>) -> PathBuf {
    String::from_utf8_lossy(&name).into_owned().into()
}

/// `\ ` read as a blank.
pub(super) fn unescaped(name: &[u8]) -> Vec<u8> {
    let mut out = Vec::with_capacity(name.len());
    for (i, &b) in name.iter().enumerate() {
        if !(b == b'\\' && name.get(i + 1) == Some(&b' ')) {
            out.push(b);
        }
    }
    out
}
