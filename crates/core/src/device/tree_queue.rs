//! Whitted's trees of rays between two kernels: what queues hold of their nodes, in rows of 16 bytes.

use super::path_queue::{
    HIT_ROWS, PathPlace, RAY_ROWS, Row, hit_of_rows, last, ray_of_rows, row, rows_of_hit, rows_of_ray, vector,
};
use crate::bsdf::{CosinePower, Lobe};
use crate::integrator::PathRay;
use crate::integrator::whitted::{LampLobe, LitPoint};
use crate::math::Vec3;
use crate::ray::{Hit, PrimitiveId};

/// Rows of a node that was not traced yet: its ray and its place.
pub const FRESH_NODE_ROWS: usize = RAY_ROWS + 1;

/// Rows of a node: what it hit follows.
pub const NODE_ROWS: usize = FRESH_NODE_ROWS + HIT_ROWS;

/// From the first row of a node to that of the next one: each has 128 bytes of its own, since those of a warp lie anywhere.
pub const NODE_STRIDE: usize = 8;

/// Of the counts of a ray: the node was traced before, and has more rays to begin.
const TRACED: u32 = 1 << 31;

/// A ray of a tree, and once that is known what it hit.
#[derive(Clone, Copy, Debug)]
pub struct TreeNode {
    /// The ray.
    pub ray: PathRay,
    /// The sample that it belongs to.
    pub place: PathPlace,
    /// What it hit, once that is known.
    pub hit: Hit,
    /// The next of the rays that go on from there; [`TreeNode::FRESH`] where nothing was done there yet.
    pub next_branch: u32,
}

impl TreeNode {
    /// Nothing was done yet: the ray is to be traced.
    pub const FRESH: u32 = u32::MAX;

    /// A node in rows.
    #[inline(always)]
    pub fn rows(&self) -> [Row; NODE_ROWS] {
        let [mut first, second, third, fourth, place] =
            rows_of_fresh_node(&self.ray, self.place, self.next_branch);
        if self.next_branch != TreeNode::FRESH {
            first.0[3] |= TRACED;
        }
        let [numbers, id] = rows_of_hit(&self.hit);
        [first, second, third, fourth, place, numbers, id]
    }

    /// The node that was written as such rows.
    #[inline(always)]
    pub fn of_rows(rows: &[Row; NODE_ROWS]) -> TreeNode {
        let [mut first, second, third, fourth, Row([pixel, sample, next_branch, _]), numbers, id] = *rows;
        first.0[3] &= !TRACED;
        TreeNode {
            ray: ray_of_rows([first, second, third, fourth]),
            place: PathPlace { pixel, sample },
            hit: hit_of_rows([numbers, id]),
            next_branch,
        }
    }
}

/// A node that is to be traced, in rows.
#[inline(always)]
pub fn rows_of_fresh_node(ray: &PathRay, place: PathPlace, next_branch: u32) -> [Row; FRESH_NODE_ROWS] {
    let [first, second, third, fourth] = rows_of_ray(ray);
    [first, second, third, fourth, Row([place.pixel, place.sample, next_branch, 0])]
}

/// Whether a node, of which this is the first row, was traced before.
#[inline(always)]
pub fn was_traced(first: &Row) -> bool {
    last(*first) & TRACED != 0
}

/// Rows of a point that lights are asked about.
pub const LIT_ROWS: usize = 11;

/// What becomes of the light at a point.
#[derive(Clone, Copy, Debug)]
pub struct LitPlace {
    /// The sample that it belongs to.
    pub place: PathPlace,
    /// The path of the ray that found the point: it keys random numbers.
    pub path: u32,
    /// What the point gives by itself.
    pub found: Vec3,
    /// What that and its light are multiplied by.
    pub weight: Vec3,
}

const LAMP_HIGHLIGHTS: u32 = 1;
const HAS_LOBE: u32 = 2;

