//! Runs of programs, and what is said of runs.

mod claims;
mod report;
mod runs;
mod sample;

use eosphor_lab::{Clock, Experiment, Header, Machine, Measure, Program, Variant};

/// An experiment over these variants; the first one is the base. Each runs a shell with a script that knows which number it is.
fn experiment(names: &[&str], script: &str) -> Experiment {
    let variant = |name: &&str| Variant {
        name: (*name).into(),
        arguments: vec!["-c".into(), script.replace("NAME", name)],
        program: Some("sh".into()),
        ..Variant::default()
    };
    Experiment {
        name: "test".into(),
        question: "Does it work?".into(),
        measures: Measure::Rays,
        prepare: Vec::new(),
        held: Vec::new(),
        input: None,
        variants: names.iter().map(variant).collect(),
        base: names[0].into(),
        cores: Some(1),
        clock: Clock::Wall,
        repeats: Some(1),
        axis: None,
        quick: None,
        pictures: Vec::new(),
        published: Vec::new(),
    }
}

fn header(experiment: Experiment) -> Header {
    Header::new(&experiment, false, Machine::default(), 7, Program::default())
}
