//! Pictures of the GPU are those of the CPU, bit for bit. Without a GPU these tests say so and pass; with REQUIRE_GPU=1
//! in the environment they fail then.

mod common;
mod gpu;

use eosphor_core::develop::{ToneCurve, Transfer};
use eosphor_core::math::Vec3;
use eosphor_core::settings::{Integrator, LightingModel, ShadowMode};
use eosphor_cuda::{CudaOptions, GpuScheduler, Traversal};
use eosphor_render::{
    Accel, Backend, CpuBackend, CpuOptions, DevelopSettings, Developed, PreparedScene, RenderControl,
};
use eosphor_scene::{
    Animation, CameraMotion, FrameStates, LightSelection, Move, MoveKey, Preset, RenderSettings, Scene,
    SceneData,
};
use gpu::{assert_identical_by, backend, skip};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};

/// Renders on CPU and GPU, over this structure there, and compares films and ray counts.
fn assert_identical(scene: &Scene, accel: Accel) {
    assert_identical_by(scene, CudaOptions { accel, ..CudaOptions::default() });
}

/// The size of a picture; a part of it where an emulator renders it.
fn size(width: u32, height: u32) -> [u32; 2] {
    let part = if std::env::var_os("CUDA_EMULATOR").is_some() { 4 } else { 1 };
    [width, height].map(|side| side.div_ceil(part))
}

#[test]
fn cornell_box() {
    let mut scene = common::scene("builtin:cornell", Some(Preset::Pg1)).unwrap();
    scene.settings.size = size(160, 120);
    assert_identical(&scene, Accel::Bvh);
}

#[test]
fn cornell_box_of_every_preset_and_none() {
    for preset in Preset::ALL.map(Some).into_iter().chain([None]) {
        let mut scene = common::scene("builtin:cornell", preset).unwrap();
        scene.settings.size = size(61, 67);
        scene.settings.samples = 2;
        assert_identical(&scene, Accel::Bvh);
    }
}

#[test]
fn glass_mirrors_lens_and_instances() {
    assert_identical(&common::scene("glass", None).unwrap(), Accel::Bvh);
}

#[test]
fn surfaces_of_model_files() {
    let mut scene = common::scene("surfaces", None).unwrap();
    assert_identical(&scene, Accel::Bvh);
    scene.camera.as_mut().unwrap().orthographic_height = Some(3.5);
    assert_identical(&scene, Accel::None);
}

#[test]
fn glass_without_hierarchy() {
    let mut scene = common::scene("glass", None).unwrap();
    scene.settings.size = size(64, 36);
    assert_identical(&scene, Accel::None);
}

/// Structures that there are on GPUs.
fn structures() -> impl Iterator<Item = Accel> {
    let is_there = |&accel: &Accel| CudaOptions { accel, ..CudaOptions::default() }.check().is_ok();
    Accel::ALL.iter().copied().filter(is_there)
}

#[test]
fn every_structure() {
    assert_eq!(structures().count(), Accel::ALL.len() - 1, "all but bvh8");
    for accel in structures() {
        for name in ["glass", "surfaces", "builtin:cornell"] {
            let mut scene = common::scene(name, None).unwrap();
            (scene.settings.size, scene.settings.samples) = (size(83, 59), 2);
            assert_identical(&scene, accel);
        }
    }
}

#[test]
fn rays_from_far_away() {
    // Beyond the grid's reach they take another walk, and rounding is larger than a cell.
    for distance in [1e3, 1e5] {
        let mut scene = common::scene("glass", None).unwrap();
        scene.settings.size = size(61, 47);
        let camera = scene.camera.as_mut().unwrap();
        camera.position = camera.position * distance;
        camera.fov_x_degrees = 60.0 / distance;
        structures().for_each(|accel| assert_identical(&scene, accel));
    }
}

