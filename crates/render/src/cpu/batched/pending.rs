//! Surface points whose rays are not all on their way yet.

use super::Path;
use eosphor_core::integrator::PathRay;
use eosphor_core::integrator::whitted::{Children, branches_at, ray_behind};
use eosphor_core::shading::SurfacePoint;
use eosphor_core::view::SceneView;

/// Rays of a glossy reflection that are computed together.
const TOGETHER: usize = 8;

/// Fewer are computed one by one.
const FEW: u32 = 3;

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
            if top.next < top.branches {
                top.take_branches(view, limit, paths);
                continue;
            }
            let Path { ref ray, x, y, sample } = top.path;
            let behind = ray_behind(view, &top.point, ray, top.t);
            self.points.pop();
            if let Some(ray) = behind {
                paths.push(Path { ray, x, y, sample });
            }
        }
    }
}

impl Branching {
    /// Takes branches until there are none or `limit` rays.
    #[inline(always)]
    fn take_branches(&mut self, view: &SceneView, limit: usize, paths: &mut Vec<Path>) {
        let Path { ref ray, x, y, sample } = self.path;
        let shown = PathRay { weight: ray.weight * self.point.coverage, ..*ray };
        let children = Children::new(view, &self.point, &shown, (x, y, sample));
        let glossy = children.glossy_rays();
        let glossy = if glossy >= FEW { glossy } else { 0 };
        if self.next < glossy {
            let Some(weight) = children.glossy_weight() else {
                self.next = glossy;
                return;
            };
            while self.next < glossy && paths.len() < limit {
                let lanes = children.glossy::<TOGETHER>(self.next);
                let room = (glossy - self.next).min((limit - paths.len()) as u32);
                for lane in 0..TOGETHER.min(room as usize) {
                    if let Some(ray) = children.glossy_ray(&lanes, lane, self.next, weight) {
                        paths.push(Path { ray, x, y, sample });
                    }
                    self.next += 1;
                }
            }
            return;
        }
        while self.next < self.branches && paths.len() < limit {
            let branch = self.next;
            self.next += 1;
            if let Some(ray) = children.ray(branch) {
                paths.push(Path { ray, x, y, sample });
            }
        }
    }
}
