//! The report as a page that needs no other file: no scripts, and nothing that a browser would have to fetch.

use super::chart::{COLOURS, Chart, STYLE};
use super::curves::curve_chart;
use super::files::TABLES;
use super::picture::{self, ReportPicture};
use super::rows::rows_chart;
use super::section::{Finding, Section};
use super::tables;
use super::words::{counted, machine_fields, measured, program_fields, repeated, utc};
use crate::quantity::MILLISECONDS;
use crate::records::Header;
use crate::run::CLAIM_BLOCKS;
use maud::{DOCTYPE, Markup, PreEscaped, html};
use std::collections::BTreeMap;

const STYLE_OF_PAGE: &str = include_str!("page.css");

/// The whole page.
pub(super) fn page(sections: &[Section], ratios: usize, pictures: &[ReportPicture]) -> String {
    // Runs of one program on one machine have one header that says so.
    let mut places: BTreeMap<String, &Header> = BTreeMap::new();
    for section in sections {
        places.entry(section.records.header.id()).or_insert(&section.records.header);
    }
    let is_placed = |picture: &&ReportPicture| {
        sections.iter().any(|section| section.experiment().name == picture.experiment)
    };
    let rest: Vec<&ReportPicture> = pictures.iter().filter(|picture| !is_placed(picture)).collect();
    let mut figures = 0;
    let page = html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta name="viewport" content="width=device-width, initial-scale=1";
                meta name="color-scheme" content="light dark";
                title { "Eosphor, measured" }
                style { (PreEscaped(COLOURS)) (PreEscaped(STYLE)) (PreEscaped(STYLE_OF_PAGE)) }
            }
            body {
                header {
                    h1 { "Eosphor, measured" }
                    p class="lead" {
                        "How fast the ray tracer Eosphor is, by experiments in which every measurement is a process of its own and every \
                         difference comes with how sure it is."
                    }
                    p { (began(sections)) }
                }
                main {
                    (results(sections))
                    (machines(&places))
                    (method(ratios))
                    (repeat(sections))
                    @for section in sections { (experiment(section, places.len() > 1, pictures, &mut figures)) }
                    @if !rest.is_empty() {
                        h2 { "Pictures" }
                        @for (number, one) in rest.iter().enumerate() { (picture::figure(one, &format!("p-{number}"))) }
                    }
                }
                footer { p class="small" { "Made by " code { "eosphor lab report" } ". Times are in UTC." } }
            }
        }
    };
    without_controls(page.into_string())
}

/// Text without characters that pages and pictures may not hold, and without those that turn the direction of what follows. All of
/// them come from files and programs.
pub(super) fn without_controls(text: String) -> String {
    let is_bad = |c: char| {
        let code = u32::from(c);
        (c.is_control() && c != '\n')
            || matches!(c, '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}' | '\u{fdd0}'..='\u{fdef}')
            || code & 0xfffe == 0xfffe
    };
    if text.contains(is_bad) { text.replace(is_bad, "\u{fffd}") } else { text }
}

fn began(sections: &[Section]) -> String {
    let times = || sections.iter().map(|section| section.records.header.began);
    match (times().min().map(utc), times().max().map(utc)) {
        (Some(first), Some(last)) if first == last => format!("Measured on {first}."),
        (Some(first), Some(last)) => format!("Measured in runs that began from {first} to {last}."),
        _ => "There are no runs yet.".to_owned(),
    }
}

fn results(sections: &[Section]) -> Markup {
    html! {
        nav aria-labelledby="results" {
            h2 id="results" { "Results" }
            ol class="results" {
                @for section in sections {
                    li {
                        a href={ "#e-" (section.stem) } { (section.experiment().name) }
                        @if section.records.header.is_quick { " (quick)" }
                        ": " (section.experiment().question)
                        span class="said" { (section.result()) }
                    }
                }
            }
        }
    }
}

fn machines(places: &BTreeMap<String, &Header>) -> Markup {
    html! {
        h2 { "Machine and program" }
        @if places.len() > 1 {
            p class="note" {
                "These runs come from " (places.len()) " different machines or programs. Each section says which one is its own; \
                 figures of different ones are not compared."
            }
        }
        @for (id, header) in places {
            section {
                h3 id={ "m-" (id) } { "Machine and program " code { (id) } }
                (tables::facts("The machine, as its system tells.", &machine_fields(&header.machine)))
                (tables::facts("The program that was measured.", &program_fields(&header.program)))
            }
        }
        @if !places.is_empty() {
            p class="small" {
                "The 8 digits name machine and program together: all figures with the same digits were measured by the same program on \
                 the same machine."
            }
        }
    }
}

