//! The experiments that come with the program.

use crate::experiment::{Experiment, Measure, Variant};

/// All of them.
pub fn builtin_experiments() -> Vec<Experiment> {
    vec![structures(), builders(), threads(), resolution(), samples()]
}

fn strings(words: &[&str]) -> Vec<String> {
    words.iter().map(|&word| word.to_owned()).collect()
}

fn variant(name: &str, arguments: &[&str]) -> Variant {
    let (name, arguments) = (name.into(), strings(arguments));
    Variant { name, arguments, program: None, against: None, needs_gpu: false }
}

fn structures() -> Experiment {
    let on_cpu = |accel: &str| variant(accel, &["--accel", accel]);
    Experiment {
        name: "structures".into(),
        question: "Which hierarchy finds hits the soonest, on one core?".into(),
        measures: Measure::Rays,
        held: strings(&["builtin:hare", "--size", "320x240", "--backend", "cpu", "--threads", "1"]),
        variants: ["bvh8", "bvh", "kdtree", "grid", "octree", "octree-parametric"].map(on_cpu).into(),
        base: "bvh".into(),
        cores: Some(1),
        repeats: 5,
    }
}

fn builders() -> Experiment {
    let built_by = |builder: &str| variant(builder, &["--builder", builder]);
    Experiment {
        name: "builders".into(),
        question: "How good is the bvh of each builder for rays, on one core?".into(),
        measures: Measure::Rays,
        held: strings(&[
            "builtin:hare",
            "--size",
            "320x240",
            "--backend",
            "cpu",
            "--threads",
            "1",
            "--accel",
            "bvh",
        ]),
        variants: ["binned", "sweep", "spatial", "hybrid", "median", "morton"].map(built_by).into(),
        base: "binned".into(),
        cores: Some(1),
        repeats: 5,
    }
}

fn threads() -> Experiment {
    let with = |threads: &str| variant(threads, &["--threads", threads]);
    Experiment {
        name: "threads".into(),
        question: "How much do more threads help?".into(),
        measures: Measure::Picture,
        held: strings(&["builtin:cornell", "--size", "320x256", "--samples", "2", "--backend", "cpu"]),
        variants: ["1", "2", "4", "8"].map(with).into(),
        base: "1".into(),
        cores: None,
        repeats: 5,
    }
}

fn resolution() -> Experiment {
    let sizes = ["1280x720", "1920x1080", "2560x1440", "3840x2160"];
    let both = |size: &&str| {
        let on = |device: &str, backend: &str| {
            variant(&format!("{size} {device}"), &["--size", size, "--backend", backend])
        };
        let cpu = on("CPU", "cpu");
        let gpu = Variant { needs_gpu: true, against: Some(cpu.name.clone()), ..on("GPU", "cuda") };
        [cpu, gpu]
    };
    Experiment {
        name: "resolution".into(),
        question: "How do CPU and GPU compare as pictures grow? (EOS)".into(),
        measures: Measure::Picture,
        held: strings(&["builtin:hare", "--preset", "eos"]),
        variants: sizes.iter().flat_map(both).collect(),
        base: "1280x720 CPU".into(),
        cores: None,
        repeats: 3,
    }
}

fn samples() -> Experiment {
    let with = |samples: &str| variant(samples, &["--samples", samples]);
    Experiment {
        name: "samples".into(),
        question: "What do more samples of a pixel take?".into(),
        measures: Measure::Picture,
        held: strings(&["builtin:cornell", "--size", "160x128", "--backend", "cpu"]),
        variants: ["1", "4", "16", "64"].map(with).into(),
        base: "1".into(),
        cores: None,
        repeats: 3,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn they_are_sound_and_have_names_of_their_own() {
        let all = builtin_experiments();
        for (number, experiment) in all.iter().enumerate() {
            assert_eq!(experiment.check(), Ok(()));
            assert!(all[..number].iter().all(|other| other.name != experiment.name));
            let text = serde_json::to_string(experiment).unwrap();
            assert_eq!(&serde_json::from_str::<Experiment>(&text).unwrap(), experiment);
        }
    }
}
