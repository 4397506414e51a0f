//! Scenes for users of this crate alone: triangles, spheres and instances, without anything that a renderer needs.

use crate::SceneGeometry;
use eosphor_core::geometry::{Bounds, Geometry, Instance, Sphere};
use eosphor_core::intersect::longest_edge_last;
use eosphor_core::material::NONE;
use eosphor_core::math::{Affine, Vec3, vec3};
use eosphor_core::ray::{Hit, PrimitiveId, Ray};
use std::fmt;

/// Coordinates and radii must not be larger, so that products of them stay finite.
pub const LARGEST_COORDINATE: f32 = 1e12;

/// What hierarchies are built over, made by hand.
///
/// The *world* is what is not placed by instances. A *mesh* is a set of triangles and spheres in a space of its own; it
/// is there only where it is placed, as often as you like. Hits name an instance (0 is the world) and a primitive:
/// triangles in the order in which they were given, from 0, and spheres after them.
///
/// ```
/// use eosphor_accel::{Affine, Bvh8, BuildOptions, Ray, RayFilter, Scene, Tracer, vec3};
///
/// let triangle = [vec3(0.0, 0.0, 0.0), vec3(1.0, 0.0, 0.0), vec3(0.0, 1.0, 0.0)];
/// let mut scene = Scene::default();
/// let mesh = scene.mesh(&[triangle], &[])?;
/// scene.place(mesh, Affine::IDENTITY)?;
/// let farther = scene.place(mesh, Affine { translation: vec3(5.0, 0.0, 0.0), ..Affine::IDENTITY })?;
///
/// let bvh = Bvh8::build(&scene.geometry(), &BuildOptions::default());
/// let ray = Ray::new(vec3(5.25, 0.5, 3.0), vec3(0.0, 0.0, -1.0));
/// let hit = bvh.tracer().closest_hit(&ray, &RayFilter::ALL);
/// assert_eq!((hit.t, hit.id.instance, hit.id.primitive), (3.0, farther, 0));
/// assert_eq!(scene.weights(&hit), [0.25, 0.25, 0.5]);
/// # Ok::<(), eosphor_accel::SceneError>(())
/// ```
#[derive(Clone, Debug)]
pub struct Scene {
    triangles: Vec<[Vec3; 3]>,
    /// Of each triangle, the place at which its first corner was given.
    first_corners: Vec<u8>,
    spheres: Vec<Sphere>,
    geometries: Vec<Geometry>,
    /// Of each geometry, not padded.
    bounds: Vec<Bounds>,
    instances: Vec<Instance>,
}

/// Names a mesh of a [`Scene`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct MeshId(u32);

/// Why something cannot be part of a [`Scene`]. Nothing was changed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SceneError {
    /// A corner is not a number, or larger than [`LARGEST_COORDINATE`].
    Triangle(usize),
    /// The centre or the radius is out of range; a radius must be over 0.
    Sphere(usize),
    /// A face names a vertex that is not there.
    Face(usize),
    /// The transform is not finite, cannot be inverted, or takes the mesh out of range.
    Transform,
    /// There is no such mesh.
    Mesh(MeshId),
    /// There is no such instance, or it is the world (0), which does not move.
    Instance(u32),
    /// The mesh has another number of triangles or spheres than were given.
    Counts,
    /// More than 2^31 - 1 primitives or instances.
    TooMany,
}

impl fmt::Display for SceneError {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            SceneError::Triangle(n) => {
                write!(f, "triangle {n} has a corner that is out of range: within {LARGEST_COORDINATE:e}, please")
            }
            SceneError::Sphere(n) => {
                write!(f, "sphere {n} is out of range: a radius over 0, all within {LARGEST_COORDINATE:e}, please")
            }
            SceneError::Face(n) => write!(f, "face {n} names a vertex that is not there"),
            SceneError::Transform => f.write_str(
                "the transform cannot be used: it must be finite and invertible (no scale of 0), and keep the mesh in range",
            ),
            SceneError::Mesh(MeshId(n)) => write!(f, "there is no mesh {n} in this scene"),
            SceneError::Instance(0) => f.write_str("instance 0 is the world, which does not move"),
            SceneError::Instance(n) => write!(f, "there is no instance {n}"),
            SceneError::Counts => {
                f.write_str("a mesh can be given new shapes for its primitives, not more or fewer of them")
            }
            SceneError::TooMany => f.write_str("more than 2^31 - 1 primitives or instances"),
        }
    }
}

