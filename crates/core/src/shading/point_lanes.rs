//! Points that several rays found, computed together.

use super::hit_point::HitPoint;
use super::surface::{
    Normals, SurfacePoint, between_corners, material_of_sphere, material_of_triangle, scaled_edges,
};
use super::{EvaluatedMaterial, MaterialTexels, MaterialValues};
use crate::geometry::Sphere;
use crate::material::{Material, NONE};
use crate::math::{Vec3, Vec3Lanes};
use crate::ray::{Hit, PrimitiveId, Ray};
use crate::texture::Rgba;
use crate::view::{SceneView, item};

/// What rays found: triangles of the world whose normals no texture changes.
#[derive(Clone, Copy, Debug)]
pub struct FoundTriangle<'a> {
    /// Where the ray starts.
    pub origin: &'a Vec3,
    /// Its direction, a unit vector.
    pub direction: &'a Vec3,
    /// Where it met the triangle.
    pub hit: &'a Hit,
    /// The triangle's corners.
    pub corners: &'a [Vec3; 3],
    /// Its shading normals there.
    pub normals: &'a [Vec3; 3],
}

/// What rays found: spheres of the world whose normals no texture changes.
#[derive(Clone, Copy, Debug)]
pub struct FoundSphere<'a> {
    /// Where the ray starts.
    pub origin: &'a Vec3,
    /// Its direction, a unit vector.
    pub direction: &'a Vec3,
    /// Where it met the sphere.
    pub hit: &'a Hit,
    /// The sphere.
    pub sphere: &'a Sphere,
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
    /// Of nothing.
    pub const NONE: PointLanes<W> = PointLanes {
        position: Vec3Lanes::ZERO,
        geometric_normal: Vec3Lanes::ZERO,
        normal: Vec3Lanes::ZERO,
        to_viewer: Vec3Lanes::ZERO,
        front: [false; W],
        offset: [0.0; W],
    };

    /// Of triangles, by what `found(lane)` says.
    #[inline(always)]
    pub fn new<'a>(found: impl Fn(usize) -> FoundTriangle<'a>) -> PointLanes<W> {
        let zero = Vec3Lanes::<W>::ZERO;
        let (mut origin, mut direction, mut smooth, mut outward) = (zero, zero, zero, zero);
        let (mut corners, mut normals) = ([zero; 3], [zero; 3]);
        let [mut t, mut t_rest, mut u, mut v] = [[0.0; W]; 4];
        for lane in 0..W {
            let of_lane = found(lane);
            origin.set(lane, *of_lane.origin);
            direction.set(lane, *of_lane.direction);
            for corner in 0..3 {
                corners[corner].set(lane, of_lane.corners[corner]);
                normals[corner].set(lane, of_lane.normals[corner]);
            }
            let hit = of_lane.hit;
            (t[lane], t_rest[lane], u[lane], v[lane]) = (hit.t, hit.t_rest, hit.u, hit.v);
        }
        let mut points = PointLanes::NONE;
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
        points.face(&direction, &outward, &smooth, &error);
        points
    }

    /// The same of spheres of the world, also by `found(lane)`.
    #[inline(always)]
    pub fn of_spheres<'a>(found: impl Fn(usize) -> FoundSphere<'a>) -> PointLanes<W> {
        let zero = Vec3Lanes::<W>::ZERO;
        let (mut origin, mut direction, mut center, mut outward) = (zero, zero, zero, zero);
        let [mut t, mut t_rest, mut radius, mut error] = [[0.0; W]; 4];
        for lane in 0..W {
            let of_lane = found(lane);
            origin.set(lane, *of_lane.origin);
            direction.set(lane, *of_lane.direction);
            center.set(lane, of_lane.sphere.center);
            radius[lane] = of_lane.sphere.radius;
            (t[lane], t_rest[lane]) = (of_lane.hit.t, of_lane.hit.t_rest);
        }
        let mut points = PointLanes::NONE;
        for lane in 0..W {
            let ray =
                Ray { origin: origin.get(lane), direction: direction.get(lane), t_min: 0.0, t_max: 0.0 };
            let hit = Hit { t: t[lane], t_rest: t_rest[lane], u: 0.0, v: 0.0, id: PrimitiveId::NONE };
            let sphere = Sphere { center: center.get(lane), radius: radius[lane] };
            let (point, way) = HitPoint::on_world_sphere(&ray, &sphere, &hit);
            points.position.set(lane, point.position);
            outward.set(lane, way);
            error[lane] = point.error;
        }
        points.face(&direction, &outward, &outward, &error);
        points
    }

    /// What follows from where rays come from, and from normals of any length: that of the surface and that for shading.
    #[inline(always)]
    fn face(
        &mut self,
        direction: &Vec3Lanes<W>,
        outward: &Vec3Lanes<W>,
        smooth: &Vec3Lanes<W>,
        error: &[f32; W],
    ) {
        for lane in 0..W {
            let to_viewer = -direction.get(lane);
            let normals = Normals::new(to_viewer, outward.get(lane), smooth.get(lane));
            self.to_viewer.set(lane, to_viewer);
            self.geometric_normal.set(lane, normals.geometric);
            self.normal.set(lane, normals.shading);
            self.front[lane] = normals.front;
            let point = HitPoint { position: self.position.get(lane), error: error[lane] };
            self.offset[lane] = point.offset(normals.outward);
        }
    }

    /// Where a ray of a lane starts that leaves to the side that `direction` points to.
    #[inline(always)]
    pub fn offset_origin(&self, lane: usize, direction: Vec3) -> Vec3 {
        let normal = self.geometric_normal.get(lane);
        let side = if direction.dot(normal) >= 0.0 { self.offset[lane] } else { -self.offset[lane] };
        self.position.get(lane).plus_scaled(normal, side)
    }
}

