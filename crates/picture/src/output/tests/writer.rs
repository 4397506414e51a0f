//! Writing row by row: portions, ends, layers, metadata, full disks.

use super::*;
use eosphor_core::math::Vec3;
use eosphor_render::{Bands, FeatureRows};

/// Some rows of a film.
fn rows_of(film: &Film, rows: std::ops::Range<u32>) -> Film {
    let width = film.width as usize;
    let pixels = film.pixels[rows.start as usize * width..rows.end as usize * width].to_vec();
    Film { width: film.width, height: rows.end - rows.start, pixels }
}

#[test]
fn rows_may_come_in_any_portions() {
    let film = gradient(21, 50);
    for format in Format::ALL {
        for quality in [90, 60] {
            let options = SaveOptions { jpeg_quality: quality, ..SaveOptions::default() };
            let files: Vec<Vec<u8>> = [50, 1, 7, 16]
                .into_iter()
                .map(|rows| {
                    let (_folder, path) = in_folder(&format!("a.{}", format.extensions()[0]));
                    let mut writer = PictureWriter::open(&path, (21, 50), &options).unwrap();
                    for band in Bands::of_rows(50, rows) {
                        writer.write_rows(&rows_of(&film, band), None).unwrap();
                    }
                    writer.finish().unwrap();
                    fs::read(&path).unwrap()
                })
                .collect();
            assert!(files.iter().all(|file| *file == files[0]), "{format:?}");
        }
    }
}

/// A stream that can be looked at, and closes after so many bytes.
#[derive(Clone)]
struct Pipe(std::sync::Arc<std::sync::Mutex<Vec<u8>>>, usize);

impl std::io::Write for Pipe {
    fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
        let mut taken = self.0.lock().unwrap();
        match taken.len() + bytes.len() > self.1 {
            true => Err(std::io::ErrorKind::BrokenPipe.into()),
            false => {
                taken.extend(bytes);
                Ok(bytes.len())
            }
        }
    }

    fn flush(&mut self) -> std::io::Result<()> {
        Ok(())
    }
}

#[test]
fn streams_get_the_bytes_of_files_or_nothing() {
    let (film, options, name) = (gradient(21, 50), SaveOptions::default(), std::path::Path::new("the pipe"));
    for format in Format::ALL {
        let (_folder, path) = in_folder(&format!("a.{}", format.extensions()[0]));
        save(&film, &path, &options).unwrap();
        let begin = |pipe: &Pipe| {
            let stream = Box::new(pipe.clone());
            let mut writer = PictureWriter::open_stream(stream, name, format, (21, 50), &options).unwrap();
            assert_eq!(writer.temporary_path(), None);
            writer.write_rows(&rows_of(&film, 0..30), None).unwrap();
            assert!(pipe.0.lock().unwrap().is_empty(), "not before it is whole");
            writer
        };
        let pipe = Pipe(Default::default(), usize::MAX);
        let mut writer = begin(&pipe);
        writer.write_rows(&rows_of(&film, 30..50), None).unwrap();
        writer.finish().unwrap();
        assert!(*pipe.0.lock().unwrap() == fs::read(&path).unwrap(), "{format:?}");

        let cut = Pipe(Default::default(), usize::MAX);
        assert!(begin(&cut).finish_partial(&path).is_err());
        drop(begin(&cut));
        assert!(cut.0.lock().unwrap().is_empty());

        let closed = Pipe(Default::default(), 10);
        let mut writer = begin(&closed);
        writer.write_rows(&rows_of(&film, 30..50), None).unwrap();
        let reason = writer.finish().unwrap_err().to_string();
        assert!(reason.contains("the pipe: ") && reason.contains("closed the pipe"), "{reason}");
    }
}