impl std::error::Error for SceneError {}

/// The triangles of an indexed mesh.
///
/// # Errors
/// [`SceneError::Face`].
pub fn indexed(vertices: &[Vec3], faces: &[[u32; 3]]) -> Result<Vec<[Vec3; 3]>, SceneError> {
    let corner = |number: usize, v: u32| vertices.get(v as usize).copied().ok_or(SceneError::Face(number));
    let triangle = |(n, f): (usize, &[u32; 3])| Ok([corner(n, f[0])?, corner(n, f[1])?, corner(n, f[2])?]);
    faces.iter().enumerate().map(triangle).collect()
}

impl Default for Scene {
    /// A world without anything in it.
    fn default() -> Scene {
        Scene::new(&[], &[]).expect("nothing is not too much")
    }
}

impl Scene {
    /// A world of these.
    ///
    /// # Errors
    /// Where numbers are out of range.
    pub fn new(triangles: &[[Vec3; 3]], spheres: &[Sphere]) -> Result<Scene, SceneError> {
        let mut scene = Scene {
            triangles: Vec::new(),
            first_corners: Vec::new(),
            spheres: Vec::new(),
            geometries: Vec::new(),
            bounds: Vec::new(),
            instances: Vec::new(),
        };
        let MeshId(world) = scene.mesh(triangles, spheres)?;
        // The world's own box is not asked.
        scene.push_instance(world, Affine::IDENTITY, Affine::IDENTITY);
        Ok(scene)
    }

    /// Adds a mesh. It is nowhere until it is placed.
    ///
    /// # Errors
    /// Where numbers are out of range.
    pub fn mesh(&mut self, triangles: &[[Vec3; 3]], spheres: &[Sphere]) -> Result<MeshId, SceneError> {
        let bounds = checked_bounds(triangles, spheres)?;
        let count = self.triangles.len() + self.spheres.len() + triangles.len() + spheres.len();
        if count >= 1 << 31 || self.geometries.len() >= 1 << 31 {
            return Err(SceneError::TooMany);
        }
        self.geometries.push(Geometry {
            first_triangle: self.triangles.len() as u32,
            triangle_count: triangles.len() as u32,
            first_sphere: self.spheres.len() as u32,
            sphere_count: spheres.len() as u32,
            extent: bounds.extent(),
            first_sphere_object: 0,
        });
        self.bounds.push(bounds);
        for triangle in triangles {
            let (turned, first) = turned(triangle);
            self.triangles.push(turned);
            self.first_corners.push(first);
        }
        self.spheres.extend_from_slice(spheres);
        Ok(MeshId(self.geometries.len() as u32 - 1))
    }