/// The same walk over the same structure does the same; and all of it takes time.
#[test]
fn counts_are_those_of_the_cpu() {
    for name in ["builtin:cornell", "glass"] {
        let mut scene = common::scene(name, None).unwrap();
        scene.settings.size = size(61, 47);
        let data = Arc::new(SceneData::flatten(&scene).unwrap().0);
        for accel in structures() {
            let Some(gpu) = backend(CudaOptions { accel, count_work: true, ..CudaOptions::default() }) else {
                return;
            };
            let cpu = CpuBackend::new(CpuOptions { accel, ..CpuOptions::default() }).unwrap();
            let on_gpu = common::render_counted(&gpu, &data).unwrap();
            let on_cpu = common::render_counted(&cpu, &data).unwrap();
            if let Some(text) = common::difference(&on_cpu.film, &on_gpu.film) {
                panic!("{name}, {accel}: {text}");
            }
            let (mut of_gpu, mut of_cpu) = (on_gpu.statistics, on_cpu.statistics);
            let times = of_gpu.times;
            assert!(times.traversal_nanoseconds > 0 && times.intersection_nanoseconds > 0, "{name}, {accel}");
            (of_gpu.times, of_cpu.times) = Default::default();
            assert!(of_gpu.nodes_visited + of_gpu.primitive_tests > of_gpu.searches, "{name}, {accel}");
            assert_eq!(of_gpu, of_cpu, "{name}, {accel}");
        }
    }
}

#[test]
fn every_block_size() {
    let mut scene = common::scene("glass", None).unwrap();
    // Neither a multiple of a warp's pixels nor of a block's.
    scene.settings.size = size(93, 53);
    for integrator in [Integrator::Whitted, Integrator::Path] {
        scene.settings.integrator = integrator;
        for block_size in [32, 64, 96, 128, 256, 512] {
            assert_identical_by(&scene, CudaOptions { block_size, ..CudaOptions::default() });
        }
    }
}

/// Of a pool's paths, each in its own way: fewer than a picture's samples, as many, and more.
#[test]
fn every_number_of_paths() {
    let mut scene = common::scene("glass", None).unwrap();
    (scene.settings.size, scene.settings.integrator) = (size(93, 53), Integrator::Path);
    scene.settings.samples = 8;
    for paths in [1 << 12, 5000, 1 << 15, 1 << 18, 1 << 21] {
        assert_identical_by(&scene, CudaOptions { paths: Some(paths), ..CudaOptions::default() });
    }
}

/// Every order of Whitted's rays, with shadows of every kind and rounds of several sizes.
#[test]
fn every_scheduler() {
    for (name, shadows, behind) in [
        ("builtin:cornell-pg1", ShadowMode::Opaque, false),
        ("glass", ShadowMode::Coloured, false),
        ("glass", ShadowMode::Coloured, true),
        ("surfaces", ShadowMode::None, true),
        ("builtin:lamps", ShadowMode::Opaque, false),
    ] {
        let mut scene = common::scene(name, None).unwrap();
        (scene.settings.size, scene.settings.samples) = (size(64, 36), 2);
        scene.settings.integrator = Integrator::Whitted;
        (scene.settings.shadows, scene.settings.light_from_behind) = (shadows, behind);
        for scheduler in [GpuScheduler::Megakernel, GpuScheduler::Queues] {
            assert_identical_by(&scene, CudaOptions { scheduler, ..CudaOptions::default() });
        }
        let paths = Some(1 << 12);
        let scheduler = GpuScheduler::Queues;
        assert_identical_by(&scene, CudaOptions { scheduler, paths, ..CudaOptions::default() });
    }
}

/// More shadow rays of a point than there is room for at a time, which is 512 with so many paths (`queue_room.rs` tests it).
#[test]
fn very_many_shadow_rays() {
    let mut scene = common::scene("builtin:cornell", None).unwrap();
    (scene.settings.size, scene.settings.samples, scene.settings.depth) = ([2, 2], 1, 1);
    scene.settings.light_samples = 1500;
    let options = || CudaOptions { paths: Some(1 << 14), ..CudaOptions::default() };
    assert_identical_by(&scene, options());
    // The same where light comes through surfaces, and where many lights have one sample each.
    for (name, samples) in [("glass", 600), ("builtin:lamps", 1)] {
        let mut scene = common::scene(name, None).unwrap();
        (scene.settings.size, scene.settings.samples, scene.settings.depth) = ([3, 2], 1, 1);
        (scene.settings.light_samples, scene.settings.lights) = (samples, Some(LightSelection::All));
        (scene.settings.shadows, scene.settings.integrator) = (ShadowMode::Coloured, Integrator::Whitted);
        assert_identical_by(&scene, options());
    }
}

