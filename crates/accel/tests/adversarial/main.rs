//! Programs without `unsafe` that mean harm: whatever they do, they get an error, a panic with a message or hits, never undefined
//! behaviour. `cargo xtask asan` runs them under AddressSanitizer, and in the release profile with debug assertions.
#![forbid(unsafe_code)]

mod arrays;
mod bits;
mod mixtures;
mod options;
mod structures;

use std::panic::{AssertUnwindSafe, catch_unwind};

/// What a program that must panic says.
fn message_of<R>(program: impl FnOnce() -> R) -> String {
    let Err(panic) = catch_unwind(AssertUnwindSafe(program)) else { panic!("it went through") };
    let text = panic.downcast_ref::<String>().cloned();
    text.or_else(|| panic.downcast_ref::<&str>().map(|s| s.to_string())).expect("a message")
}

/// Simple numbers that look random.
struct Numbers(u64);

impl Numbers {
    fn bits(&mut self) -> u32 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 32) as u32
    }

    /// Between -1 and 1.
    fn unit(&mut self) -> f32 {
        self.bits() as f32 / 2_147_483_648.0 - 1.0
    }

    /// Any float there is: NaN, infinities and denormal numbers too.
    fn any(&mut self) -> f32 {
        f32::from_bits(self.bits())
    }
}
