//! A run with what was found of it, as all forms of the report show it.

use super::scale::tick_label;
use super::words::{self, rate, shortened};
use crate::comparison::{QuantityComparison, VariantResult, Verdict, compare, why_not};
use crate::experiment::{Experiment, Published, Variant};
use crate::machine::Machine;
use crate::plan::{Slot, block_order};
use crate::quantity::MILLISECONDS;
use crate::records::{Outcome, Records};
use crate::run::CLAIM_BLOCKS;
use crate::statistics::median;
use std::collections::{BTreeMap, BTreeSet};

/// A run.
pub(super) struct Section<'a> {
    pub(super) records: &'a Records,
    /// Names its files, and its place on the page.
    pub(super) stem: String,
    pub(super) findings: Vec<Finding>,
}

/// A quantity of a run.
pub(super) struct Finding {
    /// Names its files, and its place on the page.
    pub(super) stem: String,
    /// What its values count, as people read it.
    pub(super) unit: String,
    pub(super) comparison: QuantityComparison,
}

/// All runs, and the number of their ratios.
pub(super) fn sections(runs: &[Records]) -> (Vec<Section<'_>>, usize) {
    let compared = compare(runs);
    let ratios = compared.iter().flatten().flat_map(|one| &one.variants).filter(|one| one.ratio.is_some());
    let ratios = ratios.count();
    let mut taken = BTreeSet::new();
    let sections = runs.iter().zip(compared).map(|(records, comparisons)| {
        let experiment = &records.header.experiment;
        let stem = free_name(&experiment.name, "experiment", &mut taken);
        let finding = |comparison: QuantityComparison| Finding {
            stem: free_name(&format!("{stem}-{}", comparison.quantity), "quantity", &mut taken),
            unit: words::unit_of(experiment, &comparison.unit),
            comparison,
        };
        Section { records, findings: comparisons.into_iter().map(finding).collect(), stem: stem.clone() }
    });
    (sections.collect(), ratios)
}

/// A name for files and places of the page that is like this text, and that nothing has yet.
fn free_name(text: &str, otherwise: &str, taken: &mut BTreeSet<String>) -> String {
    let mut name = String::new();
    for c in text.chars() {
        let is_plain = c.is_ascii_alphanumeric();
        if is_plain {
            name.push(c.to_ascii_lowercase());
        } else if !name.ends_with('-') && !name.is_empty() {
            name.push('-');
        }
        if name.len() == 80 {
            break;
        }
    }
    let name = name.trim_end_matches('-');
    let name = if name.is_empty() { otherwise } else { name };
    let numbered =
        (1_u32..).map(|number| if number == 1 { name.to_owned() } else { format!("{name}-{number}") });
    let free = numbered.into_iter().find(|name| !taken.contains(name)).unwrap_or_default();
    taken.insert(free.clone());
    free
}

/// How many blocks and processes a run has.
pub(super) struct Counts {
    pub(super) blocks: u32,
    pub(super) disturbed: u32,
    pub(super) processes: usize,
    pub(super) failed: usize,
}