/// What stages are said to have done is what was traced.
#[test]
fn stages_of_a_picture() {
    for integrator in [Integrator::Whitted, Integrator::Path] {
        let mut scene = common::scene("glass", None).unwrap();
        (scene.settings.size, scene.settings.samples) = (size(96, 64), 3);
        (scene.settings.integrator, scene.settings.shadows) = (integrator, ShadowMode::Coloured);
        let data = Arc::new(SceneData::flatten(&scene).unwrap().0);
        let Some(gpu) = backend(CudaOptions::default()) else { return };
        let (rendered, _) = common::render(&gpu, &data).unwrap();
        let prepared = gpu.prepare(Arc::clone(&data)).unwrap();
        let (cancel, watch) = (AtomicBool::new(false), |_| ());
        let control = RenderControl { on_progress: &watch, cancel: &cancel, count_work: false, frame: None };
        let stages = prepared.stages(&control).unwrap();
        let items = |start: &str| {
            let of = stages.iter().filter(|stage| stage.kernel.starts_with(start));
            of.map(|stage| stage.items).sum::<u64>()
        };
        let (all, shadow) = (rendered.statistics.total_rays(), rendered.statistics.shadow);
        let pixels = u64::from(data.settings.width) * u64::from(data.settings.height);
        assert_eq!(items("paths_settle"), pixels, "{stages:?}");
        let camera = items("paths_generate") + items("trees_generate");
        assert_eq!(camera, rendered.statistics.camera, "{stages:?}");
        let (traced, seen) = (items("hits_"), items("seen_"));
        match integrator {
            Integrator::Path => assert_eq!((traced, seen), (all - shadow, shadow), "{stages:?}"),
            // Glossy surfaces come again without a ray, and groups of points are whole.
            Integrator::Whitted => assert!((traced >= all - shadow) & (seen >= shadow), "{stages:?}"),
        }
        assert!((1..seen).contains(&items("crossed_")), "{stages:?}");
        assert!(stages.iter().all(|stage| stage.launches > 0 && stage.lanes >= stage.items), "{stages:?}");
    }
}

/// Queues become smaller where there may be less memory, and what does not fit says so.
#[test]
fn little_memory() {
    let mut scene = common::scene("glass", None).unwrap();
    (scene.settings.size, scene.settings.samples) = (size(96, 64), 3);
    let data = Arc::new(SceneData::flatten(&scene).unwrap().0);
    for integrator in [Integrator::Whitted, Integrator::Path] {
        scene.settings.integrator = integrator;
        assert_identical_by(&scene, CudaOptions { memory_bytes: Some(800 << 20), ..CudaOptions::default() });
    }
    let Some(gpu) = backend(CudaOptions { memory_bytes: Some(1 << 20), ..CudaOptions::default() }) else {
        return;
    };
    let refused = gpu.prepare(data).err().expect("there is no room").to_string();
    assert!(refused.contains("not enough memory") && refused.contains("1.0 MB are allowed"), "{refused}");
}

/// Rough grounds by paths, bare and under layers.
#[test]
fn rough_grounds() {
    let mut scene = common::scene("surfaces", None).unwrap();
    scene.settings.integrator = Integrator::Path;
    scene.settings.size = size(93, 53);
    for material in &mut scene.materials {
        material.diffuse_roughness = 0.8;
    }
    for accel in structures() {
        assert_identical(&scene, accel);
    }
}

#[test]
fn every_traversal() {
    for name in ["builtin:cornell", "glass"] {
        let mut scene = common::scene(name, None).unwrap();
        scene.settings.size = size(93, 53);
        for traversal in Traversal::ALL {
            assert_identical_by(&scene, CudaOptions { traversal, ..CudaOptions::default() });
        }
    }
}

/// Up to 32 threads share a pixel's samples.
#[test]
fn every_number_of_samples() {
    let mut scene = common::scene("glass", None).unwrap();
    scene.settings.size = size(37, 23);
    for samples in [1, 2, 3, 4, 5, 7, 8, 9, 15, 16, 31, 32, 33, 64, 100] {
        scene.settings.samples = samples;
        assert_identical(&scene, Accel::Bvh);
    }
}

/// Frames over what was uploaded for the first, several at a time, against those of the CPU.
fn assert_frames_identical(scene: &Scene, options: CudaOptions) {
    let way = format!("{options:?}");
    let data = Arc::new(SceneData::flatten(scene).unwrap().0);
    let states = FrameStates::new(scene, &data);
    let Some(gpu) = backend(options) else { return };
    let cpu = CpuBackend::new(CpuOptions::default()).unwrap();
    let prepared: [Box<dyn PreparedScene>; 2] =
        [gpu.prepare(Arc::clone(&data)).unwrap(), cpu.prepare(Arc::clone(&data)).unwrap()];
    std::thread::scope(|scope| {
        for frame in 0..8 {
            let (states, prepared, way) = (&states, &prepared, &way);
            scope.spawn(move || {
                // Frames may have sizes of their own.
                let mut settings = scene.settings;
                settings.size = settings.size.map(|side| side + 40 * (frame % 3));
                let state = states.seen_by(frame, scene.camera_at(frame).as_ref(), &settings).unwrap();
                let control = RenderControl {
                    on_progress: &|_| {},
                    cancel: &AtomicBool::new(false),
                    count_work: false,
                    frame: Some(&state),
                };
                let [a, b] = prepared.each_ref().map(|scene| scene.render(&control).unwrap());
                assert_eq!(common::difference(&a.film, &b.film), None, "frame {frame}, {way}");
                assert_eq!(a.statistics.total_rays(), b.statistics.total_rays());
            });
        }
    });
}

