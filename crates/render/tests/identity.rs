//! The picture contract on the CPU: a pixel does not depend on threads, tiles, SIMD level or hierarchy.

mod paths;

use eosphor_core::math::{Vec3, vec3};
use eosphor_core::settings::{FresnelMode, LightingModel, ShadowMode};
use eosphor_render::{
    Accel, Backend, Bands, CpuBackend, CpuOptions, FeatureRows, Film, PixelFeatures, RenderControl, SimdLevel,
};
use eosphor_scene::{
    Animation, Camera, CameraMotion, FrameStates, Image, Instance, Interpolation, Lens, Light, LoadOptions,
    Material, MaterialKind, Mesh, Move, MoveKey, Mtl, NO_INDEX, NormalMode, Parallelogram, PixelSampling,
    Preset, RenderSettings, Scene, SceneData, Sphere, Texels, Texture, Transform, Triangle, load,
};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

fn render(scene: &Arc<SceneData>, options: CpuOptions) -> Film {
    let backend = CpuBackend::new(options).unwrap();
    let prepared = backend.prepare(Arc::clone(scene)).unwrap();
    let cancel = AtomicBool::new(false);
    // Counting takes another way through the tracers: tiles of 5 stand for it.
    let control = RenderControl {
        on_progress: &|_| {},
        cancel: &cancel,
        count_work: options.tile == Some(5),
        frame: None,
    };
    let rendered = prepared.render(&control).unwrap();
    assert!(rendered.complete);
    rendered.film
}

/// Renders in all ways and compares every bit.
fn assert_identical(name: &str, scene: &Scene) {
    let (data, _) = SceneData::flatten(scene).unwrap();
    let scene = Arc::new(data);
    let base = CpuOptions { threads: Some(1), ..CpuOptions::default() };
    let reference = render(&scene, base);
    let lit = reference.pixels.iter().filter(|p| p.max_component() > 0.0).count();
    assert!(lit * 20 > reference.pixels.len(), "{name}: the picture shows next to nothing");
    let mut ways: Vec<(String, CpuOptions)> = Vec::new();
    for threads in [2, 7] {
        ways.push((format!("{threads} threads"), CpuOptions { threads: Some(threads), ..base }));
    }
    for tile in [1, 5, 8, 64] {
        ways.push((format!("tiles of {tile}"), CpuOptions { threads: Some(2), tile: Some(tile), ..base }));
    }
    for simd in SimdLevel::available() {
        ways.push((format!("bvh, {simd}"), CpuOptions { simd: Some(simd), threads: Some(2), ..base }));
    }
    for simd in SimdLevel::available() {
        let options = CpuOptions { accel: Accel::Bvh8, simd: Some(simd), threads: Some(2), ..base };
        ways.push((format!("bvh8, {simd}"), options));
    }
    ways.push(("no hierarchy".into(), CpuOptions { accel: Accel::None, threads: Some(2), ..base }));
    for level in SimdLevel::ALL.into_iter().filter(|l| !l.is_available()) {
        eprintln!("SKIPPED: {name}: this CPU has no {level}");
    }
    for (way, options) in ways {
        let film = render(&scene, options);
        let first = film.pixels.iter().zip(&reference.pixels).position(|(a, b)| bits(*a) != bits(*b));
        if let Some(at) = first {
            let (x, y) = (at % film.width as usize, at / film.width as usize);
            panic!(
                "{name}, {way}: pixel ({x}, {y}) is {:?}, not {:?}",
                film.pixels[at], reference.pixels[at]
            );
        }
    }
}

fn bits(c: Vec3) -> [u32; 3] {
    [c.x.to_bits(), c.y.to_bits(), c.z.to_bits()]
}

const SIZE: [u32; 2] = [52, 37];

fn cornell(change: impl FnOnce(&mut RenderSettings)) -> Scene {
    let mut scene = load("builtin:cornell", &LoadOptions::default()).unwrap().scene;
    scene.settings.size = SIZE;
    scene.settings.samples = 2;
    scene.settings.light_samples = 5;
    change(&mut scene.settings);
    scene
}

fn material(scene: &mut Scene, kind: MaterialKind) -> u32 {
    scene.materials.push(Material::new(format!("m{}", scene.materials.len()), kind));
    scene.materials.len() as u32 - 1
}

