//! Tracers behind one type, so that schedulers are compiled once for each instruction set, and not for each structure too.
//!
//! A query costs one call through a pointer: nothing to a batch or a packet.

use super::{SimdLevel, Watch, Watched};
use eosphor_accel::{BatchTracer, Coherence, Filters, Hierarchy, OneByOne, UseBatchTracer, UseTracer};
use eosphor_core::hierarchy::{ShadowBatch, Tracer};
use eosphor_core::ray::{Hit, Ray, RayFilter};

/// [`BatchTracer`] for any structure and instruction set.
pub(crate) trait Queries {
    fn closest_hits(&self, rays: &[Ray], filters: Filters, coherence: Coherence, hits: &mut [Hit]);
    fn occluded_rays(&self, rays: &[Ray], filters: Filters, coherence: Coherence, hidden: &mut [bool]);
    fn next_hits(&self, rays: &[Ray], filters: Filters, coherence: Coherence, hits: &mut [Hit]);
    fn occluded_16(&self, batch: &ShadowBatch<16>, filter: &RayFilter, active: &[bool; 16]) -> [bool; 16];
    fn occluded_4(&self, batch: &ShadowBatch<4>, filter: &RayFilter, active: &[bool; 4]) -> [bool; 4];
    fn occluded_48(&self, batch: &ShadowBatch<48>, filter: &RayFilter, active: &[bool; 48]) -> [bool; 48];
}

/// Calls `ask` with a tracer that is compiled for a level that the CPU has.
pub(crate) fn with_level<T: BatchTracer, R>(
    tracer: &T,
    simd: SimdLevel,
    ask: impl FnOnce(&dyn Queries) -> R,
) -> R {
    match simd {
        #[cfg(target_arch = "x86_64")]
        SimdLevel::Avx512 => ask(&Avx512(tracer)),
        #[cfg(target_arch = "x86_64")]
        SimdLevel::Avx2 => ask(&Avx2(tracer)),
        _ => ask(&Baseline(tracer)),
    }
}

/// Calls `ask` with a hierarchy's fast tracer. `top` has the instances: itself, or one that was built over instances alone.
pub(crate) fn with_batches<R>(
    hierarchy: &Hierarchy,
    top: &Hierarchy,
    simd: SimdLevel,
    ask: impl FnOnce(&dyn Queries) -> R,
) -> R {
    struct Ask<F>(SimdLevel, F);
    impl<R, F: FnOnce(&dyn Queries) -> R> UseBatchTracer for Ask<F> {
        type Output = R;
        fn run<T: BatchTracer>(self, tracer: &T) -> R {
            with_level(tracer, self.0, self.1)
        }
    }
    hierarchy.with_batch_tracer(top, simd, Ask(simd, ask))
}

/// Calls `ask` with a tracer that takes rays one by one, and is watched; `top` as in [`with_batches`].
pub(crate) fn with_counting<R>(
    hierarchy: &Hierarchy,
    top: &Hierarchy,
    watch: &Watch,
    simd: SimdLevel,
    ask: impl FnOnce(&dyn Queries) -> R,
) -> R {
    struct Ask<'a, F>(&'a Watch, SimdLevel, F);
    impl<R, F: FnOnce(&dyn Queries) -> R> UseTracer for Ask<'_, F> {
        type Output = R;
        fn run<T: Tracer>(self, tracer: T) -> R {
            let tracer = OneByOne(Watched { tracer, watch: self.0 });
            // One ray at a time gains nothing from AVX-512, and this code is large: it is compiled for two levels only.
            match self.1 {
                #[cfg(target_arch = "x86_64")]
                SimdLevel::Avx2 | SimdLevel::Avx512 => (self.2)(&Avx2(&tracer)),
                _ => (self.2)(&Baseline(&tracer)),
            }
        }
    }
    hierarchy.with_counting_tracer(top, watch, Ask(watch, simd, ask))
}

