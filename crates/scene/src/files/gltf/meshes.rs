//! Meshes of the file → meshes of the model. Ones that differ by their material alone become one.

use super::accessors::Accessors;
use super::animations::Animations;
use super::assembly::{Assembly, Block, Moving};
use super::document::{self, Mode, Primitive};
use super::skins::Skins;
use super::topology::{has_triangles, triangle_count};
use super::vertices::{Targets, VertexKey, Vertices};
use super::{Part, named};
use crate::files::warnings::Warnings;
use crate::model::{Mesh, Morph, Poses, Skin, SkinnedVertices, WeightTrack};
use std::collections::HashMap;
use std::path::Path;
use std::sync::Arc;

/// Which mesh of the model shows a mesh of the file, and in which material where not in its own.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Shown {
    pub(super) mesh: u32,
    /// Where its coordinates are counted from, in those of the file.
    pub(super) origin: [f64; 3],
    pub(super) material: Option<u32>,
    /// Whether it follows joints, and not the node that shows it.
    pub(super) is_skinned: bool,
}

/// How a node shows its mesh.
#[derive(Clone, Default, PartialEq, Eq, Hash)]
struct Pose {
    /// Bits of the weights of morph targets, where they stay.
    weights: Vec<u32>,
    /// The number of the sampler that moves them.
    weights_sampler: Option<usize>,
    /// The number of the skin.
    skin: Option<usize>,
}

/// What moves the vertices of a mesh.
#[derive(Default)]
struct Movers {
    track: Option<Arc<WeightTrack>>,
    skin: Option<Arc<Skin>>,
}

/// The triangles of a primitive, but for the material.
#[derive(Clone, PartialEq, Eq, Hash)]
struct Shape {
    mode: Mode,
    indices: Option<usize>,
    vertices: VertexKey,
}

/// A primitive that has triangles.
struct Surface<'a> {
    /// For messages.
    number: usize,
    primitive: &'a Primitive,
    mode: Mode,
    vertices: VertexKey,
    material: u32,
}

/// The vertices of a primitive.
enum Source {
    /// Another primitive of the mesh has brought them.
    InMesh(Block),
    Read(Vertices),
}

/// What a mesh is but for its materials: its shapes, the sampler of its weights, its skin.
type MovingShape = (Vec<Shape>, Option<usize>, Option<usize>);

/// Builds each mesh once.
pub(super) struct Meshes<'a> {
    accessors: &'a Accessors<'a>,
    path: &'a Path,
    warnings: &'a mut Warnings,
    /// Where the meshes go.
    built: &'a mut Vec<Mesh>,
    /// The model's number of the file's first material; that of what has none comes after the file's last.
    first_material: u32,
    /// Of each material of the file and the default one, whether a mesh has it.
    used_materials: Vec<bool>,
    /// What shows a mesh under weights of its morph targets; `None` where there is nothing to show.
    shown: HashMap<(usize, Pose), Option<Shown>>,
    /// Built meshes, with their materials.
    by_shape: HashMap<MovingShape, Vec<(Shown, Vec<u32>)>>,
    /// Vertices of which a mesh took a few; others may take more.
    large: HashMap<VertexKey, Vertices>,
    /// Primitives of points and lines.
    passed_over: Vec<String>,
}

