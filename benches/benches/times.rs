//! Times of all cases, on one thread: `cargo bench -p eosphor-benches --bench times [NAME]`.

use eosphor_benches::{measured, ready, stay_on_this_thread, with_cases};

macro_rules! time {
    ($({ $($name:ident: $case:ident,)* })*) => {
        $($(
            #[divan::bench]
            fn $name(bencher: divan::Bencher) {
                let case = ready::<eosphor_benches::$case>();
                bencher.bench_local(|| measured(&case));
            }
        )*)*
    };
}

with_cases!(time);

fn main() {
    stay_on_this_thread();
    divan::main();
}
