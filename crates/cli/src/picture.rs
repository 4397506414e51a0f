//! From a prepared scene to the file: bands of rows are rendered and written one after another, so that a picture of any
//! size takes the memory of one band.

use crate::failure::Failure;
use crate::interrupt;
use crate::progress::ProgressView;
use crate::report::{Seconds, timed};
use cpu_time::ProcessTime;
use eosphor::{Bands, FeaturePass, PictureWriter, PreparedScene, Progress, RayStatistics};
use eosphor::{RenderControl, Rendered, SaveOptions, partial_path};
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::time::Duration;

/// A picture to be rendered and written.
pub(crate) struct PictureJob<'a> {
    pub(crate) prepared: &'a dyn PreparedScene,
    /// Where the file has layers.
    pub(crate) features: Option<FeaturePass>,
    pub(crate) output: &'a Path,
    pub(crate) options: SaveOptions,
    /// Count nodes and tests.
    pub(crate) count_work: bool,
}

/// What was done.
pub(crate) struct Done {
    /// Every pixel was rendered.
    pub(crate) complete: bool,
    /// Share of the pixels that were, 0 to 1. Where it is 0, nothing was written.
    pub(crate) share: f64,
    /// What was written: the output, or a partial picture beside it.
    pub(crate) written: PathBuf,
    pub(crate) statistics: RayStatistics,
}

impl PictureJob<'_> {
    /// Renders and writes all of it, or, after a signal, writes what is done beside it.
    pub(crate) fn run(
        &self,
        bands: Bands,
        view: ProgressView,
        seconds: &mut Seconds,
    ) -> Result<Done, Failure> {
        let (width, height) = self.prepared.size();
        let mut writer = None;
        let mut before = Progress { pixels_done: 0, pixels_total: width as u64 * height as u64, rays: 0 };
        let mut statistics = RayStatistics::default();
        let mut complete = true;
        for rows in bands {
            // First: after Ctrl-C in the middle of the colours, what is done of them has its layers.
            let features = match &self.features {
                Some(pass) => {
                    let spent = seconds.layers.get_or_insert_default();
                    Some(timed(spent, || pass.rows(rows.clone(), None, interrupt::flag()))?)
                }
                None => None,
            };
            let rendered = self.render(rows.clone(), &before, &view, seconds)?;
            statistics += rendered.statistics;
            complete = rendered.complete;
            if !complete && view.pixels_done() == 0 {
                break;
            }
            timed(&mut seconds.write, || {
                let writer = match &mut writer {
                    Some(writer) => writer,
                    none => none.insert(self.open(width, height)?),
                };
                writer.write_rows(&rendered.film, features.as_ref())
            })?;
            if !complete {
                break;
            }
            before.pixels_done += width as u64 * rows.len() as u64;
            before.rays += rendered.statistics.total_rays();
        }
        let share = view.finish();
        let written = if complete { self.output.to_owned() } else { partial_path(self.output) };
        if let Some(writer) = writer {
            timed(&mut seconds.write, || match complete {
                true => writer.finish(),
                false => writer.finish_partial(&written),
            })?;
        }
        Ok(Done { complete, share, written, statistics })
    }

    fn open(&self, width: u32, height: u32) -> Result<PictureWriter, eosphor::OutputError> {
        let writer = PictureWriter::open(self.output, (width, height), &self.options)?;
        interrupt::note_unfinished(writer.temporary_path());
        Ok(writer)
    }

    /// Some rows; `before` is what was done before them.
    fn render(
        &self,
        rows: Range<u32>,
        before: &Progress,
        view: &ProgressView,
        seconds: &mut Seconds,
    ) -> Result<Rendered, Failure> {
        let control = RenderControl {
            on_progress: &|progress| {
                view.update(Progress {
                    pixels_done: before.pixels_done + progress.pixels_done,
                    pixels_total: before.pixels_total,
                    rays: before.rays + progress.rays,
                })
            },
            cancel: interrupt::flag(),
            count_work: self.count_work,
            moment: None,
        };
        let cpu_before = ProcessTime::try_now().ok();
        let rendered = timed(&mut seconds.render, || self.prepared.render_rows(rows, &control))?;
        if let Some(time) = cpu_before.and_then(|before| before.try_elapsed().ok()) {
            *seconds.render_cpu.get_or_insert_default() += Duration::as_secs_f64(&time);
        }
        Ok(rendered)
    }
}
