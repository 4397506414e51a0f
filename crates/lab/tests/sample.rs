//! Runs that were never measured, with all that a report has to show.

use eosphor_lab::statistics::CountedRandom;
use eosphor_lab::{
    Axis, Clock, Experiment, Gpu, Header, Load, MILLISECONDS, Machine, Measure, Measured, Outcome, Program,
    Published, Quantity, Record, Records, Variant,
};

/// A variant, and what its processes would measure.
pub struct Truth {
    pub variant: Variant,
    /// Of the first quantity; further ones are multiples of it.
    pub value: f64,
    pub answer: Option<&'static str>,
    pub failure: Option<&'static str>,
}

pub fn truth(name: &str, value: f64) -> Truth {
    let variant =
        Variant { name: name.into(), arguments: vec!["--accel".into(), name.into()], ..Variant::default() };
    Truth { variant, value, answer: Some("5f0c77e29a1b44d0"), failure: None }
}

impl Truth {
    pub fn at(mut self, series: &str, x: f64) -> Truth {
        self.variant.series = (!series.is_empty()).then(|| series.to_owned());
        self.variant.x = Some(x);
        self
    }
}

/// How a run goes.
pub struct Conditions {
    pub blocks: u32,
    /// The last block ends after so many processes.
    pub cut: usize,
    pub is_quick: bool,
    pub other_cores: f64,
    /// How much longer the base's second process takes.
    pub again: f64,
    pub noise: f64,
    pub quantities: Vec<(String, &'static str, f64)>,
}

impl Default for Conditions {
    fn default() -> Conditions {
        Conditions {
            blocks: 7,
            cut: usize::MAX,
            is_quick: false,
            other_cores: 0.01,
            again: 1.0,
            noise: 0.01,
            quantities: vec![("primary, closest hit".into(), MILLISECONDS, 1.0)],
        }
    }
}

pub fn experiment(name: &str, question: &str, truths: &[Truth], axis: Option<Axis>) -> Experiment {
    Experiment {
        name: name.into(),
        question: question.into(),
        measures: Measure::Rays,
        prepare: Vec::new(),
        held: ["builtin:hare", "--size", "640x480", "--backend", "cpu", "--threads", "1"]
            .map(String::from)
            .into(),
        input: None,
        variants: truths.iter().map(|truth| truth.variant.clone()).collect(),
        base: truths[0].variant.name.clone(),
        cores: Some(1),
        clock: Clock::Wall,
        repeats: Some(5),
        axis,
        quick: None,
        pictures: Vec::new(),
        published: Vec::new(),
    }
}

pub fn machine() -> Machine {
    Machine {
        cpu: Some("AMD EPYC 9B45 128-Core Processor".into()),
        cores: 32,
        allowed_cores: (0..32).collect(),
        smt: Some(true),
        caches: ["L1d 48K", "L1i 32K", "L2 1024K", "L3 32768K"].map(String::from).into(),
        memory_bytes: Some(128 << 30),
        huge_pages: Some("madvise".into()),
        governor: Some("performance".into()),
        system: "linux x86_64 6.8.0-51-generic".into(),
        gpus: Vec::new(),
    }
}

pub fn program() -> Program {
    Program {
        version: "0.1.0".into(),
        commit: Some("319352f4c1".into()),
        compiler: "rustc 1.92.0".into(),
        profile: "release, x86-64 baseline".into(),
        features: vec!["cuda".into(), "view".into()],
        hash: "9e3779b97f4a7c15".into(),
    }
}

/// A run of an experiment, whose processes measure the truth with some noise.
pub fn run(experiment: &Experiment, truths: &[Truth], how: &Conditions) -> Records {
    let mut random = CountedRandom::new(experiment.name.bytes().map(u64::from).sum());
    let mut uniform = move || random.next_bits() as f64 / 2f64.powi(64);
    let mut header = Header::new(experiment, how.is_quick, machine(), 7_052_913, program());
    header.began = 1_764_000_000;
    let mut records = Vec::new();
    for block in 0..how.blocks {
        let drift = 1.0 + 0.03 * uniform();
        let again = truths.iter().take(1).map(|truth| (truth, true));
        let all = truths.iter().map(|truth| (truth, false)).chain(again);
        let most = if block + 1 == how.blocks { how.cut } else { usize::MAX };
        for (truth, again) in all.filter(|(truth, _)| !truth.variant.needs_gpu).take(most) {
            let quantities = how.quantities.iter().map(|(name, unit, factor)| {
                let noise = 1.0 + how.noise * (uniform() + uniform() + uniform() + uniform() - 2.0) * 1.7;
                let value = truth.value * factor * drift * noise * if again { how.again } else { 1.0 };
                let is_time = *unit == MILLISECONDS;
                Quantity {
                    quantity: name.clone(),
                    unit: (*unit).into(),
                    values: vec![value * 0.999, value, value * 1.001],
                    cpu: if is_time { vec![value * 0.98; 3] } else { Vec::new() },
                    work: is_time.then_some(921_600),
                    answer: truth.answer.map(String::from),
                    hits: truth.answer.is_none().then_some(314_159),
                    different: truth.answer.is_none().then_some(12),
                }
            });
            let quantities = quantities.collect();
            let load = Some(Load { other_cores: how.other_cores, elsewhere_cores: 0.4, ..Load::default() });
            let outcome = match truth.failure {
                Some(why) => Outcome::Failed(why.into()),
                None => Outcome::Measured(Measured { quantities, wall_seconds: 1.0, cpu_seconds: 1.0, load }),
            };
            records.push(Record { block, variant: truth.variant.name.clone(), again, outcome });
        }
    }
    Records { header, records }
}

/// All that a report has to show, in seven runs.
pub fn all_cases() -> Vec<Records> {
    let axis = |label: &str, logarithmic| Some(Axis { label: label.into(), logarithmic, slope: logarithmic });
    let published = |what: &str, hardware: &str, value, unit: &str, x, beside: &str| Published {
        source: "Wald et al. 2014, table 2".into(),
        what: what.into(),
        hardware: hardware.into(),
        value,
        unit: unit.into(),
        x,
        beside: Some(beside.into()),
    };
    let mut runs = Vec::new();

    let mut truths =
        vec![truth("bvh", 41.0), truth("bvh8", 14.1), truth("bvh4", 18.0), truth("bvh-again", 41.1)];
    truths.push(Truth { answer: Some("77aa0e19c3d5"), ..truth("grid", 55.0) });
    truths
        .push(Truth { failure: Some("exit status: 2: the scene has no triangles"), ..truth("kd-tree", 1.0) });
    let mut other = Truth { answer: None, ..truth("embree 4.3", 11.8) };
    other.variant.program = Some("./embree-rays".into());
    other.variant.arguments = vec!["hare.obj".into()];
    truths.push(other);
    let mut gpu = truth("gpu", 1.0);
    gpu.variant.needs_gpu = true;
    truths.push(gpu);
    let mut structures =
        experiment("structures", "Which hierarchy finds hits the soonest, on one core?", &truths, None);
    structures.published = vec![
        published("primary, closest hit, hare, BVH8", "Intel Xeon E5-2690", 58.2, "Mrays/s", None, "bvh8"),
        published("a picture with soft shadows", "Intel Xeon E5-2690", 12.0, "frames/s", None, "bvh8"),
    ];
    let quantities = vec![
        ("primary, closest hit".into(), MILLISECONDS, 1.0),
        ("shadow, any hit".into(), MILLISECONDS, 0.6),
        ("memory of the structure".into(), "MiB", 0.2),
    ];
    runs.push(run(&structures, &truths, &Conditions { quantities, ..Conditions::default() }));

    let sizes = [1e3_f64, 4e3, 16e3, 64e3, 256e3, 1e6];
    let mut truths: Vec<Truth> = Vec::new();
    for (series, factor) in [("bvh", 1.0), ("bvh8", 0.36), ("bvh4", 0.5)] {
        for size in sizes {
            let mut one =
                truth(&format!("{series}, {size}"), factor * 2e-4 * size.powf(1.04)).at(series, size);
            one.variant.against = Some(format!("bvh, {size}"));
            truths.push(one);
        }
    }
    let mut triangles = experiment(
        "triangles",
        "How does the time of a build grow with triangles?",
        &truths,
        axis("triangles", true),
    );
    triangles.published = vec![
        published(
            "build of the bunny",
            "Intel Xeon E5-2690 v2, 2 × 10 cores",
            6.1,
            "ms",
            Some(69e3),
            "bvh, 64000",
        ),
        published(
            "build of the dragon",
            "Intel Xeon E5-2690 v2, 2 × 10 cores",
            88.0,
            "ms",
            Some(871e3),
            "bvh, 1000000",
        ),
    ];
    let quantities = vec![("build".into(), MILLISECONDS, 1.0)];
    runs.push(run(&triangles, &truths, &Conditions { quantities, noise: 0.05, ..Conditions::default() }));

    let times = [1.0, 2.0, 4.0, 8.0, 16.0];
    let truths: Vec<Truth> =
        times.map(|x| truth(&x.to_string(), 320.0 / x + 12.0).at("", x)).into_iter().collect();
    let threads = experiment(
        "threads",
        "How much sooner is a picture ready with more threads?",
        &truths,
        axis("threads", false),
    );
    let quantities = vec![("picture".into(), MILLISECONDS, 1.0)];
    runs.push(run(&threads, &truths, &Conditions { quantities, noise: 0.03, ..Conditions::default() }));

    let truths = [truth("1024 rays", 20.0), truth("4096 rays", 20.5), truth("65536 rays", 20.02)];
    let batch = experiment("batch", "Do larger batches of rays help?", &truths, None);
    let noisy = Conditions { blocks: 12, again: 1.05, noise: 0.003, ..Conditions::default() };
    runs.push(run(&batch, &truths, &noisy));

    let truths = [truth("16 samples", 100.0), truth("64 samples", 401.0)];
    let samples = experiment("samples", "Do samples cost the same, however many there are?", &truths, None);
    runs.push(run(&samples, &truths, &Conditions { other_cores: 0.4, ..Conditions::default() }));

    let truths = [truth("320x240", 10.0), truth("640x480", 39.0), truth("1280x960", 160.0)];
    let resolution = experiment("resolution", "Does the time grow as pixels do?", &truths, None);
    runs.push(run(&resolution, &truths, &Conditions { blocks: 4, cut: 2, ..Conditions::default() }));

    let truths = [truth("1 bounce", 10.0), truth("8 bounces", 31.0)];
    let bounces = experiment("bounces", "What do further bounces cost?", &truths, None);
    runs.push(run(&bounces, &truths, &Conditions { blocks: 2, is_quick: true, ..Conditions::default() }));
    runs
}

/// One run on another machine.
pub fn of_another_machine() -> Records {
    let truths = [truth("cpu", 41.0), truth("gpu", 0.9)];
    let devices = experiment("devices", "Which device is the quickest?", &truths, None);
    let mut records = run(&devices, &truths, &Conditions::default());
    let gpu = ["NVIDIA H100 80GB HBM3", "580.159.04", "81559 MiB", "1980 MHz", "700.00 W"].map(String::from);
    let [name, driver, memory, clock, power_limit] = gpu;
    records.header.machine.gpus = vec![Gpu { name, driver, memory, clock, power_limit }];
    records
}
