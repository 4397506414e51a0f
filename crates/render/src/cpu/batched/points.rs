//! The surface points of hits.

use super::lit::LANES;
use super::triangle_order::TriangleOrder;
use eosphor_core::ray::{Hit, Ray};
use eosphor_core::shading::{PointLanes, SurfacePoint, WorldPrimitive};
use eosphor_core::view::SceneView;

/// Fewer triangles, or spheres, are computed one by one.
const FEW: usize = 4;

/// What a ray hit, and its number in the batch.
#[derive(Clone, Copy)]
pub(super) struct Arrival {
    pub(super) ray: u32,
    /// If its point can be computed together with others.
    found: Option<WorldPrimitive>,
}

/// All hits of a batch by their kind, so that points of one kind are computed together.
#[derive(Default)]
pub(super) struct Arrivals {
    /// Triangles and spheres of the world, and others.
    pub(super) of_kind: [Vec<Arrival>; 3],
    order: TriangleOrder<Arrival>,
}

impl Arrivals {
    pub(super) fn clear(&mut self) {
        self.of_kind.iter_mut().for_each(Vec::clear);
    }

    /// Adds a hit, not a miss.
    #[inline(always)]
    pub(super) fn push(&mut self, view: &SceneView, ray: usize, hit: &Hit) {
        let found = WorldPrimitive::of(view, hit);
        let kind = match &found {
            Some(found) => found.is_sphere as usize,
            None => 2,
        };
        self.of_kind[kind].push(Arrival { ray: ray as u32, found });
    }

    /// Puts hits of triangles into the order of those.
    #[inline(always)]
    pub(super) fn sort_triangles(&mut self, view: &SceneView) {
        let number = |arrival: &Arrival| arrival.found.map_or(0, |found| found.number());
        self.order.sort(&mut self.of_kind[0], view.triangles.len(), number);
    }
}

/// The points of some hits of one kind, as far as they can be computed together.
pub(super) struct Points(Option<PointLanes<LANES>>);

impl Points {
    /// Of up to as many hits as there are lanes.
    #[inline(always)]
    pub(super) fn of(view: &SceneView, arrivals: &[Arrival], rays: &[Ray], hits: &[Hit]) -> Points {
        let Some(first) = arrivals.first().and_then(|a| a.found).filter(|_| arrivals.len() >= FEW) else {
            return Points(None);
        };
        let at = arrivals[0].ray as usize;
        // Idle lanes repeat one that is not.
        let mut chosen = [(first, at); LANES];
        for (chosen, arrival) in chosen.iter_mut().zip(arrivals) {
            *chosen = (arrival.found.unwrap_or(first), arrival.ray as usize);
        }
        // First into arrays, since a large closure would be compiled for any CPU.
        Points(Some(if first.is_sphere {
            let mut spheres = [first.sphere(view, &rays[at], &hits[at]); LANES];
            for (sphere, &(found, at)) in spheres.iter_mut().zip(&chosen) {
                *sphere = found.sphere(view, &rays[at], &hits[at]);
            }
            PointLanes::of_spheres(|lane| spheres[lane])
        } else {
            let mut triangles = [first.triangle(view, &rays[at], &hits[at]); LANES];
            for (triangle, &(found, at)) in triangles.iter_mut().zip(&chosen) {
                *triangle = found.triangle(view, &rays[at], &hits[at]);
            }
            PointLanes::new(|lane| triangles[lane])
        }))
    }

    /// Those of hits on primitives of one material that is the same everywhere on them.
    #[inline(always)]
    pub(super) fn alike(&self, arrivals: &[Arrival]) -> Option<&PointLanes<LANES>> {
        let first = arrivals.first().and_then(|first| first.found)?;
        for arrival in arrivals {
            if !arrival.found.is_some_and(|found| found.is_plain_as(&first)) {
                return None;
            }
        }
        self.0.as_ref()
    }

    /// That of a hit.
    #[inline(always)]
    pub(super) fn get(
        &self,
        view: &SceneView,
        (lane, arrival): (usize, &Arrival),
        ray: &Ray,
        hit: &Hit,
    ) -> SurfacePoint {
        match (&self.0, &arrival.found) {
            (Some(points), Some(found)) => SurfacePoint::of_lane(view, points, lane, found, hit),
            _ => SurfacePoint::new(view, ray, hit),
        }
    }
}
