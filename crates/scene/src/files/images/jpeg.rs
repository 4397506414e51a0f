//! JPEG, baseline and progressive.
//!
//! The standard leaves rounding to the decoder, and decoders round differently in their SIMD code. `zune-jpeg` is
//! therefore a dependency of this crate itself, without the features `x86` and `neon`: what is left is one scalar
//! decoder in whole numbers, the same on every machine. A test holds its texels against a known hash, and so fails
//! where another crate of a workspace turns those features on and that changes a texel.

use super::{Header, Picture, broken_picture, limits};
use crate::model::TexelLayout;
use zune_jpeg::JpegDecoder;
use zune_jpeg::errors::DecodeErrors;
use zune_jpeg::zune_core::bytestream::ZCursor;
use zune_jpeg::zune_core::colorspace::ColorSpace;
use zune_jpeg::zune_core::options::DecoderOptions;

/// A byte holds at most 8 codes, each of a block of 64 samples; with the coarsest subsampling of two components across
/// each other a block stands for 128 texels.
const TEXELS_A_BYTE: u64 = 1024;

fn say(error: DecodeErrors) -> String {
    broken_picture("JPEG", error)
}

pub(super) fn header(bytes: &[u8], most_bytes: u64) -> Result<Header, String> {
    Ok(open(bytes, most_bytes)?.1)
}

/// Over the bytes of a file.
type Decoder<'a> = JpegDecoder<ZCursor<&'a [u8]>>;

fn open(bytes: &[u8], most_bytes: u64) -> Result<(Decoder<'_>, Header), String> {
    if !is_whole(bytes) {
        return Err("the file is cut short: the mark of its end is missing; get it again".into());
    }
    // Strict: data that ends too early is an error, not half a grey picture.
    let options = DecoderOptions::default()
        .set_strict_mode(true)
        .set_use_unsafe(false)
        .set_max_width(65_535)
        .set_max_height(65_535)
        .jpeg_set_out_colorspace(ColorSpace::RGB);
    let mut decoder = JpegDecoder::new_with_options(ZCursor::new(bytes), options);
    decoder.decode_headers().map_err(say)?;
    let info = decoder.info().ok_or("the header of this JPEG is damaged; get it again")?;
    let is_grey = decoder.input_colorspace() == Some(ColorSpace::Luma);
    if is_grey {
        decoder.set_options(options.jpeg_set_out_colorspace(ColorSpace::Luma));
    }
    let layout = TexelLayout::Bytes(if is_grey { 1 } else { 3 });
    let header = limits::size(info.width.into(), info.height.into(), layout, most_bytes)?;
    limits::holds(u64::from(header.width) * u64::from(header.height), TEXELS_A_BYTE, bytes.len())?;
    Ok((decoder, header))
}

pub(super) fn decode(bytes: &[u8], most_bytes: u64) -> Result<Picture, String> {
    let (mut decoder, header) = open(bytes, most_bytes)?;
    Picture::of_bytes(&header, |samples| {
        if decoder.output_buffer_size() != Some(samples.len()) {
            return Err("a JPEG of unusual colours; convert it to RGB".into());
        }
        decoder.decode_into(samples).map_err(say)
    })
}

/// Whether an end follows the last scan. The decoder alone does not notice a cut within the last row of blocks. Within
/// a scan FF is followed by 0 or a restart, so that what looks like these marks is one.
fn is_whole(bytes: &[u8]) -> bool {
    let last = |mark: u8| bytes.windows(2).rposition(|pair| pair == [0xff, mark]);
    let (scan, end) = (last(0xda), last(0xd9));
    scan.is_some() && end > scan
}
