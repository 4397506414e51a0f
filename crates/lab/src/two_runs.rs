//! Two runs of the same experiments: another version, or another machine.

use crate::comparison::{Series, Verdict, WRONG, quantities, usable_blocks};
use crate::records::Records;
use crate::run::CLAIM_BLOCKS;
use crate::statistics::{UnpairedRatio, holm, unpaired_ratio};

/// A quantity of a variant in two runs.
#[derive(Clone, Debug, PartialEq)]
pub struct Change {
    /// The experiment.
    pub experiment: String,
    /// The variant.
    pub variant: String,
    /// The quantity.
    pub quantity: String,
    /// Its unit.
    pub unit: String,
    /// The value of the second run over that of the first.
    pub ratio: Option<UnpairedRatio>,
    /// What may be said of the second run.
    pub verdict: Verdict,
}

/// Compares two sets of runs, paired by experiment, variant and quantity. Claims are corrected for their number.
pub fn compare_runs(first: &[Records], second: &[Records]) -> Vec<Change> {
    let mut changes = Vec::new();
    for before in first {
        let name = (&before.header.experiment.name, before.header.is_quick);
        let is_same = |other: &&Records| (&other.header.experiment.name, other.header.is_quick) == name;
        if let Some(after) = second.iter().find(is_same) {
            changes.extend(changes_of(before, after));
        }
    }
    let probabilities: Vec<f64> =
        changes.iter().filter_map(|change| Some(change.ratio.as_ref()?.p)).collect();
    let mut corrected = holm(&probabilities).into_iter();
    for change in &mut changes {
        let Some(ratio) = &change.ratio else { continue };
        let p = corrected.next().unwrap_or(1.0);
        let [low, high] = ratio.interval;
        if matches!(change.verdict, Verdict::NoDifferenceSeen) && p < WRONG && !(low <= 1.0 && 1.0 <= high) {
            change.verdict = if ratio.ratio < 1.0 { Verdict::Less } else { Verdict::More };
        }
    }
    changes
}

fn changes_of(before: &Records, after: &Records) -> Vec<Change> {
    let experiment = &before.header.experiment;
    let (blocks, why) = usable_blocks(before);
    let (other_blocks, other_why) = usable_blocks(after);
    let seed = before.header.seed ^ after.header.seed;
    let mut changes = Vec::new();
    for (quantity, unit) in quantities(before) {
        for variant in &experiment.variants {
            let these = Series::of(before, &blocks, &quantity, &variant.name, false);
            let those = Series::of(after, &other_blocks, &quantity, &variant.name, false);
            if these.medians.is_empty() && those.medians.is_empty() {
                continue;
            }
            let values = |series: &Series| series.medians.values().copied().collect::<Vec<f64>>();
            let few = these.medians.len().min(those.medians.len()) < CLAIM_BLOCKS as usize;
            let is_same_work =
                experiment_work(before, &variant.name) == experiment_work(after, &variant.name);
            let verdict = match why.or(other_why) {
                _ if these.medians.is_empty() => Verdict::NotMeasured("not in the first run".into()),
                _ if those.medians.is_empty() => Verdict::NotMeasured("not in the second run".into()),
                _ if !is_same_work => Verdict::OtherWork,
                reason => match (these.misfit(&those), reason) {
                    (Some(misfit), _) => misfit,
                    (None, Some(reason)) => Verdict::NoClaim(reason),
                    (None, None) if few => Verdict::NoClaim(crate::comparison::TOO_FEW),
                    (None, None) => Verdict::NoDifferenceSeen,
                },
            };
            let is_comparable = matches!(verdict, Verdict::NoClaim(_) | Verdict::NoDifferenceSeen);
            let ratio =
                is_comparable.then(|| unpaired_ratio(&values(&those), &values(&these), seed)).flatten();
            changes.push(Change {
                experiment: experiment.name.clone(),
                variant: variant.name.clone(),
                quantity: quantity.clone(),
                unit: unit.clone(),
                ratio,
                verdict,
            });
        }
    }
    changes
}

/// What a variant does: its arguments, all that is held, and how often it is repeated.
fn experiment_work<'a>(records: &'a Records, variant: &str) -> Option<impl PartialEq + 'a> {
    let experiment = &records.header.experiment;
    let found = &experiment.variants[experiment.variant(variant)?];
    let held = (&experiment.held, &experiment.input, &experiment.prepare, experiment.measures);
    Some((held, &found.arguments, &found.program, &found.launcher, experiment.cores, experiment.clock))
}
