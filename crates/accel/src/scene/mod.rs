//! Scenes for users of this crate alone: triangles, spheres and instances, without anything that a renderer needs.

mod error;
mod surface;

pub use error::SceneError;

use crate::SceneGeometry;
use eosphor_core::geometry::{Bounds, Geometry, Instance, Sphere};
use eosphor_core::intersect::longest_edge_last;
use eosphor_core::material::NONE;
use eosphor_core::math::{Affine, Vec3};

/// The largest coordinate or radius of a [`Scene`], so that products of them stay finite.
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
    /// Of each instance, the mask by which queries may leave it out.
    masks: Vec<u32>,
}

/// The name of a mesh of a [`Scene`]; of no other one.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct MeshId(u32);

/// The corners of the triangles of an indexed mesh, in the order of its faces. A face is the numbers of three vertices.
///
/// # Errors
/// [`SceneError::Face`] where a face names a vertex that is not there.
pub fn indexed(vertices: &[Vec3], faces: &[[u32; 3]]) -> Result<Vec<[Vec3; 3]>, SceneError> {
    let corner = |number: usize, v: u32| vertices.get(v as usize).copied().ok_or(SceneError::Face(number));
    let triangle = |(n, f): (usize, &[u32; 3])| Ok([corner(n, f[0])?, corner(n, f[1])?, corner(n, f[2])?]);
    faces.iter().enumerate().map(triangle).collect()
}

impl Default for Scene {
    /// A scene whose world has nothing in it.
    fn default() -> Scene {
        Scene::new(&[], &[]).expect("nothing is not too much")
    }
}

impl Scene {
    /// A scene whose world has these triangles and spheres, and in which nothing is placed.
    ///
    /// # Errors
    /// Where coordinates or radii are out of range, or there are too many primitives.
    pub fn new(triangles: &[[Vec3; 3]], spheres: &[Sphere]) -> Result<Scene, SceneError> {
        let mut scene = Scene {
            triangles: Vec::new(),
            first_corners: Vec::new(),
            spheres: Vec::new(),
            geometries: Vec::new(),
            bounds: Vec::new(),
            instances: Vec::new(),
            masks: Vec::new(),
        };
        let MeshId(world) = scene.mesh(triangles, spheres)?;
        // The world's own box is not asked.
        scene.push_instance(world, Affine::IDENTITY, Affine::IDENTITY);
        Ok(scene)
    }

    /// Adds a mesh of triangles and spheres in a space of its own. It is nowhere until it is placed ([`Scene::place`]).
    ///
    /// # Errors
    /// Where coordinates or radii are out of range, or there are too many primitives.
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

    /// The world as a mesh, for [`Scene::reshape`].
    pub const WORLD: MeshId = MeshId(0);

    /// Places a mesh by a transform from its space to the world; returns the number of the instance, which its hits have. The first
    /// one is 1: instance 0 is the world.
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

    /// Gives an instance another transform, from its mesh's space to the world. Hierarchies are to be refitted, or built again,
    /// afterwards.
    ///
    /// # Errors
    /// Where there is no such instance, it is the world (0), or the transform cannot be inverted or takes the mesh out of range.
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
        self.masks.push(u32::MAX);
    }

    /// Gives an instance a mask: a tracer of [`crate::Bvh8Tracer::with_masks`] sees it where the mask has a bit in common with its
    /// own. Instance 0, the world, has a mask, too. A new instance has all bits set. Hierarchies stay as they are.
    ///
    /// # Errors
    /// [`SceneError::Instance`] where there is no such instance.
    pub fn set_mask(&mut self, instance: u32, mask: u32) -> Result<(), SceneError> {
        *self.masks.get_mut(instance as usize).ok_or(SceneError::Instance(instance))? = mask;
        Ok(())
    }

    /// The masks of all instances, by their numbers.
    pub fn masks(&self) -> &[u32] {
        &self.masks
    }

    /// The arrays of the scene, borrowed, for building and refitting hierarchies.
    pub fn geometry(&self) -> SceneGeometry<'_> {
        SceneGeometry::of_checked(&self.triangles, &self.spheres, &self.geometries, &self.instances)
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
