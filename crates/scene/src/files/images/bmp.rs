//! BMP (Windows and OS/2 bitmaps): palettes, run lengths, bytes and bit fields.

use super::broken::{cut_short, damaged, unread};
use super::limits::{self, MAX_TEXTURE_BYTES};
use super::{Header, Picture, to_byte};
use crate::model::TexelLayout;

mod runs;

/// The file's own head, before that of the bitmap.
const FILE_HEAD: usize = 14;

/// The oldest head of a bitmap, of OS/2: sides of 16 bits, palettes of three bytes a colour.
const CORE_HEAD: u32 = 12;

/// From this length of the head on, it has a mask for alpha.
const ALPHA_HEAD: u32 = 56;

/// Two bytes of run lengths stand for at most 255 texels.
const RUN_TEXELS_A_BYTE: u64 = 128;

/// What the head says, and the texels.
struct Opened<'a> {
    header: Header,
    from_top: bool,
    coding: Coding,
    /// From the first texel to the end of the file.
    texels: &'a [u8],
}

/// How texels are stored.
enum Coding {
    /// Numbers of palette colours, `bits` each, the first in a byte's highest bits.
    Indices { bits: u32, palette: Palette },
    /// Runs of such numbers, of 4 or 8 bits.
    Runs { bits: u32, palette: Palette },
    /// Words of `bytes` bytes, the lowest first, of which each channel has some bits.
    Fields { bytes: usize, channels: Vec<Field> },
}

/// R, G and B; black where the file has fewer.
type Palette = [[u8; 3]; 256];

/// The bits of a channel.
#[derive(Clone, Copy)]
struct Field {
    shift: u32,
    /// The largest value, at most 255.
    most: u32,
}

impl Field {
    /// Of a mask whose bits are side by side; the highest 8 count.
    fn of_mask(mask: u32) -> Result<Field, String> {
        let (shift, length) = (mask.trailing_zeros(), mask.count_ones());
        if mask == 0 || (mask >> shift).trailing_ones() != length {
            return Err(damaged("BMP"));
        }
        let used = length.min(8);
        Ok(Field { shift: shift + length - used, most: (1 << used) - 1 })
    }

    fn read(self, word: u32) -> u8 {
        to_byte(word >> self.shift & self.most, self.most)
    }
}

pub(super) fn header(bytes: &[u8]) -> Result<Header, String> {
    Ok(open(bytes)?.header)
}

/// Little-endian words of a file; where they are missing, it is cut short.
#[derive(Clone, Copy)]
struct Words<'a>(&'a [u8]);

impl Words<'_> {
    fn u32(self, at: usize) -> Result<u32, String> {
        let word = self.0.get(at..).and_then(|rest| rest.first_chunk());
        word.map(|word| u32::from_le_bytes(*word)).ok_or_else(|| cut_short("BMP"))
    }

    fn u16(self, at: usize) -> Result<u32, String> {
        let half = self.0.get(at..).and_then(|rest| rest.first_chunk());
        half.map(|half| u16::from_le_bytes(*half).into()).ok_or_else(|| cut_short("BMP"))
    }
}

fn open(bytes: &[u8]) -> Result<Opened<'_>, String> {
    let words = Words(bytes);
    let head_length = words.u32(14)?;
    let is_core = head_length == CORE_HEAD;
    match head_length {
        CORE_HEAD | 40 | 52 | ALPHA_HEAD | 108 | 124 => {}
        0..CORE_HEAD => return Err(damaged("BMP")),
        _ => return Err(unread("BMP")),
    }
    let (width, height, planes, bits, compression) = match is_core {
        true => (words.u16(18)?, words.u16(20)? as i32, words.u16(22)?, words.u16(24)?, 0),
        false => (words.u32(18)?, words.u32(22)? as i32, words.u16(26)?, words.u16(28)?, words.u32(30)?),
    };
    let colours = if is_core { 0 } else { words.u32(46)? };
    let alpha_mask = if compression == 3 && head_length >= ALPHA_HEAD { words.u32(66)? } else { 0 };
    let layout = TexelLayout::Bytes(if alpha_mask == 0 { 3 } else { 4 });
    let header = limits::size(width.into(), height.unsigned_abs().into(), layout, MAX_TEXTURE_BYTES)?;
    match compression {
        1 | 2 => limits::holds(header.texels() as u64, RUN_TEXELS_A_BYTE, bytes.len())?,
        _ => limits::holds(row_bytes(width, bits) as u64 * u64::from(header.height), 1, bytes.len())?,
    }
    let from_top = height < 0;
    if planes != 1 || (from_top && matches!(compression, 1 | 2)) {
        return Err(damaged("BMP"));
    }
    let palette =
        || palette(words, FILE_HEAD + head_length as usize, if is_core { 3 } else { 4 }, bits, colours);
    let fields = |bytes: usize, masks: &[u32]| {
        let channels = masks.iter().map(|mask| Field::of_mask(*mask)).collect::<Result<_, _>>()?;
        Ok::<_, String>(Coding::Fields { bytes, channels })
    };
    let coding = match (compression, bits) {
        (0, 1 | 4 | 8) => Coding::Indices { bits, palette: palette()? },
        (0, 2) if !is_core => Coding::Indices { bits, palette: palette()? },
        (0, 16) if !is_core => fields(2, &[0x7c00, 0x03e0, 0x001f])?,
        (0, 24) => fields(3, &BYTE_MASKS)?,
        (0, 32) if !is_core => fields(4, &BYTE_MASKS)?,
        (1, 8) | (2, 4) => Coding::Runs { bits, palette: palette()? },
        (3, 16 | 32) => {
            let masks = [words.u32(54)?, words.u32(58)?, words.u32(62)?, alpha_mask];
            if bits == 16 && masks.iter().any(|mask| mask >> 16 != 0) {
                return Err(damaged("BMP"));
            }
            fields(bits as usize / 8, &masks[..layout.channels() as usize])?
        }
        // JPEG, PNG and CMYK.
        (4 | 5 | 11..=13, _) => return Err(unread("BMP")),
        _ => return Err(damaged("BMP")),
    };
    let texels = bytes.get(words.u32(10)? as usize..).ok_or_else(|| cut_short("BMP"))?;
    Ok(Opened { header, from_top, coding, texels })
}

