//! Small files of every kind.

use crate::files::source::Source;
use crate::files::{LoadOptions, LoadedScene, load_from};
use crate::model::{AlphaMode, MaterialKind, Mesh, NO_INDEX};
use eosphor_core::math::{Vec3, vec3};
use std::borrow::Cow;
use std::path::{Path, PathBuf};

fn load_bytes(bytes: &[u8]) -> Result<LoadedScene, String> {
    let files = vec![
        (PathBuf::from("a.ply"), Cow::Owned(bytes.to_vec())),
        (PathBuf::from("my wood.ppm"), Cow::Borrowed(&b"P6\n1 1\n255\n\x01\x02\x03"[..])),
    ];
    load_from(Source::Memory(files), Path::new("a.ply"), &LoadOptions::default()).map_err(|e| e.to_string())
}

fn good(bytes: &[u8]) -> Mesh {
    let loaded = load_bytes(bytes).unwrap();
    assert!(loaded.warnings.is_empty(), "{:?}", loaded.warnings);
    loaded.scene.meshes[0].clone()
}

fn error(bytes: &[u8]) -> String {
    load_bytes(bytes).unwrap_err()
}

fn warnings(loaded: &LoadedScene) -> Vec<String> {
    loaded.warnings.iter().map(|w| w.to_string()).collect()
}

fn corners(mesh: &Mesh) -> Vec<[u32; 3]> {
    mesh.triangles.iter().map(|t| t.positions).collect()
}

const XYZ: &str = "property float x\nproperty float y\nproperty float z\n";
const FACE: &str = "property list uchar int vertex_indices\n";

/// A header of vertices and faces with these properties.
fn header(format: &str, vertices: (usize, &str), faces: (usize, &str)) -> String {
    let ((v, vp), (f, fp)) = (vertices, faces);
    format!("ply\nformat {format} 1.0\nelement vertex {v}\n{vp}element face {f}\n{fp}end_header\n")
}

fn ascii(vertices: (usize, &str), faces: (usize, &str), body: &str) -> Vec<u8> {
    (header("ascii", vertices, faces) + body).into_bytes()
}

#[test]
fn text_in_any_layout() {
    let text = "ply\r\nformat ascii 1.0\r\ncomment x\r\nobj_info y\r\nelement face 2\r\nproperty uchar flags\r\n\
                property list uint8 uint32 vertex_index\r\nelement edge 1\r\nproperty int vertex1\r\n\
                property list uchar float weights\r\nelement vertex 4\r\nproperty double z\r\n\
                property list uchar int more\r\nproperty float32 y\r\nproperty int16 x\r\nend_header\r\n\
                7 3 0 1 2\r\n\r\n  0  4  0 1 2 3 \r\n5 2 0.5 .5\r\n1 0 2 3\r\n1e1 2 8 9 2.5 -3\r\n+1 0 2 4\r\n1 0 2 5";
    let mesh = good(text.as_bytes());
    assert_eq!(
        mesh.positions,
        [vec3(3.0, 2.0, 1.0), vec3(-3.0, 2.5, 10.0), vec3(4.0, 2.0, 1.0), vec3(5.0, 2.0, 1.0)]
    );
    assert_eq!(corners(&mesh), [[0, 1, 2], [0, 1, 2], [0, 2, 3]]);
    assert_eq!(mesh.triangles[0].normals, [NO_INDEX; 3]);
    // CR alone, as on old Macs.
    let text = String::from_utf8(ascii((3, XYZ), (1, FACE), "0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n")).unwrap();
    assert_eq!(good(text.replace('\n', "\r").as_bytes()).triangles.len(), 1);
}

