//! What an experiment is: what varies, what is held, what is measured.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// An experiment about speed, for `eosphor lab run`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub struct Experiment {
    /// Its name on command lines and of files: letters, digits and hyphens.
    pub name: String,
    /// What it asks, in a line.
    pub question: String,
    /// What is measured.
    pub measures: Measure,
    /// A command of Eosphor that is run once before all processes, to make what they read. Its `{data}`, and that of `held` and
    /// `arguments`, is a folder for that.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub prepare: Vec<String>,
    /// Arguments that all variants have: the scene, its size and so on. `{block}` is the number of the block, from 0.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub held: Vec<String>,
    /// What processes read from standard input.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub input: Option<String>,
    /// What is compared.
    pub variants: Vec<Variant>,
    /// The variant that the others are compared with. It runs twice in each block: how far it is from itself is the noise.
    pub base: String,
    /// Cores that a process may use; where not given, all.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub cores: Option<usize>,
    /// Which time is compared.
    #[serde(default, skip_serializing_if = "Clock::is_wall")]
    pub clock: Clock,
    /// Repetitions within a process, after one to warm up; where not given, 5. A process that is timed as a whole has none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub repeats: Option<u32>,
    /// What the numbers `x` of the variants are; where given, the report draws a curve.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub axis: Option<Axis>,
    /// How a quick run differs.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub quick: Option<Quick>,
    /// Pictures for the report.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub pictures: Vec<Shown>,
    /// What others have published of the same.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub published: Vec<Published>,
}

/// Repetitions within a process where an experiment does not say.
const DEFAULT_REPEATS: u32 = 5;

/// What a process measures.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Measure {
    /// The time of a picture: `eosphor bench render`.
    Picture,
    /// The time of queries about sets of rays: `eosphor bench rays`.
    Rays,
    /// The noise of a picture: `eosphor bench noise`.
    Noise,
    /// A whole process of `eosphor`, from its start to its end. What it writes into the folder `{out}` is its answer.
    Process,
}

/// Which time is compared.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Clock {
    /// That of a clock on the wall.
    #[default]
    Wall,
    /// The time that the process took of cores, summed over them.
    Cpu,
}

impl Clock {
    fn is_wall(&self) -> bool {
        *self == Clock::Wall
    }
}

/// One of what is compared.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub struct Variant {
    /// Its name in tables.
    pub name: String,
    /// Its arguments, after those that are held.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub arguments: Vec<String>,
    /// Another program that measures the same work. It gets `arguments` alone, and prints lines of the lab's format.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub program: Option<String>,
    /// Words that start the program, as in `["mpirun", "-n", "2"]`.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub launcher: Vec<String>,
    /// The variant that it is compared with; where not given, the base.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub against: Option<String>,
    /// It needs an NVIDIA GPU; where there is none it is left out, and the report says so.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub needs_gpu: bool,
    /// Quick runs leave it out.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub slow: bool,
    /// Where it stands on the axis.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub x: Option<f64>,
    /// The curve that it is a point of.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub series: Option<String>,
}

/// The axis that variants stand on.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub struct Axis {
    /// What it counts.
    pub label: String,
    /// Equal factors are equally far.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub logarithmic: bool,
    /// Say by which power of it each curve grows.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub slope: bool,
}

/// How a quick run of an experiment differs.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub struct Quick {
    /// What is held instead.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub held: Option<Vec<String>>,
    /// What processes read from standard input instead.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub input: Option<String>,
    /// Repetitions within a process.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub repeats: Option<u32>,
}

/// A picture for the report, or two that are looked at by turns.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub struct Shown {
    /// What it shows.
    pub title: String,
    /// What there is to see: which one is A and which one B.
    pub caption: String,
    /// Arguments of `eosphor render` for A, without an output.
    pub a: Vec<String>,
    /// And for B, where there is one.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub b: Vec<String>,
}

/// A figure that others have published.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub struct Published {
    /// Who published it.
    pub source: String,
    /// What it is a figure of.
    pub what: String,
    /// On which hardware.
    pub hardware: String,
    /// The figure.
    pub value: f64,
    /// Its unit; of a ratio `times as fast` or `times as long`.
    pub unit: String,
    /// Where it stands on the axis.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub x: Option<f64>,
    /// Our variant that it stands beside.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub beside: Option<String>,
}

/// What is wrong with an experiment.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("experiment \"{experiment}\": {problem}")]
pub struct InvalidExperiment {
    experiment: String,
    problem: String,
}

/// The most variants of an experiment, and repetitions within a process.
const MAX_VARIANTS: usize = 100;
const MAX_REPEATS: u32 = 1000;
/// The most bytes of standard input: what a pipe holds without a reader.
const MAX_INPUT: usize = 4096;
/// The most pictures of an experiment.
const MAX_PICTURES: usize = 20;

