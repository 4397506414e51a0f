//! The file of an encoded segment.
//!
//! | part | bytes |
//! |---|---|
//! | header | `EOSVSEG1`, number of the segment, its frames |
//! | samples | one after the other |
//! | table | the length of each sample; both parameter sets, each after its length |
//! | end | the length of the table, CRC-32 of all before it |
//!
//! Numbers are 32 bits, lowest byte first. Samples come before their lengths, so that they need not be in memory.

use super::super::atomic::TemporaryFile;
use super::damaged;
use super::encoder::ParameterSets;
use std::fs::File;
use std::io::{BufReader, BufWriter, Error, ErrorKind, Read, Seek, SeekFrom, Write};
use std::path::Path;

const MAGIC: [u8; 8] = *b"EOSVSEG1";
const HEADER: u64 = 16;
const END: u64 = 8;

/// Far above what the encoder can make of its parameter sets.
const MAX_PARAMETERS: u64 = 1 << 16;

/// Writes a segment sample by sample. The file is whole or not there.
pub(super) struct SegmentWriter {
    file: TemporaryFile,
    to: BufWriter<File>,
    sum: crc32fast::Hasher,
    lengths: Vec<u32>,
}

impl SegmentWriter {
    pub(super) fn begin(path: &Path, number: u32, frames: u32) -> Result<SegmentWriter, Error> {
        let file = TemporaryFile::beside(path)?;
        let to = BufWriter::with_capacity(1 << 18, file.handle()?);
        let mut writer = SegmentWriter { file, to, sum: crc32fast::Hasher::new(), lengths: Vec::new() };
        writer.write(&MAGIC)?;
        writer.write(&number.to_le_bytes())?;
        writer.write(&frames.to_le_bytes())?;
        Ok(writer)
    }

    pub(super) fn sample(&mut self, sample: &[u8]) -> Result<(), Error> {
        self.lengths.push(u32::try_from(sample.len()).map_err(Error::other)?);
        self.write(sample)
    }

    pub(super) fn finish(mut self, parameters: &ParameterSets) -> Result<(), Error> {
        let mut table: Vec<u8> = self.lengths.iter().flat_map(|length| length.to_le_bytes()).collect();
        for set in [&parameters.sequence, &parameters.picture] {
            table.extend_from_slice(&u32::try_from(set.len()).map_err(Error::other)?.to_le_bytes());
            table.extend_from_slice(set);
        }
        self.write(&table)?;
        self.write(&u32::try_from(table.len()).map_err(Error::other)?.to_le_bytes())?;
        let sum = self.sum.clone().finalize();
        self.to.write_all(&sum.to_le_bytes())?;
        self.to.flush()?;
        drop(self.to);
        self.file.keep()
    }

    fn write(&mut self, bytes: &[u8]) -> Result<(), Error> {
        self.sum.update(bytes);
        self.to.write_all(bytes)
    }
}

/// A segment that was read and found whole.
#[derive(Debug)]
pub(super) struct Segment {
    file: File,
    /// Bytes of each sample.
    pub(super) lengths: Vec<u32>,
    pub(super) parameters: ParameterSets,
}

impl Segment {
    /// Reads all of the file. What is not whole, or not this segment, is [`ErrorKind::InvalidData`].
    pub(super) fn open(path: &Path, number: u32, frames: u32) -> Result<Segment, Error> {
        let mut file = File::open(path)?;
        let length = file.metadata()?.len();
        let checked = check_sum(&file, length).and_then(|()| read_table(&mut file, length, number, frames));
        let (lengths, parameters) = checked.map_err(|error| match error.kind() {
            ErrorKind::UnexpectedEof => damaged("the segment is cut off"),
            _ => error,
        })?;
        Ok(Segment { file, lengths, parameters })
    }

    /// Copies the samples, one after the other.
    pub(super) fn copy_samples(&mut self, to: &mut impl Write) -> Result<(), Error> {
        self.file.seek(SeekFrom::Start(HEADER))?;
        let length: u64 = self.lengths.iter().map(|&length| length as u64).sum();
        match std::io::copy(&mut (&self.file).take(length), to)? {
            copied if copied == length => Ok(()),
            _ => Err(damaged("the segment is cut off")),
        }
    }
}

