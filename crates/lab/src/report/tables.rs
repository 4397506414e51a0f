//! Tables of the page.

use super::section::{Finding, Section};
use super::words::{held_command, number, quoted, range, rate, shortened, verdict};
use crate::comparison::{VariantResult, Verdict};
use crate::experiment::Variant;
use crate::quantity::MILLISECONDS;
use maud::{Markup, html};

/// The most characters of an answer that are shown.
const ANSWER: usize = 8;

/// Names and values, in two columns.
pub(super) fn facts(caption: &str, fields: &[(&str, String)]) -> Markup {
    html! {
        div class="scroll" {
            table class="facts" {
                caption { span { (caption) } }
                tbody { @for (name, value) in fields { tr { th scope="row" { (name) } td { (value) } } } }
            }
        }
    }
}

/// The first cell of a row.
fn name(text: &str) -> Markup {
    html! { th scope="row" class=(breaks(text)) { (text) } }
}

/// Short names stay on their line.
fn breaks(text: &str) -> &'static str {
    if text.chars().count() > 22 { "long" } else { "i" }
}

/// A quantity: all that was found of each variant.
pub(super) fn quantity(section: &Section, finding: &Finding) -> Markup {
    let comparison = &finding.comparison;
    let results = &comparison.variants;
    let has_rate = comparison.unit == MILLISECONDS && results.iter().any(|result| result.work.is_some());
    let has_answer = results.iter().any(|result| !result.answers.is_empty());
    let has_hits = results.iter().any(|result| !result.hits.is_empty());
    html! {
        div class="scroll" tabindex="0" role="region" aria-label={ "Table of " (comparison.quantity) } {
            table {
                caption {
                    span {
                        (comparison.quantity) " in " (finding.unit) "; less is better. Machine and program "
                        (section.records.header.id()) "."
                    }
                }
                thead {
                    tr {
                        th scope="col" { "Variant" }
                        th scope="col" class="n" { "Median, " (finding.unit) }
                        th scope="col" { "95 %" }
                        @if has_rate { th scope="col" class="n" { "Mrays/s" } }
                        th scope="col" class="n" { "Ratio" }
                        th scope="col" { "95 %" }
                        th scope="col" { "Over" }
                        th scope="col" { "What may be said" }
                        th scope="col" class="n" { "Processes" }
                        @if has_answer { th scope="col" class="n" { "Answer" } }
                        @if has_hits { th scope="col" { "Hits; unlike ours" } }
                    }
                }
                tbody { @for result in results { (row(finding, result, [has_rate, has_answer, has_hits])) } }
            }
        }
    }
}

fn row(finding: &Finding, result: &VariantResult, [has_rate, has_answer, has_hits]: [bool; 3]) -> Markup {
    let unit = &finding.comparison.unit;
    let rate = result.value.and_then(|(value, _)| rate(value, result.work, unit));
    let is_faint = result.ratio.as_ref().is_some_and(|ratio| finding.is_within_noise(ratio.ratio));
    let dash = || "–".to_owned();
    let grey = is_faint.then_some("grey");
    html! {
        tr {
            (name(&result.variant))
            td class="n" { (result.value.map_or_else(dash, |(value, _)| number(value))) }
            td class="i" { (range(result.value.and_then(|(_, interval)| interval))) }
            @if has_rate { td class="n" { (rate.map_or_else(dash, number)) } }
            @if let Some(ratio) = &result.ratio {
                td class={ "n " (grey.unwrap_or_default()) } { (number(ratio.ratio)) }
                td class={ "i " (grey.unwrap_or_default()) } { (range(Some(ratio.interval))) }
                td class={ (breaks(result.against.as_deref().unwrap_or("–"))) " " (grey.unwrap_or_default()) } { (result.against.as_deref().unwrap_or("–")) }
            } @else {
                td class="n" { "–" } td { "–" } td { "–" }
            }
            td class=(class(&result.verdict)) { (sign(&result.verdict)) (verdict(&result.verdict, unit)) }
            td class="n" { (result.medians.len()) }
            @if has_answer { td class="n" { (answers(result)) } }
            @if has_hits { td class="i" { (hits(result)) } }
        }
    }
}

/// A sign before words, which are enough without it.
fn sign(verdict: &Verdict) -> Markup {
    let sign = match verdict {
        Verdict::Less => "▼ ",
        Verdict::More => "▲ ",
        _ => "",
    };
    html! { @if !sign.is_empty() { span aria-hidden="true" { (sign) } } }
}

fn class(verdict: &Verdict) -> &'static str {
    match verdict {
        Verdict::Less => "less",
        Verdict::More => "more",
        Verdict::WithinNoise => "grey",
        Verdict::NotMeasured(_) | Verdict::OtherAnswers | Verdict::OtherWork => "wide missing",
        _ => "wide",
    }
}

fn answers(result: &VariantResult) -> Markup {
    html! {
        @if result.answers.is_empty() { "–" }
        @for (number, answer) in result.answers.iter().take(3).enumerate() {
            @if number > 0 { ", " }
            code { (shortened(answer, ANSWER)) }
        }
        @if result.answers.len() > 3 { " and " (result.answers.len() - 3) " more" }
    }
}

