//! The course's text: what it says, how it is written, what is wrong with it.

use super::{CourseInput, CourseOptions};
use crate::files::LoadedScene;
use crate::files::source::Source;
use crate::flatten::SceneData;
use crate::model::{Law, NormalMode, PixelSampling, Texels};
use crate::solids::Solid;
use eosphor_core::develop::Transfer;
use eosphor_core::light::Light;
use eosphor_core::math::{Vec3, vec3};
use eosphor_core::settings::{LightingModel, PixelSampling as CoreSampling, ShadowMode};
use eosphor_core::texture::TextureWrap;
use proptest::prelude::*;
use std::borrow::Cow;
use std::path::{Path, PathBuf};

/// The example of the course's specification.
const EXAMPLE: &str = "1024
out/img_%d.data
640 480 120
7.0 3.0 0.0  2.0 1.0  2.0 6.0 1.0  0.0 0.0
2.0 0.0 0.0  0.5 0.1  1.0 4.0 1.0  0.0 0.0
2.0 0.0 0.0  1.0 0.0 0.0  1.0  0.9 0.1 10
0.0 2.0 0.0  0.0 1.0 0.0  0.75 0.8 0.2 5
0.0 0.0 0.0  0.0 0.7 0.7  0.5  0.7 0.3 2
-5.0 -5.0 -1.0  -5.0 5.0 -1.0  5.0 5.0 -1.0  5.0 -5.0 -1.0  floor.data  0.0 1.0 0.0  0.5
2
-10.0 0.0 10.0  1.0 1.0 1.0
1.0 0.0 10.0  0.0 0.0 1.0
10 16
";

fn parse(text: &str) -> Result<CourseInput, String> {
    CourseInput::parse(text.as_bytes(), Path::new("standard input")).map_err(|e| e.to_string())
}

/// A picture of two texels in the course's format: red, then blue.
fn floor_data() -> Vec<u8> {
    [&[2, 0, 0, 0, 1, 0, 0, 0][..], &[255, 0, 0, 0], &[0, 0, 255, 0]].concat()
}

fn scene_with(input: &CourseInput, options: &CourseOptions) -> Result<LoadedScene, String> {
    let files = vec![(PathBuf::from("floor.data"), Cow::Owned(floor_data()))];
    input.scene_from(Source::Memory(files), options).map_err(|e| e.to_string())
}

#[test]
fn the_example_has_its_numbers() {
    let input = parse(EXAMPLE).unwrap();
    assert_eq!((input.frames, input.size, input.fov_x_degrees), (1024, [640, 480], 120.0));
    assert_eq!(input.output.path(1023), PathBuf::from("out/img_1023.data"));
    let camera = Law {
        r: 7.0,
        z: 3.0,
        r_amplitude: 2.0,
        z_amplitude: 1.0,
        r_frequency: 2.0,
        z_frequency: 6.0,
        phi_frequency: 1.0,
        ..Law::default()
    };
    assert_eq!(input.position, camera);
    assert_eq!((input.look_at.r, input.look_at.z_amplitude, input.look_at.z_frequency), (2.0, 0.1, 4.0));
    let body = input.bodies[1];
    assert_eq!((body.center, body.color), (vec3(0.0, 2.0, 0.0), vec3(0.0, 1.0, 0.0)));
    assert_eq!((body.radius, body.reflection, body.transparency, body.lights_per_edge), (0.75, 0.8, 0.2, 5));
    assert_eq!(input.floor.corners[1], vec3(-5.0, 5.0, -1.0));
    assert_eq!((input.floor.texture.as_str(), input.floor.tint), ("floor.data", vec3(0.0, 1.0, 0.0)));
    assert_eq!((input.lights[1].color, input.floor.reflection), (vec3(0.0, 0.0, 1.0), 0.5));
    assert_eq!((input.depth, input.rays_root), (10, 16));
}

#[test]
fn lines_are_known() {
    let text = EXAMPLE.replace("  floor.data", "\n\nfloor.data");
    let (_, lines) = CourseInput::parse_with_lines(text.as_bytes(), Path::new("in")).unwrap();
    assert_eq!((lines.output, lines.texture), (2, 11));
}

#[test]
fn it_is_written_as_it_was_read() {
    let input = parse(EXAMPLE).unwrap();
    assert_eq!(parse(&input.to_string()), Ok(input.clone()));
    let squeezed = |text: &str| text.split_whitespace().collect::<Vec<_>>().join(" ");
    assert_eq!(squeezed(&input.to_string()), squeezed(EXAMPLE));
    let colourful = CourseInput::colourful();
    assert_eq!(parse(&colourful.to_string()), Ok(colourful));
    // White space is all the same, and so is a byte order mark.
    assert_eq!(parse(&format!("\u{feff}{}", EXAMPLE.replace(['\n', ' '], "\r\n\t"))), Ok(input));
}

