//! What is done of an animation: a file beside the frames that names each that is whole, by size and checksum, and what
//! they were made of. Several processes may render frames of one animation; all of them have this one file.
//!
//! It is text that only grows, a line a frame, so that a program that is killed leaves at most half a line, which is not
//! read. The last one that is at work puts the lines in order when it comes to its end.

use super::claims::{Claims, Other, others};
use crate::output::{PICTURE_VERSION, explain};
use std::collections::BTreeMap;
use std::fs::{self, File, OpenOptions};
use std::io::{self, Read, Seek, SeekFrom, Write};
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

/// The first words of the file.
const TITLE: &str = "eosphor frames 1";

/// Most bytes of a manifest: a line for each frame of the longest animation. Larger files are not ours.
const MAX_MANIFEST_BYTES: u64 = 1 << 30;

/// What frames are made of. Frames of different ones must not be mixed.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FramesIdentity {
    /// Hash of the scene, its files and settings.
    pub scene: String,
    /// Hash of how the scene moves.
    pub animation: String,
    /// Hash of how colours become files: development, format, quality.
    pub file: String,
    /// What else they are made by, in words: names and values, for messages.
    pub stated: Vec<(&'static str, String)>,
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
    /// The frames that are there were made of something else.
    #[error("cannot resume: {}: the frames there were made {what}: render into another folder, or without resuming", path.display())]
    Stale {
        /// The manifest.
        path: PathBuf,
        /// What the frames that are there were made of, in words.
        what: String,
    },
    /// The file is not a manifest.
    #[error("cannot resume: {}: this is no manifest of frames: delete it, or render without resuming", path.display())]
    Malformed {
        /// The manifest.
        path: PathBuf,
    },
    /// Another process has some of the frames in work, or frames of something else under these names.
    #[error("{}: {owner} has {what} in work: wait for it, or render to files of other names", path.display())]
    InUse {
        /// The manifest.
        path: PathBuf,
        /// Who.
        owner: String,
        /// Which frames.
        what: String,
        /// Whether the other process renders frames of the same sequence, so that other frames of it can be rendered
        /// meanwhile.
        is_same: bool,
    },
    /// The manifest cannot be read or written.
    #[error("cannot keep account of the frames: {}: {}", path.display(), explain(source))]
    File {
        /// The manifest.
        path: PathBuf,
        /// The system's reason.
        source: io::Error,
    },
}

/// Which frames a process is to render.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Wanted {
    /// All of these, which nobody else may have in work, whatever is done of them.
    Anew(Range<u32>),
    /// The frames of this range that are not done; no other process may work on the range.
    Missing(Range<u32>),
    /// The frames of this range that are neither done nor another process's work ([`Manifest::claim`]).
    Shared(Range<u32>),
}

/// What is done of an animation, and which frames this process has in work.
pub struct Manifest {
    path: PathBuf,
    header: String,
    wanted: Wanted,
    /// What was done when it was opened.
    before: Done,
    /// There was a manifest of the same.
    is_resumed: bool,
    state: Mutex<State>,
}

struct State {
    claims: Claims,
    /// Frames of a shared sequence that this process has in work.
    in_work: Vec<u32>,
}

/// Frames that are done: size and checksum of their files.
type Done = BTreeMap<u32, (u64, String)>;