/// All types in both byte orders; the values fit the smallest.
#[test]
fn binary_types_and_byte_orders() {
    let types = [("char", 1), ("uint8", 1), ("short", 2), ("uint16", 2), ("int", 4), ("uint32", 4)];
    let floats = [("float32", 4), ("double", 8)];
    for (format, little) in [("binary_little_endian", true), ("binary_big_endian", false)] {
        let encode = |name: &str, x: i32| -> Vec<u8> {
            let mut bytes = match name {
                "float32" => (x as f32).to_le_bytes().to_vec(),
                "double" => f64::from(x).to_le_bytes().to_vec(),
                _ => {
                    let size = types.iter().find(|t| t.0 == name).unwrap().1;
                    x.to_le_bytes()[..size].to_vec()
                }
            };
            if !little {
                bytes.reverse();
            }
            bytes
        };
        for (position, _) in types.iter().chain(&floats) {
            for ((length, _), (item, _)) in types.iter().zip(types.iter().rev()) {
                let xyz = format!(
                    "property {position} x\nproperty {position} y\nproperty char c\nproperty {position} z\n"
                );
                let face = format!("property list {length} {item} vertex_indices\n");
                let mut file = header(format, (4, &xyz), (2, &face)).into_bytes();
                for p in [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 100]] {
                    for (k, x) in p.into_iter().enumerate() {
                        file.extend(if k == 2 { vec![10] } else { Vec::new() });
                        file.extend(encode(position, x));
                    }
                }
                for face in [&[4, 0, 1, 2, 3][..], &[3, 2, 1, 0]] {
                    file.extend(encode(length, face[0]));
                    face[1..].iter().for_each(|&i| file.extend(encode(item, i)));
                }
                let mesh = good(&file);
                assert_eq!(mesh.positions[3], vec3(0.0, 1.0, 100.0), "{format} {position}");
                assert_eq!(corners(&mesh), [[0, 1, 2], [0, 2, 3], [2, 1, 0]], "{format} {length} {item}");
            }
        }
    }
}

/// The fast way and the general one find the same.
#[test]
fn the_usual_layout_is_read_like_any_other() {
    let vertices = |file: &mut Vec<u8>| {
        for i in 0..5 {
            for x in [i as f32, 0.5, -1.0, 0.0, 0.0, 1.0] {
                file.extend(x.to_le_bytes());
            }
        }
    };
    let normals = format!("{XYZ}property float nx\nproperty float ny\nproperty float nz\n");
    let indices = |file: &mut Vec<u8>, list: &[i32]| list.iter().for_each(|i| file.extend(i.to_le_bytes()));
    let mut usual = header("binary_little_endian", (5, &normals), (2, FACE)).into_bytes();
    vertices(&mut usual);
    for face in [[0, 1, 2], [4, 3, 2]] {
        usual.push(3);
        indices(&mut usual, &face);
    }
    let mut mixed = header("binary_little_endian", (5, &normals), (2, FACE)).into_bytes();
    vertices(&mut mixed);
    mixed.push(4);
    indices(&mut mixed, &[0, 1, 2, 3]);
    mixed.push(3);
    indices(&mut mixed, &[4, 3, 2]);
    let (a, b) = (good(&usual), good(&mixed));
    assert_eq!(
        (corners(&a), corners(&b)),
        (vec![[0, 1, 2], [4, 3, 2]], vec![[0, 1, 2], [0, 2, 3], [4, 3, 2]])
    );
    assert_eq!((&a.positions, &a.normals), (&b.positions, &b.normals));
    assert_eq!(a.positions[4], vec3(4.0, 0.5, -1.0));
    assert_eq!((a.normals[1], a.triangles[1].normals), (vec3(0.0, 0.0, 1.0), [4, 3, 2]));
    // The last index is -1, then 5.
    let end = usual.len();
    usual[end - 4..].fill(255);
    assert_eq!(error(&usual), "a.ply: face 1: vertex index -1 is out of range");
    usual[end - 4..].copy_from_slice(&5i32.to_le_bytes());
    assert_eq!(error(&usual), "a.ply: face 1: vertex index 5 is out of range; there are 5 vertices");
    usual[end - 26 - 24..end - 26 - 20].copy_from_slice(&f32::NAN.to_le_bytes());
    assert!(
        error(&usual).starts_with("a.ply: vertex 4: (NaN, 0.5, -1) is no point; coordinates must be finite")
    );
}

