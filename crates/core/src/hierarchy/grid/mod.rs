//! Uniform grid: the cells, and the scalar traversal by a three-dimensional digital differential analyser (Amanatides and
//! Woo 1987, "A fast voxel traversal algorithm for ray tracing").
//!
//! The walk goes through one cell after the other, and where the ray passes close to an edge or corner of cells, rounding
//! decides through which. So that this does not matter, primitives are entered in every cell within
//! [`GridRoot::margin`] of their padded bounds. That covers the rounding for rays that start within
//! [`GridRoot::reach`]; rays from further away take another walk ([`far`]), which needs no margin.

mod far;

use super::candidates::{Placement, PrimitivesView, trusted};
use super::cell_ray::{CellRay, in_time};
use super::references::{Mailbox, References};
use super::search::Search;
use super::two_level::{InstanceTreeView, SearchScene, answer_queries};
use super::{Tracer, Work};
use crate::geometry::Bounds;
use crate::intersect::LocalRay;
use crate::math::{Vec3, fma, min, vec3};
use crate::ray::{Hit, Ray, RayFilter};

/// Cells along an axis, at most.
pub const MAX_GRID_CELLS: u32 = 1024;

/// The planes that a walk computes and those of the slab test of a primitive differ by less than this times the largest
/// coordinate of geometry and ray: eight roundings of 2^-24 in the walk, and 2^-20 in the slab test.
const WALK_ROUNDING: f32 = 1.0 / 524_288.0;

/// The grid of one geometry.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C)]
pub struct GridRoot {
    /// Box of all cells, and of all primitives, padded.
    pub bounds: Bounds,
    /// Size of a cell.
    pub cell: Vec3,
    /// One over that.
    pub per_cell: Vec3,
    /// Number of cells along x, y and z; 0 for a geometry without primitives.
    pub cells: [u32; 3],
    /// Number of the first cell. Numbers grow along x, then y, then z.
    pub first_cell: u32,
    /// Largest absolute coordinate of origins whose rays can go from cell to cell.
    pub reach: f32,
}

impl GridRoot {
    /// From the box, the number of cells along each axis, and the first cell's number.
    pub fn new(bounds: Bounds, cells: [u32; 3], first_cell: u32) -> GridRoot {
        let size = bounds.max - bounds.min;
        let [x, y, z] = cells.map(|n| n as f32);
        let cell = vec3(size.x / x, size.y / y, size.z / z);
        let mut root = GridRoot {
            bounds,
            cell,
            per_cell: vec3(1.0 / cell.x, 1.0 / cell.y, 1.0 / cell.z),
            cells,
            first_cell,
            reach: f32::INFINITY,
        };
        let extent = bounds.min.abs().max(bounds.max.abs()).max_component();
        for axis in 0..3 {
            if cells[axis] > 1 {
                root.reach = root.reach.min(root.margin(axis) / WALK_ROUNDING - extent);
            }
        }
        root
    }

    /// By how much primitives are grown along an axis before they are entered in cells.
    pub fn margin(&self, axis: usize) -> f32 {
        self.cell[axis] * (1.0 / 64.0)
    }
}

/// A grid over every geometry, and a tree over the instances.
#[derive(Clone, Copy, Debug)]
pub struct GridView<'a> {
    /// For each geometry, its grid.
    pub roots: &'a [GridRoot],
    /// For each cell of all grids, where its references start; they end where the next one's start.
    pub starts: &'a [u32],
    /// What cells hold: numbers of triangles, or of spheres with [`super::SPHERE_REFERENCE`].
    pub references: &'a [u32],
    /// Finds instances.
    pub instances: InstanceTreeView<'a>,
    /// Primitives, in any order.
    pub primitives: PrimitivesView<'a>,
}

/// Traverses a [`GridView`].
#[derive(Clone, Copy, Debug)]
pub struct GridTracer<'a, C> {
    /// The grid.
    grid: GridView<'a>,
    /// Told what the traversal does ([`Work`]): each cell visited counts as one node.
    pub work: C,
}

/// One axis of a walk from cell to cell.
#[derive(Clone, Copy)]
struct Axis {
    /// Where the ray leaves the present cell across this axis.
    exit: f32,
    /// The number of the plane at `exit`. The lower side of the box is plane 0.
    plane: f32,
    /// From where the ray passes the lower side to the next plane.
    offset: f32,
    per_plane: f32,
    /// +1 or -1.
    step: f32,
    /// What a step adds to the number of the cell.
    stride: i32,
    /// How many more steps stay inside.
    left: u32,
}

impl Axis {
    /// From the cell that the ray is in at `enter`; also the cell's number along the axis.
    #[inline(always)]
    fn new(
        root: &GridRoot,
        cells: &CellRay,
        ray: &LocalRay,
        enter: f32,
        axis: usize,
        stride: u32,
    ) -> (Axis, u32) {
        let (inverse, count) = (cells.inverse[axis], root.cells[axis]);
        // The slab test's own idea of the direction, which has no zeros.
        let position = fma(enter, 1.0 / inverse, ray.origin[axis]);
        // Casts of what is out of range, or NaN, saturate.
        let at = (((position - root.bounds.min[axis]) * root.per_cell[axis]) as u32).min(count - 1);
        let backwards = inverse < 0.0;
        let mut new = Axis {
            exit: 0.0,
            plane: (at + !backwards as u32) as f32,
            offset: fma(root.bounds.min[axis], inverse, cells.offset[axis]),
            per_plane: root.cell[axis] * inverse,
            step: if backwards { -1.0 } else { 1.0 },
            stride: if backwards { -(stride as i32) } else { stride as i32 },
            left: if backwards { at } else { count - 1 - at },
        };
        new.exit = new.passes();
        (new, at * stride)
    }

