//! Primitives in the form and order that hierarchies keep them.

use eosphor_core::geometry::{Bounds, Geometry, Instance, Sphere};
use eosphor_core::hierarchy::PrimitivesView;
use eosphor_core::intersect::{PackedTriangle, sphere_bounds};
use eosphor_core::math::Vec3;

/// What hierarchies are built over: triangles and spheres of all geometries, and the instances that place them.
#[derive(Clone, Copy, Debug)]
pub struct SceneGeometry<'a> {
    /// Vertices of the triangles of all geometries.
    pub triangles: &'a [[Vec3; 3]],
    /// Spheres of all geometries.
    pub spheres: &'a [Sphere],
    /// Ranges of the above; number 0 is the world.
    pub geometries: &'a [Geometry],
    /// Placed geometries; number 0 is the world itself.
    pub instances: &'a [Instance],
}

impl<'a> SceneGeometry<'a> {
    /// Instances alone, of geometries that are elsewhere. What is built over them finds instances of a hierarchy that was
    /// built over everything: where nothing but instances moves, no more than this has to be built for a frame.
    pub fn of_instances(instances: &'a [Instance]) -> SceneGeometry<'a> {
        SceneGeometry { triangles: &[], spheres: &[], geometries: &[], instances }
    }
}

/// Primitives as traversals read them. Within each geometry's range they may stand in any order.
#[derive(Clone, Debug)]
pub struct PackedPrimitives {
    /// Triangles of all geometries.
    pub triangles: Vec<PackedTriangle>,
    /// Spheres of all geometries.
    pub spheres: Vec<Sphere>,
    /// For each sphere, its number in its geometry.
    pub sphere_primitives: Vec<u32>,
    /// Ranges of the above.
    pub geometries: Vec<Geometry>,
    /// Placed geometries.
    pub instances: Vec<Instance>,
}

impl PackedPrimitives {
    /// All primitives, in the scene's order.
    pub fn new(scene: &SceneGeometry) -> PackedPrimitives {
        let mut packed = PackedPrimitives {
            triangles: Vec::with_capacity(scene.triangles.len()),
            spheres: scene.spheres.to_vec(),
            sphere_primitives: Vec::with_capacity(scene.spheres.len()),
            geometries: scene.geometries.to_vec(),
            instances: scene.instances.to_vec(),
        };
        for g in scene.geometries {
            let triangles = &scene.triangles[g.first_triangle as usize..][..g.triangle_count as usize];
            packed.triangles.extend((0..).zip(triangles).map(|(i, v)| PackedTriangle::new(*v, i)));
            packed.sphere_primitives.extend((0..g.sphere_count).map(|i| g.triangle_count + i));
        }
        packed
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

    /// Borrowed, for traversals.
    pub fn view(&self) -> PrimitivesView<'_> {
        self.view_with_instances_of(self)
    }

    /// The same with other instances.
    pub(crate) fn view_with_instances_of<'a>(&'a self, top: &'a PackedPrimitives) -> PrimitivesView<'a> {
        PrimitivesView {
            triangles: &self.triangles,
            spheres: &self.spheres,
            sphere_primitives: &self.sphere_primitives,
            geometries: &self.geometries,
            instances: &top.instances,
        }
    }
}