    /// Gives a mesh, or the world ([`Scene::WORLD`]), other shapes for the same numbers of triangles and spheres, so that
    /// hierarchies can be refitted.
    ///
    /// # Errors
    /// Where numbers are out of range, there are more or fewer of them, or an instance would leave the range.
    pub fn reshape(
        &mut self,
        mesh: MeshId,
        triangles: &[[Vec3; 3]],
        spheres: &[Sphere],
    ) -> Result<(), SceneError> {
        let geometry = *self.geometries.get(mesh.0 as usize).ok_or(SceneError::Mesh(mesh))?;
        if (geometry.triangle_count as usize, geometry.sphere_count as usize)
            != (triangles.len(), spheres.len())
        {
            return Err(SceneError::Counts);
        }
        let bounds = checked_bounds(triangles, spheres)?;
        let places = self.instances.iter().filter(|i| i.geometry == mesh.0);
        if !places.map(|i| &i.world_from_object).all(|map| fits(&bounds, map)) {
            return Err(SceneError::Transform);
        }
        for (k, triangle) in (geometry.first_triangle as usize..).zip(triangles) {
            (self.triangles[k], self.first_corners[k]) = turned(triangle);
        }
        self.spheres[geometry.first_sphere as usize..][..spheres.len()].copy_from_slice(spheres);
        self.geometries[mesh.0 as usize].extent = bounds.extent();
        self.bounds[mesh.0 as usize] = bounds;
        for instance in self.instances.iter_mut().filter(|i| i.geometry == mesh.0) {
            instance.world_bounds = bounds.placed(&instance.world_from_object, &instance.object_from_world);
        }
        Ok(())
    }

    /// The world, where a mesh is asked for.
    pub const WORLD: MeshId = MeshId(0);

    /// Places a mesh; returns the number of the instance, which its hits have.
    ///
    /// # Errors
    /// Where the transform cannot be inverted or takes the mesh out of range.
    pub fn place(&mut self, mesh: MeshId, world_from_object: Affine) -> Result<u32, SceneError> {
        let bounds = self.bounds.get(mesh.0 as usize).ok_or(SceneError::Mesh(mesh))?;
        if self.instances.len() >= 1 << 31 {
            return Err(SceneError::TooMany);
        }
        let object_from_world = inverse(bounds, &world_from_object)?;
        self.push_instance(mesh.0, world_from_object, object_from_world);
        Ok(self.instances.len() as u32 - 1)
    }

    /// Places an instance elsewhere. Hierarchies are to be refitted, or built again, afterwards.
    ///
    /// # Errors
    /// As [`Scene::place`].
    pub fn replace(&mut self, instance: u32, world_from_object: Affine) -> Result<(), SceneError> {
        let unknown = SceneError::Instance(instance);
        let place = self.instances.get_mut(instance as usize).filter(|_| instance > 0).ok_or(unknown)?;
        let bounds = &self.bounds[place.geometry as usize];
        place.object_from_world = inverse(bounds, &world_from_object)?;
        place.world_from_object = world_from_object;
        place.world_bounds = bounds.placed(&world_from_object, &place.object_from_world);
        Ok(())
    }

    fn push_instance(&mut self, geometry: u32, world_from_object: Affine, object_from_world: Affine) {
        let world_bounds = self.bounds[geometry as usize].placed(&world_from_object, &object_from_world);
        let object = self.instances.len() as u32;
        self.instances.push(Instance {
            object_from_world,
            world_from_object,
            world_bounds,
            geometry,
            material: NONE,
            object,
        });
    }

