//! What the feature pass says of scenes whose answers are known.

use eosphor_core::math::{Vec3, vec3};
use eosphor_render::{CpuBackend, CpuOptions, FeatureRows};
use eosphor_scene::{Camera, FrameStates, Material, MaterialKind, PixelSampling, Scene, SceneData, Sphere};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

/// A green and a red ball of radius 1, at -3 and -5 in front of a camera at the origin that looks down -z; the red one
/// is half hidden.
fn balls(samples: u32) -> Scene {
    let matte = |color| Material::new("", MaterialKind::Matte { color });
    let mut scene = Scene {
        materials: vec![matte(Vec3::ONE), matte(vec3(0.0, 0.5, 0.0)), matte(vec3(0.75, 0.0, 0.0))],
        spheres: vec![
            Sphere { center: vec3(0.0, 0.0, -3.0), radius: 1.0, material: 1 },
            Sphere { center: vec3(2.0, 0.0, -5.0), radius: 1.0, material: 2 },
        ],
        camera: Some(Camera { position: Vec3::ZERO, direction: vec3(0.0, 0.0, -1.0), ..Camera::default() }),
        ..Scene::default()
    };
    scene.settings.size = [65, 33];
    scene.settings.samples = samples;
    scene.settings.pixel_sampling = PixelSampling::Random;
    scene
}

fn features(scene: &Scene) -> FeatureRows {
    let (data, _) = SceneData::flatten(scene).unwrap();
    let backend = CpuBackend::new(CpuOptions { threads: Some(2), ..CpuOptions::default() }).unwrap();
    let pass = backend.feature_pass(Arc::new(data), None).unwrap();
    pass.rows(0..scene.settings.size[1], None, &AtomicBool::new(false)).unwrap()
}

#[test]
fn the_middle_of_a_ball_faces_the_camera() {
    let rows = features(&balls(1));
    let middle = rows.pixels[16 * 65 + 32];
    assert_eq!((middle.albedo, middle.object, middle.material), (vec3(0.0, 0.5, 0.0), 0, 1));
    assert!((middle.depth - 2.0).abs() < 1e-5, "{}", middle.depth);
    assert!((middle.normal - vec3(0.0, 0.0, 1.0)).abs().max_component() < 1e-3, "{:?}", middle.normal);
    assert!(rows.work[16 * 65 + 32].tests > 0);
}

#[test]
fn what_shows_nothing_is_infinitely_far() {
    let corner = features(&balls(4)).pixels[0];
    assert_eq!((corner.albedo, corner.normal, corner.depth), (Vec3::ZERO, Vec3::ZERO, f32::INFINITY));
    assert_eq!((corner.object, corner.material), (u32::MAX, u32::MAX));
}

#[test]
fn means_are_over_the_samples_and_depths_over_the_hits() {
    let rows = features(&balls(64));
    let edges: Vec<_> =
        rows.pixels.iter().filter(|p| p.albedo.x == 0.0 && p.albedo.y > 0.0 && p.albedo.y < 0.5).collect();
    assert!(edges.len() > 10, "the green ball has an edge");
    for pixel in edges {
        // Albedo is a whole number of 64ths: the share of the samples that hit.
        let hits = pixel.albedo.y / 0.5 * 64.0;
        assert_eq!(hits, hits.round());
        let length = pixel.normal.dot(pixel.normal).sqrt();
        assert!(length <= hits / 64.0 + 1e-5 && length > 0.5 * hits / 64.0, "{pixel:?}");
        assert!(pixel.depth > 2.0 && pixel.depth < 3.0, "the mean of hits only: {pixel:?}");
    }
}

#[test]
fn a_cancelled_pass_shows_nothing() {
    let scene = balls(1);
    let (data, _) = SceneData::flatten(&scene).unwrap();
    let backend = CpuBackend::new(CpuOptions { threads: Some(2), ..CpuOptions::default() }).unwrap();
    let pass = backend.feature_pass(Arc::new(data), None).unwrap();
    assert_eq!(pass.rows(3..9, None, &AtomicBool::new(true)).unwrap(), FeatureRows::new(65, 6));
    assert!(pass.rows(30..34, None, &AtomicBool::new(false)).is_err());
}

#[test]
fn frames_of_another_size_and_single_pixels_are_those_of_a_scene_of_that_size() {
    let scene = balls(4);
    let (data, _) = SceneData::flatten(&scene).unwrap();
    let data = Arc::new(data);
    let backend = CpuBackend::new(CpuOptions { threads: Some(2), ..CpuOptions::default() }).unwrap();
    let pass = backend.feature_pass(Arc::clone(&data), None).unwrap();
    let mut other = scene.clone();
    (other.settings.size, other.settings.samples) = ([40, 50], 2);
    let states = FrameStates::new(&scene, &data);
    let state = states.seen_by(0, other.camera_at(0).as_ref(), &other.settings).unwrap();
    let rows = pass.rows(0..50, Some(&state), &AtomicBool::new(false)).unwrap();
    assert_eq!(rows.pixels, features(&other).pixels);
    for (x, y) in [(0, 0), (20, 25), (39, 49)] {
        assert_eq!(pass.pixel(x, y, &state).unwrap(), rows.pixels[y as usize * 40 + x as usize]);
    }
    assert!(pass.pixel(40, 0, &state).is_err() && pass.pixel(u32::MAX, u32::MAX, &state).is_err());
}
