//! What is done of an animation: a file beside the frames that names each that is whole, by size and checksum, and what
//! they were made of.
//!
//! It is text that only grows, a line a frame, so that a program that is killed leaves at most half a line, which is not
//! read.

use crate::output::PICTURE_VERSION;
use std::collections::HashMap;
use std::fs::{self, File, OpenOptions};
use std::io::{self, Read, Write};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

/// The first words of the file.
const TITLE: &str = "eosphor frames 1";

/// Larger ones are not ours: so many bytes are a line for each of the most frames.
const MOST_BYTES: u64 = 1 << 30;

/// What frames are made of. Frames of different ones must not be mixed.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FramesIdentity {
    /// Hash of the scene, its files and settings.
    pub scene: String,
    /// Of how it moves.
    pub animation: String,
    /// Of how colours become files: development, format, quality.
    pub file: String,
}

impl FramesIdentity {
    /// A hash of a text, in hexadecimal digits.
    pub fn hash(text: &str) -> String {
        blake3::hash(text.as_bytes()).to_hex().to_string()
    }
}

/// Why frames cannot be gone on with.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ManifestError {
    /// They were made of something else.
    #[error("cannot resume: {}: the frames there were made {what}: render into another folder, or without --resume", path.display())]
    Stale {
        /// The manifest.
        path: PathBuf,
        /// Of what.
        what: &'static str,
    },
    /// The file is not a manifest.
    #[error("cannot resume: {}: this is no manifest of frames: delete it, or render without --resume", path.display())]
    Malformed {
        /// The manifest.
        path: PathBuf,
    },
    /// It cannot be read or written.
    #[error("cannot keep account of the frames: {}: {source}", path.display())]
    File {
        /// The manifest.
        path: PathBuf,
        /// The system's reason.
        source: io::Error,
    },
}

/// What is done of an animation.
pub struct Manifest {
    path: PathBuf,
    file: Mutex<File>,
    before: Done,
    is_resumed: bool,
}

/// Frames that an earlier run says are done: size and checksum of their files.
type Done = HashMap<u32, (u64, String)>;

impl Manifest {
    /// Begins anew, or, to `resume`, goes on with what is there.
    ///
    /// # Errors
    ///
    /// [`ManifestError::Stale`] where what is there is of another identity, by the reason.
    pub fn open(path: &Path, identity: &FramesIdentity, resume: bool) -> Result<Manifest, ManifestError> {
        let failed = |source| ManifestError::File { path: path.to_owned(), source };
        let before = match resume {
            true => read(path, identity)?,
            false => None,
        };
        let mut open = OpenOptions::new();
        let is_new = before.is_none();
        let file = match is_new {
            true => {
                let mut file = File::create(path).map_err(failed)?;
                file.write_all(header(identity).as_bytes()).map_err(failed)?;
                file
            }
            false => {
                let mut file = open.append(true).open(path).map_err(failed)?;
                // After what may be half a line.
                file.write_all(b"\n").map_err(failed)?;
                file
            }
        };
        let before = before.unwrap_or_default();
        Ok(Manifest { path: path.to_owned(), file: Mutex::new(file), before, is_resumed: !is_new })
    }

    /// Whether this was begun before.
    pub fn is_resumed(&self) -> bool {
        self.is_resumed
    }

    /// Whether a frame is done: its file is there, and is what was noted.
    pub fn is_done(&self, frame: u32, file: &Path) -> bool {
        let Some((size, checksum)) = self.before.get(&frame) else { return false };
        fs::metadata(file).is_ok_and(|data| data.len() == *size)
            && checksum_of(file).is_ok_and(|found| found == *checksum)
    }

    /// Notes that a frame's file is whole.
    ///
    /// # Errors
    ///
    /// [`ManifestError::File`].
    pub fn note(&self, frame: u32, file: &Path) -> Result<(), ManifestError> {
        let failed = |source| ManifestError::File { path: self.path.clone(), source };
        let size = fs::metadata(file).map_err(failed)?.len();
        let line = format!("frame {frame} {size} {}\n", checksum_of(file).map_err(failed)?);
        let mut manifest = self.file.lock().unwrap_or_else(PoisonError::into_inner);
        manifest.write_all(line.as_bytes()).map_err(failed)
    }
}

fn header(identity: &FramesIdentity) -> String {
    let FramesIdentity { scene, animation, file } = identity;
    format!("{TITLE}\npicture {PICTURE_VERSION}\nscene {scene}\nanimation {animation}\nfile {file}\n")
}

