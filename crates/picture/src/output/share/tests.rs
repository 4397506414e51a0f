//! Shares make the whole again, and what is wrong with them is said.

use super::super::{Layer, PictureWriter};
use super::*;
use eosphor_core::math::vec3;
use eosphor_render::{CameraWork, FeatureRows, Film, PickedRows};
use std::fs;

const SIZE: (u32, u32) = (5, 43);

fn header(share: (u32, u32), layers: Vec<Layer>) -> ShareHeader {
    let options = SaveOptions { layers, ..SaveOptions::default() };
    ShareHeader { program: "test".into(), size: SIZE, scene: "abc".into(), options, share }
}

/// Rows whose pixels say where they are.
fn rows(rows: Range<u32>) -> (Film, FeatureRows) {
    let height = rows.end - rows.start;
    let (mut film, mut features) = (Film::new(SIZE.0, height), FeatureRows::new(SIZE.0, height));
    for k in 0..film.pixels.len() {
        let (x, y) = (k as u32 % SIZE.0, rows.start + k as u32 / SIZE.0);
        film.pixels[k] = vec3(x as f32 / 7.0, y as f32 / 50.0, 0.1);
        features.pixels[k].depth = y as f32;
        features.pixels[k].object = x;
        features.pixels[k].albedo = film.pixels[k];
        features.work[k] = CameraWork { nodes: x + y, tests: 3 };
    }
    (film, features)
}

fn write(path: &Path, header: &ShareHeader) {
    let mut writer = ShareWriter::open(path, header).unwrap();
    // In pieces that are other rows than its bands.
    let all = PickedRows::new(header.bands());
    for first in (0..all.height()).step_by(11) {
        let pieces = all.in_picture(&(first..all.height().min(first + 11)));
        let (mut film, mut features) = (Film::new(SIZE.0, 0), FeatureRows::new(SIZE.0, 0));
        for (some, some_features) in pieces.into_iter().map(rows) {
            film.height += some.height;
            film.pixels.extend(some.pixels);
            features.pixels.extend(some_features.pixels);
            features.work.extend(some_features.work);
        }
        writer.write_rows(&film, (!header.options.layers.is_empty()).then_some(&features)).unwrap();
    }
    writer.finish().unwrap();
}

#[test]
fn shares_make_the_whole() {
    let folder = tempfile::tempdir().unwrap();
    for (name, layers) in [("a.png", Vec::new()), ("b.exr", Layer::ALL.to_vec())] {
        let whole = folder.path().join(name);
        let options = SaveOptions { layers: layers.clone(), ..SaveOptions::default() };
        let mut writer = PictureWriter::open(&whole, SIZE, &options).unwrap();
        let (film, features) = rows(0..SIZE.1);
        writer.write_rows(&film, (!layers.is_empty()).then_some(&features)).unwrap();
        writer.finish().unwrap();
        // More shares than bands: some are empty.
        for count in [1, 2, 3, 6, 9] {
            let paths: Vec<PathBuf> = (1..=count).map(|k| share_path(&whole, (k, count))).collect();
            for (k, path) in (1..).zip(&paths) {
                write(path, &header((k, count), layers.clone()));
            }
            let merged = folder.path().join(format!("merged-{name}"));
            let backwards: Vec<PathBuf> = paths.iter().rev().cloned().collect();
            merge(&backwards, &merged).unwrap();
            assert!(fs::read(&merged).unwrap() == fs::read(&whole).unwrap(), "{name}, {count} shares");
        }
    }
}

#[test]
fn what_is_wrong_is_said() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    let [a, b, other] = [path("a"), path("b"), path("other")];
    write(&a, &header((1, 2), Vec::new()));
    write(&b, &header((2, 2), Vec::new()));
    write(&other, &ShareHeader { scene: "def".into(), ..header((2, 2), Vec::new()) });
    let out = path("out.png");
    let says = |shares: &[&PathBuf], reason: &str| {
        let shares: Vec<PathBuf> = shares.iter().map(|&path| path.clone()).collect();
        let error = merge(&shares, &out).unwrap_err().to_string();
        assert!(error.contains(reason), "{error}");
    };
    says(&[&a], "missing: 2 of 2");
    says(&[&b], "missing: 1 of 2");
    says(&[&a, &a, &b], "the same share");
    says(&[&a, &other], "scene or settings");
    says(&[&path("none")], "no such file");
    let whole = fs::read(&a).unwrap();
    for at in 0..whole.len() {
        let mut bytes = whole.clone();
        bytes[at] ^= 1 << (at % 8);
        fs::write(&a, &bytes).unwrap();
        assert!(merge(&[a.clone(), b.clone()], &out).is_err(), "byte {at}");
        fs::write(&a, &whole[..at]).unwrap();
        assert!(merge(&[a.clone(), b.clone()], &out).is_err(), "{at} bytes");
    }
    assert!(!out.exists());
}
