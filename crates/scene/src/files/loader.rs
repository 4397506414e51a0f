//! Builds one scene from several files.

use super::lines::{is_blank, text, trim};
use super::source::Source;
use super::warnings::Warnings;
use super::{LoadOptions, LoadedScene, images, mtl, obj};
use crate::error::{Place, SceneError};
use crate::model::{Instance, Material, MaterialKind, Scene, Texture, Transform};
use eosphor_core::texture::{TextureFilter, TextureWrap};
use std::borrow::Cow;
use std::collections::HashMap;
use std::path::{Path, PathBuf};

/// A scene in the making.
pub(super) struct Loader {
    pub(super) scene: Scene,
    pub(super) warnings: Warnings,
    source: Source,
    options: LoadOptions,
    files_read: Vec<PathBuf>,
    textures: HashMap<(PathBuf, TextureFilter, TextureWrap), u32>,
    default_material: Option<u32>,
}

impl Loader {
    pub(super) fn new(source: Source, options: &LoadOptions) -> Loader {
        Loader {
            scene: Scene::default(),
            warnings: Warnings::default(),
            source,
            options: options.clone(),
            files_read: Vec::new(),
            textures: HashMap::new(),
            default_material: None,
        }
    }

    /// The finished scene, validated.
    pub(super) fn finish(self, path: &Path) -> Result<LoadedScene, SceneError> {
        self.scene.validate().map_err(|problem| SceneError::Invalid {
            place: Place::file(path),
            message: problem.to_string(),
        })?;
        let files_read = if matches!(self.source, Source::Disk) { self.files_read } else { Vec::new() };
        Ok(LoadedScene { scene: self.scene, warnings: self.warnings.finish(path), files_read })
    }

    pub(super) fn read(&mut self, path: &Path) -> Result<Cow<'static, [u8]>, SceneError> {
        let bytes =
            self.source.read(path).map_err(|reason| SceneError::Read { path: path.to_path_buf(), reason })?;
        if !self.files_read.iter().any(|p| p == path) {
            self.files_read.push(path.to_path_buf());
        }
        Ok(bytes)
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

    /// A scene that is one OBJ file.
    pub(super) fn obj_scene(&mut self, path: &Path) -> Result<(), SceneError> {
        let mesh = self.obj_mesh(path)?;
        self.scene.instances.push(Instance { mesh, world_from_object: Transform::default() });
        Ok(())
    }

    /// Adds the mesh, the materials and the textures of an OBJ file; the number of the mesh.
    pub(super) fn obj_mesh(&mut self, path: &Path) -> Result<u32, SceneError> {
        let bytes = self.read(path)?;
        let mut file = obj::parse(&bytes, path, &mut self.warnings)?;
        let folder = path.parent().unwrap_or(Path::new(""));

        let mut known: HashMap<Vec<u8>, u32> = HashMap::new();
        for (arguments, line) in &file.libraries {
            self.libraries(path, folder, arguments, *line, &mut known);
        }
        let mut numbers = Vec::with_capacity(file.materials.len());
        for (name, line) in &file.materials {
            numbers.push(match known.get(name) {
                Some(&number) => number,
                None => {
                    if !name.is_empty() {
                        let message = format!("unknown material \"{}\"; the default is taken", text(name));
                        self.warnings.add(path, Some(*line), message);
                    }
                    self.default_material()
                }
            });
        }
        for triangle in &mut file.mesh.triangles {
            triangle.material = numbers[triangle.material as usize];
        }
        file.mesh.name = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        self.scene.meshes.push(file.mesh);
        Ok(self.scene.meshes.len() as u32 - 1)
    }