impl Manifest {
    /// Opens or makes the file, and claims frames.
    ///
    /// # Errors
    ///
    /// [`ManifestError::Stale`] where what is there is of another identity and is to be gone on with, by the reason;
    /// [`ManifestError::InUse`] where other processes have frames in work that this one wants.
    pub fn open(path: &Path, identity: &FramesIdentity, wanted: Wanted) -> Result<Manifest, ManifestError> {
        let failed = |source| ManifestError::File { path: path.to_owned(), source };
        let stem = path.with_extension("");
        let mut file = lock(path).map_err(failed)?;
        let others = others(&stem).map_err(failed)?;
        let (Wanted::Anew(frames) | Wanted::Missing(frames) | Wanted::Shared(frames)) = &wanted;
        let in_use = |other: &Other, what: &str, is_same| {
            let (path, owner) = (path.to_owned(), other.owner.clone());
            Err(ManifestError::InUse { path, owner, what: what.into(), is_same })
        };
        let mut found = read(&mut file, path, identity);
        if let (Err(ManifestError::Stale { .. } | ManifestError::Malformed { .. }), Some(other)) =
            (&found, others.first())
        {
            return in_use(other, "frames of something else", false);
        }
        if !matches!(wanted, Wanted::Shared(_))
            && let Some(other) = others.iter().find(|other| other.has_any(frames))
        {
            return in_use(other, "some of these frames", true);
        }
        if let Wanted::Anew(frames) = &wanted {
            // What there is of other frames of the same stays.
            found = Ok(found.ok().flatten().map(|mut done| {
                done.retain(|frame, _| !frames.contains(frame));
                done
            }));
            if let (Ok(Some(done)), true) = (&found, others.is_empty()) {
                let text = header(identity) + &lines(done);
                crate::output::write_whole(path, text.as_bytes()).map_err(failed)?;
            }
        }
        let found = found?;
        let (header, is_resumed) = (header(identity), found.is_some());
        let mut begin = || {
            if !is_resumed {
                file.set_len(0)?;
                file.seek(SeekFrom::Start(0))?;
                file.write_all(header.as_bytes())?;
            }
            let mut claims = Claims::new(&stem)?;
            if !matches!(wanted, Wanted::Shared(_)) {
                claims.set(std::slice::from_ref(frames))?;
            }
            Ok(claims)
        };
        let claims = begin().map_err(|error| {
            if !is_resumed && others.is_empty() {
                // It would say nothing to anybody.
                let _ = fs::remove_file(path);
            }
            failed(error)
        })?;
        let state = Mutex::new(State { claims, in_work: Vec::new() });
        Ok(Manifest {
            path: path.to_owned(),
            header,
            before: found.unwrap_or_default(),
            wanted,
            is_resumed,
            state,
        })
    }

    /// Whether an earlier run had begun this sequence.
    pub fn is_resumed(&self) -> bool {
        self.is_resumed
    }

    /// A folder of this process for files that are not whole yet. It goes with it.
    pub fn part(&self) -> PathBuf {
        self.state.lock().unwrap_or_else(PoisonError::into_inner).claims.folder().to_owned()
    }

    /// Whether a frame was done when this was opened: its file is there, and is what was noted.
    pub fn is_done(&self, frame: u32, file: &Path) -> bool {
        is_done(&self.before, frame, file)
    }

    /// Takes a frame for this process. `false` where frames are shared and somebody else has it in work, or has done it.
    ///
    /// # Errors
    ///
    /// [`ManifestError::File`].
    pub fn claim(&self, frame: u32, file: &Path) -> Result<bool, ManifestError> {
        if !matches!(self.wanted, Wanted::Shared(_)) {
            return Ok(true);
        }
        let failed = |source| ManifestError::File { path: self.path.clone(), source };
        let mut state = self.state.lock().unwrap_or_else(PoisonError::into_inner);
        // Until the end of this, nobody else looks.
        let mut manifest = lock(&self.path).map_err(failed)?;
        let mut text = Vec::new();
        manifest.seek(SeekFrom::Start(0)).map_err(failed)?;
        (&mut manifest).take(MAX_MANIFEST_BYTES).read_to_end(&mut text).map_err(failed)?;
        if is_done(&parse(&String::from_utf8_lossy(&text)), frame, file) {
            return Ok(false);
        }
        let own = self.path.with_extension("");
        let others = others(&own).map_err(failed)?;
        if others.iter().any(|other| other.has_any(&(frame..frame + 1))) {
            return Ok(false);
        }
        state.in_work.push(frame);
        state.tell().map_err(failed)?;
        Ok(true)
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
        let mut state = self.state.lock().unwrap_or_else(PoisonError::into_inner);
        let mut manifest = lock(&self.path).map_err(failed)?;
        append(&mut manifest, &line).map_err(failed)?;
        if let Some(at) = state.in_work.iter().position(|other| *other == frame) {
            state.in_work.swap_remove(at);
            state.tell().map_err(failed)?;
        }
        Ok(())
    }

