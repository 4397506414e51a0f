//! Reading shares, and making the whole of them.

use super::super::{MAX_SIDE, OutputError, PictureWriter, SaveOptions};
use super::{FEATURE_BYTES, MAGIC, ShareHeader};
use eosphor_core::math::Vec3;
use eosphor_render::{CameraWork, FeatureRows, Film, PixelFeatures};
use std::fs::File;
use std::io::{BufReader, Error, ErrorKind, Read, Seek, SeekFrom};
use std::ops::Range;
use std::path::{Path, PathBuf};

/// No header is longer.
const MAX_HEADER: u32 = 1 << 20;

/// Why shares make no picture.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ShareError {
    /// One cannot be read.
    #[error("cannot read the share: {}: {reason}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        reason: String,
    },
    /// Two are not of one picture.
    #[error("{} and {} are shares of different pictures: they differ in {what}", first.display(), second.display())]
    Differ {
        /// One file.
        first: PathBuf,
        /// Another.
        second: PathBuf,
        /// What differs.
        what: &'static str,
    },
    /// There are two of one number.
    #[error("{} and {} are the same share", first.display(), second.display())]
    Twice {
        /// One file.
        first: PathBuf,
        /// Another.
        second: PathBuf,
    },
    /// Some are not there.
    #[error("shares are missing: {missing} of {count}; render them")]
    Missing {
        /// The number of the first one that is.
        missing: u32,
        /// How many there must be.
        count: u32,
    },
    /// The picture could not be written.
    #[error(transparent)]
    Output(#[from] OutputError),
}

/// Reads a share band by band.
pub struct ShareReader {
    path: PathBuf,
    from: BufReader<File>,
    /// What it is part of.
    pub header: ShareHeader,
}

impl ShareReader {
    /// Opens a share, and looks whether it is whole.
    ///
    /// # Errors
    ///
    /// [`ShareError::Read`].
    pub fn open(path: &Path) -> Result<ShareReader, ShareError> {
        let fail = |error: Error| {
            let reason = match error.kind() {
                ErrorKind::NotFound => "no such file".to_string(),
                ErrorKind::UnexpectedEof => "it is cut off; render it again".to_string(),
                _ => error.to_string(),
            };
            ShareError::Read { path: path.to_owned(), reason }
        };
        let mut from = BufReader::with_capacity(1 << 18, File::open(path).map_err(fail)?);
        let header = read_header(&mut from).map_err(fail)?;
        Ok(ShareReader { path: path.to_owned(), from, header })
    }

    /// The next band, with features where the picture has layers or alpha.
    fn read_rows(&mut self, rows: &Range<u32>) -> Result<(Film, Option<FeatureRows>), ShareError> {
        let (width, height) = (self.header.size.0, rows.end - rows.start);
        let pixels = width as usize * height as usize;
        let mut bytes = vec![0; pixels * self.header.pixel_bytes() as usize];
        self.from.read_exact(&mut bytes).map_err(|error| ShareError::Read {
            path: self.path.clone(),
            reason: format!("{error}; it has changed"),
        })?;
        let (colors, features) = bytes.split_at(pixels * 12);
        let vector = |words: &[[u8; 4]]| Vec3::from([words[0], words[1], words[2]].map(f32::from_le_bytes));
        let colors = colors.as_chunks::<12>().0.iter().map(|color| vector(color.as_chunks().0)).collect();
        let film = Film { width, height, pixels: colors };
        if features.is_empty() {
            return Ok((film, None));
        }
        let mut all = FeatureRows::new(width, height);
        for (number, bytes) in features.as_chunks::<{ FEATURE_BYTES as usize }>().0.iter().enumerate() {
            let words = bytes.as_chunks::<4>().0;
            let word = |k: usize| u32::from_le_bytes(words[k]);
            all.pixels[number] = PixelFeatures {
                albedo: vector(&words[..3]),
                normal: vector(&words[3..6]),
                background: vector(&words[6..9]),
                depth: f32::from_bits(word(9)),
                object: word(10),
                material: word(11),
            };
            all.work[number] = CameraWork { nodes: word(12), tests: word(13) };
        }
        Ok((film, Some(all)))
    }
}