    /// Where the ray passes the plane. Computed from its number and not added up, so that errors do not add up. The last
    /// cells reach on without end: where the ray leaves the box as a whole is known better.
    #[inline(always)]
    fn passes(&self) -> f32 {
        if self.left == 0 { f32::INFINITY } else { fma(self.plane, self.per_plane, self.offset) }
    }

    /// Goes on by one cell.
    #[inline(always)]
    fn advance(&mut self, cell: &mut u32) {
        self.left -= 1;
        self.plane += self.step;
        self.exit = self.passes();
        *cell = cell.wrapping_add_signed(self.stride);
    }
}

impl<'a, C: Work> GridTracer<'a, C> {
    /// Over trees whose numbers hold together.
    ///
    /// # Safety
    /// The view is [closed](crate::hierarchy#closed-views).
    #[inline(always)]
    pub unsafe fn new(grid: GridView<'a>, work: C) -> Self {
        GridTracer { grid, work }
    }
}

impl<C: Work> GridTracer<'_, C> {
    /// Tests what is in a cell; `true` ends the search.
    #[inline(always)]
    fn search_cell(&self, cell: u32, references: &mut References<'_, C>, search: &mut impl Search) -> bool {
        self.work.nodes(1);
        let first = *trusted(self.grid.starts, cell);
        let count = *trusted(self.grid.starts, cell + 1) - first;
        references.search(first, count, search)
    }

    /// From cell to cell. `true` ends the search.
    ///
    /// The walk visits a cell between two exits, the previous cell's and its own. Follow the primitive's s of
    /// `cell_ray.rs` to the first cell with s <= its exit: then all planes that the walk has crossed are met at s or
    /// before, and the cell's other planes at s or later. So the point at s is in that cell, but for rounding of less
    /// than [`WALK_ROUNDING`], which the primitive's margin covers.
    #[inline(always)]
    fn search_along(
        &self,
        root: &GridRoot,
        cells: &CellRay,
        (enter, leave): (f32, f32),
        references: &mut References<'_, C>,
        search: &mut impl Search,
    ) -> bool {
        let [nx, ny, _] = root.cells;
        let ray = references.ray;
        let (mut x, cell_x) = Axis::new(root, cells, ray, enter, 0, 1);
        let (mut y, cell_y) = Axis::new(root, cells, ray, enter, 1, nx);
        let (mut z, cell_z) = Axis::new(root, cells, ray, enter, 2, nx * ny);
        let mut cell = root.first_cell + cell_x + cell_y + cell_z;
        loop {
            if self.search_cell(cell, references, search) {
                return true;
            }
            let exit = min(x.exit, min(y.exit, z.exit));
            if (exit == f32::INFINITY) | (exit > leave) | !in_time(exit, search.t_max()) {
                return false;
            }
            if exit == x.exit {
                x.advance(&mut cell);
            } else if exit == y.exit {
                y.advance(&mut cell);
            } else {
                z.advance(&mut cell);
            }
        }
    }

    /// Whether rounding is small enough to go from cell to cell.
    #[inline(always)]
    fn is_near(root: &GridRoot, cells: &CellRay, ray: &LocalRay) -> bool {
        let inverse = cells.inverse.abs();
        let near_enough = ray.origin.abs().max_component() <= root.reach;
        // Overflow makes the slack infinite. Subnormal numbers have lost their digits.
        let known = cells.slack.is_finite() & ((root.bounds.max - root.bounds.min) * inverse).is_finite();
        near_enough & known & (inverse.min_component() > f32::MIN_POSITIVE)
    }
}

impl<C: Work> SearchScene for GridTracer<'_, C> {
    #[inline(always)]
    fn primitives(&self) -> &PrimitivesView<'_> {
        &self.grid.primitives
    }

    #[inline(always)]
    fn search_geometry(
        &self,
        geometry: u32,
        ray: &LocalRay,
        placement: &Placement<'_>,
        filter: &RayFilter,
        search: &mut impl Search,
    ) -> bool {
        let grid = &self.grid;
        let root = trusted(grid.roots, geometry);
        if root.cells[0] == 0 {
            return false;
        }
        let cells = CellRay::new(ray, &root.bounds);
        let Some(interval) = cells.enter(&root.bounds, ray.t_min, search.t_max()) else {
            return false;
        };
        let mut references = References {
            primitives: &grid.primitives,
            references: grid.references,
            ray,
            placement,
            filter,
            work: &self.work,
            mailbox: Some(Mailbox::new()),
        };
        if Self::is_near(root, &cells, ray) {
            self.search_along(root, &cells, interval, &mut references, search)
        } else {
            self.search_by_halves(root, &cells, interval, &mut references, search)
        }
    }

    #[inline(always)]
    fn search_instances(
        &self,
        world_ray: Option<&LocalRay>,
        ray: &Ray,
        filter: &RayFilter,
        search: &mut impl Search,
    ) -> bool {
        self.grid.instances.search(self, &self.work, world_ray, ray, filter, search)
    }
}

answer_queries!(GridTracer);