/// For a reader who comes cold.
fn method(ratios: usize) -> Markup {
    html! {
        h2 { "How it was measured" }
        p {
            "Every measurement is a fresh process, which repeats its work and counts once: by the median of its repetitions. A block runs \
             each variant once, in a random order, so that a machine that becomes slower does so for all. A value is the median of all \
             processes; \u{201c}95 %\u{201d} is where that median lies with 95 % confidence (bootstrap over processes)."
        }
        p {
            "A ratio is the median over blocks of one variant's value over that of another, in the same block. The base runs twice in each \
             block: how far it is from itself is the noise, the shaded band of the charts. While a process runs, other programs on its cores are \
             watched. A block with such a process is disturbed: it is measured again, and left out of what is said."
        }
        p {
            "Claims are corrected for the number of all ratios of this report, which is " (ratios) " (Holm): the chance that one or more of \
             all its claims is wrong by chance is at most 5 %."
        }
        dl {
            dt { "faster, slower (less, more)" }
            dd {
                "A claim. It needs " (CLAIM_BLOCKS) " undisturbed blocks, an interval without 1, a probability by chance below 5 % after the \
                 correction (Student's test of the logarithms of the blocks' ratios), and a difference that is larger than the noise."
            }
            dt { "no difference seen" }
            dd { "These measurements do not tell the two apart. It does not mean that they are equal." }
            dt { "within the noise" }
            dd { "They differ no more than the base differs from itself. Such ratios are grey." }
            dt { "unstable" }
            dd { "Other programs ran on the cores in too many blocks. Values are shown, and nothing is claimed." }
            dt { "different answers: no ratio" }
            dd { "The two did not compute the same, though the work was the same. Answers are hashes of the picture or of all hits; times of different answers are not compared." }
            dt { "different work: no ratio" }
            dd { "The two are not about the same picture or the same number of rays, as along a curve." }
            dt { "no claim" }
            dd { "Values and ratios are shown, and nothing is said of them, for the reason that stands there." }
            dt { "quick" }
            dd { "A run with fewer blocks and less work, to see that all works. It claims nothing." }
        }
    }
}

fn repeat(sections: &[Section]) -> Markup {
    html! {
        h2 { "How to repeat it" }
        @if sections.is_empty() {
            p { "Run " code { "eosphor lab run --all" } ", then " code { "eosphor lab report" } "." }
        } @else {
            p { "With the program of the same commit (" code { "cargo build --release" } " in a checkout of it), on a machine that does nothing else; runs and report stand in the folder " code { "eosphor-lab" } ":" }
            pre { code { @for section in sections { (section.command()) "\n" } "eosphor lab report\n" } }
        }
    }
}

fn experiment(
    section: &Section,
    several_places: bool,
    pictures: &[ReportPicture],
    figures: &mut usize,
) -> Markup {
    let header = &section.records.header;
    let missing = section.missing();
    let own = pictures.iter().filter(|picture| picture.experiment == section.experiment().name);
    html! {
        section {
            h2 id={ "e-" (section.stem) } { (section.experiment().name) @if header.is_quick { " (quick)" } }
            p { strong { (section.experiment().question) } }
            p { "Result: " (section.result()) "." }
            @if header.is_quick {
                p class="note" { strong { "As a quick run it claims nothing" } ": it has fewer blocks and less work than a whole run." }
            }
            @if !missing.is_empty() {
                div class="note" { p { "What is missing:" } ul { @for line in missing { li { (line) } } } }
            }
            p { (how(section)) }
            @if several_places {
                p {
                    "Machine and program: " a href={ "#m-" (header.id()) } { (header.id()) } " ("
                    (header.machine.cpu.as_deref().unwrap_or("a processor that the system does not name"))
                    ", Eosphor " (header.program.version) ")."
                }
            }
            (tables::variants(section))
            (tables::summary(section))
            @if section.findings.is_empty() {
                p class="note" { "There is no chart: nothing was measured." }
            }
            @for finding in &section.findings { (quantity(section, finding, figures)) }
            (tables::published(section))
            @for (number, one) in own.enumerate() { (picture::figure(one, &format!("p-{}-{number}", section.stem))) }
        }
    }
}

