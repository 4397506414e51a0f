//! BMP and TGA files of all kinds, whole and damaged, beside the `image` crate.

use super::*;
use ::image::codecs::{bmp::BmpDecoder, tga::TgaDecoder};
use ::image::{ImageDecoder, ImageResult};
use std::io::Cursor;

/// Random numbers, the same in each run (Steele, Lea and Flood 2014).
struct Random(u64);

impl Random {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ self.0 >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ z >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ z >> 31
    }

    fn below(&mut self, end: usize) -> usize {
        (self.next() % end as u64) as usize
    }

    fn bytes(&mut self, count: usize) -> Vec<u8> {
        (0..count).map(|_| self.next() as u8).collect()
    }
}

/// Width, height and channels, and the bytes of all channels.
type Seen = (u32, u32, u32, Vec<u8>);

fn ours(bytes: &[u8], name: &str) -> Result<Seen, String> {
    let Picture { width, height, texels } = decode(bytes, name)?;
    let channels = texels.layout().channels();
    let bytes = texels.channel_bytes().take(texels.len() * channels as usize).collect();
    Ok((width, height, channels, bytes))
}

fn theirs(bytes: &[u8], name: &str) -> Option<Seen> {
    fn read(decoder: ImageResult<impl ImageDecoder>) -> Option<Seen> {
        let decoder = decoder.ok()?;
        let (width, height) = decoder.dimensions();
        // Damaged heads claim anything.
        let bytes = usize::try_from(decoder.total_bytes()).ok().filter(|bytes| *bytes < 1 << 24)?;
        let channels = decoder.color_type().channel_count().into();
        let mut samples = vec![0; bytes];
        decoder.read_image(&mut samples).ok()?;
        Some((width, height, channels, samples))
    }
    let file = Cursor::new(bytes);
    if name.ends_with("tga") { read(TgaDecoder::new(file)) } else { read(BmpDecoder::new(file)) }
}

/// Whole files must be read alike. Damaged ones are read alike or not at all by one of the two.
fn compare(random: &mut Random, file: &[u8], name: &str) {
    let read = ours(file, name).unwrap_or_else(|e| panic!("{name}: {e}"));
    assert_eq!(Some(read), theirs(file, name), "{name}");
    let head = header(file, name).unwrap();
    assert_eq!(head.texels(), head.width as usize * head.height as usize);
    for _ in 0..8 {
        let mut damaged = file[..file.len() - random.below(2) * random.below(file.len())].to_vec();
        for _ in 0..random.below(4) {
            // The head more often than the texels.
            let most = if random.below(2) == 0 { damaged.len().min(70) } else { damaged.len() };
            if most > 0 {
                let at = random.below(most);
                damaged[at] = random.next() as u8 >> random.below(8);
            }
        }
        if let (Ok(ours), Some(theirs)) = (ours(&damaged, name), theirs(&damaged, name)) {
            assert_eq!(ours, theirs, "{name}, damaged: {damaged:?}");
        }
    }
}

/// What the head of a BMP says.
#[derive(Clone, Copy, Debug)]
struct Bmp {
    head: u32,
    width: u32,
    height: i32,
    bits: u16,
    compression: u32,
    /// Red, green, blue, alpha.
    masks: [u32; 4],
    /// Of the palette; 0 stands for all.
    colours: u32,
}

impl Bmp {
    fn file(self, random: &mut Random, texels: &[u8]) -> Vec<u8> {
        let mut rest = self.head.to_le_bytes().to_vec();
        if self.head == 12 {
            let halves = [self.width as u16, self.height as u16, 1, self.bits];
            rest.extend(halves.iter().flat_map(|half| half.to_le_bytes()));
        } else {
            rest.extend(self.width.to_le_bytes());
            rest.extend(self.height.to_le_bytes());
            rest.extend([1, 0]);
            rest.extend(self.bits.to_le_bytes());
            let words = [self.compression, 0, 7, 7, self.colours, 0];
            rest.extend(words.iter().flat_map(|word| word.to_le_bytes()));
            let masks: Vec<u8> = self.masks.iter().flat_map(|mask| mask.to_le_bytes()).collect();
            match (self.head, self.compression) {
                (40, 3) => rest.extend(&masks[..12]),
                (40, _) => {}
                (52, _) => rest.extend(&masks[..12]),
                _ => rest.extend(&masks),
            }
            let masks_after = if self.compression == 3 && self.head == 40 { 12 } else { 0 };
            rest.resize(self.head as usize + masks_after, 0);
        }
        if self.bits <= 8 {
            let colours = if self.colours == 0 { 1 << self.bits } else { self.colours as usize };
            rest.extend(random.bytes(colours * if self.head == 12 { 3 } else { 4 }));
        }
        // Nobody has to begin with the texels at once.
        let gap = random.below(3);
        rest.extend(random.bytes(gap));
        let begin = 14 + rest.len() as u32;
        [b"BM\0\0\0\0\0\0\0\0", &begin.to_le_bytes()[..], &rest, texels].concat()
    }
}