#[test]
fn a_body_that_begins_with_a_newline_is_read_from_there() {
    let mut file = header("binary_little_endian", (3, XYZ), (1, FACE)).into_bytes();
    for bytes in [[0x0a, 0xf6, 0xbe, 0x40], [0; 4], [0; 4]].repeat(3) {
        file.extend(bytes);
    }
    file.extend([3, 0, 0, 0, 0, 1, 0, 0, 0, 2, 0, 0, 0]);
    assert!((good(&file).positions[0].x - 5.968).abs() < 1e-3);
}

#[test]
fn colors_become_linear() {
    let body = "0 0 0 255 0 188 255\n1 0 0 0 0 0 255\n0 1 0 0 0 0 255\n3 0 1 2\n";
    let rgba = |t: &str| {
        let colors = ["red", "green", "blue", "alpha"].map(|c| format!("property {t} {c}\n")).concat();
        format!("{XYZ}{colors}")
    };
    let loaded = load_bytes(&ascii((3, &rgba("uchar")), (1, FACE), body)).unwrap();
    let [r, g, b, a] = loaded.scene.meshes[0].colors[0];
    assert_eq!([r, g, a], [1.0, 0.0, 1.0]);
    assert!((b - 0.5029).abs() < 1e-4);
    let material = &loaded.scene.materials[0];
    assert_eq!((material.name.as_str(), material.alpha), ("vertex colors", AlphaMode::Opaque));
    assert!(matches!(material.kind, MaterialKind::Mtl(mtl) if mtl.Kd == Vec3::ONE && mtl.Ks == Vec3::ZERO));

    let body = "0 0 0 65535 0 48316 32768\n1 0 0 0 0 0 65535\n0 1 0 0 0 0 0\n3 0 1 2\n";
    let loaded = load_bytes(&ascii((3, &rgba("ushort")), (1, FACE), body)).unwrap();
    let [_, _, deep, a] = loaded.scene.meshes[0].colors[0];
    assert!((deep - b).abs() < 1e-6 && (a - 0.5).abs() < 1e-4, "48316 = 188 * 257");
    assert_eq!(loaded.scene.materials[0].alpha, AlphaMode::Blend);

    let diffuse =
        rgba("float").replace("float red", "float diffuse_red").replace("float green", "float diffuse_green");
    let diffuse = diffuse.replace("float blue", "float diffuse_blue");
    let body = "0 0 0 1 7 0.73725492 0\n1 0 0 0 0 0 0\n0 1 0 0 nan 0 0\n3 0 1 2\n";
    let loaded = load_bytes(&ascii((3, &diffuse), (1, FACE), body)).unwrap();
    let colors = &loaded.scene.meshes[0].colors;
    assert!(colors[0][..2] == [1.0, 1.0] && (colors[0][2] - b).abs() < 1e-6);
    assert_eq!((colors[2], loaded.scene.materials[0].alpha), ([1.0; 4], AlphaMode::Blend));
    assert_eq!(warnings(&loaded).len(), 1, "{:?}", loaded.warnings);

    let loaded = load_bytes(&ascii((3, &diffuse), (1, FACE), &body.replace("nan", "0"))).unwrap();
    assert_eq!(loaded.scene.materials[0].alpha, AlphaMode::Opaque);
    assert!(warnings(&loaded)[0].contains("wholly transparent (alpha 0); they are taken as opaque"));
}

