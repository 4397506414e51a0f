//! OpenEXR: linear 32-bit floats.

use super::{MAX_SIDE, SOFTWARE};
use crate::Film;
use eosphor_core::math::{Vec3, vec3};
use exr::prelude::*;
use std::io::{Cursor, Seek, Write};

/// No compression of the format shrinks more than this: a picture that claims to be larger is cut off or a trap.
const MAX_RATIO: u64 = 1 << 16;

pub(super) fn write(writer: impl Write + Seek, film: &Film, complete: bool) -> std::io::Result<()> {
    let width = film.width as usize;
    let colour = |at: Vec2<usize>| {
        let Vec3 { x, y, z } = film.pixels[at.y() * width + at.x()];
        (x, y, z)
    };
    let mut attributes = LayerAttributes { software_name: Text::new_or_none(SOFTWARE), ..Default::default() };
    if !complete {
        attributes.other.insert("incomplete".into(), AttributeValue::I32(1));
    }
    // Run lengths take an eighth of the time of the other methods, and noise does not shrink anyway.
    let layer = Layer::new(
        (width, film.height as usize),
        attributes,
        Encoding::FAST_LOSSLESS,
        SpecificChannels::rgb(colour),
    );
    Image::from_layer(layer).write().to_unbuffered(writer).map_err(|error| match error {
        Error::Io(source) => source,
        other => std::io::Error::other(other.to_string()),
    })
}

/// Red, green and blue of the first layer that has them, at the largest resolution.
pub(super) fn read(bytes: &[u8]) -> std::result::Result<Film, String> {
    let text = |error: Error| error.to_string();
    let meta = MetaData::read_from_buffered(Cursor::new(bytes), false).map_err(text)?;
    for header in &meta.headers {
        let Vec2(width, height) = header.layer_size;
        let limit = MAX_SIDE as usize;
        if !(1..=limit).contains(&width) || !(1..=limit).contains(&height) {
            return Err(format!("its size is {width} x {height}; sides must be 1 to {MAX_SIDE}"));
        }
        if (width * height) as u64 * 2 > (bytes.len() as u64).saturating_mul(MAX_RATIO) {
            return Err("the file is cut off".into());
        }
    }
    let image = exr::prelude::read()
        .no_deep_data()
        .largest_resolution_level()
        .rgb_channels(
            |size, _| Film::new(size.width() as u32, size.height() as u32),
            |film, at, (r, g, b): (f32, f32, f32)| {
                let index = at.y() * film.width as usize + at.x();
                film.pixels[index] = vec3(r, g, b);
            },
        )
        .first_valid_layer()
        .all_attributes()
        .from_buffered(Cursor::new(bytes))
        .map_err(text)?;
    Ok(image.layer_data.channel_data.pixels)
}

/// Whether the file says that its picture was not finished.
#[cfg(test)]
pub(super) fn is_marked_incomplete(bytes: &[u8]) -> bool {
    let meta = MetaData::read_from_buffered(Cursor::new(bytes), false).unwrap();
    meta.headers[0].own_attributes.other.contains_key(&Text::from("incomplete"))
}
