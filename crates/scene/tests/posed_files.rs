//! Skins and morph targets of the standard test scenes, against what `data/posed/posed.py` makes of them with numpy.

use crate::support::scenes;
use eosphor_core::math::{Vec3, vec3};
use eosphor_scene::{FrameState, FrameStates, LoadOptions, SceneData, load};
use std::collections::HashMap;

/// Positions and unit normals of the corners of a triangle, in the world.
type Corners = [(Vec3, Vec3); 3];

/// A triangle of a frame by its number, counted from instance to instance.
fn triangle(data: &SceneData, state: &FrameState, number: usize) -> Corners {
    let shapes = state.shapes.as_ref().expect("vertices that move");
    let mut left = number as u32;
    for instance in &state.places.as_ref().unwrap().instances[1..] {
        let geometry = &shapes.geometries[instance.geometry as usize - data.first_deforming()];
        if left >= geometry.triangle_count {
            left -= geometry.triangle_count;
            continue;
        }
        let at = (geometry.first_triangle + left) as usize - (data.triangles.len() - shapes.triangles.len());
        let normals = shapes.triangle_shading[at].normals;
        return [0, 1, 2].map(|corner| {
            let p = instance.world_from_object.point(shapes.triangles[at][corner]);
            (p, instance.object_from_world.transposed_direction(normals[corner]).normalize_or(Vec3::ZERO))
        });
    }
    panic!("triangle {number} is not there");
}

/// The largest difference of positions and of normals; triangles begin at any corner.
fn difference(a: &Corners, b: &Corners) -> (f32, f32) {
    let turned = |first: usize| {
        let pairs = (0..3).map(|k| (a[(first + k) % 3], b[k]));
        pairs.fold((0.0f32, 0.0f32), |most, (a, b)| {
            (most.0.max((a.0 - b.0).length()), most.1.max((a.1 - b.1).length()))
        })
    };
    (0..3).map(turned).min_by(|a, b| (a.0 + a.1).total_cmp(&(b.0 + b.1))).expect("three ways")
}

#[test]
fn vertices_are_where_an_independent_program_puts_them() {
    let Some(folder) = scenes() else { return };
    let lines: Vec<Vec<&str>> =
        include_str!("data/posed/posed.txt").lines().map(|line| line.split(' ').collect()).collect();
    let number = |word: &str| word.parse::<f32>().unwrap();
    let sizes: HashMap<&str, f32> =
        lines.iter().filter(|line| line[1] == "size").map(|line| (line[0], number(line[2]))).collect();
    assert_eq!(sizes.len(), 5);
    for (name, size) in sizes {
        let path = folder.join(format!("gltf-materials-motion/{name}/{name}.glb"));
        let mut options = LoadOptions::default();
        options.textures = false;
        let loaded = load(&path, &options).unwrap_or_else(|e| panic!("{e}"));
        let said: Vec<String> = loaded.warnings.iter().map(|w| w.to_string()).collect();
        assert!(!said.iter().any(|w| w.contains(" skin") || w.contains("left out")), "{said:?}");
        let (data, _) = SceneData::flatten(&loaded.scene).unwrap_or_else(|e| panic!("{e}"));
        let states = FrameStates::new(&loaded.scene, &data);
        let (mut frames, mut worst) = (HashMap::new(), (0.0f32, 0.0f32));
        for line in lines.iter().filter(|line| line[0] == name && line[1] != "size") {
            let frame: u32 = line[1].parse().unwrap();
            let state = frames.entry(frame).or_insert_with(|| states.at(frame).unwrap());
            let numbers: Vec<f32> = line[3..].iter().map(|word| number(word)).collect();
            let vector = |at: usize| vec3(numbers[at], numbers[at + 1], numbers[at + 2]);
            let expected = [0, 1, 2].map(|k| (vector(3 * k), vector(9 + 3 * k).normalize_or(Vec3::ZERO)));
            let (places, normals) = difference(&triangle(&data, state, line[2].parse().unwrap()), &expected);
            worst = (worst.0.max(places / size), worst.1.max(normals));
            assert!(
                places <= 1e-5 * size && normals <= 1e-4,
                "{name}, frame {frame}, triangle {}: {places} {normals}",
                line[2]
            );
        }
        assert!(frames.len() == 4);
        println!("{name}: positions within {:.1e} of the size, normals within {:.1e}", worst.0, worst.1);
    }
}