/// A floor, spheres of every kind, a lamp and a spot light.
fn spheres() -> Scene {
    let mut scene = Scene {
        camera: Some(Camera {
            position: vec3(0.3, 2.0, 6.5),
            look_at: Some(vec3(0.0, 0.6, 0.0)),
            ..Camera::default()
        }),
        settings: RenderSettings { size: SIZE, samples: 3, light_samples: 3, ..RenderSettings::default() },
        ..Scene::default()
    };
    let floor = material(&mut scene, MaterialKind::Matte { color: vec3(0.6, 0.5, 0.4) });
    let lamp = material(&mut scene, MaterialKind::Emissive { radiance: vec3(6.0, 5.0, 4.0) });
    scene.parallelograms.push(Parallelogram {
        corner: vec3(-6.0, 0.0, 5.0),
        edge_u: vec3(12.0, 0.0, 0.0),
        edge_v: vec3(0.0, 0.0, -12.0),
        material: floor,
    });
    scene.parallelograms.push(Parallelogram {
        corner: vec3(-1.0, 4.0, -1.0),
        edge_u: vec3(2.0, 0.0, 0.0),
        edge_v: vec3(0.0, 0.0, 2.0),
        material: lamp,
    });
    let white = Vec3::splat(0.7);
    let kinds = [
        MaterialKind::Mirror { reflectance: Vec3::splat(0.9) },
        MaterialKind::Dielectric { ior: 1.5, tint: vec3(0.9, 1.0, 0.95) },
        MaterialKind::Glossy { reflectance: white, exponent: 30.0, rays: 3, color: vec3(0.1, 0.1, 0.0) },
        MaterialKind::Transparent {
            color: vec3(0.9, 0.2, 0.2),
            transparency: 0.6,
            reflection: 0.2,
            shininess: 64.0,
            diffuse: 1.0,
        },
        MaterialKind::Mtl(Mtl { Kd: vec3(0.2, 0.3, 0.8), Ks: Vec3::splat(0.5), Ns: 50.0, ..Mtl::default() }),
    ];
    for (i, kind) in kinds.into_iter().enumerate() {
        let material = material(&mut scene, kind);
        let center = vec3(i as f32 * 1.3 - 2.6, 0.6, (i % 2) as f32 - 0.5);
        scene.spheres.push(Sphere { center, radius: 0.6, material });
    }
    scene.lights.push(Light::Spot {
        position: vec3(3.0, 4.0, 3.0),
        direction: vec3(-3.0, -4.0, -3.0),
        inner_degrees: 10.0,
        outer_degrees: 25.0,
        color: Vec3::splat(20.0),
    });
    scene
}

/// A bumpy patch of 800 triangles, so that it is not baked when placed several times.
fn patch() -> Mesh {
    const N: u32 = 20;
    let height = |i: u32, j: u32| ((i * 7 + j * 13) % 11) as f32 * 0.02;
    let mut mesh = Mesh { name: "patch".into(), ..Mesh::default() };
    for j in 0..=N {
        for i in 0..=N {
            let (x, z) = (i as f32 / N as f32 - 0.5, j as f32 / N as f32 - 0.5);
            mesh.positions.push(vec3(x, height(i, j), -z));
        }
    }
    let mut add = |positions| {
        mesh.triangles.push(Triangle { positions, normals: [NO_INDEX; 3], uvs: [NO_INDEX; 3], material: 0 });
    };
    for j in 0..N {
        for i in 0..N {
            let a = j * (N + 1) + i;
            add([a, a + 1, a + N + 2]);
            add([a, a + N + 2, a + N + 1]);
        }
    }
    mesh
}

fn instances() -> Scene {
    let mut scene = spheres();
    scene.meshes.push(patch());
    for k in 0..6 {
        let angle = k as f32 * 57.0;
        scene.instances.push(Instance {
            mesh: 0,
            material: None,
            world_from_object: Transform {
                scale: vec3(1.0 + k as f32 * 0.3, if k % 2 == 0 { 1.0 } else { -2.0 }, 1.5),
                rotate_degrees: vec3(angle, angle * 0.5, 10.0),
                translate: vec3(k as f32 - 2.5, 1.2 + 0.2 * k as f32, -1.0),
                ..Transform::default()
            },
            moves: Vec::new(),
        });
    }
    scene
}

fn moved(mut scene: Scene, offset: Vec3) -> Scene {
    let camera = scene.camera.as_mut().unwrap();
    camera.position += offset;
    camera.look_at = camera.look_at.map(|p| p + offset);
    scene.spheres.iter_mut().for_each(|s| s.center += offset);
    scene.parallelograms.iter_mut().for_each(|p| p.corner += offset);
    for instance in &mut scene.instances {
        instance.world_from_object.translate += offset;
    }
    for light in &mut scene.lights {
        if let Light::Point { position, .. } | Light::Spot { position, .. } = light {
            *position += offset;
        }
    }
    scene
}

