//! What a picture is of: everything but grounds, backdrops and skies, and what is lost far away.

use super::surfaces::{Box3, Surfaces, area_vector};
use crate::double::{Vec3d, add, dot, length, sub};

/// Sheets are looked for in slices this thin, of the box's sides: first where they are plane, then where they have a
/// thickness.
const SLICES: [usize; 4] = [512, 24, 512, 24];

/// A sheet is a ground or a backdrop where both its sides are this many times as long as what it surrounds.
const BACKDROP: f64 = 2.0;

/// And where it is no thicker than this share of the shorter of them.
const THIN: f64 = 0.05;

/// A sphere is a ground or a sky where its radius is this many times the diagonal of the rest.
const SKY: f64 = 2.0;

/// Pieces are told apart by gaps between slices this thin.
const GAP_SLICES: usize = 256;

/// Surfaces of less than this share of the box's sides would hardly be seen.
const LEAST_COVERAGE: f64 = 1e-3;

/// A slice of space that is left out: what lies wholly within it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sheet {
    pub(super) axis: usize,
    low: f64,
    high: f64,
    /// Whether the subject lies above it along the axis.
    pub(super) is_below: bool,
}

impl Sheet {
    fn holds(&self, t: &[Vec3d; 3]) -> bool {
        t.iter().all(|p| (self.low..=self.high).contains(&p[self.axis]))
    }
}

/// What is framed, by what is not.
#[derive(Debug, Default)]
pub(super) struct Subject {
    pub(super) sheets: Vec<Sheet>,
    /// Numbers of spheres that are left out, with their places.
    pub(super) skies: Vec<(usize, Vec3d, f64)>,
    /// Only what has its middle in here counts, where there is something far away.
    pub(super) within: Option<Box3>,
}

/// A part of the subject.
pub(super) enum Part<'a> {
    Triangle(&'a [Vec3d; 3]),
    Sphere(Vec3d, f64),
}

impl Part<'_> {
    fn bounds(&self) -> Box3 {
        let mut bounds = Box3::EMPTY;
        match self {
            Part::Triangle(t) => t.iter().for_each(|&p| bounds.include(p)),
            Part::Sphere(c, r) => [-r, *r].iter().for_each(|&r| bounds.include(add(*c, [r; 3]))),
        }
        bounds
    }

    /// The area that is seen at most.
    fn area(&self) -> f64 {
        match self {
            Part::Triangle(t) => 0.5 * length(area_vector(t)),
            Part::Sphere(_, r) => std::f64::consts::PI * r * r,
        }
    }
}

impl Subject {
    pub(super) fn find(surfaces: &Surfaces) -> Subject {
        let mut subject = Subject::default();
        subject.leave_out_skies(surfaces);
        for slices in SLICES {
            subject.leave_out_sheets(surfaces, slices);
        }
        subject.leave_out_far_things(surfaces);
        subject
    }

    /// Takes everything that has a surface and is not left out.
    pub(super) fn each(&self, surfaces: &Surfaces, mut take: impl FnMut(Part)) {
        surfaces.each_triangle(|t| {
            let part = Part::Triangle(t);
            if self.has_triangle(t) && part.area() > 0.0 {
                take(part);
            }
        });
        surfaces.each_sphere(|number, center, radius| {
            let part = Part::Sphere(center, radius);
            if self.is_near(&part) && !self.skies.iter().any(|sky| sky.0 == number) {
                take(part);
            }
        });
    }

    /// Whether a triangle, of whatever area, is not left out.
    pub(super) fn has_triangle(&self, t: &[Vec3d; 3]) -> bool {
        self.is_near(&Part::Triangle(t)) && !self.sheets.iter().any(|sheet| sheet.holds(t))
    }

    /// Whether a part is not far from the rest.
    fn is_near(&self, part: &Part) -> bool {
        self.within.is_none_or(|within| {
            let middle = part.bounds().center();
            (0..3).all(|k| (within.min[k]..=within.max[k]).contains(&middle[k]))
        })
    }

    pub(super) fn bounds(&self, surfaces: &Surfaces) -> Box3 {
        let mut bounds = Box3::EMPTY;
        self.each(surfaces, |part| bounds = bounds.union(part.bounds()));
        bounds
    }

