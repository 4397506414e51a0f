//! What may be said of a run: values with intervals, ratios to the base, and claims that are corrected for their number.

use crate::records::{Outcome, Records};
use crate::run::CLAIM_BLOCKS;
use crate::statistics::{PairedRatio, holm, median, median_interval, paired_ratio};
use std::collections::{BTreeMap, BTreeSet};

/// Claims are wrong by chance, one or more of all of a run, in at most this share of runs.
const WRONG: f64 = 0.05;

/// What was found of a quantity.
#[derive(Clone, Debug, PartialEq)]
pub struct Comparison {
    /// The quantity.
    pub quantity: String,
    /// In the order of the experiment.
    pub variants: Vec<VariantResult>,
    /// How far the base is from itself: the ratio of its two runs.
    pub noise: Option<PairedRatio>,
}

/// What was found of a variant.
#[derive(Clone, Debug, PartialEq)]
pub struct VariantResult {
    /// Its name.
    pub variant: String,
    /// Rays.
    pub work: Option<u64>,
    /// The medians of its processes in milliseconds, in undisturbed blocks or, where those are too few, in all.
    pub medians: Vec<f64>,
    /// Their median and its interval of 95 %.
    pub milliseconds: Option<(f64, Option<[f64; 2]>)>,
    /// Its time over that of the base.
    pub ratio: Option<PairedRatio>,
    /// Hashes of answers, or numbers of hits.
    pub answers: BTreeSet<String>,
    /// What may be said.
    pub verdict: Verdict,
}

/// What may be said of a variant beside the base.
#[derive(Clone, Debug, PartialEq)]
pub enum Verdict {
    /// It is the base.
    Base,
    /// It takes less time.
    Faster,
    /// It takes more.
    Slower,
    /// No difference was seen.
    NoDifferenceSeen,
    /// It differs less than the base does from itself.
    WithinNoise,
    /// Not enough processes, or too much other work, for a claim.
    NoClaim(&'static str),
    /// The answers are not the same: no ratio is formed.
    OtherAnswers,
    /// There is no measurement.
    NotMeasured(String),
}

/// What disturbed blocks mean for a run.
pub const UNSTABLE: &str = "other work was seen on the cores in too many blocks";
/// What it means that the other variant has no measurement.
const NO_OTHER: &str = "what it is compared with was not measured";
/// What few blocks mean.
pub const TOO_FEW: &str = "fewer than 6 blocks";

/// Compares what a run has so far.
pub fn compare(records: &Records) -> Vec<Comparison> {
    let experiment = &records.header.experiment;
    let last = records.records.iter().map(|record| record.block).max();
    let all: Vec<u32> = (0..=last.unwrap_or(0)).filter(|_| last.is_some()).collect();
    let (disturbed, undisturbed): (Vec<u32>, Vec<u32>) =
        all.iter().copied().partition(|&block| records.is_disturbed(block));
    let enough = CLAIM_BLOCKS as usize;
    let (blocks, no_claim) = match (undisturbed.len(), disturbed.len()) {
        (quiet, _) if quiet >= enough => (&undisturbed, None),
        (quiet, loud) if quiet + loud >= enough => (&all, Some(UNSTABLE)),
        _ => (&all, Some(TOO_FEW)),
    };
    let seed = records.header.seed;
    let mut comparisons: Vec<Comparison> = quantities(records)
        .into_iter()
        .map(|quantity| {
            let base = Series::of(records, blocks, &quantity, &experiment.base, false);
            let noise = base.ratio_to(&Series::of(records, blocks, &quantity, &experiment.base, true), seed);
            let variants = experiment.variants.iter().map(|variant| {
                let series = Series::of(records, blocks, &quantity, &variant.name, false);
                let other = experiment.against(variant);
                let other = other.map(|other| Series::of(records, blocks, &quantity, other, false));
                series.result(records, other.as_ref(), seed)
            });
            Comparison { variants: variants.collect(), noise, quantity }
        })
        .collect();
    judge(&mut comparisons, no_claim);
    comparisons
}

/// Says what may be said, of all ratios together.
fn judge(comparisons: &mut [Comparison], no_claim: Option<&'static str>) {
    let results = || comparisons.iter().flat_map(|comparison| &comparison.variants);
    let probabilities: Vec<f64> = results().filter_map(|result| Some(result.ratio.as_ref()?.p)).collect();
    let mut corrected = holm(&probabilities).into_iter();
    for comparison in comparisons {
        let noise =
            comparison.noise.as_ref().map(|noise| noise.student_interval.map(|bound| bound.ln().abs()));
        let noise = noise.map_or(f64::INFINITY, |[low, high]| low.max(high));
        for result in &mut comparison.variants {
            let Some(ratio) = &result.ratio else { continue };
            let p = corrected.next().unwrap_or(1.0);
            let [low, high] = ratio.interval;
            result.verdict = match no_claim {
                Some(why) => Verdict::NoClaim(why),
                None if ratio.of_blocks.len() < CLAIM_BLOCKS as usize => Verdict::NoClaim(TOO_FEW),
                None if p >= WRONG || (low <= 1.0 && 1.0 <= high) => Verdict::NoDifferenceSeen,
                None if ratio.ratio.ln().abs() <= noise => Verdict::WithinNoise,
                None if ratio.ratio < 1.0 => Verdict::Faster,
                None => Verdict::Slower,
            };
        }
    }
}

/// The names of quantities, in the order of the processes' output.
fn quantities(records: &Records) -> Vec<String> {
    let mut names: Vec<String> = Vec::new();
    for record in &records.records {
        let Outcome::Measured(measured) = &record.outcome else { continue };
        for quantity in &measured.quantities {
            if !names.contains(&quantity.quantity) {
                names.push(quantity.quantity.clone());
            }
        }
    }
    names
}

/// A quantity of a variant, block by block.
struct Series<'a> {
    variant: &'a str,
    medians: BTreeMap<u32, f64>,
    answers: BTreeSet<String>,
    /// Answers of hits alone: those of programs that are not ours.
    is_hashed: bool,
    work: Option<u64>,
}