#[test]
fn strips_turn_and_restart() {
    let strips = "ply\nformat ascii 1.0\nelement tristrips 1\nproperty list int int vertex_indices\nelement vertex 6\n";
    let body = "10 0 1 2 3 -1 2 4 5 5 3\n0 0 0\n1 0 0\n0 1 0\n1 1 0\n0 2 0\n1 2 0\n";
    let mesh = good(format!("{strips}{XYZ}end_header\n{body}").as_bytes());
    assert_eq!(corners(&mesh), [[0, 1, 2], [2, 1, 3], [2, 4, 5]]);
    let text = format!("{strips}{XYZ}end_header\n{}", body.replace(" -1 ", " 4294967295 "));
    assert_eq!(good(text.as_bytes()).triangles.len(), 3);
    let text = format!("{strips}{XYZ}end_header\n{}", body.replace(" -1 ", " 6 "));
    assert_eq!(
        error(text.as_bytes()),
        "a.ply:10: strip 0: vertex index 6 is out of range; there are 6 vertices"
    );
}

#[test]
fn texture_coordinates_and_pictures() {
    let st = format!("comment TextureFile my wood.ppm\n{XYZ}property float s\nproperty float t\n");
    let body = "0 0 0 0 0\n1 0 0 1 0\n0 1 0 nan 1\n3 2 1 0\n";
    let loaded = load_bytes(&ascii((3, &st), (1, FACE), body)).unwrap();
    let mesh = &loaded.scene.meshes[0];
    assert_eq!(
        (&mesh.uvs[..], mesh.triangles[0].uvs),
        (&[[0.0, 0.0], [1.0, 0.0], [0.0, 0.0]][..], [2, 1, 0])
    );
    let material = &loaded.scene.materials[mesh.triangles[0].material as usize];
    assert_eq!((material.name.as_str(), material.textures.color), ("my wood.ppm", Some(0)));
    assert!(warnings(&loaded)[0].contains("1 normals, colours or texture coordinates are not finite"));

    // Coordinates of corners, and two pictures, the second of which is missing.
    let wedge = format!("{FACE}property list uchar float texcoord\nproperty int texnumber\n");
    let xyz = format!("comment TextureFile my wood.ppm\ncomment TextureFile no.png\n{XYZ}");
    let body = "0 0 0\n1 0 0\n0 1 0\n1 1 0\n4 0 1 3 2 8 0 0 1 0 1 1 0 1 0\n3 0 1 2 6 0 0 .5 0 0 .5 1\n3 0 1 2 0 -1\n";
    let loaded = load_bytes(&ascii((4, &xyz), (3, &wedge), body)).unwrap();
    let mesh = &loaded.scene.meshes[0];
    let uvs: Vec<[u32; 3]> = mesh.triangles.iter().map(|t| t.uvs).collect();
    assert_eq!(uvs, [[0, 1, 2], [0, 2, 3], [4, 5, 6], [NO_INDEX; 3]]);
    assert_eq!((mesh.uvs.len(), mesh.uvs[5]), (7, [0.5, 0.0]));
    let names: Vec<&str> =
        mesh.triangles.iter().map(|t| loaded.scene.materials[t.material as usize].name.as_str()).collect();
    assert_eq!(names, ["my wood.ppm", "my wood.ppm", "default", "my wood.ppm"]);
    assert_eq!(warnings(&loaded), ["a.ply:5: texture \"no.png\" is missing; the surface is untextured"]);
}

