//! Frames in order to `ffmpeg`, a program that is installed or not. Used only when it is asked for.

use super::super::{Developed, OutputError, atomic::TemporaryFile};
use super::settings::quantiser;
use super::writer::check_name;
use super::{FrameRate, misuse, padded_size};
use std::io::{BufRead, BufReader, Error, ErrorKind, Read, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStdin, Command, Stdio};
use std::thread::JoinHandle;

/// How the program ffmpeg is called to encode a video.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FfmpegOptions {
    /// The program: a path, or a name to look up.
    pub program: PathBuf,
    /// 1 to 100, as that of [`super::VideoOptions`].
    pub quality: u8,
}

impl Default for FfmpegOptions {
    fn default() -> FfmpegOptions {
        FfmpegOptions { program: "ffmpeg".into(), quality: 90 }
    }
}

/// Writes a video by `ffmpeg` and its encoder x264: smaller files than those of [`super::VideoWriter`] and pictures of
/// any size, but frames must come in order, and a run that ends early leaves nothing. The file is whole or not there.
///
/// Which bytes it has depends on the ffmpeg that is installed.
pub struct FfmpegPipe {
    path: PathBuf,
    size: (u32, u32),
    file: Option<TemporaryFile>,
    child: Child,
    /// `None` once it is closed.
    input: Option<ChildStdin>,
    /// Gives the last line of what ffmpeg says.
    messages: Option<JoinHandle<String>>,
    /// A row of a picture that is one column wider: scratch.
    row: Vec<u8>,
}

impl FfmpegPipe {
    /// Starts ffmpeg.
    ///
    /// # Errors
    ///
    /// [`OutputError::Video`], where the name does not end in `.mp4`, the file cannot be written or there is no ffmpeg.
    pub fn open(
        path: &Path,
        size: (u32, u32),
        rate: FrameRate,
        options: &FfmpegOptions,
    ) -> Result<FfmpegPipe, OutputError> {
        check_name(path)?;
        FfmpegPipe::start(path, size, rate, options).map_err(|error| OutputError::video(path, error))
    }

    fn start(
        path: &Path,
        size: (u32, u32),
        rate: FrameRate,
        options: &FfmpegOptions,
    ) -> Result<FfmpegPipe, Error> {
        let quantiser = quantiser(options.quality)?;
        let (width, height) = padded_size(size);
        if !(1..=super::super::MAX_SIDE).contains(&size.0) || !(1..=super::super::MAX_SIDE).contains(&size.1)
        {
            return Err(misuse(format!("{} x {} pixels cannot be a video", size.0, size.1)));
        }
        let file = TemporaryFile::beside(path)?;
        let mut command = Command::new(&options.program);
        command.args(["-hide_banner", "-loglevel", "error", "-nostats", "-y"]);
        command.args(["-f", "rawvideo", "-pix_fmt", "rgb24"]);
        command.args([
            "-video_size",
            &format!("{width}x{height}"),
            "-framerate",
            &rate.to_string(),
            "-i",
            "pipe:0",
        ]);
        command.args([
            "-vf",
            "scale=out_color_matrix=bt709:out_range=tv:flags=accurate_rnd+full_chroma_int+bicubic",
        ]);
        command.args(["-c:v", "libx264", "-preset", "medium", "-crf", &quantiser.to_string()]);
        command.args(["-pix_fmt", "yuv420p", "-color_range", "tv", "-colorspace", "bt709"]);
        command.args([
            "-color_primaries",
            "bt709",
            "-color_trc",
            "bt709",
            "-movflags",
            "+faststart",
            "-f",
            "mp4",
        ]);
        command.arg(file.path());
        command.stdin(Stdio::piped()).stdout(Stdio::null()).stderr(Stdio::piped());
        let mut child = command.spawn().map_err(|error| explain_start(&options.program, error))?;
        let input = child.stdin.take();
        let messages = child.stderr.take().map(|errors| std::thread::spawn(move || last_line(errors)));
        let row = Vec::new();
        Ok(FfmpegPipe { path: path.to_owned(), size, file: Some(file), child, input, messages, row })
    }