#[test]
fn parts_of_pictures_say_where_they_lie() {
    use ::exr::prelude::{IntegerBounds, MetaData, Vec2};
    let film = gradient(9, 20);
    let region = eosphor_render::Region { x: 30, y: 50, width: 9, height: 20 };
    for window in [None, Some(Window { region, whole: (640, 480) })] {
        let (_folder, path) = in_folder("a.exr");
        let options = SaveOptions { window, ..SaveOptions::default() };
        save(&film, &path, &options).unwrap();
        let Picture::Linear(read) = Picture::read(&path).unwrap() else { panic!("EXR is linear") };
        assert_eq!(film_bits(&read), film_bits(&film));
        let meta = MetaData::read_from_file(&path, true).unwrap();
        let (data, display) = match window {
            None => (Vec2(0, 0), (9, 20)),
            Some(_) => (Vec2(30, 50), (640, 480)),
        };
        let header = &meta.headers[0];
        assert_eq!(header.data_window(), IntegerBounds::new(data, (9, 20)));
        assert_eq!(header.shared_attributes.display_window, IntegerBounds::from_dimensions(display));
    }
    let (_folder, path) = in_folder("a.png");
    let wrong = Window { region, whole: (38, 480) };
    assert!(save(&film, &path, &SaveOptions { window: Some(wrong), ..SaveOptions::default() }).is_err());
}

#[test]
fn rows_that_were_not_written_are_black() {
    let film = gradient(9, 20);
    let mut expected = film.clone();
    expected.pixels[9 * 12..].fill(Vec3::ZERO);
    for format in Format::ALL {
        let (folder, target) = in_folder(&format!("a.{}", format.extensions()[0]));
        let mut writer = PictureWriter::open(&target, (9, 20), &SaveOptions::default()).unwrap();
        writer.write_rows(&rows_of(&film, 0..12), None).unwrap();
        assert_eq!(writer.rows_left(), 8);
        let path = partial_path(&target);
        assert_eq!(path, folder.path().join(format!("a.partial.{}", format.extensions()[0])));
        writer.finish_partial(&path).unwrap();
        assert!(!target.exists());
        match (format, Picture::read(&path).unwrap()) {
            (Format::Jpeg, _) => {}
            (Format::Hdr, Picture::Linear(read)) => {
                assert_eq!(read.pixels[9 * 12..], expected.pixels[9 * 12..])
            }
            (_, Picture::Linear(read)) => assert_eq!(film_bits(&read), film_bits(&expected)),
            (_, read) => assert_eq!(read, opaque(&Developed::new(&expected, &DevelopSettings::default()))),
        }
    }
}

#[test]
fn a_writer_that_is_dropped_or_misused_leaves_nothing() {
    let (folder, path) = in_folder("a.png");
    let options = SaveOptions::default();
    let mut writer = PictureWriter::open(&path, (4, 4), &options).unwrap();
    assert!(writer.temporary_path().unwrap().exists());
    writer.write_rows(&Film::new(4, 2), None).unwrap();
    assert!(writer.write_rows(&Film::new(4, 3), None).is_err(), "too many");
    let lying = Film { pixels: Vec::new(), ..Film::new(4, 2) };
    assert!(writer.write_rows(&lying, None).is_err(), "pixels are missing");
    assert_eq!(writer.rows_left(), 2, "what was refused does not count");
    drop(writer);
    let mut writer = PictureWriter::open(&path, (4, 4), &options).unwrap();
    assert!(writer.write_rows(&Film::new(3, 1), None).is_err(), "another width");
    drop(writer);
    let writer = PictureWriter::open(&path, (4, 4), &options).unwrap();
    assert!(writer.finish().unwrap_err().to_string().contains("4 of its rows are missing"));
    let mut writer = PictureWriter::open(&folder.path().join("a.hdr"), (4, 4), &options).unwrap();
    assert!(
        writer
            .write_developed(&Developed { width: 4, height: 4, rgb: vec![0; 48], alpha: Vec::new() })
            .is_err()
    );
    drop(writer);
    for (size, quality) in [((0, 4), 90), ((4, 70_000), 90), ((4, 4), 0), ((4, 4), 101)] {
        let options = SaveOptions { jpeg_quality: quality, ..SaveOptions::default() };
        assert!(PictureWriter::open(&path, size, &options).is_err());
    }
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0);
}

#[test]
fn incomplete_pictures_say_so() {
    let film = gradient(4, 4);
    let marks = [
        ("a.png", &b"Comment\0incomplete"[..]),
        ("a.ppm", b"# incomplete"),
        ("a.jpg", b", incomplete"),
        ("a.hdr", b"# incomplete"),
        ("a.exr", b"incomplete\0int\0\x04\0\0\0\x01\0\0\0"),
    ];
    for (name, mark) in marks {
        for complete in [true, false] {
            let (_folder, path) = in_folder(name);
            save_as(&film, &path, &SaveOptions::default(), complete);
            let bytes = fs::read(&path).unwrap();
            assert_eq!(holds(&bytes, mark), !complete, "{name}");
        }
    }
}

