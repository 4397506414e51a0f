//! Pictures of every kind, whole, broken and larger than their files.

use super::*;
use crate::model::MAX_COORDINATE;
use crate::model::TexelLayout::{Bytes, Floats, Halves, Rgbe};
use ::exr::prelude as e;
use eosphor_core::texture::{TexelFormat, Texture, TextureFilter, TextureWrap, Textures};
use std::path::PathBuf;

const BASELINE: &[u8] = include_bytes!("../../../tests/data/pictures/baseline.jpg");
const PROGRESSIVE: &[u8] = include_bytes!("../../../tests/data/pictures/progressive.jpg");
const GREY: &[u8] = include_bytes!("../../../tests/data/pictures/grey.jpg");
const CMYK: &[u8] = include_bytes!("../../../tests/data/pictures/cmyk.jpg");
const INTERLACED: &[u8] = include_bytes!("../../../tests/data/pictures/interlaced.png");
const PLAIN_BMP: &[u8] = include_bytes!("../../../tests/data/pictures/plain.bmp");
const PALETTE_BMP: &[u8] = include_bytes!("../../../tests/data/pictures/palette.bmp");
const PLAIN_TGA: &[u8] = include_bytes!("../../../tests/data/pictures/plain.tga");
const RUNS_TGA: &[u8] = include_bytes!("../../../tests/data/pictures/runs.tga");

fn read(bytes: &[u8]) -> Picture {
    decode(bytes, "x").unwrap_or_else(|e| panic!("{e}"))
}

fn error(bytes: &[u8]) -> String {
    decode(bytes, "x").unwrap_err()
}

/// R, G, B and A as one word, R in the low byte.
fn rgba(r: u8, g: u8, b: u8, a: u8) -> u32 {
    u32::from_le_bytes([r, g, b, a])
}

/// What lookups see of the texels.
fn floats(picture: &Picture) -> Vec<[f32; 4]> {
    let Picture { width, height, texels } = picture;
    let format = match texels.layout() {
        TexelLayout::Bytes(_) => TexelFormat::Linear8,
        TexelLayout::Halves(_) => TexelFormat::Half,
        TexelLayout::Floats(_) => TexelFormat::Float,
        TexelLayout::Rgbe => TexelFormat::Rgbe,
    };
    let texture = Texture {
        first_word: 0,
        width: *width,
        height: *height,
        format,
        channels: texels.layout().channels(),
        filter: TextureFilter::Nearest,
        wrap_u: TextureWrap::Clamp,
        wrap_v: TextureWrap::Clamp,
        uv_set: 0,
        picture_from_mesh_uv: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
    };
    let textures = Textures { textures: &[texture], words: texels.words(), srgb_decode: &[0.0; 256] };
    let at = |i: u32, count: u32| (i as f32 + 0.5) / count as f32;
    let texel = |x: u32, y: u32| {
        let seen = textures.sample(0, &[[at(x, *width), 1.0 - at(y, *height)]; 2]);
        [seen.color.x, seen.color.y, seen.color.z, seen.alpha]
    };
    (0..*height).flat_map(|y| (0..*width).map(move |x| (x, y))).map(|(x, y)| texel(x, y)).collect()
}

/// The same of bytes.
fn words(picture: &Picture) -> Vec<u32> {
    assert!(matches!(picture.texels.layout(), TexelLayout::Bytes(_)));
    let byte = |x: f32| (x * 255.0).round() as u8;
    floats(picture).into_iter().map(|texel| u32::from_le_bytes(texel.map(byte))).collect()
}

/// What the files of `tests/data/pictures` show, 21 x 13 texels.
fn pattern() -> Vec<u32> {
    let texel = |x: u32, y: u32| rgba((x * 12) as u8, (y * 19) as u8, ((x + y) * 7) as u8, 255);
    (0..13).flat_map(|y| (0..21).map(move |x| texel(x, y))).collect()
}

/// The largest difference of a channel.
fn difference(a: &[u32], b: &[u32]) -> u8 {
    let channels = |a: &u32, b: &u32| {
        let (a, b) = (a.to_le_bytes(), b.to_le_bytes());
        a.into_iter().zip(b).map(|(a, b)| a.abs_diff(b)).max().unwrap()
    };
    a.iter().zip(b).map(|(a, b)| channels(a, b)).max().unwrap()
}

