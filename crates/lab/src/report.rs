//! A run as text: tables in Markdown.

use crate::comparison::{Comparison, VariantResult, Verdict, compare};
use crate::machine::Machine;
use crate::records::{Outcome, Records};
use crate::run::CLAIM_BLOCKS;
use crate::statistics::median;
use std::fmt::Write;

/// What a run found, as far as it is.
pub fn markdown(records: &Records) -> String {
    let experiment = &records.header.experiment;
    let mut text = format!("## {}\n\n{}\n\n", experiment.name, experiment.question);
    for comparison in compare(records) {
        let _ = writeln!(text, "**{}**\n", escaped(&comparison.quantity));
        text.push_str(&table(&comparison));
    }
    let _ = writeln!(text, "{}\n", conditions(records));
    text
}

fn table(comparison: &Comparison) -> String {
    let mut text = String::from("| variant | ms | 95 % | Mrays/s | processes | time over base | 95 % | |\n");
    text.push_str("|---|---|---|---|---|---|---|---|\n");
    for result in &comparison.variants {
        text.push_str(&row(result));
    }
    if let Some(noise) = &comparison.noise {
        let [low, high] = noise.student_interval;
        let _ =
            writeln!(text, "\nNoise: the base over itself is {:.3} ({low:.3} to {high:.3}).\n", noise.ratio);
    } else {
        text.push('\n');
    }
    text
}

fn row(result: &VariantResult) -> String {
    let range = |interval: Option<[f64; 2]>, digits: usize| {
        interval.map_or("–".to_owned(), |[low, high]| format!("{low:.digits$} to {high:.digits$}"))
    };
    let (ms, interval) = match result.milliseconds {
        Some((ms, interval)) => (format!("{ms:.3}"), range(interval, 3)),
        None => ("–".into(), "–".into()),
    };
    let rate = result.milliseconds.zip(result.work).map(|((ms, _), work)| work as f64 * 1e-3 / ms);
    let rate = rate.map_or("–".to_owned(), |rate| format!("{rate:.2}"));
    let (ratio, of_ratio) = match &result.ratio {
        Some(ratio) => (format!("{:.3}", ratio.ratio), range(Some(ratio.interval), 3)),
        None => ("–".into(), "–".into()),
    };
    let verdict = match &result.verdict {
        Verdict::Base => "base".to_owned(),
        Verdict::Faster => "**faster**".to_owned(),
        Verdict::Slower => "**slower**".to_owned(),
        Verdict::NoDifferenceSeen => "no difference seen".to_owned(),
        Verdict::WithinNoise => "within the noise".to_owned(),
        Verdict::NoClaim(why) => format!("no claim: {why}"),
        Verdict::OtherAnswers => "other work or answers: no ratio".to_owned(),
        Verdict::NotMeasured(why) => format!("not measured: {}", escaped(why)),
    };
    let (name, count) = (escaped(&result.variant), result.medians.len());
    format!("| {name} | {ms} | {interval} | {rate} | {count} | {ratio} | {of_ratio} | {verdict} |\n")
}

/// How it was measured.
fn conditions(records: &Records) -> String {
    let header = &records.header;
    let blocks = records.records.iter().map(|record| record.block + 1).max().unwrap_or(0);
    let disturbed = (0..blocks).filter(|&block| records.is_disturbed(block)).count();
    let measured = records.records.iter().filter_map(|record| match &record.outcome {
        Outcome::Measured(measured) => Some(measured),
        Outcome::Failed(_) => None,
    });
    let loads: Vec<f64> = measured.filter_map(|one| Some(one.load?.other_cores)).collect();
    let load = median(&loads).map_or("not known".to_owned(), |load| format!("{load:.2} cores in the median"));
    let experiment = &header.experiment;
    format!(
        "{} processes in {blocks} blocks of random order (seed {}), {disturbed} of them disturbed; {} repetitions in each process, \
         after one to warm up. Other work on the cores: {load}. Milliseconds are the median of the processes' medians; intervals \
         are of the bootstrap over processes; a ratio is the median over blocks; claims need {CLAIM_BLOCKS} undisturbed blocks, and are \
         corrected for their number (Holm, 5 %).\n\nEosphor {}; {}. Repeat it: `eosphor lab run {}`; all have `{}`.",
        records.records.len(),
        header.seed,
        experiment.repeats,
        header.version,
        machine(&header.machine),
        experiment.name,
        escaped(&experiment.held.join(" ")),
    )
}

fn machine(machine: &Machine) -> String {
    let mut parts =
        vec![escaped(machine.cpu.as_deref().unwrap_or("a processor that the system does not name"))];
    parts.push(format!("{} of {} cores", machine.allowed_cores.len().max(1), machine.cores));
    if machine.smt == Some(true) {
        parts.push("SMT".into());
    }
    parts.extend(machine.memory_bytes.map(|bytes| format!("{:.0} GiB", bytes as f64 / f64::from(1 << 30))));
    parts.extend(machine.caches.iter().map(|cache| escaped(cache)));
    parts.extend(machine.huge_pages.iter().map(|pages| format!("huge pages {}", escaped(pages))));
    parts.extend(machine.governor.iter().map(|governor| format!("governor {}", escaped(governor))));
    parts.push(escaped(&machine.system));
    parts.join(", ")
}

/// Text of files and programs, for a cell of a table.
fn escaped(text: &str) -> String {
    let mut escaped = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '|' | '<' | '`' | '*' | '\\' => escaped.extend(['\\', c]),
            c if c.is_control() => escaped.push(' '),
            c => escaped.push(c),
        }
    }
    escaped
}