    /// This process has done its frames. Where it is the last one, the file is what one undisturbed process leaves.
    ///
    /// # Errors
    ///
    /// [`ManifestError::File`].
    pub fn finish(self) -> Result<(), ManifestError> {
        let Manifest { path, header, state, .. } = self;
        let failed = |source| ManifestError::File { path: path.clone(), source };
        let mut file = lock(&path).map_err(failed)?;
        drop(state);
        if others(&path.with_extension("")).map_err(failed)?.is_empty() {
            in_order(&mut file, &path, &header).map_err(failed)?;
        }
        Ok(())
    }

    /// Nothing was begun: a file that was made for it goes.
    pub fn abandon(self) {
        if !self.is_resumed {
            // There is nobody to tell; a manifest without frames does no harm.
            let _ = fs::remove_file(&self.path);
        }
    }
}

impl State {
    /// Says which frames are in work.
    fn tell(&mut self) -> io::Result<()> {
        let frames: Vec<Range<u32>> = self.in_work.iter().map(|frame| *frame..frame + 1).collect();
        self.claims.set(&frames)
    }
}

/// Opens the file, which nobody else can do then until it is closed.
fn lock(path: &Path) -> io::Result<File> {
    loop {
        let mut options = OpenOptions::new();
        let file = options.read(true).write(true).create(true).truncate(false).open(path)?;
        match file.lock() {
            Err(error) if error.kind() != io::ErrorKind::Unsupported => return Err(error),
            _ => {}
        }
        // Whoever had it may have put another one in its place.
        if is_at(&file, path) {
            return Ok(file);
        }
    }
}

#[cfg(unix)]
fn is_at(file: &File, path: &Path) -> bool {
    use std::os::unix::fs::MetadataExt;
    let number = |data: fs::Metadata| (data.dev(), data.ino());
    file.metadata().map(number).ok() == fs::metadata(path).map(number).ok()
}

/// There, a file that is open cannot be replaced.
#[cfg(not(unix))]
fn is_at(_file: &File, _path: &Path) -> bool {
    true
}

/// Writes a line at the end, which may be half a line.
fn append(file: &mut File, line: &str) -> io::Result<()> {
    let end = file.seek(SeekFrom::End(0))?;
    let mut last = [b'\n'];
    if end > 0 {
        file.seek(SeekFrom::Start(end - 1))?;
        file.read_exact(&mut last)?;
    }
    let begin = if last == [b'\n'] { "" } else { "\n" };
    file.write_all(format!("{begin}{line}").as_bytes())
}

/// Puts the lines in order, in a new file that takes the place of this one.
fn in_order(file: &mut File, path: &Path, header: &str) -> io::Result<()> {
    let mut text = Vec::new();
    file.seek(SeekFrom::Start(0))?;
    file.take(MAX_MANIFEST_BYTES).read_to_end(&mut text)?;
    let text = String::from_utf8_lossy(&text);
    let ordered = header.to_owned() + &lines(&parse(&text));
    match ordered == text {
        true => Ok(()),
        false => crate::output::write_whole(path, ordered.as_bytes()),
    }
}

fn is_done(done: &Done, frame: u32, file: &Path) -> bool {
    let Some((size, checksum)) = done.get(&frame) else { return false };
    fs::metadata(file).is_ok_and(|data| data.len() == *size)
        && checksum_of(file).is_ok_and(|found| found == *checksum)
}

fn header(identity: &FramesIdentity) -> String {
    let FramesIdentity { scene, animation, file, stated } = identity;
    // In words first: these are among what the hashes are of.
    let stated: String = stated.iter().map(|(name, value)| format!("{name}: {value}\n")).collect();
    format!("{TITLE}\npicture {PICTURE_VERSION}\n{stated}scene {scene}\nanimation {animation}\nfile {file}\n")
}

/// The frames that are done; `None` where there is no manifest.
fn read(file: &mut File, path: &Path, identity: &FramesIdentity) -> Result<Option<Done>, ManifestError> {
    let failed = |source| ManifestError::File { path: path.to_owned(), source };
    let mut bytes = Vec::new();
    file.seek(SeekFrom::Start(0)).map_err(failed)?;
    file.take(MAX_MANIFEST_BYTES).read_to_end(&mut bytes).map_err(failed)?;
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
    for line in expected.lines().skip(1) {
        match lines.next() {
            Some(found) if found == line => {}
            // The last line may be half one.
            Some(found) if lines.clone().next().is_none() && line.starts_with(found) => return Ok(None),
            None => return Ok(None),
            Some(found) => {
                return Err(ManifestError::Stale { path: path.to_owned(), what: difference(found, line) });
            }
        }
    }
    Ok(Some(parse(&text)))
}

