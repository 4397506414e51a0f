//! Round trips through files, and files that are no pictures.

use super::*;
use crate::Film;
use eosphor_core::math::vec3;
use proptest::prelude::*;
use std::fs;
use std::path::PathBuf;

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

#[test]
fn byte_formats_give_back_every_byte() {
    let film = gradient(7, 5);
    let expected = opaque(&Developed::new(&film, &DevelopSettings::default()));
    for name in ["a.png", "a.PPM", "a.data"] {
        for complete in [true, false] {
            let (_folder, path) = in_folder(name);
            save(&film, &path, &SaveOptions { complete, ..SaveOptions::default() }).unwrap();
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
    let Picture::Linear(read) = Picture::read(&path).unwrap() else { panic!("EXR is linear") };
    let bits =
        |film: &Film| film.pixels.iter().map(|p| <[f32; 3]>::from(*p).map(f32::to_bits)).collect::<Vec<_>>();
    assert_eq!(bits(&read), bits(&film));
}

#[test]
fn incomplete_pictures_say_so() {
    let film = gradient(4, 4);
    for (name, mark) in [("a.png", "Comment\0incomplete"), ("a.ppm", "# incomplete")] {
        for complete in [true, false] {
            let (_folder, path) = in_folder(name);
            save(&film, &path, &SaveOptions { complete, ..SaveOptions::default() }).unwrap();
            let bytes = fs::read(&path).unwrap();
            let marked = bytes.windows(mark.len()).any(|w| w == mark.as_bytes());
            assert_eq!(marked, !complete, "{name}");
        }
    }
    for complete in [true, false] {
        let (_folder, path) = in_folder("a.exr");
        save(&film, &path, &SaveOptions { complete, ..SaveOptions::default() }).unwrap();
        assert_eq!(exr::is_marked_incomplete(&fs::read(&path).unwrap()), !complete);
    }
}

#[test]
fn data_is_the_format_of_the_course() {
    let picture = Developed { width: 2, height: 1, rgb: vec![1, 2, 3, 4, 5, 6] };
    let (_folder, path) = in_folder("a.data");
    save_developed(&picture, &path, true).unwrap();
    let expected = [2, 0, 0, 0, 1, 0, 0, 0, 1, 2, 3, 255, 4, 5, 6, 255];
    assert_eq!(fs::read(&path).unwrap(), expected);
}

#[test]
fn unknown_endings_name_the_known_ones() {
    for name in ["a.tga", "a", "png", ".png"] {
        let error = check_writable(std::path::Path::new(name)).unwrap_err().to_string();
        assert!(error.contains(name) && error.contains(".png, .ppm, .exr or .data"), "{error}");
    }
}

#[test]
fn a_full_disk_is_an_error() {
    if let Ok(full) = fs::OpenOptions::new().write(true).open("/dev/full") {
        let picture = Developed::new(&gradient(8, 8), &DevelopSettings::default());
        assert!(png::write(&full, &picture, true).is_err());
        assert!(ppm::write(&full, &picture, true).is_err());
        assert!(data::write(&full, &picture).is_err());
        assert!(exr::write(&full, &gradient(8, 8), true).is_err());
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
    let _ = (png::read(bytes), ppm::read(bytes), data::read(bytes), exr::read(bytes));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]

    #[test]
    fn damaged_files_are_errors_or_pictures(at in 0.0..1.0f64, value: u8, cut in 0.0..2.0f64) {
        let film = gradient(6, 6);
        let picture = Developed::new(&film, &DevelopSettings::default());
        let mut files = vec![Vec::new(), Vec::new(), Vec::new()];
        png::write(&mut files[0], &picture, true).unwrap();
        ppm::write(&mut files[1], &picture, true).unwrap();
        let mut exr_file = std::io::Cursor::new(Vec::new());
        exr::write(&mut exr_file, &film, true).unwrap();
        files[2] = exr_file.into_inner();
        for mut bytes in files {
            let index = (at * bytes.len() as f64) as usize;
            bytes[index] = value;
            bytes.truncate((cut * bytes.len() as f64) as usize);
            read_all(&bytes);
        }
    }
}
