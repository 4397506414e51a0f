//! Frames in any order to a video.

use super::super::{Developed, OutputError, atomic};
use super::encoder::SegmentEncoder;
use super::folder::Folder;
use super::queue::{Queue, Refusal};
use super::segment::SegmentWriter;
use super::settings::Settings;
use super::{FrameRate, VideoOptions, frame, misuse, mp4};
use std::io::Error;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::thread::JoinHandle;

/// Writes a video of frames that come in any order, from any number of threads, and in any number of runs.
///
/// The frames and what is encoded of them are in a folder beside the file, `OUT.mp4.part`; [`VideoWriter::finish`] makes
/// the file of them and removes the folder. Dropped before that, or with a program that is killed, the folder stays, and
/// the next [`VideoWriter::open`] goes on with what is whole in it. The file is the same, byte for byte, as that of one
/// run. Whether the folder holds the same scene is for the caller to know: it may keep a file of its own there.
///
/// ```
/// # use eosphor_picture::output::{Developed, FrameRate, VideoOptions, VideoWriter};
/// # let folder = tempfile::tempdir()?;
/// # let path = folder.path().join("fade.mp4");
/// let rate = FrameRate::new(24, 1)?;
/// let video = VideoWriter::open(&path, (64, 36), rate, 48, &VideoOptions::default())?;
/// for number in video.missing_frames() {
///     let rgb = vec![5 * number as u8; 64 * 36 * 3];
///     video.write_frame(number, &Developed { width: 64, height: 36, rgb, alpha: Vec::new() })?;
/// }
/// video.finish()?;
/// # assert!(path.metadata()?.len() > 0);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct VideoWriter {
    path: PathBuf,
    /// `None` when the folder is gone.
    shared: Option<Arc<Shared>>,
    threads: Vec<JoinHandle<()>>,
}

struct Shared {
    folder: Folder,
    queue: Queue<OutputError>,
}

impl VideoWriter {
    /// Begins a video of this width and height and so many frames, or goes on with one that was begun. Sides that are
    /// odd get one more column or row ([`super::padded_size`]).
    ///
    /// It reads all that is in the folder: what is not whole is removed, and missing again.
    ///
    /// # Errors
    ///
    /// [`OutputError::Video`], where the name does not end in `.mp4`, where the folder cannot be used or belongs to a
    /// video of another size, rate, quality or number of frames, and where another program writes this video.
    pub fn open(
        path: &Path,
        size: (u32, u32),
        rate: FrameRate,
        frames: u32,
        options: &VideoOptions,
    ) -> Result<VideoWriter, OutputError> {
        check_name(path)?;
        let settings = Settings::new(size, rate, frames, options.quality);
        let settings = settings.map_err(|error| OutputError::video(path, error))?;
        atomic::check(path).map_err(|error| OutputError::video(path, error))?;
        let (folder, found) = Folder::open(path, settings)?;
        let queue = Queue::new(folder.settings(), found);
        let shared = Arc::new(Shared { folder, queue });
        let mut writer =
            VideoWriter { path: path.to_owned(), shared: Some(shared.clone()), threads: Vec::new() };
        for _ in 0..options.threads.get().min(shared.folder.settings().segments() as usize) {
            let shared = shared.clone();
            let thread = std::thread::Builder::new().name("video".into()).spawn(move || shared.encode_all());
            writer.threads.push(thread.map_err(|error| OutputError::video(path, error))?);
        }
        Ok(writer)
    }

    /// The folder that the frames are stored in. It is there until [`VideoWriter::finish`].
    pub fn folder(&self) -> &Path {
        self.shared.as_ref().map_or(Path::new(""), |shared| shared.folder.path())
    }

    /// Numbers of the frames that are still to be written, in order; the first frame has number 0.
    pub fn missing_frames(&self) -> Vec<u32> {
        self.shared.as_ref().map_or_else(Vec::new, |shared| shared.queue.missing())
    }

    /// The number of frames that are encoded so far.
    pub fn encoded_frames(&self) -> u32 {
        self.shared.as_ref().map_or(0, |shared| shared.queue.encoded())
    }

