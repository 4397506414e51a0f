//! Which way faces run, in formats that leave it open (OBJ, PLY): where a file gives normals, they decide which side is
//! the front.
//!
//! Whole components are turned, and by area: a closed body of glass needs all its faces to run the same way, and the
//! normals of slivers may point anywhere.

use super::polygon::{Faces, Polygon};
use crate::double::{Vec3d, add, cross, dot, double, length, sub};
use crate::model::{Mesh, NO_INDEX, Triangle};
use crate::positions::merge_positions;
use eosphor_core::math::{Vec3, sqrt64};
use rayon::prelude::*;
use std::collections::HashMap;

/// Faces that a thread takes at once.
const BLOCK: usize = 1 << 13;

/// How many faces were mended.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Mended {
    /// They run the other way round now.
    turned: usize,
    /// Their normals point the other way now.
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
    if mesh.normals.is_empty() || mesh.triangles.len() >= NO_INDEX as usize {
        return Mended::default();
    }
    let faces = Faces::new(polygons, mesh.triangles.len());
    if !any_opposed(mesh, &faces) {
        return Mended::default();
    }
    let all = || (0..faces.len()).into_par_iter().with_min_len(BLOCK);
    let areas: Vec<f64> =
        all().map(|face| signed_area(mesh, &mesh.triangles[faces.triangles(face)])).collect();
    let component = Components::new(mesh, &faces, is_lamp).roots();
    // In the order of the faces: sums do not depend on threads.
    let mut balance = vec![0.0; faces.len()];
    for (&root, area) in component.iter().zip(&areas) {
        balance[root as usize] += area;
    }
    let mut mended = Mended::default();
    let mut negatives = Negatives::default();
    for (face, (&root, &area)) in component.iter().zip(&areas).enumerate() {
        let is_turned = balance[root as usize] < 0.0;
        let run = &mut mesh.triangles[faces.triangles(face)];
        if is_turned {
            turn(run);
            mended.turned += 1;
        }
        let opposes = if is_turned { area > 0.0 } else { area < 0.0 };
        if opposes && negatives.negate(run, &mut mesh.normals) {
            mended.negated += 1;
        }
    }
    mended
}

fn any_opposed(mesh: &Mesh, faces: &Faces) -> bool {
    let opposed = |face| {
        let run = &mesh.triangles[faces.triangles(face)];
        agreement(mesh, run, area_vector(mesh, run)) < 0.0
    };
    (0..faces.len()).into_par_iter().with_min_len(BLOCK).any(opposed)
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

/// Faces that are joined over edges which two faces share and run in opposite directions. Corners in the same place are
/// one, as exporters repeat vertices where normals or texture coordinates jump.
struct Components {
    /// Of each face, a face of the same component: itself, or one with a lower number.
    parents: Vec<u32>,
}

/// One side of an edge, listed at the edge's lower end.
#[derive(Clone, Copy, Default, PartialEq, Eq, PartialOrd, Ord)]
struct Side {
    /// The edge's other end.
    to: u32,
    face: u32,
    /// From the lower end to the other.
    forward: bool,
}

impl Components {
    fn new(mesh: &Mesh, faces: &Faces, is_lamp: impl Fn(u32) -> bool) -> Components {
        let (position_of_vertex, positions) = merge_positions(&mesh.positions);
        let sides = || {
            let (numbers, is_lamp) = (&position_of_vertex, &is_lamp);
            let edges = move |face: usize| {
                let run = &mesh.triangles[faces.triangles(face)];
                let ring = (!is_lamp(run[0].material)).then(|| ring_edges(run)).into_iter().flatten();
                ring.map(move |edge| (face as u32, edge.map(|v| numbers[v as usize])))
            };
            let side = |(face, [a, b]): (u32, [u32; 2])| {
                (a.min(b) as usize, Side { to: a.max(b), face, forward: a < b })
            };
            (0..faces.len()).flat_map(edges).filter(|(_, [a, b])| a != b).map(side)
        };
        let mut starts = vec![0usize; positions + 1];
        for (from, _) in sides() {
            starts[from + 1] += 1;
        }
        for p in 0..positions {
            starts[p + 1] += starts[p];
        }
        let mut next = starts.clone();
        let mut around = vec![Side::default(); starts[positions]];
        for (from, side) in sides() {
            around[next[from]] = side;
            next[from] += 1;
        }
        let mut components = Components { parents: (0..faces.len() as u32).collect() };
        for p in 0..positions {
            let around = &mut around[starts[p]..starts[p + 1]];
            around.sort_unstable();
            around.chunk_by(|a, b| a.to == b.to).for_each(|edge| components.join_over(edge));
        }
        components
    }

    /// Joins the faces at an edge, given all its sides in the order of faces. Where more than two meet, nothing says
    /// which belong together. A face that runs along it there and back (around a hole, or because it has no width) is
    /// not there.
    fn join_over(&mut self, edge: &[Side]) {
        let mut sides = edge.chunk_by(|a, b| a.face == b.face).filter(|own| own.len() == 1);
        if let (Some([a]), Some([b]), None) = (sides.next(), sides.next(), sides.next())
            && a.forward != b.forward
        {
            self.join(a.face, b.face);
        }
    }

    fn join(&mut self, a: u32, b: u32) {
        let (a, b) = (self.root(a), self.root(b));
        self.parents[a.max(b) as usize] = a.min(b);
    }

    /// The lowest face of a component. Ways to it are halved as they are gone.
    fn root(&mut self, mut face: u32) -> u32 {
        while self.parents[face as usize] != face {
            let above = self.parents[self.parents[face as usize] as usize];
            self.parents[face as usize] = above;
            face = above;
        }
        face
    }

    /// Of each face, the lowest one of its component.
    fn roots(mut self) -> Vec<u32> {
        // Parents have lower numbers: theirs are known.
        for face in 0..self.parents.len() {
            self.parents[face] = self.parents[self.parents[face] as usize];
        }
        self.parents
    }
}

/// The edges around a fan.
fn ring_edges(run: &[Triangle]) -> impl Iterator<Item = [u32; 2]> {
    let [first, second, _] = run[0].positions;
    let last = run[run.len() - 1].positions[2];
    let outer = run.iter().map(|t| [t.positions[1], t.positions[2]]);
    [[first, second]].into_iter().chain(outer).chain([[last, first]])
}
