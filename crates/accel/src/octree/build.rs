//! The builder: level after level, nodes of a level in parallel, with the same bytes for any number of threads.

use super::overlap::{Cell, box_overlaps, triangle_overlaps};
use crate::PackedPrimitives;
use crate::cells::{CELL_PADDING, Item, bounds_of, can_be_cut};
use eosphor_core::geometry::{Bounds, Geometry};
use eosphor_core::hierarchy::{MAX_OCTREE_DEPTH, OctreeNode, OctreeRoot, SPHERE_REFERENCE};
use eosphor_core::math::Vec3;
use rayon::prelude::*;

/// When a primitive is entered in a cell.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Overlap {
    /// Its padded bounds reach into the cell.
    Bounds,
    /// The triangle itself, padded by as much, reaches into the cell: 13 separating axes (Akenine-Möller 2001). It saves
    /// tests, and it is what PG1 does.
    #[default]
    Triangle,
    /// The triangle reaches into the cell, nothing padded: exactly as PG1 does, for statistics. It loses hits.
    UnpaddedTriangle,
}

/// How an octree is built.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OctreeOptions {
    /// Cells with more primitives are divided.
    pub max_leaf_primitives: u32,
    /// Depth of the deepest leaves; a root has depth 0. At most [`MAX_OCTREE_DEPTH`].
    pub max_depth: u32,
    /// When a primitive is entered in a cell.
    pub overlap: Overlap,
    /// Divide a cell only if that makes it cheaper to search, and cells that are not much larger than the padding of
    /// bounds never.
    pub only_if_cheaper: bool,
    /// What visiting a node costs, in tests of a primitive, beyond the one that [`OctreeOptions::only_if_cheaper`]
    /// takes for an inner node anyway.
    pub visit_cost: f32,
    /// Division ends with the level at which references are more than this many times the primitives.
    pub max_duplication: f32,
}

impl Default for OctreeOptions {
    fn default() -> OctreeOptions {
        OctreeOptions {
            max_leaf_primitives: 16,
            max_depth: 10,
            overlap: Overlap::Triangle,
            only_if_cheaper: true,
            visit_cost: 0.0,
            max_duplication: 24.0,
        }
    }
}

impl OctreeOptions {
    /// For the parametric traversal, which visits only what the ray passes: division goes on, past PG1's 16, while it
    /// pays. Of PG1's scene that saves tests, visits and a third of the references over a fixed bound of 8.
    pub fn parametric() -> OctreeOptions {
        OctreeOptions { max_leaf_primitives: 2, visit_cost: 1.0, ..OctreeOptions::default() }
    }

    /// Exactly as PG1 builds its own, for statistics beside those that it publishes. Not for pictures.
    pub fn pg1() -> OctreeOptions {
        OctreeOptions {
            overlap: Overlap::UnpaddedTriangle,
            only_if_cheaper: false,
            ..OctreeOptions::default()
        }
    }
}

/// Cells along an axis are at least this part of those along the longest one, so that flat geometry is not cut across
/// its thickness.
const FLATTEST: f32 = 1.0 / 8.0;

/// A cell of the present level.
struct Open {
    node: usize,
    cell: Cell,
    items: Vec<u32>,
}

/// Builds the tree of one geometry.
pub(super) struct Builder<'a> {
    options: &'a OctreeOptions,
    primitives: &'a PackedPrimitives,
    items: Vec<Item>,
    padding: f64,
}

