//! `eosphor render SCENE -o flight.mp4`.

use super::frames::Sequence;
use crate::animation::FrameSink;
use crate::failure::Failure;
use crate::streams::Verbosity;
use eosphor::frames::{Manifest, Wanted};
use eosphor::video::{FfmpegOptions, FfmpegPipe, FrameRate, VideoOptions, VideoWriter, padded_size};
use eosphor::{Backend, DevelopSettings, Developed, Film};
use std::path::PathBuf;
use std::sync::{Mutex, PoisonError};
use std::thread::available_parallelism;

/// Frames go to the encoder while others are rendered.
pub(super) fn render_video(sequence: &Sequence, backend: &dyn Backend) -> Result<(), Failure> {
    let Sequence { flags, scene, options, .. } = *sequence;
    let [width, height] = scene.settings.size;
    let rate = rate(sequence)?;
    let (padded, verbosity) = (padded_size((width, height)), flags.report.verbosity());
    if padded != (width, height) {
        let note = format!(
            "eosphor: note: videos have even sides: this one has {} x {}, with the last row or column twice",
            padded.0, padded.1
        );
        verbosity.say(Verbosity::Normal, &note);
    }
    let quality = flags.animation.video_quality.unwrap_or(VideoOptions::default().quality);
    let first = sequence.range.start;
    let all: Vec<u32> = sequence.range.clone().collect();
    if flags.animation.ffmpeg {
        let options_of_ffmpeg = FfmpegOptions { quality, ..FfmpegOptions::default() };
        let pipe = FfmpegPipe::open(&flags.output, (width, height), rate, &options_of_ffmpeg)?;
        let sink = Piped { pipe: Mutex::new(pipe), develop: options.develop };
        // In order.
        let done = sequence.render(backend, &all, &sink, Some(1))?;
        sink.pipe.into_inner().unwrap_or_else(PoisonError::into_inner).finish()?;
        return done.report(sequence, backend);
    }
    let mut manifest_path = flags.output.clone().into_os_string();
    manifest_path.push(".manifest");
    let manifest_path = PathBuf::from(manifest_path);
    let identity = sequence.identity(&format!("{:?}", sequence.range), &format!("mp4 {quality} {rate}"));
    let range = sequence.range.clone();
    let wanted = if flags.keep.resume { Wanted::Missing(range) } else { Wanted::Anew(range) };
    let manifest = Manifest::open(&manifest_path, &identity, wanted).map_err(Failure::because)?;
    if manifest.is_done(first, &flags.output) {
        let note = format!("eosphor: note: {} is done already", flags.output.display());
        verbosity.say(Verbosity::Normal, &note);
        return manifest.finish().map_err(Failure::because);
    }
    if !manifest.is_resumed() || !flags.keep.resume {
        VideoWriter::discard(&flags.output)?;
    }
    // Half of the cores: the others render.
    let threads = available_parallelism().map_or(1, |n| n.get().div_ceil(2));
    let options_of_video = VideoOptions { quality, threads: threads.try_into().map_err(Failure::because)? };
    let length = sequence.range.len() as u32;
    let opened = VideoWriter::open(&flags.output, (width, height), rate, length, &options_of_video);
    let (writer, manifest) = match opened {
        Ok(writer) => (writer, manifest),
        Err(error) => {
            manifest.abandon();
            return Err(error.into());
        }
    };
    let missing: Vec<u32> = writer.missing_frames().into_iter().map(|number| first + number).collect();
    let sink = Video { writer, first, develop: options.develop };
    let done = match sequence.render(backend, &missing, &sink, None) {
        Ok(done) => done,
        Err(failure) => {
            // Where no frame could be kept, nothing is.
            if sink.writer.missing_frames().len() == length as usize {
                drop(sink.writer);
                let _ = VideoWriter::discard(&flags.output);
                manifest.abandon();
            }
            return Err(failure);
        }
    };
    sink.writer.finish()?;
    manifest.note(first, &flags.output).map_err(Failure::because)?;
    manifest.finish().map_err(Failure::because)?;
    done.report(sequence, backend)
}

/// Frames a second as a fraction.
fn rate(sequence: &Sequence) -> Result<FrameRate, Failure> {
    let fps = sequence.scene.animation.as_ref().map_or(24.0, |animation| animation.fps);
    fps.to_string().parse().map_err(|error| {
        Failure::Usage(format!("{fps} frames a second: {error}: give --fps a simpler number, as 24 or 29.97"))
    })
}

struct Video {
    writer: VideoWriter,
    /// The number of the video's first frame.
    first: u32,
    develop: DevelopSettings,
}

impl FrameSink for Video {
    fn take(&self, frame: u32, film: Film) -> Result<(), Failure> {
        Ok(self.writer.write_frame(frame - self.first, &Developed::new(&film, &self.develop))?)
    }
}

struct Piped {
    pipe: Mutex<FfmpegPipe>,
    develop: DevelopSettings,
}

impl FrameSink for Piped {
    fn take(&self, _frame: u32, film: Film) -> Result<(), Failure> {
        let frame = Developed::new(&film, &self.develop);
        Ok(self.pipe.lock().unwrap_or_else(PoisonError::into_inner).write_frame(&frame)?)
    }
}
