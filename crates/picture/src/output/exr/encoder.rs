//! Writing scan lines in order, without holding the picture.
//!
//! The library compresses lines and lays out headers and blocks; it writes files only where it is given the whole picture
//! or runs the loop itself. What is left to do here is little: the table of where each line begins comes before the
//! lines, so room is left for it, and it is filled in at the end.

use super::channels::{Channel, Row};
use crate::output::destination::Destination;
use crate::output::encoder::LinearEncoder;
use crate::output::metadata::SOFTWARE;
use crate::output::{Metadata, PICTURE_VERSION, Window};
use eosphor_render::{FeatureRows, Film};
use exr::block::chunk::Chunk;
use exr::block::{BlockIndex, UncompressedBlock};
use exr::meta::attribute::{self, AttributeValue, ChannelDescription, LineOrder, Text};
use exr::meta::header::{Header, LayerAttributes};
use exr::meta::{BlockDescription, MetaData, magic_number};
use exr::prelude::{Compression, IntegerBounds, Vec2};
use rayon::prelude::*;
use std::io::{Error, ErrorKind, Result, Seek, Write};

/// Bytes of lines that are compressed before any is written, about.
const BYTES_AT_ONCE: usize = 1 << 24;

/// Says whether the picture is complete; its value, the last bytes of the header's attributes, is written over.
const INCOMPLETE: &str = "incomplete";

/// Where the pixels of a file lie.
pub(in crate::output) struct Layout {
    /// Width and height in pixels: the data window.
    pub(in crate::output) size: (u32, u32),
    /// The picture that they are a part of: the display window.
    pub(in crate::output) window: Option<Window>,
}

/// Compresses lines as they come.
pub(in crate::output) struct ExrEncoder {
    file: Destination,
    channels: Vec<Channel>,
    wants_features: bool,
    headers: [Header; 1],
    /// Where the value of [`INCOMPLETE`] is.
    incomplete_at: u64,
    /// Where each line begins.
    lines: Vec<u64>,
    position: u64,
}

impl ExrEncoder {
    pub(in crate::output) fn new(
        mut file: Destination,
        Layout { size: (width, height), window }: Layout,
        channels: Vec<Channel>,
        metadata: &Metadata,
    ) -> Result<ExrEncoder> {
        let described =
            channels.iter().map(|c| ChannelDescription::named(Text::from(c.name), c.samples)).collect();
        let size = Vec2(width as usize, height as usize);
        // Run lengths take an eighth of the time of the other methods, and noise does not shrink anyway.
        let mut header = Header::new(Text::default(), size, described)
            .with_encoding(Compression::RLE, BlockDescription::ScanLines, LineOrder::Increasing)
            .with_attributes(LayerAttributes::default());
        if let Some(Window { region, whole }) = window {
            header.own_attributes.layer_position = Vec2(region.x as i32, region.y as i32);
            header.shared_attributes.display_window =
                IntegerBounds::from_dimensions((whole.0 as usize, whole.1 as usize));
        }
        let headers = [header];
        let attributes = header_bytes(&headers, metadata).map_err(io_error)?;
        file.write_all(&attributes)?;
        // Room for the table.
        let table = height as u64 * 8;
        std::io::copy(&mut std::io::Read::take(std::io::repeat(0), table), &mut file)?;
        Ok(ExrEncoder {
            file,
            wants_features: channels.iter().any(Channel::is_of_features),
            channels,
            headers,
            // The last value and the byte that ends the header.
            incomplete_at: attributes.len() as u64 - 5,
            lines: Vec::with_capacity(height as usize),
            position: attributes.len() as u64 + table,
        })
    }

    fn compress(&self, y: usize, row: &Row) -> Result<Chunk> {
        let width = row.colors.len();
        let mut data = Vec::with_capacity(self.headers[0].channels.bytes_per_pixel * width);
        self.channels.iter().for_each(|channel| channel.append(row, &mut data));
        let index = BlockIndex {
            layer: 0,
            pixel_position: Vec2(0, y),
            pixel_size: Vec2(width, 1),
            level: Vec2(0, 0),
        };
        UncompressedBlock { index, data }.compress_to_chunk(&self.headers).map_err(io_error)
    }
}

impl LinearEncoder for ExrEncoder {
    fn rows(&mut self, film: &Film, features: Option<&FeatureRows>) -> Result<()> {
        let width = film.width as usize;
        let features = match features {
            None if self.wants_features => {
                return Err(Error::new(
                    ErrorKind::InvalidInput,
                    "layers or alpha are asked for without features",
                ));
            }
            features => features.filter(|_| self.wants_features),
        };
        let row = |y: usize| Row {
            colors: &film.pixels[y * width..][..width],
            features: features.map_or(&[], |f| &f.pixels[y * width..][..width]),
            work: features.map_or(&[], |f| &f.work[y * width..][..width]),
        };
        let at_once = (BYTES_AT_ONCE / (self.headers[0].channels.bytes_per_pixel * width)).max(16);
        for first in (0..film.height as usize).step_by(at_once) {
            let rows = first..(first + at_once).min(film.height as usize);
            let first_line = self.lines.len();
            let compressed =
                rows.clone().into_par_iter().map(|y| self.compress(first_line + y - first, &row(y)));
            let chunks: Vec<Chunk> = compressed.collect::<Result<_>>()?;
            let mut bytes = Vec::new();
            for chunk in chunks {
                self.lines.push(self.position + bytes.len() as u64);
                chunk.write(&mut bytes, 1).map_err(io_error)?;
            }
            self.file.write_all(&bytes)?;
            self.position += bytes.len() as u64;
        }
        Ok(())
    }

    fn finish(mut self: Box<Self>, complete: bool) -> Result<()> {
        let incomplete: i32 = if complete { 0 } else { 1 };
        let table: Vec<u8> = self.lines.iter().flat_map(|line| line.to_le_bytes()).collect();
        // The table follows the byte that ends the header.
        let patch = [&incomplete.to_le_bytes()[..], &[0], &table].concat();
        self.file.patch(self.incomplete_at, &patch)?;
        debug_assert_eq!(self.file.stream_position()?, self.position);
        Ok(())
    }
}

/// All before the table. The library keeps attributes of one's own in a hash table, whose order changes from run to run:
/// they are appended here, in one order.
fn header_bytes(headers: &[Header; 1], metadata: &Metadata) -> exr::error::Result<Vec<u8>> {
    let requirements = MetaData::validate(headers, true)?;
    let mut bytes = Vec::new();
    magic_number::write(&mut bytes)?;
    requirements.write(&mut bytes)?;
    headers[0].write(&mut bytes)?;
    // The byte that ends the header comes after ours.
    bytes.pop();
    let version = PICTURE_VERSION.to_string();
    let texts = [
        ("software", Some(SOFTWARE)),
        ("pictureVersion", Some(&*version)),
        ("sceneHash", metadata.scene_hash.as_deref()),
        ("commandLine", metadata.command_line.as_deref()),
    ];
    for (name, value) in texts {
        if let Some(value) = value {
            // As its bytes: UTF-8, as other programs write and read it.
            let value = AttributeValue::Text(Text::from_bytes_unchecked(value.bytes().collect()));
            attribute::write(Text::from(name).as_slice(), &value, &mut bytes)?;
        }
    }
    attribute::write(Text::from(INCOMPLETE).as_slice(), &AttributeValue::I32(0), &mut bytes)?;
    bytes.push(0);
    Ok(bytes)
}

fn io_error(error: exr::error::Error) -> Error {
    match error {
        exr::error::Error::Io(source) => source,
        other => Error::other(other.to_string()),
    }
}
