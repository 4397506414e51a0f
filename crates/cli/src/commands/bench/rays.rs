//! `eosphor bench rays SCENE`: how fast a device answers queries about rays, and whether it answers as the CPU does.

use super::export::export;
use super::{answered, lines, median, timed};
use crate::arguments::{BackendChoice, BenchRaysFlags, would_do_nothing};
use crate::backend::{check_device, cpu_backend, hierarchy_options, limit_threads};
use crate::failure::Failure;
use crate::streams;
use crate::text::grouped;
use eosphor::math::Vec3;
use eosphor::rays::{CudaRays, Hit, Ray, RaySets};
use eosphor::{
    Accel, CpuBackend, Hierarchy, HierarchyOptions, LoadOptions, SceneData, build_hierarchy, load,
};
use eosphor_lab::{Quantity, Stopwatch, Times};
use serde::Serialize;
use std::fmt::Write;

#[derive(Serialize)]
struct Report {
    device: String,
    triangles: usize,
    accel: Accel,
    rows: Vec<Row>,
}

/// One query over one set.
#[derive(Serialize)]
struct Row {
    set: &'static str,
    query: &'static str,
    rays: usize,
    /// Median over the repetitions: of the kernel on a GPU, of the whole query on the CPU.
    milliseconds: f64,
    mrays_per_second: f64,
    /// Answers that are not the CPU's, bit for bit. The CPU itself is compared with its own scalar search.
    different: usize,
    /// For `eosphor lab`.
    #[serde(skip)]
    times: Times,
    #[serde(skip)]
    answer: blake3::Hash,
}

/// What answers.
enum Device<'a> {
    Cpu(&'a CpuBackend, Hierarchy),
    Cuda(CudaRays),
}

pub(crate) fn bench_rays(flags: &BenchRaysFlags) -> Result<(), Failure> {
    flags.check()?;
    check_device(&flags.device, flags.accel)?;
    limit_threads(&flags.device)?;
    let mut options = LoadOptions::default();
    options.camera = flags.camera.choice();
    options.texture_memory_bytes = flags.textures.memory_bytes();
    let mut scene = load(&flags.scene, &options)?.scene;
    scene.settings.size = flags.size;
    flags.camera.apply(&mut scene)?;
    scene.validate().map_err(Failure::usage)?;
    let (data, _) = SceneData::flatten(&scene)?;
    let options = hierarchy_options(&flags.device);
    let cpu = cpu_backend(&flags.device, flags.accel)?;
    let fast = build_hierarchy(Accel::Bvh8, &HierarchyOptions::default(), &data)?;
    let mut sets = RaySets::new(&data, |rays| cpu.closest_hits(&fast, rays));
    if let Some(diagonals) = flags.distance {
        move_back(&mut sets.primary, diagonals * diagonal(&data));
    }
    let sets = sets;
    let mut built = Times::default();
    // What is measured is compared with another structure: bvh8, or bvh where bvh8 itself is measured.
    let (device, reference) = match flags.device.backend() {
        BackendChoice::Auto | BackendChoice::Cpu => {
            let accel = flags.accel.unwrap_or(Accel::Bvh8);
            let watch = Stopwatch::start();
            let measured = build_hierarchy(accel, &options, &data)?;
            watch.stop(&mut built);
            let plain = || build_hierarchy(Accel::Bvh, &HierarchyOptions::default(), &data);
            (Device::Cpu(&cpu, measured), if accel == Accel::Bvh8 { plain()? } else { fast })
        }
        BackendChoice::Cuda(devices) => {
            let Hierarchy::Bvh(bvh) = &build_hierarchy(Accel::Bvh, &options, &data)? else {
                unreachable!("it was asked for")
            };
            if !matches!(flags.accel, None | Some(Accel::Bvh)) {
                return Err(would_do_nothing(
                    "--accel",
                    "--backend cpu (on GPUs, rays are traced through a bvh)",
                ));
            }
            let device = match devices[..] {
                [] => 0,
                [device] => device,
                _ => {
                    let problem =
                        "rays are traced on one device at a time: choose one, as in --backend cuda:0";
                    return Err(Failure::usage(problem));
                }
            };
            (Device::Cuda(CudaRays::new(device, bvh, flags.device.gpu_traversal)?), fast)
        }
    };
    let (accel, triangles) = (device.accel(), data.triangles.len());
    let mut report = Report { device: device.describe(), triangles, accel, rows: Vec::new() };
    let sets = [("primary", &sets.primary), ("bounce", &sets.bounce), ("shuffled", &sets.shuffled)];
    if let Some(folder) = &flags.export {
        export(folder, &data, sets, |rays| cpu.closest_hits(&reference, rays))?;
    }
    for (set, rays) in sets {
        let (hits, times) = device.closest_hits(rays, flags)?;
        let expected = cpu.closest_hits(&reference, rays);
        let different = hits.iter().zip(&expected).filter(|(a, b)| bits(a) != bits(b)).count();
        report.rows.push(Row::new(set, "closest hit", rays, times, different, hash_of_hits(&hits)));
        let (hidden, times) = device.occluded(rays, flags)?;
        let expected = cpu.occluded_rays(&reference, rays);
        let different = hidden.iter().zip(&expected).filter(|(a, b)| a != b).count();
        let bytes: Vec<u8> = hidden.iter().map(|&is| u8::from(is)).collect();
        report.rows.push(Row::new(set, "any hit", rays, times, different, blake3::hash(&bytes)));
    }
    let different: usize = report.rows.iter().map(|row| row.different).sum();
    match (flags.json, flags.lines) {
        (true, _) => streams::json(&report)?,
        (_, true) => streams::result(&lines(&report.quantities(&built))?)?,
        _ => streams::result(&report.table())?,
    }
    match different {
        0 => Ok(()),
        n => Err(Failure::Failed(format!(
            "{} answers differ from the CPU's: please report this",
            grouped(n as u64)
        ))),
    }
}

