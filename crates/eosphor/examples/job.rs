//! A still that goes on where it ended, and a video of a turntable: `cargo run --release -p eosphor --example job`.

use eosphor::job::{JobControl, Sequence, Still, Video};
use eosphor::{CpuBackend, CpuOptions, LoadOptions, Progress, load};
use std::path::Path;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut scene = load("builtin:cornell", &LoadOptions::default())?.scene;
    (scene.settings.size, scene.settings.samples) = ([160, 120], 16);
    let backend = CpuBackend::new(CpuOptions::default())?;
    let on_progress = |now: Progress| eprint!("\r{} of {} pixels", now.pixels_done, now.pixels_total);
    let control = JobControl { on_progress: &on_progress, ..JobControl::default() };

    let mut still = Still::new(&scene, &backend).to_file(Path::new("cornell.png"))?;
    still.resume = true;
    let outcome = still.run(&control)?;
    let resumed = 100.0 * outcome.resumed;
    eprintln!("\ncornell.png: {resumed:.0} % were done, {} rays", outcome.statistics.total_rays());

    scene.turntable(12)?;
    let sequence = Sequence { resume: true, ..Sequence::new(&scene, &backend) };
    let outcome = sequence.write_video(&Video::new(Path::new("cornell.mp4")), &control)?;
    eprintln!("\ncornell.mp4: {} of {} frames were done", outcome.kept, outcome.wanted);
    Ok(())
}