#[test]
fn files_say_what_they_are_made_of() {
    let film = gradient(4, 4);
    let metadata =
        Metadata { scene_hash: Some("abc123".into()), command_line: Some("eosphor render 'für'".into()) };
    let options = SaveOptions { metadata, ..SaveOptions::default() };
    let plain = ["Eosphor 0.", "abc123", "eosphor render 'für'"];
    for name in ["a.png", "a.exr"] {
        let (_folder, path) = in_folder(name);
        save(&film, &path, &options).unwrap();
        let bytes = fs::read(&path).unwrap();
        assert!(plain.iter().all(|text| holds(&bytes, text.as_bytes())), "{name}");
        save(&film, &path, &options).unwrap();
        assert_eq!(fs::read(&path).unwrap(), bytes, "{name}: the same every time");
        save(&film, &path, &SaveOptions::default()).unwrap();
        assert!(!holds(&fs::read(&path).unwrap(), b"abc123"));
    }
    for name in ["a.ppm", "a.jpg", "a.hdr"] {
        let (_folder, path) = in_folder(name);
        save(&film, &path, &options).unwrap();
        assert!(holds(&fs::read(&path).unwrap(), b"Eosphor 0."), "{name}");
    }
    // The PNG chunks as a decoder sees them.
    let (_folder, path) = in_folder("a.png");
    save_as(&film, &path, &options, false);
    let mut reader =
        ::png::Decoder::new(std::io::BufReader::new(fs::File::open(&path).unwrap())).read_info().unwrap();
    let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
    reader.next_frame(&mut pixels).unwrap();
    reader.finish().unwrap();
    let info = reader.info();
    let text = |keyword: &str| {
        let chunks = &info.uncompressed_latin1_text;
        chunks.iter().find(|chunk| chunk.keyword == keyword).map(|chunk| chunk.text.clone())
    };
    assert_eq!(text("Picture version"), Some(PICTURE_VERSION.to_string()));
    assert_eq!(text("Scene hash").as_deref(), Some("abc123"));
    assert_eq!(text("Comment").as_deref(), Some("incomplete"));
    assert_eq!(info.utf8_text[0].get_text().unwrap(), "eosphor render 'für'");
}

#[test]
fn only_exr_has_layers() {
    let options = SaveOptions { layers: vec![Layer::Depth], ..SaveOptions::default() };
    let (folder, path) = in_folder("a.png");
    let error = PictureWriter::open(&path, (2, 2), &options).err().unwrap().to_string();
    assert!(error.contains("a.png") && error.contains(".exr"), "{error}");
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0);
}

#[test]
fn a_full_disk_is_an_error() {
    use crate::output::destination::Destination;
    use crate::output::encoder::{ByteEncoder, LinearEncoder};
    let Ok(full) = fs::OpenOptions::new().write(true).open("/dev/full") else { return };
    // Some formats would fail only at the end, or, in an encoder that is dropped, not at all.
    let (film, metadata) = (gradient(8, 8), Metadata::default());
    let picture = Developed::new(&film, &DevelopSettings::default());
    let bytes = |make: &dyn Fn(Destination) -> Result<Box<dyn ByteEncoder>, std::io::Error>| {
        let file = Destination::new(full.try_clone().unwrap());
        let mut encoder = make(file.clone())?;
        encoder.rows(&picture).and_then(|()| encoder.finish(true)).and_then(|()| file.finish())
    };
    let linear = |make: &dyn Fn(Destination) -> Result<Box<dyn LinearEncoder>, std::io::Error>| {
        let file = Destination::new(full.try_clone().unwrap());
        let mut encoder = make(file.clone())?;
        encoder.rows(&film, None).and_then(|()| encoder.finish(true)).and_then(|()| file.finish())
    };
    let layout = || exr::Layout { size: (8, 8), window: None };
    let results = [
        bytes(&|to| Ok(Box::new(png::PngEncoder::new(to, (8, 8), false, &metadata)?))),
        bytes(&|to| Ok(Box::new(ppm::PpmEncoder::new(to, 8, 8)?))),
        bytes(&|to| Ok(Box::new(jpeg::JpegEncoder::new(to, 8, 8, 90)))),
        bytes(&|to| Ok(Box::new(data::DataEncoder::new(to, 8, 8)?))),
        linear(&|to| Ok(Box::new(hdr::HdrEncoder::new(to, 8, 8)?))),
        linear(&|to| {
            Ok(Box::new(exr::ExrEncoder::new(to, layout(), exr::Channel::all(&[], false, false), &metadata)?))
        }),
    ];
    for (number, result) in results.into_iter().enumerate() {
        assert_eq!(result.unwrap_err().kind(), std::io::ErrorKind::StorageFull, "{number}");
    }
}

