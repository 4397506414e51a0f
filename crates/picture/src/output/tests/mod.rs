//! Round trips through files, and files that are no pictures.

mod writer;

use super::*;
use eosphor_core::math::vec3;
use eosphor_render::Film;
use proptest::prelude::*;
use std::fs;
use std::path::{Path, PathBuf};

/// A small film whose pixels all differ.
fn gradient(width: u32, height: u32) -> Film {
    let at =
        |i: u32| vec3((i % width) as f32 / width as f32, (i / width) as f32 / height as f32, 0.1 * i as f32);
    Film { width, height, pixels: (0..width * height).map(at).collect() }
}

fn in_folder(name: &str) -> (tempfile::TempDir, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(name);
    (folder, path)
}

fn opaque(picture: &Developed) -> Picture {
    let rgba = picture.rgb.as_chunks::<3>().0.iter().map(|&[r, g, b]| [r, g, b, 255]).collect();
    Picture::Bytes(ByteImage { width: picture.width, height: picture.height, rgba })
}

/// Saves a film that is all of a picture, or all that was done of it.
fn save_as(film: &Film, path: &Path, options: &SaveOptions, complete: bool) {
    let mut writer = PictureWriter::open(path, (film.width, film.height), options).unwrap();
    writer.write_rows(film, None).unwrap();
    match complete {
        true => writer.finish().unwrap(),
        false => writer.finish_partial(path).unwrap(),
    }
}

fn film_bits(film: &Film) -> Vec<[u32; 3]> {
    film.pixels.iter().map(|p| <[f32; 3]>::from(*p).map(f32::to_bits)).collect()
}

fn read_linear(path: &Path) -> Film {
    match Picture::read(path).unwrap() {
        Picture::Linear(film) => film,
        Picture::Bytes(_) => panic!("the format is linear"),
    }
}

#[test]
fn byte_formats_give_back_every_byte() {
    let film = gradient(7, 5);
    let expected = opaque(&Developed::new(&film, &DevelopSettings::default()));
    for name in ["a.png", "a.PPM", "a.data"] {
        for complete in [true, false] {
            let (_folder, path) = in_folder(name);
            save_as(&film, &path, &SaveOptions::default(), complete);
            assert_eq!(Picture::read(&path).unwrap(), expected, "{name}");
        }
    }
}

#[test]
fn exr_gives_back_every_bit() {
    let mut film = gradient(5, 9);
    film.pixels[3] = vec3(f32::MAX, -0.0, f32::MIN_POSITIVE / 2.0);
    film.pixels[4] = vec3(f32::INFINITY, -1e-30, 1.0 / 3.0);
    let (_folder, path) = in_folder("a.exr");
    save(&film, &path, &SaveOptions::default()).unwrap();
    assert_eq!(film_bits(&read_linear(&path)), film_bits(&film));
}

#[test]
fn exr_of_half_floats_is_the_nearest() {
    let mut film = gradient(6, 6);
    film.pixels[0] = vec3(1e9, 2f32.powi(-24), 1.0 + 2f32.powi(-11));
    let (_folder, path) = in_folder("a.exr");
    save(&film, &path, &SaveOptions { exr_half: true, ..SaveOptions::default() }).unwrap();
    let read = read_linear(&path);
    assert_eq!(<[f32; 3]>::from(read.pixels[0]), [65_504.0, 2f32.powi(-24), 1.0]);
    for (a, b) in film.pixels.iter().zip(&read.pixels).skip(1) {
        assert!((*a - *b).abs().max_component() <= a.max_component() * 2f32.powi(-11), "{a:?} {b:?}");
    }
}

#[test]
fn hdr_is_within_a_256th_of_the_largest_component() {
    // Under 8 pixels a row there are no run lengths.
    for width in [1, 7, 8, 200] {
        let film = gradient(width, 9);
        let (_folder, path) = in_folder("a.hdr");
        save(&film, &path, &SaveOptions::default()).unwrap();
        let read = read_linear(&path);
        assert_eq!((read.width, read.height), (width, 9));
        for (a, b) in film.pixels.iter().zip(&read.pixels) {
            assert!((*a - *b).abs().max_component() <= a.max_component() / 256.0, "{a:?} {b:?}");
        }
    }
}

