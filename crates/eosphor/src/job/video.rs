//! Frames as a video.

use super::files::make_folder;
use super::frame_files::manifest_path;
use super::frames::{FramePicture, FrameSink, FramesDone};
use super::sequence::FlatSequence;
use super::{Event, JobControl, JobError, Sequence, SequenceOutcome};
use eosphor_picture::frames::{Manifest, Wanted};
use eosphor_picture::output::{
    DevelopSettings, FfmpegOptions, FfmpegPipe, FrameRate, InvalidFrameRate, OutputError, VideoOptions,
    VideoWriter, padded_size,
};
use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};
use std::thread::available_parallelism;
use std::time::Instant;

/// A video file to be made of frames.
#[derive(Clone, Debug, PartialEq)]
pub struct Video {
    /// The file to write, an `.mp4`.
    pub path: PathBuf,
    /// Frames a second; `None`: the animation's.
    pub frame_rate: Option<f32>,
    /// 1 to 100; losses are hard to see at 90, the default.
    pub quality: u8,
    /// Let the program ffmpeg encode it, which must be installed. Nothing is kept then of a video that is not whole.
    pub by_ffmpeg: bool,
}

impl Video {
    /// A video of the default quality, at the animation's rate.
    pub fn new(path: &Path) -> Video {
        let VideoOptions { quality, .. } = VideoOptions::default();
        Video { path: path.to_owned(), frame_rate: None, quality, by_ffmpeg: false }
    }
}

impl Sequence<'_> {
    /// Renders the frames and makes a video of them, while they are rendered. The folder is made where it is missing. Until the
    /// file is whole, frames and encoded segments are in a folder beside it, `OUT.mp4.part`.
    ///
    /// # Errors
    ///
    /// Where the scene has no animation or not so many frames, the file cannot be written, the rate or size is none of a video,
    /// the memory is too small, the video is in work elsewhere, what is there of it was made of something else, or the device
    /// fails; [`JobError::VideoKept`] where frames were done until then; [`JobError::Cancelled`] where the job was cancelled
    /// before anything was begun.
    pub fn write_video(&self, video: &Video, control: &JobControl) -> Result<SequenceOutcome, JobError> {
        let rate = rate(video.frame_rate.or(self.scene.animation.as_ref().map(|animation| animation.fps)))?;
        let range = self.range(&video.path)?;
        let flat = FlatSequence::new(self, range, None, control)?;
        make_folder(&video.path)?;
        let film = VideoFilm { video, rate, flat: &flat };
        match video.by_ffmpeg {
            true => film.pipe(),
            false => film.write(),
        }
    }
}

/// A video of a flat scene.
struct VideoFilm<'a> {
    video: &'a Video,
    rate: FrameRate,
    flat: &'a FlatSequence<'a>,
}

