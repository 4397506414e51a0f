//! The filtered queries of an 8-wide hierarchy: by a mask for each instance, and by a closure.

use super::filtered::{Asked, Filtered, InstanceMasks};
use super::found::{ANY, CLOSEST, Found, NEXT, Query};
use super::{Bvh8Tracer, run_at};
use eosphor_core::hierarchy::Tracer;
use eosphor_core::ray::{Hit, Ray, RayFilter};

/// Traces single rays through a [`crate::Bvh8`], and sees only instances whose mask has a bit in common with its own. What it
/// does not see is not there: its hits are those of a scene without it, bit for bit. Made by [`Bvh8Tracer::with_masks`].
///
/// Instances that are hidden are left out before anything in them is looked at. For what is seen a ray takes 1.2 to 1.8 times
/// as long as with a [`Bvh8Tracer`].
#[derive(Clone, Copy, Debug)]
pub struct MaskedTracer<'a> {
    tracer: Bvh8Tracer<'a>,
    instances: InstanceMasks<'a>,
}

impl<'a> Bvh8Tracer<'a> {
    /// A tracer that sees only instances with `masks[instance] & mask != 0`. The world, which is instance 0, has a mask, too.
    /// [`crate::Scene::masks`] are the masks of a scene.
    ///
    /// ```
    /// use eosphor_accel::{Affine, BuildOptions, Bvh8, Ray, RayFilter, Scene, Tracer, vec3};
    ///
    /// const GLASS: u32 = 0b01;
    /// const WALLS: u32 = 0b10;
    ///
    /// let triangle = [vec3(-1.0, -1.0, 0.0), vec3(1.0, -1.0, 0.0), vec3(0.0, 1.0, 0.0)];
    /// let mut scene = Scene::new(&[triangle], &[])?;
    /// let mesh = scene.mesh(&[triangle], &[])?;
    /// let pane = scene.place(mesh, Affine { translation: vec3(0.0, 0.0, 1.0), ..Affine::IDENTITY })?;
    /// scene.set_mask(0, WALLS)?;
    /// scene.set_mask(pane, GLASS)?;
    ///
    /// let bvh = Bvh8::build(&scene.geometry(), &BuildOptions::default());
    /// let ray = Ray::new(vec3(0.0, 0.0, 5.0), vec3(0.0, 0.0, -1.0));
    /// let t = |mask| bvh.tracer().with_masks(scene.masks(), mask).closest_hit(&ray, &RayFilter::ALL).t;
    /// assert_eq!([t(WALLS | GLASS), t(WALLS)], [4.0, 5.0]);
    /// # Ok::<(), eosphor_accel::SceneError>(())
    /// ```
    ///
    /// # Panics
    /// Where there are not as many masks as instances.
    pub fn with_masks(self, masks: &'a [u32], mask: u32) -> MaskedTracer<'a> {
        let instances = self.bvh.instances.len();
        assert_eq!(masks.len(), instances, "{} masks for {instances} instances", masks.len());
        MaskedTracer { tracer: self, instances: InstanceMasks { masks: Some(masks), mask } }
    }

    /// The closest hit among those that `accept` says yes to; a miss if there is none. It is exact: the hit, bit for bit, that
    /// remains when all hits of the ray are found and those that `accept` refuses are taken away.
    ///
    /// `accept` is asked about candidates in any order, not about all of them, and perhaps more than once about one, so its
    /// answer should follow from the hit alone. Of each it is told all that [`Tracer::closest_hit`] would say. It may be asked
    /// about hits that lie behind the answer. Where the closure accepts everything, a ray takes 1.2 to 1.8 times as long as
    /// without one, plus the time of `accept`; longer where many hits are refused.
    pub fn closest_hit_where(&self, ray: &Ray, filter: &RayFilter, accept: impl FnMut(&Hit) -> bool) -> Hit {
        self.seen().closest_hit_where(ray, filter, accept)
    }

    /// Whether there is any hit that `accept` says yes to. `accept` is asked as by [`Bvh8Tracer::closest_hit_where`], until it
    /// has said yes.
    pub fn occluded_where(&self, ray: &Ray, filter: &RayFilter, accept: impl FnMut(&Hit) -> bool) -> bool {
        self.seen().occluded_where(ray, filter, accept)
    }

    /// A tracer for which every instance is there.
    fn seen(self) -> MaskedTracer<'a> {
        MaskedTracer { tracer: self, instances: InstanceMasks::ALL }
    }
}

impl MaskedTracer<'_> {
    /// The closest hit, in an instance that is seen, among those that `accept` says yes to; a miss if there is none. `accept` is
    /// asked as by [`Bvh8Tracer::closest_hit_where`].
    pub fn closest_hit_where(
        &self,
        ray: &Ray,
        filter: &RayFilter,
        mut accept: impl FnMut(&Hit) -> bool,
    ) -> Hit {
        let mut found = Found::nothing(ray.t_max);
        self.one::<CLOSEST>(ray, filter, &mut accept, &mut found);
        found.best
    }

    /// Whether there is any hit, in an instance that is seen, that `accept` says yes to. `accept` is asked as by
    /// [`Bvh8Tracer::closest_hit_where`], until it has said yes.
    pub fn occluded_where(
        &self,
        ray: &Ray,
        filter: &RayFilter,
        mut accept: impl FnMut(&Hit) -> bool,
    ) -> bool {
        let mut found = Found::nothing(ray.t_max);
        self.one::<ANY>(ray, filter, &mut accept, &mut found);
        found.any
    }

    fn one<const QUERY: Query>(
        &self,
        ray: &Ray,
        filter: &RayFilter,
        accept: &mut dyn FnMut(&Hit) -> bool,
        found: &mut Found,
    ) {
        let asked = Asked { bvh: &self.tracer.bvh, ray, filter, instances: self.instances };
        // SAFETY: instruction set: tracers are made for levels that the CPU has. Closed view: `Bvh8` keeps its fields private.
        unsafe { run_at(self.tracer.level, Filtered::<QUERY> { asked, accept, found }) };
    }
}

impl Tracer for MaskedTracer<'_> {
    fn closest_hit(&self, ray: &Ray, filter: &RayFilter) -> Hit {
        self.closest_hit_where(ray, filter, |_| true)
    }

    fn occluded(&self, ray: &Ray, filter: &RayFilter) -> bool {
        self.occluded_where(ray, filter, |_| true)
    }

    fn next_hit(&self, ray: &Ray, filter: &RayFilter, after: &Hit) -> Hit {
        let mut found = Found { after: Some(*after), ..Found::nothing(ray.t_max) };
        self.one::<NEXT>(ray, filter, &mut |_| true, &mut found);
        found.best
    }
}
