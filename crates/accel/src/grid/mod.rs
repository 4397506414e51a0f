//! Uniform grid.

mod build;

pub use build::GridOptions;

use crate::bvh::{RefitError, check_before};
use crate::cells::{self, InstanceTree, LeafCounts};
use crate::cost::{self, TreeCost};
use crate::{HierarchyStatistics, PackedPrimitives, SceneGeometry};
use eosphor_core::geometry::Bounds;
use eosphor_core::hierarchy::{GridRoot, GridTracer, GridView, InstanceTreeView, Work};
use eosphor_core::math::Vec3;
use std::time::Instant;

/// A grid over every geometry and a tree over the instances, in the arrays that devices read.
#[derive(Clone, Debug)]
pub struct Grid {
    /// The grid of each geometry, by the geometry's number.
    roots: Vec<GridRoot>,
    /// For each cell of all grids, where its references start; one more at the end.
    starts: Vec<u32>,
    /// What cells hold: numbers of triangles, or of spheres with [`eosphor_core::hierarchy::SPHERE_REFERENCE`].
    references: Vec<u32>,
    /// Primitives; triangles in the order in which cells name them first.
    primitives: PackedPrimitives,
    /// Wall time of the build, in seconds.
    pub build_seconds: f64,
    instances: InstanceTree,
}

impl Grid {
    /// Builds a hierarchy over a scene, on the threads of the current rayon pool. The result does not depend on their number.
    pub fn build(scene: &SceneGeometry, options: &GridOptions) -> Grid {
        let start = Instant::now();
        let mut grid = Grid {
            roots: Vec::new(),
            starts: Vec::new(),
            references: Vec::new(),
            primitives: PackedPrimitives::new(scene),
            build_seconds: 0.0,
            instances: InstanceTree::build(scene),
        };
        grid.add_from(0, scene, options);
        grid.build_seconds = start.elapsed().as_secs_f64();
        grid
    }

    /// Builds the grids of the geometries from number `first` on anew, and the tree over the instances. The result is what
    /// [`Grid::build`] makes of the scene, if the geometries before are as they were.
    ///
    /// # Errors
    /// Where the geometries before have other ranges in the scene; nothing is changed then.
    pub fn rebuild_from(
        &mut self,
        first: usize,
        scene: &SceneGeometry,
        options: &GridOptions,
    ) -> Result<(), RefitError> {
        check_before(&self.primitives.geometries, first, scene)?;
        let start = Instant::now();
        // The last of the starts is the end of the references.
        let cells = self.roots.get(first).map_or(self.starts.len() - 1, |root| root.first_cell as usize);
        self.references.truncate(self.starts[cells] as usize);
        self.starts.truncate(cells);
        self.roots.truncate(first);
        self.primitives.repack_from(first, scene);
        self.instances = InstanceTree::build(scene);
        self.add_from(first, scene, options);
        self.build_seconds = start.elapsed().as_secs_f64();
        Ok(())
    }

    /// Appends the grids of the geometries from this number on, whose primitives are packed.
    fn add_from(&mut self, first: usize, scene: &SceneGeometry, options: &GridOptions) {
        let before = self.references.len();
        for geometry in &scene.geometries()[first..] {
            let items = cells::items(&self.primitives, geometry);
            self.roots.push(build::build_grid(&items, options, &mut self.starts, &mut self.references));
        }
        self.starts.push(self.references.len() as u32);
        cells::order_by_first_use(&mut self.primitives, &mut self.references[before..], first);
    }