impl VideoFilm<'_> {
    /// Frames go to the encoder while others are rendered.
    fn write(&self) -> Result<SequenceOutcome, JobError> {
        let VideoFilm { video, flat, .. } = self;
        let resume = flat.sequence.resume;
        let manifest = self.manifest(resume)?;
        let first = flat.range.start;
        if manifest.is_done(first, &video.path) {
            flat.control.tell(Event::VideoIsWhole(&video.path));
            manifest.finish()?;
            let outcome = flat.outcome(flat.range.len(), FramesDone::default(), None, Instant::now());
            return Ok(SequenceOutcome { was_whole: true, ..outcome });
        }
        if !manifest.is_resumed() || !resume {
            VideoWriter::discard(&video.path)?;
        }
        let length = flat.range.len() as u32;
        let writer = match self.open() {
            Ok(writer) => writer,
            Err(error) => {
                manifest.abandon();
                return Err(error.into());
            }
        };
        self.tell_padding();
        let missing: Vec<u32> = writer.missing_frames().into_iter().map(|number| first + number).collect();
        let sink = Encoder { writer, first, develop: flat.options.develop };
        let rendered = flat.render(&missing, &sink, None);
        let is_whole = rendered.as_ref().is_ok_and(|outcome| outcome.complete);
        if !is_whole && sink.writer.missing_frames().len() == length as usize {
            // Where no frame could be kept, nothing is.
            drop(sink.writer);
            let _ = VideoWriter::discard(&video.path);
            manifest.abandon();
            return rendered;
        }
        let outcome = rendered.map_err(|error| self.still_there(error, &sink.writer))?;
        if !is_whole {
            return Ok(outcome);
        }
        let (folder, all) = (sink.writer.folder().to_owned(), length as usize);
        sink.writer.finish().map_err(|error| {
            let error = Box::new(error.into());
            JobError::VideoKept { error, folder, done: all, all }
        })?;
        manifest.note(first, &video.path)?;
        manifest.finish()?;
        Ok(outcome)
    }

    /// The account of what is done.
    fn manifest(&self, resume: bool) -> Result<Manifest, JobError> {
        let VideoFilm { video, rate, flat } = self;
        let range = flat.range.clone();
        let mut identity = flat.identity("mp4");
        identity.stated.extend([
            ("range of frames", format!("{}..{}", range.start, range.end)),
            ("number of frames a second", rate.to_string()),
            ("quality of the video", video.quality.to_string()),
        ]);
        let wanted = if resume { Wanted::Missing(range) } else { Wanted::Anew(range) };
        Ok(Manifest::open(&manifest_path(&video.path), &identity, wanted)?)
    }

    fn open(&self) -> Result<VideoWriter, OutputError> {
        // Half of the cores: the others render.
        let threads = available_parallelism().map_or(1, |n| n.get().div_ceil(2));
        let threads = NonZeroUsize::new(threads).unwrap_or(NonZeroUsize::MIN);
        let options = VideoOptions { quality: self.video.quality, threads };
        let length = self.flat.range.len() as u32;
        VideoWriter::open(&self.video.path, self.size(), self.rate, length, &options)
    }

    /// Frames go to the program ffmpeg.
    fn pipe(&self) -> Result<SequenceOutcome, JobError> {
        let VideoFilm { video, rate, flat } = self;
        let options = FfmpegOptions { quality: video.quality, ..FfmpegOptions::default() };
        let pipe = FfmpegPipe::open(&video.path, self.size(), *rate, &options)?;
        self.tell_padding();
        let sink = Piped { pipe: Mutex::new(pipe), develop: flat.options.develop };
        let all: Vec<u32> = flat.range.clone().collect();
        // In order.
        let outcome = flat.render(&all, &sink, Some(1))?;
        if outcome.complete {
            sink.pipe.into_inner().unwrap_or_else(PoisonError::into_inner).finish()?;
        }
        Ok(outcome)
    }

    /// Width and height of the frames.
    fn size(&self) -> (u32, u32) {
        self.flat.sequence.scene.settings.size.into()
    }

    /// Says that a video is larger than its frames, where it is.
    fn tell_padding(&self) {
        let size = padded_size(self.size());
        if size != self.size() {
            self.flat.control.tell(Event::VideoPadded { size });
        }
    }

    /// With what is kept of a video that failed.
    fn still_there(&self, error: JobError, writer: &VideoWriter) -> JobError {
        let (folder, all) = (writer.folder().to_owned(), self.flat.range.len());
        let done = all - writer.missing_frames().len();
        JobError::VideoKept { error: Box::new(error), folder, done, all }
    }
}

/// Frames a second as a fraction.
fn rate(fps: Option<f32>) -> Result<FrameRate, JobError> {
    let fps = fps.unwrap_or(24.0);
    fps.to_string()
        .parse()
        .map_err(|error: InvalidFrameRate| JobError::FrameRate { fps, reason: error.to_string() })
}

struct Encoder {
    writer: VideoWriter,
    /// The number of the video's first frame.
    first: u32,
    develop: DevelopSettings,
}

impl FrameSink for Encoder {
    fn develop(&self) -> Option<DevelopSettings> {
        Some(self.develop)
    }

    fn take(&self, frame: u32, picture: FramePicture) -> Result<(), JobError> {
        Ok(self.writer.write_frame(frame - self.first, &picture.developed(&self.develop))?)
    }
}

struct Piped {
    pipe: Mutex<FfmpegPipe>,
    develop: DevelopSettings,
}

impl FrameSink for Piped {
    fn develop(&self) -> Option<DevelopSettings> {
        Some(self.develop)
    }

    fn take(&self, _frame: u32, picture: FramePicture) -> Result<(), JobError> {
        let frame = picture.developed(&self.develop);
        Ok(self.pipe.lock().unwrap_or_else(PoisonError::into_inner).write_frame(&frame)?)
    }
}