/// A primitive of the world whose normals no texture changes.
#[derive(Clone, Copy, Debug)]
pub struct WorldPrimitive {
    number: u32,
    /// Number of its material.
    material: u32,
    /// It is no triangle.
    pub is_sphere: bool,
    /// The material is the same everywhere on it: it has no textures, and the corners no colours.
    is_plain: bool,
}

impl WorldPrimitive {
    /// What a hit (not a miss) found, if it is one.
    #[inline(always)]
    pub fn of(view: &SceneView, hit: &Hit) -> Option<WorldPrimitive> {
        if hit.id.instance != 0 {
            return None;
        }
        let instance = item(view.instances, 0);
        let geometry = item(view.geometries, instance.geometry);
        let is_sphere = hit.id.primitive >= geometry.triangle_count;
        let (number, own, is_bare);
        if is_sphere {
            number = geometry.first_sphere + (hit.id.primitive - geometry.triangle_count);
            own = *item(view.sphere_materials, number);
            is_bare = true;
        } else {
            number = geometry.first_triangle + hit.id.primitive;
            let shading = item(view.triangle_shading, number);
            own = shading.material;
            is_bare = shading.extra == NONE;
        }
        let material = if instance.material == NONE { own } else { instance.material };
        let made_of = item(view.materials, material);
        if made_of.normal_texture != NONE {
            return None;
        }
        Some(WorldPrimitive { number, material, is_sphere, is_plain: !made_of.is_textured & is_bare })
    }

    /// Whether this and another are of one material, which is the same everywhere on both.
    #[inline(always)]
    pub fn is_plain_as(&self, other: &WorldPrimitive) -> bool {
        self.is_plain & other.is_plain & (self.material == other.material)
    }

    /// Its number in the scene, of triangles or of spheres.
    #[inline(always)]
    pub fn number(&self) -> u32 {
        self.number
    }

    /// For [`PointLanes::new`].
    #[inline(always)]
    pub fn triangle<'a>(&self, view: &'a SceneView, ray: &'a Ray, hit: &'a Hit) -> FoundTriangle<'a> {
        let normals = &item(view.triangle_shading, self.number).normals;
        let Ray { origin, direction, .. } = ray;
        FoundTriangle { origin, direction, hit, corners: item(view.triangles, self.number), normals }
    }

    /// For [`PointLanes::of_spheres`].
    #[inline(always)]
    pub fn sphere<'a>(&self, view: &'a SceneView, ray: &'a Ray, hit: &'a Hit) -> FoundSphere<'a> {
        let Ray { origin, direction, .. } = ray;
        FoundSphere { origin, direction, hit, sphere: item(view.spheres, self.number) }
    }

    #[inline(always)]
    fn material_values(&self, view: &SceneView, material: &Material, hit: &Hit) -> EvaluatedMaterial {
        if self.is_plain {
            // As below, where all texels and colours are white.
            EvaluatedMaterial::new(material, &MaterialTexels::WHITE, &Rgba::WHITE)
        } else if self.is_sphere {
            material_of_sphere(view, material)
        } else {
            material_of_triangle(view, self.number, material, hit)
        }
    }
}

impl SurfacePoint<EvaluatedMaterial> {
    /// What [`SurfacePoint::new`] gives, from the lane of points in which a primitive's is.
    #[inline(always)]
    pub fn of_lane<const W: usize>(
        view: &SceneView,
        points: &PointLanes<W>,
        lane: usize,
        found: &WorldPrimitive,
        hit: &Hit,
    ) -> SurfacePoint {
        let material = item(view.materials, found.material);
        let material_values = found.material_values(view, material, hit);
        let front = points.front[lane];
        SurfacePoint {
            position: points.position.get(lane),
            geometric_normal: points.geometric_normal.get(lane),
            normal: points.normal.get(lane),
            to_viewer: points.to_viewer.get(lane),
            front,
            material_values,
            material: found.material,
            coverage: if front | !material.single_sided { material_values.opacity() } else { 0.0 },
            id: hit.id,
            offset: points.offset[lane],
        }
    }
}