    /// Spheres as grounds or skies around much smaller things.
    fn leave_out_skies(&mut self, surfaces: &Surfaces) {
        for _ in 0..4 {
            let mut largest: Option<(usize, Vec3d, f64)> = None;
            surfaces.each_sphere(|number, center, radius| {
                let is_new = !self.skies.iter().any(|sky| sky.0 == number);
                if is_new && largest.is_none_or(|l| radius > l.2) {
                    largest = Some((number, center, radius));
                }
            });
            let Some(sky) = largest else { return };
            self.skies.push(sky);
            let rest = self.bounds(surfaces);
            if rest.is_empty() || sky.2 < SKY * length(rest.size()) {
                self.skies.pop();
                return;
            }
        }
    }

    /// Flat things along two axes, as wide as a ground is beside what stands on it.
    fn leave_out_sheets(&mut self, surfaces: &Surfaces, slices: usize) {
        let all = self.bounds(surfaces);
        let candidates = self.candidates(surfaces, &all, slices);
        if candidates.is_empty() {
            return;
        }
        // Boxes of what lies in the same of them.
        let mut boxes = vec![Box3::EMPTY; 1 << candidates.len()];
        self.each(surfaces, |part| {
            let held = |sheet: &Sheet| matches!(&part, Part::Triangle(t) if sheet.holds(t));
            let bit = |(n, sheet)| usize::from(held(sheet)) << n;
            let mask: usize = candidates.iter().enumerate().map(bit).sum();
            boxes[mask] = boxes[mask].union(part.bounds());
        });
        let union_of = |takes: &dyn Fn(usize) -> bool| {
            let masks = (0..boxes.len()).filter(|&mask| takes(mask) && !boxes[mask].is_empty());
            masks.fold(Box3::EMPTY, |all, mask| all.union(boxes[mask]))
        };
        // How many times as large as the rest a sheet is, along its shorter side.
        let ratio = |n: usize, rest: &Box3| {
            let sheet = union_of(&|mask| mask >> n & 1 == 1).size();
            let axis = candidates[n].axis;
            let shorter = (0..3).filter(|&k| k != axis).map(|k| sheet[k]).fold(f64::INFINITY, f64::min);
            let is_thin = sheet[axis] <= THIN * shorter;
            if is_thin { shorter / length(rest.size()) } else { 0.0 }
        };
        // All of them, less the smallest, until each surrounds what is left.
        let mut kept = boxes.len() - 1;
        while kept != 0 {
            let rest = union_of(&|mask| mask & kept == 0);
            let numbers = (0..candidates.len()).filter(|n| kept >> n & 1 == 1);
            // Where nothing is left, the sheet that is the smallest beside everything goes first.
            let beside = if rest.is_empty() { all } else { rest };
            let smallest = numbers
                .map(|n| (ratio(n, &beside), n))
                .fold((f64::INFINITY, 0), |a, b| if b.0 < a.0 { b } else { a });
            if !rest.is_empty() && smallest.0 >= BACKDROP {
                let chosen = candidates.iter().enumerate().filter(|(n, _)| kept >> n & 1 == 1);
                self.sheets.extend(chosen.map(|(_, sheet)| Sheet {
                    is_below: rest.center()[sheet.axis] >= 0.5 * (sheet.low + sheet.high),
                    ..*sheet
                }));
                return;
            }
            kept &= !(1 << smallest.1);
        }
    }

