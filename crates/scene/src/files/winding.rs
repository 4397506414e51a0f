//! Which way faces run, in formats that leave it open (OBJ, PLY): where a file gives normals, they decide which side is
//! the front.
//!
//! Whole components are turned, and by area: a closed body of glass needs all its faces to run the same way, and the
//! normals of slivers may point anywhere.

use super::components::{Components, Region};
use super::face_ranges::{Faces, Polygon};
use crate::double::{Vec3d, add, cross, dot, double, length, sub};
use crate::model::{Mesh, NO_INDEX, Triangle};
use eosphor_core::math::{Vec3, sqrt64};
use rayon::prelude::*;
use std::collections::HashMap;

/// Faces that a thread takes at once.
pub(super) const BLOCK: usize = 1 << 13;

/// The region around opposed faces is judged by itself only while it holds less than one in so many of all faces.
const MIN_FACES_PER_REGION_FACE: usize = 16;

/// How many times those around them are added.
const RINGS: u32 = 4;

/// How many faces were mended.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Mended {
    /// How many faces run the other way round now.
    turned: usize,
    /// How many faces have normals that point the other way now.
    negated: usize,
}

impl Mended {
    /// What there is to say, if anything.
    pub(super) fn note(self) -> Option<String> {
        let faces = |count: usize| if count == 1 { "1 face".to_string() } else { format!("{count} faces") };
        let turned = format!("{} turned round to face where their normals point", faces(self.turned));
        let negated = format!("the normals of {} negated, which pointed behind them", faces(self.negated));
        match (self.turned > 0, self.negated > 0) {
            (false, false) => None,
            (true, false) => Some(turned),
            (false, true) => Some(negated),
            (true, true) => Some(format!("{turned}, {negated}")),
        }
    }
}

/// Makes winding and given normals agree. Each consistently wound component whose normals oppose its winding by the
/// larger part of its area is turned; then the normals of each face that still oppose it are negated. Faces for which
/// `is_lamp` (by material) shine to their front alone, so each of them is turned by its own normals.
///
/// A turned face keeps its first corner: it is the same, bit for bit, as if the file had its other corners in reverse.
pub(super) fn follow_normals(
    mesh: &mut Mesh,
    polygons: &[Polygon],
    is_lamp: impl Fn(u32) -> bool + Sync,
) -> Mended {
    // Larger meshes are no scene.
    if mesh.normals.is_empty() || mesh.positions.len().max(mesh.triangles.len()) >= NO_INDEX as usize {
        return Mended::default();
    }
    let faces = Faces::new(polygons, mesh.triangles.len());
    let all = || (0..faces.len() as u32).into_par_iter().with_min_len(BLOCK);
    let opposed: Vec<u32> =
        all().filter(|&face| is_opposed(mesh, &mesh.triangles[faces.triangles(face as usize)])).collect();
    if opposed.is_empty() {
        return Mended::default();
    }
    // Mostly few faces are in question, and some around them tell enough.
    let mut centre = opposed;
    for _ in 0..RINGS {
        if centre.len() >= faces.len() / MIN_FACES_PER_REGION_FACE {
            break;
        }
        let region = Region::around(mesh, &faces, &centre);
        if let Some(verdicts) = judge(mesh, &faces, &region, &is_lamp) {
            return mend(mesh, &faces, &region.faces, &verdicts);
        }
        centre = region.faces;
    }
    let whole = Region::whole(mesh, &faces);
    let verdicts = judge(mesh, &faces, &whole, &is_lamp).unwrap_or_default();
    mend(mesh, &faces, &whole.faces, &verdicts)
}

fn is_opposed(mesh: &Mesh, run: &[Triangle]) -> bool {
    match run {
        [t] if clearly_agrees(mesh, t) => false,
        _ => agreement(mesh, run, area_vector(mesh, run)) < 0.0,
    }
}

/// Nearly all faces are triangles on whose front all three normals lie, by more than single precision can be wrong: by
/// some 2^-21 of the edges' lengths times the normal's. Plain products, since fused ones are calls of a library here.
fn clearly_agrees(mesh: &Mesh, t: &Triangle) -> bool {
    let [a, b, c] = t.positions.map(|p| mesh.positions[p as usize]);
    let (e, f) = (b - a, c - a);
    let (x, y, z) = (e.y * f.z - e.z * f.y, e.z * f.x - e.x * f.z, e.x * f.y - e.y * f.x);
    let sum = |v: Vec3| v.x.abs() + v.y.abs() + v.z.abs();
    let scale = sum(e) * sum(f) * (1.0 / 262_144.0);
    let is_before = |n: Vec3| n.x * x + n.y * y + n.z * z > scale * sum(n);
    t.normals.iter().all(|&n| mesh.normals.get(n as usize).is_some_and(|&n| is_before(n)))
}

/// What becomes of a face.
#[derive(Clone, Copy)]
struct Verdict {
    turn: bool,
    negate: bool,
}

