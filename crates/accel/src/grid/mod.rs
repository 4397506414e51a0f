//! Uniform grid.

mod build;

pub use build::GridOptions;

use crate::cells::{self, InstanceTree, LeafCounts};
use crate::{HierarchyStatistics, PackedPrimitives, SceneGeometry};
use eosphor_core::hierarchy::{GridRoot, GridTracer, GridView, Work};
use std::time::Instant;

/// A grid over every geometry and a tree over the instances, in the arrays that devices read.
#[derive(Clone, Debug)]
pub struct Grid {
    /// For each geometry, its grid.
    pub roots: Vec<GridRoot>,
    /// For each cell of all grids, where its references start; one more at the end.
    pub starts: Vec<u32>,
    /// What cells hold: numbers of triangles, or of spheres with [`eosphor_core::hierarchy::SPHERE_REFERENCE`].
    pub references: Vec<u32>,
    /// Primitives; triangles in the order in which cells name them first.
    pub primitives: PackedPrimitives,
    /// Wall time of the build.
    pub build_seconds: f64,
    instances: InstanceTree,
}

impl Grid {
    /// Builds over a scene, on the threads of the current rayon pool. The result does not depend on their number.
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
        for geometry in scene.geometries {
            let items = cells::items(&grid.primitives, geometry);
            grid.roots.push(build::build_grid(&items, options, &mut grid.starts, &mut grid.references));
        }
        grid.starts.push(grid.references.len() as u32);
        cells::order_by_first_use(&mut grid.primitives, &mut grid.references);
        grid.build_seconds = start.elapsed().as_secs_f64();
        grid
    }

    /// Borrowed, for traversals and devices.
    pub fn view(&self) -> GridView<'_> {
        self.view_with_instances_of(self)
    }

    /// The same with the instances of another, which may be built over these alone ([`SceneGeometry::of_instances`]).
    pub fn view_with_instances_of<'a>(&'a self, top: &'a Grid) -> GridView<'a> {
        GridView {
            roots: &self.roots,
            starts: &self.starts,
            references: &self.references,
            instances: top.instances.view(),
            primitives: self.primitives.view_with_instances_of(&top.primitives),
        }
    }

    /// The traversal.
    pub fn tracer<C: Work>(&self, work: C) -> GridTracer<'_, C> {
        GridTracer { grid: self.view(), work }
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
        for (number, root) in self.roots.iter().enumerate().filter(|(_, root)| root.cells[0] > 0) {
            s.nodes += 1;
            let area = root.bounds.half_area() as f64;
            let cell = root.cell;
            let cell_area = (cell.x * cell.y + cell.y * cell.z + cell.z * cell.x) as f64;
            let share = if number == 0 && area > 0.0 { cell_area / area } else { 0.0 };
            let count = root.cells.iter().product::<u32>() as usize;
            s.sah_cost += share * count as f64;
            for pair in self.starts[root.first_cell as usize..][..count + 1].windows(2) {
                leaves.add(&mut s, 1, pair[1] - pair[0], share);
            }
        }
        leaves.finish(&mut s);
        s
    }
}