impl<'a> Meshes<'a> {
    pub(super) fn new(
        accessors: &'a Accessors<'a>,
        path: &'a Path,
        warnings: &'a mut Warnings,
        built: &'a mut Vec<Mesh>,
        first_material: u32,
    ) -> Meshes<'a> {
        let used_materials = vec![false; accessors.root.materials.len() + 1];
        Meshes {
            accessors,
            path,
            warnings,
            built,
            first_material,
            used_materials,
            shown: HashMap::new(),
            by_shape: HashMap::new(),
            large: HashMap::new(),
            passed_over: Vec::new(),
        }
    }

    /// What shows a mesh of the file as a node says: under its weights, else those of the mesh, and with its skin.
    pub(super) fn show(
        &mut self,
        number: usize,
        node_number: usize,
        (animations, skins): (&mut Animations<'_>, &mut Skins<'_>),
    ) -> Result<Option<Shown>, String> {
        let mesh = named(&self.accessors.root.meshes, number, "mesh")?;
        let node = &self.accessors.root.nodes[node_number];
        let weights = node.weights.as_deref().or(mesh.weights.as_deref()).unwrap_or_default();
        let weights_sampler = animations.weights_sampler(node_number);
        let skin = node.skin.map(|skin| skin.value());
        let weight_bits = match weights_sampler {
            Some(_) => Vec::new(),
            None => weights.iter().map(|w| w.to_bits()).collect(),
        };
        let pose = Pose { weights: weight_bits, weights_sampler, skin };
        let key = (number, pose);
        if let Some(shown) = self.shown.get(&key) {
            return Ok(*shown);
        }
        let name = Part::new("mesh", number, mesh.name.as_deref());
        let mut pose = key.1.clone();
        pose.skin = pose.skin.filter(|_| self.can_be_skinned(mesh, &name));
        let track = weights_sampler.map(|sampler| animations.weights(sampler, mesh.target_count()));
        let movers = Movers {
            track: track.transpose()?.flatten(),
            skin: pose.skin.map(|skin| skins.skin(skin)).transpose()?,
        };
        let shown = self.build(mesh, &name, weights, &pose, movers);
        let shown = shown.map_err(|problem| format!("{name}, {problem}"))?;
        self.shown.insert(key, shown);
        Ok(shown)
    }

    /// Whether all that is shown of a mesh says which joints it follows.
    fn can_be_skinned(&mut self, mesh: &document::Mesh, name: &Part) -> bool {
        let is_shown = |p: &&Primitive| p.mode.is_some_and(has_triangles) && p.attributes.position.is_some();
        let has_joints = |p: &Primitive| p.attributes.joints.contains_key(&0);
        let can_be = mesh.primitives.iter().filter(is_shown).all(has_joints);
        if !can_be {
            let message = format!("{name} does not follow its skin: a primitive has no JOINTS_0");
            self.warnings.add(self.path, None, message);
        }
        can_be
    }

    fn build(
        &mut self,
        mesh: &document::Mesh,
        name: &Part,
        weights: &[f32],
        pose: &Pose,
        movers: Movers,
    ) -> Result<Option<Shown>, String> {
        let targets = if movers.track.is_some() { Targets::Kept } else { Targets::Added(weights) };
        let is_skinned = movers.skin.is_some();
        let mut surfaces = Vec::new();
        for (number, primitive) in mesh.primitives.iter().enumerate() {
            let surface = self.surface(number, primitive, name, (targets, is_skinned));
            surfaces.extend(surface.map_err(|problem| format!("primitive {number}: {problem}"))?);
        }
        if surfaces.is_empty() {
            return Ok(None);
        }
        let materials: Vec<u32> = surfaces.iter().map(|s| s.material).collect();
        for &material in &materials {
            self.used_materials[(material - self.first_material) as usize] = true;
        }
        let shape: Vec<Shape> = surfaces.iter().map(Surface::shape).collect();
        let shape = (shape, pose.weights_sampler, pose.skin);
        let one_material = materials.iter().all(|m| *m == materials[0]).then_some(materials[0]);
        for (mesh, own) in self.by_shape.get(&shape).into_iter().flatten() {
            if *own == materials {
                return Ok(Some(*mesh));
            }
            if one_material.is_some() {
                return Ok(Some(Shown { material: one_material, ..*mesh }));
            }
        }

        let mesh_name = mesh.name.as_ref().map_or_else(|| name.to_string(), |name| super::clean(name));
        let mut assembly = Assembly::new(mesh_name, is_skinned || movers.track.is_some());
        for surface in surfaces {
            let number = surface.number;
            self.append(&mut assembly, &surface)
                .map_err(|problem| format!("primitive {number}: {problem}"))?;
        }
        let (mut mesh, moving) = assembly.finish();
        let origin = match moving {
            Some(moving) => move_vertices(&mut mesh, moving, movers)?,
            None => mesh.count_from_own(),
        };
        self.built.push(mesh);
        let shown = Shown { mesh: self.built.len() as u32 - 1, origin, material: None, is_skinned };
        self.by_shape.entry(shape).or_default().push((shown, materials));
        Ok(Some(shown))
    }

    /// A primitive that has triangles; others are passed over.
    fn surface<'p>(
        &mut self,
        number: usize,
        primitive: &'p Primitive,
        mesh: &Part,
        (targets, is_skinned): (Targets<'_>, bool),
    ) -> Result<Option<Surface<'p>>, String> {
        let Some(mode) = primitive.mode else {
            return Err("its mode is unknown; it must be 0 to 6".into());
        };
        if !has_triangles(mode) {
            self.passed_over.push(format!("{mesh}, primitive {number}"));
            return Ok(None);
        }
        let influences = if is_skinned { sets_of_joints(primitive)? } else { Vec::new() };
        let Some(vertices) = VertexKey::new(primitive, targets, &influences) else {
            let message = format!("{mesh}, primitive {number} has no positions; it is left out");
            self.warnings.add(self.path, None, message);
            return Ok(None);
        };
        let is_compressed = primitive.extensions.as_ref().is_some_and(|e| e.draco.is_some());
        let position = self.accessors.root.accessors.get(vertices.positions());
        if is_compressed && position.is_some_and(|a| a.buffer_view.is_none() && a.sparse.is_none()) {
            let draco = "KHR_draco_mesh_compression";
            return Err(format!("it is there by {draco} alone, which is not supported; export without it"));
        }
        let materials = self.accessors.root.materials.len();
        let material = primitive.material.map_or(materials, |index| index.value());
        if material > materials || (material == materials && primitive.material.is_some()) {
            return Err(format!("material {material} does not exist; there are {materials}"));
        }
        let material = self.first_material + material as u32;
        Ok(Some(Surface { number, primitive, mode, vertices, material }))
    }

    /// Adds the triangles of a primitive, and its vertices where they are not there yet.
    fn append(&mut self, assembly: &mut Assembly, surface: &Surface<'_>) -> Result<(), String> {
        let key = &surface.vertices;
        let source = match assembly.block(key) {
            Some(block) => Source::InMesh(block),
            None => Source::Read(self.vertices(key)?),
        };
        let count = match &source {
            Source::InMesh(block) => block.count,
            Source::Read(vertices) => vertices.positions.len(),
        };
        let mut indices = match surface.primitive.indices {
            Some(accessor) => self.accessors.indices(accessor.value())?,
            None => {
                self.accessors.budget.spend(count as u64)?;
                (0..u32::try_from(count).map_err(|_| "it has too many vertices")?).collect()
            }
        };
        check(&indices, count)?;
        if surface.mode == Mode::Triangles && indices.len() % 3 != 0 {
            let message = "a list of triangles does not end with a whole one; the rest is left out";
            self.warnings.add(self.path, None, message);
        }
        let block = match source {
            Source::InMesh(block) => block,
            // A few vertices of many: only these, so that meshes that share one large array stay small.
            Source::Read(vertices) if indices.len() < count / 2 => {
                let used = renumber(&mut indices);
                let block = assembly.add(vertices.gathered(&used))?;
                self.large.insert(key.clone(), vertices);
                block
            }
            Source::Read(vertices) => assembly.add_block(key, vertices)?,
        };
        // Flat normals are one a triangle.
        self.accessors.budget.spend(triangle_count(surface.mode, indices.len()) as u64)?;
        assembly.add_triangles(surface.mode, &indices, block, surface.material)
    }

    /// Reads vertices; those of large arrays once.
    fn vertices(&mut self, key: &VertexKey) -> Result<Vertices, String> {
        if let Some(vertices) = self.large.remove(key) {
            return Ok(vertices);
        }
        let vertices = Vertices::read(self.accessors, key)?;
        if vertices.mended {
            let message = "normals or texture coordinates that are not finite are taken for 0";
            self.warnings.add(self.path, None, message);
        }
        Ok(vertices)
    }

    /// A mesh of the model.
    pub(super) fn built(&self, number: u32) -> &Mesh {
        &self.built[number as usize]
    }

    /// Says what was passed over.
    pub(super) fn finish(self) -> Vec<bool> {
        const NAMED: usize = 3;
        let count = self.passed_over.len();
        if count > 0 {
            let names = self.passed_over[..count.min(NAMED)].join("; ");
            let more = if count > NAMED { "; ..." } else { "" };
            let message = format!("{count} primitives of points or lines are not rendered: {names}{more}");
            self.warnings.add(self.path, None, message);
        }
        self.used_materials
    }
}

