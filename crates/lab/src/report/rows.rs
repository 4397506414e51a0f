//! A chart with a row for each variant: every process, median and interval, and the ratio to what it is compared with.

use super::chart::{Chart, Place, WIDTH, dots, horizontal_axis, line, mark, text, text_width};
use super::scale::Scale;
use super::section::Finding;
use super::words::number;
use crate::comparison::{VariantResult, Verdict};
use maud::{Markup, html};

const ROW: f64 = 22.0;
const TOP: f64 = 26.0;
const BOTTOM: f64 = 24.0;
/// Between panels.
const GAP: f64 = 14.0;
/// The most that names take, and what a value takes beside its panel.
const MAX_NAMES: f64 = 170.0;
const VALUE: f64 = 62.0;

/// Draws values and ratios, or ratios alone. `None` where there is nothing to draw.
pub(super) fn rows_chart(finding: &Finding, experiment: &str, with_values: bool) -> Option<Chart> {
    let results = &finding.comparison.variants;
    let has_ratios = results.iter().any(|result| result.ratio.is_some());
    let shown: Vec<&VariantResult> =
        results.iter().filter(|result| with_values || result.ratio.is_some()).collect();
    if shown.is_empty() || !(has_ratios || results.iter().any(|result| result.value.is_some() && with_values))
    {
        return None;
    }
    let bottom = TOP + ROW * shown.len() as f64;
    let names = shown.iter().map(|result| text_width(&result.variant)).fold(30.0, f64::max).min(MAX_NAMES);
    let left = names + 10.0;
    // What is left is shared, with less for ratios.
    let right = WIDTH - 10.0;
    let ratio_width = match (with_values, has_ratios) {
        (true, true) => 0.36 * (right - left),
        (true, false) => -GAP,
        (false, _) => right - left - VALUE,
    };
    let values_end = right - ratio_width - GAP - VALUE;
    let ratios_start = if with_values { right - ratio_width } else { left };
    let middle = |row: usize| TOP + ROW * (row as f64 + 0.5);
    let values = || {
        shown.iter().flat_map(|result| {
            let interval = result.value.and_then(|(_, interval)| interval).into_iter().flatten();
            result.medians.iter().copied().chain(interval)
        })
    };
    let value_scale = with_values
        .then(|| Scale::of(values(), Scale::wants_logarithm(values()), [left, values_end]))
        .flatten();
    let ratios = shown.iter().filter_map(|result| result.ratio.as_ref());
    let ratios = ratios.flat_map(|ratio| ratio.interval.into_iter().chain([ratio.ratio]));
    let ratios = ratios.chain([1.0]).chain(finding.noise_band().into_iter().flatten());
    let ratio_ends = [ratios_start, ratios_start + ratio_width];
    let ratio_scale = has_ratios.then(|| Scale::of(ratios, true, ratio_ends)).flatten();
    let heights = [TOP, bottom];
    let drawing = html! {
        @if let Some(scale) = &value_scale {
            (text("soft", [left, 14.0], values_end - left + VALUE, &value_title(&finding.unit, scale)))
            (horizontal_axis(scale, &scale.ticks(4), [left, values_end], heights))
        }
        @if let Some(scale) = &ratio_scale {
            @if let Some([low, high]) = finding.noise_band() {
                rect class="band" x=(Place(scale.at(low))) y=(Place(TOP)) height=(Place(bottom - TOP))
                    width=(Place(scale.at(high) - scale.at(low))) {}
            }
            (text("soft", [ratio_ends[0], 14.0], WIDTH - ratio_ends[0], "ratio (shaded: noise)"))
            (horizontal_axis(scale, &scale.ticks(if with_values { 3 } else { 6 }), ratio_ends, heights))
            (line("one", [scale.at(1.0), TOP], [scale.at(1.0), bottom]))
        }
        @for (row, result) in shown.iter().enumerate() {
            (text("e", [left - 8.0, middle(row) + 4.0], names, &result.variant))
            @if let Some(scale) = &value_scale { (value_row(scale, result, middle(row), values_end)) }
            @if let Some(scale) = &ratio_scale { (ratio_row(scale, finding, result, middle(row), with_values)) }
        }
    };
    let quantity = &finding.comparison.quantity;
    let what = if with_values { format!("in {}", finding.unit) } else { "as ratios".to_owned() };
    Some(Chart {
        title: format!("{experiment}: {quantity} {what}"),
        description: description(&shown, &finding.unit, with_values),
        height: bottom + BOTTOM,
        drawing,
    })
}

