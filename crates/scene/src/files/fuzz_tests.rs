//! No bytes make a parser panic; what loads also passes flattening or fails with an error.

use super::images::tests::exr_files;
use super::source::Source;
use super::{LoadOptions, load_from};
use crate::SceneData;
use proptest::prelude::*;
use std::borrow::Cow;
use std::path::{Path, PathBuf};

const OBJ: &str = "mtllib m.mtl\no a\nv 0 0 0\nv 1 0 0.5\nv 1 1 0\nv -1e3 .5 0 1\nvt 0 1\nvt 0.5\nvn 0 0 1\ns 1\n\
                   usemtl red\nf 1/1/1 2/2/1 3/1/1 \\\n4/1/1\nusemtl glass\nf -1//-1 -2//1 -3//1\nl 1 2\n# end\n";
const MTL: &str = "newmtl red\nKd 1 0 0 # red\nKs .5\nNs 100\nd 0.5\nillum 2\nmap_Kd -o 1 1 -clamp on t.ppm\n\
                   newmtl glass\nillum 7\nNi 1.5\nTf 1 1 1\nTr 0.1\nKe 0 0 1e3\n";
const JSON: &str = r#"{"eosphor": 2, "camera": {"position": [0, 0, 5], "look-at": [0, 0, 0], "fov-y-degrees": 30},
    "lights": [{"spot": {"position": [0, 5, 0], "direction": [0, -1, 0], "inner-degrees": 10,
    "outer-degrees": 20, "color": [9, 9, 9]}}], "materials": {"a": {"dielectric": {"ior": "water"}},
    "b": {"matte": {"color": [1, 0, 0]}, "texture": {"file": "t.ppm", "wrap": "clamp"}}, "c": {"pbr":
    {"roughness": 0.5, "ior": 1.4}, "textures": {"color": {"file": "t.ppm", "scale": [2, -1], "offset": [0.5, 0],
    "rotate-degrees": 30, "wrap-u": "mirror", "uv-set": 0}, "opacity": {"file": "t.ppm", "channel": "red"},
    "normal-scale": 2}, "alpha": {"mask": {"cutoff": 0.5}}}, "d": {"mtl": {"Kd": [1, 1, 1]}, "alpha": "blend"}},
    "meshes": [{"file": "a.obj", "name": "m"}, {"file": "a.obj", "name": "n", "material": "c"}],
    "instances": [{"mesh": "m", "transform": {"scale": [1, -2, 1]}}, {"mesh": "m", "material": "b"},
    {"mesh": "n", "transform": {"scale": 2, "matrix": [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0]]}}],
    "spheres": [{"center": [0, 0, 0], "radius": 1, "material": "a"}],
    "parallelograms": [{"corner": [0, 0, 0], "edge-u": [1, 0, 0], "edge-v": [0, 1, 0]}],
    "settings": {"samples": 2, "pixel-sampling": {"grid": 2}}}"#;
const OVER: &str = r#"{"eosphor": 2, "base": "b.json", "camera": {"position": [1, 2, 3], "look-at": [0, 0, 0]},
    "lights": [{"point": {"position": [0, 9, 0], "color": [1, 1, 1]}}], "settings": {"samples": 3, "max-distance": null},
    "device": {"accel": "bvh"}, "output": "o.png"}"#;
const PLY: &str = "ply\nformat ascii 1.0\ncomment TextureFile t.ppm\nelement vertex 4\nproperty float x\nproperty float y\n\
                   property double z\nproperty float nx\nproperty float ny\nproperty float nz\nproperty uchar red\n\
                   property uchar green\nproperty uchar blue\nelement face 2\nproperty list uchar int vertex_indices\n\
                   property list uchar float texcoord\nelement tristrips 1\nproperty list int int vertex_indices\n\
                   end_header\n0 0 0 0 0 1 9 8 255\n1 0 0 0 0 1 9 8 255\n0 1 0 0 0 1 9 8 255\n1 1 0 0 0 1 9 8 255\n\
                   4 0 1 3 2 8 0 0 1 0 1 1 0 1\n3 0 1 2 0\n6 0 1 2 3 -1 2\n";
const PG1: &str = r#"{"seed": 1, "obj_loader": {"basepath": "."}, "renderer": {"render_mode": "gpu", "max_depth": 2,
    "render_type": "phong", "background_color": [0, 0, 1], "acceleratied_data_structure": {"name": "octree"}},
    "scene": {"source_file": "a.obj", "camera": {"pos": [0, 0, 5], "fov": 0.6, "width": 8, "samples_per_pixel": 2},
    "point_lights": [{"pos": [0, 1, 0], "color": [1, 1, 1]}]}}"#;
const PPM: &str = "P3\n1 1\n255\n1 2 3\n";

const PICTURES: [(&str, &[u8]); 7] = [
    ("a.jpg", include_bytes!("../../tests/data/pictures/baseline.jpg")),
    ("b.jpg", include_bytes!("../../tests/data/pictures/progressive.jpg")),
    ("c.png", include_bytes!("../../tests/data/pictures/interlaced.png")),
    ("d.bmp", include_bytes!("../../tests/data/pictures/palette.bmp")),
    ("e.tga", include_bytes!("../../tests/data/pictures/runs.tga")),
    (
        "h.hdr",
        b"#?RADIANCE\n\n-Y 1 +X 8\n\x02\x02\0\x08\x88\x80\x08\x80\0\x80\0\x80\0\x80\0\x84\0\x84\x20\x88\x81",
    ),
    ("i.ppm", b"P2 3 1 100 50 7 99\n"),
];

