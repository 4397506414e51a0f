//! Instructions of all cases, counted by Valgrind: `cargo xtask instructions` runs this, and compares.

#![allow(missing_docs, reason = "the macros of the harness make public items")]

use eosphor_benches::{Case, measured, ready, stay_on_this_thread, with_cases};
use gungraun::{
    Callgrind, EntryPoint, LibraryBenchmarkConfig, library_benchmark, library_benchmark_group, main,
};

/// Makes a case on the thread that is counted.
fn alone<C: Case>() -> C {
    stay_on_this_thread();
    ready()
}

/// Only what is done within a tile's function is counted: it runs on a thread of the renderer's, and threads that wait
/// for others take some instructions more or less each time. It counts every run, so there is but one.
fn tiles() -> LibraryBenchmarkConfig {
    let mut callgrind = callgrind();
    callgrind.entry_point(EntryPoint::Custom("*dispatch*render_tile_avx2*".into()));
    with(callgrind)
}

/// Instructions alone: what caches would do takes twice as long to find out.
fn callgrind() -> Callgrind {
    Callgrind::with_args(["--cache-sim=no"])
}

fn with(callgrind: Callgrind) -> LibraryBenchmarkConfig {
    let mut config = LibraryBenchmarkConfig::default();
    config.tool(callgrind);
    config
}

macro_rules! count {
    ({ $($name:ident: $case:ident,)* } { $($picture:ident: $of:ident,)* }) => {
        $(
            #[library_benchmark]
            #[bench::on_this_thread(setup = alone::<eosphor_benches::$case>)]
            fn $name(case: eosphor_benches::$case) -> (usize, eosphor_benches::$case) {
                // What it was made of is dropped later, uncounted.
                (measured(&case), case)
            }
        )*
        $(
            #[library_benchmark(config = tiles())]
            #[bench::tiles(setup = <eosphor_benches::$of as Case>::new)]
            fn $picture(case: eosphor_benches::$of) -> (usize, eosphor_benches::$of) {
                (measured(&case), case)
            }
        )*
        library_benchmark_group!(name = cases, benchmarks = [$($name,)* $($picture),*]);
    };
}

with_cases!(count);

main!(config = with(callgrind()); library_benchmark_groups = cases);