#[test]
fn cornell_as_shipped() {
    assert_identical("cornell", &cornell(|_| {}));
}

#[test]
fn cornell_with_preset_pg1() {
    let mut scene = cornell(|_| {});
    Preset::Pg1.apply(&mut scene);
    scene.settings.size = SIZE;
    assert_identical("cornell pg1", &scene);
}

#[test]
fn cornell_with_preset_eos() {
    let mut scene = cornell(|_| {});
    Preset::Eos.apply(&mut scene);
    scene.settings.size = SIZE;
    assert_identical("cornell eos", &scene);
}

#[test]
fn every_lighting_model() {
    for lighting in [
        LightingModel::Distance,
        LightingModel::Diffuse,
        LightingModel::Lambert,
        LightingModel::Phong,
        LightingModel::BlinnPhong,
    ] {
        assert_identical(&format!("{lighting:?}"), &cornell(|s| s.lighting = lighting));
    }
}

#[test]
fn every_shadow_and_fresnel_mode() {
    for (shadows, fresnel) in [
        (ShadowMode::None, FresnelMode::Exact),
        (ShadowMode::Opaque, FresnelMode::Schlick),
        (ShadowMode::Coloured, FresnelMode::Constant),
    ] {
        let mut scene = spheres();
        (scene.settings.shadows, scene.settings.fresnel) = (shadows, fresnel);
        scene.settings.light_from_behind = true;
        assert_identical(&format!("{shadows:?}, {fresnel:?}"), &scene);
    }
}

#[test]
fn lens_and_sample_grid() {
    let mut scene = spheres();
    scene.camera.as_mut().unwrap().lens = Some(Lens { aperture_radius: 0.2, focus_distance: None });
    scene.settings.pixel_sampling = PixelSampling::Grid(2);
    assert_identical("lens", &scene);
}

#[test]
fn culling_and_normals() {
    for normals in [NormalMode::Flat, NormalMode::Smooth, NormalMode::Generated] {
        let scene = cornell(|s| {
            s.normals = normals;
            s.cull_back_faces = true;
        });
        assert_identical(&format!("culling, {normals:?}"), &scene);
    }
}

#[test]
fn instances_traced_in_their_own_space() {
    let scene = instances();
    let (data, _) = SceneData::flatten(&scene).unwrap();
    assert!(data.instances.len() > 2, "the mesh must not be baked");
    assert_identical("instances", &scene);
}

#[test]
fn far_from_the_origin() {
    for distance in [100.0, 10_000.0] {
        let scene = moved(instances(), vec3(distance, -distance, 2.0 * distance));
        assert_identical(&format!("{distance} from the origin"), &scene);
    }
}

#[test]
fn surfaces_of_model_files() {
    let mut scene = crate::surfaces::scene();
    assert_identical("surfaces", &scene);
    let camera = scene.camera.as_mut().unwrap();
    camera.orthographic_height = Some(3.5);
    scene.settings.shadows = ShadowMode::Opaque;
    assert_identical("surfaces, orthographic", &scene);
}

#[test]
fn textured_floor() {
    use eosphor_core::texture::TextureFilter;
    for filter in [TextureFilter::Nearest, TextureFilter::Bilinear] {
        let mut scene = spheres();
        let texels = (0..64u32).map(|i| 0xff00_0000 | ((i * 0x0003_0501) & 0x00ff_ffff)).collect();
        let texels = Texels::rgba8(texels);
        scene.images.push(Image { name: "dots".into(), width: 8, height: 8, texels });
        scene.textures.push(Texture { filter, ..Texture::of_image(0) });
        scene.materials[0].textures.color = Some(0);
        assert_identical(&format!("{filter:?}"), &scene);
    }
}

/// Rows of a picture, rendered band by band and joined.
fn in_bands(scene: &Arc<SceneData>, options: CpuOptions, rows: u32) -> Vec<[u32; 3]> {
    let prepared = CpuBackend::new(options).unwrap().prepare(Arc::clone(scene)).unwrap();
    let cancel = AtomicBool::new(false);
    let control = RenderControl { on_progress: &|_| {}, cancel: &cancel, count_work: false, frame: None };
    let band = |rows| prepared.render_rows(rows, &control).unwrap().film.pixels;
    Bands::of_rows(prepared.size().1, rows).flat_map(band).map(bits).collect()
}

