//! The reference scheduler: one loop with a fixed stack.

use super::local::is_lit;
use super::{ExactSum, PathRay, RayKind, branch_count, camera_ray, child_ray, direct_light, local_radiance};
use crate::hierarchy::{Stack, Tracer};
use crate::math::Vec3;
use crate::ray::Hit;
use crate::shading::SurfacePoint;
use crate::view::SceneView;

/// The largest depth limit; the stack has a level for every bounce.
pub const MAX_DEPTH: u32 = 64;

/// Rays of a sample by kind.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[repr(C)]
pub struct RayCounts {
    /// From the camera.
    pub camera: u64,
    /// Mirrored.
    pub reflected: u64,
    /// Through surfaces.
    pub refracted: u64,
    /// Of glossy lobes.
    pub glossy: u64,
    /// Towards lights.
    pub shadow: u64,
}

impl RayCounts {
    #[inline(always)]
    fn count(&mut self, kind: RayKind) {
        match kind {
            RayKind::Camera => self.camera += 1,
            RayKind::Reflected => self.reflected += 1,
            RayKind::Refracted => self.refracted += 1,
            RayKind::Glossy => self.glossy += 1,
        }
    }
}

/// A surface point on the way whose rays are not all traced yet. The point itself is computed again for each branch,
/// so that a level stays small and the stack does not grow with the number of glossy rays.
#[derive(Clone, Copy)]
struct Level {
    ray: PathRay,
    hit: Hit,
    next_branch: u32,
}

/// Adds what `first` finds, and everything that follows from it, to `sum`. `W` shadow rays towards a light are asked for
/// at a time: it changes the speed only.
#[inline(always)]
pub fn radiance<T: Tracer, const W: usize>(
    view: &SceneView,
    tracer: &T,
    first: PathRay,
    (x, y, sample): (u32, u32, u32),
    sum: &mut ExactSum,
    counts: &mut RayCounts,
) {
    let settings = view.settings;
    let mut room = Stack::<Level, { MAX_DEPTH as usize }>::room();
    let mut stack = Stack::new(&mut room);
    let mut path_ray = first;
    loop {
        counts.count(path_ray.kind);
        let ray = path_ray.ray();
        let hit = tracer.closest_hit(&ray, &path_ray.filter(settings));
        if hit.is_miss() {
            sum.add(path_ray.weight * settings.background);
        } else {
            let point = SurfacePoint::new(view, &ray, &hit);
            let mut found = local_radiance(view, &point, hit.t);
            if is_lit(settings.lighting_model) {
                found += direct_light::<T, W>(
                    view,
                    tracer,
                    &point,
                    path_ray.path,
                    (x, y, sample),
                    &mut counts.shadow,
                );
                if path_ray.depth < settings.max_depth.min(MAX_DEPTH) && branch_count(point.material) > 0 {
                    // SAFETY: levels have depths 0, 1, 2 ... each, all below MAX_DEPTH.
                    unsafe { stack.push(Level { ray: path_ray, hit, next_branch: 0 }) };
                }
            }
            sum.add(path_ray.weight * found);
        }
        // The next branch of the deepest point that has one.
        path_ray = loop {
            let Some(level) = stack.top_mut() else { return };
            let point = SurfacePoint::new(view, &level.ray.ray(), &level.hit);
            if level.next_branch == branch_count(point.material) {
                stack.pop();
                continue;
            }
            let branch = level.next_branch;
            level.next_branch += 1;
            if let Some(child) = child_ray(view, &point, &level.ray, (x, y, sample), branch) {
                break child;
            }
        };
    }
}

/// Adds all samples of a pixel to a sum.
#[inline(always)]
pub fn render_pixel<T: Tracer, const W: usize>(
    view: &SceneView,
    tracer: &T,
    x: u32,
    y: u32,
    counts: &mut RayCounts,
) -> ExactSum {
    let mut sum = ExactSum::default();
    let mut sample = 0;
    while sample < view.settings.samples {
        let ray = camera_ray(view, x, y, sample);
        radiance::<T, W>(view, tracer, ray, (x, y, sample), &mut sum, counts);
        sample += 1;
    }
    sum
}

/// The colour of a pixel, from its sum.
#[inline(always)]
pub fn pixel_color(view: &SceneView, sum: &ExactSum) -> Vec3 {
    sum.mean(view.settings.samples)
}
