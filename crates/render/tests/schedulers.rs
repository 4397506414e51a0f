//! The batched scheduler against the reference, `radiance`: the same bits and the same numbers of rays, whatever rays and
//! lights there are.

use eosphor_core::math::{Vec3, vec3};
use eosphor_core::settings::{Integrator, LightingModel, ShadowMode};
use eosphor_render::{
    Accel, Backend, CpuBackend, CpuOptions, RayStatistics, RenderControl, SampleSums, Scheduler, SimdLevel,
};
use eosphor_scene::{
    AlphaMode, Camera, Light, LightSelection, LoadOptions, Material, MaterialKind, Mtl, Parallelogram, Pbr,
    PixelSampling, Preset, RenderSettings, Scene, SceneData, Sphere, load,
};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

type Bits = Vec<[u32; 3]>;

fn render(scene: &Arc<SceneData>, options: CpuOptions) -> (Bits, RayStatistics) {
    let prepared = CpuBackend::new(options).unwrap().prepare(Arc::clone(scene)).unwrap();
    let control = RenderControl {
        on_progress: &|_| {},
        cancel: &AtomicBool::new(false),
        count_work: false,
        frame: None,
    };
    let rendered = prepared.render(&control).unwrap();
    assert!(rendered.complete);
    let bits = |c: &Vec3| [c.x.to_bits(), c.y.to_bits(), c.z.to_bits()];
    (rendered.film.pixels.iter().map(bits).collect(), rendered.statistics)
}

/// The same from sums of some samples of some rows each.
fn render_in_pieces(scene: &Arc<SceneData>, options: CpuOptions) -> (Bits, RayStatistics) {
    let prepared = CpuBackend::new(options).unwrap().prepare(Arc::clone(scene)).unwrap();
    let cancel = AtomicBool::new(false);
    let control = RenderControl { on_progress: &|_| {}, cancel: &cancel, count_work: false, frame: None };
    let (height, samples) = (prepared.size().1, prepared.samples());
    let (mut bits, mut rays) = (Bits::new(), RayStatistics::default());
    for rows in [0..height / 3, height / 3..height] {
        let mut sums = SampleSums::new(prepared.size().0, rows.len() as u32);
        let mut first = 0;
        while first < samples {
            // 1, 2, 4 and so on.
            let end = samples.min(2 * first + 1);
            let sampled = prepared.sample_rows(rows.clone(), first..end, &control).unwrap();
            assert!(sampled.complete);
            sums.add(&sampled.sums);
            rays += sampled.statistics;
            first = end;
        }
        bits.extend(sums.film(samples).pixels.iter().map(|c| [c.x.to_bits(), c.y.to_bits(), c.z.to_bits()]));
    }
    (bits, rays)
}

/// Compares the schedulers in tiles of several sizes, on one thread and several; returns the rays.
fn assert_identical(name: &str, scene: &Scene) -> RayStatistics {
    let (data, _) = SceneData::flatten(scene).unwrap();
    assert_identical_data(name, data)
}

fn pixels(scene: &Scene) -> Vec<[u32; 3]> {
    render(&Arc::new(SceneData::flatten(scene).unwrap().0), CpuOptions::default()).0
}

fn assert_identical_data(name: &str, data: SceneData) -> RayStatistics {
    let scene = Arc::new(data);
    let base = CpuOptions { threads: Some(1), ..CpuOptions::default() };
    let scalar = CpuOptions { scheduler: Scheduler::Scalar, tile: Some(16), ..base };
    let (pixels, rays) = render(&scene, scalar);
    assert!(pixels.iter().any(|p| *p != pixels[0]), "{name}: the picture shows nothing");
    let mut ways = vec![base, CpuOptions { threads: Some(3), tile: Some(7), ..base }];
    ways.push(CpuOptions { threads: Some(2), tile: Some(64), ..base });
    ways.extend(SimdLevel::available().map(|simd| CpuOptions { simd: Some(simd), ..base }));
    ways.push(CpuOptions { accel: Accel::Bvh8, ..base });
    let whole = |options| (options, render(&scene, options));
    let pieces = |options| (options, render_in_pieces(&scene, options));
    for (options, (other, other_rays)) in ways.into_iter().map(whole).chain([scalar, base].map(pieces)) {
        assert_eq!(other_rays, rays, "{name}, {options:?}");
        if let Some(at) = pixels.iter().zip(&other).position(|(a, b)| a != b) {
            let (width, show) = (scene.settings.width as usize, |p: [u32; 3]| p.map(f32::from_bits));
            let (a, b) = (show(pixels[at]), show(other[at]));
            panic!("{name}, {options:?}: pixel ({}, {}) is {b:?}, not {a:?}", at % width, at / width);
        }
    }
    rays
}