/// Each word of the text replaced in turn.
#[test]
fn errors_name_line_and_field() {
    let wrong = |before: &str, after: &str| {
        assert!(EXAMPLE.contains(before), "{before}");
        parse(&EXAMPLE.replacen(before, after, 1)).unwrap_err()
    };
    for (before, after, message) in [
        ("1024", "0", "1: number of frames: 0 is out of range; it must be 1 to 6000000"),
        ("1024", "x", "1: number of frames: \"x\" is not a number"),
        ("1024", "1.5", "1: number of frames: \"1.5\" is not a whole number"),
        (
            "img_%d",
            "img",
            "2: output path: \"out/img.data\" must have one %d (or %04d, %% for a percent sign) for the number of the frame",
        ),
        ("640", "-640", "3: width: -640 is out of range; it must be 1 to 65535"),
        ("480", "65536", "3: height: 65536 is out of range; it must be 1 to 65535"),
        (" 120", " 180", "3: angle: 180 is out of range; it must be over 0 and under 180"),
        ("7.0 3.0", "nan 3.0", "4: r0 of camera: nan is out of range; it must be -1e9 to 1e9"),
        ("7.0 3.0", "7.0 3,0", "4: z0 of camera: \"3,0\" is not a number"),
        ("0.5 0.1", "0.5 1e10", "5: A_z of look-at point: 1e10 is out of range; it must be -1e9 to 1e9"),
        ("1.0 4.0", "1.0 -1e7", "5: w_z of look-at point: -1e7 is out of range; it must be -1e6 to 1e6"),
        (
            "0.0 1.0 0.0  0.75",
            "0.0 1.5 0.0  0.75",
            "7: green of colour of body 2: 1.5 is out of range; it must be 0 to 1",
        ),
        ("0.75", "-0.75", "7: radius of body 2: -0.75 is out of range; it must be over 0 and at most 1e9"),
        ("0.75", "inf", "7: radius of body 2: inf is out of range; it must be over 0 and at most 1e9"),
        ("0.9 0.1", "1.1 0.1", "6: reflection of body 1: 1.1 is out of range; it must be 0 to 1"),
        ("0.7 0.3", "0.7 -0.3", "8: transparency of body 3: -0.3 is out of range; it must be 0 to 1"),
        ("0.3 2", "0.3 1001", "8: lights an edge of body 3: 1001 is out of range; it must be 0 to 1000"),
        ("5.0 -5.0 -1.0  floor", "5.0 y -1.0  floor", "9: y of corner 4 of the floor: \"y\" is not a number"),
        (
            "0.0 1.0 0.0  0.5\n",
            "0.0 1.0 2.0  0.5\n",
            "9: blue of tint of the floor: 2.0 is out of range; it must be 0 to 1",
        ),
        ("  0.5\n2\n", "  0.5\n5\n", "10: number of lights: 5 is out of range; it must be 0 to 4"),
        (
            "1.0 1.0 1.0\n",
            "1.0 1.0 -1.0\n",
            "11: blue of colour of light 1: -1.0 is out of range; it must be 0 to 1e6",
        ),
        ("10 16", "65 16", "13: recursion depth: 65 is out of range; it must be 0 to 64"),
        ("10 16", "10 0", "13: square root of rays a pixel: 0 is out of range; it must be 1 to 256"),
        ("10 16\n", "10", "13: square root of rays a pixel: it is missing; the text ends here"),
        (
            "10 16\n",
            "10 16 7",
            "13: after the end: \"7\" is too much; the root of rays a pixel is the last number. Is the number of lights right?",
        ),
    ] {
        assert_eq!(wrong(before, after), format!("standard input:{message}"));
    }
    assert_eq!(
        parse(""),
        Err("standard input:1: number of frames: it is missing; the text ends here".into())
    );
    let bytes = CourseInput::parse(b"1\n\xff", Path::new("in")).unwrap_err().to_string();
    assert_eq!(bytes, "in:2: this is no text: the input is read as UTF-8");
    let long = parse(&"9".repeat(100_000)).unwrap_err();
    assert!(long.len() < 120, "{long}");
}

