//! The walk for rays from far away: the grid is taken as a tree over ranges of cells, halved along their longest axis.

use super::{GridRoot, GridTracer};
use crate::hierarchy::cell_ray::{CellRay, in_time};
use crate::hierarchy::references::References;
use crate::hierarchy::search::Search;
use crate::hierarchy::{Stack, Work};
use crate::math::{fma, max, min};

/// Halving 1024 cells along each axis ends after 30 steps.
const MAX_DEPTH: usize = 32;

/// Cells from `first` to before `end` on each axis, and where the ray is among them.
#[derive(Clone, Copy)]
struct Range {
    first: [u32; 3],
    end: [u32; 3],
    enter: f32,
    leave: f32,
}

impl Range {
    /// The axis with the most cells.
    #[inline(always)]
    fn longest(&self) -> (usize, u32) {
        let [x, y, z] =
            [self.end[0] - self.first[0], self.end[1] - self.first[1], self.end[2] - self.first[2]];
        if x >= y && x >= z {
            (0, x)
        } else if y >= z {
            (1, y)
        } else {
            (2, z)
        }
    }
}

impl<C: Work> GridTracer<'_, C> {
    /// From range to range, by `cell_ray.rs`'s argument, as in a kd-tree. `true` ends the search.
    #[inline(always)]
    pub(super) fn search_by_halves(
        &self,
        root: &GridRoot,
        cells: &CellRay,
        (enter, leave): (f32, f32),
        references: &mut References<'_, C>,
        search: &mut impl Search,
    ) -> bool {
        let mut storage = Stack::<Range, MAX_DEPTH>::storage();
        let mut stack = Stack::new(&mut storage);
        let mut range = Range { first: [0; 3], end: root.cells, enter, leave };
        loop {
            let (axis, count) = range.longest();
            if count > 1 {
                let half = range.first[axis] + count / 2;
                let plane = fma(half as f32, root.cell[axis], root.bounds.min[axis]);
                let (mut first, mut second) = (range, range);
                if cells.inverse[axis] < 0.0 {
                    (first.first[axis], second.end[axis]) = (half, half);
                } else {
                    (first.end[axis], second.first[axis]) = (half, half);
                }
                // Unknown planes, NaN, rule out neither side: max and min pass them over.
                let latest = cells.latest(axis, plane);
                first.leave = min(latest, range.leave);
                second.enter = max(cells.earliest(axis, plane), range.enter);
                let enters_second = (second.enter <= range.leave) & in_time(second.enter, search.t_max());
                if latest < range.enter {
                    range = second;
                } else {
                    if enters_second {
                        // SAFETY: a walk puts aside one range a halving.
                        unsafe { stack.push(second) };
                    }
                    range = first;
                }
                continue;
            }
            let [x, y, z] = range.first;
            let cell = root.first_cell + (z * root.cells[1] + y) * root.cells[0] + x;
            if self.search_cell(cell, references, search) {
                return true;
            }
            loop {
                match stack.pop() {
                    None => return false,
                    Some(next) if in_time(next.enter, search.t_max()) => {
                        range = next;
                        break;
                    }
                    Some(_) => {}
                }
            }
        }
    }
}
