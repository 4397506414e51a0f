//! OpenEXR: the first layer with colours or grey, of 16-bit, 32-bit or whole numbers.
//!
//! 16-bit floats become 32-bit ones exactly, whatever instruction does it. Lossy DWAA and DWAB are refused: the
//! decoder at hand takes another cosine transform on each kind of CPU, and their results differ in the last bits.

use super::Header as PictureHeader;
use super::float::usable;
use super::limits::{self, MAX_TEXTURE_BYTES};
use super::{Picture, broken_picture};
use crate::model::TexelLayout;
use exr::meta::MetaData;
use exr::meta::header::Header;
use exr::prelude::*;
use std::io::Cursor;

/// Deflate packs 1032 bytes into one, and PXR24 packs 4 bytes into 3 before.
const BYTES_A_BYTE: u64 = 2048;

/// The names of the channels that are read.
enum Channels {
    Colors([Text; 3], Text),
    Grey(Text, Text),
}

pub(super) fn header(bytes: &[u8]) -> std::result::Result<PictureHeader, String> {
    Ok(open(bytes)?.0)
}

fn open(bytes: &[u8]) -> std::result::Result<(PictureHeader, Channels), String> {
    let meta =
        MetaData::read_from_buffered(Cursor::new(bytes), false).map_err(|e| broken_picture("EXR", e))?;
    let (header, channels) = layer(&meta.headers).ok_or_else(|| no_colors(&meta.headers))?;
    Ok((check(header, layout(header, &channels), bytes.len())?, channels))
}

pub(super) fn decode(bytes: &[u8]) -> std::result::Result<Picture, String> {
    let (header, channels) = open(bytes)?;
    let say = |e: Error| broken_picture("EXR", e);
    let file = || Cursor::new(bytes);
    let (columns, layout) = (header.width as usize, header.layout);
    let words = || vec![0; (header.bytes / 4) as usize];
    let read = read().no_deep_data().largest_resolution_level().specific_channels();
    let texels = match channels {
        Channels::Colors([r, g, b], alpha) => {
            let read = read.required(r).required(g).required(b).optional(alpha, 1.0f32).collect_pixels(
                move |_, _| words(),
                move |words: &mut Vec<u32>, Vec2(x, y), (r, g, b, a): (f32, f32, f32, f32)| {
                    store(words, layout, y * columns + x, [r, g, b], a);
                },
            );
            read.first_valid_layer()
                .all_attributes()
                .from_buffered(file())
                .map(|i| i.layer_data.channel_data.pixels)
        }
        Channels::Grey(grey, alpha) => {
            let read = read.required(grey).optional(alpha, 1.0f32).collect_pixels(
                move |_, _| words(),
                move |words: &mut Vec<u32>, Vec2(x, y), (grey, a): (f32, f32)| {
                    store(words, layout, y * columns + x, [grey; 3], a);
                },
            );
            read.first_valid_layer()
                .all_attributes()
                .from_buffered(file())
                .map(|i| i.layer_data.channel_data.pixels)
        }
    };
    Ok(Picture::new(&header, texels.map_err(say)?))
}

/// The first layer with R, G and B, else with channels that end in them (`diffuse.R`), else with Y.
fn layer(headers: &[Header]) -> Option<(&Header, Channels)> {
    let has = |header: &Header, name: &str| header.channels.list.iter().any(|c| c.name.eq(name));
    let colors = |header: &Header, prefix: &str| {
        let [r, g, b, a] = ["R", "G", "B", "A"].map(|name| format!("{prefix}{name}"));
        let there = [&r, &g, &b].iter().all(|name| has(header, name));
        let text = |name: &str| Text::new_or_none(name);
        there.then(|| Some(Channels::Colors([text(&r)?, text(&g)?, text(&b)?], text(&a)?))).flatten()
    };
    let prefixed = |header: &Header| {
        let names = header.channels.list.iter().map(|c| c.name.to_string());
        let prefixes: Vec<String> =
            names.filter_map(|n| n.strip_suffix(".R").map(|p| format!("{p}."))).collect();
        prefixes.iter().find_map(|prefix| colors(header, prefix))
    };
    let grey = |header: &Header| has(header, "Y").then(|| Channels::Grey(Text::from("Y"), Text::from("A")));
    let first = |find: &dyn Fn(&Header) -> Option<Channels>| headers.iter().find_map(|h| Some((h, find(h)?)));
    first(&|h| colors(h, "")).or_else(|| first(&prefixed)).or_else(|| first(&grey))
}

