//! Components of a mesh: faces that hang together and run the same way.

use super::face_ranges::Faces;
use super::winding::BLOCK;
use crate::model::{Mesh, NO_INDEX};
use crate::positions::{merge_positions, place_key};
use eosphor_core::math::Vec3;
use rayon::prelude::*;
use std::collections::HashMap;

/// Some faces of a mesh and the places of their vertices. Vertices in the same place are one, as exporters repeat them
/// where normals or texture coordinates jump.
pub(super) struct Region {
    /// Ascending.
    pub(super) faces: Vec<u32>,
    /// Of each vertex of the mesh the number of its place; [`NO_INDEX`] where not all faces around it are here.
    places: Vec<u32>,
    /// How many places there are.
    count: usize,
    pub(super) is_whole: bool,
}

impl Region {
    pub(super) fn whole(mesh: &Mesh, faces: &Faces) -> Region {
        let (places, count) = merge_positions(&mesh.positions);
        Region { faces: (0..faces.len() as u32).collect(), places, count, is_whole: true }
    }

    /// These faces and those that touch them.
    pub(super) fn around(mesh: &Mesh, faces: &Faces, centre: &[u32]) -> Region {
        // Most vertices are elsewhere: a bit of their hash tells.
        const BITS: u32 = 18;
        let bit = |[x, y, z]: [u32; 3]| {
            let mixed =
                x.wrapping_mul(0x9e37_79b1) ^ y.wrapping_mul(0x85eb_ca77) ^ z.wrapping_mul(0xc2b2_ae3d);
            (mixed.wrapping_mul(0x27d4_eb2f) >> (32 - BITS)) as usize
        };
        let (mut numbers, mut known) = (HashMap::new(), vec![false; 1 << BITS]);
        for t in centre.iter().flat_map(|&face| &mesh.triangles[faces.triangles(face as usize)]) {
            for key in t.positions.map(|v| place_key(mesh.positions[v as usize])) {
                let next = numbers.len() as u32;
                numbers.entry(key).or_insert(next);
                known[bit(key)] = true;
            }
        }
        let number = |&p: &Vec3| {
            let key = place_key(p);
            if known[bit(key)] { numbers.get(&key).copied().unwrap_or(NO_INDEX) } else { NO_INDEX }
        };
        let places: Vec<u32> = mesh.positions.par_iter().with_min_len(BLOCK).map(number).collect();
        let touches = |&face: &u32| {
            let run = &mesh.triangles[faces.triangles(face as usize)];
            run.iter().any(|t| t.positions.iter().any(|&v| places[v as usize] != NO_INDEX))
        };
        let near = (0..faces.len() as u32).into_par_iter().with_min_len(BLOCK).filter(touches).collect();
        Region { faces: near, places, count: numbers.len(), is_whole: false }
    }

    /// Calls for the edges around each face, with the face's number here and the places of both ends. Edges that end
    /// outside are left out, and so are those without length.
    fn for_each_edge(
        &self,
        mesh: &Mesh,
        faces: &Faces,
        is_lamp: &impl Fn(u32) -> bool,
        mut call: impl FnMut(u32, [u32; 2]),
    ) {
        for (&face, number) in self.faces.iter().zip(0..) {
            let run = &mesh.triangles[faces.triangles(face as usize)];
            if is_lamp(run[0].material) {
                continue;
            }
            let place = |v: u32| self.places[v as usize];
            let mut edge = |a: u32, b: u32| {
                if a != b && a != NO_INDEX && b != NO_INDEX {
                    call(number, [a, b]);
                }
            };
            let first = place(run[0].positions[0]);
            let mut last = place(run[0].positions[1]);
            edge(first, last);
            for t in run {
                let next = place(t.positions[2]);
                edge(last, next);
                last = next;
            }
            edge(last, first);
        }
    }
}

/// Faces of a region that are joined over edges which two faces share and run in opposite directions.
pub(super) struct Components {
    /// For each face, a face of the same component: itself, or one with a lower number.
    parents: Vec<u32>,
}

/// One side of an edge, listed at the edge's lower end.
#[derive(Clone, Copy, Default)]
struct Side {
    /// The edge's other end.
    to: u32,
    face: u32,
    /// From the lower end to the other.
    forward: bool,
}

impl Components {
    pub(super) fn new(
        mesh: &Mesh,
        faces: &Faces,
        region: &Region,
        is_lamp: &impl Fn(u32) -> bool,
    ) -> Components {
        let mut starts = vec![0usize; region.count + 1];
        region.for_each_edge(mesh, faces, is_lamp, |_, [a, b]| starts[a.min(b) as usize + 1] += 1);
        for p in 0..region.count {
            starts[p + 1] += starts[p];
        }
        let mut next = starts.clone();
        let mut sides = vec![Side::default(); starts[region.count]];
        region.for_each_edge(mesh, faces, is_lamp, |face, [a, b]| {
            let next = &mut next[a.min(b) as usize];
            sides[*next] = Side { to: a.max(b), face, forward: a < b };
            *next += 1;
        });
        let mut components = Components { parents: (0..region.faces.len() as u32).collect() };
        for pair in pairs(&starts, &mut sides).into_iter().flatten() {
            components.join(pair);
        }
        components
    }

    fn join(&mut self, [a, b]: [u32; 2]) {
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

    /// For each face, the face of its component with the lowest number.
    pub(super) fn roots(mut self) -> Vec<u32> {
        // Parents have lower numbers: theirs are known.
        for face in 0..self.parents.len() {
            self.parents[face] = self.parents[self.parents[face] as usize];
        }
        self.parents
    }
}

/// Faces that belong together, block of places by block; the sides at each place begin where `starts` says.
fn pairs(starts: &[usize], sides: &mut [Side]) -> Vec<Vec<[u32; 2]>> {
    let (mut blocks, mut rest) = (Vec::new(), sides);
    for first in (0..starts.len() - 1).step_by(BLOCK) {
        let starts = &starts[first..(first + BLOCK + 1).min(starts.len())];
        let (own, after) = rest.split_at_mut(starts[starts.len() - 1] - starts[0]);
        blocks.push((starts, own));
        rest = after;
    }
    let of_block = |(starts, sides): (&[usize], &mut [Side])| {
        let mut pairs = Vec::new();
        for ends in starts.windows(2) {
            let around = &mut sides[ends[0] - starts[0]..ends[1] - starts[0]];
            around.sort_unstable_by_key(|s| u64::from(s.to) << 32 | u64::from(s.face));
            pairs.extend(around.chunk_by(|a, b| a.to == b.to).filter_map(pair));
        }
        pairs
    };
    blocks.into_par_iter().map(of_block).collect()
}

/// The two faces at an edge that run it in opposite directions, given all its sides in the order of faces. Where more than
/// two meet, nothing says which belong together. A face that runs along it there and back (around a hole, or because it
/// has no width) is not there.
fn pair(edge: &[Side]) -> Option<[u32; 2]> {
    let mut sides = edge.chunk_by(|a, b| a.face == b.face).filter(|own| own.len() == 1);
    match (sides.next(), sides.next(), sides.next()) {
        (Some([a]), Some([b]), None) if a.forward != b.forward => Some([a.face, b.face]),
        _ => None,
    }
}
