//! Points of triangles that several rays found, computed together.

use super::hit_point::HitPoint;
use super::surface::{Normals, between_corners, scaled_edges};
use crate::math::{Vec3, Vec3Lanes};
use crate::ray::{Hit, PrimitiveId, Ray};

/// What rays found: triangles of the world whose normals no texture changes.
#[derive(Clone, Copy, Debug)]
pub struct FoundTriangle<'a> {
    /// The ray.
    pub ray: Ray,
    /// Where it met the triangle.
    pub hit: &'a Hit,
    /// The triangle's corners.
    pub corners: &'a [Vec3; 3],
    /// Its shading normals there.
    pub normals: &'a [Vec3; 3],
}

/// What [`SurfacePoint`](super::SurfacePoint) says of a point, but for its material, in each of several lanes: the same bits.
#[derive(Clone, Copy, Debug)]
pub struct PointLanes<const W: usize> {
    /// World space.
    pub position: Vec3Lanes<W>,
    /// Unit normals on the viewers' side.
    pub geometric_normal: Vec3Lanes<W>,
    /// Unit normals for shading.
    pub normal: Vec3Lanes<W>,
    /// Unit vectors to the rays' origins.
    pub to_viewer: Vec3Lanes<W>,
    /// The rays met the front.
    pub front: [bool; W],
    /// How far off the surface new rays start.
    pub offset: [f32; W],
}

impl<const W: usize> PointLanes<W> {
    /// Of what `found(lane)` says.
    #[inline(always)]
    pub fn new<'a>(found: impl Fn(usize) -> FoundTriangle<'a>) -> PointLanes<W> {
        let zero = Vec3Lanes::ZERO;
        let (mut origin, mut direction, mut smooth, mut outward) = (zero, zero, zero, zero);
        let (mut corners, mut normals) = ([zero; 3], [zero; 3]);
        let [mut t, mut t_rest, mut u, mut v] = [[0.0; W]; 4];
        for lane in 0..W {
            let of_lane = found(lane);
            origin.set(lane, of_lane.ray.origin);
            direction.set(lane, of_lane.ray.direction);
            for corner in 0..3 {
                corners[corner].set(lane, of_lane.corners[corner]);
                normals[corner].set(lane, of_lane.normals[corner]);
            }
            let hit = of_lane.hit;
            (t[lane], t_rest[lane], u[lane], v[lane]) = (hit.t, hit.t_rest, hit.u, hit.v);
        }
        let mut points = PointLanes {
            position: zero,
            geometric_normal: zero,
            normal: zero,
            to_viewer: zero,
            front: [false; W],
            offset: [0.0; W],
        };
        let mut error = [0.0; W];
        let corners_of = |lane| [corners[0].get(lane), corners[1].get(lane), corners[2].get(lane)];
        for lane in 0..W {
            let ray =
                Ray { origin: origin.get(lane), direction: direction.get(lane), t_min: 0.0, t_max: 0.0 };
            let (t, t_rest, u, v) = (t[lane], t_rest[lane], u[lane], v[lane]);
            let hit = Hit { t, t_rest, u, v, id: PrimitiveId::NONE };
            let point = HitPoint::on_world_triangle(&ray, &corners_of(lane), &hit);
            points.position.set(lane, point.position);
            error[lane] = point.error;
        }
        for lane in 0..W {
            let (e1, e2) = scaled_edges(corners_of(lane));
            outward.set(lane, e1.cross(e2));
            let normals = [normals[0].get(lane), normals[1].get(lane), normals[2].get(lane)];
            smooth.set(lane, between_corners(&normals, u[lane], v[lane]));
        }
        for lane in 0..W {
            let to_viewer = -direction.get(lane);
            let normals = Normals::new(to_viewer, outward.get(lane), smooth.get(lane));
            points.to_viewer.set(lane, to_viewer);
            points.geometric_normal.set(lane, normals.geometric);
            points.normal.set(lane, normals.shading);
            points.front[lane] = normals.front;
            let point = HitPoint { position: points.position.get(lane), error: error[lane] };
            points.offset[lane] = point.offset(normals.outward);
        }
        points
    }
    /// Where a ray of a lane starts that leaves to the side that `direction` points to.
    #[inline(always)]
    pub fn offset_origin(&self, lane: usize, direction: Vec3) -> Vec3 {
        let normal = self.geometric_normal.get(lane);
        let side = if direction.dot(normal) >= 0.0 { self.offset[lane] } else { -self.offset[lane] };
        self.position.get(lane).plus_scaled(normal, side)
    }
}