/// A lit point in rows.
#[inline(always)]
pub fn rows_of_lit(point: &LitPoint, at: &LitPlace) -> [Row; LIT_ROWS] {
    let lobe = &point.lobe;
    let flags =
        if point.lamp_highlights { LAMP_HIGHLIGHTS } else { 0 } | if lobe.is_there() { HAS_LOBE } else { 0 };
    let (axis, exponent) = match &lobe.lobe {
        Lobe::CosinePower(CosinePower { axis, exponent }) => (*axis, *exponent),
        _ => (Vec3::ZERO, 0.0),
    };
    [
        row(point.position, point.offset.to_bits()),
        row(point.geometric_normal, flags),
        row(point.normal, point.shininess.to_bits()),
        row(point.to_viewer, at.path),
        row(point.diffuse, point.id.instance),
        row(point.specular, point.id.primitive),
        row(point.transmission, 0),
        row(at.found, at.place.pixel),
        row(at.weight, at.place.sample),
        row(axis, exponent.to_bits()),
        row(lobe.color, lobe.rays.to_bits()),
    ]
}

/// The point that was written as [`rows_of_lit`].
#[inline(always)]
pub fn lit_of_rows(rows: &[Row; LIT_ROWS]) -> (LitPoint, LitPlace) {
    let [position, above, normal, viewer, diffuse, specular, transmission, found, weight, axis, color] =
        *rows;
    let flags = last(above);
    let lobe = if flags & HAS_LOBE != 0 {
        LampLobe {
            lobe: Lobe::CosinePower(CosinePower { axis: vector(axis), exponent: f32::from_bits(last(axis)) }),
            rays: f32::from_bits(last(color)),
            color: vector(color),
        }
    } else {
        LampLobe::NONE
    };
    let point = LitPoint {
        position: vector(position),
        offset: f32::from_bits(last(position)),
        geometric_normal: vector(above),
        normal: vector(normal),
        to_viewer: vector(viewer),
        id: PrimitiveId { instance: last(diffuse), primitive: last(specular) },
        diffuse: vector(diffuse),
        specular: vector(specular),
        shininess: f32::from_bits(last(normal)),
        lamp_highlights: flags & LAMP_HIGHLIGHTS != 0,
        transmission: vector(transmission),
        lobe,
    };
    let place = PathPlace { pixel: last(found), sample: last(weight) };
    (point, LitPlace { place, path: last(viewer), found: vector(found), weight: vector(weight) })
}

#[cfg(test)]
mod tests {
    use super::super::path_queue::{NODE_CHILDREN, PathControl, in_ring};
    use super::*;
    use crate::bsdf::Delta;
    use crate::integrator::{MAX_DEPTH, RayKind};
    use crate::math::vec3;

    fn node(next_branch: u32) -> TreeNode {
        let id = PrimitiveId { instance: 3, primitive: u32::MAX - 1 };
        TreeNode {
            ray: PathRay {
                origin: vec3(1.0, -0.0, 1e-40),
                path: 0xffff_0003,
                direction: vec3(0.6, 0.8, 0.0),
                depth: 64,
                weight: vec3(1.5, 0.25, 1e30),
                kind: RayKind::Glossy,
                start: id,
                inside: u32::MAX,
                holes: 4096,
                travelled: 12.5,
                lobe_density: 1e20,
            },
            place: PathPlace { pixel: 123, sample: 456 },
            hit: Hit { t: 2.5, t_rest: -1e-9, u: 0.25, v: 0.5, id },
            next_branch,
        }
    }

    #[test]
    fn nodes_are_read_as_they_were_written() {
        for next_branch in [TreeNode::FRESH, 0, 1, 1_000_000] {
            let node = node(next_branch);
            let rows = node.rows();
            assert_eq!(format!("{:?}", TreeNode::of_rows(&rows)), format!("{node:?}"));
            assert_eq!(was_traced(&rows[0]), next_branch != TreeNode::FRESH);
            let fresh = rows_of_fresh_node(&node.ray, node.place, next_branch);
            assert_eq!(fresh[1..], rows[1..FRESH_NODE_ROWS]);
        }
    }