    /// The two slices along each axis that hold the most surface across it.
    fn candidates(&self, surfaces: &Surfaces, all: &Box3, slices: usize) -> Vec<Sheet> {
        let size = all.size();
        let mut areas = [0, 1, 2].map(|_| vec![0.0f64; slices]);
        let slice = |axis: usize, x: f64| {
            (((x - all.min[axis]) / size[axis] * slices as f64) as usize).min(slices - 1)
        };
        self.each(surfaces, |part| {
            let Part::Triangle(t) = part else { return };
            let normal = area_vector(t);
            let area = length(normal);
            for axis in (0..3).filter(|&k| size[k] > 0.0 && normal[k].abs() > 0.98 * area) {
                let x = (t[0][axis] + t[1][axis] + t[2][axis]) / 3.0;
                areas[axis][slice(axis, x)] += area;
            }
        });
        let mut sheets = Vec::new();
        for (axis, areas) in areas.iter_mut().enumerate() {
            for _ in 0..2 {
                // Two slices: a side of a thing may lie where they meet.
                let pair = |n: usize| areas[n] + areas[n + 1];
                let best = (0..slices - 1).fold(0, |best, n| if pair(n) > pair(best) { n } else { best });
                if pair(best) > 0.0 {
                    let at = |n: f64| all.min[axis] + size[axis] * (n / slices as f64);
                    let (low, high) = (at(best as f64 - 0.25), at(best as f64 + 2.25));
                    sheets.push(Sheet { axis, low, high, is_below: true });
                    let near = best.saturating_sub(1)..(best + 3).min(slices);
                    areas[near].fill(0.0);
                }
            }
        }
        sheets
    }

    /// Where things are so far apart that they would hardly be seen together, keeps those with the most surface.
    fn leave_out_far_things(&mut self, surfaces: &Surfaces) {
        for _ in 0..32 {
            let all = self.bounds(surfaces);
            let size = all.size();
            let mut area = 0.0;
            self.each(surfaces, |part| area += part.area());
            let side = size[0].max(size[1]).max(size[2]);
            if all.is_empty() || area >= LEAST_COVERAGE * side * side {
                return;
            }
            let mut filled = [0, 1, 2].map(|_| [0.0f64; GAP_SLICES]);
            let mut covered = [0, 1, 2].map(|_| [false; GAP_SLICES]);
            let slice = |k: usize, x: f64| {
                let place = (x - all.min[k]) / size[k] * GAP_SLICES as f64;
                (place as usize).min(GAP_SLICES - 1)
            };
            self.each(surfaces, |part| {
                let b = part.bounds();
                for k in (0..3).filter(|&k| size[k] > 0.0) {
                    covered[k][slice(k, b.min[k])..=slice(k, b.max[k])].fill(true);
                    filled[k][slice(k, b.center()[k])] += part.area();
                }
            });
            // The widest gap: axis, first empty slice, how many.
            let mut widest = (0, 0, 0);
            for k in 0..3 {
                let mut start = 0;
                for n in 0..GAP_SLICES {
                    if covered[k][n] || size[k] <= 0.0 {
                        start = n + 1;
                    } else if n + 1 - start > widest.2 {
                        widest = (k, start, n + 1 - start);
                    }
                }
            }
            let (axis, start, count) = widest;
            if count == 0 {
                return;
            }
            let below: f64 = filled[axis][..start].iter().sum();
            let above: f64 = filled[axis][start + count..].iter().sum();
            let middle =
                all.min[axis] + size[axis] * ((start as f64 + 0.5 * count as f64) / GAP_SLICES as f64);
            let mut within = all;
            if below >= above {
                within.max[axis] = middle;
            } else {
                within.min[axis] = middle;
            }
            self.within = Some(within);
        }
    }

    /// Whether a camera at `eye` can see the middle of the subject: no sheet (a ground or a backdrop) and no sphere
    /// that framing leaves out lies between them.
    pub(super) fn is_seen(&self, middle: Vec3d, eye: Vec3d) -> bool {
        let before = |sheet: &Sheet| {
            let up = eye[sheet.axis] - middle[sheet.axis];
            if sheet.is_below { up >= 0.0 } else { up <= 0.0 }
        };
        let is_within = |p: Vec3d, sky: &(usize, Vec3d, f64)| length(sub(p, sky.1)) < sky.2;
        // Within a sky the camera stays in it; on a ground it is on the subject's side.
        let clear = |sky: &(usize, Vec3d, f64)| {
            is_within(eye, sky) == is_within(middle, sky)
                && (is_within(eye, sky) || dot(sub(eye, middle), sub(middle, sky.1)) >= 0.0)
        };
        self.sheets.iter().all(before) && self.skies.iter().all(clear)
    }
}
