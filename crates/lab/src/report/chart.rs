//! A chart as SVG, within a page or as a file of its own, and what charts are drawn with.

use super::scale::{Scale, tick_label};
use super::words::shortened;
use maud::{Markup, PreEscaped, Render, html};
use std::fmt::Write;

/// The width of all charts.
pub(super) const WIDTH: f64 = 640.0;

/// Colours for both themes, and the way in which charts use them.
pub(super) const COLOURS: &str = include_str!("colours.css");
pub(super) const STYLE: &str = include_str!("chart.css");

/// Different colours and marks of charts.
const COLOUR_COUNT: usize = 6;

/// A drawn chart.
pub(super) struct Chart {
    /// What it shows, for who does not see it: in a line, and in sentences.
    pub(super) title: String,
    pub(super) description: String,
    pub(super) height: f64,
    pub(super) drawing: Markup,
}

impl Chart {
    /// Its size, and what it is called.
    fn view_box(&self) -> String {
        format!("0 0 {WIDTH} {}", self.height)
    }

    /// As a part of a page that has the styles; the stem makes its names unique there.
    pub(super) fn within_page(&self, stem: &str) -> Markup {
        html! {
            svg class="chart" viewBox=(self.view_box()) role="img" aria-labelledby={ "t-" (stem) " d-" (stem) } {
                title id={ "t-" (stem) } { (self.title) }
                desc id={ "d-" (stem) } { (self.description) }
                (self.drawing)
            }
        }
    }

    /// As a file of its own.
    pub(super) fn alone(&self) -> String {
        let svg = html! {
            svg class="chart" xmlns="http://www.w3.org/2000/svg" width=(WIDTH) height=(self.height) viewBox=(self.view_box())
                role="img" aria-labelledby="t d" {
                title id="t" { (self.title) }
                desc id="d" { (self.description) }
                style { (PreEscaped(COLOURS)) (PreEscaped(STYLE)) }
                rect class="paper" width="100%" height="100%" {}
                (self.drawing)
            }
        };
        svg.into_string() + "\n"
    }
}

/// A place on paper: a tenth is enough.
pub(super) struct Place(pub(super) f64);

impl Render for Place {
    fn render_to(&self, buffer: &mut String) {
        // Not `-0`.
        let rounded = (self.0 * 10.0).round() / 10.0 + 0.0;
        let _ = write!(buffer, "{rounded}");
    }
}

/// The path of commands with places.
pub(super) fn path(parts: &[(&str, &[f64])]) -> String {
    let mut text = String::new();
    for (command, places) in parts {
        text.push_str(command);
        for (number, place) in places.iter().enumerate() {
            if number > 0 {
                text.push(' ');
            }
            Place(*place).render_to(&mut text);
        }
    }
    text
}

/// A straight line.
pub(super) fn line(class: &str, from: [f64; 2], to: [f64; 2]) -> Markup {
    html! { path class=(class) d=(path(&[("M", &from), ("L", &to)])) {} }
}

/// Small marks, as one path.
pub(super) fn dots(class: &str, places: impl Iterator<Item = [f64; 2]>) -> Markup {
    let mut text = String::new();
    for place in places {
        text.push_str(&path(&[("M", &place), ("h0", &[])]));
    }
    html! { @if !text.is_empty() { path class={ "dots " (class) } d=(text) {} } }
}

/// The class of the colour of a curve.
pub(super) fn colour(number: usize) -> &'static str {
    ["c0", "c1", "c2", "c3", "c4", "c5"][number % COLOUR_COUNT]
}

/// A mark whose shape tells curves apart without their colours.
pub(super) fn mark(class: &str, shape: usize, [x, y]: [f64; 2], size: f64) -> Markup {
    let r = size;
    let d = match shape % COLOUR_COUNT {
        0 => path(&[
            ("M", &[x - r, y]),
            ("a", &[r, r, 0.0, 1.0, 0.0, 2.0 * r, 0.0]),
            ("a", &[r, r, 0.0, 1.0, 0.0, -2.0 * r, 0.0]),
            ("z", &[]),
        ]),
        1 => path(&[
            ("M", &[x - 0.9 * r, y - 0.9 * r]),
            ("h", &[1.8 * r]),
            ("v", &[1.8 * r]),
            ("h", &[-1.8 * r]),
            ("z", &[]),
        ]),
        2 => path(&[("M", &[x, y - 1.2 * r]), ("l", &[1.15 * r, 2.1 * r]), ("h", &[-2.3 * r]), ("z", &[])]),
        3 => path(&[
            ("M", &[x, y - 1.3 * r]),
            ("l", &[1.3 * r, 1.3 * r]),
            ("l", &[-1.3 * r, 1.3 * r]),
            ("l", &[-1.3 * r, -1.3 * r]),
            ("z", &[]),
        ]),
        4 => path(&[("M", &[x, y + 1.2 * r]), ("l", &[1.15 * r, -2.1 * r]), ("h", &[-2.3 * r]), ("z", &[])]),
        _ => {
            let (a, b) = (0.45 * r, 1.25 * r);
            let arm = b - a;
            path(&[
                ("M", &[x - a, y - b]),
                ("h", &[2.0 * a]),
                ("v", &[arm]),
                ("h", &[arm]),
                ("v", &[2.0 * a]),
                ("h", &[-arm]),
                ("v", &[arm]),
                ("h", &[-2.0 * a]),
                ("v", &[-arm]),
                ("h", &[-arm]),
                ("v", &[-2.0 * a]),
                ("h", &[arm]),
                ("z", &[]),
            ])
        }
    };
    html! { path class=(class) d=(d) {} }
}

