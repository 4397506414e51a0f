//! How far a render is: a bar on a terminal, plain lines elsewhere.

use crate::streams::{self, Verbosity};
use crate::text::{duration, ratio};
use eosphor::Progress;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use std::io::{IsTerminal, stderr};
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Instant;

/// Milliseconds between two lines where stderr is no terminal.
const LINE_INTERVAL: u64 = 10_000;
/// Milliseconds between two looks of the bar.
const BAR_INTERVAL: u64 = 100;

/// Shows the progress of one render.
pub(crate) struct ProgressView {
    start: Instant,
    /// When the next report is due, in milliseconds since the start.
    next: AtomicU64,
    interval: u64,
    bar: Option<ProgressBar>,
}

impl ProgressView {
    /// Begins: an empty bar, or a line.
    pub(crate) fn new(verbosity: Verbosity) -> ProgressView {
        let terminal = stderr().is_terminal();
        let bar = (terminal && verbosity > Verbosity::Quiet).then(bar);
        if bar.is_none() {
            verbosity.say(Verbosity::Normal, "rendering");
        }
        let interval = match &bar {
            _ if verbosity == Verbosity::Quiet => u64::MAX,
            Some(_) => BAR_INTERVAL,
            None => LINE_INTERVAL,
        };
        ProgressView { start: Instant::now(), next: AtomicU64::new(interval), interval, bar }
    }

    /// Reports where it is time to. Any thread may call it.
    pub(crate) fn update(&self, progress: Progress) {
        let now = self.start.elapsed().as_millis() as u64;
        let due = self.next.load(Ordering::Relaxed);
        let after = now.saturating_add(self.interval);
        let ours = now >= due
            && self.next.compare_exchange(due, after, Ordering::Relaxed, Ordering::Relaxed).is_ok();
        if !ours {
            return;
        }
        let text = describe(progress, now as f64 / 1000.0);
        match &self.bar {
            Some(bar) => {
                bar.set_position((fraction(progress) * 1000.0) as u64);
                bar.set_message(text);
            }
            None => {
                streams::message(&format!("rendering: {:.0} %, {text}", (fraction(progress) * 100.0).floor()))
            }
        }
    }

    /// Ends: the bar goes away.
    pub(crate) fn finish(&self) {
        if let Some(bar) = &self.bar {
            bar.finish_and_clear();
        }
    }
}

fn bar() -> ProgressBar {
    let bar = ProgressBar::with_draw_target(Some(1000), ProgressDrawTarget::stderr());
    if let Ok(style) = ProgressStyle::with_template("{percent:>3} % [{bar:40}] {msg}") {
        bar.set_style(style.progress_chars("=> "));
    }
    bar
}

fn fraction(progress: Progress) -> f64 {
    ratio(progress.pixels_done as f64, progress.pixels_total as f64)
}

/// `12.3 Mrays/s, 2 min 05 s left`. The rest is taken to be as fast as what is done.
fn describe(progress: Progress, seconds: f64) -> String {
    let done = fraction(progress);
    let rate = ratio(progress.rays as f64, seconds) * 1e-6;
    match done > 0.0 {
        true => format!("{rate:.2} Mrays/s, {} left", duration(seconds * (1.0 - done) / done)),
        false => format!("{rate:.2} Mrays/s"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_quarter_in_ten_seconds_leaves_thirty() {
        let progress = Progress { pixels_done: 25, pixels_total: 100, rays: 50_000_000 };
        assert_eq!(describe(progress, 10.0), "5.00 Mrays/s, 30 s left");
    }
}
