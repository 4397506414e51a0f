//! Measures a library, and prints a line for each quantity as soon as it is known.

use crate::clock::Clock;
use crate::data::{Data, RaySet};
use crate::{Hit, Library, MISS, Options, Ray};
use std::fmt::Write as _;
use std::io::Write as _;
use std::sync::Mutex;

/// Rays that a thread takes at a time, at least: few enough that all threads end together.
const PIECE: usize = 4096;

pub(crate) fn measure<L: Library>(data: &Data, options: &Options) -> Result<(), String> {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(options.threads).build();
    let pool = pool.map_err(|error| format!("cannot start threads: {error}"))?;
    let mut built = None;
    let mut times = Times::default();
    for repeat in 0..=options.repeats {
        // Memory of the structure before is given back first, outside of the measured time.
        drop(built.take());
        let mesh = L::prepare(&data.mesh, options)?;
        let clock = Clock::start();
        // In the pool also where it has one thread: libraries would take a pool of all cores otherwise.
        let library = pool.install(|| L::build(mesh, options))?;
        times.add(repeat, clock.read());
        built = Some(library);
    }
    print("build", &times, None)?;
    let library = built.expect("the loop above runs at least twice");
    for set in &data.sets {
        closest(&library, set, options)?;
        any(&library, set, options)?;
    }
    Ok(())
}

fn closest<L: Library>(library: &L, set: &RaySet, options: &Options) -> Result<(), String> {
    let mut hits = vec![Hit { t: 0.0, triangle: MISS }; set.rays.len()];
    let times =
        repeat::<L, _>(set, options, &mut hits, |rays, hits| library.closest_hits(rays, set.coherent, hits));
    let counts = Counts {
        work: hits.len(),
        hits: hits.iter().filter(|hit| hit.triangle != MISS).count(),
        different: hits
            .iter()
            .zip(&set.expected)
            .filter(|(hit, expected)| hit.triangle != **expected)
            .count(),
    };
    print(&format!("{}, closest hit", set.name), &times, Some(&counts))
}

fn any<L: Library>(library: &L, set: &RaySet, options: &Options) -> Result<(), String> {
    let mut hits = vec![false; set.rays.len()];
    let times =
        repeat::<L, _>(set, options, &mut hits, |rays, hits| library.any_hits(rays, set.coherent, hits));
    let counts = Counts {
        work: hits.len(),
        hits: hits.iter().filter(|hit| **hit).count(),
        different: hits
            .iter()
            .zip(&set.expected)
            .filter(|(hit, expected)| **hit != (**expected != MISS))
            .count(),
    };
    print(&format!("{}, any hit", set.name), &times, Some(&counts))
}

/// Traces all rays of a set, once more than is counted.
fn repeat<L: Library, H: Send>(
    set: &RaySet,
    options: &Options,
    hits: &mut [H],
    trace: impl Fn(&[Ray], &mut [H]) + Sync,
) -> Times {
    let batches = |rays: &[Ray], hits: &mut [H]| {
        for (rays, hits) in rays.chunks(options.batch).zip(hits.chunks_mut(options.batch)) {
            trace(rays, hits);
        }
    };
    let mut times = Times::default();
    for repeat in 0..=options.repeats {
        let clock = Clock::start();
        if options.threads == 1 {
            L::start_thread();
            batches(&set.rays, hits);
        } else {
            let piece = PIECE.next_multiple_of(options.batch);
            let pieces = Mutex::new(set.rays.chunks(piece).zip(hits.chunks_mut(piece)));
            let work = || {
                L::start_thread();
                loop {
                    let next = pieces.lock().expect("nothing panics while it holds the lock").next();
                    let Some((rays, hits)) = next else { break };
                    batches(rays, hits);
                }
            };
            std::thread::scope(|scope| {
                for _ in 0..options.threads {
                    scope.spawn(work);
                }
            });
        }
        times.add(repeat, clock.read());
    }
    times
}

#[derive(Default)]
struct Times {
    wall: Vec<f64>,
    cpu: Vec<f64>,
}

impl Times {
    /// The first repetition warms caches, and pages of memory; it does not count.
    fn add(&mut self, repeat: usize, (wall, cpu): (f64, f64)) {
        if repeat > 0 {
            self.wall.push(wall);
            self.cpu.push(cpu);
        }
    }
}

struct Counts {
    work: usize,
    hits: usize,
    different: usize,
}

fn print(quantity: &str, times: &Times, counts: Option<&Counts>) -> Result<(), String> {
    let list =
        |values: &[f64]| values.iter().map(|value| format!("{value:.4}")).collect::<Vec<_>>().join(",");
    let mut line = format!(
        r#"{{"quantity":"{quantity}","unit":"ms","values":[{}],"cpu":[{}]"#,
        list(&times.wall),
        list(&times.cpu)
    );
    if let Some(Counts { work, hits, different }) = counts {
        write!(line, r#","work":{work},"hits":{hits},"different":{different}"#)
            .expect("a string takes everything");
    }
    let mut out = std::io::stdout().lock();
    writeln!(out, "{line}}}").and_then(|()| out.flush()).map_err(|error| format!("cannot print: {error}"))
}
