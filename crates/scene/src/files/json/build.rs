//! From the keys of a JSON scene to the model: files are read, names become numbers.

use super::format::{InstanceEntry, MeshEntry, ParallelogramEntry, SceneFile, SphereEntry};
use super::material::{Entries, MaterialEntry};
use super::nearest::nearest;
use super::text::{line_of_key, line_of_string};
use crate::error::{Place, Problem, SceneError};
use crate::files::{self, loader::Loader};
use crate::model::{Instance, Material, Parallelogram, Sphere, Texture, Transform};
use std::path::Path;

pub(super) struct Builder<'a> {
    pub(super) loader: &'a mut Loader,
    pub(super) path: &'a Path,
    /// Of the file, to find the lines of wrong names.
    pub(super) text: &'a str,
}

/// A mesh that is read: its name, its number and the transform beside its file name.
struct ReadMesh {
    name: String,
    number: u32,
    transform: Transform,
    placed: bool,
}

impl Builder<'_> {
    pub(super) fn build(&mut self, file: SceneFile) -> Result<(), SceneError> {
        self.loader.scene.camera = file.camera;
        self.loader.scene.lights = file.lights;
        self.loader.scene.settings = file.settings;
        let materials = self.materials(file.materials)?;
        let meshes = self.meshes(file.meshes, &materials)?;
        self.instances(file.instances, meshes)?;
        for SphereEntry { center, radius, material } in file.spheres {
            let material = self.material(material.as_deref(), &materials)?;
            self.loader.scene.spheres.push(Sphere { center, radius, material });
        }
        for ParallelogramEntry { corner, edge_u, edge_v, material } in file.parallelograms {
            let material = self.material(material.as_deref(), &materials)?;
            self.loader.scene.parallelograms.push(Parallelogram { corner, edge_u, edge_v, material });
        }
        self.loader.scene.validate().map_err(|p| self.problem(&p))
    }

    /// An error at the first place where the file says `name`.
    fn named_error(&self, name: &str, message: String) -> SceneError {
        let place = Place { line: line_of_string(self.text, name), ..Place::file(self.path) };
        SceneError::Invalid { place, message }
    }

    /// A problem of the finished scene, at the line of the key or name that it speaks of.
    fn problem(&self, problem: &Problem) -> SceneError {
        let what = problem.what.as_str();
        let line = match what.split('"').nth(1) {
            Some(name) => line_of_string(self.text, name),
            None if what.starts_with("settings.") || what.starts_with("camera.") => {
                let key = what.rsplit('.').next().unwrap_or_default();
                line_of_key(self.text, key.split(' ').next().unwrap_or_default())
            }
            None => None,
        };
        let place = Place { line, ..Place::file(self.path) };
        SceneError::Invalid { place, message: problem.to_string() }
    }

    fn unknown(&self, kind: &str, name: &str, known: &[&str]) -> SceneError {
        let hint = match nearest(name, known.iter().copied()) {
            Some(near) => format!("did you mean \"{near}\"?"),
            None if known.is_empty() => "the file has none".into(),
            None => format!("there are \"{}\"", known.join("\", \"")),
        };
        self.named_error(name, format!("unknown {kind} \"{name}\"; {hint}"))
    }

    /// Adds the materials; their names by number.
    fn materials(&mut self, entries: Entries<MaterialEntry>) -> Result<Vec<String>, SceneError> {
        let mut names = Vec::with_capacity(entries.0.len());
        for (name, MaterialEntry { kind, texture }) in entries.0 {
            let color = match texture {
                Some(t) if self.loader.wants_textures() => {
                    let file = self.beside(&t.file);
                    let line = || t.file.to_string_lossy().into_owned();
                    let image = self.loader.image(&file);
                    let image = image.map_err(|e| self.named_error(&line(), format!("texture: {e}")))?;
                    let (filter, wrap_u, wrap_v) = (t.filter, t.wrap, t.wrap);
                    let texture = Texture { filter, wrap_u, wrap_v, ..Texture::of_image(image) };
                    Some(self.loader.texture(texture))
                }
                _ => None,
            };
            names.push(name.clone());
            let mut material = Material::new(name, kind);
            material.textures.color = color;
            self.loader.scene.materials.push(material);
        }
        Ok(names)
    }

    /// The number of a named material; JSON materials come first, so that it is the place of the name.
    fn material(&mut self, name: Option<&str>, materials: &[String]) -> Result<u32, SceneError> {
        let Some(name) = name else { return Ok(self.loader.default_material()) };
        match materials.iter().position(|m| m == name) {
            Some(number) => Ok(number as u32),
            None => {
                let known: Vec<&str> = materials.iter().map(String::as_str).collect();
                Err(self.unknown("material", name, &known))
            }
        }
    }

    fn meshes(&mut self, entries: Vec<MeshEntry>, materials: &[String]) -> Result<Vec<ReadMesh>, SceneError> {
        let mut meshes: Vec<ReadMesh> = Vec::with_capacity(entries.len());
        for MeshEntry { file, name, material, transform } in entries {
            let material = match material {
                Some(name) => Some(self.material(Some(&name), materials)?),
                None => None,
            };
            let number = self.mesh(&file)?;
            let mesh = &mut self.loader.scene.meshes[number as usize];
            if let Some(material) = material {
                mesh.triangles.iter_mut().for_each(|t| t.material = material);
            }
            if let Some(name) = name {
                mesh.name = name;
            }
            meshes.push(ReadMesh { name: mesh.name.clone(), number, transform, placed: false });
        }
        Ok(meshes)
    }

    fn mesh(&mut self, file: &Path) -> Result<u32, SceneError> {
        let full = self.beside(file);
        let name = file.to_string_lossy();
        match file.extension().map(|e| e.to_string_lossy().to_ascii_lowercase()).as_deref() {
            Some("obj") => match files::read_model(self.loader, &full) {
                Err(e @ SceneError::Read { .. }) => Err(self.named_error(&name, format!("mesh: {e}"))),
                other => other.map(|placed| placed[0].mesh),
            },
            _ => Err(self.named_error(&name, format!("mesh \"{name}\": only OBJ meshes are read so far"))),
        }
    }

    /// Places the meshes: as the instances say, and once where none names the mesh.
    fn instances(
        &mut self,
        entries: Vec<InstanceEntry>,
        mut meshes: Vec<ReadMesh>,
    ) -> Result<(), SceneError> {
        for InstanceEntry { mesh: name, transform } in entries {
            let mut named = meshes.iter_mut().filter(|m| m.name == name);
            let (first, second) = (named.next(), named.next());
            if second.is_some() {
                let message = format!("two meshes are named \"{name}\"; give each a \"name\" of its own");
                return Err(self.named_error(&name, message));
            }
            let Some(mesh) = first else {
                let known: Vec<&str> = meshes.iter().map(|m| m.name.as_str()).collect();
                return Err(self.unknown("mesh", &name, &known));
            };
            mesh.placed = true;
            let world_from_object = after(&transform, &mesh.transform);
            let mesh = mesh.number;
            self.loader.scene.instances.push(Instance::new(mesh, world_from_object));
        }
        for mesh in meshes.iter().filter(|m| !m.placed) {
            let instance = Instance::new(mesh.number, mesh.transform);
            self.loader.scene.instances.push(instance);
        }
        Ok(())
    }

    fn beside(&self, file: &Path) -> std::path::PathBuf {
        self.path.parent().unwrap_or(Path::new("")).join(file)
    }
}

/// The transform that applies `first` and then `then`.
fn after(then: &Transform, first: &Transform) -> Transform {
    if *first == Transform::default() {
        return *then;
    }
    Transform::from_affine(&then.affine().after(&first.affine()))
}
