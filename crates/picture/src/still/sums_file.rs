//! The file that sums of samples are in, by rows.
//!
//! | part | bytes |
//! |---|---|
//! | beginning | `EOSSUMS1`, who has the file in work (120 bytes of text), the length of the header |
//! | header | [`SumsHeader`] as JSON; its CRC-32 |
//! | records | each: `ROWS`, first row, row after the last, their CRC-32; then how many samples are done, three 64-bit sums a pixel, row after row, and the CRC-32 of these |
//!
//! Numbers are 32 bits where nothing else is said, lowest byte first. Of records of the same rows the one with the most samples
//! counts. A strip that is not done has two records, which are written by turns: whatever happens, one of them is whole. What is
//! cut off at the end, or has a wrong sum, was not done.

use super::Strip;
use super::identity::SumsHeader;
use crate::locked_file::LockedFile;
use crate::output::{self, MAX_SIDE};
use crate::process::this_process;
use eosphor_core::sums::ExactSum;
use eosphor_render::SampleSums;
use std::collections::BTreeMap;
use std::fs::{File, OpenOptions, TryLockError};
use std::io::{self, BufReader, ErrorKind, Read, Seek, SeekFrom, Write};
use std::ops::Range;
use std::path::{Path, PathBuf};

const MAGIC: [u8; 8] = *b"EOSSUMS1";
const RECORD: [u8; 4] = *b"ROWS";

/// Bytes of the text that says who has the file.
const OWNER_BYTES: usize = 120;

/// Of a record, before its samples and sums, and what is beside the sums after that.
const RECORD_HEAD: u64 = 16;
const RECORD_REST: u64 = 8;

/// Bytes of the sums of a pixel.
pub(super) const SUM_BYTES: u64 = 24;

/// Most bytes of a header.
const MAX_HEADER_BYTES: u32 = 1 << 20;

/// Why sums cannot be read or kept.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum SumsError {
    /// The file has sums of something else.
    #[error("cannot resume: {}: what is done there is {what}: render to another file, or without resuming", path.display())]
    Stale {
        /// The file.
        path: PathBuf,
        /// What the file has sums of, in words.
        what: String,
    },
    /// The file is something else.
    #[error("cannot resume: {}: this is not what the program keeps of a picture: delete it, or render without resuming", path.display())]
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
    /// The file cannot be read or written.
    #[error("cannot keep what is done of the picture: {}: {}", path.display(), output::explain(source))]
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

/// A file of sums that this process has open and locked.
pub(super) struct SumsFile {
    path: PathBuf,
    file: LockedFile,
    header: SumsHeader,
    /// Where the next record goes.
    end: u64,
    /// The best records, by first row.
    done: BTreeMap<u32, Place>,
    /// Nothing was written since it was on the disk.
    is_on_disk: bool,
}

/// What is at a path.
pub(super) enum Found {
    /// No file.
    Nothing,
    /// A file that was ended before its header was whole.
    Begun,
    /// A file of sums.
    Sums(Box<SumsFile>),
}

impl SumsFile {
    /// Opens what is there.
    ///
    /// # Errors
    ///
    /// [`SumsError::Malformed`] where it is something else; [`SumsError::InUse`] where another process has it.
    pub(super) fn open(path: &Path) -> Result<Found, SumsError> {
        let failed = |source| SumsError::File { path: path.to_owned(), source };
        let mut file = match OpenOptions::new().read(true).write(true).open(path) {
            Ok(file) => file,
            Err(error) if error.kind() == ErrorKind::NotFound => return Ok(Found::Nothing),
            Err(error) => return Err(failed(error)),
        };
        lock(path, &mut file)?;
        let mut file = LockedFile::of(file);
        let length = file.metadata().map_err(failed)?.len();
        let mut reader = BufReader::with_capacity(1 << 18, &mut *file);
        let header = match read_header(&mut reader) {
            Ok(Some(header)) => header,
            // Killed before the header was whole: nothing is done.
            Err(error) if error.kind() == ErrorKind::UnexpectedEof => return Ok(Found::Begun),
            Ok(None) => return Err(SumsError::Malformed { path: path.to_owned() }),
            Err(error) => return Err(failed(error)),
        };
        let (done, end) = read_records(&mut reader, header.size, length).map_err(failed)?;
        drop(reader);
        Ok(Found::Sums(Box::new(SumsFile {
            path: path.to_owned(),
            file,
            header,
            end,
            done,
            is_on_disk: true,
        })))
    }

