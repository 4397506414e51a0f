//! Small scenes, and what a ray sees in them.

use eosphor_core::math::{Vec3, vec3};
use eosphor_core::settings::{LightingModel, ShadowMode};
use eosphor_render::{Backend, CpuBackend, CpuOptions, Film, RenderControl};
use eosphor_scene::{
    Camera, Material, MaterialKind, NormalMode, Parallelogram, PixelSampling, RenderSettings, Scene,
    SceneData, Sphere,
};
use std::sync::atomic::AtomicBool;
use std::sync::{Arc, OnceLock};

/// The irradiance that a white matte surface answers by a radiance of 1.
pub(crate) const PI: f32 = std::f32::consts::PI;

/// Lambert, opaque shadows, black background, nothing cut off, one sample in the middle of one pixel.
pub(crate) fn scene() -> Scene {
    let settings = RenderSettings {
        size: [1, 1],
        pixel_sampling: PixelSampling::Center,
        energy_threshold: 0.0,
        lighting: LightingModel::Lambert,
        shadows: ShadowMode::Opaque,
        normals: NormalMode::Flat,
        srgb_textures: false,
        ..RenderSettings::default()
    };
    Scene { settings, ..Scene::default() }
}

/// Adds a material; returns its number.
pub(crate) fn material(scene: &mut Scene, kind: MaterialKind) -> u32 {
    scene.materials.push(Material::new("m", kind));
    scene.materials.len() as u32 - 1
}

pub(crate) fn matte(scene: &mut Scene, color: Vec3) -> u32 {
    material(scene, MaterialKind::Matte { color })
}

pub(crate) fn emissive(scene: &mut Scene, radiance: Vec3) -> u32 {
    material(scene, MaterialKind::Emissive { radiance })
}

/// Adds a rectangle about `center` with half edges `u` and `v`; its front is the side of `u x v`.
pub(crate) fn rectangle(scene: &mut Scene, center: Vec3, u: Vec3, v: Vec3, material: u32) {
    let corner = center - u - v;
    scene.parallelograms.push(Parallelogram { corner, edge_u: u * 2.0, edge_v: v * 2.0, material });
}

/// A horizontal square that faces up, with sides of 2 `half`. Shadow rays start 2^-17 of the scene's extent off a surface:
/// small scenes keep that out of the comparisons.
pub(crate) fn floor(scene: &mut Scene, height: f32, half: f32, material: u32) {
    // Not symmetric, so that no ray of a test meets the diagonal.
    let center = vec3(half * 0.1, height, -half * 0.15);
    rectangle(scene, center, vec3(0.0, 0.0, half), vec3(half, 0.0, 0.0), material);
}

pub(crate) fn sphere(scene: &mut Scene, center: Vec3, radius: f32, material: u32) {
    scene.spheres.push(Sphere { center, radius, material });
}

/// A camera at `from` that looks at `to`.
pub(crate) fn looking(from: Vec3, to: Vec3, fov_x_degrees: f32) -> Camera {
    let vertical = (to - from).normalize().y.abs() > 0.99;
    let up = if vertical { vec3(0.0, 0.0, -1.0) } else { vec3(0.0, 1.0, 0.0) };
    Camera { position: from, look_at: Some(to), up, fov_x_degrees, ..Camera::default() }
}

/// The picture.
pub(crate) fn render(scene: &Scene) -> Film {
    render_changed(scene, |_| {})
}

/// The same where flattening is not all that makes its arrays.
fn render_changed(scene: &Scene, change: impl Fn(&mut SceneData)) -> Film {
    static BACKEND: OnceLock<CpuBackend> = OnceLock::new();
    let backend = BACKEND.get_or_init(|| CpuBackend::new(CpuOptions::default()).unwrap());
    let (mut data, _) = SceneData::flatten(scene).unwrap();
    change(&mut data);
    let prepared = backend.prepare(Arc::new(data)).unwrap();
    let control = RenderControl {
        on_progress: &|_| {},
        cancel: &AtomicBool::new(false),
        count_work: false,
        frame: None,
    };
    let rendered = prepared.render(&control).unwrap();
    assert!(rendered.complete);
    rendered.film
}