/// All that a hit says, so that no difference is too small.
fn bits(hit: &Hit) -> (u32, u32, u32, u32, u32) {
    (hit.t.to_bits(), hit.u.to_bits(), hit.v.to_bits(), hit.id.instance, hit.id.primitive)
}

fn hash_of_hits(hits: &[Hit]) -> blake3::Hash {
    let mut hasher = blake3::Hasher::new();
    for hit in hits {
        let (t, u, v, instance, primitive) = bits(hit);
        [t, u, v, instance, primitive].iter().for_each(|word| {
            hasher.update(&word.to_le_bytes());
        });
    }
    hasher.finalize()
}

impl Device<'_> {
    fn describe(&self) -> String {
        match self {
            Device::Cpu(cpu, _) => format!("CPU, {} threads, {}", cpu.threads(), cpu.simd()),
            Device::Cuda(cuda) => cuda.device_name().to_owned(),
        }
    }

    fn accel(&self) -> Accel {
        match self {
            Device::Cpu(_, hierarchy) => hierarchy.accel(),
            Device::Cuda(_) => Accel::Bvh,
        }
    }

    /// And the time of each repetition.
    fn closest_hits(&self, rays: &[Ray], flags: &BenchRaysFlags) -> Result<(Vec<Hit>, Times), Failure> {
        match self {
            Device::Cpu(cpu, hierarchy) => {
                Ok(repeated(flags, rays, |rays| cpu.closest_hits(hierarchy, rays)))
            }
            Device::Cuda(cuda) => {
                let timed = cuda.closest_hits(rays, flags.repeats)?;
                Ok((timed.answers, of_kernels(&timed.milliseconds)))
            }
        }
    }

    fn occluded(&self, rays: &[Ray], flags: &BenchRaysFlags) -> Result<(Vec<bool>, Times), Failure> {
        match self {
            Device::Cpu(cpu, hierarchy) => {
                Ok(repeated(flags, rays, |rays| cpu.occluded_rays(hierarchy, rays)))
            }
            Device::Cuda(cuda) => {
                let timed = cuda.occluded(rays, flags.repeats)?;
                Ok((timed.answers, of_kernels(&timed.milliseconds)))
            }
        }
    }
}

fn of_kernels(milliseconds: &[f32]) -> Times {
    Times { wall: milliseconds.iter().map(|&t| t as f64).collect(), cpu: Vec::new() }
}

/// Answers to warm up, and then as often as is said, so many rays a call.
fn repeated<T>(flags: &BenchRaysFlags, rays: &[Ray], answer: impl Fn(&[Ray]) -> Vec<T>) -> (Vec<T>, Times) {
    let in_calls = || match flags.batch {
        None => answer(rays),
        Some(batch) => {
            let mut answers = Vec::with_capacity(rays.len());
            rays.chunks(batch).for_each(|rays| answers.extend(answer(rays)));
            answers
        }
    };
    (0..flags.warm_up).for_each(|_| drop(in_calls()));
    let (mut answers, mut times) = (Vec::new(), Times::default());
    for _ in 0..flags.repeats {
        let watch = Stopwatch::start();
        answers = in_calls();
        watch.stop(&mut times);
    }
    (answers, times)
}

/// Moves origins back along their rays, in units of the scene.
fn move_back(rays: &mut [Ray], distance: f32) {
    rays.iter_mut().for_each(|ray| ray.origin = ray.origin - ray.direction * distance);
}

/// From corner to corner of the box around all triangles.
fn diagonal(data: &SceneData) -> f32 {
    let corners = || data.triangles.iter().flatten();
    let extent = |of: fn(&Vec3) -> f32| {
        let (low, high) = corners()
            .map(of)
            .fold((f32::INFINITY, f32::NEG_INFINITY), |(low, high), x| (low.min(x), high.max(x)));
        (high - low).max(0.0)
    };
    let [x, y, z] = [extent(|p| p.x), extent(|p| p.y), extent(|p| p.z)];
    (x * x + y * y + z * z).sqrt()
}

impl Row {
    fn new(
        set: &'static str,
        query: &'static str,
        rays: &[Ray],
        times: Times,
        different: usize,
        answer: blake3::Hash,
    ) -> Row {
        let milliseconds = median(&times.wall);
        let mrays_per_second = if milliseconds > 0.0 { rays.len() as f64 * 1e-3 / milliseconds } else { 0.0 };
        Row { set, query, rays: rays.len(), milliseconds, mrays_per_second, different, times, answer }
    }
}

impl Report {
    /// For `eosphor lab`.
    fn quantities(&self, built: &Times) -> Vec<Quantity> {
        let of_row = |row: &Row| {
            answered(&format!("{}, {}", row.set, row.query), &row.times, row.rays as u64, row.answer)
        };
        let built = (!built.wall.is_empty()).then(|| timed("build", built));
        built.into_iter().chain(self.rows.iter().map(of_row)).collect()
    }

    fn table(&self) -> String {
        let mut text =
            format!("{}, {}; {} triangles\n", self.device, self.accel, grouped(self.triangles as u64));
        let _ = writeln!(
            text,
            "{:<9} {:<12} {:>12} {:>10} {:>12} {:>10}",
            "rays", "query", "number", "ms", "Mrays/s", "different"
        );
        for row in &self.rows {
            let _ = writeln!(
                text,
                "{:<9} {:<12} {:>12} {:>10.3} {:>12.1} {:>10}",
                row.set,
                row.query,
                grouped(row.rays as u64),
                row.milliseconds,
                row.mrays_per_second,
                grouped(row.different as u64)
            );
        }
        text
    }
}
