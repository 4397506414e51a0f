//! What is in the file: boxes, and pictures by openh264's decoder.

use super::*;
use openh264::decoder::{DecodeOptions, Decoder, Flush};
use openh264::formats::YUVSource;

/// The content of a box at this path, such as `moov/trak`.
fn find<'a>(bytes: &'a [u8], path: &str) -> Option<&'a [u8]> {
    let (name, rest) = path.split_once('/').unwrap_or((path, ""));
    let content = boxes(bytes).into_iter().find(|(kind, _)| kind == name)?.1;
    if rest.is_empty() { Some(content) } else { find(content, rest) }
}

fn boxes(mut bytes: &[u8]) -> Vec<(String, &[u8])> {
    let mut found = Vec::new();
    while bytes.len() >= 8 {
        let (length, header) = match number(bytes, 0) {
            1 => (u64::from_be_bytes(bytes[8..16].try_into().unwrap()) as usize, 16),
            length => (length as usize, 8),
        };
        found.push((String::from_utf8(bytes[4..8].to_vec()).unwrap(), &bytes[header..length]));
        bytes = &bytes[length..];
    }
    assert!(bytes.is_empty(), "boxes fill the file");
    found
}

fn number(bytes: &[u8], at: usize) -> u32 {
    u32::from_be_bytes(bytes[at..at + 4].try_into().unwrap())
}

#[test]
fn the_file_has_the_structure_of_an_mp4_file() {
    let file = undisturbed((49, 33), 65);
    let kinds: Vec<String> = boxes(&file).into_iter().map(|(kind, _)| kind).collect();
    let at = |kind: &str| kinds.iter().position(|k| k == kind).unwrap();
    assert_eq!(at("ftyp"), 0);
    assert!(at("moov") < at("mdat"), "{kinds:?}");
    // Frames a second: units a second, and units of a frame.
    let media = find(&file, "moov/trak/mdia/mdhd").unwrap();
    assert_eq!((media[0], number(media, 12), number(media, 16)), (0, 30_000, 65 * 1001));
    let times = find(&file, "moov/trak/mdia/minf/stbl/stts").unwrap();
    assert_eq!((number(times, 4), number(times, 8), number(times, 12)), (1, 65, 1001));
    let sizes = find(&file, "moov/trak/mdia/minf/stbl/stsz").unwrap();
    assert_eq!((number(sizes, 4), number(sizes, 8)), (0, 65));
    let total: u32 = (0..65).map(|i| number(sizes, 12 + 4 * i)).sum();
    assert_eq!(total as usize, find(&file, "mdat").unwrap().len());
    let starts = find(&file, "moov/trak/mdia/minf/stbl/stss").unwrap();
    assert_eq!((0..3).map(|i| number(starts, 8 + 4 * i)).collect::<Vec<_>>(), [1, 31, 61]);
    assert_eq!(number(starts, 4), 3);
    let track = find(&file, "moov/trak/tkhd").unwrap();
    let end = track.len();
    assert_eq!((number(track, end - 8) >> 16, number(track, end - 4) >> 16), (50, 34));
    let entry = find(&find(&file, "moov/trak/mdia/minf/stbl/stsd").unwrap()[8..], "avc1").unwrap();
    assert_eq!([&entry[24..26], &entry[26..28]].concat(), [0, 50, 0, 34]);
    assert_eq!(find(&entry[78..], "colr").unwrap(), [&b"nclx"[..], &[0, 1, 0, 1, 0, 1, 0]].concat());
}

/// All frames of a file in bytes of a screen, by openh264's decoder and the formulas of BT.709.
fn decode(file: &[u8]) -> Vec<Developed> {
    let table = |name: &str| find(file, &format!("moov/trak/mdia/minf/stbl/{name}")).unwrap();
    let entry = find(&table("stsd")[8..], "avc1").unwrap();
    let avcc = find(&entry[78..], "avcC").unwrap();
    let set = |at: usize| {
        let length = u16::from_be_bytes([avcc[at], avcc[at + 1]]) as usize;
        (&avcc[at + 2..at + 2 + length], at + 2 + length)
    };
    let (sequence, next) = set(6);
    let (picture, _) = set(next + 1);
    let start = [0, 0, 0, 1];
    let mut decoder = Decoder::new().unwrap();
    let now = DecodeOptions::new().flush_after_decode(Flush::NoFlush);
    decoder.decode_with_options(&[&start, sequence, &start, picture].concat(), now.clone()).unwrap();
    let sizes = table("stsz");
    let mut samples = find(file, "mdat").unwrap();
    let mut frames = Vec::new();
    for i in 0..number(sizes, 8) as usize {
        let (sample, rest) = samples.split_at(number(sizes, 12 + 4 * i) as usize);
        samples = rest;
        let mut units = sample;
        let mut stream = Vec::new();
        while !units.is_empty() {
            let length = number(units, 0) as usize;
            stream.extend_from_slice(&start);
            stream.extend_from_slice(&units[4..4 + length]);
            units = &units[4 + length..];
        }
        if let Some(planes) = decoder.decode_with_options(&stream, now.clone()).unwrap() {
            frames.push(screen_bytes(&planes));
        }
    }
    frames.extend(decoder.flush_remaining().unwrap().iter().map(screen_bytes));
    frames
}