/// Loads and flattens; the first file has the given contents.
fn run(first: &str, bytes: Vec<u8>) -> bool {
    let mut files: Vec<(PathBuf, Cow<'static, [u8]>)> = vec![(PathBuf::from(first), Cow::Owned(bytes))];
    for (name, text) in [("a.obj", OBJ), ("m.mtl", MTL), ("t.ppm", PPM), ("b.json", JSON)] {
        files.push((PathBuf::from(name), Cow::Borrowed(text.as_bytes())));
    }
    let start = if first.ends_with(".json") || first.ends_with(".ply") { first } else { "a.obj" };
    match load_from(Source::Memory(files), Path::new(start), &LoadOptions::default()) {
        Ok(loaded) => SceneData::flatten(&loaded.scene).is_ok(),
        Err(error) => {
            let message = error.to_string();
            assert!(!message.is_empty() && !message.contains('\n'), "{message:?}");
            // What the schema lets through is read.
            assert!(!message.contains("does not follow the format"), "{message}");
            false
        }
    }
}

/// A text with some bytes replaced, removed or inserted, mostly by bytes that matter to the formats.
fn mutated(text: &'static str) -> impl Strategy<Value = Vec<u8>> {
    let byte =
        prop_oneof![proptest::sample::select(b" \n\r\t/\\-+.#0123456789eE\"{}[],:nvf".to_vec()), any::<u8>()];
    proptest::collection::vec((any::<proptest::sample::Index>(), 0..3u8, byte), 1..8).prop_map(move |edits| {
        let mut bytes = text.as_bytes().to_vec();
        for (at, what, byte) in edits {
            let i = at.index(bytes.len());
            match what {
                0 => bytes[i] = byte,
                1 => drop(bytes.remove(i)),
                _ => bytes.insert(i, byte),
            }
        }
        bytes
    })
}

#[test]
fn the_unchanged_files_load() {
    assert!(run("a.obj", OBJ.into()));
    assert!(run("m.mtl", MTL.into()));
    assert!(run("s.json", JSON.into()));
    assert!(run("o.json", OVER.into()));
    assert!(run("p.ply", PLY.into()));
    assert!(run("c.json", PG1.into()));
}

/// What the fuzz targets have found (`cargo xtask fuzz`).
#[test]
fn what_fuzzing_found_stays_mended() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fuzz/regressions");
    let paths = std::fs::read_dir(folder).unwrap().map(|e| e.unwrap().path());
    // Folders hold what targets of other crates have found.
    let mut names: Vec<PathBuf> = paths.filter(|p| p.is_file()).collect();
    names.sort();
    assert!(!names.is_empty());
    for path in names {
        let name = format!("s.{}", path.extension().unwrap().to_str().unwrap());
        run(&name, std::fs::read(&path).unwrap());
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 400, ..ProptestConfig::default() })]

    #[test]
    fn any_bytes(bytes in proptest::collection::vec(any::<u8>(), 0..400)) {
        run("a.obj", bytes.clone());
        run("s.json", bytes.clone());
        run("m.mtl", bytes.clone());
        for format in ["ascii", "binary_little_endian", "binary_big_endian"] {
            let (header, _) = PLY.split_at(PLY.find("0 0 0").unwrap());
            run("p.ply", [header.replace("ascii", format).as_bytes(), &bytes].concat());
        }
        for name in ["x", "x.tga", "x.data"] {
            let _ = super::images::decode(&bytes, name);
        }
    }

    #[test]
    fn any_words(words in proptest::collection::vec(proptest::sample::select(vec![
        "v", "vt", "vn", "f", "usemtl", "mtllib", "m.mtl", "red", "1", "-1", "2", "0", "1e12", "-1e12", "1/1/1",
        "1//1", "/", "\\\n", "\n", "\n", "\n", "#", "nan", ".", "-", "1e-40",
    ]), 0..120)) {
        run("a.obj", words.join(" ").into_bytes());
    }

    #[test]
    fn mutated_obj(bytes in mutated(OBJ)) {
        run("a.obj", bytes);
    }

    #[test]
    fn mutated_mtl(bytes in mutated(MTL)) {
        run("m.mtl", bytes);
    }

    #[test]
    fn mutated_ply(bytes in mutated(PLY)) {
        run("p.ply", bytes.clone());
        // The same numbers as bytes: nonsense, but of the right kind.
        let text = String::from_utf8_lossy(&bytes).replace("ascii", "binary_little_endian");
        run("p.ply", text.into_bytes());
    }

    #[test]
    fn mutated_pg1(bytes in mutated(PG1)) {
        run("c.json", bytes);
    }

    #[test]
    fn mutated_pictures(edits in proptest::collection::vec((any::<proptest::sample::Index>(), any::<u8>()), 1..6)) {
        let pictures = PICTURES.into_iter().map(|(name, bytes)| (name, bytes.to_vec()));
        for (name, mut bytes) in pictures.chain(exr_files().into_iter().map(|bytes| ("x.exr", bytes))) {
            for (at, byte) in &edits {
                *at.get_mut(&mut bytes) = *byte;
            }
            if let Ok(picture) = super::images::decode(&bytes, name) {
                assert_eq!(picture.texels.len() as u64, u64::from(picture.width) * u64::from(picture.height));
            }
        }
    }

    #[test]
    fn mutated_json(bytes in mutated(JSON)) {
        run("s.json", bytes);
    }

    #[test]
    fn mutated_scenes_over_a_base(bytes in mutated(OVER)) {
        run("o.json", bytes);
    }
}
