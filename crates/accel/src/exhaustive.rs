//! No hierarchy.

use crate::{HierarchyStatistics, PackedPrimitives, SceneGeometry};
use eosphor_core::hierarchy::{ExhaustiveTracer, PrimitivesView, Work};

/// Primitives in the scene's order; every query tests them all.
#[derive(Clone, Debug)]
pub struct Exhaustive {
    /// Primitives and instances.
    pub primitives: PackedPrimitives,
}

impl Exhaustive {
    /// Packs the primitives.
    pub fn new(scene: &SceneGeometry) -> Exhaustive {
        Exhaustive { primitives: PackedPrimitives::new(scene) }
    }

    /// Borrowed, with the instances of another, which may have been made of these alone
    /// ([`SceneGeometry::of_instances`]).
    pub fn view_with_instances_of<'a>(&'a self, top: &'a Exhaustive) -> PrimitivesView<'a> {
        self.primitives.view_with_instances_of(&top.primitives)
    }

    /// The traversal.
    pub fn tracer<C: Work>(&self, work: C) -> ExhaustiveTracer<'_, C> {
        ExhaustiveTracer { primitives: self.primitives.view(), work }
    }

    /// Numbers, as far as there are any.
    pub fn statistics(&self) -> HierarchyStatistics {
        let p = &self.primitives;
        let primitives = (p.triangles.len() + p.spheres.len()) as u64;
        HierarchyStatistics {
            structure: "none",
            builder: "none",
            primitives,
            references: primitives,
            sah_cost: primitives as f64,
            bytes: (size_of_val(&p.triangles[..]) + size_of_val(&p.spheres[..])) as u64,
            ..HierarchyStatistics::default()
        }
    }
}
