//! How long a glTF file takes to load: this crate beside `gltf::import`, in turns, in one run.
//!
//! `cargo run --release -p eosphor-scene --example load_speed_gltf -- FILE... [--rounds N]`
//!
//! What is compared is not the same work. `gltf::import` checks the JSON, reads the buffers and decodes the pictures,
//! one after the other; it leaves the accessors undecoded, so the vertices that it gives are bytes. This crate also
//! decodes accessors, makes triangles, flat normals where there are none, materials and instances, checks every number
//! of the scene ([`eosphor_scene::Scene::validate`]), and turns pictures into RGBA; pictures are decoded side by side.
//! The third line therefore adds to `gltf::import` what a renderer must do next: the vertices and indices of every
//! mesh through the crate's readers.

use eosphor_scene::{LoadOptions, load};
use std::hint::black_box;
use std::time::Instant;

fn main() {
    let mut rounds = 9;
    let mut files = Vec::new();
    let mut arguments = std::env::args().skip(1);
    while let Some(argument) = arguments.next() {
        match argument.as_str() {
            "--rounds" => rounds = arguments.next().and_then(|n| n.parse().ok()).unwrap_or(rounds).max(1),
            _ => files.push(argument),
        }
    }
    if files.is_empty() {
        println!("give glTF files");
    }
    println!("medians of {rounds}, in milliseconds: wall, CPU");
    for file in files {
        println!("{file}");
        let ways: [Way; 3] =
            [("eosphor", eosphor), ("gltf::import", import), ("  + meshes", import_and_read)];
        // Short work is repeated: the system counts processor time in steps of some milliseconds.
        let repeats = ways.map(|way| {
            let start = Instant::now();
            way.1(&file);
            (0.1 / start.elapsed().as_secs_f64()).ceil().min(1000.0)
        });
        let mut times = vec![Vec::new(); ways.len()];
        for _ in 0..rounds {
            for ((way, repeats), times) in ways.iter().zip(repeats).zip(&mut times) {
                let (wall, cpu) = (Instant::now(), cpu_seconds());
                for _ in 0..repeats as usize {
                    way.1(&file);
                }
                times.push((wall.elapsed().as_secs_f64() / repeats, (cpu_seconds() - cpu) / repeats));
            }
        }
        for ((name, _), times) in ways.iter().zip(times) {
            let median = |of: fn(&(f64, f64)) -> f64| {
                let mut sorted: Vec<f64> = times.iter().map(of).collect();
                sorted.sort_by(f64::total_cmp);
                sorted[sorted.len() / 2] * 1e3
            };
            println!("  {name:<14}{:9.2}{:9.2}", median(|t| t.0), median(|t| t.1));
        }
    }
}

/// A way of loading, by name.
type Way = (&'static str, fn(&str));

fn eosphor(file: &str) {
    black_box(load(file, &LoadOptions::default()).expect("the file loads"));
}

fn import(file: &str) {
    black_box(gltf::import(file).expect("the file loads"));
}

fn import_and_read(file: &str) {
    let (document, buffers, images) = gltf::import(file).expect("the file loads");
    for primitive in document.meshes().flat_map(|mesh| mesh.primitives()) {
        let reader = primitive.reader(|buffer| Some(&buffers[buffer.index()]));
        black_box(reader.read_positions().map(|all| all.collect::<Vec<_>>()));
        black_box(reader.read_normals().map(|all| all.collect::<Vec<_>>()));
        black_box(reader.read_tex_coords(0).map(|all| all.into_f32().collect::<Vec<_>>()));
        black_box(reader.read_indices().map(|all| all.into_u32().collect::<Vec<_>>()));
    }
    black_box(images);
}

/// Processor time of all threads; 0 where it is not known.
fn cpu_seconds() -> f64 {
    // Linux: nanoseconds on a processor, the first number for each thread.
    let threads = std::fs::read_dir("/proc/self/task").into_iter().flatten().flatten();
    let nanoseconds = threads.filter_map(|thread| {
        let text = std::fs::read_to_string(thread.path().join("schedstat")).ok()?;
        text.split_whitespace().next()?.parse::<f64>().ok()
    });
    nanoseconds.sum::<f64>() * 1e-9
}
