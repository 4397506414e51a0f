//! Meshes and instances of a JSON scene.

use super::build::{Builder, MaterialNames};
use super::far::{PlacedMoves, exact_map};
use super::fault::quoted;
use super::format::{InstanceEntry, MeshEntry};
use super::nearest::hint;
use super::tree::{Node, Step, way};
use crate::error::SceneError;
use crate::files;
use crate::model::{Instance, Matrix, Move, Transform};
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
    spot: Spot,
    moves: Vec<Arc<Move>>,
    /// Whether an instance names it.
    used: bool,
}

/// Where a transform leads.
#[derive(Clone, Copy)]
struct Spot {
    transform: Transform,
    /// The map with all digits of the file, in scenes far from 0.
    exact: Option<Matrix>,
}

impl Spot {
    fn of(transform: Transform) -> Spot {
        Spot { transform, exact: None }
    }

    /// With all digits of the file.
    fn exactly(&self, node: Option<&Node>) -> Spot {
        let Some(exact) = node.map(exact_map) else { return *self };
        Spot { transform: Transform::exactly(&self.transform.affine(), exact.0[3]), exact: Some(exact) }
    }

    /// The spot that `first` and then this leads to.
    fn after(&self, first: &Spot) -> Spot {
        let nothing = Transform::default();
        let is_exact = |spot: &Spot| spot.exact.is_some() || spot.transform.offset != [0.0; 3];
        match (self.transform == nothing, first.transform == nothing) {
            (true, _) => return *first,
            (_, true) => return *self,
            _ => {}
        }
        // The linear part is the same as near 0.
        let map = self.transform.affine().after(&first.transform.affine());
        if !is_exact(self) && !is_exact(first) {
            return Spot::of(Transform::from_affine(&map));
        }
        let double = |spot: &Spot| spot.exact.unwrap_or_else(|| spot.transform.to_double());
        let exact = double(self).after(&double(first));
        Spot { transform: Transform::exactly(&map, exact.0[3]), exact: Some(exact) }
    }
}

/// An entry that places a mesh.
struct Placement {
    /// The number of the mesh.
    group: usize,
    material: Option<u32>,
    spot: Spot,
    moves: Vec<Arc<Move>>,
    origin: Origin,
}

fn add_moves(all: &mut PlacedMoves<'static>, moves: &[Arc<Move>], (list, number): Origin) {
    let ways = (0..).map(|k: usize| way![list, number, "moves", k]);
    all.extend(moves.iter().cloned().zip(ways));
}

impl Builder<'_> {
    /// Reads the meshes and places them: as the instances say, and once where none names the mesh. Where each placed
    /// instance comes from, and, in scenes far from 0, where its motions do. `origin` is what the file states.
    pub(super) fn place_meshes(
        &mut self,
        meshes: Vec<MeshEntry>,
        instances: Vec<InstanceEntry>,
        materials: &MaterialNames,
        origin: Option<[f64; 3]>,
    ) -> Result<(Vec<Origin>, PlacedMoves<'static>), SceneError> {
        let mut groups = self.groups(meshes, materials)?;
        let mut by_name: HashMap<String, Vec<usize>> = HashMap::new();
        for (i, group) in groups.iter().enumerate() {
            by_name.entry(group.name.clone()).or_default().push(i);
        }
        let mut placements = Vec::with_capacity(instances.len());
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
            placements.push(Placement {
                group,
                material,
                spot: Spot::of(transform),
                moves,
                origin: ("instances", i),
            });
        }
        for (i, _) in groups.iter().enumerate().filter(|(_, group)| !group.used) {
            let (spot, moves) = (Spot::of(Transform::default()), Vec::new());
            placements.push(Placement { group: i, material: None, spot, moves, origin: ("meshes", i) });
        }
        let mut origins = self.place_all(&groups, &placements)?;
        let mut all_moves = PlacedMoves::new();
        if self.is_far(origin) {
            // Once more, with all digits.
            for (i, group) in groups.iter_mut().enumerate() {
                group.spot = group.spot.exactly(self.document.root.at_end(&way!["meshes", i, "transform"]));
                add_moves(&mut all_moves, &group.moves, ("meshes", i));
            }
            for placement in &mut placements {
                let (list, i) = placement.origin;
                if list == "instances" {
                    let node = self.document.root.at_end(&way![list, i, "transform"]);
                    placement.spot = placement.spot.exactly(node);
                    add_moves(&mut all_moves, &placement.moves, placement.origin);
                }
            }
            self.loader.scene.instances.clear();
            origins = self.place_all(&groups, &placements)?;
        }
        Ok((origins, all_moves))
    }

    fn place_all(&mut self, groups: &[Group], placements: &[Placement]) -> Result<Vec<Origin>, SceneError> {
        let mut origins = Vec::with_capacity(placements.len());
        for placement in placements {
            self.place(&groups[placement.group], placement, &mut origins)?;
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
            groups.push(Group { name, placed, material, spot: Spot::of(transform), moves, used: false });
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
        placement: &Placement,
        origins: &mut Vec<Origin>,
    ) -> Result<(), SceneError> {
        let Placement { material, spot, moves, origin, .. } = placement;
        let origin = *origin;
        // What moves is moved before the instance's transform, which then is a motion that stays.
        let (outer, mut all) = match group.moves.is_empty() {
            true => (spot.after(&group.spot), Vec::new()),
            false => (group.spot, group.moves.clone()),
        };
        if !group.moves.is_empty() && spot.transform != Transform::default() {
            all.push(Arc::new(Move { transform: spot.transform, ..Move::default() }));
        }
        all.extend_from_slice(moves);
        let world_from_group = spot.after(&group.spot).transform.affine();
        if world_from_group.is_finite() && world_from_group.inverse().is_none() {
            let message = "the transform squashes the mesh flat; no scale may be 0";
            return Err(self.document.error_in(&way![origin.0, origin.1, "transform"], message));
        }
        // What moves within the model does so before all that is said of the model.
        let outside: Vec<Arc<Move>> = (outer.transform != Transform::default())
            .then(|| Arc::new(Move { transform: outer.transform, ..Move::default() }))
            .into_iter()
            .chain(all.iter().cloned())
            .collect();
        for placed in group.placed.iter() {
            let (world_from_object, moves) = match placed.moves.is_empty() {
                true => (outer.after(&Spot::of(placed.world_from_object)).transform, all.clone()),
                false => (placed.world_from_object, [&placed.moves[..], &outside].concat()),
            };
            let material = (*material).or(group.material).or(placed.material);
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
