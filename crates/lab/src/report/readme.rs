//! A run as one short table, for READMEs.

use super::markdown::escaped;
use super::section::{Finding, Section, sections};
use super::words::{self, number, rate};
use crate::comparison::VariantResult;
use crate::records::Records;
use std::fmt::Write;

/// A row for each variant and a column for each quantity, and when, where and how often it was measured. Times of rays are millions
/// of rays a second.
pub fn readme_table(records: &Records) -> String {
    let (all, _) = sections(std::slice::from_ref(records));
    all.first().map(table).unwrap_or_default()
}

fn table(section: &Section) -> String {
    let header = &section.records.header;
    let measured: Vec<&Finding> = section
        .findings
        .iter()
        .filter(|one| one.comparison.variants.iter().any(|v| v.value.is_some()))
        .collect();
    let mut text = String::from("| |");
    for finding in &measured {
        let is_rate = finding.comparison.variants.iter().any(|one| rate_of(one, finding).is_some());
        let unit = match (is_rate, &finding.unit[..]) {
            (true, "CPU ms") => "Mrays per CPU second",
            (true, _) => "Mrays/s",
            (false, unit) => unit,
        };
        let _ = write!(text, " {}, {} |", escaped(&finding.comparison.quantity), escaped(unit));
    }
    let _ = writeln!(text, "\n|---|{}", "---:|".repeat(measured.len()));
    for (number, variant) in section.experiment().variants.iter().enumerate() {
        let cells = measured.iter().map(|finding| cell(&finding.comparison.variants[number], finding));
        let cells: Vec<String> = cells.collect();
        if cells.iter().any(|cell| cell != NONE) {
            let _ = writeln!(text, "| {} | {} |", escaped(&variant.name), cells.join(" | "));
        }
    }
    let counts = section.counts();
    let processes = measured.iter().flat_map(|one| &one.comparison.variants).map(|one| one.medians.len());
    let [fewest, most] =
        [processes.clone().filter(|&n| n > 0).min(), processes.max()].map(Option::unwrap_or_default);
    let often = if fewest == most { format!("{most}") } else { format!("{fewest} to {most}") };
    let program = &header.program;
    let commit = program.commit.as_ref().map_or(String::new(), |commit| format!(" at {commit}"));
    let _ = write!(
        text,
        "\nMedians of {often} fresh processes each, in blocks of random order ({} of {} disturbed), with intervals of 95 %. {}, {}, \
         Eosphor {}{commit}; machine and program {}.",
        counts.disturbed,
        counts.blocks,
        words::utc(header.began),
        words::machine_in_short(&header.machine, header.experiment.cores),
        program.version,
        header.id(),
    );
    if let Some(hits) = hits(&measured) {
        let _ = write!(text, " {hits}");
    }
    text + "\n"
}

const NONE: &str = "–";

fn rate_of(result: &VariantResult, finding: &Finding) -> Option<f64> {
    rate(result.value?.0, result.work, &finding.comparison.unit)
}

fn cell(result: &VariantResult, finding: &Finding) -> String {
    let Some((value, interval)) = result.value else { return NONE.into() };
    let Some(work) = result.work.filter(|_| rate_of(result, finding).is_some()) else {
        let range = interval.map(|[low, high]| format!(" ({} to {})", number(low), number(high)));
        return number(value) + &range.unwrap_or_default();
    };
    let unit = &finding.comparison.unit;
    let in_rays = |value: f64| number(rate(value, Some(work), unit).unwrap_or(0.0));
    let range = interval.map(|[low, high]| format!(" ({} to {})", in_rays(high), in_rays(low)));
    in_rays(value) + &range.unwrap_or_default()
}

/// How far the hits of other programs are from ours.
fn hits(measured: &[&Finding]) -> Option<String> {
    let results = measured.iter().flat_map(|one| &one.comparison.variants);
    let most = results.flat_map(|one| one.hits.iter().map(|[_, different]| *different)).max()?;
    Some(format!("Of other libraries at most {most} answers of a set of rays are not ours."))
}