/// FNV-1a of R, G and B.
fn hash(picture: &Picture) -> u64 {
    let words = words(picture);
    let bytes = words.iter().flat_map(|texel| texel.to_le_bytes().into_iter().take(3));
    bytes.fold(0xcbf2_9ce4_8422_2325, |h, b| (h ^ u64::from(b)).wrapping_mul(0x0100_0000_01b3))
}

#[test]
fn portable_maps_of_all_kinds() {
    let picture = read(b"P6\n2 1\n255\n\x01\x02\x03\xff\x80\x00");
    assert_eq!((picture.width, picture.height), (2, 1));
    assert_eq!(words(&picture), [0xff03_0201, 0xff00_80ff]);
    assert_eq!(words(&read(b"P3 # a\n#b\n 1 1 # c\n15\n15 0 7")), [rgba(255, 0, 119, 255)]);
    assert_eq!(words(&read(b"P6 1 1 65535\n\xff\xff\x80\x00\x00\x80")), [rgba(255, 128, 0, 255)]);
    assert_eq!(words(&read(b"P2 2 1 100 50 999")), [rgba(128, 128, 128, 255), u32::MAX]);
    assert_eq!(words(&read(b"P5 1 1 255\n\x07")), [0xff07_0707]);
    assert_eq!(words(&read(b"P1 3 1 0 1\n0")), [u32::MAX, 0xff00_0000, u32::MAX]);
    assert_eq!(words(&read(b"P1 2 1 01")), [u32::MAX, 0xff00_0000]);
    assert_eq!(words(&read(b"P4 9 1\n\x80\x00")), [vec![0xff00_0000], vec![u32::MAX; 8]].concat());
    assert!(error(b"P6 2 1 255\n\x01\x02\x03\xff\x80").contains("too small for the size that it claims"));
    assert_eq!(error(b"P3 1 1 255 1 2      "), "the file is cut short; get it again");
    assert_eq!(error(b"P6 1 1 0\n..."), "0 is no largest value; it must be 1 to 65535");
    assert_eq!(error(b"P6 0 1 255\n"), "the picture is empty; save it anew");
}

#[test]
fn what_is_no_picture_is_an_error() {
    assert_eq!(
        error(b"hello"),
        "this is no picture of a kind that is read: PNG, JPEG, PPM, HDR, EXR, BMP, TGA and .data"
    );
    assert!(error(b"RIFF....WEBPVP8 ").starts_with("WebP pictures are not read; convert it to one of PNG"));
    assert!(decode(b"", "x.data").is_err() && decode(b"", "x.tga").is_err());
}

