//! The PLY files among the standard test scenes, where they are at hand: as their README says.

use crate::support::scenes;
use eosphor_scene::{AlphaMode, LoadOptions, LoadedScene, NO_INDEX, SceneData, load};
use std::collections::BTreeSet;
use std::path::Path;

fn read(path: &Path) -> LoadedScene {
    load(path, &LoadOptions::default()).unwrap_or_else(|e| panic!("{e}"))
}

/// One line of the README, and how many warnings the file deserves.
type Row = (&'static str, usize, usize, [f32; 3], [f32; 3], usize);

const FILES: &[Row] = &[
    ("bunny/bun_zipper.ply", 69_451, 35_947, [-0.09469, 0.03299, -0.06187], [0.06101, 0.1873, 0.0588], 0),
    ("bunny/bunny-binary.ply", 69_451, 35_947, [-0.09469, 0.03299, -0.06187], [0.06101, 0.1873, 0.0588], 0),
    ("dragon/dragon_vrip.ply", 871_414, 437_645, [-0.1083, 0.05273, -0.05041], [0.09657, 0.1972, 0.04121], 0),
    (
        "dragon/dragon_vrip_res3.ply",
        47_794,
        22_998,
        [-0.1077, 0.05277, -0.05005],
        [0.09598, 0.1966, 0.04083],
        0,
    ),
    (
        "dragon/dragon_vrip_res4.ply",
        11_102,
        5_205,
        [-0.1076, 0.05284, -0.04984],
        [0.09524, 0.1963, 0.04083],
        0,
    ),
    // Blender's line without the word "comment".
    ("ply/Wuson.ply", 3_732, 11_184, [-0.46, -0.000566, -1.622], [0.46, 1.515, 1.622], 1),
    ("ply/cube.ply", 12, 8, [0.0; 3], [1.0; 3], 0),
    ("ply/cube_binary.ply", 12, 8, [0.0; 3], [1.0; 3], 0),
    ("ply/cube_binary_starts_with_nl.ply", 12, 8, [5.968, 0.0, 0.0], [6.968, 1.0, 1.0], 0),
    ("ply/cube_uv.ply", 12, 24, [-1.0; 3], [1.0; 3], 0),
    ("ply/float-color.ply", 1, 3, [0.0; 3], [200.0, 200.0, 0.0], 0),
    ("ply/greg_turk_example1_ok_ascii.ply", 12, 8, [0.0; 3], [1.0; 3], 0),
    ("ply/greg_turk_example2_ok_ascii.ply", 12, 8, [0.0; 3], [1.0; 3], 0),
    ("ply/house_2_ok_little_endian.ply", 3, 5, [-1.0, -1.0, 0.0], [1.0, 2.0, 0.0], 0),
    ("ply/house_ok_ascii.ply", 3, 5, [-1.0, -1.0, 0.0], [1.0, 2.0, 0.0], 0),
    // Points without faces.
    ("ply/points.ply", 0, 4, [0.0; 3], [0.0, 1.0, 1.0], 1),
];

/// Four significant digits.
fn same(a: f32, b: f32) -> bool {
    format!("{a:.3e}") == format!("{b:.3e}")
}

#[test]
fn every_file_has_its_triangles_vertices_and_bounds() {
    let Some(folder) = scenes() else { return };
    for &(file, triangles, vertices, min, max, warnings) in FILES {
        let loaded = read(&folder.join(file));
        let mesh = &loaded.scene.meshes[0];
        assert_eq!((mesh.triangles.len(), mesh.positions.len()), (triangles, vertices), "{file}");
        assert_eq!(loaded.warnings.len(), warnings, "{file}: {:?}", loaded.warnings);
        for axis in 0..3 {
            let of =
                |pick: fn(f32, f32) -> f32, start| mesh.positions.iter().map(|p| p[axis]).fold(start, pick);
            let (low, high) = (of(f32::min, f32::INFINITY), of(f32::max, f32::NEG_INFINITY));
            assert!(same(low, min[axis]) && same(high, max[axis]), "{file}, axis {axis}: {low} {high}");
        }
        let (data, _) = SceneData::flatten(&loaded.scene).unwrap_or_else(|e| panic!("{file}: {e}"));
        assert_eq!(data.triangles.len(), triangles, "{file}");
    }
}

#[test]
fn the_table_above_is_whole() {
    let Some(folder) = scenes() else { return };
    let mut there = BTreeSet::new();
    for name in ["bunny", "dragon", "ply"] {
        for entry in std::fs::read_dir(folder.join(name)).unwrap() {
            let file = entry.unwrap().file_name().into_string().unwrap();
            if file.ends_with(".ply") {
                there.insert(format!("{name}/{file}"));
            }
        }
    }
    assert_eq!(there, FILES.iter().map(|row| row.0.to_string()).collect());
}

#[test]
fn the_bunny_is_the_same_in_text_and_bytes() {
    let Some(folder) = scenes() else { return };
    let [text, bytes] = ["bun_zipper.ply", "bunny-binary.ply"].map(|f| read(&folder.join("bunny").join(f)));
    let (a, b) = (&text.scene.meshes[0], &bytes.scene.meshes[0]);
    assert_eq!(a.positions, b.positions);
    assert_eq!(a.triangles, b.triangles);
}

#[test]
fn colors_normals_and_texture_coordinates_are_read() {
    let Some(folder) = scenes() else { return };
    let read = |file: &str| read(&folder.join("ply").join(file));
    let cube = read("greg_turk_example2_ok_ascii.ply").scene;
    assert_eq!(cube.meshes[0].colors[0], [1.0, 0.0, 0.0, 1.0]);
    assert_eq!(cube.meshes[0].colors[7], [0.0, 0.0, 1.0, 1.0]);
    assert_eq!(
        (cube.materials[0].name.as_str(), cube.materials[0].alpha),
        ("vertex colors", AlphaMode::Opaque)
    );
    assert_eq!(read("float-color.ply").scene.meshes[0].colors, [[0.0, 0.0, 1.0, 1.0]; 3]);

    let wuson = read("Wuson.ply");
    assert!(wuson.warnings[0].to_string().contains(
        "Wuson.ply:3: unknown header line \"Created by Blender3D 247 - www.blender.org, source file:\"; passed over"
    ));
    let mesh = &wuson.scene.meshes[0];
    assert_eq!((mesh.uvs[0], mesh.triangles[1].uvs), ([0.68118, 0.275_678], [3, 4, 5]));
    assert_eq!((mesh.normals[0].x, mesh.triangles[1].normals), (0.241_919, [3, 4, 5]));

    let points = read("points.ply");
    assert!(points.warnings[0].to_string().ends_with("the file has points without faces"));
    let house = &read("house_2_ok_little_endian.ply").scene.meshes[0];
    assert_eq!((house.triangles[0].normals, house.triangles[0].uvs), ([NO_INDEX; 3], [NO_INDEX; 3]));
}
