//! PNG.

use super::destination::Destination;
use super::encoder::ByteEncoder;
use super::metadata::SOFTWARE;
use super::{Developed, Metadata, PICTURE_VERSION};
use std::io::{Error, Seek, SeekFrom, Write};

/// The chunk that ends every file.
const IEND: [u8; 12] = [0, 0, 0, 0, b'I', b'E', b'N', b'D', 0xae, 0x42, 0x60, 0x82];

/// Compresses rows as they come.
pub(super) struct PngEncoder {
    rows: png::StreamWriter<'static, Destination>,
    file: Destination,
    has_alpha: bool,
}

impl PngEncoder {
    pub(super) fn new(
        file: Destination,
        (width, height): (u32, u32),
        has_alpha: bool,
        metadata: &Metadata,
    ) -> Result<PngEncoder, Error> {
        let mut encoder = png::Encoder::new(file.clone(), width, height);
        encoder.set_color(if has_alpha { png::ColorType::Rgba } else { png::ColorType::Rgb });
        encoder.set_depth(png::BitDepth::Eight);
        // Balanced takes 39 times as long for 10 % fewer bytes.
        encoder.set_compression(png::Compression::Fast);
        encoder.add_text_chunk("Software".into(), SOFTWARE.into())?;
        encoder.add_text_chunk("Picture version".into(), PICTURE_VERSION.to_string())?;
        let texts = [("Scene hash", &metadata.scene_hash), ("Command line", &metadata.command_line)];
        for (keyword, text) in texts.into_iter().filter_map(|(keyword, text)| Some((keyword, text.clone()?)))
        {
            // Plain text chunks are Latin-1.
            match text.is_ascii() {
                true => encoder.add_text_chunk(keyword.into(), text)?,
                false => encoder.add_itxt_chunk(keyword.into(), text)?,
            }
        }
        Ok(PngEncoder { rows: encoder.write_header()?.into_stream_writer()?, file, has_alpha })
    }
}

impl ByteEncoder for PngEncoder {
    fn rows(&mut self, rows: &Developed) -> Result<(), Error> {
        if !self.has_alpha {
            return self.rows.write_all(&rows.rgb);
        }
        let pixels = rows.rgb.as_chunks::<3>().0.iter().zip(&rows.alpha);
        let rgba: Vec<u8> = pixels.flat_map(|(&[r, g, b], &alpha)| [r, g, b, alpha]).collect();
        self.rows.write_all(&rgba)
    }

    fn finish(self: Box<Self>, complete: bool) -> Result<(), Error> {
        let PngEncoder { rows, mut file, .. } = *self;
        rows.finish()?;
        if !complete {
            file.seek(SeekFrom::End(-(IEND.len() as i64)))?;
            file.write_all(&text_chunk(b"Comment\0incomplete"))?;
            file.write_all(&IEND)?;
        }
        Ok(())
    }
}

/// A `tEXt` chunk: length, kind, text, check sum.
fn text_chunk(text: &[u8]) -> Vec<u8> {
    let body = [b"tEXt", text].concat();
    let sum = crc32fast::hash(&body);
    [&(text.len() as u32).to_be_bytes()[..], &body, &sum.to_be_bytes()].concat()
}
