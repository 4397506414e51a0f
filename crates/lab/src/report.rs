//! Runs as text: tables in Markdown.

use crate::comparison::{Comparison, VariantResult, Verdict, compare};
use crate::experiment::{Clock, Experiment, Published};
use crate::machine::Machine;
use crate::quantity::MILLISECONDS;
use crate::records::{Outcome, Records};
use crate::run::CLAIM_BLOCKS;
use crate::statistics::median;
use crate::two_runs::Change;
use std::fmt::Write;

/// What runs found, as far as they are.
pub fn markdown(runs: &[Records]) -> String {
    let compared = compare(runs);
    let claims = compared.iter().flatten().flat_map(|one| &one.variants).filter(|one| one.ratio.is_some());
    let claims = claims.count();
    runs.iter().zip(&compared).map(|(records, comparisons)| section(records, comparisons, claims)).collect()
}

fn section(records: &Records, comparisons: &[Comparison], claims: usize) -> String {
    let experiment = &records.header.experiment;
    let quick = if records.header.is_quick { ", quickly" } else { "" };
    let mut text = format!("## {}{quick}\n\n{}\n\n", experiment.name, escaped(&experiment.question));
    for comparison in comparisons {
        let _ = writeln!(text, "**{}**\n", escaped(&comparison.quantity));
        text.push_str(&table(experiment, comparison));
    }
    text.push_str(&published(&experiment.published));
    let _ = writeln!(text, "{}\n", conditions(records, claims));
    text
}

fn table(experiment: &Experiment, comparison: &Comparison) -> String {
    let unit = match (experiment.clock, &comparison.unit[..]) {
        (Clock::Cpu, MILLISECONDS) => "CPU ms",
        (_, unit) => unit,
    };
    let mut text =
        format!("| variant | {} | 95 % | Mrays/s | processes | over | ratio | 95 % | |\n", escaped(unit));
    text.push_str("|---|---:|---|---:|---:|---|---:|---|---|\n");
    for result in &comparison.variants {
        text.push_str(&row(result, &comparison.unit));
    }
    text.push('\n');
    for (curve, slope) in &comparison.slopes {
        let name = if curve.is_empty() { String::new() } else { format!("{}: ", escaped(curve)) };
        let interval = slope.interval.map(|[low, high]| format!(" ({low:.3} to {high:.3})"));
        let _ = writeln!(
            text,
            "{name}grows with the power {:.3}{}.\n",
            slope.slope,
            interval.unwrap_or_default()
        );
    }
    if let Some(noise) = &comparison.noise {
        let [low, high] = noise.student_interval;
        let _ =
            writeln!(text, "Noise: the base over itself is {:.3} ({low:.3} to {high:.3}).\n", noise.ratio);
    }
    text
}

/// So many digits that four count.
pub(crate) fn number(value: f64) -> String {
    let digits = (3.0 - value.abs().max(1e-12).log10().floor()).clamp(0.0, 9.0) as usize;
    format!("{value:.digits$}")
}

fn range(interval: Option<[f64; 2]>) -> String {
    interval.map_or("–".to_owned(), |[low, high]| format!("{} to {}", number(low), number(high)))
}

fn row(result: &VariantResult, unit: &str) -> String {
    let (value, interval) = match result.value {
        Some((value, interval)) => (number(value), range(interval)),
        None => ("–".into(), "–".into()),
    };
    let rate = result.value.zip(result.work).filter(|_| unit == MILLISECONDS);
    let rate = rate.map_or("–".to_owned(), |((ms, _), work)| number(work as f64 * 1e-3 / ms));
    let (ratio, of_ratio) = match &result.ratio {
        Some(ratio) => (format!("{:.3}", ratio.ratio), range(Some(ratio.interval))),
        None => ("–".into(), "–".into()),
    };
    let against = result.against.as_deref().filter(|_| result.ratio.is_some()).unwrap_or("–");
    let mut verdict = verdict(&result.verdict, unit);
    for [hits, different] in &result.hits {
        let _ = write!(verdict, "; {hits} hits, {different} answers other than ours");
    }
    let (name, count) = (escaped(&result.variant), result.medians.len());
    format!(
        "| {name} | {value} | {interval} | {rate} | {count} | {} | {ratio} | {of_ratio} | {verdict} |\n",
        escaped(against)
    )
}

