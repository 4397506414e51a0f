//! The vertices of a primitive: positions and what goes with them, in the renderer's conventions.

use super::accessors::Accessors;
use super::document::{Index, Primitive};
use super::skins::Influences;
use eosphor_core::math::{Vec3, vec3};

/// Which accessors the vertices of a primitive come from. Primitives with equal keys have equal vertices.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub(super) struct VertexKey {
    positions: usize,
    normals: Option<usize>,
    uvs: Option<usize>,
    uvs1: Option<usize>,
    colors: Option<usize>,
    /// Morph targets that are added once and for all: the accessors of positions and normals, and the bits of the weight.
    targets: Vec<(Option<usize>, Option<usize>, u32)>,
    /// Morph targets that are kept: the accessors of positions and normals.
    kept_targets: Vec<(Option<usize>, Option<usize>)>,
    /// The accessors of the joints that vertices follow, and of their weights, set by set.
    influences: Vec<(usize, usize)>,
}

/// What is done with morph targets.
#[derive(Clone, Copy)]
pub(super) enum Targets<'a> {
    /// They are added by these weights.
    Added(&'a [f32]),
    /// Their weights change: what they add is kept.
    Kept,
}

/// What a morph target adds to each vertex.
#[derive(Clone, Debug, Default)]
pub(super) struct TargetOffsets {
    pub(super) positions: Vec<Vec3>,
    pub(super) normals: Vec<Vec3>,
}

/// Vertices; every array that is there has one entry for each.
#[derive(Clone, Debug, Default)]
pub(super) struct Vertices {
    pub(super) positions: Vec<Vec3>,
    pub(super) normals: Option<Vec<Vec3>>,
    pub(super) uvs: Option<Vec<[f32; 2]>>,
    pub(super) uvs1: Option<Vec<[f32; 2]>>,
    pub(super) colors: Option<Vec<[f32; 4]>>,
    /// Of morph targets that are kept; arrays that are empty add nothing.
    pub(super) targets: Vec<TargetOffsets>,
    pub(super) influences: Option<Influences>,
    /// Normals and texture coordinates that were not finite and became 0.
    pub(super) mended: bool,
}

impl VertexKey {
    /// The key of a primitive under weights of its morph targets; `None` where it has no positions.
    pub(super) fn new(
        primitive: &Primitive,
        targets: Targets<'_>,
        influences: &[(usize, usize)],
    ) -> Option<VertexKey> {
        let attributes = &primitive.attributes;
        let all = primitive.targets.as_deref().unwrap_or_default();
        let (weights, kept) = match targets {
            Targets::Added(weights) => (weights, &[][..]),
            Targets::Kept => (&[][..], all),
        };
        let targets = all.iter().zip(weights).filter(|(_, weight)| **weight != 0.0);
        let value = |index: Option<Index>| index.map(Index::value);
        Some(VertexKey {
            positions: value(attributes.position)?,
            normals: value(attributes.normal),
            uvs: value(attributes.tex_coord_0),
            uvs1: value(attributes.tex_coord_1),
            colors: value(attributes.color_0),
            targets: targets
                .map(|(t, weight)| (value(t.position), value(t.normal), weight.to_bits()))
                .collect(),
            kept_targets: kept.iter().map(|t| (value(t.position), value(t.normal))).collect(),
            influences: influences.to_vec(),
        })
    }

    /// The accessor of the positions.
    pub(super) fn positions(&self) -> usize {
        self.positions
    }
}