    /// The arrays of the hierarchy, borrowed, for devices and for tracers of eosphor-core.
    ///
    /// # Panics
    /// Where the hierarchy was built over instances alone.
    pub fn view(&self) -> GridView<'_> {
        self.view_with_instances_of(self)
    }

    /// The tree over the instances alone, which does not need the geometries.
    pub fn instance_tree(&self) -> InstanceTreeView<'_> {
        self.instances.view()
    }

    /// The arrays of the hierarchy, borrowed, with the instances of another one, `top`, in place of its own. That one may be built
    /// over the instances alone ([`SceneGeometry::of_instances`]).
    ///
    /// # Panics
    /// Where an instance is of a geometry that this hierarchy does not have.
    pub fn view_with_instances_of<'a>(&'a self, top: &'a Grid) -> GridView<'a> {
        GridView {
            roots: &self.roots,
            starts: &self.starts,
            references: &self.references,
            instances: top.instance_tree(),
            primitives: self.primitives.view_with_instances_of(&top.primitives),
        }
    }

    /// The traversal, one ray at a time. It tells `work` what it does; [`IgnoreWork`](crate::IgnoreWork) costs nothing.
    ///
    /// # Panics
    /// Where the hierarchy was built over instances alone ([`SceneGeometry::of_instances`]).
    pub fn tracer<C: Work>(&self, work: C) -> GridTracer<'_, C> {
        self.tracer_with_instances_of(self, work)
    }

    /// The traversal of [`Grid::tracer`], with the instances of another hierarchy, `top`, in place of the own ones. That one
    /// may be built over the instances alone ([`SceneGeometry::of_instances`]).
    ///
    /// # Panics
    /// Where an instance is of a geometry that this hierarchy does not have.
    pub fn tracer_with_instances_of<'a, C: Work>(&'a self, top: &'a Grid, work: C) -> GridTracer<'a, C> {
        // SAFETY: closed view: the fields are private, and builders make them so; `view_with_instances_of` checks the instances.
        unsafe { GridTracer::new(self.view_with_instances_of(top), work) }
    }

    /// The grid of each geometry, by the geometry's number.
    pub fn roots(&self) -> &[GridRoot] {
        &self.roots
    }

    /// For each cell of all grids, where its references start; one more at the end.
    pub fn starts(&self) -> &[u32] {
        &self.starts
    }

    /// What cells hold, one after the other: numbers of triangles in the array of primitives, or of spheres with
    /// [`eosphor_core::hierarchy::SPHERE_REFERENCE`].
    pub fn references(&self) -> &[u32] {
        &self.references
    }

    /// Primitives, in the order of the leaves.
    pub fn primitives(&self) -> &PackedPrimitives {
        &self.primitives
    }

    /// The grids of all geometries in numbers; the tree over the instances counts in the bytes alone. Cells are leaves
    /// at depth 1 below a root.
    pub fn statistics(&self) -> HierarchyStatistics {
        let p = &self.primitives;
        let mut s = HierarchyStatistics {
            structure: "grid",
            builder: "uniform",
            primitives: (p.triangles.len() + p.spheres.len()) as u64,
            bytes: (size_of_val(&self.starts[..])
                + size_of_val(&self.references[..])
                + size_of_val(&self.roots[..])
                + self.instances.bytes()
                + cells::primitive_bytes(p)) as u64,
            build_seconds: self.build_seconds,
            ..HierarchyStatistics::default()
        };
        let mut leaves = LeafCounts::default();
        let mut trees = vec![TreeCost::NOTHING; self.roots.len()];
        for (root, tree) in self.roots.iter().zip(&mut trees).filter(|(root, _)| root.cells[0] > 0) {
            s.nodes += 1;
            let count = root.cells.iter().product::<u32>() as usize;
            let starts = &self.starts[root.first_cell as usize..][..count + 1];
            // Each cell is visited, and what it holds tested.
            let work = count as f64 + f64::from(starts[count] - starts[0]);
            *tree = TreeCost::new(
                root.bounds,
                work * cost::half_area(&Bounds { min: Vec3::ZERO, max: root.cell }),
            );
            for pair in starts.windows(2) {
                leaves.add(&mut s, 1, pair[1] - pair[0]);
            }
        }
        leaves.finish(&mut s);
        s.sah_cost = cost::scene_cost(&trees, self.instances.inner_nodes(), &p.instances);
        s
    }
}