/// What may be said, in words.
pub(crate) fn verdict(verdict: &Verdict, unit: &str) -> String {
    let is_time = unit == MILLISECONDS;
    match verdict {
        Verdict::Base => "base".to_owned(),
        Verdict::Less => if is_time { "**faster**" } else { "**less**" }.to_owned(),
        Verdict::More => if is_time { "**slower**" } else { "**more**" }.to_owned(),
        Verdict::NoDifferenceSeen => "no difference seen".to_owned(),
        Verdict::WithinNoise => "within the noise".to_owned(),
        Verdict::NoClaim(why) => format!("no claim: {why}"),
        Verdict::OtherWork => "other work: no ratio".to_owned(),
        Verdict::OtherAnswers => "other answers: no ratio".to_owned(),
        Verdict::NotMeasured(why) => format!("not measured: {}", escaped(why)),
    }
}

fn published(figures: &[Published]) -> String {
    if figures.is_empty() {
        return String::new();
    }
    let mut text =
        String::from("| published | figure | hardware | source | beside ours |\n|---|---:|---|---|---|\n");
    for Published { source, what, hardware, value, unit, beside, .. } in figures {
        let beside = beside.as_deref().unwrap_or("–");
        let cells = [what, &format!("{value} {unit}"), hardware, source, beside].map(|cell| escaped(cell));
        let _ = writeln!(text, "| {} |", cells.join(" | "));
    }
    text + "\n"
}

/// How it was measured.
fn conditions(records: &Records, claims: usize) -> String {
    let header = &records.header;
    let blocks = records.records.iter().map(|record| record.block + 1).max().unwrap_or(0);
    let disturbed = (0..blocks).filter(|&block| records.is_disturbed(block)).count();
    let measured = records.records.iter().filter_map(|record| match &record.outcome {
        Outcome::Measured(measured) => measured.load,
        Outcome::Failed(_) => None,
    });
    let (others, elsewhere): (Vec<f64>, Vec<f64>) =
        measured.map(|load| (load.other_cores, load.elsewhere_cores)).unzip();
    let said =
        |loads: &[f64]| median(loads).map_or("not known".to_owned(), |load| format!("{load:.2} cores"));
    let experiment = &header.experiment;
    let quick = if header.is_quick { " --quick" } else { "" };
    format!(
        "{} processes in {blocks} blocks of random order (seed {}), {disturbed} of them disturbed; {} repetitions in each process, \
         after one to warm up. Other work on the same cores: {} in the median; on the other cores: {}. A value is the median of the \
         processes' medians; intervals of 95 % are of the bootstrap over processes; a ratio is the median over blocks; claims need \
         {CLAIM_BLOCKS} undisturbed blocks, and are corrected for the {claims} ratios of this report (Holm, 5 %).\n\nEosphor {}; {} \
         (machine and program {}). Repeat it: `eosphor lab run{quick} {}`; all have `{}`.",
        records.records.len(),
        header.seed,
        experiment.repeats,
        said(&others),
        said(&elsewhere),
        program(records),
        machine(&header.machine),
        header.id(),
        experiment.name,
        experiment.held.join(" ").replace('`', "'"),
    )
}

fn program(records: &Records) -> String {
    let program = &records.header.program;
    let commit = program.commit.as_ref().map_or(String::new(), |commit| format!(" at {commit}"));
    format!("{}{commit} ({}, {})", program.version, program.compiler, program.profile)
}

/// Two runs beside each other.
pub fn changes_markdown(changes: &[Change]) -> String {
    let mut text = String::from(
        "| experiment | variant | quantity | second over first | 95 % | |\n|---|---|---|---:|---|---|\n",
    );
    for Change { experiment, variant, quantity, unit, ratio, verdict: said } in changes {
        let (value, interval) = match ratio {
            Some(ratio) => (format!("{:.3}", ratio.ratio), range(Some(ratio.interval))),
            None => ("–".into(), "–".into()),
        };
        let [experiment, variant, quantity] = [experiment, variant, quantity].map(|cell| escaped(cell));
        let _ = writeln!(
            text,
            "| {experiment} | {variant} | {quantity} | {value} | {interval} | {} |",
            verdict(said, unit)
        );
    }
    text
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
    for gpu in &machine.gpus {
        let fields = [&gpu.name, &gpu.memory, &gpu.clock, &gpu.power_limit].map(|field| escaped(field));
        parts.push(format!("{}, driver {}", fields.join(", "), escaped(&gpu.driver)));
    }
    parts.join(", ")
}

/// Text of files and programs, for a cell of a table.
pub(crate) fn escaped(text: &str) -> String {
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