    /// Borrowed, for building and refitting.
    pub fn geometry(&self) -> SceneGeometry<'_> {
        SceneGeometry::of_checked(&self.triangles, &self.spheres, &self.geometries, &self.instances)
    }

    /// Barycentric weights of the corners of the triangle that was hit, in the order in which they were given.
    ///
    /// A scene may turn the corners of a triangle round, because the intersection test is at its best with the longest
    /// edge opposite the first; so a hit's own `u` and `v` may belong to other corners. For a sphere or a miss the
    /// weights mean nothing.
    pub fn weights(&self, hit: &Hit) -> [f32; 3] {
        let weights = [1.0 - hit.u - hit.v, hit.u, hit.v];
        let first = self.triangle_index(hit.id).map_or(0, |k| self.first_corners[k] as usize);
        // Corner k was given at place k + first.
        [0, 1, 2].map(|given| weights[(given + 3 - first) % 3])
    }

    /// The corners of a triangle in the order in which they were given, in its mesh's own space; `None` for what is no
    /// triangle.
    pub fn corners(&self, id: PrimitiveId) -> Option<[Vec3; 3]> {
        let k = self.triangle_index(id)?;
        let first = self.first_corners[k] as usize;
        Some([0, 1, 2].map(|given| self.triangles[k][(given + 3 - first) % 3]))
    }

    /// The unit geometric normal of what was hit, in world space: of a triangle on the side from which its corners run
    /// counter-clockwise, of a sphere at the point that `ray` hit, outwards. `None` for a miss, for what is not there, and where
    /// there is none (a triangle without area).
    pub fn normal(&self, ray: &Ray, hit: &Hit) -> Option<Vec3> {
        let instance = self.instances.get(hit.id.instance as usize)?;
        let geometry = &self.geometries[instance.geometry as usize];
        let object_normal = match self.corners(hit.id) {
            Some([a, b, c]) => (b - a).cross(c - a),
            None => {
                let number = hit.id.primitive.checked_sub(geometry.triangle_count)?;
                let of_geometry =
                    geometry.first_sphere as usize..(geometry.first_sphere + geometry.sphere_count) as usize;
                let sphere = self.spheres[of_geometry].get(number as usize)?;
                instance.object_from_world.point(hit.point(ray)) - sphere.center
            }
        };
        // Normals go by the transpose of the inverse: that of the map into the object's space.
        let [x, y, z] = instance.object_from_world.columns;
        let world = vec3(x.dot(object_normal), y.dot(object_normal), z.dot(object_normal));
        // Unit length first, so that no square overflows or vanishes.
        let largest = world.abs().max_component();
        let unit = (world * (1.0 / largest)).normalize_or(Vec3::ZERO);
        (unit.is_finite() && unit != Vec3::ZERO).then_some(unit)
    }

    fn triangle_index(&self, id: PrimitiveId) -> Option<usize> {
        let instance = self.instances.get(id.instance as usize)?;
        let geometry = &self.geometries[instance.geometry as usize];
        (id.primitive < geometry.triangle_count).then(|| (geometry.first_triangle + id.primitive) as usize)
    }
}

/// The same triangle with its longest edge opposite the first corner, and where that corner was.
fn turned(triangle: &[Vec3; 3]) -> ([Vec3; 3], u8) {
    let first = longest_edge_last(triangle);
    ([0, 1, 2].map(|k| triangle[(first + k) % 3]), first as u8)
}

fn in_range(p: Vec3) -> bool {
    p.is_finite() && p.abs().max_component() <= LARGEST_COORDINATE
}

/// The box around all, not padded.
pub(crate) fn checked_bounds(triangles: &[[Vec3; 3]], spheres: &[Sphere]) -> Result<Bounds, SceneError> {
    let mut bounds = Bounds::EMPTY;
    for (number, triangle) in triangles.iter().enumerate() {
        if !triangle.iter().all(|&p| in_range(p)) {
            return Err(SceneError::Triangle(number));
        }
        bounds = triangle.iter().fold(bounds, |b, &p| b.including(p));
    }
    for (number, s) in spheres.iter().enumerate() {
        let r = Vec3::splat(s.radius);
        let (low, high) = (s.center - r, s.center + r);
        if !(s.radius > 0.0 && in_range(low) && in_range(high)) {
            return Err(SceneError::Sphere(number));
        }
        bounds = bounds.including(low).including(high);
    }
    Ok(bounds)
}

/// Whether what is in a box, so placed, lies within the range of coordinates.
fn fits(bounds: &Bounds, world_from_object: &Affine) -> bool {
    let world = bounds.transformed(world_from_object);
    world.is_empty() || (in_range(world.min) && in_range(world.max))
}

/// The inverse of a transform that can be used.
fn inverse(bounds: &Bounds, world_from_object: &Affine) -> Result<Affine, SceneError> {
    if !world_from_object.is_finite() || !fits(bounds, world_from_object) {
        return Err(SceneError::Transform);
    }
    world_from_object.inverse().ok_or(SceneError::Transform)
}
