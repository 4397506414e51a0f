//! Frames to a video: `eosphor render SCENE -o flight.mp4`, `eosphor course -o flight.mp4`.

use super::frames::Sequence;
use crate::animation::FrameSink;
use crate::failure::Failure;
use crate::streams::Verbosity;
use eosphor::frames::{FramesIdentity, Manifest, Wanted};
use eosphor::job::make_folder;
use eosphor::video::{FfmpegOptions, FfmpegPipe, FrameRate, VideoOptions, VideoWriter, padded_size};
use eosphor::{Backend, DevelopSettings, Developed, Film};
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};
use std::thread::available_parallelism;

pub(super) fn render_video(sequence: &Sequence, backend: &dyn Backend) -> Result<(), Failure> {
    let Sequence { flags, scene, options, .. } = *sequence;
    let job = VideoJob {
        output: flags.output(),
        size: scene.settings.size.into(),
        fps: scene.animation.as_ref().map_or(24.0, |animation| animation.fps),
        quality: flags.animation.video_quality,
        ffmpeg: flags.animation.ffmpeg,
        resume: flags.keep.resume,
        range: sequence.range.clone(),
        develop: options.develop,
        identity: &|file| sequence.identity(file),
        verbosity: flags.report.verbosity(),
    };
    let render =
        |frames: &[u32], sink: &dyn FrameSink, in_flight| sequence.render(backend, frames, sink, in_flight);
    match job.run(&render)? {
        Some(done) => done.report(sequence, backend),
        None => Ok(()),
    }
}

/// A video to be made.
pub(super) struct VideoJob<'a> {
    pub(super) output: &'a Path,
    /// Width and height of the frames.
    pub(super) size: (u32, u32),
    /// Frames a second.
    pub(super) fps: f32,
    /// 1 to 100, where it was given.
    pub(super) quality: Option<u8>,
    /// The program ffmpeg encodes.
    pub(super) ffmpeg: bool,
    /// Frames of an earlier run are kept.
    pub(super) resume: bool,
    /// The numbers of its frames.
    pub(super) range: Range<u32>,
    pub(super) develop: DevelopSettings,
    /// What the frames are made of; it is given what the file is like.
    pub(super) identity: &'a dyn Fn(&str) -> FramesIdentity,
    pub(super) verbosity: Verbosity,
}

/// Renders these frames into a sink, so many at the same time where a number is given.
type Render<'a, T> = &'a dyn Fn(&[u32], &dyn FrameSink, Option<u16>) -> Result<T, Failure>;

impl VideoJob<'_> {
    /// Frames go to the encoder while others are rendered. What rendering gave; `None` where the file was done already.
    pub(super) fn run<T>(&self, render: Render<T>) -> Result<Option<T>, Failure> {
        let (rate, quality) = (self.rate()?, self.quality.unwrap_or(VideoOptions::default().quality));
        make_folder(self.output)?;
        if self.ffmpeg {
            return self.pipe(rate, quality, render).map(Some);
        }
        let first = self.range.start;
        let mut manifest_path = self.output.to_owned().into_os_string();
        manifest_path.push(".manifest");
        let mut identity = (self.identity)("mp4");
        let range = self.range.clone();
        identity.stated.extend([
            ("range of frames", format!("{}..{}", range.start, range.end)),
            ("number of frames a second", rate.to_string()),
            ("quality of the video", quality.to_string()),
        ]);
        let wanted = if self.resume { Wanted::Missing(range) } else { Wanted::Anew(range) };
        let manifest =
            Manifest::open(&PathBuf::from(manifest_path), &identity, wanted).map_err(Failure::because)?;
        if manifest.is_done(first, self.output) {
            let note = format!("eosphor: note: {} is done already", self.output.display());
            self.verbosity.say(Verbosity::Normal, &note);
            manifest.finish().map_err(Failure::because)?;
            return Ok(None);
        }
        if !manifest.is_resumed() || !self.resume {
            VideoWriter::discard(self.output)?;
        }
        // Half of the cores: the others render.
        let threads = available_parallelism().map_or(1, |n| n.get().div_ceil(2));
        let options = VideoOptions { quality, threads: threads.try_into().map_err(Failure::because)? };
        let length = self.range.len() as u32;
        let writer = match VideoWriter::open(self.output, self.size, rate, length, &options) {
            Ok(writer) => writer,
            Err(error) => {
                manifest.abandon();
                return Err(error.into());
            }
        };
        self.note_padding();
        let missing: Vec<u32> = writer.missing_frames().into_iter().map(|number| first + number).collect();
        let sink = Video { writer, first, develop: self.develop };
        let done = match render(&missing, &sink, None) {
            Ok(done) => done,
            Err(failure) => {
                // Where no frame could be kept, nothing is.
                if sink.writer.missing_frames().len() == length as usize {
                    drop(sink.writer);
                    let _ = VideoWriter::discard(self.output);
                    manifest.abandon();
                    return Err(failure);
                }
                return Err(self.still_there(failure, &sink.writer));
            }
        };
        let folder = sink.writer.folder().to_owned();
        sink.writer.finish().map_err(|error| {
            let kept = folder.display();
            Failure::Failed(format!(
                "{error}; {kept} has {length} of {length} frames: the same with --resume goes on"
            ))
        })?;
        manifest.note(first, self.output).map_err(Failure::because)?;
        manifest.finish().map_err(Failure::because)?;
        Ok(Some(done))
    }

    /// With what is kept of a video that failed.
    fn still_there(&self, failure: Failure, writer: &VideoWriter) -> Failure {
        let Failure::Failed(line) = failure else { return failure };
        let (kept, all) = (writer.folder().display(), self.range.len());
        let count = all - writer.missing_frames().len();
        Failure::Failed(format!("{line}; {kept} has {count} of {all} frames: the same with --resume goes on"))
    }

    /// Frames go to the program ffmpeg.
    fn pipe<T>(&self, rate: FrameRate, quality: u8, render: Render<T>) -> Result<T, Failure> {
        let options = FfmpegOptions { quality, ..FfmpegOptions::default() };
        let pipe = FfmpegPipe::open(self.output, self.size, rate, &options)?;
        self.note_padding();
        let sink = Piped { pipe: Mutex::new(pipe), develop: self.develop };
        let all: Vec<u32> = self.range.clone().collect();
        // In order.
        let done = render(&all, &sink, Some(1))?;
        sink.pipe.into_inner().unwrap_or_else(PoisonError::into_inner).finish()?;
        Ok(done)
    }

    /// Says that a video is larger than its frames, where it is.
    fn note_padding(&self) {
        let padded = padded_size(self.size);
        if padded != self.size {
            let note = format!(
                "eosphor: note: videos have even sides: this one has {} x {}, with the last row or column twice",
                padded.0, padded.1
            );
            self.verbosity.say(Verbosity::Normal, &note);
        }
    }

    /// Frames a second as a fraction.
    fn rate(&self) -> Result<FrameRate, Failure> {
        let fps = self.fps;
        fps.to_string().parse().map_err(|error| {
            Failure::Usage(format!(
                "{fps} frames a second: {error}: give --fps a simpler number, as 24 or 29.97"
            ))
        })
    }
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