/// Small files that claim to be huge pictures, by each format's own header.
#[test]
fn what_a_file_cannot_hold_is_refused_before_it_is_allocated() {
    let png = |side: u32| {
        let mut bytes = INTERLACED.to_vec();
        bytes[16..20].copy_from_slice(&side.to_be_bytes());
        bytes[20..24].copy_from_slice(&side.to_be_bytes());
        let crc = crc32(&bytes[12..29]);
        bytes[29..33].copy_from_slice(&crc.to_be_bytes());
        bytes
    };
    let jpeg = |side: u16| {
        let mut bytes = BASELINE.to_vec();
        let frame = bytes.windows(2).position(|w| w == [0xff, 0xc0]).unwrap();
        bytes[frame + 5..frame + 7].copy_from_slice(&side.to_be_bytes());
        bytes[frame + 7..frame + 9].copy_from_slice(&side.to_be_bytes());
        bytes
    };
    let bmp = |side: u32| {
        let mut bytes = PLAIN_BMP.to_vec();
        bytes[18..22].copy_from_slice(&side.to_le_bytes());
        bytes[22..26].copy_from_slice(&side.to_le_bytes());
        bytes
    };
    let tga = |side: u16, bytes: &[u8]| {
        let mut bytes = bytes.to_vec();
        bytes[12..14].copy_from_slice(&side.to_le_bytes());
        bytes[14..16].copy_from_slice(&side.to_le_bytes());
        bytes
    };
    let hdr = |side: u32| format!("#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y {side} +X {side}\n").into_bytes();
    let data = |side: i32| [side.to_le_bytes(), side.to_le_bytes()].concat();
    for (bytes, name) in [
        (png(20_000), "x"),
        (jpeg(20_000), "x"),
        (bmp(20_000), "x"),
        (tga(20_000, PLAIN_TGA), "x.tga"),
        (tga(20_000, RUNS_TGA), "x.TGA"),
        (hdr(10_000), "x"),
        (b"P6 20000 20000 255\n".to_vec(), "x"),
        (b"P1 20000 20000\n".to_vec(), "x"),
    ] {
        let message = decode(&bytes, name).unwrap_err();
        assert_eq!(
            message,
            "the file is too small for the size that it claims; it is cut short or damaged; get it again",
            "{name}"
        );
    }
    let message = decode(&data(20_000), "a.data").unwrap_err();
    assert_eq!(message, "20000 x 20000 texels take 1600000000 bytes after the first 8; there are 0");
    for (bytes, name) in
        [(png(60_000), "x"), (jpeg(60_000), "x"), (hdr(30_000), "x"), (data(60_000), "x.data")]
    {
        let message = decode(&bytes, name).unwrap_err();
        assert!(message.ends_with("texels take more than 2 GiB; use a smaller picture"), "{message}");
    }
    for (bytes, name) in
        [(png(70_000), "x"), (hdr(70_000), "x"), (bmp(1 << 30), "x"), (data(70_000), "x.data")]
    {
        let message = decode(&bytes, name).unwrap_err();
        assert!(message.ends_with("sides must be at most 65535"), "{message}");
    }
    assert_eq!(decode(&data(-1), "x.data").unwrap_err(), "-1 is no width or height");
}

/// PNG's own.
fn crc32(bytes: &[u8]) -> u32 {
    !bytes.iter().fold(u32::MAX, |crc, &b| {
        (0..8).fold(crc ^ u32::from(b), |c, _| if c & 1 == 1 { 0xedb8_8320 ^ (c >> 1) } else { c >> 1 })
    })
}

#[test]
fn png_of_all_colours_and_depths() {
    use ::png::{BitDepth, ColorType};
    let encode = |color, depth, size: (u32, u32), palette: &[u8], trns: &[u8], data: &[u8]| {
        let mut bytes = Vec::new();
        let mut encoder = ::png::Encoder::new(&mut bytes, size.0, size.1);
        encoder.set_color(color);
        encoder.set_depth(depth);
        if !palette.is_empty() {
            encoder.set_palette(palette.to_vec());
        }
        if !trns.is_empty() {
            encoder.set_trns(trns.to_vec());
        }
        encoder.write_header().unwrap().write_image_data(data).unwrap();
        bytes
    };
    let grey = |g| rgba(g, g, g, 255);
    for (bytes, expected) in [
        (
            encode(ColorType::Grayscale, BitDepth::One, (3, 1), &[], &[], &[0b0100_0000]),
            vec![grey(0), grey(255), grey(0)],
        ),
        (encode(ColorType::Grayscale, BitDepth::Four, (2, 1), &[], &[], &[0x2f]), vec![grey(34), grey(255)]),
        (
            encode(ColorType::Grayscale, BitDepth::Eight, (2, 1), &[], &[0, 9], &[9, 8]),
            vec![rgba(9, 9, 9, 0), grey(8)],
        ),
        (
            encode(ColorType::GrayscaleAlpha, BitDepth::Eight, (1, 1), &[], &[], &[9, 8]),
            vec![rgba(9, 9, 9, 8)],
        ),
        (encode(ColorType::Rgba, BitDepth::Eight, (1, 1), &[], &[], &[1, 2, 3, 4]), vec![rgba(1, 2, 3, 4)]),
        // 16 bits are rounded, not cut: 0x0180 is 1.49 of 255 parts, 0x01ff is 1.99, 0x8000 is 127.5.
        (
            encode(
                ColorType::Rgb,
                BitDepth::Sixteen,
                (1, 1),
                &[],
                &[],
                &[0x01, 0x80, 0x01, 0xff, 0x80, 0x00],
            ),
            vec![rgba(1, 2, 128, 255)],
        ),
        (
            encode(
                ColorType::Indexed,
                BitDepth::Two,
                (3, 1),
                &[1, 2, 3, 4, 5, 6, 7, 8, 9],
                &[0, 128],
                &[0b0001_1000],
            ),
            vec![rgba(1, 2, 3, 0), rgba(4, 5, 6, 128), rgba(7, 8, 9, 255)],
        ),
    ] {
        assert_eq!(words(&read(&bytes)), expected);
        for length in 0..bytes.len() - 12 {
            assert!(decode(&bytes[..length], "x").is_err(), "cut to {length} of {}", bytes.len());
        }
    }
    for value in 0..=65_535u32 {
        assert_eq!(u32::from(to_byte(value, 65_535)), (value * 255 + 32_767) / 65_535);
    }
    assert_eq!(words(&read(INTERLACED)), pattern());
}