fn add(scene: &mut Scene, kind: MaterialKind) -> u32 {
    scene.materials.push(Material::new(format!("m{}", scene.materials.len()), kind));
    scene.materials.len() as u32 - 1
}

/// Paths: mirrors, glass that refracts and panes, lamps; with roulette early and late, and with all light or limited.
#[test]
fn paths() {
    for (roulette, clamp_indirect, depth) in [(1, None, 12), (5, Some(2.0), 5), (60, None, 1)] {
        let mut scene = everything();
        scene.settings.integrator = Integrator::Path;
        scene.settings.roulette = roulette;
        scene.settings.clamp_indirect = clamp_indirect;
        scene.settings.depth = depth;
        let rays = assert_identical(&format!("roulette {roulette}, depth {depth}"), &scene);
        assert!(rays.glossy > 0 && rays.shadow > 0);
    }
}

/// Rough grounds are not among the matte surfaces that are taken together, and stand beside such.
#[test]
fn paths_of_rough_grounds() {
    let mut scene = everything();
    scene.settings.integrator = Integrator::Path;
    let plain = add(&mut scene, MaterialKind::Matte { color: vec3(0.3, 0.6, 0.4) });
    let plastic = add(&mut scene, MaterialKind::Pbr(Pbr { roughness: 0.4, ..Pbr::default() }));
    for (i, material) in [plain, plastic].into_iter().enumerate() {
        let center = vec3(i as f32 * 1.6 - 0.8, 0.4, 1.9);
        scene.spheres.push(Sphere { center, radius: 0.4, material });
    }
    let smooth = pixels(&scene);
    for (number, material) in scene.materials.iter_mut().enumerate() {
        let is_black = matches!(
            material.kind,
            MaterialKind::Mirror { .. } | MaterialKind::Dielectric { .. } | MaterialKind::Emissive { .. }
        );
        if !is_black && number as u32 != plain {
            material.diffuse_roughness = if number == 0 { 1.0 } else { 0.6 };
        }
    }
    assert_identical("rough grounds", &scene);
    assert!(pixels(&scene) != smooth, "roughness changes nothing");
}

/// Spheres of every kind over a floor, with a light of every kind.
fn everything() -> Scene {
    let mut scene = Scene {
        camera: Some(Camera {
            position: vec3(0.3, 2.0, 6.5),
            look_at: Some(vec3(0.0, 0.6, 0.0)),
            ..Camera::default()
        }),
        settings: RenderSettings {
            size: [45, 34],
            samples: 2,
            light_samples: 3,
            ..RenderSettings::default()
        },
        ..Scene::default()
    };
    let floor = add(&mut scene, MaterialKind::Matte { color: vec3(0.6, 0.5, 0.4) });
    let lamp = add(&mut scene, MaterialKind::Emissive { radiance: vec3(6.0, 5.0, 4.0) });
    let plane = |corner, edge_u, edge_v, material| Parallelogram { corner, edge_u, edge_v, material };
    let z = vec3(0.0, 0.0, 1.0);
    scene.parallelograms.push(plane(vec3(-6.0, 0.0, 5.0), vec3(12.0, 0.0, 0.0), z * -12.0, floor));
    scene.parallelograms.push(plane(vec3(-1.0, 4.0, -1.0), vec3(2.0, 0.0, 0.0), z * 2.0, lamp));
    let transparent = |reflection| MaterialKind::Transparent {
        color: vec3(0.9, 0.2, 0.2),
        transparency: 0.6,
        reflection,
        shininess: 64.0,
        diffuse: 1.0,
    };
    let kinds = [
        MaterialKind::Mirror { reflectance: Vec3::splat(0.9) },
        MaterialKind::Dielectric { ior: 1.5, tint: vec3(0.9, 1.0, 0.95) },
        MaterialKind::Glossy {
            reflectance: Vec3::splat(0.7),
            exponent: 30.0,
            rays: 5,
            color: vec3(0.1, 0.1, 0.0),
        },
        transparent(0.2),
        MaterialKind::Mtl(Mtl { Kd: vec3(0.2, 0.3, 0.8), Ks: Vec3::splat(0.5), Ns: 50.0, ..Mtl::default() }),
    ];
    for (i, kind) in kinds.into_iter().enumerate() {
        let material = add(&mut scene, kind);
        let center = vec3(i as f32 * 1.3 - 2.6, 0.6, (i % 2) as f32 - 0.5);
        scene.spheres.push(Sphere { center, radius: 0.6, material });
    }
    let color = Vec3::splat(8.0);
    scene.lights.push(Light::Point { position: vec3(-3.0, 3.0, 3.0), color });
    scene.lights.push(Light::Directional { direction: vec3(0.2, -1.0, -0.4), color: Vec3::splat(0.3) });
    scene.lights.push(Light::Spot {
        position: vec3(3.0, 4.0, 3.0),
        direction: vec3(-3.0, -4.0, -3.0),
        inner_degrees: 10.0,
        outer_degrees: 25.0,
        color: color * 2.0,
    });
    scene
}