impl Section<'_> {
    pub(super) fn experiment(&self) -> &Experiment {
        &self.records.header.experiment
    }

    pub(super) fn counts(&self) -> Counts {
        let records = &self.records.records;
        let blocks: BTreeSet<u32> = records.iter().map(|record| record.block).collect();
        let disturbed = blocks.iter().filter(|&&block| self.records.is_disturbed(block)).count() as u32;
        let failed = records.iter().filter(|record| matches!(record.outcome, Outcome::Failed(_))).count();
        Counts { blocks: blocks.len() as u32, disturbed, processes: records.len(), failed }
    }

    /// The command that repeats it.
    pub(super) fn command(&self) -> String {
        let header = &self.records.header;
        let name = header.source.as_ref().unwrap_or(&header.experiment.name);
        let how = if header.is_quick {
            "--quick".to_owned()
        } else {
            let counts = self.counts();
            format!("--blocks {}", (counts.blocks - counts.disturbed).max(CLAIM_BLOCKS))
        };
        format!("eosphor lab run {} {how} --seed {}", words::quoted(name), header.seed)
    }

    /// What else ran, in words.
    pub(super) fn load(&self) -> String {
        let loads = self.records.records.iter().filter_map(|record| match &record.outcome {
            Outcome::Measured(measured) => measured.load,
            Outcome::Failed(_) => None,
        });
        let (others, elsewhere): (Vec<f64>, Vec<f64>) =
            loads.map(|load| (load.other_cores, load.elsewhere_cores)).unzip();
        let said =
            |loads: &[f64]| median(loads).map_or("not known".to_owned(), |load| format!("{load:.2} cores"));
        format!(
            "Other programs on the same cores: {} in the median; on the other cores: {}",
            said(&others),
            said(&elsewhere)
        )
    }

    /// What has not run or has failed, in sentences.
    pub(super) fn missing(&self) -> Vec<String> {
        let experiment = self.experiment();
        let records = &self.records.records;
        let mut missing = Vec::new();
        let counts = self.counts();
        let quiet = counts.blocks - counts.disturbed;
        if quiet < CLAIM_BLOCKS && !self.records.header.is_quick {
            missing.push(format!(
                "It has {quiet} undisturbed of its {}; a claim needs {CLAIM_BLOCKS}.",
                words::counted(counts.blocks, "block")
            ));
        }
        let blocks: BTreeSet<u32> = records.iter().map(|record| record.block).collect();
        let has_gpu = !self.records.header.machine.gpus.is_empty();
        // A run that was ended has begun its last block, and no more is to be said of that.
        let last = blocks.iter().copied().max();
        let runs_here: Vec<bool> =
            experiment.variants.iter().map(|variant| has_gpu || !variant.needs_gpu).collect();
        let of_a_block = block_order(experiment, &runs_here, 0, 0).len();
        let in_last = records.iter().filter(|record| Some(record.block) == last).count();
        let is_begun = in_last < of_a_block && blocks.len() > 1;
        if is_begun {
            missing.push(format!("Of its last block, {in_last} of {of_a_block} processes have run."));
        }
        let without = |slot: Slot| -> Vec<u32> {
            let whole = blocks.iter().copied().filter(|&block| !(is_begun && Some(block) == last));
            whole.filter(|&block| !self.records.has(block, slot)).collect()
        };
        for (number, variant) in experiment.variants.iter().enumerate() {
            let left_out = variant.needs_gpu && !has_gpu;
            let of_it = || records.iter().filter(|record| record.variant == variant.name);
            if left_out && of_it().next().is_none() {
                missing.push(format!("{} was left out: no GPU here.", variant.name));
                continue;
            }
            missing.extend(not_run(&variant.name, &without(Slot::Variant(number))));
            let failures: Vec<&String> = of_it()
                .filter_map(|record| match &record.outcome {
                    Outcome::Failed(why) => Some(why),
                    Outcome::Measured(_) => None,
                })
                .collect();
            if let [first, ..] = failures[..] {
                let (failed, all) = (failures.len(), of_it().count());
                let name = &variant.name;
                missing.push(format!(
                    "{failed} of {all} processes of {name} failed: {}.",
                    shortened(first, 200)
                ));
            }
        }
        missing
            .extend(not_run(&format!("{} for the second time", experiment.base), &without(Slot::BaseAgain)));
        missing
    }

    /// What came of it, in a line.
    pub(super) fn result(&self) -> String {
        let several = self.findings.len() > 1;
        let mut claims = Vec::new();
        let mut others: Vec<(String, BTreeSet<&str>)> = Vec::new();
        for finding in &self.findings {
            for result in &finding.comparison.variants {
                match &result.verdict {
                    // Along a curve no two points are of the same work: that is no result.
                    Verdict::Base | Verdict::OtherWork => {}
                    Verdict::Less | Verdict::More => claims.extend(finding.claim(result, several)),
                    other => {
                        let said = match other {
                            Verdict::NoClaim(why) => format!("nothing is claimed: {why}"),
                            other => words::verdict(other, &finding.comparison.unit),
                        };
                        let said = shortened(&said, 100);
                        match others.iter_mut().find(|(known, _)| *known == said) {
                            Some((_, names)) => _ = names.insert(&result.variant),
                            None => others.push((said, BTreeSet::from([&result.variant[..]]))),
                        }
                    }
                }
            }
        }
        let claims = if self.experiment().axis.is_some() { self.claims_of_curves() } else { claims };
        let mut parts: Vec<String> = claims.iter().take(MOST_CLAIMS).cloned().collect();
        match claims.len().saturating_sub(MOST_CLAIMS) {
            0 => {}
            1 => parts.push("1 more difference".to_owned()),
            more => parts.push(format!("{more} more differences")),
        }
        let is_alone = parts.is_empty() && others.len() == 1;
        parts.extend(others.into_iter().map(|(said, names)| match names.len() {
            _ if is_alone => said,
            1 | 2 => format!("{}: {said}", names.into_iter().collect::<Vec<_>>().join(", ")),
            count => format!("{said} ({count} variants)"),
        }));
        if parts.is_empty() {
            parts.extend(self.findings.iter().take(MOST_CLAIMS).filter_map(Finding::base_value));
        }
        if parts.is_empty() {
            let failed = self.records.records.iter().find_map(|record| match &record.outcome {
                Outcome::Failed(why) => Some(shortened(why, 100)),
                Outcome::Measured(_) => None,
            });
            let why = failed.unwrap_or_else(|| why_not(self.records, &self.experiment().variants[0]));
            parts.push(format!("nothing was measured: {why}"));
        }
        parts.join("; ")
    }
}