/// The same texels on every machine: the hashes were taken once, with and without SIMD.
#[test]
fn jpeg_decodes_to_known_bits() {
    for (name, bytes, expected, near) in [
        ("baseline", BASELINE, 0xfea7_49e3_c15a_11f8, 12),
        ("progressive", PROGRESSIVE, 0x7576_2870_4538_ad6e, 80),
        ("grey", GREY, 0xd023_dc09_fbb9_0bcb, 255),
        ("CMYK", CMYK, 0xe414_6ff7_3c47_9511, 12),
    ] {
        let picture = read(bytes);
        assert_eq!((picture.width, picture.height, words(&picture).len()), (21, 13, 273), "{name}");
        assert_eq!(hash(&picture), expected, "{name}: {:016x}", hash(&picture));
        let difference = difference(&words(&picture), &pattern());
        assert!(difference <= near, "{name}: {difference}");
    }
}

#[test]
fn a_jpeg_that_is_cut_short_is_an_error() {
    for bytes in [BASELINE, PROGRESSIVE, GREY, CMYK] {
        for length in 0..bytes.len() {
            assert!(decode(&bytes[..length], "x").is_err(), "cut to {length} of {}", bytes.len());
        }
    }
}

#[test]
fn bmp_and_tga() {
    assert_eq!(words(&read(PLAIN_BMP)), pattern());
    assert!(difference(&words(&read(PALETTE_BMP)), &pattern()) < 80);
    for bytes in [PLAIN_TGA, RUNS_TGA] {
        assert_eq!(words(&decode(bytes, "a/b.TGA").unwrap()), pattern());
        for length in 0..bytes.len() - 26 {
            assert!(decode(&bytes[..length], "x.tga").is_err(), "cut to {length} of {}", bytes.len());
        }
    }
    for length in 0..PLAIN_BMP.len() {
        assert!(decode(&PLAIN_BMP[..length], "x").is_err(), "cut to {length}");
    }
}

#[test]
fn data_pictures() {
    let bytes = [&[2, 0, 0, 0, 1, 0, 0, 0][..], &[1, 2, 3, 4, 5, 6, 7, 8]].concat();
    let picture = decode(&bytes, "dir.x/a.data").unwrap();
    assert_eq!((picture.width, picture.height), (2, 1));
    assert_eq!(words(&picture), [rgba(1, 2, 3, 4), rgba(5, 6, 7, 8)]);
    assert!(decode(&bytes[..15], "a.data").is_err() && decode(&bytes, "a").is_err());
}

const HDR: &[u8] = b"#?RADIANCE\n# made by hand\nEXPOSURE=2\nFORMAT=32-bit_rle_rgbe\n\n";

fn hdr(size: &str, body: &[u8]) -> Vec<u8> {
    [HDR, size.as_bytes(), b"\n", body].concat()
}

