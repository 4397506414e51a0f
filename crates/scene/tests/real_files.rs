//! The standard test scenes, where they are at hand: triangles and bounds as their README says.

use crate::support::scenes;
use eosphor_scene::{LoadOptions, LoadedScene, Preset, SceneData, SceneError, load};

fn read(path: &std::path::Path) -> Result<LoadedScene, SceneError> {
    load(path, &LoadOptions::default())
}

/// The box of all vertices, used or not, as the README counts it.
fn bounds(loaded: &LoadedScene) -> ([f32; 3], [f32; 3]) {
    let p = &loaded.scene.meshes[0].positions;
    let of = |pick: fn(f32, f32) -> f32, start: f32| {
        [0, 1, 2].map(|axis| p.iter().map(|v| v[axis]).fold(start, pick))
    };
    (of(f32::min, f32::INFINITY), of(f32::max, f32::NEG_INFINITY))
}

#[test]
fn standard_scenes_have_their_triangles_and_bounds() {
    let Some(folder) = scenes() else { return };
    for (file, triangles, vertices, min, max) in [
        ("bunny/bunny-watertight.obj", 69_666, 34_835, [-1.075, -0.009476, -0.8334], [1.075, 2.122, 0.8334]),
        ("conference/conference.obj", 331_179, 194_399, [-1020.0, -2.792, -1056.0], [1686.0, 650.3, 668.5]),
        ("cornell-box/CornellBox-Original.obj", 36, 72, [-1.02, 0.0, -1.04], [1.0, 1.99, 0.99]),
        ("cornell-box/CornellBox-Mirror.obj", 36, 72, [-1.02, 0.0, -1.04], [1.0, 1.99, 0.99]),
        ("cornell-box/CornellBox-Glossy.obj", 1_112, 578, [-1.02, -0.0001, -1.04], [1.0, 1.59, 0.99]),
        ("cornell-box/CornellBox-Sphere.obj", 2_188, 1_116, [-1.02, 0.0, -1.04], [1.0, 1.59, 0.99]),
        ("cornell-box-pg1/CornellBox-Sphere.obj", 2_188, 1_116, [-1.02, 0.0, -1.04], [1.0, 2.0, 0.99]),
        ("spot/spot.obj", 5_856, 2_930, [-0.4716, -0.7368, -0.6689], [0.4716, 0.9536, 1.049]),
        ("spot/spot_quadrangulated.obj", 5_856, 2_930, [-0.4716, -0.7368, -0.6689], [0.4716, 0.9536, 1.049]),
        ("sponza-dabrovic/sponza.obj", 66_450, 60_848, [-17.4, -0.9067, -7.799], [17.42, 15.65, 7.801]),
        ("suzanne/suzanne.obj", 968, 507, [-1.367, -0.9844, -0.8516], [1.367, 0.9844, 0.8516]),
        ("suzanne/suzanne-quads.obj", 968, 507, [-3.861, 0.2673, 3.252], [-1.127, 2.236, 4.955]),
        ("teapot/teapot.obj", 6_320, 3_644, [-3.0, 0.0, -2.0], [3.434, 3.15, 2.0]),
    ] {
        let loaded = read(&folder.join(file)).unwrap_or_else(|e| panic!("{e}"));
        let mesh = &loaded.scene.meshes[0];
        assert_eq!((mesh.triangles.len(), mesh.positions.len()), (triangles, vertices), "{file}");
        let (low, high) = bounds(&loaded);
        for axis in 0..3 {
            let near = |a: f32, b: f32| (a - b).abs() <= 1e-3 * b.abs().max(0.01);
            assert!(near(low[axis], min[axis]) && near(high[axis], max[axis]), "{file}: {low:?} {high:?}");
        }
        let (data, _) = SceneData::flatten(&loaded.scene).unwrap_or_else(|e| panic!("{file}: {e}"));
        assert_eq!(data.triangles.len(), triangles, "{file}");
        for shading in &data.triangle_shading {
            assert!(shading.normals.iter().all(|n| (n.length() - 1.0).abs() < 1e-6), "{file}: {shading:?}");
        }
    }
}

#[test]
fn the_scene_of_pg1_is_lit_by_two_triangles_through_its_stray_dot() {
    let Some(folder) = scenes() else { return };
    let mut loaded = read(&folder.join("cornell-box-pg1/CornellBox-Sphere.obj")).unwrap();
    let warnings: Vec<String> = loaded.warnings.iter().map(|w| w.to_string()).collect();
    assert_eq!(warnings.len(), 1, "{warnings:?}");
    assert!(warnings[0].ends_with(
        "CornellBox-Sphere.obj:5753: stray characters after a number: \"-0.2200.\", read as -0.22"
    ));
    Preset::Pg1.apply(&mut loaded.scene);
    let (data, notes) = SceneData::flatten(&loaded.scene).unwrap();
    assert!(notes.is_empty(), "{notes:?}");
    let samples: Vec<u32> = data.lights.iter().map(|l| l.samples()).collect();
    assert_eq!(samples, [50, 50]);
    let number = |name: &str| loaded.scene.materials.iter().position(|m| m.name == name).unwrap();
    let material = |name: &str| data.materials[number(name)];
    assert_eq!(<[f32; 3]>::from(material("light").transmission), [0.0; 3], "Tf alone is no glass");
    assert_eq!(<[f32; 3]>::from(material("leftWall").reflection), [0.5; 3]);
    assert_eq!(<[f32; 3]>::from(material("rightSphere").transmission), [1.0; 3]);
    assert_eq!(material("rightSphere").ior, 1.6);
}

#[test]
fn textures_come_along() {
    let Some(folder) = scenes() else { return };
    let loaded = read(&folder.join("spot/spot.obj")).unwrap();
    assert!(loaded.warnings.is_empty(), "{:?}", loaded.warnings);
    let image = &loaded.scene.images[0];
    assert_eq!((image.width, image.height, image.texels.len()), (1024, 1024, 1024 * 1024));
    assert_eq!(loaded.scene.materials[0].textures.color, Some(0));
    let names: Vec<String> =
        loaded.files_read.iter().map(|p| p.file_name().unwrap().to_string_lossy().into_owned()).collect();
    assert_eq!(names, ["spot.obj", "spot.mtl", "spot_texture.png"]);
    let spider = read(&folder.join("obj-awkward/assimp/spider.obj")).unwrap();
    assert_eq!(spider.scene.textures.len(), 5, "{:?}", spider.warnings);
}