/// Claims of one curve beside another.
struct CurveClaims<'a> {
    /// The curves, the quantity, and what is said.
    said: (&'a str, &'a str, &'a str, &'static str),
    /// Of the claims.
    ratios: Vec<f64>,
    /// Where they are on the axis.
    places: Vec<f64>,
}

impl Section<'_> {
    /// Claims of experiments with an axis: one for all places of a curve.
    fn claims_of_curves(&self) -> Vec<String> {
        let experiment = self.experiment();
        let several = self.findings.len() > 1;
        let label = experiment.axis.as_ref().map_or("", |axis| &axis.label);
        let mut all: Vec<CurveClaims> = Vec::new();
        for finding in &self.findings {
            for (variant, result) in experiment.variants.iter().zip(&finding.comparison.variants) {
                let Some(said) = finding.said(&result.verdict) else { continue };
                let (Some(ratio), Some(against)) = (&result.ratio, result.against.as_deref()) else {
                    continue;
                };
                let series = variant.series.as_deref().unwrap_or_default();
                let other = experiment
                    .variant(against)
                    .and_then(|other| experiment.variants[other].series.as_deref());
                let other = other.filter(|other| *other != series).unwrap_or(against);
                let quantity = if several { &finding.comparison.quantity[..] } else { "" };
                let said = (series, other, quantity, said);
                let (ratio, place) = (ratio.ratio, variant.x.unwrap_or_default());
                match all.iter_mut().find(|one| one.said == said) {
                    Some(one) => {
                        one.ratios.push(ratio);
                        one.places.push(place);
                    }
                    None => all.push(CurveClaims { said, ratios: vec![ratio], places: vec![place] }),
                }
            }
        }
        let ends = |values: &[f64], word: fn(f64) -> String| {
            let [low, high] =
                [f64::min, f64::max].map(|of| values.iter().copied().reduce(of).unwrap_or_default());
            if low == high { word(low) } else { format!("{} to {}", word(low), word(high)) }
        };
        let in_words = |one: &CurveClaims| {
            let (series, other, quantity, said) = one.said;
            let quantity = if quantity.is_empty() { String::new() } else { format!("{quantity}: ") };
            let (places, ratios) = (ends(&one.places, tick_label), ends(&one.ratios, words::ratio));
            match series.is_empty() {
                true => format!("with {label} {places}, it {said} {other} ({quantity}{ratios} of that)"),
                false => {
                    format!("{series} {said} {other} ({quantity}{ratios} of that, with {label} {places})")
                }
            }
        };
        let slopes = self.findings.iter().filter(|finding| !finding.comparison.slopes.is_empty());
        let slopes = slopes.map(|finding| {
            let of =
                |(name, slope): &(String, crate::statistics::Slope)| format!("{name} {:.2}", slope.slope);
            let powers: Vec<String> = finding.comparison.slopes.iter().map(of).collect();
            format!(
                "{} goes with these powers of {label}: {}",
                finding.comparison.quantity,
                powers.join(", ")
            )
        });
        slopes.chain(all.iter().map(in_words)).collect()
    }
}

/// The most claims that a line names.
const MOST_CLAIMS: usize = 3;

/// A sentence about a variant that has not run in these blocks.
fn not_run(name: &str, blocks: &[u32]) -> Option<String> {
    let first: Vec<String> = blocks.iter().take(8).map(|block| (block + 1).to_string()).collect();
    let more = if blocks.len() > first.len() { " and others" } else { "" };
    let word = if blocks.len() == 1 { "block" } else { "blocks" };
    (!blocks.is_empty()).then(|| format!("{name} has not run in {word} {}{more}.", first.join(", ")))
}

