//! Reading colours.

use crate::output::MAX_SIDE;
use eosphor_core::math::vec3;
use eosphor_render::Film;
use eosphor_scene::broken_picture;
use exr::meta::header::Header;
use exr::prelude::*;
use std::io::Cursor;

/// No compression of the format shrinks more than this: a picture that claims to be larger is cut off or a trap.
const MAX_RATIO: u64 = 1 << 16;

/// Red, green and blue of the first layer that has them, at the largest resolution.
pub(in crate::output) fn read(bytes: &[u8]) -> std::result::Result<Film, String> {
    let text = |error: Error| broken_picture("EXR", error);
    let meta = MetaData::read_from_buffered(Cursor::new(bytes), false).map_err(text)?;
    for header in &meta.headers {
        let Vec2(width, height) = header.layer_size;
        let limit = MAX_SIDE as usize;
        if !(1..=limit).contains(&width) || !(1..=limit).contains(&height) {
            return Err(format!("its size is {width} x {height}; sides must be 1 to {MAX_SIDE}"));
        }
        if (width * height) as u64 * 2 > (bytes.len() as u64).saturating_mul(MAX_RATIO) {
            return Err("the file is cut off; get it again".into());
        }
    }
    let has = |header: &Header, name: &str| header.channels.list.iter().any(|channel| channel.name.eq(name));
    if !meta.headers.iter().any(|header| ["R", "G", "B"].iter().all(|name| has(header, name))) {
        return Err("it has no channels R, G and B; name a picture with colours".into());
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