fn value_title(unit: &str, scale: &Scale) -> String {
    let note = if scale.has_honest_lengths() { "" } else { "; does not begin at 0" };
    format!("{unit}{note}")
}

fn value_row(scale: &Scale, result: &VariantResult, y: f64, end: f64) -> Markup {
    let colour = if result.verdict == Verdict::Base { "k" } else { "c0" };
    html! {
        @if let Some((value, interval)) = result.value {
            (dots(colour, result.medians.iter().map(|&one| [scale.at(one), y])))
            @if let Some([low, high]) = interval { (line("bar", [scale.at(low), y], [scale.at(high), y])) }
            (line("bar", [scale.at(value), y - 6.0], [scale.at(value), y + 6.0]))
            text class="e" x=(Place(end + VALUE)) y=(Place(y + 4.0)) { (number(value)) }
        } @else {
            text class="soft" x=(Place(scale.at(0.0) + 4.0)) y=(Place(y + 4.0)) { "not measured" }
        }
    }
}

/// A filled mark is a claim: it points to less or to more. A hollow one is none.
fn ratio_row(scale: &Scale, finding: &Finding, result: &VariantResult, y: f64, with_values: bool) -> Markup {
    let why = match &result.verdict {
        Verdict::OtherAnswers => "other answers",
        Verdict::OtherWork => "other work",
        _ => "",
    };
    html! {
        @if let Some(ratio) = &result.ratio {
            @let [low, high] = ratio.interval;
            @let x = scale.at(ratio.ratio);
            @let is_faint = finding.is_within_noise(ratio.ratio);
            (line(if is_faint { "bar faint" } else { "bar" }, [scale.at(low), y], [scale.at(high), y]))
            @match &result.verdict {
                Verdict::Less => (mark("mark c0", 4, [x, y], 5.0)),
                Verdict::More => (mark("mark c1", 2, [x, y], 5.0)),
                _ if is_faint => (mark("hollow faint", 0, [x, y], 3.5)),
                _ => (mark("hollow", 0, [x, y], 3.5)),
            }
            @if !with_values {
                text class="e" x=(Place(WIDTH - 10.0)) y=(Place(y + 4.0)) { (format!("{:.3}", ratio.ratio)) }
            }
        } @else if !why.is_empty() {
            text class="soft m" x=(Place(scale.middle())) y=(Place(y + 4.0)) { (why) }
        }
    }
}

/// The numbers of a chart, for who does not see it.
fn description(shown: &[&VariantResult], unit: &str, with_values: bool) -> String {
    let of = |result: &&VariantResult| {
        let name = &result.variant;
        let value = match result.value.filter(|_| with_values) {
            Some((value, _)) => format!(" {} {unit}", number(value)),
            None => String::new(),
        };
        let ratio = result.ratio.as_ref().map(|ratio| {
            let against = result.against.as_deref().unwrap_or_default();
            format!(", {:.3} of {against}", ratio.ratio)
        });
        format!("{name}:{value}{}", ratio.unwrap_or_default())
    };
    const MOST: usize = 12;
    let mut text = shown.iter().take(MOST).map(of).collect::<Vec<_>>().join("; ");
    if shown.len() > MOST {
        text.push_str("; the table has the others");
    }
    text + "."
}
