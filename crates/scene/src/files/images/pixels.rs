//! Pictures as whoever compares them needs them: all of their bits or an error, and of any size.

use super::{Kind, Picture, broken_picture, data, hdr, jpeg, kind, png, pnm};
use crate::model::TexelLayout;

/// A decoded picture file.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct PicturePixels {
    /// Pixels a row, 1 to 65,535.
    pub width: u32,
    /// Rows, 1 to 65,535.
    pub height: u32,
    /// `width * height` pixels, top row first: R, G, B and A, or of HDR files R, G, B and the exponent that they share.
    pub pixels: Vec<[u8; 4]>,
}

/// The pixels of the contents of a PNG file: R, G, B and A, which is 255 where the file has none. Files of 16 bits a
/// channel are an error. The error says what is wrong with the file, but not its name.
pub fn read_png(bytes: &[u8]) -> Result<PicturePixels, String> {
    expect("PNG", matches!(kind(bytes, ""), Ok(Kind::Png)))?;
    if png::has_16_bits(bytes) {
        return Err("16 bits a channel are not supported; convert it to 8 bits".into());
    }
    Ok(pixels(png::decode(bytes, u64::MAX)?))
}

/// The pixels of the contents of a JPEG file: R, G, B and 255. The error says what is wrong with the file, but not its
/// name.
pub fn read_jpeg(bytes: &[u8]) -> Result<PicturePixels, String> {
    expect("JPEG", matches!(kind(bytes, ""), Ok(Kind::Jpeg)))?;
    Ok(pixels(jpeg::decode(bytes, u64::MAX)?))
}

/// The pixels of the contents of a PPM, PGM or PBM file: R, G, B and 255. Files whose largest value is not 255 are an
/// error, but for those of one bit. The error says what is wrong with the file, but not its name.
pub fn read_ppm(bytes: &[u8]) -> Result<PicturePixels, String> {
    expect("PPM", matches!(kind(bytes, ""), Ok(Kind::Pnm)))?;
    match pnm::largest_value(bytes)? {
        1 | 255 => Ok(pixels(pnm::decode(bytes, u64::MAX)?)),
        most => Err(format!("its largest value is {most}; only 255 is read: save it with 8 bits a channel")),
    }
}

/// The pixels of the contents of a `.data` file: R, G, B and A. The error says what is wrong with the file, but not its
/// name.
pub fn read_data(bytes: &[u8]) -> Result<PicturePixels, String> {
    Ok(pixels(data::decode(bytes, u64::MAX)?))
}

/// The pixels of the contents of a Radiance HDR file: R, G, B and exponent e; a channel m is the number m · 2^(e − 136),
/// and 0 where e is 0. The error says what is wrong with the file, but not its name.
pub fn read_hdr(bytes: &[u8]) -> Result<PicturePixels, String> {
    expect("HDR", matches!(kind(bytes, ""), Ok(Kind::Hdr)))?;
    Ok(pixels(hdr::decode(bytes, u64::MAX)?))
}

fn expect(format: &str, is_it: bool) -> Result<(), String> {
    if is_it { Ok(()) } else { Err(broken_picture(format, "it does not begin as such files do")) }
}

fn pixels(picture: Picture) -> PicturePixels {
    let Picture { width, height, texels } = picture;
    let stored = match texels.layout() {
        TexelLayout::Rgbe => 4,
        layout => layout.channels() as usize,
    };
    let mut bytes = texels.channel_bytes();
    let pixel = |_| {
        let mut texel = [0; 4];
        texel[..stored].fill_with(|| bytes.next().unwrap_or_default());
        match (stored, texel) {
            (1, [grey, ..]) => [grey, grey, grey, 255],
            (2, [grey, alpha, ..]) => [grey, grey, grey, alpha],
            (3, [r, g, b, _]) => [r, g, b, 255],
            _ => texel,
        }
    };
    PicturePixels { width, height, pixels: (0..texels.len()).map(pixel).collect() }
}
