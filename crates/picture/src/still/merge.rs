//! The picture that shares of its samples make.

use super::identity::SampleShare;
use super::sums_file::{Found, SumsError, SumsFile};
use crate::output::{OutputError, PictureWriter};
use eosphor_render::SampleSums;
use std::path::{Path, PathBuf};

/// Why shares of samples make no picture.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum MergeError {
    /// One cannot be read.
    #[error(transparent)]
    Sums(#[from] SumsError),
    /// A file is no share of samples; the message says what it is and what to do.
    #[error("cannot merge: {}: {what}", path.display())]
    NoShare {
        /// The file.
        path: PathBuf,
        /// What it is, and what to do.
        what: &'static str,
    },
    /// A share is not whole, as its render was ended early.
    #[error("cannot merge: {}: it is not whole: resume its render", path.display())]
    NotWhole {
        /// The file of the share.
        path: PathBuf,
    },
    /// The file keeps what is done of a still, which is no share.
    #[error("cannot merge: {}: this is what is kept of a still: resume the render of the still", path.display())]
    KeptStill {
        /// The file.
        path: PathBuf,
    },
    /// Two are not of one picture.
    #[error("{} and {} are shares of different pictures: they differ in scene or settings", first.display(), second.display())]
    Differ {
        /// One file.
        first: PathBuf,
        /// Another.
        second: PathBuf,
    },
    /// Two have samples in common.
    #[error("{} and {} have the same samples", first.display(), second.display())]
    Twice {
        /// One file.
        first: PathBuf,
        /// Another.
        second: PathBuf,
    },
    /// Some are not there.
    #[error("samples are missing: {first} to {end} of {all}; render them")]
    Missing {
        /// The first of them.
        first: u32,
        /// The one after the last.
        end: u32,
        /// How many there must be.
        all: u32,
    },
    /// The picture could not be written.
    #[error(transparent)]
    Output(#[from] OutputError),
}

struct Reader {
    file: SumsFile,
    share: SampleShare,
}

/// Writes the picture that shares of its samples make, as one run would have.
///
/// # Errors
///
/// Where the shares are not all of one picture; [`PictureWriter::open`]'s.
pub fn merge_samples(shares: &[PathBuf], output: &Path) -> Result<(), MergeError> {
    let mut readers = shares.iter().map(|path| open(path)).collect::<Result<Vec<Reader>, _>>()?;
    readers.sort_by_key(|reader| reader.share.samples.start);
    let Some(first) = readers.first() else { return Err(MergeError::Missing { first: 0, end: 1, all: 1 }) };
    let (size, SampleShare { all, options, .. }) = (first.file.header().size, first.share.clone());
    let mut next = 0;
    for (number, reader) in readers.iter().enumerate() {
        let (path, before) = (reader.file.path(), readers[number.saturating_sub(1)].file.path());
        let pair = (first.file.path().to_owned(), path.to_owned());
        if reader.file.header().size != size || !reader.share.is_beside(&first.share) {
            return Err(MergeError::Differ { first: pair.0, second: pair.1 });
        }
        let samples = &reader.share.samples;
        if samples.start > next {
            return Err(MergeError::Missing { first: next, end: samples.start, all });
        }
        if samples.start < next {
            return Err(MergeError::Twice { first: before.to_owned(), second: pair.1 });
        }
        next = samples.end;
    }
    if next < all {
        return Err(MergeError::Missing { first: next, end: all, all });
    }
    let mut writer = PictureWriter::open(output, size, &options)?;
    // Strips of the shares have other rows.
    let mut waiting: Vec<(u32, SampleSums)> = Vec::new();
    let mut row = 0;
    while row < size.1 {
        for (number, reader) in readers.iter_mut().enumerate() {
            if waiting.len() == number {
                waiting.push((row, SampleSums::new(size.0, 0)));
            }
            let (begin, sums) = &mut waiting[number];
            if *begin + sums.height == row {
                let path = reader.file.path().to_owned();
                let what = "it has changed; render it again";
                let no_share = || MergeError::NoShare { path, what };
                let rows = reader.file.rows_from(row).map_err(|_| no_share())?;
                let strip = reader.file.strip(rows)?;
                if strip.samples != reader.share.samples.len() as u32 {
                    let path = reader.file.path().to_owned();
                    return Err(MergeError::NoShare { path, what });
                }
                (*begin, *sums) = (strip.rows.start, strip.sums);
            }
        }
        let end = waiting.iter().map(|(begin, sums)| begin + sums.height).min().unwrap_or(size.1);
        let mut all_sums = SampleSums::new(size.0, end - row);
        for (begin, sums) in &waiting {
            let at = |row: u32| (row - begin) as usize * size.0 as usize;
            let rows = &sums.sums[at(row)..at(end)];
            all_sums.sums.iter_mut().zip(rows).for_each(|(sum, other)| sum.merge(other));
        }
        writer.write_rows(&all_sums.film(all), None)?;
        row = end;
    }
    Ok(writer.finish()?)
}

fn open(path: &Path) -> Result<Reader, MergeError> {
    let wrong = |what| Err(MergeError::NoShare { path: path.to_owned(), what });
    let file = match SumsFile::open(path)? {
        Found::Nothing => return wrong("no such file"),
        Found::Begun => return Err(MergeError::NotWhole { path: path.to_owned() }),
        Found::Sums(file) => *file,
    };
    let Some(share) = file.header().share.clone() else {
        return Err(MergeError::KeptStill { path: path.to_owned() });
    };
    let samples = share.samples.clone();
    if samples.is_empty() || samples.end > share.all {
        return wrong("its numbers are out of range; render it again");
    }
    if !file.has(&(0..file.header().size.1), samples.len() as u32) {
        return Err(MergeError::NotWhole { path: path.to_owned() });
    }
    Ok(Reader { file, share })
}