/// How often it was measured, and beside what.
fn how(section: &Section) -> String {
    let header = &section.records.header;
    let experiment = &header.experiment;
    let counts = section.counts();
    let failed = if counts.failed > 0 { format!(" ({} failed)", counts.failed) } else { String::new() };
    let cores = match experiment.cores {
        Some(1) => " Each process may use 1 core.".to_owned(),
        Some(cores) => format!(" Each process may use {cores} cores."),
        None => String::new(),
    };
    format!(
        "{} Began {}. {} processes{failed} in {} of random order (seed {}), {} of them disturbed; {}.{cores} {}.",
        measured(experiment.measures),
        utc(header.began),
        counts.processes,
        counted(counts.blocks, "block"),
        header.seed,
        counts.disturbed,
        repeated(experiment),
        section.load()
    )
}

fn quantity(section: &Section, finding: &Finding, figures: &mut usize) -> Markup {
    let comparison = &finding.comparison;
    let charts = section.charts_of(finding);
    html! {
        h3 id={ "q-" (finding.stem) } { (comparison.quantity) }
        @for (number, (stem, chart)) in charts.iter().enumerate() {
            figure {
                div class="scroll" tabindex="0" role="region" aria-label={ "Chart: " (chart.title) } { (chart.within_page(stem)) }
                figcaption { (caption(section, finding, number, figures)) }
            }
        }
        @if charts.is_empty() { p class="note" { "There is no chart: " (section.result()) "." } }
        (tables::quantity(section, finding))
        p class="small" {
            @if let Some(noise) = &comparison.noise {
                @let [low, high] = noise.student_interval;
                "Noise: the base (" (section.experiment().base) ") over itself is " (format!("{:.3} ({low:.3} to {high:.3})", noise.ratio)) ". "
            } @else { "Noise: not measured. " }
            "All values: " a href={ (TABLES) "/" (finding.stem) ".csv" } { (TABLES) "/" (finding.stem) ".csv" } "."
        }
    }
}

/// What a chart shows and how it is read. The first one of a quantity has its values.
fn caption(section: &Section, finding: &Finding, number: usize, figures: &mut usize) -> Markup {
    *figures += 1;
    let experiment = section.experiment();
    let slopes = || finding.comparison.slopes.iter();
    let time = if finding.comparison.unit == MILLISECONDS {
        "faster, ▲\u{a0}slower"
    } else {
        "less, ▲\u{a0}more"
    };
    html! {
        "Figure " (figures) ": " (experiment.name) ", " (finding.comparison.quantity) @if number > 0 { ", ratios" } ". "
        @if number == 0 && experiment.axis.is_some() {
            "Large marks are medians, bars their intervals of 95 %, small dots to the right all processes. "
            @if experiment.published.iter().any(|figure| figure.x.is_some()) { "Hollow marks were published by others, of other hardware. " }
            @for (name, slope) in slopes() {
                @if name.is_empty() { "It" } @else { (name) }
                " goes with the power " (format!("{:.3}", slope.slope))
                @if let Some([low, high]) = slope.interval { (format!(" ({low:.3} to {high:.3})")) }
                ". "
            }
        } @else {
            @if number == 0 { "Dots are processes, ticks their medians, bars intervals of 95 %. " }
            @if finding.comparison.variants.iter().any(|result| result.ratio.is_some()) {
                "Ratios: ▼\u{a0}" (time) ", hollow: no claim; shaded: how far the base is from itself. "
            }
        }
        "Machine and program " (section.records.header.id()) "."
    }
}

impl Section<'_> {
    /// Charts with the names of their files.
    pub(super) fn charts(&self) -> Vec<(String, Chart)> {
        self.findings.iter().flat_map(|finding| self.charts_of(finding)).collect()
    }

    /// Values, and ratios where they are apart.
    pub(super) fn charts_of(&self, finding: &Finding) -> Vec<(String, Chart)> {
        let experiment = self.experiment();
        let Some(axis) = &experiment.axis else {
            let chart = rows_chart(finding, &experiment.name, true);
            return chart.map(|chart| (finding.stem.clone(), chart)).into_iter().collect();
        };
        let values = curve_chart(experiment, axis, finding, &self.findings);
        let ratios = rows_chart(finding, &experiment.name, false);
        // No name of a quantity has a point.
        let ratios = ratios.map(|chart| (format!("{}.ratios", finding.stem), chart));
        values.map(|chart| (finding.stem.clone(), chart)).into_iter().chain(ratios).collect()
    }
}