impl Finding {
    /// What a claim says between two names.
    fn said(&self, verdict: &Verdict) -> Option<&'static str> {
        let is_time = self.comparison.unit == MILLISECONDS;
        match (verdict, is_time) {
            (Verdict::Less, true) => Some("is faster than"),
            (Verdict::Less, false) => Some("has less than"),
            (Verdict::More, true) => Some("is slower than"),
            (Verdict::More, false) => Some("has more than"),
            _ => None,
        }
    }

    /// A claim, in words.
    fn claim(&self, result: &VariantResult, with_quantity: bool) -> Option<String> {
        let ratio = result.ratio.as_ref()?;
        let against = result.against.as_deref()?;
        let said = self.said(&result.verdict)?;
        let quantity = if with_quantity { format!("{}: ", self.comparison.quantity) } else { String::new() };
        let [low, high] = ratio.interval.map(words::ratio);
        let value = words::ratio(ratio.ratio);
        Some(format!("{} {said} {against} ({quantity}{value} [{low}, {high}] of that)", result.variant))
    }

    /// The first value that there is, in words.
    fn base_value(&self) -> Option<String> {
        let result = self.comparison.variants.iter().find(|result| result.value.is_some())?;
        let (value, interval) = result.value?;
        let interval = interval.map(|ends| format!(" [{}]", ends.map(words::number).join(", ")));
        let (name, unit) = (&result.variant, &self.unit);
        Some(format!("{name}: {} {unit}{}", words::number(value), interval.unwrap_or_default()))
    }

    /// How far the base may be from itself, as a ratio below 1 and one above.
    pub(super) fn noise_band(&self) -> Option<[f64; 2]> {
        let ends = self.comparison.noise.as_ref()?.student_interval;
        let far = ends.into_iter().map(|end| end.ln().abs()).fold(0.0, f64::max);
        far.is_finite().then(|| [(-far).exp(), far.exp()])
    }

    /// Whether a ratio is no farther from 1 than the base is from itself.
    pub(super) fn is_within_noise(&self, ratio: f64) -> bool {
        self.noise_band().is_some_and(|[low, high]| (low..=high).contains(&ratio))
    }

    /// Whether a published figure can be drawn with these values.
    pub(super) fn shows(&self, figure: &Published, findings: &[Finding]) -> bool {
        figure.unit == self.unit && figure.value > 0.0 && self.is_meant(figure, findings)
    }

    /// Whether a published figure is about this quantity: it is the only one, or the figure names it.
    fn is_meant(&self, figure: &Published, findings: &[Finding]) -> bool {
        findings.len() == 1 || figure.what.to_lowercase().contains(&self.comparison.quantity.to_lowercase())
    }

    /// Our value beside a published figure, in the figure's unit.
    fn beside(&self, figure: &Published) -> Option<f64> {
        let name = figure.beside.as_deref()?;
        let result = self.comparison.variants.iter().find(|result| result.variant == name)?;
        let (value, _) = result.value?;
        match &figure.unit[..] {
            unit if unit == self.unit => Some(value),
            "Mrays/s" => rate(value, result.work, &self.comparison.unit),
            // Beside what it is compared with.
            "times as fast" => result.ratio.as_ref().map(|ratio| 1.0 / ratio.ratio),
            "times as long" => result.ratio.as_ref().map(|ratio| ratio.ratio),
            _ => None,
        }
    }
}

/// A published figure with ours.
pub(super) struct Beside<'a> {
    pub(super) figure: &'a Published,
    /// The quantity, and our value in the figure's unit.
    pub(super) ours: Option<(&'a str, f64)>,
    /// Whether the figure names this machine's processor or GPU as its hardware.
    pub(super) is_same_hardware: bool,
}

impl Beside<'_> {
    /// How often their value ours is. `None` where either is missing.
    pub(super) fn times(&self) -> Option<f64> {
        let (_, ours) = self.ours?;
        (self.figure.value > 0.0).then(|| ours / self.figure.value)
    }
}

impl Section<'_> {
    /// Published figures with ours.
    pub(super) fn published(&self) -> Vec<Beside<'_>> {
        let hardware = hardware(&self.records.header.machine);
        let beside = |figure| {
            let meant = self.findings.iter().filter(|finding| finding.is_meant(figure, &self.findings));
            let ours =
                meant.filter_map(|finding| Some((&finding.comparison.quantity[..], finding.beside(figure)?)));
            let is_same_hardware = hardware.contains(&&figure.hardware[..]);
            Beside { figure, ours: { ours }.next(), is_same_hardware }
        };
        self.experiment().published.iter().map(beside).collect()
    }
}

fn hardware(machine: &Machine) -> Vec<&str> {
    machine.cpu.as_deref().into_iter().chain(machine.gpus.iter().map(|gpu| &gpu.name[..])).collect()
}

/// The names of curves in the order of variants, each with the numbers of its variants.
pub(super) fn curves(variants: &[Variant]) -> Vec<(&str, Vec<usize>)> {
    let mut order: Vec<&str> = Vec::new();
    let mut numbers: BTreeMap<&str, Vec<usize>> = BTreeMap::new();
    for (number, variant) in variants.iter().enumerate() {
        let name = variant.series.as_deref().unwrap_or_default();
        if !order.contains(&name) {
            order.push(name);
        }
        numbers.entry(name).or_default().push(number);
    }
    order.into_iter().map(|name| (name, numbers.remove(name).unwrap_or_default())).collect()
}