#[test]
fn many_lines_are_read_side_by_side_in_order() {
    // Several chunks of text, with a blank line now and then; the elements change in the middle of one.
    let count = 60_000;
    let mut body = String::new();
    for i in 0..count {
        body += &format!("{i} 0.25 {}\n", i % 7);
        if i % 10_000 == 5 {
            body += " \n\n";
        }
    }
    for i in 2..count {
        body += &format!("3 {} {} {i} 6 0 0 1 0 1 {}\n", i - 2, i - 1, i % 5);
    }
    let face = format!("{FACE}property list uchar float texcoord\n");
    let mesh = good(&ascii((count, XYZ), (count - 2, &face), &body));
    assert!(mesh.positions.iter().enumerate().all(|(i, p)| *p == vec3(i as f32, 0.25, (i % 7) as f32)));
    assert!(mesh.triangles.iter().zip(0u32..).all(|(t, i)| t.positions == [i, i + 1, i + 2]));
    assert!(mesh.triangles.iter().zip(0u32..).all(|(t, i)| t.uvs == [3 * i, 3 * i + 1, 3 * i + 2]));
    assert!((2..count).all(|i| mesh.uvs[3 * (i - 2) + 2] == [1.0, (i % 5) as f32]));
    // The first wrong line counts, whatever is read first: 10 lines of header, 12 blank ones, the vertices.
    let wrong = body.replace("3 39998 39999 40000 6", "3 39998 x 40000 6").replace("3 59000", "3 y");
    assert_eq!(
        error(&ascii((count, XYZ), (count - 2, &face), &wrong)),
        format!("a.ply:{}: face 39998: \"x\" is not a whole number", 10 + 12 + count + 39_999)
    );
}

#[test]
fn errors_of_headers_say_line_and_remedy() {
    for (text, expected) in [
        ("plx\n", "a.ply: this is no PLY file: it does not start with the line \"ply\""),
        ("ply\nformat ascii 1.0\n", "a.ply: the header does not end: the line \"end_header\" is missing"),
        ("ply\nelement vertex 1\nend_header\n", "a.ply: the header has no \"format\"; it needs ascii, "),
        (
            "ply\nformat asci 1.0\n",
            "a.ply:2: unknown format \"asci\"; there are ascii, binary_little_endian and",
        ),
        ("ply\nproperty float x\n", "a.ply:2: a property before the first element"),
        ("ply\nelement vertex -1\n", "a.ply:2: \"-1\" is no count; write: element NAME COUNT"),
        (
            "ply\nelement vertex 99999999999\n",
            "a.ply:2: 99999999999 vertices are too many; the limit is 2^32 - 2",
        ),
        ("ply\nelement vertex 1\nelement vertex 1\n", "a.ply:3: a second element \"vertex\""),
        (
            "ply\nelement vertex 1\nproperty int64 x\n",
            "a.ply:3: unknown type \"int64\"; there are char, uchar, ",
        ),
        (
            "ply\nelement vertex 1\nproperty list uchar\n",
            "a.ply:3: unknown type \"\"; there are char, uchar, ",
        ),
        (
            "ply\nelement vertex 1\nproperty list float int a\n",
            "a.ply:3: the length of a list must be a whole number",
        ),
        (
            "ply\nelement vertex 1\nproperty float\n",
            "a.ply:3: a property without a name; write: property TYPE NAME",
        ),
        (
            "ply\nformat ascii 1.0\nend_header\n",
            "a.ply: there is no element \"vertex\" with the properties x, y and z",
        ),
    ] {
        let message = error(text.as_bytes());
        assert!(message.starts_with(expected), "{message}");
    }
    let long = |line: &str, n: usize| error(format!("ply\n{}", line.repeat(n)).as_bytes());
    assert_eq!(
        long("comment ................\n", 50_000),
        "a.ply: the header is longer than 1 MiB; is this a PLY file?"
    );
    assert_eq!(long("element e 1\n", 1000), "a.ply:258: more than 256 elements are too many");
    assert_eq!(
        long("element e 1\nproperty int i\nproperty int i\n", 100).len(),
        long("element e 1\n", 1).len()
    );
    let many = format!("element e 1\n{}", "property int i\n".repeat(5000));
    assert_eq!(long(&many, 1), "a.ply:4099: more than 4096 properties are too many");
}

