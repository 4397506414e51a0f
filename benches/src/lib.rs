//! What is measured, for two ways to do so: `benches/instructions.rs` counts instructions, which CI compares with
//! `instructions.json` (`cargo xtask instructions`); `benches/times.rs` takes times (`cargo bench -p eosphor-benches --bench
//! times`).
//!
//! Everything is made by arithmetic that is the same everywhere, and runs on one thread at one SIMD level, whatever the
//! CPU.

mod ball;
mod builds;
mod pictures;
mod rays;
mod scenes;

pub use builds::{BuildBinned, BuildEight, BuildMorton};
pub use pictures::{PictureBatched, PictureScalar};
pub use rays::{EightCamera, EightScattered, EightSingle, TwoSingle};
pub use scenes::{Flatten, ReadObj, ReadPly};

use eosphor_accel::SimdLevel;

/// The level that all is measured at: the highest one that Valgrind knows.
pub const LEVEL: SimdLevel = SimdLevel::Avx2;

/// Something to measure.
pub trait Case {
    /// What [`Case::run`] finds at the least: where it finds less, it no longer measures what it is there for.
    const AT_LEAST: usize;

    /// Makes all that is needed, unmeasured.
    fn new() -> Self;

    /// What is measured. It can be run again, and says how much it found or made.
    fn run(&self) -> usize;
}

/// A case that is ready to be measured: it has been run once, so that memory and what is looked up once are there.
pub fn ready<C: Case>() -> C {
    let case = C::new();
    measured(&case);
    case
}

/// Runs a case.
///
/// # Panics
/// Where it finds too little.
pub fn measured<C: Case>(case: &C) -> usize {
    let (found, least) = (case.run(), C::AT_LEAST);
    assert!(found >= least, "it finds {found}, and should find {least} at the least");
    found
}

/// Lets this thread be the only one of rayon's pool, so that all work is done, and counted, by it.
///
/// # Panics
/// Where rayon has threads already.
pub fn stay_on_this_thread() {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).use_current_thread();
    pool.build_global().expect("rayon has no threads yet");
}

/// Calls a macro with all cases, by name: first those that stay on their thread, then those that render on threads of
/// their own.
#[macro_export]
macro_rules! with_cases {
    ($measure:ident) => {
        $measure! {
            {
                bvh8_camera_rays: EightCamera,
                bvh8_scattered_rays: EightScattered,
                bvh8_single_rays: EightSingle,
                bvh_single_rays: TwoSingle,
                build_bvh_binned: BuildBinned,
                build_bvh_morton: BuildMorton,
                build_bvh8: BuildEight,
                flatten: Flatten,
                read_obj: ReadObj,
                read_ply: ReadPly,
            }
            {
                picture_batched_bvh8: PictureBatched,
                picture_scalar_bvh: PictureScalar,
            }
        }
    };
}
