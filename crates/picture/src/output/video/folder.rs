//! The folder that a video is made in, `OUT.mp4.part`. Every file in it is whole or not there, so what is there after a
//! program was killed can be used.

use super::super::{OutputError, atomic, atomic::TemporaryFile};
use super::segment::Segment;
use super::settings::Settings;
use super::{damaged, frame, misuse};
use crate::locked_file::LockedFile;
use rayon::prelude::*;
use std::ffi::OsStr;
use std::fs::{self, File, TryLockError};
use std::io::{Error, ErrorKind, Write};
use std::path::{Path, PathBuf};

const SETTINGS: &str = "settings.json";
const LOCK: &str = "lock";

/// The folder, while one program works in it.
pub(super) struct Folder {
    path: PathBuf,
    settings: Settings,
    _lock: LockedFile,
}

/// What is whole in it.
pub(super) struct Found {
    /// Segments that are encoded.
    pub(super) segments: Vec<bool>,
    /// Frames that are stored or in an encoded segment.
    pub(super) frames: Vec<bool>,
}

impl Folder {
    /// The folder of the video at `path`; beside the file itself where that is a link.
    pub(super) fn of(path: &Path) -> Result<PathBuf, OutputError> {
        let target = atomic::resolve(path).map_err(|error| OutputError::video(path, error))?;
        Ok(with_ending(&target, ".part"))
    }

    /// Makes the folder of the video at `path`, or goes on with one that was left.
    pub(super) fn open(path: &Path, settings: Settings) -> Result<(Folder, Found), OutputError> {
        let folder = Folder::of(path)?;
        let left = finished(&folder);
        if is_ours(&left) {
            remove(&left).map_err(|error| OutputError::video(&left, error))?;
        }
        let is_new = match create(&folder, path) {
            Ok(()) => true,
            Err(error) if error.kind() == ErrorKind::AlreadyExists => false,
            Err(error) => return Err(OutputError::video(path, error)),
        };
        let in_folder = |error| OutputError::video(&folder, error);
        if fs::metadata(&folder).is_ok_and(|data| !data.is_dir()) {
            return Err(in_folder(misuse(
                "the frames go to a folder of this name, and it is a file; rename it",
            )));
        }
        let lock = lock(&folder).map_err(in_folder)?;
        if let Err(error) = read_settings(&folder, &settings) {
            if is_new {
                // It would say nothing to anybody.
                let _ = fs::remove_dir_all(&folder);
            }
            return Err(in_folder(error));
        }
        let folder = Folder { path: folder, settings, _lock: lock };
        let found = folder.scan()?;
        Ok((folder, found))
    }

    pub(super) fn path(&self) -> &Path {
        &self.path
    }

    pub(super) fn settings(&self) -> &Settings {
        &self.settings
    }

    pub(super) fn frame(&self, number: u32) -> PathBuf {
        self.path.join(format!("frame-{number:07}.png"))
    }

    pub(super) fn segment(&self, number: u32) -> PathBuf {
        self.path.join(format!("segment-{number:06}.h264"))
    }

    pub(super) fn open_segment(&self, number: u32) -> Result<Segment, OutputError> {
        let path = self.segment(number);
        let frames = self.settings.frames_of(number).len() as u32;
        Segment::open(&path, number, frames).map_err(|error| OutputError::video(&path, error))
    }

    /// Removes frames that are in an encoded segment. One that cannot be removed is in nobody's way: it goes with the
    /// folder.
    pub(super) fn remove_frames(&self, segment: u32) {
        for number in self.settings.frames_of(segment) {
            let _ = fs::remove_file(self.frame(number));
        }
    }

    /// Removes the folder. First it loses its name, so that half of it is never taken for a video in the making.
    pub(super) fn remove(self) -> Result<(), OutputError> {
        let Folder { path, _lock: lock, .. } = self;
        // Some systems remove no file that is open.
        drop(lock);
        Folder::discard(&path)
    }

    /// Removes a folder that nobody works in.
    fn discard(folder: &Path) -> Result<(), OutputError> {
        let away = finished(folder);
        let removed = fs::rename(folder, &away).and_then(|()| remove(&away));
        removed.map_err(|error| OutputError::video(folder, error))
    }

    /// Deletes the folder that an interrupted video has left, if there is one. Fails where the folder is not a video's.
    pub(super) fn discard_left(path: &Path) -> Result<(), OutputError> {
        let folder = Folder::of(path)?;
        if !folder.exists() {
            return Ok(());
        }
        let in_folder = |error| OutputError::video(&folder, error);
        if !is_ours(&folder) {
            return Err(in_folder(not_ours()));
        }
        drop(lock(&folder).map_err(in_folder)?);
        Folder::discard(&folder)
    }

