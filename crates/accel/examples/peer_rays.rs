//! Eosphor beside other ray tracing libraries: reads the ray files of a peer benchmark, traces them, and prints one JSON
//! line a measurement.
//!
//! `peer_rays DATA_DIR SCENE[,SCENE...] [REPEATS]`. Files, little endian: `X.tris` is a count and 9 floats a triangle;
//! `X_primary.rays`, `X_diffuse.rays`, `X_shadow.rays` are a count and 8 floats a ray (origin, t_min, unit direction,
//! t_max); the `.ref` files are a count and (t, primitive) a ray, with primitive `ffffffff` for a miss.
//!
//! Environment: `HITS_DIR` writes `SCENE_QUERY.eosphor-VARIANT-BUILD.hits` in the form of the `.ref` files; `SIMD` is one of
//! the levels, `VARIANTS` (`1ray`, `batch`, `coherent`, `incoherent`; `where` with a closure that accepts all, `half` with one
//! that refuses every other triangle, `halfnext` likewise by `next_hit`; `steps` counts), `BUILDS` and `QUERIES` choose from
//! what is measured (comma-separated; `medium-cut` is medium that cuts large triangles, `-whole` one that does not, `-moved` and
//! `-left` say whether large nodes are put elsewhere), `THREADS` lists thread counts, `BATCH` is how many rays go into a call (as
//! many as there are).

use eosphor_accel::{
    BatchTracer, BuildOptions, Builder, Bvh8, Bvh8Tracer, Coherence, CountWork, Filters, Hit, PrimitiveId,
    Quality, Ray, RayFilter, Scene, SimdLevel, Tracer, Vec3, closest_hit_where, occluded_where, vec3,
};
use std::error::Error;
use std::hint::black_box;
use std::sync::LazyLock;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Instant;

const QUERIES: [&str; 3] = ["primary", "diffuse", "shadow"];
/// Rays that a thread takes at a time.
const CHUNK: usize = 4096;

struct Data {
    scene: String,
    triangles: Vec<[Vec3; 3]>,
    rays: [Vec<Ray>; 3],
    references: [Vec<(f32, u32)>; 3],
}

fn words(path: &str) -> Result<Vec<f32>, Box<dyn Error>> {
    let bytes = std::fs::read(path).map_err(|e| format!("{path}: {e}"))?;
    let words = bytes.get(4..).ok_or_else(|| format!("{path}: too short"))?;
    Ok(words.chunks_exact(4).map(|c| f32::from_le_bytes([c[0], c[1], c[2], c[3]])).collect())
}

impl Data {
    fn read(folder: &str, scene: &str) -> Result<Data, Box<dyn Error>> {
        let vertex = |v: &[f32]| vec3(v[0], v[1], v[2]);
        let ray = |v: &[f32]| Ray { origin: vertex(v), t_min: v[3], direction: vertex(&v[4..]), t_max: v[7] };
        let triangle = |v: &[f32]| [vertex(v), vertex(&v[3..]), vertex(&v[6..])];
        let mut data = Data {
            scene: scene.into(),
            triangles: words(&format!("{folder}/{scene}.tris"))?.chunks_exact(9).map(triangle).collect(),
            rays: Default::default(),
            references: Default::default(),
        };
        for (k, query) in QUERIES.iter().enumerate() {
            let file = format!("{folder}/{scene}_{query}");
            data.rays[k] = words(&format!("{file}.rays"))?.chunks_exact(8).map(ray).collect();
            let references = words(&format!("{file}.ref"))?;
            data.references[k] = references.chunks_exact(2).map(|v| (v[0], v[1].to_bits())).collect();
        }
        Ok(data)
    }
}

/// Seconds that this thread has run.
#[cfg(target_os = "linux")]
fn thread_seconds() -> f64 {
    let mut time = libc::timespec { tv_sec: 0, tv_nsec: 0 };
    // SAFETY: `time` can be written.
    unsafe { libc::clock_gettime(libc::CLOCK_THREAD_CPUTIME_ID, &mut time) };
    time.tv_sec as f64 + time.tv_nsec as f64 * 1e-9
}

/// Seconds that have passed: other systems' clocks of threads differ.
#[cfg(not(target_os = "linux"))]
fn thread_seconds() -> f64 {
    static START: std::sync::OnceLock<Instant> = std::sync::OnceLock::new();
    START.get_or_init(Instant::now).elapsed().as_secs_f64()
}