#[test]
fn the_scene_is_platos() {
    let input = parse(EXAMPLE).unwrap();
    let scene = scene_with(&input, &CourseOptions::default()).unwrap().scene;
    let s = &scene.settings;
    assert_eq!((s.size, s.depth, s.pixel_sampling), ([640, 480], 10, PixelSampling::Grid(16)));
    assert_eq!((s.lighting, s.shadows), (LightingModel::Phong, ShadowMode::Coloured));
    assert_eq!((s.energy_threshold, s.light_falloff, s.srgb_textures), (0.005, false, false));
    assert_eq!((s.normals, s.transfer, s.background), (NormalMode::Flat, Transfer::Linear, Vec3::ZERO));
    let camera = scene.camera.unwrap();
    assert_eq!((camera.position, camera.look_at), (vec3(7.0, 0.0, 3.0), Some(vec3(2.0, 0.0, 0.0))));
    assert_eq!((camera.up, camera.fov_x_degrees), (vec3(0.0, 0.0, 1.0), 120.0));
    // Frame 256 of 1024 is at a quarter of the time.
    let quarter = scene.camera_at(256).unwrap().position;
    assert!((quarter - vec3(0.0, 7.0, 3.0)).length() < 1e-5, "{quarter:?}");

    let (data, notes) = SceneData::flatten(&scene).unwrap();
    assert!(notes.is_empty(), "{notes:?}");
    assert_eq!((data.settings.samples, data.settings.pixel_sampling), (256, CoreSampling::Grid));
    let lights = data.lights.iter().map(|light| match light {
        Light::Point { position, color } => (*position, *color),
        other => panic!("{other:?}"),
    });
    let dim = Vec3::splat(0.7);
    let expected = [
        (vec3(2.0, 0.0, 0.0), dim),
        (vec3(0.0, 2.0, 0.0), dim),
        (Vec3::ZERO, dim),
        (vec3(-10.0, 0.0, 10.0), Vec3::ONE),
        (vec3(1.0, 0.0, 10.0), vec3(0.0, 0.0, 1.0)),
    ];
    assert!(lights.eq(expected));
    // Face: half of its colour scatters, all of it colours the shadow.
    let face = &data.materials[0];
    assert_eq!((face.diffuse, face.shadow_filter), (vec3(0.5, 0.0, 0.0), vec3(0.1, 0.0, 0.0)));
    assert_eq!((face.reflection, face.transmission), (Vec3::splat(0.9), Vec3::splat(0.1)));
    assert_eq!((face.specular, face.shininess), (Vec3::splat(0.9), 64.0));
}

/// The frame whose time PLATO reports.
#[test]
fn the_measured_frame_has_326_triangles() {
    let mut input = parse(EXAMPLE).unwrap();
    for (body, lights) in input.bodies.iter_mut().zip([5, 5, 3]) {
        body.lights_per_edge = lights;
    }
    let (data, _) =
        SceneData::flatten(&scene_with(&input, &CourseOptions::default()).unwrap().scene).unwrap();
    assert_eq!(data.triangles.len(), 326);
    assert_eq!(data.triangles.len(), 16 + 30 + 32 + 60 + 96 + 90 + 2);
    // With real diodes each is a light, instead of those in the middle.
    let options = CourseOptions { diodes: true, ..CourseOptions::default() };
    let (data, _) = SceneData::flatten(&scene_with(&input, &options).unwrap().scene).unwrap();
    assert_eq!((data.triangles.len(), data.lights.len()), (326, 2 + 30 + 60 + 90));
}

#[test]
fn bodies_can_have_other_shapes() {
    let input = parse(EXAMPLE).unwrap();
    let shapes = [Solid::Cube, Solid::Icosahedron, Solid::Cube].map(Some);
    let scene = scene_with(&input, &CourseOptions { shapes, ..CourseOptions::default() }).unwrap().scene;
    let counts: Vec<usize> = scene.meshes.iter().map(|m| m.triangles.len()).collect();
    assert_eq!(counts, [36 + 120, 80 + 150, 36 + 24]);
    // One of them alone, on the floor.
    let shapes = [Some(Solid::Tetrahedron), None, None];
    let scene = scene_with(&input, &CourseOptions { shapes, ..CourseOptions::default() }).unwrap().scene;
    assert_eq!(SceneData::flatten(&scene).unwrap().0.triangles.len(), 78);
}

