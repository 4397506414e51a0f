//! Measures how long files take to become scenes, against the crate `tobj`, whose runs are interleaved with ours so that
//! both meet the same moments of a busy machine. Textures are off.
//!
//! ```text
//! cargo run --release -p eosphor-scene --example load_speed -- --generate grid.obj
//! RAYON_NUM_THREADS=1 cargo run --release -p eosphor-scene --example load_speed -- grid.obj 11
//! ```

mod grid;

use cpu_time::ProcessTime;
use eosphor_scene::LoadOptions;
use std::path::Path;
use std::process::ExitCode;
use std::time::Instant;

/// Seconds on the clock and on all cores.
#[derive(Clone, Copy)]
struct Seconds {
    wall: f64,
    cpu: f64,
}

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let words: Vec<&str> = arguments.iter().map(String::as_str).collect();
    let done = match words[..] {
        ["--generate", file] => grid::write(Path::new(file)).map_err(|e| format!("{file}: {e}")),
        [file] => compare(Path::new(file), 9),
        [file, repeats] => match repeats.parse() {
            Ok(repeats @ 1..) => compare(Path::new(file), repeats),
            _ => Err(format!("\"{repeats}\" must be a number of repeats from 1")),
        },
        _ => Err("usage: load_speed FILE.obj [REPEATS], or load_speed --generate FILE.obj".into()),
    };
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(message) => {
            eprintln!("{message}");
            ExitCode::FAILURE
        }
    }
}

fn compare(file: &Path, repeats: usize) -> Result<(), String> {
    let (mut ours, mut theirs) = (Vec::new(), Vec::new());
    for _ in 0..repeats {
        ours.push(time(|| eosphor_triangles(file))?);
        theirs.push(time(|| tobj_triangles(file))?);
    }
    let counts = [ours[0].1, theirs[0].1];
    println!("{}: {} triangles (tobj: {}), {repeats} runs", file.display(), counts[0], counts[1]);
    // On a busy machine the fastest runs say most about a quiet one.
    for (name, place) in [("median", repeats / 2), ("fastest", 0)] {
        let (ours, theirs) = (nth(&ours, place), nth(&theirs, place));
        println!("{name:8} {:>10} {:>10}", "wall", "CPU");
        println!("eosphor  {:7.1} ms {:7.1} ms", ours.wall * 1e3, ours.cpu * 1e3);
        println!("tobj     {:7.1} ms {:7.1} ms", theirs.wall * 1e3, theirs.cpu * 1e3);
        println!("ratio    {:7.2}    {:7.2}", theirs.wall / ours.wall, theirs.cpu / ours.cpu);
    }
    Ok(())
}

fn time(load: impl FnOnce() -> Result<usize, String>) -> Result<(Seconds, usize), String> {
    let (wall, cpu) = (Instant::now(), ProcessTime::now());
    let triangles = load()?;
    Ok((Seconds { wall: wall.elapsed().as_secs_f64(), cpu: cpu.elapsed().as_secs_f64() }, triangles))
}

/// The n-th smallest of either clock.
fn nth(runs: &[(Seconds, usize)], n: usize) -> Seconds {
    let pick = |of: fn(&Seconds) -> f64| {
        let mut list: Vec<f64> = runs.iter().map(|(seconds, _)| of(seconds)).collect();
        list.sort_by(f64::total_cmp);
        list[n]
    };
    Seconds { wall: pick(|s| s.wall), cpu: pick(|s| s.cpu) }
}

fn eosphor_triangles(file: &Path) -> Result<usize, String> {
    let mut options = LoadOptions::default();
    options.textures = false;
    let loaded = eosphor_scene::load(file, &options).map_err(|e| e.to_string())?;
    Ok(loaded.scene.meshes.iter().map(|mesh| mesh.triangles.len()).sum())
}

/// With `single_index` off `tobj` keeps indices of their own for normals and texture coordinates, as we do, and need
/// not match corners to vertices: it is its fastest way.
fn tobj_triangles(file: &Path) -> Result<usize, String> {
    let options = tobj::LoadOptions { triangulate: true, single_index: false, ..Default::default() };
    let (models, _) = tobj::load_obj(file, &options).map_err(|e| e.to_string())?;
    Ok(models.iter().map(|model| model.mesh.indices.len() / 3).sum())
}
