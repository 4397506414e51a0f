//! TGA (Truevision Targa): colours, greys and colour maps, plain or in run lengths.

use super::broken::{cut_short, damaged, unread};
use super::limits::{self, MAX_TEXTURE_BYTES};
use super::{Header, Picture, to_byte};
use crate::model::TexelLayout;

/// Texels of the longest run, which takes a byte and a texel.
const LONGEST_RUN: u64 = 128;

/// What the head says, and the texels.
struct Opened<'a> {
    header: Header,
    coding: Coding,
    /// Of mapped pictures.
    map: Option<ColourMap<'a>>,
    packets: Packets<'a>,
    from_top: bool,
    from_right: bool,
}

/// How a colour is stored: in a texel, or in the colour map.
#[derive(Clone, Copy)]
enum Coding {
    /// Grey, or grey and alpha.
    Grey,
    /// Five bits each for red, green and blue, blue lowest. The bit that is left is no alpha: many programs leave it 0.
    FiveBits,
    /// Blue, green, red, and perhaps alpha.
    Bytes,
}

/// The colours that indices stand for.
struct ColourMap<'a> {
    /// The index of the first entry.
    origin: usize,
    entries: std::slice::ChunksExact<'a, u8>,
}

pub(super) fn header(bytes: &[u8]) -> Result<Header, String> {
    Ok(open(bytes)?.header)
}

fn open(bytes: &[u8]) -> Result<Opened<'_>, String> {
    let (head, rest) = bytes.split_first_chunk::<18>().ok_or_else(|| cut_short("TGA"))?;
    let half = |at: usize| u16::from_le_bytes([head[at], head[at + 1]]);
    let (id_length, has_map, map_length, entry_bits) = (head[0], head[1] == 1, half(5), head[7]);
    let (depth, alpha_bits, flags) = (head[16], head[17] & 15, head[17]);
    let (is_mapped, is_grey, has_runs) = match head[2] {
        1 => (true, false, false),
        2 => (false, false, false),
        3 => (false, true, false),
        9 => (true, false, true),
        10 => (false, false, true),
        11 => (false, true, true),
        _ => return Err(unread("TGA")),
    };
    if is_mapped && !has_map {
        return Err(damaged("TGA"));
    }
    if is_mapped && !matches!(depth, 8 | 16) {
        return Err(unread("TGA"));
    }
    let colour_bits = if is_mapped { entry_bits } else { depth };
    let (coding, channels) = match (is_grey, colour_bits, alpha_bits) {
        (true, 8, 0 | 8) => (Coding::Grey, 1),
        (true, 16, 8) => (Coding::Grey, 2),
        (false, 15, 0) | (false, 16, 0 | 1) => (Coding::FiveBits, 3),
        (false, 24, 0) => (Coding::Bytes, 3),
        (false, 32, 0 | 8) => (Coding::Bytes, 4),
        _ => return Err(unread("TGA")),
    };
    let (width, height) = (u64::from(half(12)), u64::from(half(14)));
    let header = limits::size(width, height, TexelLayout::Bytes(channels), MAX_TEXTURE_BYTES)?;
    let texel_bytes = usize::from(depth.div_ceil(8));
    match has_runs {
        true => limits::holds(width * height, LONGEST_RUN, bytes.len())?,
        false => limits::holds(width * height * texel_bytes as u64, 1, bytes.len())?,
    }
    let entry_bytes = usize::from(entry_bits.div_ceil(8));
    let map_bytes = if has_map { usize::from(map_length) * entry_bytes } else { 0 };
    let map_and_texels = rest.get(usize::from(id_length)..).ok_or_else(|| cut_short("TGA"))?;
    let (map, texels) = map_and_texels.split_at_checked(map_bytes).ok_or_else(|| cut_short("TGA"))?;
    Ok(Opened {
        header,
        coding,
        map: is_mapped
            .then(|| ColourMap { origin: usize::from(half(3)), entries: map.chunks_exact(entry_bytes) }),
        packets: Packets { rest: texels, texel_bytes, has_runs, left: 0, repeated: None },
        from_top: flags & 32 != 0,
        from_right: flags & 16 != 0,
    })
}

pub(super) fn decode(bytes: &[u8]) -> Result<Picture, String> {
    let Opened { header, coding, map, mut packets, from_top, from_right } = open(bytes)?;
    let (columns, rows) = (header.width as usize, header.height as usize);
    let channels = header.layout.channels() as usize;
    let mut row = vec![0; columns * packets.texel_bytes];
    Picture::of_bytes(&header, |bytes| {
        for y in 0..rows {
            packets.read_row(&mut row)?;
            let y = if from_top { y } else { rows - 1 - y };
            let texels = row.chunks_exact(packets.texel_bytes);
            for (x, texel) in texels.enumerate() {
                let x = if from_right { columns - 1 - x } else { x };
                let stored = match &map {
                    Some(map) => map.entry(texel).ok_or_else(|| damaged("TGA"))?,
                    None => texel,
                };
                coding.write(stored, &mut bytes[(y * columns + x) * channels..][..channels]);
            }
        }
        Ok(())
    })
}

impl Coding {
    /// Writes a stored colour as grey or R, G, B, with alpha where the picture has it.
    fn write(self, stored: &[u8], out: &mut [u8]) {
        match (self, stored) {
            (Coding::FiveBits, &[low, high]) => {
                let bits = u32::from(u16::from_le_bytes([low, high]));
                out.copy_from_slice(&[10, 5, 0].map(|shift| to_byte(bits >> shift & 31, 31)));
            }
            _ => {
                out.copy_from_slice(stored);
                if let Coding::Bytes = self {
                    out.swap(0, 2);
                }
            }
        }
    }
}

impl<'a> ColourMap<'a> {
    /// The entry of an index of 8 or 16 bits.
    fn entry(&self, index: &[u8]) -> Option<&'a [u8]> {
        let index = index.iter().rev().fold(0, |index, &byte| index << 8 | usize::from(byte));
        self.entries.clone().nth(index.checked_sub(self.origin)?)
    }
}

/// Texels in the order of the file. Runs may go on in the next row.
struct Packets<'a> {
    rest: &'a [u8],
    texel_bytes: usize,
    has_runs: bool,
    /// Texels of the packet that are still to come.
    left: usize,
    /// The texel that the packet repeats; otherwise its texels follow.
    repeated: Option<&'a [u8]>,
}

impl<'a> Packets<'a> {
    fn take(&mut self, bytes: usize) -> Result<&'a [u8], String> {
        let (taken, rest) = self.rest.split_at_checked(bytes).ok_or_else(|| cut_short("TGA"))?;
        self.rest = rest;
        Ok(taken)
    }

    fn read_row(&mut self, mut row: &mut [u8]) -> Result<(), String> {
        if !self.has_runs {
            row.copy_from_slice(self.take(row.len())?);
            return Ok(());
        }
        while !row.is_empty() {
            if self.left == 0 {
                let head = self.take(1)?[0];
                self.left = usize::from(head & 127) + 1;
                self.repeated = if head < 128 { None } else { Some(self.take(self.texel_bytes)?) };
            }
            let texels = self.left.min(row.len() / self.texel_bytes);
            let (now, later) = row.split_at_mut(texels * self.texel_bytes);
            match self.repeated {
                Some(texel) => {
                    now.chunks_exact_mut(self.texel_bytes).for_each(|out| out.copy_from_slice(texel));
                }
                None => now.copy_from_slice(self.take(now.len())?),
            }
            self.left -= texels;
            row = later;
        }
        Ok(())
    }
}