/// A tracer whose queries run in functions of this name and with these features. `cargo xtask fma` looks for the names.
macro_rules! at_level {
    ($level:ident, $query:ident $(, $features:meta)?) => {
        struct $level<'a, T>(&'a T);

        impl<T: BatchTracer> Queries for $level<'_, T> {
            fn closest_hits(&self, rays: &[Ray], filters: Filters, how: Coherence, hits: &mut [Hit]) {
                $(#[$features])?
                unsafe fn $query<T: BatchTracer>(t: &T, r: &[Ray], f: Filters, c: Coherence, h: &mut [Hit]) {
                    t.closest_hits(r, f, c, h);
                }
                // SAFETY: the CPU has the features of `$query`: `with_level` makes a `$level` only for a level that
                // `CpuBackend::new` has found available.
                unsafe { $query(self.0, rays, filters, how, hits) }
            }

            fn occluded_rays(&self, rays: &[Ray], filters: Filters, how: Coherence, hidden: &mut [bool]) {
                $(#[$features])?
                unsafe fn $query<T: BatchTracer>(t: &T, r: &[Ray], f: Filters, c: Coherence, h: &mut [bool]) {
                    t.occluded_rays(r, f, c, h);
                }
                // SAFETY: the CPU has the features of `$query`: `with_level` makes a `$level` only for a level that
                // `CpuBackend::new` has found available.
                unsafe { $query(self.0, rays, filters, how, hidden) }
            }

            fn next_hits(&self, rays: &[Ray], filters: Filters, how: Coherence, hits: &mut [Hit]) {
                $(#[$features])?
                unsafe fn $query<T: BatchTracer>(t: &T, r: &[Ray], f: Filters, c: Coherence, h: &mut [Hit]) {
                    t.next_hits(r, f, c, h);
                }
                // SAFETY: the CPU has the features of `$query`: `with_level` makes a `$level` only for a level that
                // `CpuBackend::new` has found available.
                unsafe { $query(self.0, rays, filters, how, hits) }
            }

            fn occluded_16(&self, batch: &ShadowBatch<16>, filter: &RayFilter, active: &[bool; 16]) -> [bool; 16] {
                $(#[$features])?
                unsafe fn $query<T: Tracer>(t: &T, b: &ShadowBatch<16>, f: &RayFilter, a: &[bool; 16]) -> [bool; 16] {
                    t.occluded_batch(b, f, a)
                }
                // SAFETY: the CPU has the features of `$query`: `with_level` makes a `$level` only for a level that
                // `CpuBackend::new` has found available.
                unsafe { $query(self.0, batch, filter, active) }
            }

            fn occluded_48(&self, batch: &ShadowBatch<48>, filter: &RayFilter, active: &[bool; 48]) -> [bool; 48] {
                $(#[$features])?
                unsafe fn $query<T: Tracer>(t: &T, b: &ShadowBatch<48>, f: &RayFilter, a: &[bool; 48]) -> [bool; 48] {
                    t.occluded_batch(b, f, a)
                }
                // SAFETY: the CPU has the features of `$query`: `with_level` makes a `$level` only for a level that
                // `CpuBackend::new` has found available.
                unsafe { $query(self.0, batch, filter, active) }
            }

            fn occluded_4(&self, batch: &ShadowBatch<4>, filter: &RayFilter, active: &[bool; 4]) -> [bool; 4] {
                $(#[$features])?
                unsafe fn $query<T: Tracer>(t: &T, b: &ShadowBatch<4>, f: &RayFilter, a: &[bool; 4]) -> [bool; 4] {
                    t.occluded_batch(b, f, a)
                }
                // SAFETY: the CPU has the features of `$query`: `with_level` makes a `$level` only for a level that
                // `CpuBackend::new` has found available.
                unsafe { $query(self.0, batch, filter, active) }
            }
        }
    };
}

at_level!(Baseline, query_baseline);
#[cfg(target_arch = "x86_64")]
at_level!(Avx2, query_avx2, target_feature(enable = "avx2,fma,bmi1,bmi2,popcnt,lzcnt"));
#[cfg(target_arch = "x86_64")]
at_level!(
    Avx512,
    query_avx512,
    target_feature(enable = "avx512f,avx512bw,avx512dq,avx512vl,avx2,fma,bmi1,bmi2,popcnt,lzcnt")
);

/// Any tracer.
#[derive(Clone, Copy)]
pub(crate) struct AnyTracer<'a>(pub(crate) &'a dyn Queries);

impl Tracer for AnyTracer<'_> {
    #[inline(always)]
    fn closest_hit(&self, ray: &Ray, filter: &RayFilter) -> Hit {
        let mut hit = [Hit::miss(ray.t_max)];
        self.0.closest_hits(std::slice::from_ref(ray), Filters::Shared(filter), Coherence::Auto, &mut hit);
        hit[0]
    }

    #[inline(always)]
    fn occluded(&self, ray: &Ray, filter: &RayFilter) -> bool {
        let mut hidden = [false];
        self.0.occluded_rays(
            std::slice::from_ref(ray),
            Filters::Shared(filter),
            Coherence::Auto,
            &mut hidden,
        );
        hidden[0]
    }

    #[inline(always)]
    fn next_hit(&self, ray: &Ray, filter: &RayFilter, after: &Hit) -> Hit {
        let mut hit = [*after];
        self.0.next_hits(std::slice::from_ref(ray), Filters::Shared(filter), Coherence::Auto, &mut hit);
        hit[0]
    }

    #[inline(always)]
    fn occluded_batch<const W: usize>(
        &self,
        batch: &ShadowBatch<W>,
        filter: &RayFilter,
        active: &[bool; W],
    ) -> [bool; W] {
        match W {
            16 => resized(&self.0.occluded_16(&batch_of(batch), filter, &resized(active))),
            48 => resized(&self.0.occluded_48(&batch_of(batch), filter, &resized(active))),
            4 => resized(&self.0.occluded_4(&batch_of(batch), filter, &resized(active))),
            _ => {
                let mut hidden = [true; W];
                for lane in 0..W {
                    if active[lane] {
                        hidden[lane] = self.occluded(&batch.ray(lane), filter);
                    }
                }
                hidden
            }
        }
    }
}

/// The same array, once its length is known.
#[inline(always)]
fn resized<E: Copy + Default, const A: usize, const B: usize>(items: &[E; A]) -> [E; B] {
    let mut same = [E::default(); B];
    same.copy_from_slice(items);
    same
}

#[inline(always)]
fn batch_of<const A: usize, const B: usize>(batch: &ShadowBatch<A>) -> ShadowBatch<B> {
    ShadowBatch {
        origin: batch.origin,
        x: resized(&batch.x),
        y: resized(&batch.y),
        z: resized(&batch.z),
        t_max: resized(&batch.t_max),
    }
}

impl BatchTracer for AnyTracer<'_> {
    #[inline(always)]
    fn closest_hits(&self, rays: &[Ray], filters: Filters, coherence: Coherence, hits: &mut [Hit]) {
        self.0.closest_hits(rays, filters, coherence, hits);
    }

    #[inline(always)]
    fn occluded_rays(&self, rays: &[Ray], filters: Filters, coherence: Coherence, hidden: &mut [bool]) {
        self.0.occluded_rays(rays, filters, coherence, hidden);
    }

    #[inline(always)]
    fn next_hits(&self, rays: &[Ray], filters: Filters, coherence: Coherence, hits: &mut [Hit]) {
        self.0.next_hits(rays, filters, coherence, hits);
    }
}