#[test]
fn bmp_without_runs() {
    let random = &mut Random(1);
    let none = [0; 4];
    let five = [0x7c00, 0x3e0, 0x1f, 0];
    let mut kinds = vec![(12, 24, 0, none), (12, 1, 0, none), (12, 4, 0, none), (12, 8, 0, none)];
    for head in [40, 52, 56, 108, 124] {
        kinds.extend([1, 2, 4, 8, 16, 24, 32].map(|bits| (head, bits, 0, none)));
        for masks in
            [five, [0xf800, 0x7e0, 0x1f, 0], [0xf, 0xf0, 0xf00, 0xf000], [0x7c00, 0x3e0, 0x1f, 0x8000]]
        {
            kinds.push((head, 16, 3, masks));
        }
        for masks in [
            [0xff_0000, 0xff00, 0xff, 0],
            [0xff_0000, 0xff00, 0xff, 0xff00_0000],
            [0xff00_0000, 0xff_0000, 0xff00, 0],
            [0xff, 0xff00, 0xff_0000, 0xff00_0000],
            [0x3ff0_0000, 0xf_fc00, 0x3ff, 0xc000_0000],
            [1, 6, 0x38, 0x3fc0],
            [0xfe00_0000, 0x1f8_0000, 0x7c000, 0x3c00],
        ] {
            kinds.push((head, 32, 3, masks));
        }
    }
    for (head, bits, compression, masks) in kinds {
        for (width, height) in [(1, 1), (2, 3), (7, 2), (9, 5), (33, 4)] {
            for height in [height, -height] {
                if head == 12 && height < 0 {
                    continue;
                }
                let colours = if bits <= 8 && head != 12 { random.below(1 << bits) as u32 } else { 0 };
                let bmp = Bmp { head, width, height, bits, compression, masks, colours };
                let row_bytes = (width as usize * usize::from(bits)).div_ceil(32) * 4;
                let texels = random.bytes(row_bytes * height.unsigned_abs() as usize);
                let file = bmp.file(random, &texels);
                compare(random, &file, "x.bmp");
            }
        }
    }
}

/// Runs, literal stretches, moves and ends of rows that fit the picture.
fn runs(random: &mut Random, width: usize, height: usize, bits: usize) -> Vec<u8> {
    let (mut out, mut x, mut y) = (Vec::new(), 0, 0);
    while y < height {
        let left = width - x;
        match random.below(8) {
            0..3 if left > 0 => {
                let count = 1 + random.below(left.min(255));
                out.extend([count as u8, random.next() as u8]);
                x += count;
            }
            3..6 if left >= 3 => {
                let count = 3 + random.below(left.min(255) - 2);
                out.extend([0, count as u8]);
                out.extend(random.bytes((count * bits).div_ceil(16) * 2));
                x += count;
            }
            6 if y + 1 < height => {
                let moved = (random.below(left + 1).min(255), random.below((height - y).min(3)));
                out.extend([0, 2, moved.0 as u8, moved.1 as u8]);
                (x, y) = (x + moved.0, y + moved.1);
            }
            7 if random.below(9) == 0 => {
                out.extend([0, 1]);
                return out;
            }
            _ if left == 0 || random.below(4) == 0 => {
                out.extend([0, 0]);
                (x, y) = (0, y + 1);
            }
            _ => {}
        }
    }
    if random.below(2) == 0 {
        out.extend([0, 1]);
    }
    out
}