impl Builder<'_> {
    /// For the geometry's items, of which there is at least one.
    pub(super) fn new<'a>(
        primitives: &'a PackedPrimitives,
        geometry: &Geometry,
        items: Vec<Item>,
        options: &'a OctreeOptions,
    ) -> Builder<'a> {
        let mut builder =
            Builder { options, primitives, items, padding: (CELL_PADDING * geometry.extent) as f64 };
        if options.overlap == Overlap::UnpaddedTriangle {
            builder.padding = 0.0;
            for item in builder.items.iter_mut().filter(|item| item.reference & SPHERE_REFERENCE == 0) {
                item.bounds = primitives.triangles[item.reference as usize].bounds();
            }
        }
        builder
    }

    /// Appends to the arrays.
    pub(super) fn build(self, nodes: &mut Vec<OctreeNode>, references: &mut Vec<u32>) -> OctreeRoot {
        let bounds = root_cell(&bounds_of(&self.items));
        let root = OctreeRoot { bounds, node: nodes.len() as u32 };
        let max_depth =
            if can_be_cut(&bounds) { self.options.max_depth.min(MAX_OCTREE_DEPTH as u32) } else { 0 };
        let allowed = self.items.len() as f64 * self.options.max_duplication as f64 + 65_536.0;
        nodes.push(EMPTY);
        let all = (0..self.items.len() as u32).collect();
        let mut level = vec![Open { node: root.node as usize, cell: Cell::of(&bounds), items: all }];
        let (mut depth, mut in_leaves) = (0, 0);
        while !level.is_empty() {
            let may_divide = depth < max_depth;
            let divided: Vec<_> =
                level.par_iter().map(|open| if may_divide { self.divide(open) } else { None }).collect();
            let in_children = |d: &Option<[Vec<u32>; 8]>| d.iter().flatten().map(Vec::len).sum::<usize>();
            let total = in_leaves + divided.iter().map(in_children).sum::<usize>();
            let too_many = total as f64 > allowed;
            let mut next = Vec::new();
            for (open, divided) in level.into_iter().zip(divided) {
                match divided {
                    Some(octants) if !too_many => enter_children(open, octants, nodes, &mut next),
                    _ => {
                        in_leaves += open.items.len();
                        let first = references.len() as u32;
                        nodes[open.node] = OctreeNode { first, octants_or_count: open.items.len() as u32 };
                        references.extend(open.items.iter().map(|&i| self.items[i as usize].reference));
                    }
                }
            }
            level = next;
            depth += 1;
        }
        root
    }

    /// What is in each octant, or `None` where the cell stays whole.
    fn divide(&self, open: &Open) -> Option<[Vec<u32>; 8]> {
        let count = open.items.len();
        if count <= self.options.max_leaf_primitives as usize {
            return None;
        }
        let only_if_cheaper = self.options.only_if_cheaper;
        if only_if_cheaper && open.cell.half.iter().any(|&h| h < 8.0 * self.padding) {
            return None;
        }
        let octant = |o: usize| -> Vec<u32> {
            let cell = open.cell.octant(o);
            open.items.iter().copied().filter(|&i| self.overlaps(i, &cell)).collect()
        };
        let octants: Vec<Vec<u32>> = if count > 1024 {
            (0..8).into_par_iter().map(octant).collect()
        } else {
            (0..8).map(octant).collect()
        };
        let sum: usize = octants.iter().map(Vec::len).sum();
        // A ray through the cell passes each octant with a chance of a quarter, the ratio of surfaces.
        let visit_cost = f64::from(self.options.visit_cost);
        let children = octants.iter().filter(|octant| !octant.is_empty()).count() as f64;
        let divided = 1.0 + visit_cost + 0.25 * (sum as f64 + visit_cost * children);
        if only_if_cheaper && divided >= count as f64 {
            return None;
        }
        Some(octants.try_into().expect("eight octants"))
    }

    fn overlaps(&self, index: u32, cell: &Cell) -> bool {
        let item = &self.items[index as usize];
        if !box_overlaps(&item.bounds, cell) {
            return false;
        }
        if self.options.overlap == Overlap::Bounds || item.reference & SPHERE_REFERENCE != 0 {
            return true;
        }
        let triangle = &self.primitives.triangles[item.reference as usize];
        triangle_overlaps(triangle, self.padding, cell)
    }
}

const EMPTY: OctreeNode = OctreeNode { first: 0, octants_or_count: 0 };

/// Makes an inner node, and children for the octants that hold something.
fn enter_children(open: Open, octants: [Vec<u32>; 8], nodes: &mut Vec<OctreeNode>, next: &mut Vec<Open>) {
    let mut node = OctreeNode { first: nodes.len() as u32, octants_or_count: OctreeNode::INNER };
    for (o, items) in octants.into_iter().enumerate().filter(|(_, items)| !items.is_empty()) {
        node.octants_or_count |= 1 << o;
        next.push(Open { node: nodes.len(), cell: open.cell.octant(o), items });
        nodes.push(EMPTY);
    }
    nodes[open.node] = node;
}

/// The box, made thicker upwards where it is flat: what lies low in a cell stays out of its upper half.
fn root_cell(bounds: &Bounds) -> Bounds {
    let size = bounds.max - bounds.min;
    let least = Vec3::splat(size.max_component() * FLATTEST);
    Bounds { min: bounds.min, max: bounds.max.max(bounds.min + size.max(least)) }
}