    /// Stores a frame; when it is back, the frame is on the disk. It does not wait for encoders. A frame that is there
    /// already is left alone.
    ///
    /// # Errors
    ///
    /// [`OutputError::Video`] where there is no frame of this number, it has another size or it cannot be stored, and
    /// what went wrong while other frames were encoded.
    pub fn write_frame(&self, number: u32, frame: &Developed) -> Result<(), OutputError> {
        let Some(Shared { folder, queue }) = self.shared.as_deref() else { return Ok(()) };
        let lacking = queue.lacks(number).map_err(|refusal| self.explain(refusal))?;
        let (width, height) = (folder.settings().width, folder.settings().height);
        let whole = frame.rgb.len() as u64 == width as u64 * height as u64 * 3;
        if (frame.width, frame.height) != (width, height) || !whole {
            return Err(self.error(misuse(format!(
                "a frame of {} x {} pixels for a video of {width} x {height}",
                frame.width, frame.height
            ))));
        }
        if lacking {
            let path = folder.frame(number);
            frame::write(&path, frame).map_err(|error| OutputError::video(&path, error))?;
            queue.stored(number);
        }
        Ok(())
    }

    /// Waits for the encoders, joins the segments, gives the file its name and removes the folder.
    ///
    /// # Errors
    ///
    /// [`OutputError::Video`], also where frames are missing; the folder stays then.
    pub fn finish(mut self) -> Result<(), OutputError> {
        let Some(shared) = self.shared.clone() else { return Ok(()) };
        shared.queue.wait().map_err(|refusal| self.explain(refusal))?;
        self.join();
        mp4::write(&self.path, &shared.folder)?;
        // Nobody else has a part of it: the threads are gone.
        self.shared = None;
        match Arc::into_inner(shared) {
            Some(shared) => shared.folder.remove(),
            None => Ok(()),
        }
    }

    /// Removes the folder of a video that was begun, where there is one, so that it begins anew.
    ///
    /// # Errors
    ///
    /// [`OutputError::Video`], also for a folder of this name that is no video's, and where a program works in it.
    pub fn discard(path: &Path) -> Result<(), OutputError> {
        Folder::discard_left(path)
    }

    fn join(&mut self) {
        for thread in self.threads.drain(..) {
            // Panics are caught in the thread.
            let _ = thread.join();
        }
    }

    fn error(&self, error: Error) -> OutputError {
        OutputError::video(&self.path, error)
    }

    fn explain(&self, refusal: Refusal<OutputError>) -> OutputError {
        match refusal {
            Refusal::Failed(failure) => failure,
            Refusal::Misuse(error) => self.error(error),
        }
    }
}

impl Drop for VideoWriter {
    /// Encoders stop after the frame that they are at; their segments are encoded again in the next run.
    fn drop(&mut self) {
        if let Some(shared) = &self.shared {
            shared.queue.stop();
        }
        self.join();
    }
}

/// A name that players know.
pub(super) fn check_name(path: &Path) -> Result<(), OutputError> {
    match path.extension() {
        Some(ending) if ending.eq_ignore_ascii_case("mp4") => Ok(()),
        _ => Err(OutputError::video(path, misuse("use a file name that ends in .mp4"))),
    }
}

impl Shared {
    /// What an encoding thread does.
    fn encode_all(&self) {
        while let Some(segment) = self.queue.next() {
            let encoded = catch_unwind(AssertUnwindSafe(|| self.encode(segment))).unwrap_or_else(|_| {
                Err(OutputError::video(&self.folder.segment(segment), Error::other("the encoder panicked")))
            });
            match encoded {
                Ok(true) => self.queue.finished(self.folder.settings().frames_of(segment).len() as u32),
                Ok(false) => return,
                Err(failure) => return self.queue.fail(failure),
            }
        }
    }

    /// Encodes a segment, whose frames it removes. `false`: it was told to stop.
    fn encode(&self, number: u32) -> Result<bool, OutputError> {
        let settings = self.folder.settings();
        let path = self.folder.segment(number);
        let failed = |error| OutputError::video(&path, error);
        let frames = settings.frames_of(number);
        let mut encoder = SegmentEncoder::new(settings).map_err(failed)?;
        let mut writer = SegmentWriter::begin(&path, number, frames.len() as u32).map_err(failed)?;
        for frame in frames {
            if self.queue.is_stopped() {
                return Ok(false);
            }
            let path = self.folder.frame(frame);
            let frame = frame::read(&path, (settings.width, settings.height));
            let frame = frame.map_err(|error| OutputError::video(&path, error))?;
            writer.sample(&encoder.encode(&frame).map_err(failed)?).map_err(failed)?;
        }
        writer.finish(&encoder.finish()).map_err(failed)?;
        // Only now: the segment is on the disk.
        self.folder.remove_frames(number);
        Ok(true)
    }
}
