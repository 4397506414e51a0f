//! No hierarchy.

use crate::bvh::{RefitError, check_before};
use crate::cost::{around, half_area};
use crate::{HierarchyStatistics, PackedPrimitives, SceneGeometry};
use eosphor_core::geometry::{Bounds, Geometry, Instance};
use eosphor_core::hierarchy::{ExhaustiveTracer, PrimitivesView, Work};

/// No hierarchy: primitives in the scene's order, and every query tests them all. It is the reference for all structures.
#[derive(Clone, Debug)]
pub struct Exhaustive {
    /// Primitives and instances.
    primitives: PackedPrimitives,
}

impl Exhaustive {
    /// Copies the primitives of a scene into the form in which they are tested.
    pub fn new(scene: &SceneGeometry) -> Exhaustive {
        Exhaustive { primitives: PackedPrimitives::new(scene) }
    }

    /// Takes the shapes of the geometries from number `first` on, and all instances, from a scene. The result is what
    /// [`Exhaustive::new`] makes of the scene, if the geometries before are as they were.
    ///
    /// # Errors
    /// Where the geometries before have other ranges in the scene; nothing is changed then.
    pub fn rebuild_from(&mut self, first: usize, scene: &SceneGeometry) -> Result<(), RefitError> {
        check_before(&self.primitives.geometries, first, scene)?;
        self.primitives.repack_from(first, scene);
        Ok(())
    }

    /// The arrays, borrowed, with the instances of another one, `top`, in place of the own ones. That one may be made of the
    /// instances alone
    /// ([`SceneGeometry::of_instances`]).
    ///
    /// # Panics
    /// Where an instance is of a geometry that this does not have.
    pub fn view_with_instances_of<'a>(&'a self, top: &'a Exhaustive) -> PrimitivesView<'a> {
        self.primitives.view_with_instances_of(&top.primitives)
    }

    /// The test of everything, one ray at a time. It tells `work` what it does; [`IgnoreWork`](crate::IgnoreWork) costs nothing.
    ///
    /// # Panics
    /// Where this was made of instances alone ([`SceneGeometry::of_instances`]).
    pub fn tracer<C: Work>(&self, work: C) -> ExhaustiveTracer<'_, C> {
        self.tracer_with_instances_of(self, work)
    }

    /// The test of [`Exhaustive::tracer`], with the instances of another one, `top`, in place of the own ones. That one may be made
    /// of the instances alone
    /// ([`SceneGeometry::of_instances`]).
    ///
    /// # Panics
    /// Where an instance is of a geometry that this hierarchy does not have.
    pub fn tracer_with_instances_of<'a, C: Work>(
        &'a self,
        top: &'a Exhaustive,
        work: C,
    ) -> ExhaustiveTracer<'a, C> {
        // SAFETY: closed view: the fields are private, and builders make them so; `view_with_instances_of` checks the instances.
        unsafe { ExhaustiveTracer::new(self.view_with_instances_of(top), work) }
    }

    /// Primitives, in the scene's order.
    pub fn primitives(&self) -> &PackedPrimitives {
        &self.primitives
    }

    /// Its numbers of primitives and bytes, and its expected cost; what only a hierarchy has is 0.
    pub fn statistics(&self) -> HierarchyStatistics {
        let p = &self.primitives;
        let primitives = (p.triangles.len() + p.spheres.len()) as u64;
        HierarchyStatistics {
            structure: "none",
            builder: "none",
            primitives,
            references: primitives,
            sah_cost: self.sah_cost(),
            bytes: (size_of_val(&p.triangles[..]) + size_of_val(&p.spheres[..])) as u64,
            ..HierarchyStatistics::default()
        }
    }
    /// Every ray tests the world's own primitives and the boxes of all instances; those that meet a box test what is inside.
    fn sah_cost(&self) -> f64 {
        let p = &self.primitives;
        let held =
            |geometry: &Geometry| f64::from(geometry.triangle_count) + f64::from(geometry.sphere_count);
        let Some(world) = p.geometries.first() else { return 0.0 };
        let boxes = [p.triangle_bounds(world), p.sphere_bounds(world)].concat();
        let own = boxes.iter().fold(Bounds::EMPTY, |bounds, b| bounds.union(b));
        let area = half_area(&around(own, &p.instances));
        let of_instance = |instance: &Instance| {
            let inside = held(&p.geometries[instance.geometry as usize]);
            1.0 + if area > 0.0 { half_area(&instance.world_bounds) / area * inside } else { 0.0 }
        };
        held(world) + p.instances.iter().skip(1).map(of_instance).sum::<f64>()
    }
}