pub(super) fn screen_bytes(planes: &impl YUVSource) -> Developed {
    let ((width, height), (y_stride, u_stride, v_stride)) = (planes.dimensions(), planes.strides());
    let mut rgb = Vec::new();
    for row in 0..height {
        for column in 0..width {
            let y = (planes.y()[row * y_stride + column] as f64 - 16.0) / 219.0;
            // Colours lie on even columns; between two of them is their mean.
            let colour = |plane: &[u8], stride: usize| {
                let at = |x: usize| plane[row / 2 * stride + x.min(width / 2 - 1)] as f64;
                let mean = (at(column / 2) + at(column.div_ceil(2))) / 2.0;
                (mean - 128.0) / 224.0
            };
            let blue = y + 1.8556 * colour(planes.u(), u_stride);
            let red = y + 1.5748 * colour(planes.v(), v_stride);
            let green = (y - 0.2126 * red - 0.0722 * blue) / 0.7152;
            rgb.extend([red, green, blue].map(|x| (x * 255.0 + 0.5) as u8));
        }
    }
    Developed { width: width as u32, height: height as u32, rgb, alpha: Vec::new() }
}

/// Root of the mean square, and mean, of the differences of the picture that both have.
pub(super) fn difference(a: &Developed, b: &Developed) -> (f64, [f64; 3]) {
    let (mut squares, mut sums) = (0.0, [0.0; 3]);
    let (width, height) = (a.width.min(b.width), a.height.min(b.height));
    for y in 0..height {
        let pixels = a.row(y).chunks(3).zip(b.row(y).chunks(3)).take(width as usize);
        for (a, b) in pixels {
            for c in 0..3 {
                let difference = b[c] as f64 - a[c] as f64;
                squares += difference * difference;
                sums[c] += difference;
            }
        }
    }
    let count = (width * height) as f64;
    ((squares / (3.0 * count)).sqrt(), sums.map(|sum| sum / count))
}

#[test]
fn decoded_frames_are_near_the_frames_that_were_written() {
    for size in [(160, 96), (161, 97)] {
        let frames = decode(&undisturbed(size, 33));
        assert_eq!(frames.len(), 33);
        for (number, decoded) in (0..).zip(&frames) {
            assert_eq!((decoded.width, decoded.height), padded_size(size));
            let (error, mean) = difference(&frame(number, size), decoded);
            let decibel = 20.0 * (255.0 / error).log10();
            assert!(decibel > 38.0, "frame {number} of {size:?}: {decibel:.1} dB");
            assert!(mean.iter().all(|m| m.abs() < 1.0), "frame {number} of {size:?}: {mean:?}");
        }
    }
}

/// A wrong matrix or range moves pure colours by ten and more.
#[test]
fn colours_come_back() {
    let colours =
        [[255, 0, 0], [0, 255, 0], [0, 0, 255], [255, 255, 255], [0, 0, 0], [200, 120, 40], [90, 90, 90]];
    let (_folder, path) = in_folder();
    let video = open(&path, (32, 32), colours.len() as u32, 1);
    for (number, colour) in (0..).zip(colours) {
        let picture = Developed { width: 32, height: 32, rgb: colour.repeat(32 * 32), alpha: Vec::new() };
        video.write_frame(number, &picture).unwrap();
    }
    video.finish().unwrap();
    for (colour, frame) in colours.iter().zip(decode(&fs::read(&path).unwrap())) {
        for pixel in frame.rgb.chunks(3) {
            assert!(
                pixel.iter().zip(colour).all(|(a, b)| a.abs_diff(*b) <= 3),
                "{colour:?} became {pixel:?}"
            );
        }
    }
}

#[test]
fn a_picture_that_stands_still_is_as_many_frames() {
    let (_folder, path) = in_folder();
    let video = open(&path, (64, 48), 40, 1);
    for number in 0..40 {
        video.write_frame(number, &frame(0, (64, 48))).unwrap();
    }
    video.finish().unwrap();
    let frames = decode(&fs::read(&path).unwrap());
    assert_eq!(frames.len(), 40);
    assert!(frames.iter().all(|decoded| difference(&frame(0, (64, 48)), decoded).0 < 4.0));
}

#[test]
fn every_small_size_can_be_written_and_decoded() {
    for size in [(15, 15), (15, 17), (16, 16), (18, 50), (33, 31), (130, 16)] {
        let frames = decode(&undisturbed(size, 3));
        assert_eq!(frames.len(), 3, "{size:?}");
        for (number, decoded) in (0..).zip(&frames) {
            assert_eq!((decoded.width, decoded.height), padded_size(size));
            let (error, _) = difference(&frame(number, size), decoded);
            assert!(error < 6.0, "frame {number} of {size:?}: {error}");
        }
    }
}

#[test]
fn more_quality_is_less_error_and_more_bytes() {
    let of = |quality| {
        let (_folder, path) = in_folder();
        let options = VideoOptions { quality, ..options(1) };
        let video = VideoWriter::open(&path, (96, 64), rate(), 5, &options).unwrap();
        for number in 0..5 {
            video.write_frame(number, &frame(number, (96, 64))).unwrap();
        }
        video.finish().unwrap();
        let file = fs::read(&path).unwrap();
        (difference(&frame(4, (96, 64)), &decode(&file)[4]).0, find(&file, "mdat").unwrap().len())
    };
    let found = [1, 40, 80, 100].map(of);
    assert!(found.is_sorted_by(|a, b| a.0 > b.0 && a.1 < b.1), "{found:?}");
}
