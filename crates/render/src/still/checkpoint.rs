//! The file that keeps what is done of a still: exact sums by rows, so that it can go on after whatever ended the program.
//!
//! | part | bytes |
//! |---|---|
//! | beginning | `EOSSUMS1`, who has the file in work (120 bytes of text), the length of the header |
//! | header | what the sums are of, as JSON; its CRC-32 |
//! | records | each: `ROWS`, first row, row after the last, their CRC-32; then how many samples are done, three 64-bit sums a pixel, row after row, and the CRC-32 of these |
//!
//! Numbers are 32 bits where nothing else is said, lowest byte first. Of records of the same rows the one with the most samples
//! counts. A strip that is not done has two records, which are written by turns: whatever happens, one of them is whole. What is
//! cut off at the end, or has a wrong sum, was not done.

use super::Strip;
use crate::SampleSums;
use crate::output::{DevelopSettings, MAX_SIDE, PICTURE_VERSION};
use crate::process::this_process;
use crate::scene_hash::hash_with;
use eosphor_core::settings::PixelSampling;
use eosphor_core::whitted::ExactSum;
use eosphor_scene::SceneData;
use serde::{Deserialize, Serialize};

use std::collections::BTreeMap;
use std::fs::{self, File, OpenOptions, TryLockError};
use std::io::{self, BufReader, ErrorKind, Read, Seek, SeekFrom, Write};
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::{Arc, OnceLock};
use std::time::{Duration, Instant};

const MAGIC: [u8; 8] = *b"EOSSUMS1";
const RECORD: [u8; 4] = *b"ROWS";

/// Bytes of the text that says who has the file.
const OWNER_BYTES: usize = 120;

/// Of a record, before its samples and sums, and what is beside the sums after that.
const RECORD_HEAD: u64 = 16;
const RECORD_REST: u64 = 8;

const SUM_BYTES: u64 = 24;

/// No header is longer.
const MOST_HEADER: u32 = 1 << 16;

/// Sums of strips that are done but not in the file yet take at most so much memory.
const MOST_WAITING: usize = 128 << 20;

/// Strips that took less are rather rendered again than written where there is no memory for them.
const WORTH_WRITING: Duration = Duration::from_secs(8);

/// The file of what is done of the picture at `path`: `out.png.part`.
pub fn checkpoint_path(path: &Path) -> PathBuf {
    let mut name = path.as_os_str().to_owned();
    name.push(".part");
    name.into()
}

/// What sums are of: all that a sample depends on. How many there are of a pixel is not among it, where a sample does not
/// depend on that, nor how colours become bytes.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct SceneIdentity {
    /// The version of the program's pictures.
    picture: u32,
    /// Width and height in pixels.
    size: (u32, u32),
    scene: String,
}

impl SceneIdentity {
    /// Of a scene.
    pub fn of(scene: &SceneData) -> SceneIdentity {
        let mut settings = scene.settings;
        match settings.pixel_sampling {
            // One random sample is in the middle of its pixel.
            PixelSampling::Random => settings.samples = settings.samples.min(2),
            PixelSampling::Center => settings.samples = 1,
            PixelSampling::Grid => {}
        }
        let scene = hash_with(scene, &settings, &DevelopSettings::default());
        SceneIdentity { picture: PICTURE_VERSION, size: (settings.width, settings.height), scene }
    }
}

/// Why a still cannot be gone on with.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum CheckpointError {
    /// It is of something else.
    #[error("cannot resume: {}: what is done there is {what}: render to another file, or without --resume", path.display())]
    Stale {
        /// The file.
        path: PathBuf,
        /// Of what.
        what: String,
    },
    /// The file is something else.
    #[error("cannot resume: {}: this is not what the program keeps of a picture: delete it, or render without --resume", path.display())]
    Malformed {
        /// The file.
        path: PathBuf,
    },
    /// Another process has it.
    #[error("{}: {owner} is rendering this picture: wait for it, or render to another file", path.display())]
    InUse {
        /// The file.
        path: PathBuf,
        /// Who, as far as it is known.
        owner: String,
    },
    /// It cannot be read or written.
    #[error("cannot keep what is done of the picture: {}: {source}", path.display())]
    File {
        /// The file.
        path: PathBuf,
        /// The system's reason.
        source: io::Error,
    },
}

