//! Queries with a closure that says which hits count, for any structure.

use eosphor_core::hierarchy::Tracer;
use eosphor_core::ray::{Hit, Ray, RayFilter};

/// The closest hit among those that `accept` says yes to; a miss if there is none. `accept` is asked about the hits in the order
/// in which they lie along the ray, ties by the lowest (instance, primitive), and about none behind the answer.
///
/// It works with every structure, by [`Tracer::next_hit`]: each hit that is refused costs a query more. For a [`crate::Bvh8`],
/// [`crate::Bvh8Tracer::closest_hit_where`] finds the same hit in one walk. Here [`Hit::t_rest`] is always known.
///
/// ```
/// use eosphor_accel::{IgnoreWork, KdTree, KdTreeOptions, Ray, RayFilter, Scene, closest_hit_where, vec3};
///
/// let triangle = |z: f32| [vec3(-1.0, -1.0, z), vec3(1.0, -1.0, z), vec3(0.0, 1.0, z)];
/// let scene = Scene::new(&[triangle(0.0), triangle(-2.0)], &[])?;
/// let tree = KdTree::build(&scene.geometry(), &KdTreeOptions::default());
/// let ray = Ray::new(vec3(0.0, 0.0, 5.0), vec3(0.0, 0.0, -1.0));
/// let tracer = tree.tracer(IgnoreWork);
/// let hit = closest_hit_where(&tracer, &ray, &RayFilter::ALL, |hit| hit.id.primitive != 0);
/// assert_eq!((hit.t, hit.id.primitive), (7.0, 1));
/// # Ok::<(), eosphor_accel::SceneError>(())
/// ```
pub fn closest_hit_where(
    tracer: &impl Tracer,
    ray: &Ray,
    filter: &RayFilter,
    mut accept: impl FnMut(&Hit) -> bool,
) -> Hit {
    // All hits come after this one.
    let mut hit = Hit::miss(f32::NEG_INFINITY);
    loop {
        hit = tracer.next_hit(ray, filter, &hit);
        if hit.is_miss() || accept(&hit) {
            return hit;
        }
    }
}

/// Whether there is any hit that `accept` says yes to. `accept` is asked as by [`closest_hit_where`], and each hit that it
/// refuses costs a query more. For a [`crate::Bvh8`] there is [`crate::Bvh8Tracer::occluded_where`].
pub fn occluded_where(
    tracer: &impl Tracer,
    ray: &Ray,
    filter: &RayFilter,
    accept: impl FnMut(&Hit) -> bool,
) -> bool {
    !closest_hit_where(tracer, ray, filter, accept).is_miss()
}