impl Vertices {
    /// Reads them, the morph targets applied.
    pub(super) fn read(accessors: &Accessors<'_>, key: &VertexKey) -> Result<Vertices, String> {
        let mut positions = accessors.read(key.positions, vec3_of).map_err(|e| format!("POSITION: {e}"))?;
        let count = positions.len();
        let mut normals = optional("NORMAL", key.normals, count, |i| accessors.read(i, vec3_of))?;
        for &(of_positions, of_normals, weight) in &key.targets {
            let weight = f32::from_bits(weight);
            let read = |i| accessors.read(i, vec3_of);
            if let Some(offsets) = optional("a morph target's POSITION", of_positions, count, read)? {
                add(&mut positions, &offsets, weight);
            }
            let offsets = optional("a morph target's NORMAL", of_normals, count, read)?;
            if let (Some(normals), Some(offsets)) = (&mut normals, offsets) {
                add(normals, &offsets, weight);
            }
        }
        let mut targets = Vec::with_capacity(key.kept_targets.len());
        for &(of_positions, of_normals) in &key.kept_targets {
            let read = |i| accessors.read(i, vec3_of);
            let positions = optional("a morph target's POSITION", of_positions, count, read)?;
            let mut offsets = optional("a morph target's NORMAL", of_normals, count, read)?;
            // Normals of faces are found anew.
            offsets = offsets.filter(|_| normals.is_some());
            let (positions, normals) = (positions.unwrap_or_default(), offsets.unwrap_or_default());
            if !positions.iter().chain(&normals).all(|v| v.is_finite()) {
                return Err("a morph target has numbers that are not finite; export it again".into());
            }
            targets.push(TargetOffsets { positions, normals });
        }
        let influences = match key.influences.is_empty() {
            true => None,
            false => Some(Influences::read(accessors, &key.influences, count)?),
        };
        // The picture's v runs down in glTF, up here.
        let flipped = |[u, v]: [f32; 2]| [u, 1.0 - v];
        let mut uvs = optional("TEXCOORD_0", key.uvs, count, |i| accessors.read(i, flipped))?;
        let mut uvs1 = optional("TEXCOORD_1", key.uvs1, count, |i| accessors.read(i, flipped))?;
        let colors = optional("COLOR_0", key.colors, count, |i| match accessors.components(i)? {
            3 => accessors.read(i, |[r, g, b]: [f32; 3]| [r, g, b, 1.0].map(share)),
            _ => accessors.read(i, |rgba: [f32; 4]| rgba.map(share)),
        })?;
        // One | and not ||: all are mended.
        let mended = mend(normals.as_deref_mut(), |n| n.is_finite(), Vec3::ZERO)
            | mend(uvs.as_deref_mut(), is_finite, [0.0; 2])
            | mend(uvs1.as_deref_mut(), is_finite, [0.0; 2]);
        Ok(Vertices { positions, normals, uvs, uvs1, colors, targets, influences, mended })
    }

    /// The vertices of these numbers, in this order.
    pub(super) fn gathered(&self, numbers: &[u32]) -> Vertices {
        Vertices {
            positions: of(&self.positions, numbers),
            normals: self.normals.as_ref().map(|n| of(n, numbers)),
            uvs: self.uvs.as_ref().map(|uvs| of(uvs, numbers)),
            uvs1: self.uvs1.as_ref().map(|uvs| of(uvs, numbers)),
            colors: self.colors.as_ref().map(|colors| of(colors, numbers)),
            targets: self.targets.iter().map(|target| target.gathered(numbers)).collect(),
            influences: self.influences.as_ref().map(|influences| influences.gathered(numbers)),
            mended: self.mended,
        }
    }
}

impl TargetOffsets {
    fn gathered(&self, numbers: &[u32]) -> TargetOffsets {
        let some = |all: &[Vec3]| if all.is_empty() { Vec::new() } else { of(all, numbers) };
        TargetOffsets { positions: some(&self.positions), normals: some(&self.normals) }
    }
}

fn of<T: Copy>(all: &[T], numbers: &[u32]) -> Vec<T> {
    numbers.iter().map(|&i| all[i as usize]).collect()
}

/// An attribute that may be missing; one entry for each of `count` vertices.
fn optional<T>(
    name: &str,
    accessor: Option<usize>,
    count: usize,
    read: impl Fn(usize) -> Result<Vec<T>, String>,
) -> Result<Option<Vec<T>>, String> {
    let Some(accessor) = accessor else { return Ok(None) };
    let values = read(accessor).map_err(|problem| format!("{name}: {problem}"))?;
    if values.len() != count {
        return Err(format!("{name} has {} elements for {count} vertices; export it again", values.len()));
    }
    Ok(Some(values))
}

fn vec3_of([x, y, z]: [f32; 3]) -> Vec3 {
    vec3(x, y, z)
}

fn add(to: &mut [Vec3], offsets: &[Vec3], weight: f32) {
    for (to, offset) in to.iter_mut().zip(offsets) {
        *to += *offset * weight;
    }
}

fn is_finite(uv: &[f32; 2]) -> bool {
    uv[0].is_finite() & uv[1].is_finite()
}

/// Puts `instead` for values that are wrong; whether there were any.
fn mend<T: Copy>(values: Option<&mut [T]>, is_right: impl Fn(&T) -> bool, instead: T) -> bool {
    let mut mended = false;
    for value in values.into_iter().flatten() {
        if !is_right(value) {
            *value = instead;
            mended = true;
        }
    }
    mended
}

/// Colours are from 0 to 1 by the specification; what is no number counts as 0.
fn share(x: f32) -> f32 {
    if x > 0.0 { x.min(1.0) } else { 0.0 }
}
