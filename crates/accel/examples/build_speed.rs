//! What building costs, and what is built: `build_speed DATA_DIR SCENE REPS [THREADS] [BUILDER,…]`.
//!
//! `DATA_DIR/SCENE.tris` holds a number of triangles (u32) and nine coordinates (f32) for each, little endian. Every line
//! is the whole build of an 8-wide hierarchy by one builder: the least of REPS processor times (all threads together,
//! /proc/self/schedstat) and wall times in milliseconds, then what was built. `sah` is the cost of the hierarchy with
//! two children a node (1 for a visit, 1 for a test) over that of the SAH sweep; `sah8` that of the 8-wide one, where a
//! node and a block cost 1. `peak` is what building had allocated at most, beyond the mesh.

use eosphor_accel::bvh8::{EMPTY, LEAF};
use eosphor_accel::{BuildOptions, Builder, Bvh, Bvh8, Quality, SceneGeometry};
use eosphor_core::geometry::{Bounds, Geometry, Instance};
use eosphor_core::intersect::longest_edge_last;
use eosphor_core::material::NONE;
use eosphor_core::math::{Affine, Vec3, vec3};
use std::alloc::{GlobalAlloc, Layout, System};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Instant;

/// Counts bytes.
struct Counting;

static USED: AtomicUsize = AtomicUsize::new(0);
static PEAK: AtomicUsize = AtomicUsize::new(0);

