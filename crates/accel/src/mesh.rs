//! The short way: a hierarchy over one mesh, and queries without a tracer.

use crate::scene::checked_bounds;
use crate::{BuildOptions, Bvh8, SceneError, SceneGeometry};
use eosphor_core::geometry::{Geometry, Instance};
use eosphor_core::hierarchy::Tracer;
use eosphor_core::material::NONE;
use eosphor_core::math::{Affine, Vec3};
use eosphor_core::ray::{Hit, Ray, RayFilter};

impl Bvh8 {
    /// Builds over an indexed mesh, with the default options. Hits name the triangle by its place among `triangles`; their `u`
    /// and `v` weigh its second and third corner.
    ///
    /// ```
    /// use eosphor_accel::{Bvh8, Ray, vec3};
    ///
    /// let square = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
    /// let bvh = Bvh8::from_mesh(&square, &[[0, 1, 2], [0, 2, 3]])?;
    /// let ray = Ray::new(vec3(0.25, 0.75, 2.0), vec3(0.0, 0.0, -1.0));
    /// let hit = bvh.closest_hit(&ray).expect("the square is in the way");
    /// assert_eq!((hit.id.primitive, hit.u, hit.v), (1, 0.25, 0.5));
    /// assert_eq!(hit.point(&ray), vec3(0.25, 0.75, 0.0));
    /// # Ok::<(), eosphor_accel::SceneError>(())
    /// ```
    ///
    /// # Errors
    /// Where a triangle names a position that is not there, coordinates are out of range, or there are 2^31 triangles or more.
    pub fn from_mesh(positions: &[[f32; 3]], triangles: &[[u32; 3]]) -> Result<Bvh8, SceneError> {
        Bvh8::from_vertices(positions, |&position| position, triangles)
    }

    /// Builds over an indexed mesh whose vertices are of any type, with the default options: `position` reads where a vertex is.
    /// Nothing is copied before it is read. Hits are those of [`Bvh8::from_mesh`].
    ///
    /// ```
    /// use eosphor_accel::Bvh8;
    ///
    /// struct Vertex {
    ///     position: [f32; 3],
    ///     color: [u8; 4],
    /// }
    /// let vertex = |x, y| Vertex { position: [x, y, 0.0], color: [255; 4] };
    /// let vertices = [vertex(0.0, 0.0), vertex(1.0, 0.0), vertex(0.0, 1.0)];
    /// let bvh = Bvh8::from_vertices(&vertices, |vertex| vertex.position, &[[0, 1, 2]])?;
    /// # assert_eq!((bvh.blocks().len(), vertices[0].color), (1, [255; 4]));
    /// # Ok::<(), eosphor_accel::SceneError>(())
    /// ```
    ///
    /// # Errors
    /// Where a triangle names a vertex that is not there, coordinates are out of range, or there are 2^31 triangles or more.
    pub fn from_vertices<V>(
        vertices: &[V],
        position: impl Fn(&V) -> [f32; 3],
        triangles: &[[u32; 3]],
    ) -> Result<Bvh8, SceneError> {
        let corner = |face: usize, vertex: u32| {
            let vertex = vertices.get(vertex as usize).ok_or(SceneError::Face(face))?;
            Ok(Vec3::from(position(vertex)))
        };
        let triangle = |(face, &[a, b, c]): (usize, &[u32; 3])| {
            Ok([corner(face, a)?, corner(face, b)?, corner(face, c)?])
        };
        let corners = triangles.iter().enumerate().map(triangle).collect::<Result<Vec<_>, SceneError>>()?;
        let bounds = checked_bounds(&corners, &[])?;
        if corners.len() >= 1 << 31 {
            return Err(SceneError::TooMany);
        }
        let geometry = Geometry {
            first_triangle: 0,
            triangle_count: corners.len() as u32,
            first_sphere: 0,
            sphere_count: 0,
            extent: bounds.extent(),
            first_sphere_object: 0,
        };
        let world = Instance {
            object_from_world: Affine::IDENTITY,
            world_from_object: Affine::IDENTITY,
            world_bounds: bounds,
            geometry: 0,
            material: NONE,
            object: 0,
        };
        let (geometries, instances) = ([geometry], [world]);
        let scene = SceneGeometry::of_checked(&corners, &[], &geometries, &instances);
        Ok(Bvh8::build(&scene, &BuildOptions::default()))
    }

    /// The closest hit of a ray. For many rays, take [`Bvh8::tracer`] once, or give it all of them together
    /// ([`crate::BatchTracer`]).
    ///
    /// # Panics
    /// Where the hierarchy was built over instances alone ([`SceneGeometry::of_instances`]).
    pub fn closest_hit(&self, ray: &Ray) -> Option<Hit> {
        let hit = self.tracer().closest_hit(ray, &RayFilter::ALL);
        (!hit.is_miss()).then_some(hit)
    }

    /// Whether anything is in the way of a ray.
    ///
    /// # Panics
    /// Where the hierarchy was built over instances alone ([`SceneGeometry::of_instances`]).
    pub fn occluded(&self, ray: &Ray) -> bool {
        self.tracer().occluded(ray, &RayFilter::ALL)
    }

    /// The closest hit of a ray among those that `accept` says yes to: alpha tests, back faces, what the ray starts on. It is
    /// exact, as [`Bvh8Tracer::closest_hit_where`](crate::Bvh8Tracer::closest_hit_where) says, which also says when `accept` is
    /// asked.
    ///
    /// ```
    /// use eosphor_accel::{Bvh8, Ray, vec3};
    ///
    /// let square = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
    /// let bvh = Bvh8::from_mesh(&square, &[[0, 1, 2], [0, 2, 3]])?;
    /// let ray = Ray::new(vec3(0.25, 0.75, 2.0), vec3(0.0, 0.0, -1.0));
    /// assert!(bvh.closest_hit_where(&ray, |hit| hit.id.primitive != 1).is_none());
    /// assert!(bvh.closest_hit_where(&ray, |hit| hit.u + hit.v > 0.5).is_some());
    /// # Ok::<(), eosphor_accel::SceneError>(())
    /// ```
    ///
    /// # Panics
    /// Where the hierarchy was built over instances alone ([`SceneGeometry::of_instances`]).
    pub fn closest_hit_where(&self, ray: &Ray, accept: impl FnMut(&Hit) -> bool) -> Option<Hit> {
        let hit = self.tracer().closest_hit_where(ray, &RayFilter::ALL, accept);
        (!hit.is_miss()).then_some(hit)
    }

    /// Whether anything that `accept` says yes to is in the way of a ray.
    ///
    /// # Panics
    /// Where the hierarchy was built over instances alone ([`SceneGeometry::of_instances`]).
    pub fn occluded_where(&self, ray: &Ray, accept: impl FnMut(&Hit) -> bool) -> bool {
        self.tracer().occluded_where(ray, &RayFilter::ALL, accept)
    }
}
