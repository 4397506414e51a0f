//! Primitives in the form and order that hierarchies keep them.

use crate::SceneGeometry;
use eosphor_core::geometry::{Bounds, Geometry, Instance, Sphere};
use eosphor_core::hierarchy::PrimitivesView;
use eosphor_core::intersect::{PackedTriangle, sphere_bounds};

/// Primitives as traversals read them. Within each geometry's range they may stand in any order.
#[derive(Clone, Debug)]
pub struct PackedPrimitives {
    pub(crate) triangles: Vec<PackedTriangle>,
    pub(crate) spheres: Vec<Sphere>,
    /// For each sphere, its number in its geometry.
    pub(crate) sphere_primitives: Vec<u32>,
    /// Ranges of the above.
    pub(crate) geometries: Vec<Geometry>,
    pub(crate) instances: Vec<Instance>,
    /// How many geometries instances name: one more than the largest number of one.
    named_geometries: usize,
}

impl PackedPrimitives {
    /// A scene's geometries and instances, and none of its primitives so far.
    pub(crate) fn without_primitives(scene: &SceneGeometry) -> PackedPrimitives {
        PackedPrimitives {
            triangles: Vec::new(),
            spheres: Vec::new(),
            sphere_primitives: Vec::new(),
            geometries: scene.geometries().to_vec(),
            instances: scene.instances().to_vec(),
            named_geometries: scene.named_geometries(),
        }
    }

    /// Packs all primitives of a scene, in its order.
    pub fn new(scene: &SceneGeometry) -> PackedPrimitives {
        let mut packed = PackedPrimitives {
            triangles: Vec::with_capacity(scene.triangles().len()),
            spheres: Vec::with_capacity(scene.spheres().len()),
            sphere_primitives: Vec::with_capacity(scene.spheres().len()),
            ..PackedPrimitives::without_primitives(scene)
        };
        packed.repack_from(0, scene);
        packed
    }

    /// Takes the geometries and instances of another scene, which has the same geometries before this number.
    pub(crate) fn take_ranges(&mut self, scene: &SceneGeometry) {
        self.geometries.clear();
        self.geometries.extend_from_slice(scene.geometries());
        self.instances.clear();
        self.instances.extend_from_slice(scene.instances());
        self.named_geometries = scene.named_geometries();
    }

    /// Packs the primitives of the geometries from this number on, in the scene's order, in place of those that are there.
    /// Triangles before stand as many as in the scene.
    pub(crate) fn repack_from(&mut self, first: usize, scene: &SceneGeometry) {
        self.take_ranges(scene);
        let tail = &scene.geometries()[first..];
        let ends = (scene.triangles().len(), scene.spheres().len());
        let begins = |g: &Geometry| (g.first_triangle as usize, g.first_sphere as usize);
        let (triangles, spheres) = tail.first().map_or(ends, begins);
        self.triangles.truncate(triangles);
        self.truncate_spheres(spheres);
        for g in tail {
            let triangles = &scene.triangles()[g.first_triangle as usize..][..g.triangle_count as usize];
            self.triangles.extend((0..).zip(triangles).map(|(i, v)| PackedTriangle::new(*v, i)));
            let spheres = &scene.spheres()[g.first_sphere as usize..][..g.sphere_count as usize];
            self.spheres.extend_from_slice(spheres);
            self.sphere_primitives.extend((0..g.sphere_count).map(|i| g.triangle_count + i));
        }
    }

    /// Leaves only so many spheres.
    pub(crate) fn truncate_spheres(&mut self, count: usize) {
        self.spheres.truncate(count);
        self.sphere_primitives.truncate(count);
    }

    /// Bounds of the triangles of a geometry, in their present order, with slack.
    pub fn triangle_bounds(&self, geometry: &Geometry) -> Vec<Bounds> {
        let range = &self.triangles[geometry.first_triangle as usize..][..geometry.triangle_count as usize];
        range.iter().map(PackedTriangle::bounds).collect()
    }

    /// Bounds of the spheres of a geometry, in their present order, with slack.
    pub fn sphere_bounds(&self, geometry: &Geometry) -> Vec<Bounds> {
        let range = &self.spheres[geometry.first_sphere as usize..][..geometry.sphere_count as usize];
        range.iter().map(sphere_bounds).collect()
    }

    /// Triangles of all geometries, in the order in which the hierarchy's leaves have them.
    pub fn triangles(&self) -> &[PackedTriangle] {
        &self.triangles
    }

    /// Spheres of all geometries, in the order in which the hierarchy's leaves have them.
    pub fn spheres(&self) -> &[Sphere] {
        &self.spheres
    }

    /// For each sphere, its number in its geometry.
    pub fn sphere_primitives(&self) -> &[u32] {
        &self.sphere_primitives
    }

    /// Ranges of triangles and spheres, as the scene has them.
    pub fn geometries(&self) -> &[Geometry] {
        &self.geometries
    }

    /// Placed geometries; number 0 is the world.
    pub fn instances(&self) -> &[Instance] {
        &self.instances
    }

    /// The arrays, borrowed, for traversals.
    ///
    /// # Panics
    /// Where it was made of instances alone ([`SceneGeometry::of_instances`]).
    pub fn view(&self) -> PrimitivesView<'_> {
        self.view_with_instances_of(self)
    }

    /// Borrowed, with the instances of another, which may have been made of these alone.
    ///
    /// # Panics
    /// Where an instance is of a geometry that this does not have.
    pub(crate) fn view_with_instances_of<'a>(&'a self, top: &'a PackedPrimitives) -> PrimitivesView<'a> {
        check_instances(top.named_geometries, self.geometries.len());
        PrimitivesView {
            triangles: &self.triangles,
            spheres: &self.spheres,
            sphere_primitives: &self.sphere_primitives,
            geometries: &self.geometries,
            instances: &top.instances,
        }
    }
}

/// Whether instances that name so many geometries can be found in a hierarchy over so many.
///
/// # Panics
/// Where they cannot, or there is no geometry at all: such a hierarchy has no tracer.
#[inline]
pub(crate) fn check_instances(named_geometries: usize, geometries: usize) {
    assert!(geometries > 0, "a hierarchy over instances alone is the top level of another");
    assert!(
        named_geometries <= geometries,
        "instances place geometry {}, the hierarchy has {geometries}",
        named_geometries - 1
    );
}
