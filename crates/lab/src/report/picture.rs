//! Pictures in a report, that are looked at one after the other in the same place, without scripts.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use maud::{Markup, html};

/// A picture of a report, or two that are compared.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ReportPicture {
    /// The experiment that it belongs to; where there is none of this name, it stands at the end.
    pub experiment: String,
    /// What it shows.
    pub title: String,
    /// What there is to see: which one is A and which one B.
    pub caption: String,
    /// A file in the PNG format.
    pub a_png: Vec<u8>,
    /// What A is compared with.
    pub b_png: Option<Vec<u8>>,
    /// A map of the differences.
    pub heat_png: Option<Vec<u8>>,
}

/// The picture with buttons that choose what is seen. On paper all are seen, one below the other.
pub(super) fn figure(picture: &ReportPicture, stem: &str) -> Markup {
    let b = picture.b_png.as_deref().map(|png| ("B", png));
    let heat = picture.heat_png.as_deref().map(|png| ("Difference", png));
    let views: Vec<(&str, &[u8])> = [("A", &picture.a_png[..])].into_iter().chain(b).chain(heat).collect();
    html! {
        figure class="picture" {
            // What is chosen comes before what it shows: styles only look forward.
            @if views.len() > 1 {
                @for (number, (name, _)) in views.iter().enumerate() {
                    input type="radio" name=(stem) id={ (stem) "-" (number) } class={ "v" (number) } checked[number == 0];
                    label for={ (stem) "-" (number) } { (name) }
                }
            }
            @for (number, (name, png)) in views.iter().enumerate() {
                div class={ "view w" (number) } {
                    @if views.len() > 1 { p class="paper-only" { (name) } }
                    img alt={ (picture.title) @if views.len() > 1 { ", " (name) } } src={ "data:image/png;base64," (STANDARD.encode(png)) };
                }
            }
            figcaption { strong { (picture.title) } " " (picture.caption) }
        }
    }
}
