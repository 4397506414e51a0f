//! The builder: how many cells, and what is in them; with the same bytes for any number of threads.

use crate::cells::{Item, bounds_of, can_be_cut};
use eosphor_core::geometry::Bounds;
use eosphor_core::hierarchy::{GridRoot, MAX_GRID_CELLS};
use rayon::prelude::*;

/// Cells for each primitive that are never exceeded.
const MOST_DENSE: f64 = 1e9;

/// How a grid is built.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GridOptions {
    /// Cells a primitive (Cleary and Wyvill 1988).
    pub density: f32,
    /// Cells of one grid, at most; never over 2^28.
    pub max_cells: u32,
    /// Cells are made larger until references are no more than this many times the primitives.
    pub max_duplication: f32,
}

impl Default for GridOptions {
    fn default() -> GridOptions {
        GridOptions { density: 5.0, max_cells: 1 << 26, max_duplication: 32.0 }
    }
}

/// The cells that a primitive is in, on each axis from the first to the last.
type CellRange = [(u32, u32); 3];

/// Appends a geometry's cells to the arrays, but not where the last cell ends.
pub(super) fn build_grid(
    items: &[Item],
    options: &GridOptions,
    starts: &mut Vec<u32>,
    references: &mut Vec<u32>,
) -> GridRoot {
    let first_cell = starts.len() as u32;
    if items.is_empty() {
        let none = Bounds { min: Default::default(), max: Default::default() };
        return GridRoot { cells: [0; 3], ..GridRoot::new(none, [1; 3], first_cell) };
    }
    let bounds = bounds_of(items);
    let allowed = items.len() as f64 * options.max_duplication.max(1.0) as f64 + 4096.0;
    // Finite, or quarters of it would never get small enough.
    let mut density = f64::from(options.density).min(MOST_DENSE);
    let (root, ranges) = loop {
        let root = GridRoot::new(bounds, resolution(&bounds, items.len(), density, options), first_cell);
        let ranges: Vec<CellRange> = items.par_iter().map(|item| range(&root, &item.bounds)).collect();
        let count: u64 = ranges.iter().map(cells_in).sum();
        if count as f64 <= allowed || root.cells == [1; 3] {
            break (root, ranges);
        }
        density *= 0.25;
    };
    fill(&root, items, &ranges, starts, references);
    root
}

fn cells_in(range: &CellRange) -> u64 {
    range.iter().map(|(first, last)| (last - first + 1) as u64).product()
}

/// Cells along each axis: cubes as far as possible, one cell where the box is flatter than that.
fn resolution(bounds: &Bounds, count: usize, density: f64, options: &GridOptions) -> [u32; 3] {
    if !can_be_cut(bounds) {
        return [1; 3];
    }
    let size = bounds.max - bounds.min;
    let size = [size.x as f64, size.y as f64, size.z as f64];
    let wanted = (count as f64 * density).min(options.max_cells.min(1 << 28) as f64).max(1.0);
    let mut flat = [false; 3];
    let mut edge = 0.0;
    for _ in 0..3 {
        let sides = size.iter().zip(flat).filter(|(_, flat)| !flat).map(|(s, _)| *s);
        let dimensions = flat.iter().filter(|f| !**f).count();
        if dimensions == 0 {
            break;
        }
        edge = (sides.product::<f64>() / wanted).powf(1.0 / dimensions as f64);
        let before = flat;
        for axis in 0..3 {
            flat[axis] |= size[axis] < edge;
        }
        if before == flat {
            break;
        }
    }
    [0, 1, 2].map(|axis| {
        let cells = size[axis] / edge;
        // NaN, of a box without size, casts to 0.
        if flat[axis] { 1 } else { (cells as u32).clamp(1, MAX_GRID_CELLS) }
    })
}

/// The cells within the margin of a box.
fn range(root: &GridRoot, bounds: &Bounds) -> CellRange {
    [0, 1, 2].map(|axis| {
        let (margin, count) = (root.margin(axis), root.cells[axis]);
        if count == 1 {
            return (0, 0);
        }
        let low = root.bounds.min[axis] as f64;
        let cell = root.cell[axis] as f64;
        // Casts of negative numbers make 0.
        let at = |x: f32, margin: f32| ((((x as f64 + margin as f64) - low) / cell) as u32).min(count - 1);
        (at(bounds.min[axis], -margin), at(bounds.max[axis], margin))
    })
}

/// Layer after layer of cells with the same z, layers in parallel.
fn fill(
    root: &GridRoot,
    items: &[Item],
    ranges: &[CellRange],
    starts: &mut Vec<u32>,
    references: &mut Vec<u32>,
) {
    let [nx, ny, nz] = root.cells;
    let mut in_layer: Vec<Vec<u32>> = vec![Vec::new(); nz as usize];
    for (number, [_, _, (first, last)]) in (0u32..).zip(ranges) {
        for z in *first..=*last {
            in_layer[z as usize].push(number);
        }
    }
    let layers: Vec<(Vec<u32>, Vec<u32>)> = in_layer
        .into_par_iter()
        .map(|numbers| {
            let cells = (nx * ny) as usize;
            let each_cell = |visit: &mut dyn FnMut(usize, u32)| {
                for &number in &numbers {
                    let [(x0, x1), (y0, y1), _] = ranges[number as usize];
                    for y in y0..=y1 {
                        for x in x0..=x1 {
                            visit((y * nx + x) as usize, number);
                        }
                    }
                }
            };
            // A counting sort: primitives come in the order of their numbers in every cell.
            let mut ends = vec![0u32; cells + 1];
            each_cell(&mut |cell, _| ends[cell + 1] += 1);
            for cell in 0..cells {
                ends[cell + 1] += ends[cell];
            }
            let starts = ends[..cells].to_vec();
            let mut held = vec![0u32; ends[cells] as usize];
            each_cell(&mut |cell, number| {
                held[ends[cell] as usize] = items[number as usize].reference;
                ends[cell] += 1;
            });
            (starts, held)
        })
        .collect();
    for (layer_starts, held) in layers {
        let base = references.len() as u32;
        starts.extend(layer_starts.iter().map(|start| base + start));
        references.extend_from_slice(&held);
    }
}