#[test]
fn models_shadows_and_sides() {
    for lighting in [
        LightingModel::Distance,
        LightingModel::Diffuse,
        LightingModel::Lambert,
        LightingModel::Phong,
        LightingModel::BlinnPhong,
    ] {
        for shadows in [ShadowMode::None, ShadowMode::Opaque, ShadowMode::Coloured] {
            for light_from_behind in [false, true] {
                let mut scene = everything();
                let settings = &mut scene.settings;
                (settings.lighting, settings.shadows) = (lighting, shadows);
                settings.light_from_behind = light_from_behind;
                settings.ambient = 0.1;
                assert_identical(&format!("{lighting:?}, {shadows:?}, {light_from_behind}"), &scene);
            }
        }
    }
}

#[test]
fn samples_of_lights_and_pixels() {
    for light_samples in [1, 2, 11, 12, 17, 50] {
        for (samples, pixel_sampling) in
            [(1, PixelSampling::Center), (7, PixelSampling::Random), (4, PixelSampling::Grid(2))]
        {
            let mut scene = everything();
            (scene.settings.light_samples, scene.settings.samples) = (light_samples, samples);
            scene.settings.pixel_sampling = pixel_sampling;
            scene.settings.size = [23, 17];
            assert_identical(&format!("{light_samples} a light, {samples} a pixel"), &scene);
        }
    }
}

#[test]
fn depth_limits_and_energy() {
    for depth in [0, 1, 2, 64] {
        for energy_threshold in [0.0, 0.05] {
            let mut scene = everything();
            (scene.settings.depth, scene.settings.energy_threshold) = (depth, energy_threshold);
            let rays = assert_identical(&format!("depth {depth}, from {energy_threshold}"), &scene);
            assert_eq!(rays.refracted > 0, depth > 0);
        }
    }
}

#[test]
fn points_that_wait_for_nothing_hold_up_no_camera_ray() {
    // Every camera ray finds a pane whose rays are all too weak to go on.
    let mut scene = everything();
    let kind = MaterialKind::Transparent {
        color: vec3(0.7, 0.6, 0.5),
        transparency: 0.5,
        reflection: 0.2,
        shininess: 20.0,
        diffuse: 1.0,
    };
    let material = add(&mut scene, kind);
    let (edge_u, edge_v) = (vec3(40.0, 0.0, 0.0), vec3(0.0, 40.0, 0.0));
    scene.parallelograms.push(Parallelogram { corner: vec3(-20.0, -20.0, 5.0), edge_u, edge_v, material });
    scene.settings.size = [96, 80];
    scene.settings.energy_threshold = 0.9;
    let rays = assert_identical("too weak to go on", &scene);
    assert_eq!((rays.camera, rays.refracted), (2 * 96 * 80, 0));
}