    /// Reads all that is there. What is damaged is removed, and so are temporary files and frames that were encoded.
    fn scan(&self) -> Result<Found, OutputError> {
        let mut segments = vec![false; self.settings.segments() as usize];
        let mut frames = vec![false; self.settings.frames as usize];
        let mut stored = Vec::new();
        let entries = fs::read_dir(&self.path).map_err(|error| OutputError::video(&self.path, error))?;
        for entry in entries {
            let name = entry.map_err(|error| OutputError::video(&self.path, error))?.file_name();
            let Some(name) = name.to_str() else { continue };
            let number =
                |prefix, suffix| name.strip_prefix(prefix)?.strip_suffix(suffix)?.parse::<u32>().ok();
            if name.starts_with(atomic::TEMPORARY.0) && name.ends_with(atomic::TEMPORARY.1) {
                let _ = fs::remove_file(self.path.join(name));
            } else if let Some(number) = number("frame-", ".png").filter(|&n| n < self.settings.frames) {
                stored.push(number);
            } else if let Some(number) = number("segment-", ".h264").filter(|&n| n < self.settings.segments())
            {
                segments[number as usize] = whole(&self.segment(number), self.open_segment(number))?;
            }
        }
        for segment in (0..self.settings.segments()).filter(|&segment| segments[segment as usize]) {
            let range = self.settings.frames_of(segment);
            frames[range.start as usize..range.end as usize].fill(true);
        }
        // Killed between writing a segment and removing its frames.
        let (encoded, stored): (Vec<u32>, Vec<u32>) = stored.into_iter().partition(|&n| frames[n as usize]);
        for number in encoded {
            let _ = fs::remove_file(self.frame(number));
        }
        let size = (self.settings.width, self.settings.height);
        let checked = stored.into_par_iter().map(|number| {
            let path = self.frame(number);
            let read = frame::read(&path, size).map_err(|error| OutputError::video(&path, error));
            whole(&path, read).map(|whole| (number, whole))
        });
        for (number, whole) in checked.collect::<Result<Vec<_>, OutputError>>()? {
            frames[number as usize] = whole;
        }
        Ok(Found { segments, frames })
    }
}

/// Whether a file that was read is whole. One that is not is removed, so that it is made again.
fn whole<T>(path: &Path, read: Result<T, OutputError>) -> Result<bool, OutputError> {
    match read {
        Ok(_) => Ok(true),
        Err(OutputError::Video { source, .. }) if source.kind() == ErrorKind::InvalidData => {
            fs::remove_file(path).map(|()| false).map_err(|error| OutputError::video(path, error))
        }
        Err(error) => Err(error),
    }
}

/// Makes the folder, which only those may enter who may read the video that is there.
fn create(folder: &Path, video: &Path) -> Result<(), Error> {
    let mut builder = fs::DirBuilder::new();
    #[cfg(unix)]
    {
        use std::os::unix::fs::DirBuilderExt;
        builder.mode(atomic::mode_before_rights(video, 0o777));
    }
    builder.create(folder)?;
    if video.exists()
        && let Ok(folder) = File::open(folder)
    {
        atomic::take_rights_of(video, &folder, 0o700);
    }
    Ok(())
}

/// Where the folder goes to be removed.
fn finished(folder: &Path) -> PathBuf {
    folder.with_extension("done")
}

fn with_ending(path: &Path, ending: &str) -> PathBuf {
    let mut name = path.as_os_str().to_owned();
    name.push(ending);
    name.into()
}

/// Whether a video was made in it, or it is about to be.
fn is_ours(folder: &Path) -> bool {
    folder.join(SETTINGS).is_file()
}

fn not_ours() -> Error {
    misuse("there is a folder of this name, but no video was made in it; rename or remove it")
}

fn remove(folder: &Path) -> Result<(), Error> {
    // The settings go last: a folder without them is not taken for one of ours.
    for entry in fs::read_dir(folder)? {
        let name = entry?.file_name();
        if name != OsStr::new(SETTINGS) {
            fs::remove_file(folder.join(name))?;
        }
    }
    fs::remove_file(folder.join(SETTINGS))?;
    fs::remove_dir(folder)
}

/// Fails where another program works in the folder. A lock ends with its program, however that ends. Some file systems
/// have none; they go without.
fn lock(folder: &Path) -> Result<LockedFile, Error> {
    let file = File::options().create(true).truncate(false).write(true).open(folder.join(LOCK))?;
    match file.try_lock() {
        Err(TryLockError::WouldBlock) => {
            Err(misuse("another program is making this video; wait for it, or choose another name"))
        }
        Ok(()) | Err(TryLockError::Error(_)) => Ok(LockedFile::of(file)),
    }
}

/// Compares the settings of a folder that was left, or writes those of a new one.
fn read_settings(folder: &Path, settings: &Settings) -> Result<(), Error> {
    let path = folder.join(SETTINGS);
    let text = match fs::read(&path) {
        Ok(text) => text,
        Err(error) if error.kind() == ErrorKind::NotFound => return begin(folder, &path, settings),
        Err(error) => return Err(error),
    };
    let there: Settings = serde_json::from_slice(&text)
        .map_err(|_| damaged("its settings.json cannot be read; remove the folder to start anew"))?;
    match there.difference(settings) {
        Some(difference) => Err(misuse(format!(
            "a video that was begun there has another {difference}; choose the same, another name, or remove the \
             folder to start anew"
        ))),
        None => Ok(()),
    }
}

fn begin(folder: &Path, path: &Path, settings: &Settings) -> Result<(), Error> {
    for entry in fs::read_dir(folder)? {
        let name = entry?.file_name();
        let temporary = name.as_encoded_bytes().starts_with(atomic::TEMPORARY.0.as_bytes());
        if name != OsStr::new(LOCK) && !temporary {
            return Err(not_ours());
        }
    }
    let file = TemporaryFile::beside(path)?;
    file.handle()?.write_all(&serde_json::to_vec(settings)?)?;
    file.keep()
}