#[test]
fn errors_of_text_say_the_line() {
    let four = "0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";
    for (from, to, expected) in [
        ("1 0 0", "1 0", "a.ply:11: vertex 1: the line ends too early: numbers are missing"),
        ("1 0 0", "1 a.b 0", "a.ply:11: vertex 1: \"a.b\" is not a number"),
        (
            "1 0 0",
            "1 inf 0",
            "a.ply:11: vertex 1: (1, inf, 0) is no point; coordinates must be finite numbers",
        ),
        (
            "1 0 0",
            "1e13 1 0",
            "a.ply:11: vertex 1: (1e13, 1e0, 0e0) is out of range; coordinates must be within 1e12",
        ),
        ("3 0 1 2", "3 0 1 3", "a.ply:13: face 0: vertex index 3 is out of range; there are 3 vertices"),
        ("3 0 1 2", "3 0 1 -1", "a.ply:13: face 0: vertex index -1 is out of range"),
        ("3 0 1 2", "-3 0 1 2", "a.ply:13: face 0: a list of -3 numbers cannot be"),
        ("3 0 1 2", "4000000000 0 1 2", "a.ply:13: face 0: the line ends too early"),
        ("3 0 1 2", "3 0 1 1.5", "a.ply:13: face 0: \"1.5\" is not a whole number"),
        (
            "3 0 1 2\n",
            "",
            "a.ply:12: the file ends before face 0 of 1; it is cut short, or its header is wrong",
        ),
    ] {
        let message = error(&ascii((3, XYZ), (1, FACE), &four.replace(from, to)));
        assert!(message.starts_with(expected), "{message}");
    }
    let loaded =
        load_bytes(&ascii((3, XYZ), (1, FACE), &(four.replace("1 0 0", "1 0 0 5") + "more\n"))).unwrap();
    assert_eq!(
        warnings(&loaded),
        ["a.ply: 1 lines have more numbers than the header says; the rest of them is left out"]
    );
}

#[test]
fn what_the_bytes_cannot_hold_is_refused_before_it_is_allocated() {
    let huge = header("binary_little_endian", (4_000_000_000, XYZ), (0, FACE));
    assert_eq!(
        error(huge.as_bytes()),
        "a.ply: the header promises 4000000000 rows \"vertex\" of at least 12 bytes, but 0 bytes are left: the file is \
         cut short, or its header is wrong"
    );
    let huge = header("ascii", (4_000_000_000, XYZ), (0, FACE)) + "0 0 0\n";
    assert!(error(huge.as_bytes()).starts_with("a.ply:10: the file ends before vertex 1 of 4000000000;"));
    // A list that is longer than the file.
    let list = "property list int int vertex_indices\n";
    let mut file = header("binary_little_endian", (1, XYZ), (1, list)).into_bytes();
    file.extend([0; 12]);
    file.extend(i32::MAX.to_le_bytes());
    file.extend([0; 8]);
    assert_eq!(
        error(&file),
        "a.ply: face 0: the file ends within it; it is cut short, or its header is wrong"
    );
    // Rows without properties take no bytes: any number of them is none.
    let nothing =
        format!("ply\nformat ascii 1.0\nelement x {}\nelement vertex 1\n{XYZ}end_header\n0 0 0\n", u64::MAX);
    assert_eq!(load_bytes(nothing.as_bytes()).unwrap().scene.meshes[0].positions.len(), 1);
}

#[test]
fn odd_faces_and_points_load_with_a_warning() {
    let loaded = load_bytes(&ascii((3, XYZ), (2, FACE), "0 0 0\n1 0 0\n0 1 0\n2 0 1\n0\n")).unwrap();
    assert_eq!(
        warnings(&loaded),
        [
            "a.ply: 2 faces with fewer than 3 corners are left out",
            "a.ply: there is nothing to see: no face has 3 corners in a list \"vertex_indices\"",
        ]
    );
    let points = format!("ply\nformat ascii 1.1\nMade by me\nelement vertex 1\n{XYZ}end_header\n0 0 0\n");
    assert_eq!(
        warnings(&load_bytes(points.as_bytes()).unwrap()),
        [
            "a.ply:2: version \"1.1\" of PLY is read as 1.0",
            "a.ply:3: unknown header line \"Made by me\"; passed over",
            "a.ply: there is nothing to see: the file has points without faces",
        ]
    );
}
