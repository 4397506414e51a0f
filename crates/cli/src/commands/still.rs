//! `eosphor render SCENE -o OUT`: a single picture, or a share of one.

use crate::arguments::{RenderFlags, SampleRange, Share as RowShare};
use crate::backend::cpu_options;
use crate::failure::Failure;
use crate::flag_hints::RESUME;
use crate::outputs::names;
use crate::report::{Report, Seconds, Speed, Work};
use crate::streams::{self, Verbosity};
use crate::text::{grouped, ratio};
use crate::watcher::Watcher;
use eosphor::job::{Output, Share, Still, StillOutcome, process_cpu_seconds};
use eosphor::shares::share_path;
use eosphor::{Backend, Scene};
use std::path::PathBuf;
use std::time::Instant;

/// A still that flags ask for.
pub(super) struct StillJob<'a> {
    pub(super) flags: &'a RenderFlags,
    pub(super) scene: &'a Scene,
    pub(super) backend: &'a dyn Backend,
    /// When loading began.
    pub(super) start: Instant,
    pub(super) load_seconds: f64,
}

impl StillJob<'_> {
    /// Renders it and says what was done. `has_ranks`: others work, too, whose CPU time nobody knows.
    pub(super) fn run(self, outputs: Vec<Output>, watcher: Watcher, has_ranks: bool) -> Result<(), Failure> {
        let StillJob { flags, scene, backend, start, load_seconds } = self;
        let targets: Vec<String> = outputs.iter().map(Output::to_string).collect();
        let still = Still {
            outputs,
            file: flags.file_options(),
            region: flags.file.region,
            share: flags.file.share(),
            resume: flags.keep.resume,
            checkpoint_interval: flags.keep.interval(),
            count_work: flags.report.stats,
            most_rows: flags.file.band_rows,
            cpu: cpu_options(&flags.device, flags.picture.accel),
            ..Still::new(scene, backend)
        };
        let outcome = watcher.run(|control| still.run(control))?;
        if let Some(RowShare(share)) = flags.file.tiles {
            return self.end_of_rows(share_path(flags.output(), share), &outcome);
        }
        if outcome.done == 0.0 && !outcome.complete {
            let output = match flags.file.sample_range.is_some() {
                true => names(outcome.written.iter().map(|path| path.display())),
                false => names(&targets),
            };
            return Err(Failure::Interrupted(format!(
                "interrupted: {output}: nothing was rendered, nothing written"
            )));
        }
        let total = start.elapsed().as_secs_f64();
        let mut seconds = Seconds { load: load_seconds, total, ..outcome.seconds.into() };
        match has_ranks {
            true => seconds.render_cpu = None,
            false => seconds.total_cpu = process_cpu_seconds(),
        }
        let notes = watcher.into_notes();
        let report = self.report(&targets, &outcome, seconds, notes);
        flags.report.verbosity().say(Verbosity::Normal, &report.table());
        if flags.report.json {
            streams::json(&report)?;
        }
        match outcome.complete {
            true => Ok(()),
            false => Err(Failure::Interrupted(self.interruption(&names(&targets), &outcome))),
        }
    }

    /// Says what was done of a share of rows.
    fn end_of_rows(&self, path: PathBuf, outcome: &StillOutcome) -> Result<(), Failure> {
        let name = path.display();
        if !outcome.complete {
            let percent = (outcome.done * 100.0).floor();
            return Err(Failure::Interrupted(match outcome.kept {
                None => format!("interrupted: {name}: nothing was written"),
                Some(_) => format!(
                    "interrupted: {name} was not written: {percent:.0} % of its samples are done; {RESUME}"
                ),
            }));
        }
        let text = format!(
            "{name}: {} of {} rows on {} in {:.2} s, {} rays",
            outcome.size.1,
            self.flags.file.region.map_or(self.scene.settings.size[1], |region| region.height),
            self.backend.describe(),
            self.start.elapsed().as_secs_f64(),
            grouped(outcome.statistics.total_rays())
        );
        self.flags.report.verbosity().say(Verbosity::Normal, &text);
        Ok(())
    }

    /// What there is after a signal.
    fn interruption(&self, targets: &str, outcome: &StillOutcome) -> String {
        let percent = (outcome.done * 100.0).floor();
        let written = names(outcome.written.iter().map(|path| path.display()));
        if self.flags.file.sample_range.is_some() {
            return format!("interrupted: {written} has {percent:.0} % of its samples: {RESUME}");
        }
        let goes_on = match &outcome.kept {
            Some(_) => format!("; {RESUME}"),
            None => String::new(),
        };
        let were = if self.flags.outputs.len() > 1 { "were" } else { "was" };
        let partial = match outcome.written.len() {
            0 => String::new(),
            1 => format!("; {written} is the partial picture"),
            _ => format!("; {written} are the partial picture"),
        };
        format!(
            "interrupted: {targets} {were} not written: {percent:.0} % of its samples are done{partial}{goes_on}"
        )
    }

    fn report(
        &self,
        targets: &[String],
        outcome: &StillOutcome,
        seconds: Seconds,
        notes: Vec<String>,
    ) -> Report {
        let (width, height) = outcome.size;
        let total_rays = outcome.statistics.total_rays();
        // A partial picture, or a share, has another name.
        let files: Vec<String> = match outcome.complete && self.flags.file.sample_range.is_none() {
            true => targets.to_vec(),
            false => outcome.written.iter().map(|path| path.display().to_string()).collect(),
        };
        Report {
            output: files.first().cloned().unwrap_or_default(),
            outputs: files,
            width,
            height,
            complete: outcome.complete,
            backend: self.backend.describe(),
            rays: outcome.statistics,
            total_rays,
            resumed: outcome.resumed,
            rays_per_pixel: ratio(total_rays as f64, width as f64 * height as f64 * (1.0 - outcome.resumed)),
            work: self.flags.report.stats.then(|| Work::of(&outcome.statistics)),
            speed: Speed::of(total_rays, &seconds),
            seconds,
            hierarchy: outcome.hierarchy.clone(),
            notes,
        }
    }
}

impl crate::arguments::FileFlags {
    /// The share of the picture that flags ask for.
    fn share(&self) -> Option<Share> {
        let rows = self.tiles.as_ref().map(|&RowShare((number, count))| Share::Rows { number, count });
        let samples = || self.sample_range.clone().map(|SampleRange(samples)| Share::Samples(samples));
        rows.or_else(samples)
    }
}