/// A frame over what was built for another is the picture of a scene with that camera.
#[test]
fn frames_over_one_hierarchy() {
    let mut scene = spheres();
    let orbit = CameraMotion::Orbit { turns: 0.3, around: Some(vec3(0.0, 0.5, 0.0)) };
    scene.animation = Some(Animation { camera: Some(orbit), ..Animation::of_frames(5) });
    let data = Arc::new(SceneData::flatten(&scene).unwrap().0);
    let states = FrameStates::new(&scene, &data);
    let options = CpuOptions { threads: Some(2), ..CpuOptions::default() };
    let prepared = CpuBackend::new(options).unwrap().prepare(Arc::clone(&data)).unwrap();
    let mut pictures = Vec::new();
    for frame in [3, 0, 4] {
        let state = states.at(frame).unwrap();
        let control = RenderControl {
            on_progress: &|_| {},
            cancel: &AtomicBool::new(false),
            count_work: false,
            frame: Some(&state),
        };
        let found = prepared.render(&control).unwrap().film;
        let still = Scene { camera: scene.camera_at(frame), animation: None, ..scene.clone() };
        let expected = render(&Arc::new(SceneData::flatten(&still).unwrap().0), options);
        assert!(found == expected, "frame {frame}");
        pictures.push(found);
    }
    assert!(pictures[0] != pictures[1] && pictures[1] != pictures[2]);
}

/// A frame of another size and with other samples than the scene that was prepared.
#[test]
fn frames_of_other_sizes() {
    let scene = spheres();
    let data = Arc::new(SceneData::flatten(&scene).unwrap().0);
    let states = FrameStates::new(&scene, &data);
    let options = CpuOptions { threads: Some(2), ..CpuOptions::default() };
    let prepared = CpuBackend::new(options).unwrap().prepare(Arc::clone(&data)).unwrap();
    for (size, samples) in [([5, 3], 1), ([131, 90], 2)] {
        let mut other = scene.clone();
        (other.settings.size, other.settings.samples) = (size, samples);
        let state = states.seen_by(0, other.camera.as_ref(), &other.settings).unwrap();
        let cancel = AtomicBool::new(false);
        let control =
            RenderControl { on_progress: &|_| {}, cancel: &cancel, count_work: false, frame: Some(&state) };
        let expected = render(&Arc::new(SceneData::flatten(&other).unwrap().0), options);
        assert!(prepared.render(&control).unwrap().film == expected, "{size:?}");
        let sums = prepared.sample_rows(0..size[1], 0..samples, &control).unwrap().sums;
        assert!(sums.film(samples) == expected, "{size:?}");
        assert!(prepared.sample_rows(0..size[1] + 1, 0..samples, &control).is_err());
        assert!(prepared.sample_rows(0..size[1], 0..samples + 1, &control).is_err());
    }
}

/// The motion from frame to frame of objects, of which one shines: 16 steps of an eighth each, and a turn.
fn motion(keys: &[f32]) -> Vec<Arc<Move>> {
    let key = |&frame: &f32| MoveKey {
        seconds: frame - keys[0],
        translate: Some(vec3(frame / 8.0, frame / 16.0, 0.0)),
        rotate_degrees: Some(vec3(0.0, frame * 10.0, 0.0)),
        ..MoveKey::default()
    };
    let (keys, interpolation) = (keys.iter().map(key).collect(), Interpolation::Linear);
    vec![Arc::new(Move { keys, interpolation, around: vec3(0.5, 0.0, -1.0), ..Move::default() })]
}

