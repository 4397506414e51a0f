//! The awkward OBJ files of other projects, where they are at hand: triangles, vertices and bounds as the README of the
//! test scenes says, or one clear error.

use eosphor_scene::{LoadOptions, LoadedScene, MaterialKind, SceneData, SceneError, Triangle, load};
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

/// File, triangles, vertices, and the box of all vertices.
type Row = (&'static str, usize, usize, [f32; 3], [f32; 3]);

#[rustfmt::skip]
const LOADED: [Row; 37] = [
    ("assimp/box.obj", 12, 8, [-0.5, -0.5, -0.5], [0.5, 0.5, 0.5]),
    ("assimp/box_longline.obj", 944, 8, [-0.5, -0.5, -0.5], [0.5, 0.5, 0.5]),
    ("assimp/box_without_lineending.obj", 12, 8, [-0.5, -0.5, -0.5], [0.5, 0.5, 0.5]),
    ("assimp/concave_polygon.obj", 64, 64, [-1.146, 1.657, 1.605], [-1.146, 3.143, 3.091]),
    ("assimp/cube_mtllib_after_g.obj", 12, 8, [0.0, 0.0, 0.0], [1.0, 1.0, 1.0]),
    ("assimp/cube_usemtl.obj", 12, 8, [0.0, 0.0, 0.0], [1.0, 1.0, 1.0]),
    ("assimp/cube_with_vertexcolors.obj", 12, 8, [0.0, 0.0, 0.0], [1.0, 1.0, 1.0]),
    ("assimp/multiple_spaces.obj", 1, 4, [1.0, 1.0, 1.0], [3.0, 3.0, 3.0]),
    ("assimp/number_formats.obj", 1, 15, [-100.0, -20.0, -310.0], [10000000000.0, 20.0, 31000000000.0]),
    ("assimp/regr_3429812.obj", 4, 4, [0.04185, 0.9615, 0.09391], [0.04988, 0.9645, 0.09805]),
    ("assimp/spider.obj", 1_368, 762, [-92.66, -42.23, -106.7], [57.94, 37.5, 86.69]),
    ("assimp/testmixed.obj", 12, 8, [-0.5, -0.5, -0.5], [0.5, 0.5, 0.5]),
    ("tinyobjloader/catmark_torus_creases0.obj", 64, 32, [-1.251, -1.251, -0.3536], [1.251, 1.251, 0.3536]),
    ("tinyobjloader/cornell_box.obj", 36, 76, [0.0, 0.0, 0.0], [556.0, 548.8, 559.2]),
    ("tinyobjloader/cornell_box_multimaterial.obj", 36, 76, [0.0, 0.0, 0.0], [556.0, 548.8, 559.2]),
    ("tinyobjloader/cube-vertex-w-component.obj", 12, 8, [0.0, 0.0, 0.0], [2.0, 2.0, 2.0]),
    ("tinyobjloader/cube-vertexcol.obj", 12, 8, [0.0, 0.0, 0.0], [2.0, 2.0, 2.0]),
    ("tinyobjloader/invalid-face-definition.obj", 0, 8, [0.0, 0.0, 0.0], [2.0, 2.0, 2.0]),
    ("tinyobjloader/issue-161-inconsistent-f.obj", 12, 8, [-0.5, -0.5, -0.5], [0.5, 0.5, 0.5]),
    ("tinyobjloader/issue-248-texres-texopt.obj", 12, 8, [0.0, 0.0, 0.0], [2.0, 2.0, 2.0]),
    ("tinyobjloader/issue-295-trianguation-failure.obj", 28, 16, [14680.0, 0.0, 9605.0], [14680.0, 1.0, 9608.0]),
    ("tinyobjloader/issue-319-002.obj", 14, 20, [8211.0, 6376.0, 9.139], [8233.0, 6407.0, 55.85]),
    ("tinyobjloader/leading-decimal-dot-issue-201.obj", 1, 3, [0.08, -70.0, -5.533], [0.9404, 1.0, 5.896]),
    ("tinyobjloader/line-prim.obj", 0, 8, [0.0, 0.0, 0.0], [2.0, 2.0, 2.0]),
    ("tinyobjloader/missing_material_file.obj", 36, 76, [0.0, 0.0, 0.0], [556.0, 548.8, 559.2]),
    ("tinyobjloader/mtl filename with whitespace issue46.obj", 12, 8, [0.0, 0.0, 0.0], [2.0, 2.0, 2.0]),
    ("tinyobjloader/mtllib-multiple-files-issue-112.obj", 1, 3, [0.5759, -1.219, -5.533], [1.864, 1.0, 5.896]),
    ("tinyobjloader/no_material.obj", 36, 76, [0.0, 0.0, 0.0], [556.0, 548.8, 559.2]),
    ("tinyobjloader/pbr-mat-ext.obj", 2, 4, [0.0, 0.0, 0.0], [552.8, 0.0, 559.2]),
    ("tinyobjloader/points-prim.obj", 0, 8, [0.0, 0.0, 0.0], [2.0, 2.0, 2.0]),
    ("tinyobjloader/smoothing-normal.obj", 6, 8, [0.0, 0.0, 0.0], [2.0, 2.0, 2.0]),
    ("tinyobjloader/texture-options-issue-85.obj", 1, 3, [0.5759, -1.219, -5.533], [1.864, 1.0, 5.896]),
    ("tinyobjloader/usemtl-issue-68.obj", 400, 218, [-9.098, -1.462, -7.515], [9.098, 1.221, 5.896]),
    ("trimesh/nancolor.obj", 12, 8, [-0.5, -0.5, -0.5], [0.5, 0.5, 0.5]),
    ("trimesh/negative_indices.obj", 12, 8, [-1.0, -1.0, -1.0], [1.0, 1.0, 1.0]),
    ("trimesh/quadknot.obj", 2_880, 1_440, [-149.3, -66.86, -167.2], [21.44, 66.86, 14.09]),
    ("trimesh/wallhole.obj", 66, 92, [0.0, 0.0, -10.0], [10.0, 15.0, 0.0]),
];

/// Files that are wrong: file, line and what is said of it.
const WRONG: [(&str, u32, &str); 3] = [
    ("tinyobjloader/invalid-relative-vertex-index.obj", 1, "vertex index -4 is out of range; there are 0"),
    ("tinyobjloader/issue-140-zero-face-idx.obj", 16, "vertex index 0; indices count from 1"),
    ("tinyobjloader/test-nan.obj", 12, "\"nan\" is not a finite number; mend the file"),
];

/// The folder of the files, or `None` with a message: a clone of the repository does not hold it.
fn folder() -> Option<PathBuf> {
    crate::support::scenes().map(|scenes| scenes.join("obj-awkward"))
}

fn read(path: &Path) -> Result<LoadedScene, SceneError> {
    load(path, &LoadOptions::default())
}

fn read_good(file: &str) -> Option<LoadedScene> {
    Some(read(&folder()?.join(file)).unwrap_or_else(|e| panic!("{e}")))
}

/// What is said of a file, without the folder's name.
fn warnings(loaded: &LoadedScene) -> Vec<String> {
    let without_folder =
        |text: String| text.rsplit_once('/').map_or(text.clone(), |(_, rest)| rest.to_string());
    loaded.warnings.iter().map(|w| without_folder(w.to_string())).collect()
}

#[test]
fn the_tables_have_all_files() {
    let Some(folder) = folder() else { return };
    let mut there = BTreeSet::new();
    for source in ["assimp", "tinyobjloader", "trimesh"] {
        for entry in folder.join(source).read_dir().unwrap() {
            let name = entry.unwrap().file_name().into_string().unwrap();
            if name.ends_with(".obj") {
                there.insert(format!("{source}/{name}"));
            }
        }
    }
    let files = LOADED.iter().map(|row| row.0).chain(WRONG.iter().map(|row| row.0));
    assert_eq!(there, files.map(str::to_string).collect());
}

#[test]
fn awkward_files_have_their_triangles_vertices_and_bounds() {
    let Some(folder) = folder() else { return };
    for (file, triangles, vertices, min, max) in LOADED {
        let loaded = read(&folder.join(file)).unwrap_or_else(|e| panic!("{e}"));
        let mesh = &loaded.scene.meshes[0];
        assert_eq!((mesh.triangles.len(), mesh.positions.len()), (triangles, vertices), "{file}");
        for axis in 0..3 {
            // What lies far is counted from a point near it, and so may be its scene.
            let at = loaded.scene.origin[axis] + loaded.scene.instances[0].world_from_object.offset[axis];
            let placed = mesh.positions.iter().map(|p| (f64::from(p[axis]) + at) as f32);
            let of = |pick: fn(f32, f32) -> f32| placed.clone().reduce(pick).unwrap();
            // The README has four significant digits.
            let near = |a: f32, b: f32| (a - b).abs() <= 5.1e-4 * b.abs();
            let (low, high) = (of(f32::min), of(f32::max));
            assert!(near(low, min[axis]) && near(high, max[axis]), "{file}: axis {axis}: {low} {high}");
        }
        let (data, _) = SceneData::flatten(&loaded.scene).unwrap_or_else(|e| panic!("{file}: {e}"));
        assert_eq!(data.triangles.len(), triangles, "{file}");
    }
}

#[test]
fn wrong_files_are_told_by_file_and_line() {
    let Some(folder) = folder() else { return };
    for (file, line, message) in WRONG {
        let path = folder.join(file);
        assert_eq!(read(&path).unwrap_err().to_string(), format!("{}:{line}: {message}", path.display()));
    }
}

/// The area of triangles of a mesh.
fn area(loaded: &LoadedScene, triangles: &[Triangle]) -> f64 {
    let p = &loaded.scene.meshes[0].positions;
    let doubled = |t: &Triangle| {
        let [a, b, c] = t.positions.map(|i| p[i as usize]);
        f64::from((b - a).cross(c - a).length())
    };
    triangles.iter().map(doubled).sum::<f64>() / 2.0
}

#[test]
fn the_concave_polygon_is_covered_once() {
    let Some(loaded) = read_good("assimp/concave_polygon.obj") else { return };
    // A ring of 32 corners a side in the plane of y and z, with a bridge; its area by the shoelace formula.
    let path = folder().unwrap().join("assimp/concave_polygon.obj");
    let text = std::fs::read_to_string(path).unwrap();
    let face = text.lines().find(|line| line.starts_with("f ")).unwrap();
    let corners: Vec<[f64; 2]> = face
        .split_whitespace()
        .skip(1)
        .map(|word| {
            loaded.scene.meshes[0].positions[word.split('/').next().unwrap().parse::<usize>().unwrap() - 1]
        })
        .map(|p| [f64::from(p.y), f64::from(p.z)])
        .collect();
    assert_eq!(corners.len(), 66);
    let shoelace: f64 =
        (0..66).map(|i| (corners[i], corners[(i + 1) % 66])).map(|(a, b)| a[0] * b[1] - a[1] * b[0]).sum();
    let covered = area(&loaded, &loaded.scene.meshes[0].triangles);
    assert!((covered - shoelace.abs() / 2.0).abs() < 1e-5, "{covered} {}", shoelace / 2.0);
}

/// Areas of the polygons of issue-319-002.obj by Newell's formula.
const NEWELL: [f64; 3] = [3.0679, 14.9700, 1.5458];

#[test]
fn polygons_far_from_the_origin_are_covered() {
    let Some(loaded) = read_good("tinyobjloader/issue-319-002.obj") else { return };
    let t = &loaded.scene.meshes[0].triangles;
    for (triangles, expected) in [(&t[..5], NEWELL[0]), (&t[5..11], NEWELL[1]), (&t[11..], NEWELL[2])] {
        let covered = area(&loaded, triangles);
        assert!((covered - expected).abs() < 0.02 * expected, "{covered} {expected}");
    }
}

#[test]
fn malformed_numbers_are_read_as_far_as_they_go() {
    let Some(loaded) = read_good("assimp/number_formats.obj") else { return };
    let p = &loaded.scene.meshes[0].positions;
    assert_eq!(<[f32; 3]>::from(p[7]), [100.0, 20.0, 3.1]);
    assert_eq!(
        warnings(&loaded)[0],
        "number_formats.obj:11: stray characters after a number: \"3.1+e2\", read as 3.1"
    );
}

#[test]
fn vertex_colours_are_linear_and_show_on_white() {
    let Some(loaded) = read_good("assimp/cube_with_vertexcolors.obj") else { return };
    let mesh = &loaded.scene.meshes[0];
    assert_eq!(mesh.colors.len(), 8);
    // The code 0.48627 is byte 124, whose linear value is 0.20156.
    let [r, _, _, opacity] = mesh.colors[0];
    assert!((r - 0.201_56).abs() < 1e-4 && opacity == 1.0, "{r}");
    let material = &loaded.scene.materials[mesh.triangles[0].material as usize];
    assert_eq!(material.name, "vertex colors");
    assert!(matches!(material.kind, MaterialKind::Mtl(mtl) if <[f32; 3]>::from(mtl.Kd) == [1.0; 3]));

    let weights = read_good("tinyobjloader/cube-vertex-w-component.obj").unwrap();
    assert!(weights.scene.meshes[0].colors.is_empty());
    let nan = read_good("trimesh/nancolor.obj").unwrap();
    assert_eq!(nan.scene.meshes[0].colors[6], [1.0; 4]);
    assert_eq!(
        warnings(&nan),
        ["nancolor.obj:7: a vertex colour is not a finite number; the vertex is white"]
    );
}

#[test]
fn smoothing_groups_give_normals() {
    let Some(loaded) = read_good("tinyobjloader/smoothing-normal.obj") else { return };
    let mesh = &loaded.scene.meshes[0];
    let normal =
        |t: usize, corner: usize| <[f32; 3]>::from(mesh.normals[mesh.triangles[t].normals[corner] as usize]);
    let half = std::f32::consts::FRAC_1_SQRT_2;
    // The front (+z) and the bottom (-y) share a group and the vertices 2 and 3; the back (-z) is in no group.
    assert_eq!([normal(0, 0), normal(0, 1)], [[0.0, 0.0, 1.0], [0.0, -half, half]]);
    assert_eq!([normal(4, 0), normal(5, 2)], [[0.0, 0.0, -1.0]; 2]);
}

#[test]
fn pbr_keys_and_map_options_come_along() {
    let Some(loaded) = read_good("tinyobjloader/pbr-mat-ext.obj") else { return };
    let MaterialKind::Mtl(mtl) = loaded.scene.materials[0].kind else { panic!("no MTL material") };
    assert_eq!((mtl.Pr, mtl.Pm, mtl.Ps, mtl.anisor), (Some(0.2), Some(0.3), Some(0.4), Some(0.8)));
    let list = warnings(&loaded);
    assert!(list.contains(&"pbr-mat-ext.mtl:16: map_Ps is not rendered".to_string()), "{list:?}");
    assert!(
        list.contains(
            &"pbr-mat-ext.mtl:14: texture \"roughness.tex\" is missing; the surface goes without".to_string()
        ),
        "{list:?}"
    );
    let loaded = read_good("tinyobjloader/texture-options-issue-85.obj").unwrap();
    let list = warnings(&loaded);
    assert!(
        list.iter().any(|w| w.ends_with(
            "texture \"diffuse.jpg\" is missing; the surface is untextured (3 times in this file)"
        )),
        "{list:?}"
    );
    assert!(list.iter().any(|w| w.ends_with("map_bump is not rendered (3 times in this file)")), "{list:?}");
}

#[test]
fn faces_against_their_normals_are_turned() {
    let Some(loaded) = read_good("assimp/spider.obj") else { return };
    let note = "spider.obj: 4 faces turned round to face where their normals point".to_string();
    assert!(warnings(&loaded).contains(&note), "{:?}", warnings(&loaded));
    // Files with normals all of whose faces agree with them.
    for file in ["assimp/box.obj", "tinyobjloader/usemtl-issue-68.obj", "tinyobjloader/smoothing-normal.obj"]
    {
        let list = warnings(&read_good(file).unwrap());
        assert!(!list.iter().any(|w| w.contains("turned") || w.contains("negated")), "{list:?}");
    }
}