impl Surface<'_> {
    fn shape(&self) -> Shape {
        Shape {
            mode: self.mode,
            indices: self.primitive.indices.map(|i| i.value()),
            vertices: self.vertices.clone(),
        }
    }
}

/// Gives a mesh what moves its vertices, and the vertices where they are at first. Where nothing moves after all, they stay there.
/// From where its coordinates are counted.
fn move_vertices(mesh: &mut Mesh, moving: Moving, movers: Movers) -> Result<[f64; 3], String> {
    let Moving { mut deformation, targets, influences } = moving;
    deformation.morph = movers.track.map(|weights| Morph { targets, weights });
    if let Some(skin) = movers.skin {
        let last = influences.last_joint().unwrap_or(0);
        if last as usize >= skin.joints.len() {
            let count = skin.joints.len();
            return Err(format!("a vertex follows joint {last}, and its skin has {count}; export it again"));
        }
        deformation.skin =
            Some(SkinnedVertices { starts: influences.starts, influences: influences.list, skin });
    }
    let mut poses = Poses::at(0.0);
    deformation.origin = deformation.shape(mesh, &mut poses).count_from_own();
    *mesh = deformation.shape(mesh, &mut poses);
    let origin = deformation.origin;
    mesh.deformation = deformation.moves().then(|| Arc::new(deformation));
    Ok(origin)
}