    /// Makes one, in the place of what is there.
    ///
    /// # Errors
    ///
    /// [`SumsError::InUse`] where another process has what is there.
    pub(super) fn create(path: &Path, header: SumsHeader) -> Result<SumsFile, SumsError> {
        let failed = |source| SumsError::File { path: path.to_owned(), source };
        let mut options = OpenOptions::new();
        options.read(true).write(true).create(true).truncate(false);
        let picture = picture_of(path);
        #[cfg(unix)]
        {
            use std::os::unix::fs::OpenOptionsExt;
            options.mode(output::mode_before_rights(&picture, 0o666));
        }
        let mut file = options.open(path).map_err(failed)?;
        lock(path, &mut file)?;
        let mut file = LockedFile::of(file);
        output::take_rights_of(&picture, &file, 0o600);
        let json = serde_json::to_vec(&header).map_err(|error| failed(error.into()))?;
        let mut bytes = MAGIC.to_vec();
        bytes.resize(MAGIC.len() + OWNER_BYTES, b' ');
        bytes.extend((json.len() as u32).to_le_bytes());
        bytes.extend(&json);
        bytes.extend(crc32fast::hash(&json).to_le_bytes());
        let written = file.set_len(0).and_then(|()| file.write_all(&bytes));
        written.and_then(|()| write_owner(&mut file)).map_err(failed)?;
        let end = bytes.len() as u64;
        Ok(SumsFile { path: path.to_owned(), file, header, end, done: BTreeMap::new(), is_on_disk: false })
    }

    /// Gets ready to write more: what is half a record goes, and the file says who has it.
    pub(super) fn go_on(&mut self) -> Result<(), SumsError> {
        let begun = self.file.set_len(self.end).and_then(|()| write_owner(&mut self.file));
        begun.map_err(|error| self.error(error))
    }

    pub(super) fn header(&self) -> &SumsHeader {
        &self.header
    }

    pub(super) fn path(&self) -> &Path {
        &self.path
    }

    /// The rows from this one on that one record has, or else the next row that there is.
    pub(super) fn rows_from(&self, row: u32) -> Result<Range<u32>, Option<u32>> {
        match self.done.get(&row) {
            Some(place) => Ok(row..place.end_row),
            None => Err(self.done.range(row..).next().map(|(first, _)| *first)),
        }
    }

    /// Whether there is nothing in it.
    pub(super) fn is_empty(&self) -> bool {
        self.done.is_empty()
    }

    /// Samples of all pixels together.
    pub(super) fn samples(&self) -> u64 {
        let width = u64::from(self.header.size.0);
        let of =
            |(row, place): (&u32, &Place)| u64::from(place.end_row - row) * width * u64::from(place.samples);
        self.done.iter().map(of).sum()
    }

    /// The most samples of any pixel.
    pub(super) fn most_samples(&self) -> u32 {
        self.done.values().map(|place| place.samples).max().unwrap_or(0)
    }

    /// Whether it has so many samples of all these rows.
    pub(super) fn has(&self, rows: &Range<u32>, samples: u32) -> bool {
        let mut row = rows.start;
        while row < rows.end {
            match self.done.get(&row) {
                Some(place) if place.samples == samples => row = place.end_row,
                _ => return false,
            }
        }
        true
    }

    /// What it has of these rows, which a record has ([`SumsFile::rows_from`]).
    pub(super) fn strip(&mut self, rows: Range<u32>) -> Result<Strip, SumsError> {
        let mut strip = Strip::new(self.header.size.0, rows.clone());
        if let Some(place) = self.done.get(&rows.start).copied() {
            let found = self.file.seek(SeekFrom::Start(place.offset));
            let read = found.and_then(|_| read_body(&mut *self.file, strip.pixels()));
            let body = read.map_err(|error| self.error(error))?;
            if let Some((samples, sums)) = body.filter(|(samples, _)| *samples == place.samples) {
                (strip.samples, strip.sums.sums) = (samples, sums);
            }
        }
        Ok(strip)
    }

