//! Runs as Markdown.

use super::files::CHARTS;
use super::section::{Beside, Finding, Section, sections};
use super::words::{self, number, range, rate};
use crate::comparison::{VariantResult, Verdict};
use crate::machine::Machine;
use crate::records::Records;
use crate::run::CLAIM_BLOCKS;
use crate::two_runs::Change;
use std::fmt::Write;

/// What runs found, as far as they are.
pub fn markdown(runs: &[Records]) -> String {
    let (sections, ratios) = sections(runs);
    sections.iter().map(|one| section(one, ratios, false)).collect()
}

/// The file of a report, with its charts.
pub(super) fn whole(sections: &[Section], ratios: usize) -> String {
    let text: String = sections.iter().map(|one| section(one, ratios, true)).collect();
    format!("# Eosphor, measured\n\n{text}")
}

fn section(section: &Section, ratios: usize, with_charts: bool) -> String {
    let experiment = section.experiment();
    let quick = if section.records.header.is_quick { ", quickly" } else { "" };
    let mut text =
        format!("## {}{quick}\n\n{}\n\n", escaped(&experiment.name), escaped(&experiment.question));
    if section.records.header.is_quick {
        text.push_str("As a quick run it claims nothing.\n\n");
    }
    for line in section.missing() {
        let _ = writeln!(text, "- {}", escaped(&line));
    }
    if text.ends_with(".\n") {
        text.push('\n');
    }
    for finding in &section.findings {
        let _ = writeln!(text, "**{}**\n", escaped(&finding.comparison.quantity));
        if with_charts {
            for (stem, chart) in section.charts_of(finding) {
                let title = escaped(&chart.title).replace(['[', ']'], " ");
                let _ = writeln!(text, "![{title}]({CHARTS}/{stem}.svg)\n");
            }
        }
        text.push_str(&table(finding));
    }
    text.push_str(&published(&section.published()));
    let _ = writeln!(text, "{}\n", conditions(section, ratios));
    text
}

fn table(finding: &Finding) -> String {
    let comparison = &finding.comparison;
    let unit = escaped(&finding.unit);
    let mut text = format!("| variant | {unit} | 95 % | Mrays/s | processes | over | ratio | 95 % | |\n");
    text.push_str("|---|---:|---|---:|---:|---|---:|---|---|\n");
    for result in &comparison.variants {
        text.push_str(&row(result, &comparison.unit));
    }
    text.push('\n');
    for (curve, slope) in &comparison.slopes {
        let name = if curve.is_empty() { String::new() } else { format!("{}: ", escaped(curve)) };
        let interval = slope.interval.map(|[low, high]| format!(" ({low:.3} to {high:.3})"));
        let _ =
            writeln!(text, "{name}goes with the power {:.3}{}.\n", slope.slope, interval.unwrap_or_default());
    }
    if let Some(noise) = &comparison.noise {
        let [low, high] = noise.student_interval;
        let _ =
            writeln!(text, "Noise: the base over itself is {:.3} ({low:.3} to {high:.3}).\n", noise.ratio);
    }
    text
}

fn row(result: &VariantResult, unit: &str) -> String {
    let (value, interval) = match result.value {
        Some((value, interval)) => (number(value), range(interval)),
        None => ("–".into(), "–".into()),
    };
    let rate = result.value.and_then(|(value, _)| rate(value, result.work, unit));
    let rate = rate.map_or("–".to_owned(), number);
    let (ratio, of_ratio) = match &result.ratio {
        Some(ratio) => (number(ratio.ratio), range(Some(ratio.interval))),
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

/// What may be said, in words; claims are strong.
fn verdict(said: &Verdict, unit: &str) -> String {
    let words = words::verdict(said, unit);
    match said {
        Verdict::Less | Verdict::More => format!("**{words}**"),
        _ => escaped(&words),
    }
}

fn published(all: &[Beside]) -> String {
    if all.is_empty() {
        return String::new();
    }
    let mut text =
        String::from("| published | figure | hardware | source | ours | |\n|---|---:|---|---|---:|---|\n");
    for one in all {
        let figure = one.figure;
        let ours = one.ours.map_or("–".to_owned(), |(_, ours)| format!("{} {}", number(ours), figure.unit));
        let hardware = if one.is_same_hardware { "" } else { " (different hardware)" };
        let times = one.times().map(|times| format!("ours is {}× theirs{hardware}", words::ratio(times)));
        let value = format!("{} {}", figure.value, figure.unit);
        let cells =
            [&figure.what, &value, &figure.hardware, &figure.source, &ours, &times.unwrap_or_default()];
        let _ = writeln!(text, "| {} |", cells.map(|cell| escaped(cell)).join(" | "));
    }
    text + "\n"
}

/// How it was measured.
fn conditions(section: &Section, ratios: usize) -> String {
    let header = &section.records.header;
    let counts = section.counts();
    let experiment = &header.experiment;
    let code = |text: String| format!("`{}`", text.replace('`', "'").replace(char::is_control, " "));
    format!(
        "{} processes in {} of random order (seed {}), {} of them disturbed; {}. {}. A value is the median of the processes' medians; \
         intervals of 95 % are of the bootstrap over processes; a ratio is the median over blocks; claims need {CLAIM_BLOCKS} undisturbed blocks, and are corrected for the {ratios} ratios of this \
         report (Holm, 5 %).\n\nEosphor {}; {} (machine and program {}). Repeat it: {}; all have {}.",
        counts.processes,
        words::counted(counts.blocks, "block"),
        header.seed,
        counts.disturbed,
        words::repeated(experiment),
        section.load(),
        escaped(&program(section.records)),
        machine(&header.machine),
        header.id(),
        code(section.command()),
        code(words::held_command(experiment)),
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
            Some(ratio) => (number(ratio.ratio), range(Some(ratio.interval))),
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
pub(super) fn escaped(text: &str) -> String {
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
