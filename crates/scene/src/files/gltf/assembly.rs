//! One mesh of the model from the primitives of a mesh of the file.

use super::document::Mode;
use super::skins::Influences;
use super::topology::{face_normal, for_each_triangle, triangle_count};
use super::vertices::{TargetOffsets, VertexKey, Vertices};
use crate::model::{Deformation, Mesh, MorphBlock, MorphTarget, NO_INDEX, Triangle};
use std::collections::HashMap;

/// A mesh in the making.
pub(super) struct Assembly {
    mesh: Mesh,
    /// Vertices that are in the mesh already, for primitives that share them.
    blocks: HashMap<VertexKey, Block>,
    /// Where its vertices move.
    moving: Option<MovingVertices>,
}

/// What moves the vertices of a mesh in the making.
#[derive(Default)]
struct MovingVertices {
    /// For each normal, its vertex.
    normal_vertices: Vec<u32>,
    targets: Vec<MorphTarget>,
    influences: Influences,
}

/// A mesh whose vertices move, before anything moves them.
pub(super) struct Moving {
    /// Without weights and skin.
    pub(super) deformation: Deformation,
    pub(super) targets: Vec<MorphTarget>,
    pub(super) influences: Influences,
}

/// Vertices of a mesh.
#[derive(Clone, Copy)]
pub(super) struct Block {
    /// Number of the first in the mesh.
    first: u32,
    pub(super) count: usize,
    /// Number of the first one's normal, where they have normals.
    first_normal: Option<u32>,
    has_uvs: bool,
}

impl Assembly {
    /// `moves` says that its vertices move.
    pub(super) fn new(name: String, moves: bool) -> Assembly {
        let mesh = Mesh { name, ..Mesh::default() };
        Assembly { mesh, blocks: HashMap::new(), moving: moves.then(MovingVertices::default) }
    }

    pub(super) fn block(&self, key: &VertexKey) -> Option<Block> {
        self.blocks.get(key).copied()
    }

    /// Adds the vertices that the accessors of a key hold. Other primitives with the same key find them by it.
    pub(super) fn add_block(&mut self, key: &VertexKey, vertices: Vertices) -> Result<Block, String> {
        let block = self.add(vertices)?;
        self.blocks.insert(key.clone(), block);
        Ok(block)
    }

    /// Adds vertices that no other primitive shares.
    pub(super) fn add(&mut self, vertices: Vertices) -> Result<Block, String> {
        let mesh = &mut self.mesh;
        let (first, count) = (mesh.positions.len(), vertices.positions.len());
        let has_uvs = vertices.uvs.is_some();
        let number = |number: usize, more: usize| {
            let fits = number.checked_add(more).is_some_and(|sum| sum < NO_INDEX as usize);
            if fits { Ok(number as u32) } else { Err("the mesh has too many vertices for 32-bit numbers") }
        };
        let first_normal = match vertices.normals {
            Some(normals) => {
                let first_normal = number(mesh.normals.len(), normals.len())?;
                append(&mut mesh.normals, normals);
                Some(first_normal)
            }
            None => None,
        };
        let block = Block { first: number(first, count)?, count, first_normal, has_uvs };
        if let Some(moving) = &mut self.moving {
            moving.add(&block, mesh.normals.len(), vertices.targets, vertices.influences.as_ref())?;
        }
        append(&mut mesh.positions, vertices.positions);
        // These arrays run beside the positions: what earlier vertices lack is filled up.
        for (all, more) in [(&mut mesh.uvs, vertices.uvs), (&mut mesh.uvs1, vertices.uvs1)] {
            if let Some(more) = more {
                all.resize(first, [0.0; 2]);
                append(all, more);
            }
        }
        if let Some(colors) = vertices.colors {
            mesh.colors.resize(first, [1.0; 4]);
            append(&mut mesh.colors, colors);
        }
        Ok(block)
    }

    /// Adds triangles. The indices are of vertices of the block.
    pub(super) fn add_triangles(
        &mut self,
        mode: Mode,
        indices: &[u32],
        block: Block,
        material: u32,
    ) -> Result<(), String> {
        let count = triangle_count(mode, indices.len());
        let Mesh { positions, normals, triangles, .. } = &mut self.mesh;
        triangles.reserve(count);
        if block.first_normal.is_none() {
            if normals.len() + count >= NO_INDEX as usize {
                return Err("the mesh has too many normals for 32-bit numbers".into());
            }
            normals.reserve(count);
        }
        for_each_triangle(mode, indices, |corners| {
            let in_mesh = corners.map(|i| block.first + i);
            let normals = match block.first_normal {
                Some(first_normal) => corners.map(|i| first_normal + i),
                // The specification asks for flat normals where a file has none.
                None => {
                    normals.push(face_normal(in_mesh.map(|i| positions[i as usize])));
                    if let Some(moving) = &mut self.moving {
                        moving.normal_vertices.push(NO_INDEX);
                    }
                    [normals.len() as u32 - 1; 3]
                }
            };
            let uvs = if block.has_uvs { in_mesh } else { [NO_INDEX; 3] };
            triangles.push(Triangle { positions: in_mesh, normals, uvs, material });
        });
        Ok(())
    }

    /// The mesh, and what its vertices are moved by, where they are.
    pub(super) fn finish(self) -> (Mesh, Option<Moving>) {
        let mut mesh = self.mesh;
        let count = mesh.positions.len();
        for uvs in [&mut mesh.uvs, &mut mesh.uvs1] {
            if !uvs.is_empty() {
                uvs.resize(count, [0.0; 2]);
            }
        }
        if !mesh.colors.is_empty() {
            mesh.colors.resize(count, [1.0; 4]);
        }
        let moving = self.moving.map(|MovingVertices { normal_vertices, targets, influences }| Moving {
            deformation: Deformation {
                positions: mesh.positions.clone(),
                normals: mesh.normals.clone(),
                normal_vertices,
                morph: None,
                skin: None,
                origin: [0.0; 3],
            },
            targets,
            influences,
        });
        (mesh, moving)
    }
}

impl MovingVertices {
    /// Adds the vertices of a block, whose normals are the last of so many.
    fn add(
        &mut self,
        block: &Block,
        normals: usize,
        targets: Vec<TargetOffsets>,
        influences: Option<&Influences>,
    ) -> Result<(), String> {
        let end = block.first + block.count as u32;
        if block.first_normal.is_some() {
            self.normal_vertices.extend(block.first..end);
        }
        if self.targets.len() < targets.len() {
            self.targets.resize_with(targets.len(), MorphTarget::default);
        }
        let (first_vertex, first_normal) = (block.first, block.first_normal.unwrap_or(normals as u32));
        for (target, TargetOffsets { positions, normals }) in self.targets.iter_mut().zip(targets) {
            target.blocks.push(MorphBlock { first_vertex, first_normal, positions, normals });
        }
        influences.map_or(Ok(()), |influences| self.influences.append(influences))
    }
}

/// Moves where it can.
fn append<T>(to: &mut Vec<T>, mut from: Vec<T>) {
    if to.is_empty() {
        *to = from;
    } else {
        to.append(&mut from);
    }
}
