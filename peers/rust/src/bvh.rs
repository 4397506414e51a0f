//! bvh: a hierarchy of two children a node, over shapes that the caller defines.

use bvh::aabb::{Aabb, Bounded, IntersectsAabb};
use bvh::bounding_hierarchy::{BHShape, BoundingHierarchy};
use bvh::bvh::Bvh;
use bvh::ray::Ray as OwnRay;
use nalgebra::{Point3, Vector3};
use peer_harness::{Hit, Library, MISS, Options, Ray, Triangle};
use std::cell::Cell;

pub struct Tree {
    hierarchy: Bvh<f32, 3>,
    shapes: Vec<Shape>,
}

/// A triangle with its edges and box: the hierarchy asks for boxes often.
pub struct Shape {
    corner: Vector3<f32>,
    edges: [Vector3<f32>; 2],
    bounds: Aabb<f32, 3>,
    triangle: u32,
    node: usize,
}

impl Bounded<f32, 3> for Shape {
    fn aabb(&self) -> Aabb<f32, 3> {
        self.bounds
    }
}

impl BHShape<f32, 3> for Shape {
    fn set_bh_node_index(&mut self, node: usize) {
        self.node = node;
    }

    fn bh_node_index(&self) -> usize {
        self.node
    }
}

impl Shape {
    fn new((triangle, corners): (usize, &Triangle)) -> Self {
        let [a, b, c] = corners.map(Vector3::from);
        let bounds = Aabb::with_bounds(a.inf(&b).inf(&c).into(), a.sup(&b).sup(&c).into());
        Self { corner: a, edges: [b - a, c - a], bounds, triangle: triangle as u32, node: 0 }
    }

    /// Möller and Trumbore's test. The library's own, `Ray::intersects_triangle`, sees front faces only.
    #[inline(always)]
    fn distance(&self, ray: &OwnRay<f32, 3>, t_min: f32, t_max: f32) -> Option<f32> {
        let [e1, e2] = &self.edges;
        let p = ray.direction.cross(e2);
        let determinant = e1.dot(&p);
        if determinant == 0.0 {
            return None;
        }
        let inverse = 1.0 / determinant;
        let from_corner = ray.origin.coords - self.corner;
        let u = from_corner.dot(&p) * inverse;
        if !(0.0..=1.0).contains(&u) {
            return None;
        }
        let q = from_corner.cross(e1);
        let v = ray.direction.dot(&q) * inverse;
        if v < 0.0 || u + v > 1.0 {
            return None;
        }
        let t = e2.dot(&q) * inverse;
        (t >= t_min && t < t_max).then_some(t)
    }
}

/// A ray that ends at the closest hit so far: boxes beyond it are left out, which the library's own rays cannot do. Its
/// iterators from near to far could stop early instead, and take longer.
struct Shortened<'a> {
    ray: &'a OwnRay<f32, 3>,
    end: Cell<f32>,
}

impl IntersectsAabb<f32, 3> for Shortened<'_> {
    fn intersects_aabb(&self, aabb: &Aabb<f32, 3>) -> bool {
        // The first test is SIMD code in the library, the second, which gives distances, is not.
        let end = self.end.get();
        let is_before_end =
            || self.ray.intersection_slice_for_aabb(aabb).is_some_and(|(entry, _)| entry <= end);
        self.ray.intersects_aabb(aabb) && (end == f32::INFINITY || is_before_end())
    }
}

fn own_ray(ray: &Ray) -> OwnRay<f32, 3> {
    OwnRay::new(Point3::from(ray.origin), Vector3::from(ray.direction))
}

impl Library for Tree {
    type Mesh = Vec<Shape>;

    fn prepare(mesh: &[Triangle], _: &Options) -> Result<Self::Mesh, String> {
        Ok(mesh.iter().enumerate().map(Shape::new).collect())
    }

    fn build(mut shapes: Self::Mesh, options: &Options) -> Result<Self, String> {
        let hierarchy = match options.threads {
            1 => Bvh::build(&mut shapes),
            _ => Bvh::build_par(&mut shapes),
        };
        Ok(Self { hierarchy, shapes })
    }

    fn closest_hits(&self, rays: &[Ray], _: bool, hits: &mut [Hit]) {
        for (ray, found) in rays.iter().zip(hits) {
            let own = own_ray(ray);
            *found = Hit { t: ray.t_max, triangle: MISS };
            let query = Shortened { ray: &own, end: Cell::new(f32::INFINITY) };
            for shape in self.hierarchy.traverse_iterator(&query, &self.shapes) {
                if let Some(t) = shape.distance(&own, ray.t_min, found.t) {
                    query.end.set(t);
                    *found = Hit { t, triangle: shape.triangle };
                }
            }
        }
    }

    fn any_hits(&self, rays: &[Ray], _: bool, hits: &mut [bool]) {
        for (ray, found) in rays.iter().zip(hits) {
            let own = own_ray(ray);
            let mut shapes = self.hierarchy.traverse_iterator(&own, &self.shapes);
            *found = shapes.any(|shape| shape.distance(&own, ray.t_min, ray.t_max).is_some());
        }
    }
}