/// Red, green and blue of 24 and 32 bits; what is left of 32 is no alpha.
const BYTE_MASKS: [u32; 3] = [0xff_0000, 0xff00, 0xff];

/// Of a row, which is whole words of 32 bits.
fn row_bytes(width: u32, bits: u32) -> usize {
    (u64::from(width) * u64::from(bits)).div_ceil(32) as usize * 4
}

/// The palette after the head: blue, green and red of each colour, and a byte that nothing uses but in the oldest files.
fn palette(words: Words, at: usize, colour_bytes: usize, bits: u32, colours: u32) -> Result<Palette, String> {
    let colours = match colours {
        0 => 1 << bits,
        _ if colours <= 1 << bits => colours as usize,
        _ => return Err(damaged("BMP")),
    };
    let stored = words.0.get(at..).and_then(|rest| rest.get(..colours * colour_bytes));
    let mut palette = [[0; 3]; 256];
    let stored = stored.ok_or_else(|| cut_short("BMP"))?.chunks_exact(colour_bytes);
    for (colour, stored) in palette.iter_mut().zip(stored) {
        *colour = [stored[2], stored[1], stored[0]];
    }
    Ok(palette)
}

pub(super) fn decode(bytes: &[u8]) -> Result<Picture, String> {
    let Opened { header, from_top, coding, texels } = open(bytes)?;
    let out_row_bytes = header.width as usize * header.layout.channels() as usize;
    Picture::of_bytes(&header, |bytes| {
        let mut rows: Vec<&mut [u8]> = bytes.chunks_exact_mut(out_row_bytes).collect();
        if !from_top {
            rows.reverse();
        }
        let bits = match &coding {
            Coding::Runs { bits, palette } => return runs::decode(texels, *bits, palette, &mut rows),
            Coding::Indices { bits, .. } => *bits,
            Coding::Fields { bytes, .. } => 8 * *bytes as u32,
        };
        let stored = texels.chunks_exact(row_bytes(header.width, bits));
        if stored.len() < rows.len() {
            return Err(cut_short("BMP"));
        }
        for (row, stored) in rows.into_iter().zip(stored) {
            coding.write_row(stored, row);
        }
        Ok(())
    })
}

impl Coding {
    fn write_row(&self, stored: &[u8], row: &mut [u8]) {
        match self {
            Coding::Indices { bits, palette } | Coding::Runs { bits, palette } => {
                for (x, out) in row.as_chunks_mut::<3>().0.iter_mut().enumerate() {
                    *out = palette[usize::from(index(stored, *bits, x))];
                }
            }
            Coding::Fields { bytes, channels } => {
                for (word, out) in stored.chunks_exact(*bytes).zip(row.chunks_exact_mut(channels.len())) {
                    let word = word.iter().rev().fold(0, |word, &byte| word << 8 | u32::from(byte));
                    for (channel, out) in channels.iter().zip(out) {
                        *out = channel.read(word);
                    }
                }
            }
        }
    }
}

/// The number of a palette colour: the `x`th of some of at most 8 bits each, the first in a byte's highest bits.
fn index(stored: &[u8], bits: u32, x: usize) -> u8 {
    let each_byte = 8 / bits as usize;
    let shift = 8 - bits as usize * (1 + x % each_byte);
    stored[x / each_byte] >> shift & ((1u32 << bits) - 1) as u8
}