    /// Writes a record at the end; a part of one is taken away again. Where its sums are.
    pub(super) fn append(&mut self, strip: &Strip) -> Result<u64, SumsError> {
        let (begin, Range { start, end }) = (self.end, strip.rows.clone());
        self.is_on_disk = false;
        let mut head = RECORD.to_vec();
        head.extend([start.to_le_bytes(), end.to_le_bytes()].concat());
        head.extend(crc32fast::hash(&head).to_le_bytes());
        let written = self
            .file
            .seek(SeekFrom::Start(begin))
            .and_then(|_| self.file.write_all(&head))
            .and_then(|()| write_body(&mut *self.file, strip));
        if let Err(error) = written {
            let _ = self.file.set_len(begin);
            return Err(self.error(error));
        }
        let offset = begin + RECORD_HEAD;
        self.end = offset + RECORD_REST + strip.pixels() * SUM_BYTES;
        self.done.insert(start, Place { end_row: end, samples: strip.samples, offset });
        Ok(offset)
    }

    /// Writes over the sums of a record of the same rows.
    pub(super) fn overwrite(&mut self, offset: u64, strip: &Strip) -> Result<(), SumsError> {
        self.is_on_disk = false;
        let found = self.file.seek(SeekFrom::Start(offset));
        found.and_then(|_| write_body(&mut *self.file, strip)).map_err(|error| self.error(error))?;
        let place = Place { end_row: strip.rows.end, samples: strip.samples, offset };
        self.done.insert(strip.rows.start, place);
        Ok(())
    }

    /// Waits until all of it is on the disk.
    pub(super) fn sync(&mut self) -> Result<(), SumsError> {
        if !self.is_on_disk {
            self.file.sync_data().map_err(|error| self.error(error))?;
            self.is_on_disk = true;
        }
        Ok(())
    }

    fn error(&self, source: io::Error) -> SumsError {
        SumsError::File { path: self.path.clone(), source }
    }
}

/// The picture that sums in such a file are of: `out.png` of `out.png.part` and `out.png.0-64.sums`.
fn picture_of(path: &Path) -> PathBuf {
    let picture = path.with_extension("");
    if path.extension().is_some_and(|ending| ending == "sums") { picture.with_extension("") } else { picture }
}

/// Takes the file for this process; it is free again when this process is gone, however it ends.
fn lock(path: &Path, file: &mut File) -> Result<(), SumsError> {
    match file.try_lock() {
        Ok(()) => Ok(()),
        Err(TryLockError::WouldBlock) => {
            let owner = read_owner(file).unwrap_or_else(|_| "another process".into());
            Err(SumsError::InUse { path: path.to_owned(), owner })
        }
        // Where the file system has no locks, nobody can be asked.
        Err(TryLockError::Error(error)) if error.kind() == ErrorKind::Unsupported => Ok(()),
        Err(TryLockError::Error(source)) => Err(SumsError::File { path: path.to_owned(), source }),
    }
}

/// What the sums of a file are of, whoever has it.
pub(super) fn header_of(path: &Path) -> Option<SumsHeader> {
    read_header(&mut BufReader::new(File::open(path).ok()?)).ok()?
}

/// What the sums are of; `None` where this is no such file.
fn read_header(from: &mut impl Read) -> io::Result<Option<SumsHeader>> {
    let mut magic = [0; MAGIC.len()];
    from.read_exact(&mut magic)?;
    if magic != MAGIC {
        return Ok(None);
    }
    let mut owner = [0; OWNER_BYTES];
    from.read_exact(&mut owner)?;
    let length = read_number(from)?;
    if length > MAX_HEADER_BYTES {
        return Ok(None);
    }
    let mut json = vec![0; length as usize];
    from.read_exact(&mut json)?;
    let is_whole = read_number(from)? == crc32fast::hash(&json);
    let header: Option<SumsHeader> = serde_json::from_slice(&json).ok();
    let sides = 1..=MAX_SIDE;
    let is_sane = |header: &SumsHeader| sides.contains(&header.size.0) && sides.contains(&header.size.1);
    Ok(header.filter(|header| is_whole && is_sane(header)))
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
        if !is_one || rows.is_empty() || rows.end > height {
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
        for unit in some.iter().flat_map(|sum| sum.units) {
            bytes.extend_from_slice(&unit.to_le_bytes());
        }
        hasher.update(&bytes);
        to.write_all(&bytes)?;
        bytes.clear();
    }
    to.write_all(&hasher.finalize().to_le_bytes())
}
