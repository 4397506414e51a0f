//! The file of a frame: an ordinary PNG file, without loss, that people can look at while a video is made.

use super::super::Developed;
use super::super::atomic::TemporaryFile;
use super::damaged;
use std::fs::File;
use std::io::{BufReader, BufWriter, Error, Write};
use std::path::Path;

/// The file is whole or not there.
pub(super) fn write(path: &Path, frame: &Developed) -> Result<(), Error> {
    let file = TemporaryFile::beside(path)?;
    let mut to = BufWriter::with_capacity(1 << 18, file.handle()?);
    let mut encoder = png::Encoder::new(&mut to, frame.width, frame.height);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(png::BitDepth::Eight);
    // It is read once and removed: time counts, bytes do not. Compressing took a third of the time that a video took.
    encoder.set_compression(png::Compression::NoCompression);
    let mut writer = encoder.write_header().map_err(reason)?;
    writer.write_image_data(&frame.rgb).and_then(|()| writer.finish()).map_err(reason)?;
    to.flush()?;
    drop(to);
    file.keep()
}

/// What is not a whole frame of this size is [`std::io::ErrorKind::InvalidData`].
pub(super) fn read(path: &Path, (width, height): (u32, u32)) -> Result<Developed, Error> {
    let file = BufReader::with_capacity(1 << 18, File::open(path)?);
    let mut reader = png::Decoder::new(file).read_info().map_err(explain)?;
    if reader.info().size() != (width, height)
        || reader.output_color_type() != (png::ColorType::Rgb, png::BitDepth::Eight)
    {
        return Err(damaged("this is no frame of this video"));
    }
    let mut rgb = vec![0; width as usize * height as usize * 3];
    reader.next_frame(&mut rgb).map_err(explain)?;
    // What follows the pixels is part of a whole file.
    reader.finish().map_err(explain)?;
    Ok(Developed { width, height, rgb, alpha: Vec::new() })
}

/// The system's own reason, where there is one.
fn reason(error: png::EncodingError) -> Error {
    match error {
        png::EncodingError::IoError(error) => error,
        error => Error::other(error.to_string()),
    }
}

fn explain(error: png::DecodingError) -> Error {
    match error {
        png::DecodingError::IoError(error) if error.kind() != std::io::ErrorKind::UnexpectedEof => error,
        error => damaged(error.to_string()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::ErrorKind;

    #[test]
    fn any_damage_to_a_frame_is_noticed_or_harmless() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.png");
        let frame =
            Developed { width: 5, height: 3, rgb: (0..45).map(|i| i * 5).collect(), alpha: Vec::new() };
        write(&path, &frame).unwrap();
        assert_eq!(read(&path, (5, 3)).unwrap(), frame);
        assert_eq!(read(&path, (3, 5)).unwrap_err().kind(), ErrorKind::InvalidData);
        let whole = std::fs::read(&path).unwrap();
        for at in 0..whole.len() {
            let mut bytes = whole.clone();
            bytes[at] ^= 1 << (at % 8);
            std::fs::write(&path, &bytes).unwrap();
            match read(&path, (5, 3)) {
                Ok(read) => assert_eq!(read, frame, "byte {at}"),
                Err(error) => assert_eq!(error.kind(), ErrorKind::InvalidData, "byte {at}: {error}"),
            }
            std::fs::write(&path, &whole[..at]).unwrap();
            assert_eq!(read(&path, (5, 3)).unwrap_err().kind(), ErrorKind::InvalidData, "{at} bytes");
        }
    }
}