#[test]
fn the_floor_has_one_picture() {
    let mut input = parse(EXAMPLE).unwrap();
    let scene = scene_with(&input, &CourseOptions::default()).unwrap().scene;
    let floor = scene.parallelograms[0];
    assert_eq!((floor.corner, floor.edge_u), (vec3(-5.0, -5.0, -1.0), vec3(10.0, 0.0, 0.0)));
    let material = &scene.materials[floor.material as usize];
    let texture = &scene.textures[material.textures.color.unwrap() as usize];
    assert_eq!((texture.wrap_u, texture.wrap_v), (TextureWrap::Clamp, TextureWrap::Clamp));
    let image = &scene.images[texture.image as usize];
    assert_eq!(image.texels, Texels::rgba8(vec![0x0000_00ff, 0x00ff_0000]));
    // Half of picture times tint scatters; nothing passes.
    let (data, _) = SceneData::flatten(&scene).unwrap();
    let flat = &data.materials[floor.material as usize];
    assert_eq!((flat.diffuse, flat.shadow_filter), (vec3(0.0, 0.5, 0.0), Vec3::ZERO));

    // Four corners that make no parallelogram: the same picture over two triangles.
    input.floor.corners[2] = vec3(6.0, 6.0, -1.0);
    let scene = scene_with(&input, &CourseOptions::default()).unwrap().scene;
    assert!(scene.parallelograms.is_empty());
    let mesh = scene.meshes.last().unwrap();
    assert_eq!((mesh.positions.as_slice(), mesh.triangles.len()), (&input.floor.corners[..], 2));
    for t in &mesh.triangles {
        assert_eq!(t.positions, t.uvs);
        let [a, b, c] = t.positions.map(|i| mesh.positions[i as usize]);
        assert!((b - a).cross(c - a).z > 0.0);
    }
}

#[test]
fn textures_are_found_or_missed_by_name() {
    let mut input = parse(EXAMPLE).unwrap();
    let folder = PathBuf::from("there");
    let options = CourseOptions { folder, ..CourseOptions::default() };
    let missing = scene_with(&input, &options).unwrap_err();
    assert!(missing.starts_with("there/floor.data: cannot read: "), "{missing}");
    input.floor.texture = "builtin:parquet".into();
    let scene = scene_with(&input, &options).unwrap().scene;
    assert_eq!(scene.images.iter().map(|i| i.width).max(), Some(1024));
    input.floor.texture = "builtin:marble".into();
    let error = scene_with(&input, &options).unwrap_err();
    assert_eq!(
        error,
        "builtin:marble: there is no built-in picture \"marble\"; there are parquet and studio"
    );
    let cut = vec![(PathBuf::from("floor.data"), Cow::Owned(floor_data()[..10].to_vec()))];
    input.floor.texture = "floor.data".into();
    let error = input.scene_from(Source::Memory(cut), &CourseOptions::default()).unwrap_err().to_string();
    assert!(error.starts_with("floor.data: 2 x 1 texels take 8 bytes"), "{error}");
}

#[test]
fn the_colourful_one_runs_as_it_is() {
    let loaded = CourseInput::colourful().scene(&CourseOptions::default()).unwrap();
    let (data, notes) = SceneData::flatten(&loaded.scene).unwrap();
    assert!(notes.is_empty() && loaded.warnings.is_empty() && loaded.files_read.is_empty());
    assert_eq!(data.triangles.len(), 16 + 60 + 32 + 60 + 96 + 150 + 2);
}

/// What reads, also makes a scene or says why not.
fn check(text: &[u8]) {
    match CourseInput::parse(text, Path::new("in")) {
        Ok(input) => {
            let bytes = input.to_string();
            assert_eq!(CourseInput::parse(bytes.as_bytes(), Path::new("in")).unwrap(), input);
            // Thousands of lights take long to make; they are tested elsewhere.
            let few = input.bodies.iter().all(|b| b.lights_per_edge < 50);
            if let (true, Ok(loaded)) = (few, scene_with(&input, &CourseOptions::default())) {
                let _ = SceneData::flatten(&loaded.scene);
            }
        }
        Err(error) => {
            let message = error.to_string();
            assert!(message.starts_with("in:") && !message.contains('\n'), "{message}");
        }
    }
}

proptest! {
    #[test]
    fn no_input_panics(text in proptest::collection::vec(any::<u8>(), 0..200)) {
        check(&text);
    }

    #[test]
    fn no_words_panic(edits in proptest::collection::vec((any::<proptest::sample::Index>(), proptest::sample::select(vec![
        "0", "1", "-1", "1e9", "-1e9", "1e-40", "0.5", "nan", "-inf", "1e39", "4", "180", "179.999", "%d", "x", "",
        "builtin:", "builtin:parquet", "99999999999999999999999999999999999999999999", "\u{1F600}", "\u{a0}",
    ])), 1..4)) {
        let mut words: Vec<&str> = EXAMPLE.split_whitespace().collect();
        for (at, word) in edits {
            *at.get_mut(&mut words) = word;
        }
        check(words.join(" ").as_bytes());
    }
}