/// The frames that are done; `None` where there is no manifest.
fn read(path: &Path, identity: &FramesIdentity) -> Result<Option<Done>, ManifestError> {
    let failed = |source| ManifestError::File { path: path.to_owned(), source };
    let mut bytes = Vec::new();
    match File::open(path) {
        Ok(file) => file.take(MOST_BYTES).read_to_end(&mut bytes).map_err(failed)?,
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(None),
        Err(error) => return Err(failed(error)),
    };
    let text = String::from_utf8_lossy(&bytes);
    let mut lines = text.split('\n');
    // Killed before the header was whole: nothing is done.
    if bytes.is_empty() || TITLE.starts_with(&*text) {
        return Ok(None);
    }
    if lines.next() != Some(TITLE) {
        return Err(ManifestError::Malformed { path: path.to_owned() });
    }
    let expected = header(identity);
    for (line, what) in expected.lines().skip(1).zip([
        "by a version of the program with other pictures",
        "of another scene, or with other settings",
        "with another animation",
        "with other settings of the file",
    ]) {
        match lines.next() {
            Some(found) if found == line => {}
            // The last line may be half one.
            Some(found) if lines.clone().next().is_none() && line.starts_with(found) => return Ok(None),
            None => return Ok(None),
            Some(_) => return Err(ManifestError::Stale { path: path.to_owned(), what }),
        }
    }
    let mut done = Done::new();
    // What is no whole line is left out; the last piece is what comes after the last line end.
    for line in lines {
        let words: Vec<&str> = line.split(' ').collect();
        if let ["frame", frame, size, checksum] = words[..]
            && let (Ok(frame), Ok(size)) = (frame.parse(), size.parse())
            && checksum.len() == 64
        {
            done.insert(frame, (size, checksum.to_owned()));
        }
    }
    Ok(Some(done))
}

/// A BLAKE3 hash, in hexadecimal digits.
fn checksum_of(file: &Path) -> io::Result<String> {
    let mut hasher = blake3::Hasher::new();
    hasher.update_reader(File::open(file)?)?;
    Ok(hasher.finalize().to_hex().to_string())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn identity() -> FramesIdentity {
        FramesIdentity { scene: "abc".into(), animation: "def".into(), file: "ghi".into() }
    }

    #[test]
    fn what_was_noted_is_done_as_long_as_the_file_is_the_same() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("m");
        let frame = |k: u32| folder.path().join(format!("{k}.png"));
        for k in 0..3 {
            fs::write(frame(k), [k as u8; 100]).unwrap();
        }
        let manifest = Manifest::open(&path, &identity(), true).unwrap();
        (0..3).for_each(|k| manifest.note(k, &frame(k)).unwrap());
        assert!(!manifest.is_done(0, &frame(0)), "of an earlier run, that is");
        drop(manifest);
        fs::write(frame(1), [9; 100]).unwrap();
        fs::remove_file(frame(2)).unwrap();
        let manifest = Manifest::open(&path, &identity(), true).unwrap();
        assert_eq!([0, 1, 2, 3].map(|k| manifest.is_done(k, &frame(k))), [true, false, false, false]);
        manifest.note(1, &frame(1)).unwrap();
        drop(manifest);
        assert!(Manifest::open(&path, &identity(), true).unwrap().is_done(1, &frame(1)));
        // Anew.
        assert!(!Manifest::open(&path, &identity(), false).unwrap().is_done(0, &frame(0)));
        assert!(!Manifest::open(&path, &identity(), true).unwrap().is_done(0, &frame(0)));
    }

    #[test]
    fn a_manifest_that_was_cut_off_anywhere_is_read() {
        let folder = tempfile::tempdir().unwrap();
        let (path, frame) = (folder.path().join("m"), folder.path().join("0.png"));
        fs::write(&frame, b"x").unwrap();
        let manifest = Manifest::open(&path, &identity(), false).unwrap();
        manifest.note(0, &frame).unwrap();
        drop(manifest);
        let whole = fs::read(&path).unwrap();
        for length in 0..=whole.len() {
            fs::write(&path, &whole[..length]).unwrap();
            let manifest = Manifest::open(&path, &identity(), true).unwrap();
            // The line end may be missing: the line is whole without it.
            assert_eq!(manifest.is_done(0, &frame), length + 1 >= whole.len(), "{length}");
            manifest.note(0, &frame).unwrap();
            drop(manifest);
            assert!(Manifest::open(&path, &identity(), true).unwrap().is_done(0, &frame), "{length}");
        }
    }

    #[test]
    fn other_frames_are_refused_with_the_reason() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("m");
        drop(Manifest::open(&path, &identity(), false).unwrap());
        let other = |change: fn(&mut FramesIdentity)| {
            let mut identity = identity();
            change(&mut identity);
            Manifest::open(&path, &identity, true).err().unwrap().to_string()
        };
        assert!(other(|i| i.scene = "x".into()).contains("another scene"));
        assert!(other(|i| i.animation = "x".into()).contains("another animation"));
        assert!(other(|i| i.file = "x".into()).contains("settings of the file"));
        let text = fs::read_to_string(&path).unwrap();
        fs::write(&path, text.replace("picture ", "picture 9")).unwrap();
        assert!(other(|_| {}).contains("version"));
        fs::write(&path, "my notes\n").unwrap();
        assert!(other(|_| {}).contains("no manifest"));
    }
}