/// What its texels are: halves where all channels are.
fn layout(header: &Header, channels: &Channels) -> TexelLayout {
    let kind = |name: &Text| header.channels.list.iter().find(|c| c.name == *name).map(|c| c.sample_type);
    let (colors, alpha) = match channels {
        Channels::Colors(colors, alpha) => (&colors[..], alpha),
        Channels::Grey(grey, alpha) => (std::slice::from_ref(grey), alpha),
    };
    let kinds: Vec<SampleType> = colors.iter().chain([alpha]).filter_map(kind).collect();
    match kinds.iter().all(|kind| *kind == SampleType::F16) {
        true => TexelLayout::Halves(kinds.len() as u32),
        false => TexelLayout::Floats(kinds.len() as u32),
    }
}

fn no_colors(headers: &[Header]) -> String {
    let names = headers.iter().flat_map(|h| &h.channels.list).map(|c| c.name.to_string());
    let names: Vec<String> = names.take(16).collect();
    let there = if names.is_empty() { "no channels at all".into() } else { names.join(", ") };
    format!("it has no channels R, G and B, nor Y, but {there}; save it with colours")
}

/// The size of a layer that can be read and whose bytes can be there.
fn check(
    header: &Header,
    layout: TexelLayout,
    file_bytes: usize,
) -> std::result::Result<PictureHeader, String> {
    let convert = match header.compression {
        Compression::DWAA(_) => Some("DWAA"),
        Compression::DWAB(_) => Some("DWAB"),
        Compression::HTJ2K32 | Compression::HTJ2K256 => Some("HTJ2K"),
        _ => None,
    };
    if let Some(name) = convert {
        return Err(format!("its compression {name} is not read; save it with ZIP or PIZ"));
    }
    if header.deep {
        return Err("deep pictures are not read; flatten it".into());
    }
    if header.channels.list.iter().any(|c| c.sampling != Vec2(1, 1)) {
        return Err("subsampled channels are not read; save it as plain RGB".into());
    }
    let Vec2(columns, rows) = header.layer_size;
    let size = limits::size(columns as u64, rows as u64, layout, MAX_TEXTURE_BYTES)?;
    let raw = columns as u64 * rows as u64 * header.channels.bytes_per_pixel as u64;
    limits::holds(raw, BYTES_A_BYTE, file_bytes)?;
    Ok(size)
}

/// Puts a texel where it belongs. In EXR files colours are multiplied by alpha. Halves stay so, and reading them divides;
/// floats are divided here.
fn store(words: &mut [u32], layout: TexelLayout, number: usize, color: [f32; 3], alpha: f32) {
    let alpha = if alpha < 1.0 { usable(alpha) } else { 1.0 };
    let channels = layout.channels() as usize;
    let colors = if channels < 3 { 1 } else { 3 };
    let first = number * channels;
    if let TexelLayout::Halves(_) = layout {
        // They were halves, so this is exact.
        let bits = |x: f32| u32::from(f16::from_f32(if x > 0.0 { x } else { 0.0 }).to_bits());
        let mut put = |k: usize, x: f32| words[(first + k) / 2] |= bits(x) << ((first + k) % 2 * 16);
        color.iter().take(colors).enumerate().for_each(|(k, &x)| put(k, x));
        if channels > colors {
            put(colors, alpha);
        }
        return;
    }
    let plain = |x: f32| usable(if alpha > 0.0 { x / alpha } else { x });
    let texel = &mut words[first..][..channels];
    texel.iter_mut().zip(color).take(colors).for_each(|(word, x)| *word = plain(x).to_bits());
    if channels > colors {
        texel[colors] = alpha.to_bits();
    }
}
