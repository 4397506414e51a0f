//! Skins and morph targets: frames in which vertices of meshes are elsewhere.

use eosphor_core::math::Vec3;
use eosphor_core::settings::Integrator;
use eosphor_render::{Accel, Backend, Bands, CpuBackend, CpuOptions, Film, PixelFeatures, RenderControl};
use eosphor_scene::{FrameStates, LoadOptions, Scene, SceneData, load};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

const SIZE: [u32; 2] = [53, 37];

/// A stem that bends, a bud on it that opens and shines, and ground that stays.
fn reed() -> Scene {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../scenes/reed.glb");
    let mut scene = load(path, &LoadOptions::default()).unwrap().scene;
    (scene.settings.size, scene.settings.samples) = (SIZE, 2);
    scene
}

/// Frames in which vertices of meshes are elsewhere are the same in every structure and way, alone and one after the other, in any
/// order, and in parts.
#[test]
fn frames_of_moving_vertices() {
    for integrator in [Integrator::Whitted, Integrator::Path] {
        let mut scene = reed();
        scene.settings.integrator = integrator;
        let data = Arc::new(SceneData::flatten(&scene).unwrap().0);
        assert_eq!((data.deforming_geometries, data.geometries.len()), (2, 3));
        let states = FrameStates::new(&scene, &data);
        let base = CpuOptions { threads: Some(2), ..CpuOptions::default() };
        let options: Vec<CpuOptions> = Accel::ALL.iter().map(|&accel| CpuOptions { accel, ..base }).collect();
        let prepare = |&options: &CpuOptions| {
            let backend = CpuBackend::new(options).unwrap();
            let features = backend.feature_pass(Arc::clone(&data), None).unwrap();
            (backend.prepare(Arc::clone(&data)).unwrap(), features)
        };
        let prepared: Vec<_> = options.iter().map(prepare).collect();
        let (on_progress, cancel) = (&|_| {}, &AtomicBool::new(false));
        let mut pictures = Vec::new();
        for frame in [31, 0, 12, 31] {
            let state = states.at(frame).unwrap();
            let control = |count_work| RenderControl { on_progress, cancel, count_work, frame: Some(&state) };
            // One that has rendered nothing else, without a structure.
            let (alone, features) = prepare(&options[0]);
            let expected = alone.render(&control(false)).unwrap().film;
            let features = features.rows(0..SIZE[1], Some(&state), cancel).unwrap().pixels;
            for ((prepared, pass), options) in prepared.iter().zip(&options) {
                for count_work in [false, true] {
                    let found = prepared.render(&control(count_work)).unwrap().film;
                    assert!(found == expected, "frame {frame}, {}, counting: {count_work}", options.accel);
                }
                let found = pass.rows(0..SIZE[1], Some(&state), cancel).unwrap().pixels;
                assert!(bits(&found) == bits(&features), "frame {frame}, {}", options.accel);
                let bands = Bands::of_rows(SIZE[1], 11);
                let band = |rows| prepared.render_rows(rows, &control(false)).unwrap().film.pixels;
                let bands: Vec<Vec3> = bands.flat_map(band).collect();
                assert!(bands == expected.pixels, "frame {frame} in bands, {}", options.accel);
            }
            pictures.push(expected);
        }
        // Without a state: as it was prepared, which is the first frame.
        let control = RenderControl { on_progress, cancel, count_work: false, frame: None };
        assert!(prepared[1].0.render(&control).unwrap().film == pictures[1]);
        assert!(pictures[0] != pictures[1] && pictures[1] != pictures[2] && pictures[2] != pictures[0]);
        assert!(pictures[0] == pictures[3]);
    }
}

/// Frames that are rendered at the same time have scenes of their own.
#[test]
fn frames_of_moving_vertices_at_the_same_time() {
    let scene = reed();
    let data = Arc::new(SceneData::flatten(&scene).unwrap().0);
    let states = FrameStates::new(&scene, &data);
    let options = CpuOptions { accel: Accel::Bvh8, threads: Some(2), ..CpuOptions::default() };
    let prepared = CpuBackend::new(options).unwrap().prepare(Arc::clone(&data)).unwrap();
    let picture = |frame: u32| {
        let state = states.at(frame).unwrap();
        let (on_progress, cancel) = (&|_| {}, &AtomicBool::new(false));
        let control = RenderControl { on_progress, cancel, count_work: false, frame: Some(&state) };
        prepared.render(&control).unwrap().film
    };
    let expected: Vec<Film> = (0..12).map(|n| picture(4 * n)).collect();
    std::thread::scope(|scope| {
        for worker in 0..3 {
            let (picture, expected) = (&picture, &expected);
            scope.spawn(move || {
                (0..12).for_each(|n| {
                    let number = (n * 5 + worker * 4) % 12;
                    assert!(picture(4 * number as u32) == expected[number], "frame {}", 4 * number);
                });
            });
        }
    });
}

/// In words that tell all numbers apart.
fn bits(features: &[PixelFeatures]) -> Vec<String> {
    features.iter().map(|pixel| format!("{pixel:?}")).collect()
}
