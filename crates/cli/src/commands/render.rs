//! `eosphor render SCENE -o OUT`.

use super::scene::load_scene;
use super::{cost, frames, still};
use crate::arguments::{OutputKind, RenderFlags, Show};
use crate::backend::ranks_or_own;
use crate::command_line::command_line;
use crate::failure::Failure;
use crate::interrupt;
use crate::outputs::{self, is_stdout, outputs};
use crate::watcher::Watcher;
use eosphor::job::{FileOptions, Output};
use eosphor::{Backend, Format};
use std::time::Instant;

/// `ranks` is the backend where there are several.
pub(crate) fn render(flags: &RenderFlags, ranks: Option<&dyn Backend>) -> Result<(), Failure> {
    // What can be known to fail does so before minutes of rendering.
    let kind = frames::output_kind(flags);
    flags.animation.check(kind)?;
    let to_stdout = flags.outputs.iter().any(|output| is_stdout(output));
    let has_file = flags.outputs.iter().any(|output| !is_stdout(output));
    flags.keep.check(kind, &flags.file, flags.show, &flags.report, has_file)?;
    flags.report.check(&flags.device, flags.show, to_stdout)?;
    let sequence = kind != OutputKind::Still;
    if flags.outputs.len() > 1 && (sequence || flags.file.is_share()) {
        let message = "several outputs (-o) are for whole single pictures: name one";
        return Err(Failure::Usage(message.into()));
    }
    let outputs = match kind {
        OutputKind::Video => Vec::new(),
        OutputKind::Still | OutputKind::Frames => outputs(&flags.outputs, flags.file.format)?,
    };
    let formats: Vec<Format> = outputs.iter().map(Output::format).collect();
    flags.file.check(&formats, to_stdout)?;
    let is_developed = kind == OutputKind::Video || formats.iter().any(|format| !format.is_linear());
    flags.settings.check_development(is_developed && flags.show.is_none())?;
    flags.check_shape(kind)?;
    match sequence {
        true => frames::check_output(flags.output())?,
        false => outputs::check(&outputs)?,
    }
    let verbosity = flags.report.verbosity();
    let backend = ranks_or_own(ranks, &flags.device, flags.picture.accel, flags.report.stats, verbosity)?;
    interrupt::watch(verbosity)?;

    let start = Instant::now();
    let mut notes = Vec::new();
    let scene = load_scene(flags, &mut notes)?;
    let load_seconds = start.elapsed().as_secs_f64();
    flags.animation.check_fps(kind, &scene)?;
    #[cfg(feature = "video")]
    check_video_size(flags, kind, scene.settings.size)?;
    let watcher = Watcher::new(verbosity, notes);
    match (kind, flags.show) {
        (OutputKind::Still, None) => {
            let job = still::StillJob { flags, scene: &scene, backend: &*backend, start, load_seconds };
            job.run(outputs, watcher, ranks.is_some())
        }
        (OutputKind::Still, Some(Show::Cost)) => cost::show_cost(flags, &scene, outputs, &watcher),
        (OutputKind::Frames | OutputKind::Video, _) => {
            frames::render_frames(flags, &*backend, &scene, &watcher)
        }
    }
}

/// Fails where flags ask for a video of a size that the encoder does not take.
#[cfg(feature = "video")]
fn check_video_size(flags: &RenderFlags, kind: OutputKind, size: [u32; 2]) -> Result<(), Failure> {
    match kind == OutputKind::Video && flags.settings.has_size() && !flags.animation.ffmpeg {
        true => eosphor::video::check_video_size(size.into())
            .map_err(|problem| Failure::Usage(format!("--size: {problem}"))),
        false => Ok(()),
    }
}

impl RenderFlags {
    /// Fails where flags about single pictures are given with others, or those about a whole one with a share.
    fn check_shape(&self, kind: OutputKind) -> Result<(), Failure> {
        let file = &self.file;
        let is_single = file.tiles.is_some()
            || file.region.is_some()
            || self.show.is_some()
            || !file.layers().is_empty()
            || file.alpha;
        if kind != OutputKind::Still && is_single {
            let message =
                "--show, --tiles, --region, --layers and --alpha are for single pictures: leave them out";
            return Err(Failure::Usage(message.into()));
        }
        if file.tiles.is_some() && (self.show.is_some() || self.report.stats || self.report.json) {
            let message = "--show, --stats and --json are not for shares of a picture";
            return Err(Failure::Usage(message.into()));
        }
        Ok(())
    }

    /// What the files are like.
    pub(super) fn file_options(&self) -> FileOptions {
        let defaults = FileOptions::default();
        FileOptions {
            layers: self.file.layers().to_vec(),
            alpha: self.file.alpha,
            exr_half: self.file.exr_half,
            jpeg_quality: self.file.jpeg_quality.unwrap_or(defaults.jpeg_quality),
            metadata: !self.file.no_metadata,
            // Frames are to be the same bytes however often it took to render them all.
            command_line: (!frames::are_asked_for(self)).then(command_line),
        }
    }
}
