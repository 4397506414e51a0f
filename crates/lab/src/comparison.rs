//! What may be said of runs: values with intervals, ratios to the base, and claims that are corrected for their number.

use crate::experiment::{Clock, Experiment, Variant};
use crate::quantity::{MILLISECONDS, Quantity};
use crate::records::{Outcome, Records};
use crate::run::CLAIM_BLOCKS;
use crate::statistics::{PairedRatio, Slope, holm, log_log_slope, median, median_interval, paired_ratio};
use std::collections::{BTreeMap, BTreeSet};

/// Claims are wrong by chance, one or more of all of a report, in at most this share of reports.
pub(crate) const WRONG: f64 = 0.05;

/// What was found of a quantity.
#[derive(Clone, Debug, PartialEq)]
pub struct QuantityComparison {
    /// The quantity.
    pub quantity: String,
    /// The unit of its values.
    pub unit: String,
    /// In the order of the experiment.
    pub variants: Vec<VariantResult>,
    /// How far the base is from itself: the ratio of its two runs.
    pub noise: Option<PairedRatio>,
    /// By which power of the axis each curve grows, where the experiment asks for it.
    pub slopes: Vec<(String, Slope)>,
}

/// What was found of a variant.
#[derive(Clone, Debug, PartialEq)]
pub struct VariantResult {
    /// Its name.
    pub variant: String,
    /// Rays.
    pub work: Option<u64>,
    /// The medians of its processes, in undisturbed blocks or, where those are too few, in all; the median of each process is of
    /// its repetitions.
    pub medians: Vec<f64>,
    /// Their median and its interval of 95 %.
    pub value: Option<(f64, Option<[f64; 2]>)>,
    /// Its value over that of what it is compared with.
    pub ratio: Option<PairedRatio>,
    /// The name of what it is compared with, unless it is the base itself.
    pub against: Option<String>,
    /// Hashes of answers.
    pub answers: BTreeSet<String>,
    /// Of programs that do not hash: how many rays hit something, and how many have another answer than ours.
    pub hits: BTreeSet<[u64; 2]>,
    /// What may be said.
    pub verdict: Verdict,
}

