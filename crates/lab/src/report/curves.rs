//! A chart of curves over an axis: every process, medians with intervals, and what others have published.

use super::chart::{
    Chart, WIDTH, colour, cut, dots, horizontal_axis, line, mark, path, text, text_width, vertical_axis,
};
use super::scale::{Scale, tick_label};
use super::section::{Finding, curves};
use super::words::number;
use crate::comparison::VariantResult;
use crate::experiment::{Axis, Experiment, Published};
use maud::{Markup, html};

const LEFT: f64 = 64.0;
const RIGHT: f64 = WIDTH - 14.0;
const HEIGHT: f64 = 260.0;
/// A line of the legend.
const LINE: f64 = 19.0;
/// The most places of variants that the axis names itself.
const MAX_PLACES: usize = 9;
/// Dots of processes are this far beside their median, those of each further curve a little farther, but not beyond all of it.
const BESIDE: [f64; 2] = [7.0, 5.0];
const FARTHEST: f64 = 24.0;

/// The most that a source and its hardware take in the legend.
const MAX_SOURCE: [f64; 2] = [290.0, 210.0];

/// A point of a curve.
type Point<'a> = (f64, &'a VariantResult);

/// What of a published figure is drawn.
struct Theirs<'a> {
    source: String,
    figures: Vec<&'a Published>,
}

/// Draws the curves of a quantity. `None` where nothing was measured.
pub(super) fn curve_chart(
    experiment: &Experiment,
    axis: &Axis,
    finding: &Finding,
    findings: &[Finding],
) -> Option<Chart> {
    let results = &finding.comparison.variants;
    let all: Vec<(&str, Vec<Point>)> = curves(&experiment.variants)
        .into_iter()
        .map(|(name, numbers)| {
            let point = |number: usize| Some((experiment.variants[number].x?, results.get(number)?));
            let mut points: Vec<Point> =
                numbers.into_iter().filter_map(point).filter(|(_, result)| result.value.is_some()).collect();
            points.sort_by(|a, b| a.0.total_cmp(&b.0));
            (name, points)
        })
        .collect();
    let theirs = theirs(experiment, finding, findings);
    let figures =
        || theirs.iter().flat_map(|one| &one.figures).filter_map(|figure| Some([figure.x?, figure.value]));
    let points = || all.iter().flat_map(|(_, points)| points);
    let values = || {
        let ours = points().flat_map(|(_, result)| {
            let interval = result.value.and_then(|(_, interval)| interval).into_iter().flatten();
            result.medians.iter().copied().chain(interval)
        });
        ours.chain(figures().map(|[_, y]| y))
    };
    points().next()?;
    let legend = Legend::of(&all, &theirs);
    let top = 24.0 + legend.height;
    let bottom = top + HEIGHT;
    let xs = points().map(|(x, _)| *x).chain(figures().map(|[x, _]| x));
    let across = Scale::of(xs, axis.logarithmic, [LEFT + 8.0, RIGHT - 16.0])?;
    let up = Scale::of(values(), Scale::wants_logarithm(values()), [bottom, top])?;
    let note = if up.has_honest_lengths() { "" } else { "; does not begin at 0" };
    let drawing = html! {
        (legend.drawing)
        (text("soft", [10.0, top - 8.0], WIDTH - 20.0, &format!("{}{note}", finding.unit)))
        (vertical_axis(&up, &up.ticks(5), [LEFT, RIGHT], [top, bottom]))
        (horizontal_axis(&across, &places(&all, &across), [LEFT, RIGHT], [top, bottom]))
        (text("soft m", [(LEFT + RIGHT) / 2.0, bottom + 34.0], RIGHT - LEFT, &axis.label))
        @for (number, (_, points)) in all.iter().enumerate() { (curve([number, all.len()], points, [&across, &up])) }
        @for (number, one) in theirs.iter().enumerate() {
            @for figure in &one.figures {
                @if let Some(x) = figure.x { (mark("hollow", number + 3, [across.at(x), up.at(figure.value)], 5.5)) }
            }
        }
    };
    Some(Chart {
        title: format!("{}: {} over {}", experiment.name, finding.comparison.quantity, axis.label),
        description: description(&all, &finding.unit),
        height: bottom + 44.0,
        drawing,
    })
}