/// Frames may have shadows of another kind than the scene that was prepared.
#[test]
fn frames_with_shadows_of_their_own() {
    const MODES: [ShadowMode; 3] = [ShadowMode::None, ShadowMode::Opaque, ShadowMode::Coloured];
    let mut scene = common::scene("glass", None).unwrap();
    (scene.settings.size, scene.settings.integrator) = (size(40, 24), Integrator::Whitted);
    scene.animation = Some(Animation { fps: 4.0, ..Animation::of_frames(3) });
    for prepared in MODES {
        scene.settings.shadows = prepared;
        let data = Arc::new(SceneData::flatten(&scene).unwrap().0);
        let states = FrameStates::new(&scene, &data);
        let Some(gpu) = backend(CudaOptions::default()) else { return };
        let cpu = CpuBackend::new(CpuOptions::default()).unwrap();
        let prepared: [Box<dyn PreparedScene>; 2] =
            [gpu.prepare(Arc::clone(&data)).unwrap(), cpu.prepare(Arc::clone(&data)).unwrap()];
        for shadows in MODES {
            let settings = RenderSettings { shadows, ..scene.settings };
            let state = states.seen_by(1, None, &settings).unwrap();
            let (on_progress, cancel) = (|_| {}, AtomicBool::new(false));
            let control = RenderControl {
                on_progress: &on_progress,
                cancel: &cancel,
                count_work: false,
                frame: Some(&state),
            };
            let [a, b] = prepared.each_ref().map(|scene| scene.render(&control).unwrap().film);
            assert_eq!(common::difference(&a, &b), None, "{:?} and {shadows:?}", scene.settings.shadows);
        }
    }
}

#[test]
fn frames_of_an_animation() {
    let mut scene = common::scene("glass", None).unwrap();
    scene.settings.size = size(93, 53);
    let orbit = CameraMotion::Orbit { turns: 0.2, around: None };
    scene.animation = Some(Animation { camera: Some(orbit), ..Animation::of_frames(8) });
    assert_frames_identical(&scene, CudaOptions::default());
}

/// Every frame has a top level of its own: more frames at a time than there is room for.
#[test]
fn frames_of_moving_instances() {
    let mut scene = common::scene("glass", None).unwrap();
    scene.settings.size = size(61, 47);
    scene.animation = Some(Animation { fps: 8.0, ..Animation::of_frames(8) });
    // Far beyond where the first frame has them.
    let key =
        |seconds, x| MoveKey { seconds, translate: Some(Vec3 { x, y: 0.0, z: -x }), ..MoveKey::default() };
    let keys = vec![key(0.0, 0.0), key(0.5, 0.5), key(1.0, 60.0)];
    let motion = Arc::new(Move { keys, ..Move::default() });
    scene.instances.iter_mut().skip(1).for_each(|instance| instance.moves = vec![Arc::clone(&motion)]);
    for accel in structures() {
        assert_frames_identical(&scene, CudaOptions { accel, ..CudaOptions::default() });
    }
    for traversal in Traversal::ALL {
        assert_frames_identical(&scene, CudaOptions { traversal, ..CudaOptions::default() });
    }
}

/// Every frame has trees and vertices of its own.
#[test]
fn frames_of_moving_vertices() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../scenes/reed.glb");
    let mut scene = common::scene(path, None).unwrap();
    scene.settings.size = size(61, 47);
    scene.animation = Some(Animation { fps: 4.0, ..Animation::of_frames(8) });
    for accel in structures() {
        assert_frames_identical(&scene, CudaOptions { accel, ..CudaOptions::default() });
    }
    for traversal in Traversal::ALL {
        assert_frames_identical(&scene, CudaOptions { traversal, ..CudaOptions::default() });
    }
}