/// Where sums of some rows are in the file.
#[derive(Clone, Copy, Debug)]
struct Place {
    end_row: u32,
    samples: u32,
    offset: u64,
}

/// Places of the records of the strip in work.
#[derive(Clone, Debug, Default)]
struct InWork {
    rows: Range<u32>,
    offsets: Vec<u64>,
    newest: usize,
}

/// What is done of a still, in memory for a while and in a file. The file is made when there is something to be kept.
pub struct Checkpoint {
    path: PathBuf,
    scene: Arc<SceneData>,
    /// Hashing a large scene takes a while, and many stills are done before it is needed.
    identity: OnceLock<SceneIdentity>,
    interval: Duration,
    /// When something was written last, or it began: what was done since then is lost where the program is killed.
    written: Instant,
    file: Option<File>,
    /// There is a file of an earlier render, which is not gone on with.
    has_other: bool,
    /// Where the next record goes.
    end: u64,
    /// What the file has, by first row.
    done: BTreeMap<u32, Place>,
    in_work: InWork,
    /// Strips that are whole and not in the file.
    waiting: Vec<Strip>,
    /// When the first of them began.
    waiting_since: Instant,
    /// Why writing has failed.
    failed: Option<CheckpointError>,
}

impl Checkpoint {
    /// For a picture at `path`, written every `interval` at most. To `resume`, with what is in the file, if there is one.
    ///
    /// # Errors
    ///
    /// [`CheckpointError::Stale`] where the file is of another picture, or has more samples of a pixel than the scene;
    /// [`CheckpointError::InUse`] where another process has it, also where nothing is to be resumed.
    pub fn open(
        path: &Path,
        scene: Arc<SceneData>,
        interval: Duration,
        resume: bool,
    ) -> Result<Checkpoint, CheckpointError> {
        let now = Instant::now();
        let mut checkpoint = Checkpoint {
            path: path.to_owned(),
            scene,
            identity: OnceLock::new(),
            interval,
            written: now,
            file: None,
            has_other: false,
            end: 0,
            done: BTreeMap::new(),
            in_work: InWork::default(),
            waiting: Vec::new(),
            waiting_since: now,
            failed: None,
        };
        let mut file = match OpenOptions::new().read(true).write(true).open(path) {
            Ok(file) => file,
            Err(error) if error.kind() == ErrorKind::NotFound => return Ok(checkpoint),
            Err(error) => return Err(checkpoint.file_error(error)),
        };
        checkpoint.lock(&mut file)?;
        match resume {
            true => checkpoint.read(file)?,
            false => checkpoint.has_other = true,
        }
        Ok(checkpoint)
    }

    /// Whether the file has something to go on with.
    pub fn is_kept(&self) -> bool {
        !self.done.is_empty()
    }

    /// Whether there is a file that is not gone on with. It is replaced when there is something to be kept.
    pub fn has_other(&self) -> bool {
        self.has_other
    }

    /// The file.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// The rows from this one on that the file has, or else the next row that it has.
    pub fn rows_from(&self, row: u32) -> Result<Range<u32>, Option<u32>> {
        match self.done.get(&row) {
            Some(place) => Ok(row..place.end_row),
            None => Err(self.done.range(row..).next().map(|(first, _)| *first)),
        }
    }

    /// What the file has of samples, of all pixels together.
    pub fn samples_done(&self) -> u64 {
        let width = u64::from(self.scene.settings.width);
        self.done
            .iter()
            .map(|(row, place)| u64::from(place.end_row - row) * width * u64::from(place.samples))
            .sum()
    }