fn check_sum(file: &File, length: u64) -> Result<(), Error> {
    let Some(mut left) = length.checked_sub(4) else { return Err(ErrorKind::UnexpectedEof.into()) };
    let mut from = BufReader::new(file);
    let mut sum = crc32fast::Hasher::new();
    let mut part = vec![0; 1 << 18];
    while left > 0 {
        let part = &mut part[..left.min(1 << 18) as usize];
        from.read_exact(part)?;
        sum.update(part);
        left -= part.len() as u64;
    }
    match read_number(&mut from)? == sum.finalize() {
        true => Ok(()),
        false => Err(damaged("the segment's check sum is wrong")),
    }
}

fn read_table(
    file: &mut File,
    length: u64,
    number: u32,
    frames: u32,
) -> Result<(Vec<u32>, ParameterSets), Error> {
    let wrong = || damaged("this is no such segment");
    file.seek(SeekFrom::Start(0))?;
    let mut header = [0; HEADER as usize];
    file.read_exact(&mut header)?;
    if header != *[&MAGIC[..], &number.to_le_bytes(), &frames.to_le_bytes()].concat() || length < HEADER + END
    {
        return Err(wrong());
    }
    file.seek(SeekFrom::Start(length - END))?;
    let table = read_number(file)? as u64;
    if table > length - HEADER - END || table > frames as u64 * 4 + MAX_PARAMETERS {
        return Err(wrong());
    }
    file.seek(SeekFrom::Start(length - END - table))?;
    let mut bytes = vec![0; table as usize];
    file.read_exact(&mut bytes)?;
    let mut rest = &bytes[..];
    let lengths = (0..frames).map(|_| read_number(&mut rest)).collect::<Result<Vec<u32>, Error>>()?;
    let parameters = ParameterSets { sequence: read_bytes(&mut rest)?, picture: read_bytes(&mut rest)? };
    let samples: u64 = lengths.iter().map(|&length| length as u64).sum();
    match rest.is_empty() && HEADER + samples + table + END == length {
        true => Ok((lengths, parameters)),
        false => Err(wrong()),
    }
}

fn read_number(from: &mut impl Read) -> Result<u32, Error> {
    let mut bytes = [0; 4];
    from.read_exact(&mut bytes)?;
    Ok(u32::from_le_bytes(bytes))
}

fn read_bytes(from: &mut &[u8]) -> Result<Vec<u8>, Error> {
    let length = read_number(from)? as usize;
    let (bytes, rest) = from.split_at_checked(length).ok_or(ErrorKind::UnexpectedEof)?;
    *from = rest;
    Ok(bytes.to_vec())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn written(path: &Path) {
        let mut writer = SegmentWriter::begin(path, 7, 3).unwrap();
        for sample in [&b"one"[..], b"", b"three"] {
            writer.sample(sample).unwrap();
        }
        writer.finish(&ParameterSets { sequence: b"abc".to_vec(), picture: b"d".to_vec() }).unwrap();
    }

    #[test]
    fn a_segment_comes_back() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("segment");
        written(&path);
        let mut segment = Segment::open(&path, 7, 3).unwrap();
        let mut samples = Vec::new();
        segment.copy_samples(&mut samples).unwrap();
        assert_eq!((&samples[..], &segment.lengths[..]), (&b"onethree"[..], &[3, 0, 5][..]));
        assert_eq!(segment.parameters, ParameterSets { sequence: b"abc".to_vec(), picture: b"d".to_vec() });
        for (number, frames) in [(6, 3), (7, 2), (7, 4)] {
            assert_eq!(Segment::open(&path, number, frames).unwrap_err().kind(), ErrorKind::InvalidData);
        }
    }

    #[test]
    fn any_damage_is_noticed() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("segment");
        written(&path);
        let whole = std::fs::read(&path).unwrap();
        for at in 0..whole.len() {
            let mut bytes = whole.clone();
            bytes[at] ^= 1 << (at % 8);
            std::fs::write(&path, &bytes).unwrap();
            assert_eq!(Segment::open(&path, 7, 3).unwrap_err().kind(), ErrorKind::InvalidData, "byte {at}");
            std::fs::write(&path, &whole[..at]).unwrap();
            assert_eq!(Segment::open(&path, 7, 3).unwrap_err().kind(), ErrorKind::InvalidData, "{at} bytes");
        }
    }
}
