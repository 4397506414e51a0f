//! The hierarchy, borrowed for traversals.

use super::{Bvh8, Child, EMPTY, Node8, TriangleBlock};
use eosphor_core::geometry::{Bounds, Geometry, Instance, Sphere};
use eosphor_core::hierarchy::FAR;
use eosphor_core::intersect::USUAL_REACH;

/// Trees over every geometry and one over the instances, which may be those of another hierarchy.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Bvh8View<'a> {
    /// Nodes of the geometries' trees.
    pub(super) nodes: &'a [Node8],
    /// Leaves of triangles.
    pub(super) blocks: &'a [TriangleBlock],
    pub(super) spheres: &'a [Sphere],
    pub(super) sphere_primitives: &'a [u32],
    /// For each geometry, its root.
    pub(super) roots: &'a [Child],
    pub(super) geometries: &'a [Geometry],
    /// For each geometry, as in [`Bvh8`].
    pub(super) farthest: &'a [f32],
    /// Of the first, which is the world's own: its root and size.
    pub(super) world_root: Child,
    pub(super) world: GeometrySize,
    /// Nodes of the tree over the instances, perhaps among others.
    pub(super) instance_nodes: &'a [Node8],
    pub(super) instance_root: Child,
    pub(super) instances: &'a [Instance],
    /// For each geometry, the box around it.
    pub(super) bounds: &'a [Bounds],
    /// The box around what instances place.
    pub(super) instance_bounds: Bounds,
    /// Rays with an origin that has no coordinate beyond this are not far from the world's own geometry.
    pub(super) near: f32,
}

/// How large a geometry is, as bounds for single rays need it.
#[derive(Clone, Copy, Debug)]
pub(super) struct GeometrySize {
    /// Its largest absolute coordinate.
    pub(super) extent: f32,
    /// How far a first vertex is from 0, with the lengths of its edges: as in [`Bvh8`].
    pub(super) farthest: f32,
}

impl Bvh8 {
    pub(super) fn view(&self) -> Bvh8View<'_> {
        let extent = self.bounds.first().map_or(0.0, Bounds::extent);
        Bvh8View {
            nodes: &self.nodes,
            blocks: &self.blocks,
            spheres: &self.spheres,
            sphere_primitives: &self.sphere_primitives,
            roots: &self.roots,
            geometries: &self.geometries,
            farthest: &self.farthest,
            world_root: self.roots.first().copied().unwrap_or(EMPTY),
            world: GeometrySize {
                extent: self.geometries.first().map_or(0.0, |geometry| geometry.extent),
                farthest: self.farthest.first().copied().unwrap_or(0.0),
            },
            instance_nodes: &self.nodes,
            instance_root: self.instance_root,
            instances: &self.instances,
            bounds: &self.bounds,
            instance_bounds: self.instance_bounds,
            near: if extent > 0.0 { USUAL_REACH.min(FAR * extent) } else { USUAL_REACH },
        }
    }
}

impl Bvh8View<'_> {
    /// How large a geometry is.
    #[inline(always)]
    pub(super) fn size_of(&self, geometry: usize) -> GeometrySize {
        GeometrySize { extent: self.geometries[geometry].extent, farthest: self.farthest[geometry] }
    }

    /// The largest absolute coordinate of all.
    pub(super) fn extent(&self) -> f32 {
        self.instance_bounds.extent().max(self.world.extent)
    }
}