#[test]
fn jpeg_is_near_at_any_quality_and_size() {
    for (quality, most) in [(100, 6), (90, 8), (75, 24)] {
        for (width, height) in [(1, 1), (16, 16), (17, 33), (40, 130)] {
            let at = |i: u32| vec3((i % width) as f32 / 64.0, (i / width) as f32 / 140.0, 0.3);
            let film = Film { width, height, pixels: (0..width * height).map(at).collect() };
            let (_folder, path) = in_folder("a.JPEG");
            let options = SaveOptions { jpeg_quality: quality, ..SaveOptions::default() };
            save(&film, &path, &options).unwrap();
            let Picture::Bytes(read) = Picture::read(&path).unwrap() else { panic!("JPEG has bytes") };
            let Picture::Bytes(expected) = opaque(&Developed::new(&film, &options.develop)) else { panic!() };
            assert_eq!((read.width, read.height), (width, height));
            for (a, b) in read.rgba.iter().flatten().zip(expected.rgba.iter().flatten()) {
                assert!(a.abs_diff(*b) <= most, "quality {quality}, {width} x {height}: {a} is not {b}");
            }
        }
    }
}

fn holds(bytes: &[u8], part: &[u8]) -> bool {
    bytes.windows(part.len()).any(|window| window == part)
}

#[test]
fn data_is_the_format_of_the_course() {
    let picture = Developed { width: 2, height: 1, rgb: vec![1, 2, 3, 4, 5, 6], alpha: Vec::new() };
    let (_folder, path) = in_folder("a.data");
    save_developed(&picture, &path, &SaveOptions::default()).unwrap();
    let expected = [2, 0, 0, 0, 1, 0, 0, 0, 1, 2, 3, 255, 4, 5, 6, 255];
    assert_eq!(fs::read(&path).unwrap(), expected);
}

#[test]
fn unknown_endings_name_the_known_ones() {
    for name in ["a.tga", "a", "png", ".png"] {
        let error = check_writable(Path::new(name)).unwrap_err().to_string();
        assert!(error.contains(name) && error.contains(".png, .ppm, .jpg, .hdr, .exr or .data"), "{error}");
    }
}

#[test]
fn sixteen_bits_are_refused_not_cut() {
    let (_folder, path) = in_folder("a.png");
    let mut encoder = ::png::Encoder::new(fs::File::create(&path).unwrap(), 1, 1);
    encoder.set_depth(::png::BitDepth::Sixteen);
    encoder.write_header().unwrap().write_image_data(&[1, 2]).unwrap();
    assert!(Picture::read(&path).unwrap_err().to_string().contains("16 bits"));
}

/// Reads `bytes` as every format. The result does not matter; that it comes back does.
fn read_all(bytes: &[u8]) {
    for format in Format::ALL {
        let _ = Picture::from_bytes(bytes, format);
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]

    #[test]
    fn damaged_files_are_errors_or_pictures(at in 0.0..1.0f64, value: u8, cut in 0.0..2.0f64) {
        static FILES: std::sync::LazyLock<Vec<Vec<u8>>> = std::sync::LazyLock::new(|| {
            let file = |format: Format| {
                let (_folder, path) = in_folder(&format!("a.{}", format.extensions()[0]));
                save(&gradient(9, 6), &path, &SaveOptions::default()).unwrap();
                fs::read(&path).unwrap()
            };
            Format::ALL.map(file).to_vec()
        });
        for file in FILES.iter() {
            let mut bytes = file.clone();
            let index = (at * bytes.len() as f64) as usize;
            bytes[index] = value;
            bytes.truncate((cut * bytes.len() as f64) as usize);
            read_all(&bytes);
        }
    }
}