    /// The next frame.
    ///
    /// # Errors
    ///
    /// [`OutputError::Video`], where it has another size or ffmpeg has ended; then with what ffmpeg said last.
    pub fn write_frame(&mut self, frame: &Developed) -> Result<(), OutputError> {
        let whole = frame.rgb.len() as u64 == self.size.0 as u64 * self.size.1 as u64 * 3;
        if (frame.width, frame.height) != self.size || !whole {
            let error = misuse(format!(
                "a frame of {} x {} pixels for a video of {} x {}",
                frame.width, frame.height, self.size.0, self.size.1
            ));
            return Err(OutputError::video(&self.path, error));
        }
        self.send(frame).map_err(|error| {
            // It ends early for a reason of its own; that the pipe is broken is the consequence.
            let error = self.end().err().unwrap_or(error);
            OutputError::video(&self.path, error)
        })
    }

    /// Odd sides have their last column or row twice.
    fn send(&mut self, frame: &Developed) -> Result<(), Error> {
        let Some(input) = &mut self.input else { return Err(Error::other("ffmpeg has ended")) };
        let (width, height) = padded_size(self.size);
        if (width, height) == self.size {
            return input.write_all(&frame.rgb);
        }
        for y in 0..height {
            let row = frame.row(y.min(self.size.1 - 1));
            self.row.clear();
            self.row.extend_from_slice(row);
            if width > self.size.0 {
                self.row.extend_from_slice(&row[row.len() - 3..]);
            }
            input.write_all(&self.row)?;
        }
        Ok(())
    }

    /// Ends the video and gives the file its name.
    ///
    /// # Errors
    ///
    /// [`OutputError::Video`], with what ffmpeg said last.
    pub fn finish(mut self) -> Result<(), OutputError> {
        let ended = self.end().and_then(|()| match self.file.take() {
            Some(file) => file.keep(),
            None => Err(Error::other("ffmpeg has ended")),
        });
        ended.map_err(|error| OutputError::video(&self.path, error))
    }

    /// Closes the pipe and waits.
    fn end(&mut self) -> Result<(), Error> {
        self.input = None;
        let status = self.child.wait()?;
        let said = self.messages.take().and_then(|thread| thread.join().ok()).unwrap_or_default();
        match status.success() {
            true => Ok(()),
            false if said.is_empty() => Err(Error::other(format!("ffmpeg failed: {status}"))),
            false => Err(Error::other(format!("ffmpeg failed: {said}"))),
        }
    }
}

impl Drop for FfmpegPipe {
    fn drop(&mut self) {
        // Nobody wants the file any more: it goes when `file` is dropped.
        self.input = None;
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// Reads to the end, and keeps the last line that is not empty.
fn last_line(from: impl Read) -> String {
    const LONGEST: usize = 500;
    let mut last = Vec::new();
    let mut from = BufReader::new(from);
    let mut line = Vec::new();
    loop {
        line.clear();
        // A line without an end must not fill the memory.
        match (&mut from).take(1 << 16).read_until(b'\n', &mut line) {
            Ok(0) | Err(_) => break,
            Ok(_) if line.trim_ascii().is_empty() => {}
            Ok(_) => last = line.trim_ascii().to_vec(),
        }
    }
    String::from_utf8_lossy(&last[..last.len().min(LONGEST)]).into_owned()
}

fn explain_start(program: &Path, error: Error) -> Error {
    let name = program.display();
    match error.kind() {
        ErrorKind::NotFound => {
            misuse(format!("there is no program {name}; install ffmpeg, or write the video without it"))
        }
        ErrorKind::PermissionDenied => misuse(format!("{name} may not be run; is it a program?")),
        _ => Error::other(format!("{name} cannot be started: {error}")),
    }
}
