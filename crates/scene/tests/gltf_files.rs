//! The glTF files among the standard test scenes, where they are at hand: every one of them, as their README says.

use crate::support::scenes;
use eosphor_scene::{LoadOptions, LoadedScene, SceneData, load};
use std::collections::BTreeSet;
use std::path::Path;

/// The row of a file: its triangles with every instance, its vertices with every accessor once, its box in the world.
type Row = (&'static str, usize, usize, [f64; 3], [f64; 3]);

#[rustfmt::skip]
const ROWS: [Row; 30] = [
    ("AlphaBlendModeTest.glb", 61, 137, [-4.3, -0.1, -0.75], [4.3, 2.3, 0.55]),
    ("AttenuationTest.glb", 292, 344, [-10.0, -10.0, -2.0], [10.0, 10.0, 2.0]),
    ("Avocado.gltf", 682, 406, [-0.02128, -4.774e-05, -0.01381], [0.02128, 0.06285, 0.01381]),
    ("BoomBox.glb", 6_036, 3_575, [-0.009921, -0.009772, -0.01008], [0.009921, 0.009772, 0.01008]),
    ("Box.glb", 12, 24, [-0.5, -0.5, -0.5], [0.5, 0.5, 0.5]),
    ("BoxInterleaved.glb", 12, 24, [-0.5, -0.5, -0.5], [0.5, 0.5, 0.5]),
    ("BoxTextured.glb", 12, 24, [-0.5, -0.5, -0.5], [0.5, 0.5, 0.5]),
    ("BoxVertexColors.glb", 12, 24, [0.0, 0.0, 0.0], [1.0, 1.0, 1.0]),
    ("Cameras.gltf", 2, 4, [0.0, 0.0, -0.7076], [1.0, 0.7066, 0.0]),
    ("ClearCoatTest.glb", 37_116, 1_185, [-7.358, -6.25, -0.06], [3.1, 6.855, 1.05]),
    ("Duck.glb", 4_212, 2_399, [-0.693, 0.09929, -0.6133], [0.9618, 1.64, 0.5393]),
    ("EmissiveStrengthTest.glb", 90, 188, [-8.003, -6.001, -2.0], [8.001, 4.009, 1.999]),
    ("FlightHelmet.gltf", 94_722, 55_392, [-0.2036, -2.142e-05, -0.1715], [0.1629, 0.716, 0.2]),
    // The README counts the points and lines of this file too (7 vertices, up to y = 4). Here are its list, strip and
    // fan: three meshes, each with the seven.
    ("MeshPrimitiveModes.gltf", 16, 21, [-2.866, -4.0, 0.0], [2.866, -2.0, 0.0]),
    ("MetalRoughSpheresNoTextures.glb", 1_040_409, 7_013, [-0.0009243, -0.00101, -0.00335], [0.006477, 0.006494, 0.00035]),
    ("MultiUVTest.glb", 12, 24, [-1.0, -1.0, -1.0], [1.0, 1.0, 1.0]),
    ("NormalTangentMirrorTest.glb", 5_240, 2_770, [-1.425, -1.2, -0.01], [1.414, 1.047, 0.0805]),
    ("NormalTangentTest.glb", 7_774, 3_983, [-1.11, -1.2, -0.01], [1.11, 0.95, 0.0805]),
    ("OrientationTest.glb", 524, 1_048, [-5.331, -5.331, -5.331], [5.331, 5.331, 5.331]),
    ("SimpleMeshes.gltf", 2, 3, [0.0, 0.0, 0.0], [2.0, 1.0, 0.0]),
    ("SpecularTest.glb", 44_828, 4_343, [-0.7508, -0.38, -0.05], [0.375, 0.38, 0.05]),
    ("Suzanne.gltf", 3_936, 11_808, [-1.337, -0.9746, -0.8008], [1.337, 0.9502, 0.8257]),
    ("TextureCoordinateTest.glb", 10, 20, [-1.2, -1.2, -0.05259], [1.2, 1.2, 5.255e-07]),
    ("TextureSettingsTest.glb", 72, 144, [-5.162, -5.619, -0.15], [5.162, 4.454, 0.1]),
    // Its four positions go with two sets of texture coordinates: two meshes.
    ("TextureTransformTest.gltf", 24, 8, [-1.6, -1.141, 0.0], [1.6, 1.05, 0.01]),
    ("TransmissionRoughnessTest.glb", 77_792, 7_930, [-1.0, -0.45, -0.15], [1.0, 0.45, 0.35]),
    ("TransmissionTest.glb", 128_775, 25_961, [-0.9764, -0.4, -0.521], [0.8262, 0.6205, 1.368]),
    ("TriangleWithoutIndices.gltf", 1, 3, [0.0, 0.0, 0.0], [1.0, 1.0, 0.0]),
    ("VertexColorTest.glb", 36, 72, [-1.0, -1.0, -0.01274], [1.0, 1.0, 0.06137]),
    ("WaterBottle.gltf", 4_510, 2_549, [-0.05445, -0.1302, -0.05445], [0.05445, 0.1302, 0.05445]),
];

const DRAGONS: Row = ("dragon-x12.glb", 10_456_970, 437_649, [-2.0, 0.0, -2.0], [2.0, 0.1444, 2.0]);

fn read(path: &Path) -> LoadedScene {
    let mut options = LoadOptions::default();
    options.textures = false;
    load(path, &options).unwrap_or_else(|e| panic!("{e}"))
}

/// Triangles that are placed.
fn triangles(loaded: &LoadedScene) -> usize {
    loaded.scene.instances.iter().map(|i| loaded.scene.meshes[i.mesh as usize].triangles.len()).sum()
}

/// Vertices of all meshes. Meshes share them as the files' accessors do.
fn vertices(loaded: &LoadedScene) -> usize {
    loaded.scene.meshes.iter().map(|mesh| mesh.positions.len()).sum()
}

/// The box of all placed vertices.
fn bounds(loaded: &LoadedScene) -> ([f64; 3], [f64; 3]) {
    let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
    for instance in &loaded.scene.instances {
        let map = instance.world_from_object.affine();
        for &p in &loaded.scene.meshes[instance.mesh as usize].positions {
            let p = map.point(p);
            for axis in 0..3 {
                low[axis] = low[axis].min(p[axis].into());
                high[axis] = high[axis].max(p[axis].into());
            }
        }
    }
    (low, high)
}

/// Equal to four digits, as the README gives them; zeros of its files are not always exact.
fn near(got: f64, want: f64, extent: f64) -> bool {
    (got - want).abs() <= 6e-4 * want.abs() + 1e-6 * extent
}

fn assert_row(loaded: &LoadedScene, &(file, triangle_count, vertex_count, min, max): &Row) {
    assert_eq!(triangles(loaded), triangle_count, "{file}: triangles");
    assert_eq!(vertices(loaded), vertex_count, "{file}: vertices");
    let (low, high) = bounds(loaded);
    for axis in 0..3 {
        let extent = max[axis] - min[axis];
        assert!(
            near(low[axis], min[axis], extent) && near(high[axis], max[axis], extent),
            "{file}: {low:?} {high:?} instead of {min:?} {max:?}"
        );
    }
}

#[test]
fn every_file_has_its_triangles_vertices_and_bounds() {
    let Some(folder) = scenes() else { return };
    let folder = folder.join("gltf");
    let found: BTreeSet<String> = std::fs::read_dir(&folder)
        .unwrap()
        .flat_map(|entry| std::fs::read_dir(entry.unwrap().path()).into_iter().flatten())
        .map(|file| file.unwrap().file_name().to_string_lossy().into_owned())
        .filter(|name| name.ends_with(".gltf") || name.ends_with(".glb"))
        .collect();
    let listed: BTreeSet<String> = ROWS.iter().map(|row| row.0.to_string()).collect();
    assert_eq!(found, listed, "the table and the folder differ");
    for row in &ROWS {
        let loaded = read(&folder.join(Path::new(row.0).file_stem().unwrap()).join(row.0));
        assert_row(&loaded, row);
        let (data, _) = SceneData::flatten(&loaded.scene).unwrap_or_else(|e| panic!("{}: {e}", row.0));
        for shading in &data.triangle_shading {
            assert!(shading.normals.iter().all(|n| (n.length() - 1.0).abs() < 1e-6), "{}", row.0);
        }
    }
}

#[test]
fn twelve_dragons_are_one_mesh() {
    let Some(folder) = scenes() else { return };
    let loaded = read(&folder.join("dragon-x12/dragon-x12.glb"));
    assert_row(&loaded, &DRAGONS);
    let scene = &loaded.scene;
    let mut sizes: Vec<usize> = scene.meshes.iter().map(|mesh| mesh.triangles.len()).collect();
    sizes.sort_unstable();
    assert_eq!(sizes, [2, 871_414]);
    assert_eq!(scene.instances.len(), 13);
    let materials: BTreeSet<u32> = (scene.instances.iter())
        .map(|i| i.material.unwrap_or(scene.meshes[i.mesh as usize].triangles[0].material))
        .collect();
    assert_eq!(materials.len(), 4, "three kinds of dragon and the ground");
}

#[test]
fn pictures_are_read_and_nothing_odd_is_said_of_common_files() {
    let Some(folder) = scenes() else { return };
    for (file, images, textures, warnings) in [
        ("FlightHelmet/FlightHelmet.gltf", 15, 15, 1),
        ("WaterBottle/WaterBottle.gltf", 4, 4, 2),
        ("BoxTextured/BoxTextured.glb", 1, 1, 0),
        ("MultiUVTest/MultiUVTest.glb", 2, 2, 1),
        ("TextureSettingsTest/TextureSettingsTest.glb", 3, 8, 0),
    ] {
        let loaded = load(folder.join("gltf").join(file), &LoadOptions::default()).unwrap();
        let found = (loaded.scene.images.len(), loaded.scene.textures.len(), loaded.warnings.len());
        assert_eq!(found, (images, textures, warnings), "{file}: {:?}", loaded.warnings);
    }
}

#[test]
fn the_arrow_of_the_transform_test_points_at_the_green_marker() {
    let Some(folder) = scenes() else { return };
    let path = folder.join("gltf/TextureTransformTest/TextureTransformTest.gltf");
    let scene = load(path, &LoadOptions::default()).unwrap().scene;
    // The arrow lies on the picture's diagonal from the upper left to (0.7, 0.7). The markers stand beside the quad
    // from -0.5 to 0.5 whose u runs right and whose v runs up.
    for (material, marker, tolerance) in
        [("Rotation", [-0.079_05, -0.516_27], 1e-3), ("All", [-0.07, -0.25], 0.05)]
    {
        let of_name = scene.materials.iter().find(|m| m.name == material).unwrap();
        let texture = scene.textures[of_name.textures.color.unwrap() as usize];
        let [u, v] = marker.map(|x: f32| x + 0.5);
        let [u, v] = texture.picture_from_mesh_uv.map(|row| row[0] * u + row[1] * v + row[2]);
        assert!((u - (1.0 - v)).abs() < tolerance, "{material}: ({u}, {v}) is off the diagonal");
    }
}
