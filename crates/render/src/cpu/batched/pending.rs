//! Surface points whose rays are not all on their way yet.

use super::Path;
use eosphor_core::integrator::PathRay;
use eosphor_core::integrator::whitted::{branches_at, child_ray, ray_behind};
use eosphor_core::shading::SurfacePoint;
use eosphor_core::view::SceneView;

/// A point and what is next of its rays.
#[derive(Clone, Copy, Debug)]
struct Branching {
    point: SurfacePoint,
    /// What found it, with the weight with which it arrived.
    path: Path,
    /// How far it came.
    t: f32,
    next: u32,
    branches: u32,
}

/// A stack of points.
#[derive(Default)]
pub(super) struct Pending {
    points: Vec<Branching>,
}

impl Pending {
    #[inline(always)]
    pub(super) fn clear(&mut self) {
        self.points.clear();
    }

    /// How many points wait.
    #[inline(always)]
    pub(super) fn len(&self) -> usize {
        self.points.len()
    }

    /// Puts a point on top that `path` found at distance `t`, where any ray goes on from it.
    #[inline(always)]
    pub(super) fn push(
        &mut self,
        view: &SceneView,
        point: &SurfacePoint,
        path: &Path,
        t: f32,
        max_depth: u32,
    ) {
        let branches = branches_at(point, path.ray.depth, max_depth);
        if branches > 0 || ray_behind(view, point, &path.ray, t).is_some() {
            self.points.push(Branching { point: *point, path: *path, t, next: 0, branches });
        }
    }

    /// Takes up to `limit` rays from the points on top.
    #[inline(always)]
    pub(super) fn take(&mut self, view: &SceneView, limit: usize, paths: &mut Vec<Path>) {
        while paths.len() < limit {
            let Some(top) = self.points.last_mut() else { return };
            let Path { ref ray, x, y, sample } = top.path;
            let next = if top.next < top.branches {
                let branch = top.next;
                top.next += 1;
                let shown = PathRay { weight: ray.weight * top.point.coverage, ..*ray };
                child_ray(view, &top.point, &shown, (x, y, sample), branch)
            } else {
                let behind = ray_behind(view, &top.point, ray, top.t);
                self.points.pop();
                behind
            };
            if let Some(ray) = next {
                paths.push(Path { ray, x, y, sample });
            }
        }
    }
}