/// Frames in which instances are elsewhere are those of a scene that has them there, in every structure and way.
#[test]
fn frames_of_moving_instances() {
    let mut scene = instances();
    scene.animation = Some(Animation { fps: 1.0, ..Animation::of_frames(9) });
    let shining = Material::new("lamp", MaterialKind::Emissive { radiance: vec3(0.02, 0.01, 0.0) });
    scene.materials.push(shining);
    let lamp = scene.materials.len() as u32 - 1;
    scene.instances[2].material = Some(lamp);
    scene.settings.light_samples = 1;
    // One stands still.
    scene.instances.iter_mut().skip(1).for_each(|instance| instance.moves = motion(&[0.0, 8.0]));
    let data = Arc::new(SceneData::flatten(&scene).unwrap().0);
    let states = FrameStates::new(&scene, &data);
    let base = CpuOptions { threads: Some(2), ..CpuOptions::default() };
    let options: Vec<CpuOptions> = Accel::ALL.iter().map(|&accel| CpuOptions { accel, ..base }).collect();
    let prepared: Vec<_> = options
        .iter()
        .map(|&options| CpuBackend::new(options).unwrap().prepare(Arc::clone(&data)).unwrap())
        .collect();
    let mut pictures = Vec::new();
    for frame in [5, 0, 8] {
        let mut still = scene.clone();
        still.instances.iter_mut().skip(1).for_each(|instance| instance.moves = motion(&[frame as f32]));
        let expected = render(&Arc::new(SceneData::flatten(&still).unwrap().0), options[0]);
        let state = states.at(frame).unwrap();
        for (prepared, options) in prepared.iter().zip(&options) {
            // Without a structure it takes long, and once is enough.
            let is_slow = options.accel == Accel::None;
            if is_slow && frame != 8 {
                continue;
            }
            for count_work in [false, true].into_iter().skip(usize::from(is_slow)) {
                let (on_progress, cancel) = (&|_| {}, &AtomicBool::new(false));
                let control = RenderControl { on_progress, cancel, count_work, frame: Some(&state) };
                let found = prepared.render(&control).unwrap().film;
                assert!(found == expected, "frame {frame}, {}, counting: {count_work}", options.accel);
            }
        }
        pictures.push(expected);
    }
    assert!(pictures[0] != pictures[1] && pictures[1] != pictures[2]);
}

#[test]
fn bands_of_rows() {
    let (data, _) = SceneData::flatten(&spheres()).unwrap();
    let scene = Arc::new(data);
    let options = CpuOptions { threads: Some(2), ..CpuOptions::default() };
    let whole: Vec<[u32; 3]> = render(&scene, options).pixels.into_iter().map(bits).collect();
    for rows in [1, 3, 16, 36, 37, 1000] {
        assert!(in_bands(&scene, options, rows) == whole, "bands of {rows} rows");
    }
    let prepared = CpuBackend::new(options).unwrap().prepare(scene).unwrap();
    let control = RenderControl {
        on_progress: &|_| {},
        cancel: &AtomicBool::new(false),
        count_work: false,
        frame: None,
    };
    for rows in [0..38, 37..38, 5..5, std::ops::Range { start: 9, end: 3 }] {
        assert!(prepared.render_rows(rows.clone(), &control).is_err(), "{rows:?}");
    }
}

#[test]
fn features_are_the_same_bits_everywhere() {
    let mut lens = spheres();
    lens.camera.as_mut().unwrap().lens = Some(Lens { aperture_radius: 0.2, focus_distance: None });
    for (name, scene) in [("cornell", cornell(|_| {})), ("instances", instances()), ("lens", lens)] {
        let (data, _) = SceneData::flatten(&scene).unwrap();
        let scene = Arc::new(data);
        let trace = |options, rows| {
            let pass = CpuBackend::new(options).unwrap().feature_pass(Arc::clone(&scene), None).unwrap();
            let band = |rows| pass.rows(rows, None, &AtomicBool::new(false)).unwrap();
            let bands: Vec<FeatureRows> = Bands::of_rows(SIZE[1], rows).map(band).collect();
            let pixels =
                bands.iter().flat_map(|band| band.pixels.iter().map(feature_bits)).collect::<Vec<_>>();
            (pixels, bands.into_iter().flat_map(|band| band.work).collect::<Vec<_>>())
        };
        let base = CpuOptions { threads: Some(1), ..CpuOptions::default() };
        let (reference, work) = trace(base, u32::MAX);
        assert!(reference.iter().any(|pixel| *pixel != feature_bits(&PixelFeatures::NOTHING)));
        let mut ways = vec![
            CpuOptions { threads: Some(7), ..base },
            CpuOptions { threads: Some(2), tile: Some(5), ..base },
            CpuOptions { accel: Accel::None, threads: Some(2), ..base },
        ];
        ways.extend(SimdLevel::available().map(|simd| CpuOptions { simd: Some(simd), ..base }));
        for options in ways {
            for rows in [u32::MAX, 7] {
                let (pixels, other_work) = trace(options, rows);
                assert!(pixels == reference, "{name}, {options:?}, bands of {rows} rows");
                assert!(other_work == work || options.accel == Accel::None, "{name}, {options:?}");
            }
        }
    }
}

fn feature_bits(features: &PixelFeatures) -> [u32; 12] {
    let PixelFeatures { albedo, normal, depth, object, material, background } = *features;
    let ([r, g, b], [x, y, z], [u, v, w]) = (bits(albedo), bits(normal), bits(background));
    [r, g, b, x, y, z, depth.to_bits(), object, material, u, v, w]
}
