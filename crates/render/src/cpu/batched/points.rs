//! The surface points of hits.

use super::lit::LANES;
use eosphor_core::ray::{Hit, Ray};
use eosphor_core::shading::{PointLanes, SurfacePoint, WorldPrimitive};
use eosphor_core::view::SceneView;

/// Fewer triangles, or spheres, are computed one by one.
const FEW: usize = 4;

/// The points of some hits, as far as they can be computed together.
pub(super) struct Points {
    found: [Option<WorldPrimitive>; LANES],
    /// Whether triangles, and spheres, are computed together.
    together: [bool; 2],
    triangles: PointLanes<LANES>,
    spheres: PointLanes<LANES>,
}

impl Points {
    pub(super) const NONE: Points = Points {
        found: [None; LANES],
        together: [false; 2],
        triangles: PointLanes::NONE,
        spheres: PointLanes::NONE,
    };

    /// Of the first hits, as many as there are lanes.
    #[inline(always)]
    pub(super) fn find(&mut self, view: &SceneView, rays: &[Ray], hits: &[Hit]) {
        self.found = [None; LANES];
        let (mut counts, mut last) = ([0; 2], [0; 2]);
        for (lane, hit) in hits.iter().take(LANES).enumerate() {
            if !hit.is_miss() {
                self.found[lane] = WorldPrimitive::of(view, hit);
            }
            if let Some(found) = &self.found[lane] {
                let kind = found.is_sphere as usize;
                (counts[kind], last[kind]) = (counts[kind] + 1, lane);
            }
        }
        for kind in 0..2 {
            self.together[kind] = counts[kind] >= FEW;
            let Some(other) = self.found[last[kind]].filter(|_| self.together[kind]) else { continue };
            // Idle lanes repeat one that is not.
            let mut chosen = [(other, last[kind]); LANES];
            for lane in 0..LANES {
                if let Some(found) = self.found[lane]
                    && found.is_sphere as usize == kind
                {
                    chosen[lane] = (found, lane);
                }
            }
            // First into arrays, since a large closure would be compiled for any CPU.
            if kind == 0 {
                let mut triangles = [other.triangle(view, &rays[last[kind]], &hits[last[kind]]); LANES];
                for (triangle, &(found, from)) in triangles.iter_mut().zip(&chosen) {
                    *triangle = found.triangle(view, &rays[from], &hits[from]);
                }
                self.triangles = PointLanes::new(|lane| triangles[lane]);
            } else {
                let mut spheres = [other.sphere(view, &rays[last[kind]], &hits[last[kind]]); LANES];
                for (sphere, &(found, from)) in spheres.iter_mut().zip(&chosen) {
                    *sphere = found.sphere(view, &rays[from], &hits[from]);
                }
                self.spheres = PointLanes::of_spheres(|lane| spheres[lane]);
            }
        }
    }

    /// That of a hit.
    #[inline(always)]
    pub(super) fn get(&self, view: &SceneView, lane: usize, ray: &Ray, hit: &Hit) -> SurfacePoint {
        match &self.found[lane] {
            Some(found) if self.together[found.is_sphere as usize] => {
                let points = if found.is_sphere { &self.spheres } else { &self.triangles };
                SurfacePoint::of_lane(view, points, lane, found, hit)
            }
            _ => SurfacePoint::new(view, ray, hit),
        }
    }
}