    /// What the file has of these rows, which it names ([`Checkpoint::rows_from`]).
    ///
    /// # Errors
    ///
    /// [`CheckpointError::File`].
    pub fn strip(&mut self, rows: Range<u32>) -> Result<Strip, CheckpointError> {
        let mut strip = Strip::new(self.scene.settings.width, rows.clone());
        if let (Some(place), Some(file)) = (self.done.get(&rows.start).copied(), &mut self.file) {
            let read = file.seek(SeekFrom::Start(place.offset)).and_then(|_| read_body(file, strip.pixels()));
            let body = read
                .map_err(|error| self.file_error(error))?
                .filter(|(samples, _)| *samples == place.samples);
            if let Some((samples, sums)) = body {
                (strip.samples, strip.sums.sums) = (samples, sums);
            }
        }
        Ok(strip)
    }

    /// Whether it is time to write, where the next piece of work takes so long.
    pub fn is_due(&self, next: Duration) -> bool {
        self.written.elapsed() + next >= self.interval
    }

    /// Takes a strip that is whole, to be written with the next ones, and not at all where it took little time and many
    /// such strips would fill the memory.
    pub fn take(&mut self, strip: Strip) {
        let is_in_file = self.done.get(&strip.rows.start).is_some_and(|place| place.samples == strip.samples);
        if is_in_file {
            return;
        }
        self.waiting.push(strip);
        let bytes: usize = self.waiting.iter().map(|strip| strip.sums.sums.len() * SUM_BYTES as usize).sum();
        if bytes > MOST_WAITING {
            match self.waiting_since.elapsed() >= WORTH_WRITING {
                true => self.write(None),
                false => self.forget(),
            }
        }
    }

    fn forget(&mut self) {
        self.waiting.clear();
        self.waiting_since = Instant::now();
    }

    /// Writes what is not in the file, with what is done of the strip in work. Where that fails, [`Checkpoint::failure`] has
    /// the reason.
    pub fn write(&mut self, in_work: Option<&Strip>) {
        let in_work = in_work.filter(|strip| strip.samples > 0);
        if !self.waiting.is_empty() || in_work.is_some() {
            self.failed = self.write_all(in_work).err();
        }
        self.forget();
        self.written = Instant::now();
    }

    /// Why writing has failed, told once; after that it is tried again.
    pub fn failure(&mut self) -> Option<CheckpointError> {
        self.failed.take_if(|_| true)
    }

    /// The picture is whole: the file goes, also one of an earlier render of the same. Whether there was one.
    pub fn remove(self) -> bool {
        let is_same = || {
            let header = File::open(&self.path).and_then(|file| read_header(&mut BufReader::new(file)));
            header.is_ok_and(|header| header.as_ref() == Some(self.identity()))
        };
        // Nothing depends on it any more.
        (self.file.is_some() || (self.has_other && is_same())) && fs::remove_file(&self.path).is_ok()
    }

    fn identity(&self) -> &SceneIdentity {
        self.identity.get_or_init(|| SceneIdentity::of(&self.scene))
    }

    fn file_error(&self, source: io::Error) -> CheckpointError {
        CheckpointError::File { path: self.path.clone(), source }
    }

    /// Takes the file for this process; it is free again when this process is gone, however it ends.
    fn lock(&self, file: &mut File) -> Result<(), CheckpointError> {
        match file.try_lock() {
            Ok(()) => Ok(()),
            Err(TryLockError::WouldBlock) => {
                let owner = read_owner(file).unwrap_or_else(|_| "another process".into());
                Err(CheckpointError::InUse { path: self.path.clone(), owner })
            }
            // Where the file system has no locks, nobody can be asked.
            Err(TryLockError::Error(error)) if error.kind() == ErrorKind::Unsupported => Ok(()),
            Err(TryLockError::Error(error)) => Err(self.file_error(error)),
        }
    }