/// Of each face of a region; `None` where the region is too small to tell.
fn judge(
    mesh: &Mesh,
    faces: &Faces,
    region: &Region,
    is_lamp: &(impl Fn(u32) -> bool + Sync),
) -> Option<Vec<Verdict>> {
    let area = |&face: &u32| signed_area(mesh, &mesh.triangles[faces.triangles(face as usize)]);
    let areas: Vec<f64> = region.faces.par_iter().with_min_len(BLOCK).map(area).collect();
    let roots = Components::new(mesh, faces, region, is_lamp).roots();
    // In the order of the faces: sums do not depend on threads.
    let mut votes = vec![Votes::default(); areas.len()];
    for (&root, &area) in roots.iter().zip(&areas) {
        let votes = &mut votes[root as usize];
        votes.against -= area.min(0.0);
        votes.agree += area.max(0.0);
        votes.goes_on |= area >= 0.0;
    }
    if !region.is_whole {
        // Components of opposed faces alone are all here. The others may go on outside and be one, but then what agrees
        // must outweigh all that opposes.
        let mixed = || votes.iter().filter(|v| v.goes_on && v.against > 0.0);
        let against: f64 = mixed().map(|v| v.against).sum();
        if mixed().any(|v| v.agree <= against) {
            return None;
        }
    }
    let verdict = |(&root, &area): (&u32, &f64)| {
        let turn = votes[root as usize].against > votes[root as usize].agree;
        Verdict { turn, negate: if turn { area > 0.0 } else { area < 0.0 } }
    };
    Some(roots.iter().zip(&areas).map(verdict).collect())
}

/// What a component's faces say, by area.
#[derive(Clone, Copy, Default)]
struct Votes {
    agree: f64,
    against: f64,
    /// It has faces that do not oppose it, whose neighbours may lie outside a region.
    goes_on: bool,
}

fn mend(mesh: &mut Mesh, faces: &Faces, region: &[u32], verdicts: &[Verdict]) -> Mended {
    let mut mended = Mended::default();
    let mut negatives = Negatives::default();
    for (&face, verdict) in region.iter().zip(verdicts) {
        let run = &mut mesh.triangles[faces.triangles(face as usize)];
        if verdict.turn {
            turn(run);
            mended.turned += 1;
        }
        if verdict.negate && negatives.negate(run, &mut mesh.normals) {
            mended.negated += 1;
        }
    }
    mended
}

/// Twice the area of a face, negative where its normals oppose its winding; 0 where it has none.
fn signed_area(mesh: &Mesh, run: &[Triangle]) -> f64 {
    let area = area_vector(mesh, run);
    match agreement(mesh, run, area) {
        a if a > 0.0 => length(area),
        a if a < 0.0 => -length(area),
        _ => 0.0,
    }
}

/// Twice the area long, towards the side from which the face runs counter-clockwise.
fn area_vector(mesh: &Mesh, run: &[Triangle]) -> Vec3d {
    let of = |t: &Triangle| {
        let [a, b, c] = t.positions.map(|p| double(mesh.positions[p as usize]));
        cross(sub(b, a), sub(c, a))
    };
    run[1..].iter().fold(of(&run[0]), |sum, t| add(sum, of(t)))
}

/// Positive where the face's normals lie on its front by their sum, negative where they lie behind it. Their lengths do
/// not count.
fn agreement(mesh: &Mesh, run: &[Triangle], area: Vec3d) -> f64 {
    let along = |n: u32| (n != NO_INDEX).then(|| double(mesh.normals[n as usize])).map(|n| (dot(n, area), n));
    let dots = || corner_normals(run).filter_map(along);
    let (low, high) = dots().fold((0.0f64, 0.0f64), |(low, high), (d, _)| (low.min(d), high.max(d)));
    if low >= 0.0 || high <= 0.0 {
        // All on one side: lengths do not matter.
        return low + high;
    }
    dots().map(|(d, n)| if d == 0.0 { 0.0 } else { d / sqrt64(dot(n, n)) }).sum()
}

/// The normals at the corners of a fan, each corner once.
fn corner_normals(run: &[Triangle]) -> impl Iterator<Item = u32> {
    run[0].normals.into_iter().chain(run[1..].iter().map(|t| t.normals[2]))
}

/// Reverses the corners of a fan but for the first.
fn turn(run: &mut [Triangle]) {
    run.reverse();
    for t in run {
        t.positions.swap(1, 2);
        t.normals.swap(1, 2);
        t.uvs.swap(1, 2);
    }
}

/// The numbers of normals that are others' negatives.
#[derive(Default)]
struct Negatives(HashMap<u32, u32>);

impl Negatives {
    /// Negates the normals of a face; false where there is no room for more normals.
    fn negate(&mut self, run: &mut [Triangle], normals: &mut Vec<Vec3>) -> bool {
        if normals.len() + run.len() + 2 >= NO_INDEX as usize {
            return false;
        }
        for n in run.iter_mut().flat_map(|t| &mut t.normals).filter(|n| **n != NO_INDEX) {
            *n = *self.0.entry(*n).or_insert_with(|| {
                // Subtracted from 0, so that no 0 becomes -0.
                normals.push(Vec3::ZERO - normals[*n as usize]);
                normals.len() as u32 - 1
            });
        }
        true
    }
}