/// What comes back along the ray from `from` towards `to`.
pub(crate) fn probe(scene: &Scene, from: Vec3, to: Vec3) -> Vec3 {
    probe_data(scene, from, to, |_| {})
}

/// The same where the scene's arrays are changed.
pub(crate) fn probe_data(scene: &Scene, from: Vec3, to: Vec3, change: impl Fn(&mut SceneData)) -> Vec3 {
    let mut scene = scene.clone();
    scene.camera = Some(looking(from, to, 10.0));
    scene.settings.size = [1, 1];
    render_changed(&scene, change).pixels[0]
}

pub(crate) fn pixel(film: &Film, x: u32, y: u32) -> Vec3 {
    film.pixels[(y * film.width + x) as usize]
}

/// Asserts a relative error per channel (and an absolute one for what is nearly black).
#[track_caller]
pub(crate) fn assert_near(got: Vec3, expected: [f64; 3], relative: f64) {
    for (g, e) in <[f32; 3]>::from(got).into_iter().zip(expected) {
        assert!((g as f64 - e).abs() <= relative * e.abs() + 1e-8, "{got:?} instead of {expected:?}");
    }
}

#[track_caller]
pub(crate) fn assert_grey(got: Vec3, expected: f64, relative: f64) {
    assert_near(got, [expected; 3], relative);
}

// --- Double precision ------------------------------------------------------------------------------------------------

pub(crate) type V = [f64; 3];

pub(crate) fn double(v: Vec3) -> V {
    [v.x as f64, v.y as f64, v.z as f64]
}
pub(crate) fn single(v: V) -> Vec3 {
    vec3(v[0] as f32, v[1] as f32, v[2] as f32)
}
pub(crate) fn dot(a: V, b: V) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}
pub(crate) fn cross(a: V, b: V) -> V {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}
pub(crate) fn sub(a: V, b: V) -> V {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}
/// `a + d t`.
pub(crate) fn along(a: V, d: V, t: f64) -> V {
    [a[0] + d[0] * t, a[1] + d[1] * t, a[2] + d[2] * t]
}
pub(crate) fn length(v: V) -> f64 {
    dot(v, v).sqrt()
}
pub(crate) fn unit(v: V) -> V {
    v.map(|x| x / length(v))
}

/// Direction of the middle of a pixel, of unit length.
pub(crate) fn pixel_direction(camera: &Camera, [width, height]: [u32; 2], x: f64, y: f64) -> V {
    let forward = unit(sub(double(camera.look_at.unwrap()), double(camera.position)));
    let right = unit(cross(forward, double(camera.up)));
    let up = cross(right, forward);
    let half = (camera.fov_x_degrees as f64 * 0.5).to_radians().tan();
    let across = (2.0 * x / width as f64 - 1.0) * half;
    let down = (2.0 * y / height as f64 - 1.0) * half * height as f64 / width as f64;
    unit(along(along(forward, right, across), up, -down))
}

/// Fresnel's reflectance of unpolarised light and the cosine beyond; `eta` is the index here over that beyond.
pub(crate) fn fresnel(cos_in: f64, eta: f64) -> (f64, f64) {
    let sin2_out = eta * eta * (1.0 - cos_in * cos_in);
    if sin2_out >= 1.0 {
        return (1.0, 0.0);
    }
    let cos_out = (1.0 - sin2_out).sqrt();
    let s = (eta * cos_in - cos_out) / (eta * cos_in + cos_out);
    let p = (cos_in - eta * cos_out) / (cos_in + eta * cos_out);
    (0.5 * (s * s + p * p), cos_out)
}

/// Snell's law; `n` is on the side that `d` comes from.
pub(crate) fn refract(d: V, n: V, eta: f64) -> V {
    let cos_in = -dot(d, n);
    let (_, cos_out) = fresnel(cos_in, eta);
    unit(along(d.map(|x| x * eta), n, eta * cos_in - cos_out))
}

/// SplitMix64 (Steele et al. 2014): plain random numbers in [0, 1).
pub(crate) struct Random(pub(crate) u64);

impl Random {
    pub(crate) fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
    }
}