    /// Reads what is in a file.
    fn read(&mut self, mut file: File) -> Result<(), CheckpointError> {
        let length = file.metadata().map_err(|error| self.file_error(error))?.len();
        let malformed = || CheckpointError::Malformed { path: self.path.clone() };
        let mut reader = BufReader::with_capacity(1 << 18, &mut file);
        let identity = match read_header(&mut reader) {
            Ok(Some(identity)) => identity,
            // Killed before the header was whole: nothing is done.
            Err(error) if error.kind() == ErrorKind::UnexpectedEof => return Ok(()),
            Ok(None) => return Err(malformed()),
            Err(error) => return Err(self.file_error(error)),
        };
        let stale = |what: String| Err(CheckpointError::Stale { path: self.path.clone(), what });
        let (SceneIdentity { picture, size, scene }, own) = (&identity, self.identity());
        match () {
            _ if *picture != own.picture => {
                return stale("by a version of the program with other pictures".into());
            }
            _ if *size != own.size => return stale(format!("of {} x {} pixels", size.0, size.1)),
            _ if *scene != own.scene => return stale("of another scene, or with other settings".into()),
            _ => {}
        }
        let samples = self.scene.settings.samples;
        let (done, end) = read_records(&mut reader, *size, length).map_err(|error| self.file_error(error))?;
        drop(reader);
        if let Some(most) = done.values().map(|place| place.samples).max().filter(|most| *most > samples) {
            return stale(format!("with {most} samples a pixel, more than the {samples} that are asked for"));
        }
        let begun = file.set_len(end).and_then(|()| write_owner(&mut file));
        begun.map_err(|error| self.file_error(error))?;
        (self.done, self.end, self.file) = (done, end, Some(file));
        Ok(())
    }

    /// Begins a file, in the place of what an earlier render may have left.
    fn begin(&mut self) -> Result<(), CheckpointError> {
        if self.file.is_some() {
            return Ok(());
        }
        let fail = |error| CheckpointError::File { path: self.path.clone(), source: error };
        let mut options = OpenOptions::new();
        let mut file =
            options.read(true).write(true).create(true).truncate(false).open(&self.path).map_err(fail)?;
        self.lock(&mut file)?;
        let header = serde_json::to_vec(self.identity()).map_err(|error| fail(error.into()))?;
        let mut bytes = MAGIC.to_vec();
        bytes.resize(MAGIC.len() + OWNER_BYTES, b' ');
        bytes.extend((header.len() as u32).to_le_bytes());
        bytes.extend(&header);
        bytes.extend(crc32fast::hash(&header).to_le_bytes());
        let written =
            file.set_len(0).and_then(|()| file.write_all(&bytes)).and_then(|()| write_owner(&mut file));
        written.map_err(fail)?;
        (self.end, self.file, self.has_other) = (bytes.len() as u64, Some(file), false);
        Ok(())
    }

    fn write_all(&mut self, in_work: Option<&Strip>) -> Result<(), CheckpointError> {
        self.begin()?;
        for strip in std::mem::take(&mut self.waiting) {
            self.append(&strip)?;
        }
        if let Some(strip) = in_work {
            self.write_in_work(strip)?;
        }
        let Some(file) = &self.file else { return Ok(()) };
        file.sync_data().map_err(|error| self.file_error(error))
    }

    /// Writes a record at the end; a part of one is taken away again.
    fn append(&mut self, strip: &Strip) -> Result<u64, CheckpointError> {
        let Some(file) = &mut self.file else { return Ok(0) };
        let (begin, Range { start, end }) = (self.end, strip.rows.clone());
        let mut head = RECORD.to_vec();
        head.extend([start.to_le_bytes(), end.to_le_bytes()].concat());
        head.extend(crc32fast::hash(&head).to_le_bytes());
        let written = file
            .seek(SeekFrom::Start(begin))
            .and_then(|_| file.write_all(&head))
            .and_then(|()| write_body(file, strip));
        if let Err(error) = written {
            let _ = file.set_len(begin);
            return Err(self.file_error(error));
        }
        let offset = begin + RECORD_HEAD;
        self.end = offset + RECORD_REST + strip.pixels() * SUM_BYTES;
        self.done.insert(start, Place { end_row: end, samples: strip.samples, offset });
        Ok(offset)
    }