fn choices(variable: &str, default: &str) -> Vec<String> {
    let list = std::env::var(variable).unwrap_or_else(|_| default.into());
    list.split(',').map(str::to_owned).collect()
}

/// How rays are asked for.
#[derive(Clone, Copy, PartialEq)]
enum Variant {
    OneRay,
    /// One ray, and only triangles whose number has no bit of this.
    Where(u32),
    /// The same by the function for any structure.
    Next(u32),
    Batch(Coherence),
}

impl Variant {
    fn named(name: &str) -> Result<Variant, Box<dyn Error>> {
        Ok(match name {
            "1ray" => Variant::OneRay,
            "where" => Variant::Where(0),
            "half" => Variant::Where(1),
            "halfnext" => Variant::Next(1),
            "batch" => Variant::Batch(Coherence::Auto),
            "coherent" => Variant::Batch(Coherence::Coherent),
            "incoherent" => Variant::Batch(Coherence::Incoherent),
            _ => return Err(format!("no variant '{name}'").into()),
        })
    }
}

/// Answers in one array for each query, as they would be used.
enum Answers<'a> {
    Hits(&'a mut [Hit]),
    Hidden(&'a mut [bool]),
}

/// Rays that go into a call of batches.
static BATCH: LazyLock<usize> = LazyLock::new(|| {
    let batch = std::env::var("BATCH").map(|count| count.parse().expect("BATCH is a number of rays"));
    batch.unwrap_or(usize::MAX)
});

fn trace(tracer: &Bvh8Tracer, variant: Variant, rays: &[Ray], answers: Answers) {
    let filter = &RayFilter::ALL;
    match (answers, variant) {
        (Answers::Hits(hits), Variant::OneRay) => {
            for (ray, hit) in rays.iter().zip(hits) {
                *hit = tracer.closest_hit(black_box(ray), filter);
            }
        }
        (Answers::Hidden(hidden), Variant::OneRay) => {
            for (ray, hidden) in rays.iter().zip(hidden) {
                *hidden = tracer.occluded(black_box(ray), filter);
            }
        }
        (Answers::Hits(hits), Variant::Where(bit)) => {
            for (ray, hit) in rays.iter().zip(hits) {
                *hit = tracer.closest_hit_where(black_box(ray), filter, |hit| hit.id.primitive & bit == 0);
            }
        }
        (Answers::Hidden(hidden), Variant::Where(bit)) => {
            for (ray, hidden) in rays.iter().zip(hidden) {
                *hidden = tracer.occluded_where(black_box(ray), filter, |hit| hit.id.primitive & bit == 0);
            }
        }
        (Answers::Hits(hits), Variant::Next(bit)) => {
            for (ray, hit) in rays.iter().zip(hits) {
                *hit = closest_hit_where(tracer, black_box(ray), filter, |hit| hit.id.primitive & bit == 0);
            }
        }
        (Answers::Hidden(hidden), Variant::Next(bit)) => {
            for (ray, hidden) in rays.iter().zip(hidden) {
                *hidden = occluded_where(tracer, black_box(ray), filter, |hit| hit.id.primitive & bit == 0);
            }
        }
        (Answers::Hits(hits), Variant::Batch(coherence)) => {
            for (rays, hits) in rays.chunks(*BATCH).zip(hits.chunks_mut(*BATCH)) {
                tracer.closest_hits(rays, Filters::Shared(filter), coherence, hits);
            }
        }
        (Answers::Hidden(hidden), Variant::Batch(coherence)) => {
            for (rays, hidden) in rays.chunks(*BATCH).zip(hidden.chunks_mut(*BATCH)) {
                tracer.occluded_rays(rays, Filters::Shared(filter), coherence, hidden);
            }
        }
    }
}

/// Traces all rays on some threads; returns the CPU seconds of all.
fn run(tracer: &Bvh8Tracer, variant: Variant, rays: &[Ray], hits: &mut [Hit], hidden: &mut [bool]) -> f64 {
    let start = thread_seconds();
    if hidden.is_empty() {
        trace(tracer, variant, rays, Answers::Hits(hits));
    } else {
        trace(tracer, variant, rays, Answers::Hidden(hidden));
    }
    thread_seconds() - start
}

fn run_threads(
    tracer: &Bvh8Tracer,
    variant: Variant,
    rays: &[Ray],
    hits: &mut [Hit],
    hidden: &mut [bool],
    threads: usize,
) -> f64 {
    if threads == 1 {
        return run(tracer, variant, rays, hits, hidden);
    }
    let any = !hidden.is_empty();
    // Each chunk behind a lock of its own, which is taken once.
    let mut chunks = Vec::new();
    let mut hits_left = hits.chunks_mut(CHUNK);
    let mut hidden_left = hidden.chunks_mut(CHUNK);
    for rays in rays.chunks(CHUNK) {
        let hits = if any { &mut [] } else { hits_left.next().unwrap_or_default() };
        let hidden = if any { hidden_left.next().unwrap_or_default() } else { &mut [] };
        chunks.push(std::sync::Mutex::new((rays, hits, hidden)));
    }
    let next = AtomicUsize::new(0);
    let work = || {
        let mut seconds = 0.0;
        while let Some(chunk) = chunks.get(next.fetch_add(1, Ordering::Relaxed)) {
            let mut guard = chunk.lock().expect("no thread panics");
            let (rays, hits, hidden) = &mut *guard;
            seconds += run(tracer, variant, rays, hits, hidden);
        }
        seconds
    };
    std::thread::scope(|scope| {
        let others: Vec<_> = (1..threads).map(|_| scope.spawn(work)).collect();
        work() + others.into_iter().map(|t| t.join().expect("no thread panics")).sum::<f64>()
    })
}

fn measure(
    data: &Data,
    (tracer, level): (&Bvh8Tracer, SimdLevel),
    query: usize,
    (build, name): (&str, &str),
    repeats: usize,
) -> Result<(), Box<dyn Error>> {
    let variant = Variant::named(name)?;
    let rays = &data.rays[query];
    let mut hits = vec![Hit::miss(0.0); if query == 2 { 0 } else { rays.len() }];
    let mut hidden = vec![false; if query == 2 { rays.len() } else { 0 }];
    for threads in choices("THREADS", "1,2") {
        let threads: usize = threads.parse()?;
        let (mut wall, mut cpu) = (f64::MAX, f64::MAX);
        for _ in 0..repeats {
            let start = Instant::now();
            cpu = cpu.min(run_threads(tracer, variant, rays, &mut hits, &mut hidden, threads));
            wall = wall.min(start.elapsed().as_secs_f64());
        }
        let answers: Vec<(f32, u32)> = if query == 2 {
            hidden.iter().map(|&h| (0.0, if h { 0 } else { u32::MAX })).collect()
        } else {
            let pair =
                |h: &Hit| if h.id == PrimitiveId::NONE { (0.0, u32::MAX) } else { (h.t, h.id.primitive) };
            hits.iter().map(pair).collect()
        };
        let (mut other_hit, mut other_t, mut other_t4, mut other_primitive) = (0, 0, 0, 0);
        for (a, r) in answers.iter().zip(&data.references[query]) {
            if (a.1 == u32::MAX) != (r.1 == u32::MAX) {
                other_hit += 1;
            } else if a.1 != u32::MAX && query != 2 {
                let error = (a.0 - r.0).abs() / r.0.abs().max(1e-3);
                other_t += (error > 1e-3) as u32;
                other_t4 += (error > 1e-4) as u32;
                other_primitive += (a.1 != r.1) as u32;
            }
        }
        let count = rays.len() as f64;
        println!(
            "{{\"kind\":\"query\",\"lib\":\"eosphor\",\"variant\":\"{name}\",\"build\":\"{build}\",\"simd\":\"{level}\",\
             \"scene\":\"{}\",\"query\":\"{}\",\"threads\":{threads},\"mrays\":{:.3},\"mrays_cpu\":{:.3},\"n\":{},\
             \"hitmiss_diff\":{other_hit},\"t_diff\":{other_t},\"t_diff4\":{other_t4},\"prim_diff\":{other_primitive}}}",
            data.scene,
            QUERIES[query],
            count / wall * 1e-6,
            count / cpu * threads as f64 * 1e-6,
            rays.len(),
        );
        if let (1, Ok(folder)) = (threads, std::env::var("HITS_DIR")) {
            let mut bytes = (rays.len() as u32).to_le_bytes().to_vec();
            for (t, primitive) in &answers {
                bytes.extend(t.to_le_bytes());
                bytes.extend(primitive.to_le_bytes());
            }
            let (scene, query) = (&data.scene, QUERIES[query]);
            std::fs::write(format!("{folder}/{scene}_{query}.eosphor-{name}-{build}.hits"), bytes)?;
        }
    }
    Ok(())
}

/// Nodes and triangles that the scalar walk of a single ray tests, on average.
fn count_steps(data: &Data, bvh: &Bvh8, query: usize, build: &str) {
    let tracer = bvh.counting_tracer(CountWork::default());
    for ray in &data.rays[query] {
        if query == 2 {
            black_box(tracer.occluded(ray, &RayFilter::ALL));
        } else {
            black_box(tracer.closest_hit(ray, &RayFilter::ALL));
        }
    }
    let count = data.rays[query].len() as f64;
    println!(
        "{{\"kind\":\"steps\",\"lib\":\"eosphor\",\"build\":\"{build}\",\"scene\":\"{}\",\"query\":\"{}\",\
         \"nodes\":{:.3},\"triangles\":{:.3}}}",
        data.scene,
        QUERIES[query],
        tracer.work.nodes.get() as f64 / 8.0 / count,
        tracer.work.primitives.get() as f64 / count,
    );
}

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().collect();
    let [_, folder, scenes, ..] = &arguments[..] else {
        return Err("usage: peer_rays DATA_DIR SCENE[,SCENE...] [REPEATS]".into());
    };
    let repeats: usize = arguments.get(3).map_or(Ok(3), |r| r.parse())?;
    let level = match std::env::var("SIMD") {
        Ok(name) => name.parse::<SimdLevel>()?,
        Err(_) => SimdLevel::best(),
    };
    for scene in scenes.split(',') {
        let data = Data::read(folder, scene)?;
        let world = Scene::new(&data.triangles, &[])?;
        for build in choices("BUILDS", "medium") {
            let (name, change) = build.split_once('-').unwrap_or((&build, ""));
            let mut options = match name.parse::<Quality>() {
                Ok(quality) => quality.options(),
                Err(_) => BuildOptions::of(name.parse::<Builder>()?),
            };
            match change {
                "" => {}
                "cut" => options.cut_large_triangles = true,
                "whole" => options.cut_large_triangles = false,
                "moved" => options.reinsertion = true,
                "left" => options.reinsertion = false,
                _ => return Err(format!("no build '{build}'").into()),
            }
            let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build()?;
            let mut best: Option<(f64, f64, Bvh8)> = None;
            for _ in 0..repeats.min(if data.triangles.len() > 500_000 { 2 } else { 5 }) {
                let (seconds, cpu, bvh) = pool.install(|| {
                    let (start, cpu) = (Instant::now(), thread_seconds());
                    let bvh = Bvh8::build(&world.geometry(), &options);
                    (start.elapsed().as_secs_f64(), thread_seconds() - cpu, bvh)
                });
                if best.as_ref().is_none_or(|b| cpu < b.1) {
                    best = Some((seconds, cpu, bvh));
                }
            }
            let Some((seconds, cpu, bvh)) = best else { continue };
            println!(
                "{{\"kind\":\"build\",\"lib\":\"eosphor\",\"build\":\"{build}\",\"scene\":\"{scene}\",\"threads\":1,\
                 \"seconds\":{seconds:.5},\"cpu\":{cpu:.5},\"bytes\":{},\"tris\":{}}}",
                size_of_val(bvh.nodes()) + size_of_val(bvh.blocks()),
                data.triangles.len(),
            );
            let tracer = bvh.tracer_at(level).ok_or_else(|| format!("this CPU has no {level}"))?;
            let queries = choices("QUERIES", "primary,diffuse,shadow");
            for query in (0..3).filter(|&query| queries.iter().any(|name| name == QUERIES[query])) {
                for name in choices("VARIANTS", "1ray,batch") {
                    if name == "steps" {
                        count_steps(&data, &bvh, query, &build);
                        continue;
                    }
                    measure(&data, (&tracer, level), query, (&build, &name), repeats)?;
                }
            }
        }
    }
    Ok(())
}
