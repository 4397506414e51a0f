//! Meshes and instances of a JSON scene.

use super::build::{Builder, MaterialNames};
use super::fault::quoted;
use super::format::{InstanceEntry, MeshEntry};
use super::nearest::hint;
use super::tree::{Step, way};
use crate::error::SceneError;
use crate::files;
use crate::model::{Instance, Move, Transform};
use std::collections::{HashMap, HashSet};
use std::path::PathBuf;
use std::rc::Rc;
use std::sync::Arc;

/// The list and the number of the entry that placed an instance.
pub(super) type Origin = (&'static str, usize);

/// A mesh of the file: everything that its model file places.
struct Group {
    name: String,
    placed: Rc<[Instance]>,
    material: Option<u32>,
    transform: Transform,
    moves: Vec<Arc<Move>>,
    /// Whether an instance names it.
    used: bool,
}

impl Builder<'_> {
    /// Reads the meshes and places them: as the instances say, and once where none names the mesh. Where each placed
    /// instance comes from.
    pub(super) fn place_meshes(
        &mut self,
        meshes: Vec<MeshEntry>,
        instances: Vec<InstanceEntry>,
        materials: &MaterialNames,
    ) -> Result<Vec<Origin>, SceneError> {
        let mut groups = self.groups(meshes, materials)?;
        let mut by_name: HashMap<String, Vec<usize>> = HashMap::new();
        for (i, group) in groups.iter().enumerate() {
            by_name.entry(group.name.clone()).or_default().push(i);
        }
        let mut origins = Vec::new();
        for (i, InstanceEntry { mesh, material, transform, moves }) in instances.into_iter().enumerate() {
            let way = way!["instances", i, "mesh"];
            let group = match by_name.get(&mesh).map(Vec::as_slice) {
                Some(&[group]) => group,
                Some(_) => {
                    let name = quoted(&mesh);
                    let message = format!("two meshes are called {name}; give each a \"name\" of its own");
                    return Err(self.document.error_in(&way, message));
                }
                None => {
                    let hint = hint(&mesh, groups.iter().map(|group| group.name.as_str()));
                    let message = format!("unknown mesh {}; {hint}", quoted(&mesh));
                    return Err(self.document.error_in(&way, message));
                }
            };
            groups[group].used = true;
            let material = self.material(material, materials, &way!["instances", i, "material"])?;
            let moves: Vec<_> = moves.into_iter().map(Arc::new).collect();
            self.place(&groups[group], material, &transform, &moves, ("instances", i), &mut origins)?;
        }
        for (i, group) in groups.iter().enumerate().filter(|(_, group)| !group.used) {
            self.place(group, None, &Transform::default(), &[], ("meshes", i), &mut origins)?;
        }
        Ok(origins)
    }

    /// Reads each model file once.
    fn groups(
        &mut self,
        entries: Vec<MeshEntry>,
        materials: &MaterialNames,
    ) -> Result<Vec<Group>, SceneError> {
        let mut read: HashMap<PathBuf, Rc<[Instance]>> = HashMap::new();
        let mut given_names = HashSet::new();
        let mut groups = Vec::with_capacity(entries.len());
        for (i, MeshEntry { file, name, material, transform, moves }) in entries.into_iter().enumerate() {
            if let Some(name) = name.as_ref().filter(|name| !given_names.insert((*name).clone())) {
                let message = format!("another mesh has the name {}; names must differ", quoted(name));
                return Err(self.document.error_in(&way!["meshes", i, "name"], message));
            }
            let material = self.material(material, materials, &way!["meshes", i, "material"])?;
            let full = self.beside(&file);
            let placed = match read.get(&full) {
                Some(placed) => Rc::clone(placed),
                None => {
                    let placed: Rc<[Instance]> = self.model(&full, &way!["meshes", i, "file"])?.into();
                    read.insert(full, Rc::clone(&placed));
                    placed
                }
            };
            let stem = || file.file_stem().unwrap_or_default().to_string_lossy().into_owned();
            let (name, moves) = (name.unwrap_or_else(stem), moves.into_iter().map(Arc::new).collect());
            groups.push(Group { name, placed, material, transform, moves, used: false });
        }
        Ok(groups)
    }

    /// Reads a model file. What is wrong inside it is said with its place there.
    fn model(&mut self, file: &std::path::Path, way: &[Step]) -> Result<Vec<Instance>, SceneError> {
        files::read_model(self.loader, file).map_err(|error| match error {
            SceneError::Read { .. } => self.document.error_in(way, format!("mesh: {error}")),
            SceneError::UnknownFormat { .. } => {
                let message = "a mesh must be an OBJ, glTF or PLY file: .obj, .gltf, .glb or .ply";
                self.document.error_in(way, message)
            }
            other => other,
        })
    }

    /// Places everything of a group.
    fn place(
        &mut self,
        group: &Group,
        material: Option<u32>,
        transform: &Transform,
        moves: &[Arc<Move>],
        origin: Origin,
        origins: &mut Vec<Origin>,
    ) -> Result<(), SceneError> {
        // What moves is moved before the instance's transform, which then is a motion that stays.
        let (outer, mut all) = match group.moves.is_empty() {
            true => (after(transform, &group.transform), Vec::new()),
            false => (group.transform, group.moves.clone()),
        };
        if !group.moves.is_empty() && *transform != Transform::default() {
            all.push(Arc::new(Move { transform: *transform, ..Move::default() }));
        }
        all.extend_from_slice(moves);
        let world_from_group = after(transform, &group.transform).affine();
        if world_from_group.is_finite() && world_from_group.inverse().is_none() {
            let message = "the transform squashes the mesh flat; no scale may be 0";
            return Err(self.document.error_in(&way![origin.0, origin.1, "transform"], message));
        }
        // What moves within the model does so before all that is said of the model.
        let outside: Vec<Arc<Move>> = (outer != Transform::default())
            .then(|| Arc::new(Move { transform: outer, ..Move::default() }))
            .into_iter()
            .chain(all.iter().cloned())
            .collect();
        for placed in group.placed.iter() {
            let (world_from_object, moves) = match placed.moves.is_empty() {
                true => (after(&outer, &placed.world_from_object), all.clone()),
                false => (placed.world_from_object, [&placed.moves[..], &outside].concat()),
            };
            let material = material.or(group.material).or(placed.material);
            self.loader.scene.instances.push(Instance {
                mesh: placed.mesh,
                material,
                world_from_object,
                moves,
            });
            origins.push(origin);
        }
        Ok(())
    }
}

/// The transform that applies `first` and then `then`.
fn after(then: &Transform, first: &Transform) -> Transform {
    let nothing = Transform::default();
    match (*then == nothing, *first == nothing) {
        (true, _) => *first,
        (_, true) => *then,
        _ => Transform::from_affine(&then.affine().after(&first.affine())),
    }
}