/// The places of variants, where they are few; otherwise round ones.
fn places(all: &[(&str, Vec<Point>)], across: &Scale) -> Vec<f64> {
    let mut xs: Vec<f64> = all.iter().flat_map(|(_, points)| points).map(|(x, _)| *x).collect();
    xs.sort_by(f64::total_cmp);
    xs.dedup();
    if xs.len() <= MAX_PLACES { xs } else { across.ticks(6) }
}

fn curve([number, count]: [usize; 2], points: &[Point], [across, up]: [&Scale; 2]) -> Markup {
    let class = colour(number);
    let at = |&(x, result): &Point| result.value.map(|(value, _)| [across.at(x), up.at(value)]);
    let corners: Vec<[f64; 2]> = points.iter().filter_map(at).collect();
    let commands: Vec<(&str, &[f64])> =
        corners.iter().enumerate().map(|(n, corner)| (if n == 0 { "M" } else { "L" }, &corner[..])).collect();
    let step = BESIDE[1].min((FARTHEST - BESIDE[0]) / count as f64);
    let beside = BESIDE[0] + step * number as f64;
    let processes = points
        .iter()
        .flat_map(|(x, result)| result.medians.iter().map(move |&one| [across.at(*x) + beside, up.at(one)]));
    html! {
        // Dashes tell curves apart that have the same mark.
        path class={ "curve " (class) } stroke-dasharray=[(number >= 6).then_some("6 3")] d=(path(&commands)) {}
        (dots(class, processes))
        @for (x, result) in points {
            @if let Some((value, interval)) = result.value {
                @if let Some([low, high]) = interval {
                    (line("bar", [across.at(*x), up.at(low)], [across.at(*x), up.at(high)]))
                }
                (mark(&format!("mark {class}"), number, [across.at(*x), up.at(value)], 4.5))
            }
        }
    }
}

/// Published figures that can stand among these values, by source and hardware.
fn theirs<'a>(experiment: &'a Experiment, finding: &Finding, findings: &[Finding]) -> Vec<Theirs<'a>> {
    let mut all: Vec<Theirs> = Vec::new();
    for figure in
        experiment.published.iter().filter(|figure| figure.x.is_some_and(|x| x.is_finite() && x > 0.0))
    {
        if !finding.shows(figure, findings) {
            continue;
        }
        let source =
            format!("{}, on {}", cut(&figure.source, MAX_SOURCE[0]), cut(&figure.hardware, MAX_SOURCE[1]));
        match all.iter_mut().find(|one| one.source == source) {
            Some(one) => one.figures.push(figure),
            None => all.push(Theirs { source, figures: vec![figure] }),
        }
    }
    all
}

/// Names of curves and sources above the chart.
struct Legend {
    drawing: Markup,
    height: f64,
}

impl Legend {
    fn of(all: &[(&str, Vec<Point>)], theirs: &[Theirs]) -> Legend {
        let ours = all.iter().enumerate().filter(|(_, (name, _))| !name.is_empty());
        let ours = ours.map(|(number, (name, _))| (format!("mark {}", colour(number)), number, *name));
        let published =
            theirs.iter().enumerate().map(|(number, one)| ("hollow".to_owned(), number + 3, &one.source[..]));
        let (mut x, mut y) = (LEFT, 0.0);
        let mut entries = Vec::new();
        for (class, shape, name) in ours.chain(published) {
            let width = (text_width(name) + 34.0).min(RIGHT - LEFT);
            if entries.is_empty() {
                y = LINE;
            } else if x + width > RIGHT {
                (x, y) = (LEFT, y + LINE);
            }
            entries.push((class, shape, name, [x, y - 6.0]));
            x += width;
        }
        let drawing = html! {
            @for (class, shape, name, [x, y]) in entries {
                (mark(&class, shape, [x + 5.0, y], 4.5))
                (text("", [x + 15.0, y + 4.0], RIGHT - x - 15.0, name))
            }
        };
        Legend { drawing, height: y }
    }
}

/// The numbers of a chart, for who does not see it.
fn description(all: &[(&str, Vec<Point>)], unit: &str) -> String {
    let of = |(name, points): &(&str, Vec<Point>)| {
        let [(first, begin), .., (last, end)] = points[..] else { return None };
        let value = |result: &VariantResult| result.value.map_or(String::new(), |(value, _)| number(value));
        let name = if name.is_empty() { "the curve" } else { name };
        let (first, last) = (tick_label(first), tick_label(last));
        Some(format!("{name}: from {} {unit} at {first} to {} {unit} at {last}", value(begin), value(end)))
    };
    all.iter().take(12).filter_map(of).collect::<Vec<_>>().join("; ") + "."
}
