//! Meshes of the file → meshes of the model. Ones that differ by their material alone become one.

use super::accessors::Accessors;
use super::assembly::{Assembly, Block};
use super::document::{self, Mode, Primitive};
use super::topology::{has_triangles, triangle_count};
use super::vertices::{VertexKey, Vertices};
use super::{Part, named};
use crate::files::warnings::Warnings;
use crate::model::Mesh;
use std::collections::HashMap;
use std::path::Path;

/// Which mesh of the model shows a mesh of the file, and in which material where not in its own.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Shown {
    pub(super) mesh: u32,
    /// Where its coordinates are counted from, in those of the file.
    pub(super) origin: [f64; 3],
    pub(super) material: Option<u32>,
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
    shown: HashMap<(usize, Vec<u32>), Option<Shown>>,
    /// Built meshes by shape, with their materials.
    by_shape: HashMap<Vec<Shape>, Vec<(Shown, Vec<u32>)>>,
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

    /// What shows a mesh of the file under the weights of a node, else its own.
    pub(super) fn show(&mut self, number: usize, weights: Option<&[f32]>) -> Result<Option<Shown>, String> {
        let mesh = named(&self.accessors.root.meshes, number, "mesh")?;
        let weights = weights.or(mesh.weights.as_deref()).unwrap_or_default();
        let key = (number, weights.iter().map(|w| w.to_bits()).collect());
        if let Some(shown) = self.shown.get(&key) {
            return Ok(*shown);
        }
        let name = Part::new("mesh", number, mesh.name.as_deref());
        let shown = self.build(mesh, &name, weights).map_err(|problem| format!("{name}, {problem}"))?;
        self.shown.insert(key, shown);
        Ok(shown)
    }

    fn build(
        &mut self,
        mesh: &document::Mesh,
        name: &Part,
        weights: &[f32],
    ) -> Result<Option<Shown>, String> {
        let mut surfaces = Vec::new();
        for (number, primitive) in mesh.primitives.iter().enumerate() {
            let surface = self.surface(number, primitive, name, weights);
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
        let one_material = materials.iter().all(|m| *m == materials[0]).then_some(materials[0]);
        for (mesh, own) in self.by_shape.get(&shape).into_iter().flatten() {
            if *own == materials {
                return Ok(Some(*mesh));
            }
            if one_material.is_some() {
                return Ok(Some(Shown { material: one_material, ..*mesh }));
            }
        }

        let mut assembly = Assembly::new(match &mesh.name {
            Some(name) => super::clean(name),
            None => name.to_string(),
        });
        for surface in surfaces {
            let number = surface.number;
            self.append(&mut assembly, &surface)
                .map_err(|problem| format!("primitive {number}: {problem}"))?;
        }
        let mut mesh = assembly.finish();
        let origin = mesh.count_from_own();
        self.built.push(mesh);
        let shown = Shown { mesh: self.built.len() as u32 - 1, origin, material: None };
        self.by_shape.entry(shape).or_default().push((shown, materials));
        Ok(Some(shown))
    }

    /// A primitive that has triangles; others are passed over.
    fn surface<'p>(
        &mut self,
        number: usize,
        primitive: &'p Primitive,
        mesh: &Part,
        weights: &[f32],
    ) -> Result<Option<Surface<'p>>, String> {
        let Some(mode) = primitive.mode else {
            return Err("its mode is unknown; it must be 0 to 6".into());
        };
        if !has_triangles(mode) {
            self.passed_over.push(format!("{mesh}, primitive {number}"));
            return Ok(None);
        }
        let Some(vertices) = VertexKey::new(primitive, weights) else {
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