/// The accessors of the sets of joints and weights of a primitive, from set 0 on.
fn sets_of_joints(primitive: &Primitive) -> Result<Vec<(usize, usize)>, String> {
    let document::Attributes { joints, weights, .. } = &primitive.attributes;
    if let Some(n) = joints.keys().find(|n| !weights.contains_key(n)) {
        return Err(format!("there is JOINTS_{n} and no WEIGHTS_{n}; export it again"));
    }
    if let Some(n) = weights.keys().find(|n| !joints.contains_key(n)) {
        return Err(format!("there is WEIGHTS_{n} and no JOINTS_{n}; export it again"));
    }
    if let Some((n, _)) = joints.keys().enumerate().find(|(place, n)| *place != **n as usize) {
        return Err(format!("there is no JOINTS_{n}, though there are later ones; export it again"));
    }
    Ok(joints.values().zip(weights.values()).map(|(j, w)| (j.value(), w.value())).collect())
}

/// Whether all indices are of vertices that exist.
fn check(indices: &[u32], vertices: usize) -> Result<(), String> {
    let Some(&largest) = indices.iter().max() else { return Ok(()) };
    if (largest as usize) < vertices {
        return Ok(());
    }
    let hint = match largest {
        0xff | 0xffff | u32::MAX => " (glTF knows no restart index)",
        _ => "",
    };
    Err(format!("index {largest} is out of range; there are {vertices} vertices{hint}; mend the file"))
}

/// Numbers the vertices that are used from 0 on, in their old order; their old numbers.
fn renumber(indices: &mut [u32]) -> Vec<u32> {
    let mut used = indices.to_vec();
    used.sort_unstable();
    used.dedup();
    for index in indices {
        *index = used.binary_search(index).unwrap_or_default() as u32;
    }
    used
}
