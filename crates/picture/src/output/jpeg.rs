//! JPEG: baseline, sRGB bytes.
//!
//! The library encodes whole pictures. Here each row of its blocks is encoded as a picture of its own, and their data is
//! joined by restart markers, which are for just this. So the picture need not be in memory, rows of blocks are encoded
//! in parallel, and all of it is ordinary baseline JPEG.

use super::Developed;
use super::destination::Destination;
use super::encoder::ByteEncoder;
use super::metadata::{SOFTWARE, completeness};
use jpeg_encoder::{ColorType, Encoder, SamplingFactor};
use rayon::prelude::*;
use std::io::{Error, Write};

/// From this quality on colours keep their full resolution; below, 2 × 2 pixels share theirs.
const FULL_COLOUR_QUALITY: u8 = 90;

/// Encodes rows of blocks as they become whole.
pub(super) struct JpegEncoder {
    file: Destination,
    width: u32,
    height: u32,
    quality: u8,
    /// Rows that are not a whole row of blocks yet.
    pending: Vec<u8>,
    rows_taken: u32,
    strips_written: usize,
    /// Where the file says whether the picture is complete.
    completeness_at: u64,
}

impl JpegEncoder {
    /// `quality` from 1 to 100.
    pub(super) fn new(file: Destination, width: u32, height: u32, quality: u8) -> JpegEncoder {
        JpegEncoder {
            file,
            width,
            height,
            quality,
            pending: Vec::new(),
            rows_taken: 0,
            strips_written: 0,
            completeness_at: 0,
        }
    }

    /// Pixels along a side of a block.
    fn block_side(&self) -> u32 {
        if self.quality < FULL_COLOUR_QUALITY { 16 } else { 8 }
    }

    /// A picture of at most a row of blocks.
    fn encode_strip(&self, rgb: &[u8]) -> Result<Vec<u8>, Error> {
        let mut bytes = Vec::new();
        let mut encoder = Encoder::new(&mut bytes, self.quality);
        encoder.set_sampling_factor(match self.block_side() {
            8 => SamplingFactor::F_1_1,
            _ => SamplingFactor::F_2_2,
        });
        // As many blocks as a strip has: the marker between strips is ours to write.
        encoder.set_restart_interval(self.width.div_ceil(self.block_side()) as u16);
        let rows = rgb.len() / (self.width as usize * 3);
        encoder.encode(rgb, self.width as u16, rows as u16, ColorType::Rgb).map_err(Error::other)?;
        Ok(bytes)
    }

    fn write_strip(&mut self, strip: &[u8]) -> Result<(), Error> {
        let parts = Parts::of(strip).ok_or_else(|| Error::other("the JPEG encoder wrote no picture"))?;
        match self.strips_written {
            0 => self.write_header(&parts)?,
            // Restart markers are numbered from 0 to 7, again and again.
            number => self.file.write_all(&[0xff, 0xd0 + ((number - 1) % 8) as u8])?,
        }
        self.strips_written += 1;
        self.file.write_all(parts.data)
    }

    /// The header of the first strip, but for the height and with a comment.
    fn write_header(&mut self, parts: &Parts) -> Result<(), Error> {
        let mut header = parts.header.to_vec();
        let [high, low] = (self.height as u16).to_be_bytes();
        // Of the frame header: marker, length and precision come before the height.
        header[parts.frame + 5..][..2].copy_from_slice(&[high, low]);
        let text = format!("{SOFTWARE}, {}", completeness(true));
        let length = (text.len() + 2) as u16;
        let comment = [&[0xff, 0xfe], &length.to_be_bytes()[..], text.as_bytes()].concat();
        self.completeness_at = (parts.frame + comment.len() - completeness(true).len()) as u64;
        self.file.write_all(&header[..parts.frame])?;
        self.file.write_all(&comment)?;
        self.file.write_all(&header[parts.frame..])
    }
}

impl ByteEncoder for JpegEncoder {
    fn rows(&mut self, rows: &Developed) -> Result<(), Error> {
        self.pending.extend_from_slice(&rows.rgb);
        self.rows_taken += rows.height;
        let strip = self.width as usize * 3 * self.block_side() as usize;
        // The last strip may be lower.
        let ready = match self.rows_taken == self.height {
            true => self.pending.len(),
            false => self.pending.len() / strip * strip,
        };
        let strips = self.pending[..ready].par_chunks(strip).map(|rgb| self.encode_strip(rgb));
        for strip in strips.collect::<Result<Vec<_>, _>>()? {
            self.write_strip(&strip)?;
        }
        self.pending.drain(..ready);
        Ok(())
    }

    fn finish(mut self: Box<Self>, complete: bool) -> Result<(), Error> {
        self.file.write_all(&[0xff, 0xd9])?;
        self.file.patch(self.completeness_at, completeness(complete).as_bytes())
    }
}

/// The parts of a JPEG file of one scan.
struct Parts<'a> {
    /// All up to the data.
    header: &'a [u8],
    /// Where in it the segment of the frame begins.
    frame: usize,
    /// The compressed pixels, without the marker of the end.
    data: &'a [u8],
}

impl Parts<'_> {
    fn of(file: &[u8]) -> Option<Parts<'_>> {
        let (mut at, mut frame) = (2, None);
        loop {
            let segment = file.get(at..at + 4)?;
            let end = at + 2 + u16::from_be_bytes([segment[2], segment[3]]) as usize;
            match segment[1] {
                0xc0 => frame = Some(at),
                0xda => {
                    let data = file.get(end..file.len() - 2)?;
                    return Some(Parts { header: &file[..end], frame: frame?, data });
                }
                _ => {}
            }
            at = end;
        }
    }
}