impl Experiment {
    /// Checks what a file says.
    ///
    /// # Errors
    ///
    /// The first thing that is wrong.
    pub fn check(&self) -> Result<(), InvalidExperiment> {
        let wrong = |problem: String| {
            Err(InvalidExperiment { experiment: self.name.chars().take(60).collect(), problem })
        };
        let is_name = |name: &str| {
            let is_plain = |c: char| c.is_ascii_alphanumeric() || c == '-';
            !name.is_empty() && name.len() <= 60 && name.chars().all(is_plain)
        };
        if !is_name(&self.name) {
            return wrong("its name must have 1 to 60 letters, digits and hyphens".into());
        }
        if !(1..=MAX_VARIANTS).contains(&self.variants.len()) {
            return wrong(format!("it must have 1 to {MAX_VARIANTS} variants"));
        }
        let repeats = self.quick.as_ref().and_then(|quick| quick.repeats);
        if [self.repeats, repeats].into_iter().flatten().any(|n| !(1..=MAX_REPEATS).contains(&n)) {
            return wrong(format!("\"repeats\" must be 1 to {MAX_REPEATS}"));
        }
        let inputs = [self.input.as_ref(), self.quick.as_ref().and_then(|quick| quick.input.as_ref())];
        if inputs.into_iter().flatten().any(|input| input.len() > MAX_INPUT) {
            return wrong(format!("\"input\" must have at most {MAX_INPUT} bytes"));
        }
        if self.cores == Some(0) {
            return wrong("\"cores\" must be at least 1".into());
        }
        for (number, variant) in self.variants.iter().enumerate() {
            let is_taken = self.variants[..number].iter().any(|other| other.name == variant.name);
            if variant.name.is_empty() || variant.name.len() > 60 || is_taken {
                return wrong(format!(
                    "variant {} must have a name of its own, of 1 to 60 bytes",
                    number + 1
                ));
            }
            if variant.x.is_some_and(|x| !(x.is_finite() && x > 0.0)) {
                return wrong(format!("\"x\" of variant {} must be above 0", number + 1));
            }
            if self.axis.is_some() != variant.x.is_some() {
                return wrong("either all variants have an \"x\", and there is an \"axis\", or none".into());
            }
        }
        let names = self.variants.iter().filter_map(|variant| variant.against.as_ref());
        let names = names.chain(self.published.iter().filter_map(|figure| figure.beside.as_ref()));
        for name in names.chain([&self.base]) {
            if self.variant(name).is_none() {
                return wrong(format!("\"{name}\", which others are compared with, is none of its variants"));
            }
        }
        if self.pictures.len() > MAX_PICTURES {
            return wrong(format!("it may have at most {MAX_PICTURES} pictures"));
        }
        if self.published.iter().any(|figure| !figure.value.is_finite()) {
            return wrong("a published figure must be a number".into());
        }
        Ok(())
    }

    /// Checks that an experiment says nothing that would change nothing. (Runs of earlier versions may.)
    ///
    /// # Errors
    ///
    /// What it says in vain.
    pub fn check_use(&self) -> Result<(), InvalidExperiment> {
        let repeats = self.repeats.or(self.quick.as_ref().and_then(|quick| quick.repeats));
        let is_held = !self.held.is_empty() || self.quick.as_ref().is_some_and(|quick| quick.held.is_some());
        let problem = if self.measures == Measure::Process && repeats.is_some() {
            "a process that is timed as a whole does its work once: leave out \"repeats\""
        } else if self.measures == Measure::Noise && self.clock == Clock::Cpu {
            "noise is not a time: leave out \"clock\""
        } else if is_held && self.variants.iter().all(|variant| variant.program.is_some()) {
            "no variant is Eosphor, which \"held\" is for: leave it out"
        } else {
            return Ok(());
        };
        Err(InvalidExperiment { experiment: self.name.clone(), problem: problem.into() })
    }

    /// What a quick run runs: with less held, fewer repetitions, and without variants that are slow.
    pub fn quickly(&self) -> Experiment {
        let mut quick = self.clone();
        if let Some(Quick { held, input, repeats }) = quick.quick.take() {
            quick.held = held.unwrap_or(quick.held);
            quick.input = input.or(quick.input);
            quick.repeats = repeats.or(quick.repeats);
        }
        let is_kept = |name: &String| !self.variant(name).is_some_and(|number| self.variants[number].slow);
        quick.variants.retain(|variant| is_kept(&variant.name) || variant.name == self.base);
        quick
            .variants
            .iter_mut()
            .for_each(|variant| variant.against = variant.against.take().filter(&is_kept));
        quick.published.iter_mut().for_each(|figure| figure.beside = figure.beside.take().filter(&is_kept));
        quick
    }

    /// Repetitions within a process that is not timed as a whole.
    pub fn repetitions(&self) -> u32 {
        self.repeats.unwrap_or(DEFAULT_REPEATS)
    }

    /// The name of the variant that this one is compared with; `None`: it is the base itself.
    pub fn against<'a>(&'a self, variant: &'a Variant) -> Option<&'a str> {
        let against = variant.against.as_deref().unwrap_or(&self.base);
        (against != variant.name).then_some(against)
    }

    /// The number of the variant of this name.
    pub fn variant(&self, name: &str) -> Option<usize> {
        self.variants.iter().position(|variant| variant.name == name)
    }
}

/// The JSON schema of experiments, for editors.
pub fn experiment_schema() -> String {
    let schema = schemars::schema_for!(Experiment);
    serde_json::to_string_pretty(&schema).unwrap_or_default() + "\n"
}