impl<'a> Series<'a> {
    fn of(records: &Records, blocks: &[u32], quantity: &str, variant: &'a str, again: bool) -> Series<'a> {
        let (medians, answers, work, is_hashed) = (BTreeMap::new(), BTreeSet::new(), None, true);
        let mut series = Series { variant, medians, answers, is_hashed, work };
        for &block in blocks {
            let of_block = records.block(block);
            let Some(measured) = of_block.get(&(variant, again)) else { continue };
            let Some(found) = measured.quantities.iter().find(|one| one.quantity == quantity) else {
                continue;
            };
            let Some(median) = median(&found.milliseconds) else { continue };
            series.medians.insert(block, median);
            series.work = Some(found.work);
            series.is_hashed &= found.answer.is_some();
            let hits = || found.hits.map(|hits| format!("{hits} hits"));
            series.answers.extend(found.answer.clone().or_else(hits));
        }
        series
    }

    /// Whether times of the two are of the same work.
    fn has_answers_of(&self, other: &Series) -> bool {
        let is_one = |series: &Series| series.answers.len() == 1;
        // Programs that do not hash count as the same work where rays are as many; their hits are shown.
        let is_same = !self.is_hashed || !other.is_hashed || self.answers == other.answers;
        self.work == other.work && is_one(self) && is_one(other) && is_same
    }

    /// Its times over those of another one, in the blocks that have both.
    fn ratio_to(&self, other: &Series, seed: u64) -> Option<PairedRatio> {
        if !self.has_answers_of(other) {
            return None;
        }
        let pairs = self.medians.iter().filter_map(|(block, ms)| Some((*ms, *other.medians.get(block)?)));
        let (these, those): (Vec<f64>, Vec<f64>) = pairs.unzip();
        paired_ratio(&these, &those, seed)
    }

    fn result(self, records: &Records, other: Option<&Series>, seed: u64) -> VariantResult {
        let ratio = other.and_then(|other| self.ratio_to(other, seed));
        let medians: Vec<f64> = self.medians.values().copied().collect();
        let verdict = match other {
            _ if medians.is_empty() => Verdict::NotMeasured(why_not(records, self.variant)),
            None => Verdict::Base,
            Some(other) if other.medians.is_empty() => Verdict::NoClaim(NO_OTHER),
            Some(other) if !self.has_answers_of(other) => Verdict::OtherAnswers,
            // What may be said of ratios is said of all together.
            Some(_) => Verdict::NoClaim(TOO_FEW),
        };
        VariantResult {
            variant: self.variant.to_owned(),
            work: self.work,
            milliseconds: median(&medians).map(|ms| (ms, median_interval(&medians, 0.95, seed))),
            medians,
            ratio,
            answers: self.answers,
            verdict,
        }
    }
}

/// Why a variant has no measurement.
fn why_not(records: &Records, variant: &str) -> String {
    let failed = records.records.iter().find_map(|record| match &record.outcome {
        Outcome::Failed(why) if record.variant == variant => Some(why.clone()),
        _ => None,
    });
    let experiment = &records.header.experiment;
    let needs_gpu = experiment.variants.iter().any(|one| one.name == variant && one.needs_gpu);
    failed.unwrap_or_else(|| if needs_gpu { "no GPU here".into() } else { "not yet".into() })
}