/// How frames were made, by a line of the header that is not the one that it should be.
fn difference(found: &str, expected: &str) -> String {
    let what = match expected.split(' ').next().unwrap_or_default() {
        "picture" => "by a version of the program with other pictures",
        "scene" => "of another scene, or with other settings",
        "animation" => "with another animation",
        "file" => "with other settings of the file",
        _ => match (found.split_once(": "), expected.split_once(": ")) {
            (Some((name, found)), Some((wanted, value))) if name == wanted => {
                return format!("with another {name}: {found}, not {value}");
            }
            _ => "with other settings of the file",
        },
    };
    what.to_owned()
}

/// The lines of frames, in their order.
fn lines(done: &Done) -> String {
    done.iter().map(|(frame, (size, checksum))| format!("frame {frame} {size} {checksum}\n")).collect()
}

/// The frames that a manifest names.
fn parse(text: &str) -> Done {
    let mut done = Done::new();
    // What is no whole line is left out; the last piece is what comes after the last line end.
    for line in text.split('\n') {
        let words: Vec<&str> = line.split(' ').collect();
        if let ["frame", frame, size, checksum] = words[..]
            && let (Ok(frame), Ok(size)) = (frame.parse(), size.parse())
            && checksum.len() == 64
        {
            done.insert(frame, (size, checksum.to_owned()));
        }
    }
    done
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
        FramesIdentity {
            scene: "abc".into(),
            animation: "def".into(),
            file: "ghi".into(),
            stated: vec![("size", "4 x 3".into())],
        }
    }

    fn open(path: &Path, wanted: Wanted) -> Manifest {
        Manifest::open(path, &identity(), wanted).unwrap()
    }

    fn refused(path: &Path, identity: &FramesIdentity, wanted: Wanted) -> String {
        Manifest::open(path, identity, wanted).err().unwrap().to_string()
    }

    const ALL: Range<u32> = 0..9;

    #[test]
    fn what_was_noted_is_done_as_long_as_the_file_is_the_same() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("m.manifest");
        let frame = |k: u32| folder.path().join(format!("{k}.png"));
        for k in 0..3 {
            fs::write(frame(k), [k as u8; 100]).unwrap();
        }
        let manifest = open(&path, Wanted::Missing(ALL));
        (0..3).for_each(|k| manifest.note(k, &frame(k)).unwrap());
        assert!(!manifest.is_done(0, &frame(0)), "of an earlier run, that is");
        drop(manifest);
        fs::write(frame(1), [9; 100]).unwrap();
        fs::remove_file(frame(2)).unwrap();
        let manifest = open(&path, Wanted::Missing(ALL));
        assert_eq!([0, 1, 2, 3].map(|k| manifest.is_done(k, &frame(k))), [true, false, false, false]);
        manifest.note(1, &frame(1)).unwrap();
        drop(manifest);
        // Of whichever frames are asked for.
        assert!(open(&path, Wanted::Missing(1..2)).is_done(1, &frame(1)));
        assert!(!open(&path, Wanted::Anew(ALL)).is_done(0, &frame(0)));
        assert!(!open(&path, Wanted::Missing(ALL)).is_done(0, &frame(0)));
    }

    #[test]
    fn a_manifest_that_was_cut_off_anywhere_is_read() {
        let folder = tempfile::tempdir().unwrap();
        let (path, frame) = (folder.path().join("m.manifest"), folder.path().join("0.png"));
        fs::write(&frame, b"x").unwrap();
        let manifest = open(&path, Wanted::Anew(ALL));
        manifest.note(0, &frame).unwrap();
        manifest.finish().unwrap();
        let whole = fs::read(&path).unwrap();
        for length in 0..=whole.len() {
            fs::write(&path, &whole[..length]).unwrap();
            let manifest = open(&path, Wanted::Missing(ALL));
            // The line end may be missing: the line is whole without it.
            assert_eq!(manifest.is_done(0, &frame), length + 1 >= whole.len(), "{length}");
            manifest.note(0, &frame).unwrap();
            manifest.finish().unwrap();
            assert!(fs::read(&path).unwrap() == whole, "{length}: as if nothing had happened");
        }
    }

    #[test]
    fn other_frames_are_refused_with_the_reason() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("m.manifest");
        drop(open(&path, Wanted::Anew(ALL)));
        let other = |change: fn(&mut FramesIdentity)| {
            let mut identity = identity();
            change(&mut identity);
            refused(&path, &identity, Wanted::Missing(ALL))
        };
        assert!(other(|i| i.scene = "x".into()).contains("another scene"));
        // What can be said in words is.
        let wider = other(|i| (i.scene, i.stated[0].1) = ("x".into(), "5 x 3".into()));
        assert!(wider.contains("made with another size: 4 x 3, not 5 x 3: "), "{wider}");
        assert!(other(|i| i.stated[0].0 = "width").contains("other settings of the file"));
        assert!(other(|i| i.animation = "x".into()).contains("another animation"));
        assert!(other(|i| i.file = "x".into()).contains("settings of the file"));
        let text = fs::read_to_string(&path).unwrap();
        fs::write(&path, text.replace("picture ", "picture 9")).unwrap();
        assert!(other(|_| {}).contains("version"));
        fs::write(&path, "my notes\n").unwrap();
        assert!(other(|_| {}).contains("no manifest"));
    }

    #[test]
    fn frames_are_of_one_process_at_a_time() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("m.manifest");
        let frame = |k: u32| folder.path().join(format!("{k}.png"));
        let first = open(&path, Wanted::Anew(0..3));
        let reason = refused(&path, &identity(), Wanted::Missing(2..4));
        assert!(reason.contains(&format!("process {}", std::process::id())), "{reason}");
        let other = FramesIdentity { scene: "x".into(), ..identity() };
        assert!(refused(&path, &other, Wanted::Anew(5..6)).contains("something else"));
        let second = open(&path, Wanted::Anew(3..6));
        assert!(first.part() != second.part() && first.part().is_dir());
        for (manifest, k) in [(&first, 0), (&second, 4), (&first, 2), (&second, 3)] {
            fs::write(frame(k), [k as u8]).unwrap();
            manifest.note(k, &frame(k)).unwrap();
        }
        let part = second.part();
        second.finish().unwrap();
        assert!(!part.exists());
        // Of what others have done nothing is lost.
        let third = open(&path, Wanted::Anew(3..5));
        assert!(!third.is_done(3, &frame(3)));
        third.finish().unwrap();
        first.finish().unwrap();
        let last = open(&path, Wanted::Missing(0..9));
        let done: Vec<u32> = (0..9).filter(|k| last.is_done(*k, &frame(*k))).collect();
        assert_eq!(done, [0, 2, 3, 4]);
        drop(last);
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1 + 4, "no folder is left");
        let numbers: Vec<String> =
            fs::read_to_string(&path).unwrap().lines().skip(6).map(|l| l[6..7].into()).collect();
        assert_eq!(numbers, ["0", "2", "3", "4"], "in order");
    }

    #[test]
    fn shared_frames_are_taken_once() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("m.manifest");
        let frame = |k: u32| folder.path().join(format!("{k}.png"));
        let taken = Mutex::new(Vec::new());
        std::thread::scope(|scope| {
            for _ in 0..3 {
                scope.spawn(|| {
                    let manifest = open(&path, Wanted::Shared(ALL));
                    for k in ALL {
                        if manifest.claim(k, &frame(k)).unwrap() {
                            fs::write(frame(k), [k as u8]).unwrap();
                            manifest.note(k, &frame(k)).unwrap();
                            taken.lock().unwrap().push(k);
                        }
                    }
                    manifest.finish().unwrap();
                });
            }
        });
        let mut taken = taken.into_inner().unwrap();
        taken.sort();
        assert_eq!(taken, ALL.collect::<Vec<u32>>());
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1 + 9);
    }

    #[test]
    fn what_the_dead_have_left_is_removed() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("m.manifest");
        let dead = folder.path().join("m.1@nowhere.part");
        fs::create_dir(&dead).unwrap();
        fs::write(dead.join("claims"), "process 1 on nowhere\n0..9\n").unwrap();
        let others = folder.path().join("n.1@nowhere.part");
        fs::create_dir(&others).unwrap();
        drop(open(&path, Wanted::Missing(ALL)));
        assert!(!dead.exists() && others.exists());
    }
}