#[test]
fn radiance_with_both_codes_and_none() {
    // 128 * 2^(129 - 136) = 1, 64 * ... = 0.5.
    let (one, half, black) = ([1.0, 1.0, 1.0, 1.0], [0.5, 1.0, 0.25, 1.0], [0.0, 0.0, 0.0, 1.0]);
    let flat = [128, 128, 128, 129, 64, 128, 32, 129, 9, 9, 9, 0];
    assert_eq!(floats(&read(&hdr("-Y 1 +X 3", &flat))), [one, half, black]);
    assert_eq!(floats(&read(&hdr("-Y 1 -X 3", &flat))), [black, half, one]);
    assert_eq!(floats(&read(&hdr("-Y 3 +X 1", &flat))), [one, half, black]);
    assert_eq!(floats(&read(&hdr("+Y 3 +X 1", &flat))), [black, half, one]);

    // The older code: once, then 2 more, then 256 more.
    let runs = [64, 128, 32, 129, 1, 1, 1, 2, 1, 1, 1, 1, 128, 128, 128, 129];
    let picture = read(&hdr("-Y 1 +X 260", &runs));
    assert_eq!(floats(&picture)[..259], [half; 259]);
    assert_eq!(floats(&picture)[259], one);

    // The newer one: a run of red, literal green, runs of blue and exponent.
    let green = [128, 0, 128, 0, 128, 0, 128, 0];
    let new = [&[2, 2, 0, 8, 128 + 8, 128, 8][..], &green, &[128 + 4, 0, 128 + 4, 32, 128 + 8, 129]].concat();
    let picture = read(&hdr("-Y 1 +X 8", &new));
    assert_eq!(floats(&picture)[0], [1.0, 1.0, 0.0, 1.0]);
    assert_eq!(floats(&picture)[7], [1.0, 0.0, 0.25, 1.0]);

    for (size, body, expected) in [
        ("-Y 1 +X 8", &new[..new.len() - 1], "the file is cut short; get it again"),
        ("-Y 1 +X 3", &flat[..11], "the file is cut short; get it again"),
        ("-Y 1 +X 9", &new[..], "a row is not as long as the header says; the file is damaged; get it again"),
        (
            "-Y 1 +X 8",
            &[2, 2, 0, 8, 128 + 9, 1],
            "a run does not fit its row; the file is damaged; get it again",
        ),
        ("-Y 1 +X 8", &[2, 2, 0, 8, 0, 1], "a run does not fit its row; the file is damaged; get it again"),
        (
            "-Y 1 +X 3",
            &[1, 1, 1, 2, 0, 0, 0, 0, 0, 0, 0, 0],
            "a run does not fit its row; the file is damaged; get it again",
        ),
        (
            "-Y 1 +X 3",
            &[1, 0, 0, 2, 1, 1, 1, 9, 0, 0, 0, 0],
            "a run does not fit its row; the file is damaged; get it again",
        ),
        ("+X 8 -Y 1", &new[..], "\"+X 8 -Y 1\" is no size that is read; it must be: -Y HEIGHT +X WIDTH"),
    ] {
        assert_eq!(error(&hdr(size, body)), expected, "{size}");
    }
    // The largest exponent is beyond what scenes have, the smallest is a number still.
    let picture = read(&hdr("-Y 1 +X 2", &[255, 0, 0, 255, 255, 0, 0, 1]));
    assert_eq!((floats(&picture)[0][0], floats(&picture)[1][0]), (MAX_COORDINATE, 255.0 * 0.5f32.powi(135)));
}

/// An EXR of one layer, 2 x 1 texels.
fn exr(compression: e::Compression, channels: Vec<(&str, e::FlatSamples)>) -> Vec<u8> {
    use e::WritableImage;
    let channels = channels.into_iter().map(|(name, samples)| e::AnyChannel::new(name, samples)).collect();
    let encoding = e::Encoding { compression, ..e::Encoding::UNCOMPRESSED };
    let channels = e::AnyChannels::sort(channels);
    let layer = e::Layer::new((2, 1), e::LayerAttributes::named("a"), encoding, channels);
    let mut file = std::io::Cursor::new(Vec::new());
    e::Image::from_layer(layer).write().to_buffered(&mut file).unwrap();
    file.into_inner()
}

/// Small files of each compression.
pub(in crate::files) fn exr_files() -> Vec<Vec<u8>> {
    use e::Compression as C;
    let channel = |name| (name, e::FlatSamples::F16(vec![e::f16::from_f32(0.1), e::f16::ONE]));
    let kinds = [C::Uncompressed, C::RLE, C::ZIP1, C::ZIP16, C::PIZ, C::PXR24, C::B44, C::B44A];
    kinds.map(|kind| exr(kind, ["R", "G", "B", "A"].map(channel).to_vec())).to_vec()
}