    /// Reads the files of an `mtllib` line. Names are divided by blanks and may themselves hold blanks, plain or
    /// escaped: the longest run of words that names a file counts.
    fn libraries(
        &mut self,
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
                let file = self.find(folder, &rest[..end])?;
                Some((end, file))
            });
            match found {
                Some((end, file)) => {
                    self.library(&file, known);
                    rest = trim(&rest[end..]);
                }
                None => {
                    let end = ends.first().copied().unwrap_or(rest.len());
                    let message = format!("material file \"{}\" is missing", text(&unescaped(&rest[..end])));
                    self.warnings.add(obj, Some(line), message);
                    rest = trim(&rest[end..]);
                }
            }
        }
    }

    /// The path of a file that another names: as written, with escaped blanks, with `\` for `/`, or, for paths of
    /// another machine, the bare name beside the file that names it.
    fn find(&self, folder: &Path, name: &[u8]) -> Option<PathBuf> {
        let plain = String::from_utf8_lossy(name).into_owned();
        let unescaped = String::from_utf8_lossy(&unescaped(name)).into_owned();
        let slashes = plain.replace('\\', "/");
        let bare = slashes.rsplit('/').next().unwrap_or_default().to_string();
        [plain, unescaped, slashes, bare]
            .into_iter()
            .filter(|candidate| !candidate.is_empty() && !candidate.contains('\0'))
            .map(|candidate| folder.join(candidate))
            .find(|path| self.source.exists(path))
    }

    fn library(&mut self, path: &Path, known: &mut HashMap<Vec<u8>, u32>) {
        let bytes = match self.read(path) {
            Ok(bytes) => bytes,
            Err(problem) => {
                self.warnings.add(path, None, problem.to_string());
                return;
            }
        };
        let folder = path.parent().unwrap_or(Path::new(""));
        for entry in mtl::parse(&bytes, path, &mut self.warnings) {
            if known.contains_key(&entry.name) {
                let message = format!("material \"{}\" is given twice; the first counts", text(&entry.name));
                self.warnings.add(path, Some(entry.line), message);
                continue;
            }
            let diffuse_texture = entry.texture.as_ref().and_then(|map| self.map_kd(path, folder, map));
            let name = String::from_utf8_lossy(&entry.name).into_owned();
            self.scene.materials.push(Material { name, kind: MaterialKind::Mtl(entry.mtl), diffuse_texture });
            known.insert(entry.name, self.scene.materials.len() as u32 - 1);
        }
    }

    /// The texture of a material; what is missing or broken warns and leaves the surface untextured.
    fn map_kd(&mut self, mtl: &Path, folder: &Path, map: &mtl::MapKd) -> Option<u32> {
        if !self.options.textures {
            return None;
        }
        let Some(file) = self.find(folder, &map.file) else {
            let name = text(&map.file);
            let message = format!("texture \"{name}\" is missing; the surface is untextured");
            self.warnings.add(mtl, Some(map.line), message);
            return None;
        };
        match self.texture(&file, TextureFilter::Bilinear, map.wrap) {
            Ok(number) => Some(number),
            Err(problem) => {
                let message = format!("texture: {problem}; the surface is untextured");
                self.warnings.add(mtl, Some(map.line), message);
                None
            }
        }
    }

    /// Reads a picture once for each way of reading it; the number of the texture.
    pub(super) fn texture(
        &mut self,
        path: &Path,
        filter: TextureFilter,
        wrap: TextureWrap,
    ) -> Result<u32, SceneError> {
        let key = (path.to_path_buf(), filter, wrap);
        if let Some(&number) = self.textures.get(&key) {
            return Ok(number);
        }
        let bytes = self.read(path)?;
        let picture = images::decode(&bytes)
            .map_err(|message| SceneError::Invalid { place: Place::file(path), message })?;
        let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        let images::Picture { width, height, texels } = picture;
        self.scene.textures.push(Texture { name, width, height, texels, filter, wrap });
        let number = self.scene.textures.len() as u32 - 1;
        self.textures.insert(key, number);
        Ok(number)
    }

    pub(super) fn wants_textures(&self) -> bool {
        self.options.textures
    }
}

/// The ends of the words of a line; an escaped blank does not end one.
fn word_ends(line: &[u8]) -> impl Iterator<Item = usize> + '_ {
    (1..=line.len()).filter(|&i| {
        let ends = i == line.len() || (is_blank(line[i]) && line[i - 1] != b'\\');
        ends && !is_blank(line[i - 1])
    })
}

/// `\ ` read as a blank.
fn unescaped(name: &[u8]) -> Vec<u8> {
    let mut out = Vec::with_capacity(name.len());
    for (i, &b) in name.iter().enumerate() {
        if !(b == b'\\' && name.get(i + 1) == Some(&b' ')) {
            out.push(b);
        }
    }
    out
}