/// Features of which every number is another.
fn numbered_features(width: u32, height: u32) -> FeatureRows {
    let mut rows = FeatureRows::new(width, height);
    for (i, pixel) in rows.pixels.iter_mut().enumerate() {
        let x = i as f32;
        pixel.albedo = vec3(x, x + 0.25, x + 0.5);
        pixel.normal = vec3(-x, x * 0.5, 1.0);
        pixel.depth = if i == 2 { f32::INFINITY } else { x + 10.0 };
        (pixel.object, pixel.material) = (i as u32 + 100, u32::MAX - i as u32);
    }
    for (i, work) in rows.work.iter_mut().enumerate() {
        (work.nodes, work.tests) = (i as u32 + 1000, i as u32 + 2000);
    }
    rows
}

#[test]
fn layers_are_read_back() {
    use ::exr::prelude::{FlatSamples, read_all_flat_layers_from_file};
    let (film, features) = (gradient(5, 7), numbered_features(5, 7));
    for half in [false, true] {
        let (_folder, path) = in_folder("a.exr");
        let options = SaveOptions { layers: Layer::ALL.to_vec(), exr_half: half, ..SaveOptions::default() };
        let mut writer = PictureWriter::open(&path, (5, 7), &options).unwrap();
        assert!(writer.write_rows(&film, None).is_err(), "layers need features");
        drop(writer);
        let mut writer = PictureWriter::open(&path, (5, 7), &options).unwrap();
        writer.write_rows(&film, Some(&features)).unwrap();
        writer.finish().unwrap();

        let image = read_all_flat_layers_from_file(&path).unwrap();
        assert_eq!(image.layer_data.len(), 1, "one part");
        let channels = &image.layer_data[0].channel_data.list;
        assert_eq!(channels.len(), 3 + 3 + 3 + 1 + 1 + 1 + 2);
        let samples = |name: &str| &channels.iter().find(|c| c.name.eq(name)).unwrap().sample_data;
        let floats = |name| match samples(name) {
            FlatSamples::F32(values) => values.clone(),
            FlatSamples::F16(values) if half && name != "depth.Z" => {
                values.iter().map(|v| v.to_f32()).collect()
            }
            _ => panic!("{name} has another type"),
        };
        let numbers = |name| match samples(name) {
            FlatSamples::U32(values) => values.clone(),
            _ => panic!("{name} has no whole numbers"),
        };
        let pixels = &features.pixels;
        if !half {
            assert_eq!(floats("G"), film.pixels.iter().map(|c| c.y).collect::<Vec<_>>());
        }
        assert_eq!(floats("albedo.B"), pixels.iter().map(|p| p.albedo.z).collect::<Vec<_>>());
        assert_eq!(floats("normal.X"), pixels.iter().map(|p| p.normal.x).collect::<Vec<_>>());
        assert_eq!(floats("depth.Z"), pixels.iter().map(|p| p.depth).collect::<Vec<_>>());
        assert_eq!(numbers("object.ID"), pixels.iter().map(|p| p.object).collect::<Vec<_>>());
        assert_eq!(numbers("material.ID"), pixels.iter().map(|p| p.material).collect::<Vec<_>>());
        assert_eq!(numbers("cost.nodes"), features.work.iter().map(|w| w.nodes).collect::<Vec<_>>());
        assert_eq!(numbers("cost.tests"), features.work.iter().map(|w| w.tests).collect::<Vec<_>>());
        // Programs that know nothing of layers see the colours.
        assert_eq!(read_linear(&path).pixels.len(), 35);
    }
}