#[test]
fn bmp_with_runs() {
    let random = &mut Random(2);
    for round in 0..300 {
        let (bits, compression) = if round % 2 == 0 { (8, 1) } else { (4, 2) };
        let (width, height) = (1 + random.below(40), 1 + random.below(9));
        let texels = runs(random, width, height, bits);
        // Heads claim no more than two bytes of runs can hold.
        let padding = vec![0; (width * height).div_ceil(128)];
        let head = [40, 52, 56, 108, 124][random.below(5)];
        let colours = random.below(1 << bits) as u32;
        let (width, height) = (width as u32, height as i32);
        let bmp = Bmp { head, width, height, bits: bits as u16, compression, masks: [0; 4], colours };
        let file = bmp.file(random, &[texels, padding].concat());
        compare(random, &file, "x.bmp");
    }
}

/// A run of 8 bits may be longer than its row, as ImageMagick writes it; a run of 4 bits may not.
#[test]
fn bmp_with_a_run_that_is_too_long() {
    let random = &mut Random(3);
    let bmp = |bits, compression| Bmp {
        head: 40,
        width: 3,
        height: 1,
        bits,
        compression,
        masks: [0; 4],
        colours: 0,
    };
    let file = bmp(8, 1).file(random, &[200, 7, 0, 1]);
    let picture = words(&file);
    assert!(picture.iter().all(|texel| *texel == picture[0]));
    let file = bmp(4, 2).file(random, &[200, 7, 0, 1]);
    assert!(decode(&file, "x").unwrap_err().contains("damaged"));
}

fn words(file: &[u8]) -> Vec<[u8; 3]> {
    ours(file, "x").unwrap().3.as_chunks::<3>().0.to_vec()
}

/// Packets of texels, which may go on in the next row.
fn packets(
    random: &mut Random,
    texels: usize,
    texel_bytes: usize,
    mut texel: impl FnMut(&mut Random) -> Vec<u8>,
) -> Vec<u8> {
    let (mut out, mut done) = (Vec::new(), 0);
    while done < texels {
        let count = 1 + random.below((texels - done).min(128));
        let repeats = random.below(2) == 0;
        out.push((count - 1) as u8 | if repeats { 128 } else { 0 });
        for _ in 0..if repeats { 1 } else { count } {
            out.extend(texel(random));
        }
        done += count;
    }
    assert!(out.len() >= texel_bytes);
    out
}

#[test]
fn tga_of_all_kinds() {
    let random = &mut Random(4);
    // Type without runs, depth, bits of alpha, bits of an entry of the colour map.
    let mut kinds =
        vec![(2, 15, 0, 0), (2, 16, 0, 0), (2, 16, 1, 0), (2, 24, 0, 0), (2, 32, 0, 0), (2, 32, 8, 0)];
    kinds.extend([(3, 8, 0, 0), (3, 8, 8, 0), (3, 16, 8, 0), (2, 24, 0, 24), (3, 8, 0, 16)]);
    for depth in [8, 16] {
        kinds.extend(
            [(16, 0), (16, 1), (24, 0), (32, 0), (32, 8)].map(|(entry, alpha)| (1, depth, alpha, entry)),
        );
    }
    kinds.push((1, 8, 0, 15));
    for (kind, depth, alpha, entry) in kinds {
        for (width, height) in [(1, 1), (2, 3), (5, 4), (200, 2)] {
            for flags in [0, 16, 32, 48] {
                for has_runs in [false, true] {
                    let texel_bytes = usize::from(depth as u8).div_ceil(8);
                    let (origin, colours) = (random.below(5), 1 + random.below(60));
                    let mut texel = |random: &mut Random| match kind {
                        1 => ((origin + random.below(colours)) as u16).to_le_bytes()[..texel_bytes].to_vec(),
                        _ => random.bytes(texel_bytes),
                    };
                    let texels = match has_runs {
                        true => packets(random, width * height, texel_bytes, &mut texel),
                        false => (0..width * height).flat_map(|_| texel(random)).collect(),
                    };
                    let id = random.below(9);
                    let mut file = vec![id as u8, u8::from(entry > 0), kind + if has_runs { 8 } else { 0 }];
                    for half in [origin, if entry > 0 { colours } else { 0 }] {
                        file.extend((half as u16).to_le_bytes());
                    }
                    file.extend([entry, 0, 0, 0, 0]);
                    for half in [width, height] {
                        file.extend((half as u16).to_le_bytes());
                    }
                    file.extend([depth as u8, alpha | flags]);
                    file.extend(random.bytes(id));
                    if entry > 0 {
                        file.extend(random.bytes(colours * usize::from(entry).div_ceil(8)));
                    }
                    file.extend(texels);
                    // Room for the second check of runs: 128 texels a byte.
                    compare(random, &file, "x.tga");
                }
            }
        }
    }
}
