//! What an experiment is: what varies, what is held, what is measured.

use serde::{Deserialize, Serialize};

/// An experiment. It can be read from a JSON file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub struct Experiment {
    /// Its name on command lines: letters, digits and hyphens.
    pub name: String,
    /// What it asks, in a line.
    pub question: String,
    /// What is measured.
    pub measures: Measure,
    /// Arguments that all variants have: the scene, its size and so on.
    pub held: Vec<String>,
    /// What is compared.
    pub variants: Vec<Variant>,
    /// The variant that the others are compared with. It runs twice in each block: how far it is from itself is the noise.
    pub base: String,
    /// Cores that a process may use; where not given, all.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub cores: Option<usize>,
    /// Repetitions within a process, after one to warm up.
    #[serde(default = "default_repeats")]
    pub repeats: u32,
}

fn default_repeats() -> u32 {
    5
}

/// What a process measures.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Measure {
    /// The time of a picture: `eosphor bench render`.
    Picture,
    /// The time of queries about sets of rays: `eosphor bench rays`.
    Rays,
}

/// One of what is compared.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub struct Variant {
    /// Its name in tables.
    pub name: String,
    /// Its arguments, after those that are held.
    #[serde(default)]
    pub arguments: Vec<String>,
    /// Another program that measures the same work; it gets the arguments and prints lines of the lab's format.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub program: Option<String>,
    /// The variant that it is compared with; where not given, the base.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub against: Option<String>,
    /// It needs an NVIDIA GPU; where there is none it is left out, and the report says so.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub needs_gpu: bool,
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
        if !(1..=MAX_REPEATS).contains(&self.repeats) {
            return wrong(format!("\"repeats\" must be 1 to {MAX_REPEATS}"));
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
        }
        let names = self.variants.iter().filter_map(|variant| variant.against.as_ref());
        for name in names.chain([&self.base]) {
            if self.variant(name).is_none() {
                return wrong(format!("\"{name}\", which others are compared with, is none of its variants"));
            }
        }
        Ok(())
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