/// The header of a share that is whole; the bands come next.
fn read_header(from: &mut BufReader<File>) -> Result<ShareHeader, Error> {
    let wrong = |reason: &str| Error::new(ErrorKind::InvalidData, reason.to_string());
    let mut magic = [0; 8];
    from.read_exact(&mut magic)?;
    if magic != MAGIC {
        return Err(wrong("this is no share of a picture"));
    }
    let mut number = [0; 4];
    from.read_exact(&mut number)?;
    let length = u32::from_le_bytes(number);
    if length > MAX_HEADER {
        return Err(wrong("this is no share of a picture"));
    }
    let mut bytes = vec![0; length as usize];
    from.read_exact(&mut bytes)?;
    let header: ShareHeader = serde_json::from_slice(&bytes)
        .map_err(|_| wrong("another version of the program made it; render it again"))?;
    let sides = 1..=MAX_SIDE;
    let (number_of_share, count) = header.share;
    if !sides.contains(&header.size.0)
        || !sides.contains(&header.size.1)
        || !(1..=count).contains(&number_of_share)
    {
        return Err(wrong("its numbers are out of range; render it again"));
    }
    let begin = from.stream_position()?;
    let rows: u64 = header.bands().map(|rows| rows.len() as u64).sum();
    let pixels = rows * u64::from(header.size.0);
    let (end, file_end) = (begin + pixels * header.pixel_bytes(), from.seek(SeekFrom::End(0))?);
    if end + 4 != file_end {
        return Err(wrong("it is not as long as it must be; render it again"));
    }
    from.seek(SeekFrom::Start(0))?;
    let (mut sum, mut left, mut part) = (crc32fast::Hasher::new(), end, vec![0; 1 << 18]);
    while left > 0 {
        let part = &mut part[..left.min(1 << 18) as usize];
        from.read_exact(part)?;
        sum.update(part);
        left -= part.len() as u64;
    }
    from.read_exact(&mut number)?;
    if u32::from_le_bytes(number) != sum.finalize() {
        return Err(wrong("its check sum is wrong; render it again"));
    }
    from.seek(SeekFrom::Start(begin))?;
    Ok(header)
}

/// What must be the same: how the program was called may have differed in what changes no pixel. The whole has the first
/// share's.
fn without_command_line(header: &ShareHeader) -> SaveOptions {
    let mut options = header.options.clone();
    options.metadata.command_line = None;
    options
}

/// Writes the picture that shares make, as one run would have.
///
/// # Errors
///
/// Where the shares are not all of one picture; [`PictureWriter::open`]'s.
pub fn merge(shares: &[PathBuf], output: &Path) -> Result<(), ShareError> {
    let mut readers: Vec<ShareReader> =
        shares.iter().map(|path| ShareReader::open(path)).collect::<Result<_, _>>()?;
    readers.sort_by_key(|reader| reader.header.share);
    let Some(first) = readers.first() else { return Err(ShareError::Missing { missing: 1, count: 1 }) };
    let header = first.header.clone();
    for (number, reader) in (1..).zip(&readers) {
        let other = &reader.header;
        let differ =
            |what| ShareError::Differ { first: first.path.clone(), second: reader.path.clone(), what };
        match () {
            _ if other.share.1 != header.share.1 => return Err(differ("the number of shares")),
            _ if other.program != header.program => return Err(differ("the program that made them")),
            _ if other.size != header.size => return Err(differ("their size")),
            _ if other.scene != header.scene => return Err(differ("scene or settings")),
            _ if without_command_line(other) != without_command_line(&header) => {
                return Err(differ("the settings of the file"));
            }
            _ if other.share.0 > number => {
                return Err(ShareError::Missing { missing: number, count: header.share.1 });
            }
            _ if other.share.0 < number => {
                let before = readers[number as usize - 2].path.clone();
                return Err(ShareError::Twice { first: before, second: reader.path.clone() });
            }
            _ => {}
        }
    }
    if (readers.len() as u64) < u64::from(header.share.1) {
        return Err(ShareError::Missing { missing: readers.len() as u32 + 1, count: header.share.1 });
    }
    let mut writer = PictureWriter::open(output, header.size, &header.options)?;
    let whole = ShareHeader { share: (1, 1), ..header };
    let count = readers.len();
    for (band, rows) in whole.bands().enumerate() {
        let (film, features) = readers[band % count].read_rows(&rows)?;
        writer.write_rows(&film, features.as_ref())?;
    }
    Ok(writer.finish()?)
}
