//! A program that measures in the lab's format: so many steps of arithmetic, as often as is said, and then nothing else.
//!
//! `spin STEPS REPEATS`. What `cargo xtask lab` compares: the truth is known, since twice the steps take twice the time.

use eosphor_lab::{MILLISECONDS, Quantity, Stopwatch, Times};
use std::hint::black_box;

fn main() {
    let mut numbers = std::env::args().skip(1).map(|word| word.parse::<u64>().ok());
    let (Some(Some(steps)), Some(Some(repeats))) = (numbers.next(), numbers.next()) else {
        eprintln!("usage: spin STEPS REPEATS");
        std::process::exit(1);
    };
    let mut times = Times::default();
    // Once to warm up.
    for repeat in 0..=repeats {
        let watch = Stopwatch::start();
        black_box(
            (0..steps)
                .fold(1u64, |state, step| black_box((state ^ step).wrapping_mul(0x9e37_79b9_7f4a_7c15))),
        );
        if repeat > 0 {
            watch.stop(&mut times);
        }
    }
    let Times { wall, cpu } = times;
    let quantity = Quantity {
        quantity: "steps".into(),
        unit: MILLISECONDS.into(),
        values: wall,
        cpu,
        answer: Some("the same".into()),
        ..Quantity::default()
    };
    println!("{}", serde_json::to_string(&quantity).expect("it has no keys but texts"));
}