    /// Writes what is done of the strip in work over the older of its two records.
    fn write_in_work(&mut self, strip: &Strip) -> Result<(), CheckpointError> {
        if self.in_work.rows != strip.rows {
            self.in_work = InWork { rows: strip.rows.clone(), ..InWork::default() };
        }
        if self.in_work.offsets.len() < 2 {
            let offset = self.append(strip)?;
            self.in_work.offsets.push(offset);
            self.in_work.newest = self.in_work.offsets.len() - 1;
            return Ok(());
        }
        let older = 1 - self.in_work.newest;
        let offset = self.in_work.offsets[older];
        let Some(file) = &mut self.file else { return Ok(()) };
        let written = file.seek(SeekFrom::Start(offset)).and_then(|_| write_body(file, strip));
        written.map_err(|error| self.file_error(error))?;
        self.in_work.newest = older;
        let place = Place { end_row: strip.rows.end, samples: strip.samples, offset };
        self.done.insert(strip.rows.start, place);
        Ok(())
    }
}

/// What the sums are of; `None` where this is no such file.
fn read_header(from: &mut impl Read) -> io::Result<Option<SceneIdentity>> {
    let mut magic = [0; MAGIC.len()];
    from.read_exact(&mut magic)?;
    if magic != MAGIC {
        return Ok(None);
    }
    let mut owner = [0; OWNER_BYTES];
    from.read_exact(&mut owner)?;
    let length = read_number(from)?;
    if length > MOST_HEADER {
        return Ok(None);
    }
    let mut header = vec![0; length as usize];
    from.read_exact(&mut header)?;
    let is_whole = read_number(from)? == crc32fast::hash(&header);
    Ok(serde_json::from_slice(&header).ok().filter(|_| is_whole))
}

/// Who has the file in work.
fn read_owner(file: &mut File) -> io::Result<String> {
    let mut text = [0; OWNER_BYTES];
    file.seek(SeekFrom::Start(MAGIC.len() as u64))?;
    file.read_exact(&mut text)?;
    Ok(String::from_utf8_lossy(&text).trim().to_owned())
}

fn write_owner(file: &mut File) -> io::Result<()> {
    let mut text = this_process().into_bytes();
    text.resize(OWNER_BYTES, b' ');
    file.seek(SeekFrom::Start(MAGIC.len() as u64))?;
    file.write_all(&text)
}

/// Where the best of all records are, and the end of the last one.
fn read_records(
    from: &mut (impl Read + Seek),
    (width, height): (u32, u32),
    length: u64,
) -> io::Result<(BTreeMap<u32, Place>, u64)> {
    let mut done = BTreeMap::<u32, Place>::new();
    let mut end = from.stream_position()?;
    loop {
        let mut head = [0; RECORD_HEAD as usize];
        if length < end + RECORD_HEAD {
            return Ok((done, end));
        }
        from.read_exact(&mut head)?;
        let number = |at: usize| u32::from_le_bytes([head[at], head[at + 1], head[at + 2], head[at + 3]]);
        let (rows, offset) = (number(4)..number(8), end + RECORD_HEAD);
        let is_one = head[..4] == RECORD && number(12) == crc32fast::hash(&head[..12]);
        if !is_one || rows.is_empty() || rows.end > height.min(MAX_SIDE) {
            return Ok((done, end));
        }
        let pixels = rows.len() as u64 * u64::from(width);
        let next = offset + RECORD_REST + pixels * SUM_BYTES;
        if length < next {
            return Ok((done, end));
        }
        // (What is damaged was not done; all of it is there.)
        if let Some(samples) = check_body(from, pixels)? {
            let place = Place { end_row: rows.end, samples, offset };
            let is_better = |old: &Place| old.end_row == rows.end && old.samples < samples;
            // Strips of two renders never overlap otherwise; what does is left out.
            let overlaps = done
                .range(..rows.end)
                .next_back()
                .is_some_and(|(first, old)| *first != rows.start && old.end_row > rows.start);
            if !overlaps && done.get(&rows.start).is_none_or(is_better) {
                done.insert(rows.start, place);
            }
        }
        end = next;
    }
}

