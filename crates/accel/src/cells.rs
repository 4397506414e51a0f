//! What the structures that divide space share: primitives with their bounds, and the tree over the instances.

use crate::bvh::{BuildOptions, Purpose, instance_tree};
use crate::{HierarchyStatistics, PackedPrimitives, SceneGeometry, cost};
use eosphor_core::geometry::{Bounds, Geometry};
use eosphor_core::hierarchy::{BvhNode, InstanceTreeView, SPHERE_REFERENCE};

/// A primitive on its way into cells.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Item {
    /// Its bounds, grown by [`CELL_PADDING`] of the extent.
    pub(crate) bounds: Bounds,
    /// Number of the triangle among those of all geometries, or of the sphere with [`SPHERE_REFERENCE`].
    pub(crate) reference: u32,
}

/// What primitives are grown by, over the extent of their geometry, before they are entered in cells: more than the rounding
/// of walks from cell to cell.
pub(crate) const CELL_PADDING: f32 = 1.0 / 131_072.0;

/// The primitives of a geometry; triangles first.
pub(crate) fn items(primitives: &PackedPrimitives, geometry: &Geometry) -> Vec<Item> {
    let padding = CELL_PADDING * geometry.extent;
    let triangles = primitives.triangle_bounds(geometry);
    let spheres = primitives.sphere_bounds(geometry);
    let numbered = move |first: u32, bounds: Vec<Bounds>| {
        (first..).zip(bounds).map(move |(reference, b)| Item { bounds: b.padded(padding), reference })
    };
    numbered(geometry.first_triangle, triangles)
        .chain(numbered(geometry.first_sphere | SPHERE_REFERENCE, spheres))
        .collect()
}

/// The box around all.
pub(crate) fn bounds_of(items: &[Item]) -> Bounds {
    items.iter().fold(Bounds::EMPTY, |b, item| b.union(&item.bounds))
}

/// Whether planes can be put between these coordinates.
pub(crate) fn can_be_cut(bounds: &Bounds) -> bool {
    bounds.min.is_finite() && bounds.max.is_finite() && (bounds.max - bounds.min).is_finite()
}

/// The tree over the instances but the world.
#[derive(Clone, Debug)]
pub(crate) struct InstanceTree {
    nodes: Vec<BvhNode>,
    order: Vec<u32>,
}

impl InstanceTree {
    pub(crate) fn build(scene: &SceneGeometry) -> InstanceTree {
        let tree = instance_tree(scene, &BuildOptions::default(), Purpose::Two);
        InstanceTree { nodes: tree.nodes, order: tree.order.iter().map(|i| i + 1).collect() }
    }

    pub(crate) fn view(&self) -> InstanceTreeView<'_> {
        InstanceTreeView { nodes: &self.nodes, root: 0, order: &self.order }
    }

    /// As [`cost::inner_nodes`].
    pub(crate) fn inner_nodes(&self) -> f64 {
        cost::inner_nodes(&self.nodes, 0)
    }

    pub(crate) fn bytes(&self) -> usize {
        size_of_val(&self.nodes[..]) + size_of_val(&self.order[..])
    }
}

/// Brings the triangles of the geometries from number `first_geometry` on into the order in which their cells name them first,
/// so that what is tested together lies together.
pub(crate) fn order_by_first_use(
    primitives: &mut PackedPrimitives,
    references: &mut [u32],
    first_geometry: usize,
) {
    // Cells of one geometry follow those of another, so each geometry keeps its range: cells name all its triangles.
    let Some(geometry) = primitives.geometries.get(first_geometry) else { return };
    let first = geometry.first_triangle;
    let old = primitives.triangles.split_off(first as usize);
    let mut new_numbers = vec![u32::MAX; old.len()];
    primitives.triangles.reserve_exact(old.len());
    for reference in references.iter_mut().filter(|r| **r & SPHERE_REFERENCE == 0) {
        let new_number = &mut new_numbers[(*reference - first) as usize];
        if *new_number == u32::MAX {
            *new_number = primitives.triangles.len() as u32;
            primitives.triangles.push(old[(*reference - first) as usize]);
        }
        *reference = *new_number;
    }
    assert_eq!(primitives.triangles.len(), first as usize + old.len(), "every triangle is in a cell");
}

/// Bytes of the packed primitives.
pub(crate) fn primitive_bytes(p: &PackedPrimitives) -> usize {
    size_of_val(&p.triangles[..]) + size_of_val(&p.spheres[..]) + size_of_val(&p.sphere_primitives[..])
}

/// Gathers statistics from leaf to leaf.
#[derive(Default)]
pub(crate) struct LeafCounts {
    depth_sum: u64,
}

impl LeafCounts {
    /// A leaf of `count` references.
    pub(crate) fn add(&mut self, s: &mut HierarchyStatistics, depth: u32, count: u32) {
        s.nodes += 1;
        s.leaves += 1;
        s.empty_leaves += (count == 0) as u64;
        s.references += count as u64;
        s.max_leaf_depth = s.max_leaf_depth.max(depth);
        s.max_leaf_primitives = s.max_leaf_primitives.max(count);
        self.depth_sum += depth as u64;
    }

    /// Means.
    pub(crate) fn finish(&self, s: &mut HierarchyStatistics) {
        s.mean_leaf_depth = self.depth_sum as f64 / s.leaves.max(1) as f64;
        s.mean_leaf_primitives = s.references as f64 / s.leaves.max(1) as f64;
    }
}