/// What may be said of a variant beside what it is compared with.
#[derive(Clone, Debug, PartialEq)]
pub enum Verdict {
    /// It is the base.
    Base,
    /// It takes less.
    Less,
    /// It takes more.
    More,
    /// No difference was seen.
    NoDifferenceSeen,
    /// It differs less than the base does from itself.
    WithinNoise,
    /// Not enough processes, or too much other work, for a claim.
    NoClaim(&'static str),
    /// The work is not the same: no ratio is formed.
    OtherWork,
    /// The answers are not the same: no ratio is formed.
    OtherAnswers,
    /// There is no measurement.
    NotMeasured(String),
}

/// What disturbed blocks mean for a run.
pub const UNSTABLE: &str = "unstable: other programs ran on its cores in too many blocks";
/// What it means that the other variant has no measurement.
const NO_OTHER: &str = "what it is compared with was not measured";
/// What it means that a run is quick.
pub const QUICK: &str = "a quick run";
/// What few blocks mean.
pub const TOO_FEW: &str = "fewer than 6 undisturbed blocks";

/// Compares what runs have so far; claims are corrected for the number of all of them.
pub fn compare(runs: &[Records]) -> Vec<Vec<QuantityComparison>> {
    let mut compared: Vec<(Vec<QuantityComparison>, _)> = runs.iter().map(compare_run).collect();
    judge(&mut compared);
    compared.into_iter().map(|(comparisons, _)| comparisons).collect()
}

/// The blocks whose measurements are used, and why they allow no claim.
pub(crate) fn usable_blocks(records: &Records) -> (Vec<u32>, Option<&'static str>) {
    let last = records.records.iter().map(|record| record.block).max();
    let all: Vec<u32> = (0..=last.unwrap_or(0)).filter(|_| last.is_some()).collect();
    let (disturbed, undisturbed): (Vec<u32>, Vec<u32>) =
        all.iter().copied().partition(|&block| records.is_disturbed(block));
    let enough = CLAIM_BLOCKS as usize;
    match (undisturbed.len(), disturbed.len()) {
        (quiet, _) if quiet >= enough && records.header.is_quick => (undisturbed, Some(QUICK)),
        _ if records.header.is_quick => (all, Some(QUICK)),
        (quiet, _) if quiet >= enough => (undisturbed, None),
        (quiet, loud) if quiet + loud >= enough => (all, Some(UNSTABLE)),
        _ => (all, Some(TOO_FEW)),
    }
}

fn compare_run(records: &Records) -> (Vec<QuantityComparison>, Option<&'static str>) {
    let experiment = &records.header.experiment;
    let (blocks, no_claim) = usable_blocks(records);
    let seed = records.header.seed;
    let of_quantity = |(quantity, unit): (String, String)| {
        let of = |variant: &str, again| Series::of(records, &blocks, &quantity, variant, again);
        let noise = of(&experiment.base, false).ratio_to(&of(&experiment.base, true), seed);
        let all: Vec<Series> = experiment.variants.iter().map(|variant| of(&variant.name, false)).collect();
        let slopes = slopes(experiment, &all, seed);
        let variants = experiment.variants.iter().zip(all).map(|(variant, series)| {
            let other = experiment.against(variant).map(|other| of(other, false));
            series.result(records, variant, other.as_ref(), seed)
        });
        QuantityComparison { variants: variants.collect(), noise, slopes, unit, quantity }
    };
    (quantities(records).into_iter().map(of_quantity).collect(), no_claim)
}

/// Says what may be said, of all ratios together.
fn judge(runs: &mut [(Vec<QuantityComparison>, Option<&'static str>)]) {
    let results = || runs.iter().flat_map(|(run, _)| run).flat_map(|comparison| &comparison.variants);
    let probabilities: Vec<f64> = results().filter_map(|result| Some(result.ratio.as_ref()?.p)).collect();
    let mut corrected = holm(&probabilities).into_iter();
    for (comparisons, no_claim) in runs {
        for comparison in comparisons {
            let noise = comparison.noise_logarithm();
            for result in &mut comparison.variants {
                let Some(ratio) = &result.ratio else { continue };
                let p = corrected.next().unwrap_or(1.0);
                let [low, high] = ratio.interval;
                result.verdict = match no_claim {
                    Some(why) => Verdict::NoClaim(why),
                    None if ratio.of_blocks.len() < CLAIM_BLOCKS as usize => Verdict::NoClaim(TOO_FEW),
                    None if p >= WRONG || (low <= 1.0 && 1.0 <= high) => Verdict::NoDifferenceSeen,
                    None if ratio.ratio.ln().abs() <= noise => Verdict::WithinNoise,
                    None if ratio.ratio < 1.0 => Verdict::Less,
                    None => Verdict::More,
                };
            }
        }
    }
}

impl QuantityComparison {
    /// How far the base may be from itself, as the logarithm of a ratio: infinitely far where that was not measured.
    fn noise_logarithm(&self) -> f64 {
        let bounds = self.noise.as_ref().map(|noise| noise.student_interval.map(|bound| bound.ln().abs()));
        bounds.map_or(f64::INFINITY, |[low, high]| low.max(high))
    }
}

/// The names and units of quantities, in the order of the processes' output.
pub(crate) fn quantities(records: &Records) -> Vec<(String, String)> {
    let mut names: Vec<(String, String)> = Vec::new();
    // The base comes first, so that the order does not hang on which variant happened to be the first.
    let base = &records.header.experiment.base;
    let (of_base, others): (Vec<_>, Vec<_>) =
        records.records.iter().partition(|record| record.variant == *base);
    for record in of_base.into_iter().chain(others) {
        let Outcome::Measured(measured) = &record.outcome else { continue };
        for quantity in &measured.quantities {
            if !names.iter().any(|(name, _)| *name == quantity.quantity) {
                names.push((quantity.quantity.clone(), quantity.unit.clone()));
            }
        }
    }
    names
}

/// By which power of the axis each curve grows.
fn slopes(experiment: &Experiment, all: &[Series], seed: u64) -> Vec<(String, Slope)> {
    if !experiment.axis.as_ref().is_some_and(|axis| axis.slope) {
        return Vec::new();
    }
    let name = |variant: &Variant| variant.series.clone().unwrap_or_default();
    let mut names: Vec<String> = Vec::new();
    for variant in &experiment.variants {
        if !names.contains(&name(variant)) {
            names.push(name(variant));
        }
    }
    let of_curve = |curve: String| {
        let mut blocks: BTreeMap<u32, Vec<(f64, f64)>> = BTreeMap::new();
        for (variant, series) in experiment.variants.iter().zip(all).filter(|(one, _)| name(one) == curve) {
            let Some(x) = variant.x else { continue };
            for (&block, &value) in &series.medians {
                blocks.entry(block).or_default().push((x, value));
            }
        }
        let slope = log_log_slope(&blocks.into_values().collect::<Vec<_>>(), seed)?;
        Some((curve, slope))
    };
    names.into_iter().filter_map(of_curve).collect()
}

/// A quantity of a variant, block by block.
pub(crate) struct Series {
    variant: String,
    pub(crate) medians: BTreeMap<u32, f64>,
    answers: BTreeSet<String>,
    hits: BTreeSet<[u64; 2]>,
    work: BTreeSet<Option<u64>>,
}

impl Series {
    pub(crate) fn of(
        records: &Records,
        blocks: &[u32],
        quantity: &str,
        variant: &str,
        again: bool,
    ) -> Series {
        let clock = records.header.experiment.clock;
        let (medians, answers) = (BTreeMap::new(), BTreeSet::new());
        let (hits, work) = (BTreeSet::new(), BTreeSet::new());
        let mut series = Series { variant: variant.to_owned(), medians, answers, hits, work };
        for &block in blocks {
            let of_block = records.block(block);
            let Some(measured) = of_block.get(&(variant, again)) else { continue };
            let found = measured.quantities.iter().find(|one| one.quantity == quantity);
            let Some((found, median)) = found.and_then(|found| Some((found, median_of(found, clock)?)))
            else {
                continue;
            };
            series.medians.insert(block, median);
            series.work.insert(found.work);
            series.answers.extend(found.answer.clone());
            series.hits.extend(found.hits.map(|hits| [hits, found.different.unwrap_or(0)]));
        }
        series
    }

    /// Why its values are not compared with those of another one.
    pub(crate) fn misfit(&self, other: &Series) -> Option<Verdict> {
        if self.work.len() != 1 || self.work != other.work {
            return Some(Verdict::OtherWork);
        }
        // Programs that do not hash are compared where rays are as many; their hits are shown.
        let is_foreign = |series: &Series| series.answers.is_empty() && series.hits.len() == 1;
        let is_same = self.answers == other.answers && self.answers.len() <= 1;
        (!is_same && !is_foreign(self) && !is_foreign(other)).then_some(Verdict::OtherAnswers)
    }

    /// Its values over those of another one, in the blocks that have both.
    fn ratio_to(&self, other: &Series, seed: u64) -> Option<PairedRatio> {
        if self.misfit(other).is_some() {
            return None;
        }
        let pairs = self.medians.iter().filter_map(|(block, ms)| Some((*ms, *other.medians.get(block)?)));
        let (these, those): (Vec<f64>, Vec<f64>) = pairs.unzip();
        paired_ratio(&these, &those, seed)
    }

    fn result(
        self,
        records: &Records,
        variant: &Variant,
        other: Option<&Series>,
        seed: u64,
    ) -> VariantResult {
        let ratio = other.and_then(|other| self.ratio_to(other, seed));
        let medians: Vec<f64> = self.medians.values().copied().collect();
        let verdict = match other {
            _ if medians.is_empty() => Verdict::NotMeasured(why_not(records, variant)),
            None => Verdict::Base,
            Some(other) if other.medians.is_empty() => Verdict::NoClaim(NO_OTHER),
            // What may be said of ratios is said of all together.
            Some(other) => self.misfit(other).unwrap_or(Verdict::NoClaim(TOO_FEW)),
        };
        VariantResult {
            variant: self.variant,
            work: self.work.iter().next().copied().flatten(),
            value: median(&medians).map(|value| (value, median_interval(&medians, 0.95, seed))),
            medians,
            ratio,
            against: other.map(|other| other.variant.clone()),
            answers: self.answers,
            hits: self.hits,
            verdict,
        }
    }
}

/// The median of the repetitions, by the clock that is asked for.
pub(crate) fn median_of(quantity: &Quantity, clock: Clock) -> Option<f64> {
    match clock {
        Clock::Cpu if quantity.unit == MILLISECONDS => median(&quantity.cpu),
        _ => median(&quantity.values),
    }
}

/// Why a variant has no measurement.
pub(crate) fn why_not(records: &Records, variant: &Variant) -> String {
    let failed = records.records.iter().find_map(|record| match &record.outcome {
        Outcome::Failed(why) if record.variant == variant.name => Some(why.clone()),
        _ => None,
    });
    let has_run = records.records.iter().any(|record| record.variant == variant.name);
    failed.unwrap_or_else(|| match () {
        () if has_run => "it does not measure this".into(),
        () if variant.needs_gpu && records.header.machine.gpus.is_empty() => "no GPU here".into(),
        () => "not yet".into(),
    })
}
