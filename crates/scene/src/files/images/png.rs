//! PNG: all colour types and depths, transparency, interlacing.

use super::{Header, Picture, broken_picture, limits, to_byte};
use crate::model::TexelLayout;
use png::{BitDepth, Decoder, Reader, Transformations};
use std::io::Cursor;

/// Deflate packs at most this many bytes into one.
const DEFLATE: u64 = 1032;

pub(super) fn header(bytes: &[u8], most_bytes: u64) -> Result<Header, String> {
    Ok(open(bytes, most_bytes)?.1)
}

/// Whether its head says so.
pub(super) fn has_16_bits(bytes: &[u8]) -> bool {
    bytes.get(24) == Some(&16)
}

/// Over the bytes of a file.
type BytesReader<'a> = Reader<Cursor<&'a [u8]>>;

fn open(bytes: &[u8], most_bytes: u64) -> Result<(BytesReader<'_>, Header), String> {
    let mut decoder = Decoder::new(Cursor::new(bytes));
    decoder.set_ignore_text_chunk(true);
    decoder.set_ignore_iccp_chunk(true);
    // Palettes become colours, 1 to 4 bits become 8, a transparent colour becomes alpha; 16 bits stay.
    decoder.set_transformations(Transformations::EXPAND);
    let reader = decoder.read_info().map_err(say)?;
    // 16 bits become 8 as well: textures have no more.
    let layout = TexelLayout::Bytes(reader.output_color_type().0.samples() as u32);
    let header = limits::size(reader.info().width.into(), reader.info().height.into(), layout, most_bytes)?;
    let bits = u64::from(header.width) * reader.info().bits_per_pixel() as u64;
    limits::holds(bits.div_ceil(8) * u64::from(header.height), DEFLATE, bytes.len())?;
    Ok((reader, header))
}

pub(super) fn decode(bytes: &[u8], most_bytes: u64) -> Result<Picture, String> {
    let (mut reader, header) = open(bytes, most_bytes)?;
    let is_wide = reader.output_color_type().1 == BitDepth::Sixteen;
    Picture::of_bytes(&header, |bytes| match (is_wide, reader.info().interlaced) {
        (false, _) => reader.next_frame(bytes).map(drop).map_err(say),
        (true, true) => {
            let size = reader.output_buffer_size().ok_or("the picture is too large for this machine")?;
            let mut samples = vec![0; size];
            reader.next_frame(&mut samples).map_err(say)?;
            narrow(&samples, bytes);
            Ok(())
        }
        (true, false) => {
            for row in bytes.chunks_exact_mut(bytes.len() / header.height as usize) {
                let samples = reader.next_row().map_err(say)?.ok_or("it has too few rows; get it again")?;
                narrow(samples.data(), row);
            }
            // What comes after the last row must be whole too.
            reader.next_row().map(drop).map_err(say)
        }
    })
}

/// Samples of 16 bits as bytes.
fn narrow(samples: &[u8], bytes: &mut [u8]) {
    for (pair, byte) in samples.as_chunks::<2>().0.iter().zip(bytes) {
        *byte = to_byte(u32::from(u16::from_be_bytes(*pair)), 65_535);
    }
}

fn say(error: png::DecodingError) -> String {
    broken_picture("PNG", error)
}
