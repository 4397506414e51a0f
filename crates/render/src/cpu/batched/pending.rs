//! Rays that go on and are not on their way yet, and surface points with many of them.

use super::Path;
use eosphor_core::integrator::PathRay;
use eosphor_core::integrator::whitted::{Children, branches_at, ray_behind};
use eosphor_core::shading::SurfacePoint;
use eosphor_core::view::SceneView;

/// Rays of a glossy reflection that are computed together.
const TOGETHER: usize = 8;

/// Fewer are computed one by one.
const FEW: u32 = 3;

/// A point with more rays than these waits itself.
const AT_ONCE: u32 = 2;

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
    /// How many rays waited when it came: the others lie above it.
    rays_below: usize,
}

/// A stack of rays and of points with more of them. What came last is taken first, be it ray or point: were all rays taken before
/// points, points of whole trees of rays would wait at one time.
#[derive(Default)]
pub(super) struct Pending {
    paths: Vec<Path>,
    points: Vec<Branching>,
}

impl Pending {
    #[inline(always)]
    pub(super) fn clear(&mut self) {
        self.paths.clear();
        self.points.clear();
    }

    /// How many rays and points wait.
    #[inline(always)]
    pub(super) fn len(&self) -> usize {
        self.paths.len() + self.points.len()
    }

    /// Puts the rays that go on from a point on top. `path` found it at distance `t`.
    #[inline(always)]
    pub(super) fn push(
        &mut self,
        view: &SceneView,
        point: &SurfacePoint,
        path: &Path,
        t: f32,
        max_depth: u32,
    ) {
        let Path { ref ray, x, y, sample } = *path;
        let branches = branches_at(point, ray.depth, max_depth);
        let behind = ray_behind(view, point, ray, t);
        // What lies behind a hole takes the place of the hole's point, however many holes there are.
        if branches > AT_ONCE || (branches > 0 && behind.is_some()) {
            let rays_below = self.paths.len();
            self.points.push(Branching { point: *point, path: *path, t, next: 0, branches, rays_below });
        } else if let Some(ray) = behind {
            self.paths.push(Path { ray, x, y, sample });
        } else if branches > 0 {
            let shown = shown(path, point);
            let children = Children::new(view, point, &shown, (x, y, sample));
            // (In a loop, all that both kinds need would be computed for either.)
            if let Some(ray) = children.ray(0) {
                self.paths.push(Path { ray, x, y, sample });
            }
            if branches > 1
                && let Some(ray) = children.ray(1)
            {
                self.paths.push(Path { ray, x, y, sample });
            }
        }
    }

    /// Takes up to `limit` rays from the top.
    #[inline(always)]
    pub(super) fn take(&mut self, view: &SceneView, limit: usize, paths: &mut Vec<Path>) {
        while paths.len() < limit {
            let rays_below = self.points.last().map_or(0, |top| top.rays_below);
            if self.paths.len() > rays_below {
                let room = limit - paths.len();
                let first = self.paths.len().saturating_sub(room).max(rays_below);
                paths.extend_from_slice(&self.paths[first..]);
                self.paths.truncate(first);
                continue;
            }
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

/// What found a point, with the weight of what the point gives.
#[inline(always)]
fn shown(path: &Path, point: &SurfacePoint) -> PathRay {
    PathRay { weight: path.ray.weight * point.coverage, ..path.ray }
}

impl Branching {
    /// Takes branches until there are none or `limit` rays.
    #[inline(always)]
    fn take_branches(&mut self, view: &SceneView, limit: usize, paths: &mut Vec<Path>) {
        let Path { x, y, sample, .. } = self.path;
        let shown = shown(&self.path, &self.point);
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

#[cfg(test)]
mod tests {
    use super::*;
    use eosphor_core::integrator::camera_ray;
    use eosphor_core::material::{FresnelUse, Refraction};
    use eosphor_core::math::{Vec3, vec3};
    use eosphor_core::ray::PrimitiveId;
    use eosphor_core::shading::EvaluatedMaterial;
    use eosphor_scene::{Scene, SceneData};

    /// A point that the ray of sample `sample` met head-on, with so many glossy rays, or a mirror.
    fn push(pending: &mut Pending, view: &SceneView, sample: u32, glossy_rays: u32, coverage: f32) {
        let material_values = EvaluatedMaterial {
            diffuse: Vec3::ZERO,
            specular: Vec3::ZERO,
            shininess: 1.0,
            lamp_highlights: false,
            emission: Vec3::ZERO,
            ior: 1.5,
            reflection: Vec3::ONE,
            fresnel: FresnelUse::Ignore,
            metal: 0.0,
            metal_color: Vec3::ZERO,
            transmission: Vec3::ZERO,
            refraction: Refraction::Straight,
            shadow_filter: Vec3::ZERO,
            opacity: coverage,
            glossy_rays,
            glossy_rays_later: glossy_rays,
            glossy_exponent: 1e6,
            glossy_transmission: false,
        };
        let up = vec3(0.0, 0.0, 1.0);
        let point = SurfacePoint {
            position: Vec3::ZERO,
            geometric_normal: up,
            normal: up,
            to_viewer: up,
            front: true,
            material_values,
            material: 0,
            coverage,
            id: PrimitiveId { instance: 0, primitive: 0 },
            offset: 1e-3,
        };
        let ray = PathRay { origin: up, direction: -up, weight: Vec3::ONE, ..camera_ray(view, 0, 0, 0) };
        pending.push(view, &point, &Path { ray, x: 0, y: 0, sample }, 1.0, 5);
    }

    #[test]
    fn what_came_last_is_taken_first() {
        let (data, _) = SceneData::flatten(&Scene::default()).unwrap();
        let (view, mut pending) = (data.view(), Pending::default());
        push(&mut pending, &view, 1, 0, 1.0);
        push(&mut pending, &view, 2, 4, 1.0);
        push(&mut pending, &view, 3, 0, 1.0);
        assert_eq!(pending.len(), 3);
        let mut order = Vec::new();
        for limit in [1, 2, 9] {
            let mut taken = Vec::new();
            pending.take(&view, limit, &mut taken);
            order.push(taken.iter().map(|path| path.sample).collect::<Vec<u32>>());
            if limit == 2 {
                // Lies above what is left of the point.
                push(&mut pending, &view, 4, 0, 1.0);
            }
        }
        assert_eq!(order, [vec![3], vec![2, 2], vec![4, 2, 2, 1]]);
        assert_eq!(pending.len(), 0);
    }

    #[test]
    fn what_lies_behind_a_hole_takes_the_place_of_its_point() {
        let (data, _) = SceneData::flatten(&Scene::default()).unwrap();
        let (view, mut pending) = (data.view(), Pending::default());
        push(&mut pending, &view, 1, 0, 0.5);
        assert_eq!(pending.len(), 1);
        let mut taken = Vec::new();
        pending.take(&view, 9, &mut taken);
        assert_eq!(taken.iter().map(|path| path.ray.direction.z > 0.0).collect::<Vec<bool>>(), [true, false]);
    }
}