fn read_number(from: &mut impl Read) -> io::Result<u32> {
    let mut bytes = [0; 4];
    from.read_exact(&mut bytes)?;
    Ok(u32::from_le_bytes(bytes))
}

/// Pixels that are read or written at a time.
const CHUNK: usize = 1 << 14;

/// How many samples a record is of; `None` where its check sum is wrong.
fn check_body(from: &mut impl Read, pixels: u64) -> io::Result<Option<u32>> {
    let mut hasher = crc32fast::Hasher::new();
    let samples = read_number(from)?;
    hasher.update(&samples.to_le_bytes());
    let mut bytes = vec![0; CHUNK * SUM_BYTES as usize];
    let mut left = pixels * SUM_BYTES;
    while left > 0 {
        let some = left.min(bytes.len() as u64);
        from.read_exact(&mut bytes[..some as usize])?;
        hasher.update(&bytes[..some as usize]);
        left -= some;
    }
    Ok((read_number(from)? == hasher.finalize() && samples > 0).then_some(samples))
}

/// Samples and sums of a record.
fn read_body(from: &mut impl Read, pixels: u64) -> io::Result<Option<(u32, Vec<ExactSum>)>> {
    let mut hasher = crc32fast::Hasher::new();
    let samples = read_number(from)?;
    hasher.update(&samples.to_le_bytes());
    let mut sums = Vec::with_capacity(pixels as usize);
    let mut bytes = vec![0; CHUNK * SUM_BYTES as usize];
    let mut left = pixels * SUM_BYTES;
    while left > 0 {
        let some = &mut bytes[..left.min((CHUNK as u64) * SUM_BYTES) as usize];
        from.read_exact(some)?;
        hasher.update(some);
        left -= some.len() as u64;
        sums.extend(some.as_chunks::<{ SUM_BYTES as usize }>().0.iter().map(|bytes| {
            let mut units = [0; 3];
            units
                .iter_mut()
                .zip(bytes.as_chunks::<8>().0)
                .for_each(|(unit, bytes)| *unit = u64::from_le_bytes(*bytes));
            ExactSum { units }
        }));
    }
    Ok((read_number(from)? == hasher.finalize()).then_some((samples, sums)))
}

fn write_body(to: &mut impl Write, strip: &Strip) -> io::Result<()> {
    let mut hasher = crc32fast::Hasher::new();
    let SampleSums { sums, .. } = &strip.sums;
    let mut bytes = strip.samples.to_le_bytes().to_vec();
    for some in sums.chunks(CHUNK) {
        bytes.extend(some.iter().flat_map(|sum| sum.units).flat_map(u64::to_le_bytes));
        hasher.update(&bytes);
        to.write_all(&bytes)?;
        bytes.clear();
    }
    to.write_all(&hasher.finalize().to_le_bytes())
}

#[cfg(test)]
mod tests {
    use super::*;
    use eosphor_scene::{LoadOptions, load};

    const WIDTH: u32 = 5;
    const HEIGHT: u32 = 9;

    fn scene(samples: u32, seed: u32) -> Arc<SceneData> {
        let mut scene = load("builtin:cornell", &LoadOptions::default()).unwrap().scene;
        (scene.settings.size, scene.settings.samples, scene.settings.seed) = ([WIDTH, HEIGHT], samples, seed);
        Arc::new(SceneData::flatten(&scene).unwrap().0)
    }

