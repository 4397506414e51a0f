//! Ways to work that change no bit: every two of them together, and sums that are full. Skipped as in `identity.rs`.

mod common;
mod gpu;

use eosphor_core::math::Vec3;
use eosphor_core::settings::Integrator;
use eosphor_cuda::{CudaOptions, devices};
use eosphor_render::{Backend, CpuBackend, CpuOptions, RenderControl};
use eosphor_scene::{Scene, SceneData};
use gpu::{assert_identical_by, backend, skip};
use std::collections::HashSet;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

/// How many values each of some choices has, as a set of rows in which every two values of two choices stand together.
fn rows_with_all_pairs(values: &[usize]) -> Vec<Vec<usize>> {
    let mut all: Vec<Vec<usize>> = vec![Vec::new()];
    for &count in values {
        all = all.iter().flat_map(|row| (0..count).map(move |value| [&row[..], &[value]].concat())).collect();
    }
    let pairs = |row: &[usize]| {
        let choices = 0..row.len();
        let of = |a: usize| (a + 1..row.len()).map(move |b| (a, b));
        choices.flat_map(of).map(|(a, b)| (a, row[a], b, row[b])).collect::<Vec<_>>()
    };
    let mut left: HashSet<_> = all.iter().flat_map(|row| pairs(row)).collect();
    let mut rows = Vec::new();
    while !left.is_empty() {
        let new = |row: &&Vec<usize>| pairs(row).iter().filter(|pair| left.contains(pair)).count();
        let row = all.iter().max_by_key(new).expect("there are rows").clone();
        for pair in pairs(&row) {
            left.remove(&pair);
        }
        rows.push(row);
    }
    rows
}

#[test]
fn rows_have_all_pairs() {
    let rows = rows_with_all_pairs(&[2, 3, 4]);
    for (a, b, values) in [(0, 1, 6), (0, 2, 8), (1, 2, 12)] {
        let pairs: HashSet<_> = rows.iter().map(|row| (row[a], row[b])).collect();
        assert_eq!(pairs.len(), values);
    }
    assert!(rows.len() < 24, "fewer than all");
}

/// Pools, blocks, devices, samples of a pass and depths.
#[test]
fn every_two_ways_together() {
    let found = match devices() {
        Ok(found) => found,
        Err(error) if std::env::var_os("REQUIRE_GPU").is_some_and(|v| v == "1") => panic!("{error}"),
        Err(error) => return skip(&error),
    };
    // One GPU twice where there is no other: bands are shared out all the same.
    let several = if found.len() > 1 { vec![0, 1] } else { vec![0, 0] };
    let pools = [1 << 12, 1 << 15, 1 << 18, 1 << 21];
    let blocks = [32, 64, 96, 128];
    let device_sets = [vec![0], several];
    // At depth 64 a pass has 504 samples at most, so 505 are two.
    let samples = [1, 7, 504, 505];
    let depths = [0, 1, 8, 64];
    let is_emulated = std::env::var_os("CUDA_EMULATOR").is_some();
    let [many, few] = if is_emulated { [[17, 11], [3, 2]] } else { [[320, 180], [32, 20]] };
    for (number, integrator) in [Integrator::Path, Integrator::Whitted].into_iter().enumerate() {
        let mut scene = common::scene("glass", None).unwrap();
        scene.settings.integrator = integrator;
        for row in rows_with_all_pairs(&[4, 4, 2, 4, 4]) {
            scene.settings.samples = samples[row[3]];
            scene.settings.depth = depths[row[4]];
            // With several samples more paths than all pools but the largest have room for.
            scene.settings.size = if samples[row[3]] > 7 { few } else { many };
            scene.settings.seed = number as u32;
            let options = CudaOptions {
                paths: Some(pools[row[0]]),
                block_size: blocks[row[1]],
                devices: device_sets[row[2]].clone(),
                ..CudaOptions::default()
            };
            assert_identical_by(&scene, options);
        }
    }
}

/// More of the largest contributions than a pixel holds.
#[test]
fn full_pixels() {
    let mut scene = Scene { camera: Some(Default::default()), ..Scene::default() };
    scene.settings.background = Vec3::splat(1e12);
    (scene.settings.size, scene.settings.samples) = ([2, 1], 65_536);
    for integrator in [Integrator::Whitted, Integrator::Path] {
        scene.settings.integrator = integrator;
        let Some(gpu) = backend(CudaOptions::default()) else { return };
        let cpu = CpuBackend::new(CpuOptions::default()).unwrap();
        let data = Arc::new(SceneData::flatten(&scene).unwrap().0);
        let sums = |backend: &dyn Backend| {
            let cancel = &AtomicBool::new(false);
            let control = RenderControl { on_progress: &|_| {}, cancel, count_work: false, frame: None };
            let prepared = backend.prepare(Arc::clone(&data)).unwrap();
            prepared.sample_rows(0..1, 0..65_536, &control).unwrap().sums.sums
        };
        let (on_cpu, on_gpu) = (sums(&cpu), sums(&gpu));
        assert_eq!(on_cpu, on_gpu, "{integrator:?}");
        assert!(on_gpu.iter().all(|sum| sum.units == [u64::MAX; 3]), "{on_gpu:?}");
        assert_identical_by(&scene, CudaOptions::default());
    }
}
