//! Who has which frames in work: each process has a folder beside the frames, where its files are until they are whole, with
//! a file that names its frames and is locked for as long as the process lives.

use crate::locked_file::LockedFile;
use crate::process::this_process;
use std::fs::{self, File, OpenOptions, TryLockError};
use std::io::{self, Read, Seek, SeekFrom, Write};
use std::ops::Range;
use std::path::{Path, PathBuf};

/// The locked file in the folder.
const FILE: &str = "claims";

/// Most bytes of a file of claims: two numbers per frame that one process has in work.
const MAX_CLAIMS_BYTES: u64 = 1 << 16;

/// Frames that this process has in work.
pub(super) struct Claims {
    folder: PathBuf,
    file: LockedFile,
}

/// Another process that is at work.
pub(super) struct Other {
    /// Who, as `process 4711 on alpha`.
    pub(super) owner: String,
    pub(super) frames: Vec<Range<u32>>,
}

impl Other {
    /// Whether it has one of these frames.
    pub(super) fn has_any(&self, frames: &Range<u32>) -> bool {
        self.frames.iter().any(|own| own.start < frames.end && frames.start < own.end)
    }
}

/// What folders of processes begin and end with, for frames whose manifest begins with `stem`.
fn names(stem: &Path) -> (String, &'static str) {
    let name = stem.file_name().unwrap_or_default().to_string_lossy();
    (format!("{name}."), ".part")
}

fn folder_of(stem: &Path) -> &Path {
    stem.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

/// Those that are at work. What dead ones have left is removed.
pub(super) fn others(stem: &Path) -> io::Result<Vec<Other>> {
    let (begin, end) = names(stem);
    let mut others = Vec::new();
    for entry in fs::read_dir(folder_of(stem))? {
        let path = entry?.path();
        let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        let is_one = name.strip_prefix(&begin).and_then(|name| name.strip_suffix(end));
        // (A video in the making is a folder without such a file.)
        if !is_one.is_some_and(|name| name.contains('@')) {
            continue;
        }
        let Ok(mut file) = OpenOptions::new().read(true).write(true).open(path.join(FILE)) else {
            // It has been killed before it had the file, or has just ended.
            let _ = fs::remove_dir_all(&path);
            continue;
        };
        match file.try_lock() {
            Err(TryLockError::WouldBlock) => others.push(read(&mut file)),
            // Where the file system has no locks, nobody can be asked.
            Ok(()) | Err(TryLockError::Error(_)) => {
                let _ = fs::remove_dir_all(&path);
            }
        }
    }
    Ok(others)
}

fn read(file: &mut File) -> Other {
    let mut text = String::new();
    // What cannot be read has no frames; it is at work all the same.
    let _ = file.take(MAX_CLAIMS_BYTES).read_to_string(&mut text);
    let mut lines = text.lines();
    let owner = lines.next().unwrap_or("another process").to_owned();
    let range = |line: &str| {
        let (start, end) = line.split_once("..")?;
        Some(start.parse().ok()?..end.parse().ok()?)
    };
    Other { owner, frames: lines.filter_map(range).collect() }
}

impl Claims {
    /// Claims of this process, on no frames yet. Nobody else must look for claims meanwhile.
    pub(super) fn new(stem: &Path) -> io::Result<Claims> {
        let (begin, end) = names(stem);
        let owner = this_process();
        let host = owner.split(' ').next_back().unwrap_or_default().replace(['/', '\\', '%'], "-");
        let folder = (0..u32::MAX)
            .map(|number| match number {
                0 => format!("{begin}{}@{host}{end}", std::process::id()),
                // A thread of this process has the same frames in work, or a namesake of its host.
                _ => format!("{begin}{}-{number}@{host}{end}", std::process::id()),
            })
            .map(|name| folder_of(stem).join(name))
            .find(|folder| !folder.exists())
            .unwrap_or_default();
        fs::create_dir(&folder)?;
        let file = || {
            let mut options = OpenOptions::new();
            let file = options.read(true).write(true).create(true).truncate(true).open(folder.join(FILE))?;
            match file.try_lock() {
                Err(TryLockError::Error(error)) if error.kind() != io::ErrorKind::Unsupported => Err(error),
                _ => Ok(LockedFile::of(file)),
            }
        };
        match file() {
            Ok(file) => Ok(Claims { folder, file }),
            Err(error) => {
                let _ = fs::remove_dir_all(&folder);
                Err(error)
            }
        }
    }

    /// For files that are not whole yet.
    pub(super) fn folder(&self) -> &Path {
        &self.folder
    }

    /// Says which frames it has in work.
    pub(super) fn set(&mut self, frames: &[Range<u32>]) -> io::Result<()> {
        let ranges: Vec<String> =
            frames.iter().map(|range| format!("{}..{}\n", range.start, range.end)).collect();
        let text = format!("{}\n{}", this_process(), ranges.concat());
        self.file.seek(SeekFrom::Start(0))?;
        self.file.set_len(0)?;
        self.file.write_all(text.as_bytes())
    }
}

impl Drop for Claims {
    fn drop(&mut self) {
        // There is nobody to tell; whoever looks next removes it.
        let _ = fs::remove_dir_all(&self.folder);
    }
}