    #[test]
    fn lit_points_are_read_as_they_were_written() {
        let lobe = Lobe::CosinePower(CosinePower { axis: vec3(0.0, 0.6, 0.8), exponent: 17.0 });
        let glossy = LampLobe { lobe, rays: 4.0, color: vec3(0.5, 0.25, 0.125) };
        for (lobe, lamp_highlights) in [(LampLobe::NONE, true), (glossy, false)] {
            let point = LitPoint {
                position: vec3(1.0, 2.0, 3.0),
                offset: 1e-6,
                geometric_normal: vec3(0.0, 0.0, 1.0),
                normal: vec3(0.0, 1.0, 0.0),
                to_viewer: vec3(1.0, 0.0, 0.0),
                id: PrimitiveId { instance: 7, primitive: 8 },
                diffuse: vec3(0.1, 0.2, 0.3),
                specular: vec3(0.4, 0.5, 0.6),
                shininess: 30.0,
                lamp_highlights,
                transmission: vec3(0.7, 0.8, 0.9),
                lobe,
            };
            let place = PathPlace { pixel: 12, sample: 34 };
            let at = LitPlace { place, path: 56, found: vec3(0.0, 1.0, 2.0), weight: vec3(3.0, 4.0, 5.0) };
            let read = lit_of_rows(&rows_of_lit(&point, &at));
            assert_eq!(format!("{read:?}"), format!("{:?}", (point, at)));
        }
        assert!(matches!(LampLobe::NONE.lobe, Lobe::Delta(Delta { .. })));
    }

    /// Trees whose nodes leave `children` each, down to a depth, through a stack and a ring as kernels keep them. Gives back how
    /// many nodes there were.
    fn nodes_of(samples: u32, children: u32, depth: u32, room: u32) -> u64 {
        let slots = 4 * room;
        let mut control = PathControl { samples, samples_left: samples, ..Default::default() };
        let mut free: Vec<u32> = (0..slots).collect();
        // Depth of what is in a slot; none where it is free.
        let mut depths: Vec<Option<u32>> = vec![None; slots as usize];
        let mut stack = vec![0; slots as usize];
        let mut nodes = 0;
        while !control.is_done() {
            control.begin_round_of_trees(room, slots);
            let new = control.samples - control.samples_left - control.first_sample;
            let take = |free: &[u32], first: u32, number: u32| free[in_ring(first + number, slots) as usize];
            for number in 0..new {
                let slot = take(&free, control.new_slots, number);
                assert_eq!(depths[slot as usize].replace(0), None);
                stack[(control.first_new + number) as usize] = slot;
            }
            assert!(control.paths > 0 && control.paths <= room);
            let taken: Vec<u32> =
                (0..control.paths).map(|number| stack[(control.waiting + number) as usize]).collect();
            nodes += taken.len() as u64;
            // Slots of this round are written when its kernels are done: no thread may take one before.
            let place = |number| in_ring(control.end_free + number, slots) as usize;
            let freed: Vec<(usize, u32)> = (0..).map(place).zip(taken.iter().copied()).collect();
            freed.iter().for_each(|&(place, _)| free[place] = u32::MAX);
            for &slot in &taken {
                let of = depths[slot as usize].take().expect("a node");
                for _ in 0..if of < depth { children } else { 0 } {
                    let number = control.appended as u32;
                    let slot = take(&free, control.first_free, number);
                    assert_eq!(depths[slot as usize].replace(of + 1), None, "a slot that was free");
                    stack[(control.waiting + number) as usize] = slot;
                    control.appended += 1;
                }
            }
            freed.into_iter().for_each(|(place, slot)| free[place] = slot);
        }
        nodes
    }

    #[test]
    fn trees_of_all_samples_come_to_an_end() {
        for room in [64, 96, 1024] {
            assert_eq!(nodes_of(1000, 1, 5, room), 6000, "{room}");
            assert_eq!(nodes_of(100, 2, 9, room), 100 * 1023, "{room}");
            assert_eq!(nodes_of(7, NODE_CHILDREN, 9, room), 7 * (3_u64.pow(10) - 1) / 2, "{room}");
            assert_eq!(nodes_of(3, 1, MAX_DEPTH, room), 3 * u64::from(MAX_DEPTH + 1), "{room}");
        }
    }
}