// SAFETY: everything is handed on to the system's allocator.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        let used = USED.fetch_add(layout.size(), Ordering::Relaxed) + layout.size();
        PEAK.fetch_max(used, Ordering::Relaxed);
        // SAFETY: layout and pointer go to the system's allocator as they came.
        unsafe { System.alloc(layout) }
    }
    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        let used = USED.fetch_add(layout.size(), Ordering::Relaxed) + layout.size();
        PEAK.fetch_max(used, Ordering::Relaxed);
        // SAFETY: layout and pointer go to the system's allocator as they came.
        unsafe { System.alloc_zeroed(layout) }
    }
    unsafe fn dealloc(&self, at: *mut u8, layout: Layout) {
        USED.fetch_sub(layout.size(), Ordering::Relaxed);
        // SAFETY: layout and pointer go to the system's allocator as they came.
        unsafe { System.dealloc(at, layout) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [directory, scene, reps, rest @ ..] = &arguments[..] else {
        eprintln!("usage: build_speed DATA_DIR SCENE REPS [THREADS] [BUILDER,…]");
        std::process::exit(2);
    };
    let reps: usize = reps.parse().expect("REPS is a number");
    let threads: usize = rest.first().map_or(1, |t| t.parse().expect("THREADS is a number"));
    let builders: Vec<Builder> = match rest.get(1) {
        Some(names) => names.split(',').map(|n| n.parse().expect("a builder")).collect(),
        None => Builder::ALL.to_vec(),
    };
    rayon::ThreadPoolBuilder::new().num_threads(threads).build_global().expect("threads");
    let triangles = load(&format!("{directory}/{scene}.tris"));
    println!("{scene}: {} triangles, {threads} thread(s), best of {reps}", triangles.len());
    println!(
        "{:8} {:8} {:>9} {:>9} {:>6} {:>6} {:>8} {:>7} {:>9} {:>8} {:>6} {:>6}",
        "builder",
        "quality",
        "cpu ms",
        "wall ms",
        "sah",
        "sah8",
        "B/tri",
        "peak",
        "nodes",
        "refs",
        "fill",
        "depth"
    );
    let world = World::new(triangles);
    let geometry = world.geometry();
    let sweep = Bvh::build(&geometry, &BuildOptions::of(Builder::Sweep)).sah_cost();
    for builder in builders {
        measure(builder, &geometry, reps, sweep);
    }
}

fn measure(builder: Builder, scene: &SceneGeometry, reps: usize, sweep: f64) {
    let options = BuildOptions::of(builder);
    let (mut cpu_ms, mut wall_ms, mut peak) = (f64::INFINITY, f64::INFINITY, 0);
    for _ in 0..reps {
        let before = USED.load(Ordering::Relaxed);
        PEAK.store(before, Ordering::Relaxed);
        let (cpu, wall) = (cpu_seconds(), Instant::now());
        let bvh8 = rayon::scope(|_| Bvh8::build(scene, &options));
        wall_ms = wall_ms.min(wall.elapsed().as_secs_f64() * 1e3);
        cpu_ms = cpu_ms.min((cpu_seconds() - cpu) * 1e3);
        peak = PEAK.load(Ordering::Relaxed) - before;
        std::hint::black_box(&bvh8);
    }
    let sah = Bvh::build(scene, &options).sah_cost() / sweep;
    let bvh8 = Bvh8::build(scene, &options);
    let triangles = scene.triangles().len() as f64;
    let bytes = (size_of_val(bvh8.nodes()) + size_of_val(bvh8.blocks())) as f64;
    let references = bvh8.blocks().iter().flat_map(|b| b.primitive).filter(|&p| p != u32::MAX).count();
    let quality = Quality::ALL.into_iter().find(|q| q.options().builder == builder);
    println!(
        "{:8} {:8} {cpu_ms:9.2} {wall_ms:9.2} {sah:6.3} {:6.1} {:8.1} {:7.1} {:9} {:8.4} {:6.2} {:6}",
        builder.to_string(),
        quality.map_or(String::from("-"), |q| q.to_string()),
        sah8(&bvh8),
        bytes / triangles,
        peak as f64 / triangles,
        bvh8.nodes().len(),
        references as f64 / triangles,
        references as f64 / bvh8.blocks().len() as f64,
        depth(&bvh8),
    );
}

/// Processor time of all threads of this process, in seconds.
fn cpu_seconds() -> f64 {
    let tasks = std::fs::read_dir("/proc/self/task").expect("Linux");
    let nanoseconds = |task: std::io::Result<std::fs::DirEntry>| -> Option<f64> {
        let text = std::fs::read_to_string(task.ok()?.path().join("schedstat")).ok()?;
        text.split_whitespace().next()?.parse().ok()
    };
    tasks.filter_map(nanoseconds).sum::<f64>() / 1e9
}

/// Box of a child.
fn child_box(bvh8: &Bvh8, node: usize, k: usize) -> Bounds {
    let p = &bvh8.nodes()[node].planes;
    Bounds { min: vec3(p[0][k], p[2][k], p[4][k]), max: vec3(p[1][k], p[3][k], p[5][k]) }
}

/// Sum of the areas of all children over that of the root.
fn sah8(bvh8: &Bvh8) -> f64 {
    let mut sum = 0.0;
    let mut root = Bounds::EMPTY;
    for (n, node) in bvh8.nodes().iter().enumerate() {
        for k in (0..8).filter(|&k| node.children[k] != EMPTY) {
            sum += f64::from(child_box(bvh8, n, k).half_area());
            if n as u32 == bvh8.roots()[0] {
                root = root.union(&child_box(bvh8, n, k));
            }
        }
    }
    1.0 + sum / f64::from(root.half_area())
}

fn depth(bvh8: &Bvh8) -> usize {
    let (mut deepest, mut pending) = (0, vec![(bvh8.roots()[0], 0)]);
    while let Some((child, depth)) = pending.pop() {
        deepest = deepest.max(depth);
        if child & LEAF == 0 {
            pending.extend(bvh8.nodes()[child as usize].children.iter().map(|&c| (c, depth + 1)));
        }
    }
    deepest
}

fn load(path: &str) -> Vec<[Vec3; 3]> {
    let bytes = std::fs::read(path).unwrap_or_else(|e| panic!("{path}: {e}"));
    let number = |b: &[u8]| f32::from_le_bytes(b.try_into().expect("four bytes"));
    bytes[4..]
        .chunks_exact(36)
        .map(|t| {
            let corner = |k: usize| {
                let at = |a: usize| number(&t[12 * k + 4 * a..][..4]);
                vec3(at(0), at(1), at(2))
            };
            let triangle = [corner(0), corner(1), corner(2)];
            let first = longest_edge_last(&triangle);
            [0, 1, 2].map(|k| triangle[(first + k) % 3])
        })
        .collect()
}

struct World {
    triangles: Vec<[Vec3; 3]>,
    geometries: [Geometry; 1],
    instances: [Instance; 1],
}

impl World {
    fn new(triangles: Vec<[Vec3; 3]>) -> World {
        let bounds = triangles.iter().flatten().fold(Bounds::EMPTY, |b, p| b.including(*p));
        let geometries = [Geometry {
            first_triangle: 0,
            triangle_count: triangles.len() as u32,
            first_sphere: 0,
            sphere_count: 0,
            extent: bounds.extent(),
            first_sphere_object: 0,
        }];
        let instances = [Instance {
            object_from_world: Affine::IDENTITY,
            world_from_object: Affine::IDENTITY,
            world_bounds: bounds,
            geometry: 0,
            material: NONE,
            object: 0,
        }];
        World { triangles, geometries, instances }
    }

    fn geometry(&self) -> SceneGeometry<'_> {
        SceneGeometry::new(&self.triangles, &[], &self.geometries, &self.instances)
            .expect("arrays that hold together")
    }
}
