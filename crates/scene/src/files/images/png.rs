//! PNG: all colour types and depths, transparency, interlacing.

use super::{Header, Picture, broken_picture, limits, rgba, to_byte};
use crate::model::Texels;
use png::{BitDepth, ColorType, Decoder, Reader, Transformations};
use std::io::Cursor;

/// Deflate packs at most this many bytes into one.
const DEFLATE: u64 = 1032;

pub(super) fn header(bytes: &[u8]) -> Result<Header, String> {
    Ok(open(bytes)?.1)
}

/// Over the bytes of a file.
type BytesReader<'a> = Reader<Cursor<&'a [u8]>>;

fn open(bytes: &[u8]) -> Result<(BytesReader<'_>, Header), String> {
    let mut decoder = Decoder::new(Cursor::new(bytes));
    decoder.set_ignore_text_chunk(true);
    decoder.set_ignore_iccp_chunk(true);
    // Palettes become colours, 1 to 4 bits become 8, a transparent colour becomes alpha; 16 bits stay.
    decoder.set_transformations(Transformations::EXPAND);
    let reader = decoder.read_info().map_err(say)?;
    let header = limits::size(reader.info().width.into(), reader.info().height.into(), limits::RGBA8)?;
    let bits = u64::from(header.width) * reader.info().bits_per_pixel() as u64;
    limits::holds(bits.div_ceil(8) * u64::from(header.height), DEFLATE, bytes.len())?;
    Ok((reader, header))
}

pub(super) fn decode(bytes: &[u8]) -> Result<Picture, String> {
    let (mut reader, Header { width, height, .. }) = open(bytes)?;
    let size = reader.output_buffer_size().ok_or("the picture is too large for this machine")?;
    let mut samples = vec![0; size];
    let frame = reader.next_frame(&mut samples).map_err(say)?;
    let texels = match frame.bit_depth {
        BitDepth::Sixteen => {
            let wide = |pair: &[u8]| to_byte(u32::from(pair[0]) << 8 | u32::from(pair[1]), 65_535);
            let bytes: Vec<u8> = samples.chunks_exact(2).map(wide).collect();
            pack(frame.color_type, &bytes)
        }
        _ => pack(frame.color_type, &samples),
    };
    Ok(Picture { width, height, texels: Texels::Rgba8(texels) })
}

fn say(error: png::DecodingError) -> String {
    broken_picture("PNG", error)
}

fn pack(kind: ColorType, samples: &[u8]) -> Vec<u32> {
    let by = |channels: usize, texel: fn(&[u8]) -> u32| samples.chunks_exact(channels).map(texel).collect();
    match kind {
        // Palettes are expanded to RGB or RGBA.
        ColorType::Grayscale | ColorType::Indexed => by(1, |c| rgba(c[0], c[0], c[0], 255)),
        ColorType::GrayscaleAlpha => by(2, |c| rgba(c[0], c[0], c[0], c[1])),
        ColorType::Rgb => by(3, |c| rgba(c[0], c[1], c[2], 255)),
        ColorType::Rgba => by(4, |c| rgba(c[0], c[1], c[2], c[3])),
    }
}
