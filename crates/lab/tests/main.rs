//! Runs of programs, and what is said of runs.

mod claims;
mod runs;

use eosphor_lab::{Experiment, Header, Machine, Measure, Variant};

/// An experiment over these variants; the first one is the base. Each runs a shell with a script that knows which number it is.
fn experiment(names: &[&str], script: &str) -> Experiment {
    let variant = |name: &&str| Variant {
        name: (*name).into(),
        arguments: vec!["-c".into(), script.replace("NAME", name)],
        program: Some("sh".into()),
        against: None,
        needs_gpu: false,
    };
    Experiment {
        name: "test".into(),
        question: "Does it work?".into(),
        measures: Measure::Rays,
        held: Vec::new(),
        variants: names.iter().map(variant).collect(),
        base: names[0].into(),
        cores: Some(1),
        repeats: 1,
    }
}

fn header(experiment: Experiment) -> Header {
    Header::new(experiment, Machine::default(), 7, "0")
}
