//! The reference scheduler: one loop with a fixed stack.

use super::{
    LampLobe, LitPoint, branches_at, child_ray, depth_limit, direct_light, local_radiance, ray_behind,
    takes_light,
};
use crate::hierarchy::{Stack, Tracer};
use crate::integrator::{MAX_DEPTH, PathRay, RayCounts, weight_at};
use crate::ray::Hit;
use crate::shading::SurfacePoint;
use crate::sums::ExactSum;
use crate::view::SceneView;

/// A surface point on the way whose rays are not all traced yet. The point itself is computed again for each branch,
/// so that a level stays small and the stack does not grow with the number of glossy rays.
#[derive(Clone, Copy)]
struct Level {
    ray: PathRay,
    hit: Hit,
    next_branch: u32,
}

/// The next branch of a point that has not been shaded yet.
const FRESH: u32 = u32::MAX;

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
    let max_depth = depth_limit(settings);
    let mut storage = Stack::<Level, { MAX_DEPTH as usize + 1 }>::storage();
    let mut stack = Stack::new(&mut storage);
    let mut path_ray = first;
    loop {
        counts.count(path_ray.kind);
        let hit = tracer.closest_hit(&path_ray.ray(), &path_ray.filter(settings));
        if hit.is_miss() {
            sum.add(path_ray.weight * settings.background);
        } else {
            // SAFETY: each level is deeper than the one below it, and none is deeper than MAX_DEPTH.
            unsafe { stack.push(Level { ray: path_ray, hit, next_branch: FRESH }) };
        }
        // The next branch of the deepest point that has one.
        path_ray = 'next: loop {
            let Some(level) = stack.top_mut() else { return };
            let point = SurfacePoint::new(view, &level.ray.ray(), &level.hit);
            let there = point.coverage;
            if level.next_branch == FRESH {
                level.next_branch = 0;
                level.ray.weight = weight_at(view, &point, &level.ray, level.hit.t);
                if there > 0.0 {
                    let mut found = local_radiance(view, &point, &level.ray, level.hit.t);
                    if settings.lighting_model.is_lit() {
                        let lobe = LampLobe::new(view, &point, &level.ray, max_depth);
                        if takes_light(&point, &lobe) {
                            let (path, place) = (level.ray.path, (x, y, sample));
                            let point = LitPoint::new(&point, &lobe);
                            let shadow_rays = &mut counts.shadow;
                            found += direct_light::<T, W>(view, tracer, &point, path, place, shadow_rays);
                        }
                    }
                    sum.add(level.ray.weight * there * found);
                }
            }
            let ray = level.ray;
            let shown = PathRay { weight: ray.weight * there, ..ray };
            let branches = branches_at(&point, ray.depth, max_depth);
            while level.next_branch < branches {
                let branch = level.next_branch;
                level.next_branch += 1;
                if let Some(child) = child_ray(view, &point, &shown, (x, y, sample), branch) {
                    // Nothing is left to do here after the last branch: the point would be computed again for nothing.
                    if level.next_branch == branches && there >= 1.0 {
                        stack.pop();
                    }
                    break 'next child;
                }
            }
            // What is behind the holes comes last, when the level has made room for it: it is no bounce.
            let t = level.hit.t;
            stack.pop();
            if let Some(behind) = ray_behind(view, &point, &ray, t) {
                break 'next behind;
            }
        };
    }
}