    fn open(path: &Path, samples: u32, resume: bool) -> Result<Checkpoint, CheckpointError> {
        Checkpoint::open(path, scene(samples, 1), Duration::ZERO, resume)
    }

    /// Sums that say which rows and samples they are of.
    fn strip(rows: Range<u32>, samples: u32) -> Strip {
        let mut strip = Strip::new(WIDTH, rows.clone());
        strip.samples = samples;
        for (number, sum) in strip.sums.sums.iter_mut().enumerate() {
            sum.units = [rows.start.into(), u64::from(samples) << 40, number as u64];
        }
        strip
    }

    fn all(checkpoint: &mut Checkpoint) -> Vec<Strip> {
        let rows: Vec<Range<u32>> = checkpoint.done.iter().map(|(row, place)| *row..place.end_row).collect();
        rows.into_iter().map(|rows| checkpoint.strip(rows).unwrap()).collect()
    }

    #[test]
    fn what_was_kept_comes_back() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.png.part");
        let mut checkpoint = open(&path, 64, true).unwrap();
        assert!(!checkpoint.is_kept() && checkpoint.rows_from(0) == Err(None));
        checkpoint.write(None);
        assert!(!path.exists(), "nothing to be kept");
        checkpoint.take(strip(0..3, 64));
        for samples in [1, 5, 9, 12] {
            checkpoint.write(Some(&strip(3..5, samples)));
        }
        assert!(checkpoint.failure().is_none());
        drop(checkpoint);
        let mut checkpoint = open(&path, 64, true).unwrap();
        assert!(checkpoint.is_kept());
        assert_eq!(all(&mut checkpoint), [strip(0..3, 64), strip(3..5, 12)]);
        assert_eq!((checkpoint.rows_from(0), checkpoint.rows_from(1)), (Ok(0..3), Err(Some(3))));
        assert_eq!(checkpoint.samples_done(), 5 * (3 * 64 + 2 * 12));
        checkpoint.write(Some(&strip(3..5, 20)));
        checkpoint.take(strip(3..5, 64));
        checkpoint.take(strip(5..9, 64));
        checkpoint.write(None);
        drop(checkpoint);
        let mut checkpoint = open(&path, 64, true).unwrap();
        assert_eq!(all(&mut checkpoint), [strip(0..3, 64), strip(3..5, 64), strip(5..9, 64)]);
        assert!(checkpoint.remove() && !path.exists());
    }

    #[test]
    fn a_whole_picture_leaves_nothing_of_an_earlier_render_of_it() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.png.part");
        open(&path, 16, false).unwrap().write(Some(&strip(0..9, 2)));
        // Of another picture.
        assert!(!Checkpoint::open(&path, scene(16, 2), Duration::ZERO, false).unwrap().remove());
        assert!(path.exists());
        assert!(open(&path, 32, false).unwrap().remove() && !path.exists());
        assert!(!open(&path, 32, false).unwrap().remove());
    }

    #[test]
    fn more_samples_go_on_and_other_scenes_do_not() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.png.part");
        let mut checkpoint = open(&path, 16, true).unwrap();
        checkpoint.take(strip(0..9, 16));
        checkpoint.write(None);
        drop(checkpoint);
        assert_eq!(open(&path, 32, true).unwrap().samples_done(), 45 * 16);
        let reason = |opened: Result<Checkpoint, CheckpointError>| opened.err().unwrap().to_string();
        assert!(reason(open(&path, 8, true)).contains("with 16 samples a pixel, more than the 8"));
        // A single sample is elsewhere in its pixel.
        assert!(reason(open(&path, 1, true)).contains("another scene, or with other settings"));
        let other = Checkpoint::open(&path, scene(16, 2), Duration::ZERO, true);
        assert!(reason(other).contains("another scene, or with other settings"));
        // Anew, which replaces it when there is something to be kept.
        let mut anew = Checkpoint::open(&path, scene(16, 2), Duration::ZERO, false).unwrap();
        assert!(!anew.is_kept() && anew.has_other());
        anew.write(Some(&strip(0..1, 3)));
        drop(anew);
        let again = Checkpoint::open(&path, scene(16, 2), Duration::ZERO, true).unwrap();
        assert_eq!(again.samples_done(), 15);
        fs::write(
            &path,
            "my notes, which are long enough to be a header of something else, if not of a picture",
        )
        .unwrap();
        assert!(reason(open(&path, 16, true)).contains("delete it"));
        fs::write(&path, "EOS").unwrap();
        assert_eq!(open(&path, 16, true).unwrap().samples_done(), 0);
    }

    #[test]
    fn a_file_that_was_cut_off_or_damaged_anywhere_is_read() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.png.part");
        let mut checkpoint = open(&path, 64, true).unwrap();
        checkpoint.take(strip(0..3, 64));
        checkpoint.write(None);
        let begin = checkpoint.done[&0].offset - RECORD_HEAD;
        checkpoint.write(Some(&strip(3..5, 7)));
        checkpoint.write(Some(&strip(3..5, 8)));
        let (older, end) = (checkpoint.in_work.offsets[0], checkpoint.end);
        drop(checkpoint);
        let whole = fs::read(&path).unwrap();
        assert_eq!(whole.len() as u64, end);
        let mut before = 0;
        for length in 0..=whole.len() {
            fs::write(&path, &whole[..length]).unwrap();
            let Ok(mut checkpoint) = open(&path, 64, true) else { panic!("{length}") };
            let done = checkpoint.samples_done();
            assert!(done >= before, "{length}");
            before = done;
            // It goes on from there.
            checkpoint.take(strip(5..9, 64));
            checkpoint.write(None);
            assert!(checkpoint.failure().is_none());
            drop(checkpoint);
            assert_eq!(open(&path, 64, true).unwrap().samples_done(), done + 20 * 64, "{length}");
        }
        assert_eq!(before, 5 * (3 * 64 + 2 * 8));
        for at in begin as usize..whole.len() {
            let mut damaged = whole.clone();
            damaged[at] ^= 16;
            fs::write(&path, &damaged).unwrap();
            let mut checkpoint = open(&path, 64, true).unwrap();
            for got in all(&mut checkpoint) {
                let expected = strip(got.rows.clone(), got.samples);
                assert!(got == expected && [64, 7, 8].contains(&got.samples), "byte {at}");
            }
            // Half of what is written over: the other one counts.
            if (at as u64) >= older && (at as u64) < older + RECORD_REST + 10 * SUM_BYTES {
                assert_eq!(checkpoint.samples_done(), 5 * (3 * 64 + 2 * 8), "byte {at}");
            }
        }
    }

    #[test]
    fn two_cannot_have_it() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.png.part");
        let mut first = open(&path, 64, true).unwrap();
        first.write(Some(&strip(0..9, 2)));
        for resume in [false, true] {
            let message = open(&path, 64, resume).err().unwrap().to_string();
            assert!(message.contains(&format!("process {}", std::process::id())), "{message}");
        }
        drop(first);
        assert_eq!(open(&path, 64, true).unwrap().samples_done(), 90);
    }

    #[test]
    fn what_cannot_be_written_is_said_and_tried_again() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("none/a.png.part");
        let mut checkpoint = open(&path, 64, true).unwrap();
        checkpoint.write(Some(&strip(0..9, 2)));
        assert!(checkpoint.failure().unwrap().to_string().contains("cannot keep"));
        fs::create_dir(folder.path().join("none")).unwrap();
        checkpoint.write(Some(&strip(0..9, 3)));
        assert!(checkpoint.failure().is_none());
        drop(checkpoint);
        assert_eq!(open(&path, 64, true).unwrap().samples_done(), 45 * 3);
    }
}