/// Develops on the GPU, and compares with what the CPU makes of its own film. The number of bands, or `None` without a GPU.
fn assert_developed(scene: &Scene, options: CudaOptions, ways: &[DevelopSettings]) -> Option<u32> {
    let text = format!("{options:?}");
    let gpu = backend(options)?;
    let data = Arc::new(SceneData::flatten(scene).unwrap().0);
    let cpu = CpuBackend::new(CpuOptions::default()).unwrap();
    let (on_cpu, _) = common::render(&cpu, &data).unwrap();
    let (prepared, bands) = (gpu.prepare(data).unwrap(), AtomicU32::new(0));
    for develop in ways {
        bands.store(0, Ordering::Relaxed);
        let on_progress = |_| {
            bands.fetch_add(1, Ordering::Relaxed);
        };
        let cancel = &AtomicBool::new(false);
        let control = RenderControl { on_progress: &on_progress, cancel, count_work: false, frame: None };
        let on_gpu = prepared.render_developed(develop, &control).unwrap();
        assert!(on_gpu.complete && on_gpu.statistics == on_cpu.statistics, "{develop:?}, {text}");
        let (got, expected) = (on_gpu.developed(), Developed::new(&on_cpu.film, develop));
        let first = got.rgb.iter().zip(&expected.rgb).position(|(a, b)| a != b);
        assert!(got == expected, "{develop:?}, {text}: first at byte {first:?} of {}", got.rgb.len());
        assert!(got.rgb.iter().any(|&byte| byte != got.rgb[0]), "there is something to be seen");
    }
    Some(bands.into_inner())
}

/// Every curve and transfer, with a number of pixels whose bytes are no whole words.
#[test]
fn developed_pictures() {
    let curves = [ToneCurve::None, ToneCurve::Aces, ToneCurve::Agx, ToneCurve::Neutral];
    let ways = curves.iter().flat_map(|&tone_curve| {
        let way = |exposure, transfer| DevelopSettings { exposure, tone_curve, transfer };
        [way(1.5, Transfer::Srgb), way(-0.5, Transfer::Linear)]
    });
    let ways: Vec<DevelopSettings> = ways.collect();
    let mut scene = common::scene("glass", None).unwrap();
    (scene.settings.size, scene.settings.samples) = (size(49, 27), 2);
    assert!(scene.settings.size.iter().product::<u32>() % 4 == 3);
    assert_developed(&scene, CudaOptions::default(), &ways);
    for scheduler in GpuScheduler::ALL {
        assert_developed(&scene, CudaOptions { scheduler, ..CudaOptions::default() }, &ways[5..6]);
    }
    scene.settings.integrator = Integrator::Path;
    assert_developed(&scene, CudaOptions::default(), &ways[6..7]);
    // Fewer pixels than a thread has.
    (scene.settings.size, scene.settings.integrator) = ([3, 1], Integrator::Whitted);
    assert_developed(&scene, CudaOptions::default(), &ways[..1]);
}

/// In several bands, each of which has bytes of its own: many shadow rays are expected, of which unlit surfaces trace none, and
/// many threads share a pixel.
#[test]
fn developed_bands() {
    let mut scene = common::scene("builtin:cornell", None).unwrap();
    let is_emulated = std::env::var_os("CUDA_EMULATOR").is_some();
    scene.settings.size = if is_emulated { [21, 15] } else { [301, 203] };
    (scene.settings.samples, scene.settings.light_samples) = (32, 65_536);
    scene.settings.lighting = LightingModel::Diffuse;
    for scheduler in [GpuScheduler::Megakernel, GpuScheduler::Queues] {
        let options = CudaOptions { scheduler, ..CudaOptions::default() };
        let bands = assert_developed(&scene, options, &[DevelopSettings::default()]);
        assert!(bands.is_none_or(|bands| bands > 1), "{scheduler:?}");
    }
}

#[test]
fn one_pixel_and_nothing_in_it() {
    let mut scene = Scene { camera: Some(Default::default()), ..Scene::default() };
    scene.settings.size = size(1, 1);
    structures().for_each(|accel| assert_identical(&scene, accel));
}

/// EOSPHOR_TEST_OBJ names one more scene.
#[test]
fn a_scene_from_a_file() {
    let Some(path) = std::env::var_os("EOSPHOR_TEST_OBJ") else {
        return skip(&"EOSPHOR_TEST_OBJ is not set");
    };
    let mut scene = common::scene(path.to_str().unwrap(), None).unwrap();
    scene.settings.size = size(320, 240);
    assert_identical(&scene, Accel::Bvh);
}