/// Text that begins, ends (`e`) or has its middle (`m`) at a place; it is cut to a width, and its whole is told beside it.
pub(super) fn text(class: &str, [x, y]: [f64; 2], width: f64, text: &str) -> Markup {
    let cut = cut(text, width);
    html! {
        text class=[(!class.is_empty()).then_some(class)] x=(Place(x)) y=(Place(y)) {
            @if cut != text { title { (text) } }
            (cut)
        }
    }
}

/// The width of text, about: which font it will have is not known here.
pub(super) fn text_width(text: &str) -> f64 {
    let of = |c: char| match c {
        'i' | 'j' | 'l' | 'I' | '.' | ',' | ':' | ';' | '\'' | '|' | '!' => 3.6,
        'm' | 'w' | 'M' | 'W' | '@' | '%' => 12.0,
        c if c.is_ascii_uppercase() => 8.6,
        c if c.is_ascii() => 7.5,
        '\u{1100}'.. => 12.5,
        _ => 7.6,
    };
    text.chars().map(of).sum()
}

/// The beginning of a text that is no wider, about.
pub(super) fn cut(text: &str, width: f64) -> String {
    if text_width(text) <= width {
        return text.to_owned();
    }
    let mut most = text.chars().count();
    let mut short = text.to_owned();
    while most > 1 && text_width(&short) > width {
        most -= 1;
        short = shortened(text, most);
    }
    short
}

/// The names of an axis below it, with lines up to the top: those that there is room for.
pub(super) fn horizontal_axis(
    scale: &Scale,
    ticks: &[f64],
    [left, right]: [f64; 2],
    [top, bottom]: [f64; 2],
) -> Markup {
    let mut end = f64::NEG_INFINITY;
    let mut named = Vec::new();
    for &tick in ticks {
        let (x, label) = (scale.at(tick), tick_label(tick));
        let half = text_width(&label) / 2.0;
        if x - half > end + 4.0 {
            end = x + half;
            named.push((x, label));
        }
    }
    let grid: String =
        ticks.iter().map(|&tick| path(&[("M", &[scale.at(tick), top]), ("V", &[bottom])])).collect();
    html! {
        path class="grid" d=(grid) {}
        (line("axis", [left, bottom], [right, bottom]))
        @for (x, label) in named { text class="m" x=(Place(x)) y=(Place(bottom + 15.0)) { (label) } }
    }
}

/// The names of an axis to its left, with lines to the right.
pub(super) fn vertical_axis(
    scale: &Scale,
    ticks: &[f64],
    [left, right]: [f64; 2],
    [top, bottom]: [f64; 2],
) -> Markup {
    let grid: String =
        ticks.iter().map(|&tick| path(&[("M", &[left, scale.at(tick)]), ("H", &[right])])).collect();
    html! {
        path class="grid" d=(grid) {}
        (line("axis", [left, top], [left, bottom]))
        @for &tick in ticks { text class="e" x=(Place(left - 6.0)) y=(Place(scale.at(tick) + 4.0)) { (tick_label(tick)) } }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn long_names_are_cut_and_told() {
        let drawn = text("", [1.04, -0.01], 60.0, "a name that is long <").into_string();
        assert_eq!(drawn, r#"<text x="1" y="0"><title>a name that is long &lt;</title>a nam…</text>"#);
        assert_eq!(
            text("e", [0.0; 2], 60.0, "short").into_string(),
            r#"<text class="e" x="0" y="0">short</text>"#
        );
        assert!(cut("文文文文文文", 40.0).chars().count() == 3);
    }
}