#[test]
fn exr_of_all_number_types_and_names() {
    use e::Compression as C;
    let f32s = |a: f32, b: f32| e::FlatSamples::F32(vec![a, b]);
    let f16s = |a: f32, b: f32| e::FlatSamples::F16(vec![e::f16::from_f32(a), e::f16::from_f32(b)]);
    for compression in [C::Uncompressed, C::RLE, C::ZIP1, C::ZIP16, C::PIZ] {
        let channels = vec![
            ("R", f16s(0.1, 65_504.0)),
            ("G", f32s(f32::NAN, f32::INFINITY)),
            ("B", e::FlatSamples::U32(vec![7, 0])),
            ("Z", f32s(1.0, 2.0)),
        ];
        let bytes = exr(compression, channels);
        let picture = read(&bytes);
        let tenth = e::f16::from_f32(0.1).to_f32();
        let expected = [[tenth, 0.0, 7.0, 1.0], [65_504.0, MAX_COORDINATE, 0.0, 1.0]];
        assert_eq!(floats(&picture), expected, "{compression}");
        for length in 0..bytes.len() - 4 {
            assert!(
                decode(&bytes[..length], "x").is_err(),
                "{compression} cut to {length} of {}",
                bytes.len()
            );
        }
    }
    // Grey; colours that are multiplied by alpha; negative ones; a layer's name before the channel's.
    assert_eq!(
        floats(&read(&exr(C::ZIP1, vec![("Y", f32s(0.5, 2.0))]))),
        [[0.5, 0.5, 0.5, 1.0], [2.0, 2.0, 2.0, 1.0]]
    );
    let rgba = vec![
        ("v.R", f32s(0.25, 0.5)),
        ("v.G", f32s(0.5, 0.0)),
        ("v.B", f32s(-1.0, 0.0)),
        ("v.A", f32s(0.5, 0.0)),
    ];
    assert_eq!(floats(&read(&exr(C::ZIP1, rgba))), [[0.5, 1.0, 0.0, 0.5], [0.5, 0.0, 0.0, 0.0]]);
    let message = error(&exr(C::ZIP1, vec![("Z", f32s(0.5, 2.0)), ("id", f32s(0.5, 2.0))]));
    assert_eq!(message, "it has no channels R, G and B, nor Y, but Z, id; save it with colours");
}

/// The standard test scenes' pictures, where they are at hand.
#[test]
fn environments_and_textures() {
    let folder = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../../shared/scenes");
    if !folder.is_dir() {
        println!("skipped: {} is not there", folder.display());
        return;
    }
    let decode = |file: &str| decode(&std::fs::read(folder.join(file)).unwrap(), file);

    let venice = decode("environments/venice_sunset_1k.hdr").unwrap();
    assert_eq!((venice.width, venice.height), (1024, 512));
    let venice = floats(&venice);
    let peak = venice.iter().map(|t| t[0].max(t[1]).max(t[2])).fold(0.0, f32::max);
    assert!((6_495.5..6_496.5).contains(&peak), "{peak}");
    let studio = decode("environments/studio_small_03_1k.hdr").unwrap();
    assert_eq!((studio.width, studio.height), (1024, 512));

    // The smaller one is made of the larger: 2 x 2 texels each, as 16-bit floats.
    let small = decode("environments/venice_sunset_512_zip.exr").unwrap();
    assert_eq!((small.width, small.height), (512, 256));
    for (i, texel) in floats(&small).iter().enumerate() {
        let (x, y) = (i % 512 * 2, i / 512 * 2);
        for channel in 0..3 {
            let at = |x: usize, y: usize| venice[y * 1024 + x][channel];
            let mean = (at(x, y) + at(x + 1, y) + at(x, y + 1) + at(x + 1, y + 1)) / 4.0;
            let error = (texel[channel] - mean).abs();
            assert!(error <= mean * 0.000_6 + 1e-7, "{x} {y}: {} and {mean}", texel[channel]);
        }
    }

    let message = decode("environments/city.exr").unwrap_err();
    assert_eq!(message, "its compression DWAB is not read; save it with ZIP or PIZ");

    let wood = decode("textures/wood_floor_diff_1k.jpg").unwrap();
    assert_eq!((wood.width, wood.height, hash(&wood)), (1024, 1024, WOOD));
}