#[test]
fn glossy_rays_by_the_thousand() {
    let mut scene = everything();
    for material in &mut scene.materials {
        if let MaterialKind::Glossy { rays, .. } = &mut material.kind {
            *rays = 1024;
        }
    }
    scene.settings.size = [20, 15];
    (scene.settings.samples, scene.settings.light_samples, scene.settings.depth) = (1, 1, 3);
    let rays = assert_identical("1024 glossy rays", &scene);
    assert!(rays.glossy > 8 * 1024, "{rays:?}");
}

#[test]
fn holes_and_surfaces_of_model_files() {
    let mut scene = crate::surfaces::scene();
    for shadows in [ShadowMode::Opaque, ShadowMode::Coloured] {
        scene.settings.shadows = shadows;
        assert_identical(&format!("surfaces, {shadows:?}"), &scene);
    }
    // Leaves before leaves: a chain of rays through holes.
    let mut scene = everything();
    for k in 0..40 {
        let pbr = Pbr { color: vec3(0.1, 0.5, 0.1), opacity: 0.15, ..Pbr::default() };
        let material = add(&mut scene, MaterialKind::Pbr(pbr));
        scene.materials[material as usize].alpha = AlphaMode::Blend;
        let center = vec3(0.2, 1.0, 3.0 - 0.02 * k as f32);
        scene.spheres.push(Sphere { center, radius: 0.8, material });
    }
    scene.settings.size = [16, 12];
    assert_identical("leaves", &scene);
}

#[test]
fn culling_presets_and_no_lights() {
    for preset in [Preset::Pg1, Preset::Eos] {
        let mut scene = load("builtin:cornell", &LoadOptions::default()).unwrap().scene;
        preset.apply(&mut scene);
        scene.settings.size = [40, 40];
        scene.settings.cull_back_faces = true;
        assert_identical(&format!("cornell, {preset:?}"), &scene);
    }
    let mut scene = everything();
    scene.settings.ambient = 0.4;
    scene.settings.background = vec3(0.1, 0.2, 0.4);
    let (mut data, _) = SceneData::flatten(&scene).unwrap();
    data.lights.clear();
    let rays = assert_identical_data("no lights", data);
    assert_eq!(rays.shadow, 0);
}

#[test]
fn lamps_that_are_drawn() {
    for (shadows, from_behind) in
        [(ShadowMode::Opaque, false), (ShadowMode::Coloured, true), (ShadowMode::None, false)]
    {
        for selection in [LightSelection::Tree, LightSelection::Power, LightSelection::Uniform] {
            let mut scene = everything();
            scene.settings.lights = Some(selection);
            (scene.settings.shadows, scene.settings.light_from_behind) = (shadows, from_behind);
            let rays = assert_identical(&format!("{selection:?}, {shadows:?}"), &scene);
            assert!((rays.shadow > 0) == (shadows != ShadowMode::None));
        }
    }
    let mut rooms = crate::closed_form::many_lights::rooms(3, 40);
    rooms.settings.integrator = Integrator::Whitted;
    (rooms.settings.samples, rooms.settings.light_samples, rooms.settings.lights) = (2, 3, None);
    let rays = assert_identical("many lamps", &rooms);
    // Of 720 lamps three are drawn at a point.
    assert!(rays.shadow <= 3 * rays.camera, "{rays:?}");
}

#[test]
fn a_raised_flag_ends_a_tile_soon() {
    let mut scene = everything();
    (scene.settings.samples, scene.settings.light_samples, scene.settings.size) = (64, 64, [64, 64]);
    let (data, _) = SceneData::flatten(&scene).unwrap();
    let options = CpuOptions { threads: Some(1), tile: Some(64), ..CpuOptions::default() };
    let prepared = CpuBackend::new(options).unwrap().prepare(Arc::new(data)).unwrap();
    let cancel = AtomicBool::new(false);
    let control = RenderControl { on_progress: &|_| {}, cancel: &cancel, count_work: false, frame: None };
    let start = std::time::Instant::now();
    let rendered = std::thread::scope(|scope| {
        let render = scope.spawn(|| prepared.render(&control).unwrap());
        std::thread::sleep(std::time::Duration::from_millis(50));
        cancel.store(true, Ordering::Relaxed);
        render.join().unwrap()
    });
    assert!(!rendered.complete, "the picture takes far longer than 50 ms");
    assert!(start.elapsed().as_secs_f64() < 5.0, "{:?}", start.elapsed());
}