fn hits(result: &VariantResult) -> String {
    let of = |[hits, different]: &[u64; 2]| format!("{hits}; {different}");
    let all: Vec<String> = result.hits.iter().take(3).map(of).collect();
    if all.is_empty() { "–".to_owned() } else { all.join(", ") }
}

/// All quantities of all variants beside each other, where there are several.
pub(super) fn summary(section: &Section) -> Markup {
    html! {
        @if section.findings.len() > 1 {
            div class="scroll" tabindex="0" role="region" aria-label="Summary" {
                table {
                    caption {
                        span {
                            "Medians with their intervals of 95 %" @if has_rates(section) { "; below, millions of rays a second" }
                            ". Machine and program " (section.records.header.id()) "."
                        }
                    }
                    thead {
                        tr {
                            th scope="col" { "Variant" }
                            @for finding in &section.findings {
                                th scope="col" { (finding.comparison.quantity) ", " (finding.unit) }
                            }
                        }
                    }
                    tbody {
                        @for (number, variant) in section.experiment().variants.iter().enumerate() {
                            tr {
                                (name(&variant.name))
                                @for finding in &section.findings { td class="i" { (summary_cell(finding, number)) } }
                            }
                        }
                    }
                }
            }
        }
    }
}

fn has_rates(section: &Section) -> bool {
    let has_work = |finding: &Finding| finding.comparison.variants.iter().any(|result| result.work.is_some());
    section.findings.iter().any(|finding| finding.comparison.unit == MILLISECONDS && has_work(finding))
}

fn summary_cell(finding: &Finding, variant: usize) -> Markup {
    let result = finding.comparison.variants.get(variant);
    let value = result.and_then(|result| Some((result, result.value?)));
    html! {
        @if let Some((result, (value, interval))) = value {
            strong { (number(value)) }
            @if let Some([low, high]) = interval { " [" (number(low)) ", " (number(high)) "]" }
            @if let Some(rate) = rate(value, result.work, &finding.comparison.unit) {
                br; span class="small" { (number(rate)) " Mrays/s" }
            }
        } @else { "–" }
    }
}

/// What each variant runs.
pub(super) fn variants(section: &Section) -> Markup {
    let experiment = section.experiment();
    html! {
        p { "All variants run " code { (held_command(experiment)) } @if has_programs(experiment) { ", unless they name a program" } ", and:" }
        div class="scroll" tabindex="0" role="region" aria-label="What each variant runs" {
            table {
                caption { span { "What each variant runs." } }
                thead { tr { th scope="col" { "Variant" } th scope="col" { "Arguments" } th scope="col" { "Compared with" } } }
                tbody {
                    @for variant in &experiment.variants {
                        tr {
                            (name(&variant.name))
                            td class="words" { code { (arguments(variant)) } }
                            td class=(breaks(experiment.against(variant).unwrap_or_default())) { (experiment.against(variant).unwrap_or("it is the base")) }
                        }
                    }
                }
            }
        }
    }
}

fn has_programs(experiment: &crate::experiment::Experiment) -> bool {
    experiment.variants.iter().any(|variant| variant.program.is_some())
}

fn arguments(variant: &Variant) -> String {
    let words = variant.launcher.iter().chain(&variant.program).chain(&variant.arguments);
    let words: Vec<String> = words.map(|word| quoted(word)).collect();
    if words.is_empty() { "no more".to_owned() } else { shortened(&words.join(" "), 300) }
}

/// What others have published, with ours beside it.
pub(super) fn published(section: &Section) -> Markup {
    let all = section.published();
    html! {
        @if !all.is_empty() {
            h3 { "Published figures" }
            div class="scroll" tabindex="0" role="region" aria-label="Published figures" {
                table {
                    caption {
                        span {
                            "What others have published, with what was measured here beside it. Where the hardware differs, a ratio is \
                             of hardware and program together. Machine and program of ours: " (section.records.header.id()) "."
                        }
                    }
                    thead {
                        tr {
                            th scope="col" { "What" }
                            th scope="col" class="n" { "Theirs" }
                            th scope="col" { "Their hardware" }
                            th scope="col" { "Source" }
                            th scope="col" class="n" { "Ours" }
                            th scope="col" { "Ours over theirs" }
                        }
                    }
                    tbody {
                        @for one in &all {
                            tr {
                                (name(&one.figure.what))
                                td class="n" { (one.figure.value) " " (one.figure.unit) }
                                td class="wide" { (one.figure.hardware) }
                                td class="wide" { (one.figure.source) }
                                @if let Some((quantity, ours)) = one.ours {
                                    td class="n" { (number(ours)) " " (one.figure.unit) br; span class="small" { (quantity) } }
                                } @else { td class="n" { "–" } }
                                td class="wide" {
                                    @if let Some(times) = one.times() {
                                        "ours is " (super::words::ratio(times)) "× theirs"
                                        @if !one.is_same_hardware { " (different hardware)" }
                                    } @else { "–" }
                                }
                            }
                        }
                    }
                }
            }
        }
    }
}