/// Of the wood's texels.
const WOOD: u64 = 0x43cc_5f3d_03af_2f8e;

/// Each file takes what its own texels do, of whatever depth, and says so before it is decoded.
#[test]
fn texels_stay_as_files_have_them() {
    use e::Compression as C;
    let f16s = e::FlatSamples::F16(vec![e::f16::ONE; 2]);
    let f32s = e::FlatSamples::F32(vec![1.0; 2]);
    let half =
        |names: &[&'static str]| exr(C::ZIP1, names.iter().map(|name| (*name, f16s.clone())).collect());
    let mixed = |names: [&'static str; 3]| {
        let kinds = [f16s.clone(), f16s.clone(), f32s.clone()];
        exr(C::ZIP1, names.into_iter().zip(kinds).collect())
    };
    let data = [&[1, 0, 0, 0, 1, 0, 0, 0][..], &[1, 2, 3, 4]].concat();
    for (file, name, layout, bytes) in [
        (&b"P5 3 1 255\n\x01\x02\x03"[..], "x", Bytes(1), 4),
        (b"P6 3 1 65535\n123456123456123456", "x", Bytes(3), 12),
        (b"P4 9 1\n\x80\x00", "x", Bytes(1), 12),
        (&data, "x.data", Bytes(4), 4),
        (BASELINE, "x", Bytes(3), 820),
        (GREY, "x", Bytes(1), 276),
        (CMYK, "x", Bytes(3), 820),
        (INTERLACED, "x", Bytes(3), 820),
        (PLAIN_BMP, "x", Bytes(3), 820),
        (PLAIN_TGA, "x.tga", Bytes(3), 820),
        (&hdr("-Y 1 +X 1", &[1, 2, 3, 128]), "x", Rgbe, 4),
        (&half(&["R", "G", "B"]), "x", Halves(3), 12),
        (&half(&["R", "G", "B", "A"]), "x", Halves(4), 16),
        (&half(&["Y"]), "x", Halves(1), 4),
        (&half(&["Y", "A"]), "x", Halves(2), 8),
        (&mixed(["R", "G", "B"]), "x", Floats(3), 24),
        (&mixed(["v.R", "v.G", "v.B"]), "x", Floats(3), 24),
        (&exr(C::ZIP1, vec![("Y", f32s.clone())]), "x", Floats(1), 8),
    ] {
        let (head, picture) = (header(file, name).unwrap(), decode(file, name).unwrap());
        assert_eq!((head.layout, head.bytes), (layout, bytes));
        assert_eq!((picture.texels.layout(), picture.texels.bytes()), (layout, bytes));
    }
}

/// Halves that are divided by alpha when they are read are what floats that are divided before are.
#[test]
fn halves_are_read_as_floats_are() {
    use e::Compression as C;
    let numbers = [0.1, 0.0, -0.5, 1.0, 2.0, 65_504.0, 5.96e-8, f32::INFINITY, f32::NAN, 0.3];
    for (color, alpha) in numbers.into_iter().flat_map(|color| numbers.map(|alpha| (color, alpha))) {
        let [color, alpha] = [color, alpha].map(e::f16::from_f32);
        for names in [&["R", "G", "B", "A"][..], &["R", "G", "B"], &["Y"], &["Y", "A"]] {
            let of = |name: &str| if name == "A" { [alpha, alpha] } else { [color, e::f16::from_f32(0.7)] };
            let halves = |name| (name, e::FlatSamples::F16(of(name).to_vec()));
            let wide = |name| (name, e::FlatSamples::F32(of(name).map(e::f16::to_f32).to_vec()));
            let [halves, wide] = [
                read(&exr(C::ZIP1, names.iter().copied().map(halves).collect())),
                read(&exr(C::ZIP1, names.iter().copied().map(wide).collect())),
            ];
            assert_ne!(halves.texels.layout(), wide.texels.layout());
            let bits = |p| floats(p).into_iter().map(|t| t.map(f32::to_bits)).collect::<Vec<_>>();
            assert_eq!(bits(&halves), bits(&wide), "{color} {alpha} {names:?}");
        }
    }
}
