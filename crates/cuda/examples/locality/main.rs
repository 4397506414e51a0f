//! Whether far and huge things that no ray of a picture meets change a bit of it, on CPU and GPU.
//!
//! `locality [--device cpu|cuda|cuda:0,1] [--times X] SCENE [FLAGS OF eosphor render]`, or `--random N` for N random
//! scenes instead of one by name. Things lie X times the scene's extent away: 10, 10^4 and 10^7 otherwise. On the CPU every
//! structure renders, on the GPU the one that flags name. A line a distance; exit code 1 where a film differs.
//! `LOCALITY=.../locality gpu/compare-pairs PROGRAM SCENES` takes the scenes and settings of that script.

#[path = "../../../render/tests/locality/far.rs"]
mod far;
mod flags;
#[path = "../../../render/tests/locality/random_scene.rs"]
mod random_scene;
#[allow(dead_code, reason = "tests take the rest")]
#[path = "../../../accel/tests/truth/shapes.rs"]
mod shapes;
#[allow(dead_code, reason = "tests take the rest")]
#[path = "../../../accel/tests/truth/vector.rs"]
mod vector;

use eosphor_cuda::CudaBackend;
use eosphor_render::{Accel, Backend, CpuBackend, CpuOptions, Film, RenderControl, SimdLevel};
use eosphor_scene::{Camera, Scene, SceneData};
use far::{Queries, Random, add_far_things};
use flags::{Asked, Subject};
use std::error::Error;
use std::process::ExitCode;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

fn main() -> ExitCode {
    match run() {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => ExitCode::FAILURE,
        Err(error) => {
            eprintln!("locality: {error}");
            ExitCode::FAILURE
        }
    }
}

/// Whether all films are identical.
fn run() -> Result<bool, Box<dyn Error>> {
    let asked = Asked::parse(std::env::args().skip(1))?;
    let gpu = asked.cuda.clone().map(CudaBackend::new).transpose()?;
    let mut identical = true;
    match &asked.subject {
        Subject::Scene(scene) => {
            let scene = explicit(scene)?;
            for (seed, &times) in asked.times.iter().enumerate() {
                identical &= check("scene", &scene, times, &mut Random(seed as u64), gpu.as_ref())?;
            }
        }
        Subject::Random(count) => {
            for seed in 0..*count {
                let mut random = Random(seed);
                let scene = random_scene::random_scene(&mut random);
                let times = asked.times[seed as usize % asked.times.len()];
                identical &= check(&format!("random {seed}"), &scene, times, &mut random, gpu.as_ref())?;
            }
        }
    }
    Ok(identical)
}

/// The scene with the camera and the maximal distance said that it would have by itself.
fn explicit(scene: &Scene) -> Result<Scene, Box<dyn Error>> {
    let (data, _) = SceneData::flatten(scene)?;
    let mut scene = scene.clone();
    scene.settings.max_distance = Some(data.settings.max_distance);
    scene.camera.get_or_insert(Camera {
        position: data.camera.eye,
        direction: data.camera.forward,
        up: data.camera.up,
        fov_x_degrees: (2.0 * data.camera.half_width.atan()).to_degrees(),
        ..Camera::default()
    });
    Ok(scene)
}

fn render(backend: &dyn Backend, data: &Arc<SceneData>) -> Result<Film, Box<dyn Error>> {
    let prepared = backend.prepare(Arc::clone(data))?;
    let cancel = AtomicBool::new(false);
    let control = RenderControl { on_progress: &|_| {}, cancel: &cancel, count_work: false, frame: None };
    Ok(prepared.render(&control)?.film)
}

/// Queries times primitives that no structure at all may have to test.
const PATIENCE: usize = 4_000_000_000;

/// Every way on the CPU, by name.
fn ways(work: usize) -> Result<Vec<(String, CpuBackend)>, Box<dyn Error>> {
    let structures = Accel::ALL.iter().filter(|accel| **accel != Accel::None || work < PATIENCE);
    let structures =
        structures.map(|&accel| (accel.to_string(), CpuOptions { accel, ..CpuOptions::default() }));
    let levels = SimdLevel::available().map(|simd| {
        let options = CpuOptions { accel: Accel::Bvh8, simd: Some(simd), ..CpuOptions::default() };
        (format!("bvh8 {simd}"), options)
    });
    structures.chain(levels).map(|(name, options)| Ok((name, CpuBackend::new(options)?))).collect()
}

/// Prints a line; whether all films of a scene and of the scene with far things are identical.
fn check(
    name: &str,
    scene: &Scene,
    times: f32,
    random: &mut Random,
    gpu: Option<&CudaBackend>,
) -> Result<bool, Box<dyn Error>> {
    let data = Arc::new(SceneData::flatten(scene)?.0);
    let queries = Queries::of(&data);
    let Some(extended) = add_far_things(scene, &queries, data.world_bounds().extent(), times, random) else {
        println!("NO ROOM    {name}, {times:e} extents away: {} queries go everywhere", queries.count());
        return Ok(false);
    };
    let more = Arc::new(SceneData::flatten(&extended.scene)?.0);
    let met = Queries::of(&more).met(&extended.balls);
    let reference = render(&CpuBackend::new(CpuOptions::default())?, &data)?;
    let mut wrong = Vec::new();
    let mut compare = |way: &str, film: Film| {
        let pixels = film.pixels.iter().zip(&reference.pixels).filter(|(a, b)| bits(a) != bits(b)).count();
        if pixels > 0 {
            wrong.push(format!("{way}: {pixels} pixels"));
        }
    };
    for (way, backend) in ways(queries.count() * (data.triangles.len() + data.spheres.len()))? {
        compare(&way, render(&backend, &more)?);
    }
    if let Some(gpu) = gpu {
        compare("GPU, nothing added", render(gpu, &data)?);
        compare("GPU", render(gpu, &more)?);
    }
    if met > 0 {
        wrong.push(format!("{met} queries meet what none met before"));
    }
    let (verdict, count) = (if wrong.is_empty() { "IDENTICAL" } else { "DIFFERENT" }, queries.count());
    println!(
        "{verdict}  {name}, {times:e} extents away: {count} queries, {met} meet what was added {}",
        wrong.join(", ")
    );
    Ok(wrong.is_empty())
}

fn bits(p: &eosphor_core::math::Vec3) -> [u32; 3] {
    [p.x, p.y, p.z].map(f32::to_bits)
}
