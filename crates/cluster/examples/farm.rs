//! Measures the farm and the broadcast. Run under mpirun:
//!
//! `farm sleep SECONDS UNITS`: UNITS a rank that do nothing but sleep; efficiency is units x seconds / (ranks x wall).
//!
//! `farm broadcast MB`: the time of a broadcast against that of a bare MPI_Bcast of the same bytes, taking turns.

use eosphor_cluster::{ClusterError, Coordinator, Job, Report, World};
use std::sync::atomic::AtomicBool;
use std::time::{Duration, Instant};

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let number = |at: usize| arguments.get(at).and_then(|text| text.parse::<f64>().ok());
    let Some(world) = World::open(Some(Duration::from_secs(30))).unwrap_or_else(|error| panic!("{error}"))
    else {
        println!("no launcher: start me with mpirun");
        return;
    };
    world.abort_handle().on_panic();
    let result = match (arguments.first().map(String::as_str), number(1), number(2)) {
        (Some("sleep"), Some(seconds), Some(units)) => sleep(&world, seconds, units as u64),
        (Some("broadcast"), Some(megabytes), None) => broadcast(&world, megabytes),
        _ => panic!("usage: farm sleep SECONDS UNITS, or farm broadcast MB"),
    };
    result.and_then(|()| world.finish()).unwrap_or_else(|error| panic!("{error}"));
}

fn sleep(world: &World, seconds: f64, units_a_rank: u64) -> Result<(), ClusterError> {
    let (mut describe, mut collect, mut progress) = (|_| Ok(Some(Vec::new())), |_, _| Ok(()), |_: &_| ());
    let cancel = AtomicBool::new(false);
    let coordinator = Coordinator {
        describe: &mut describe,
        collect: &mut collect,
        in_order: true,
        progress: &mut progress,
        cancel: &cancel,
    };
    let processor = processor_seconds();
    let report: Report = world.run(Job {
        units: units_a_rank * u64::from(world.size()),
        in_flight: 2,
        coordinator: (world.rank() == 0).then_some(coordinator),
        compute: &|_, _| {
            std::thread::sleep(Duration::from_secs_f64(seconds));
            Ok(vec![0; 100_000])
        },
        threads: 1,
    })?;
    let used = world.gather(&(processor_seconds() - processor).to_le_bytes())?;
    if let Some(used) = used {
        let used: Vec<f64> =
            used.iter().map(|bytes| f64::from_le_bytes(bytes[..].try_into().unwrap())).collect();
        let wall = report.elapsed.as_secs_f64();
        let (ranks, units) = (world.size(), report.units_done);
        let efficiency = units as f64 * seconds / (f64::from(ranks) * wall);
        println!(
            "{}: {ranks} ranks, {units} units of {seconds} s in {wall:.3} s: efficiency {:.1} %, {:.1} MB moved, \
             processor time {:.2} s on rank 0, {:.2} s on all",
            world.library(),
            100.0 * efficiency,
            report.bytes_moved as f64 / 1e6,
            used[0],
            used.iter().sum::<f64>(),
        );
        if std::env::var_os("FARM_DETAIL").is_some() {
            for (rank, of_rank) in report.ranks.iter().enumerate() {
                println!("  {rank}: {} units in {:.3} s", of_rank.units_done, of_rank.seconds_computing);
            }
        }
    }
    Ok(())
}

fn broadcast(world: &World, megabytes: f64) -> Result<(), ClusterError> {
    let count = (megabytes * 1e6) as usize;
    let pattern = |byte: usize| (byte ^ (byte >> 11)) as u8;
    let original: Vec<u8> = if world.rank() == 0 { (0..count).map(pattern).collect() } else { Vec::new() };
    let mut times = [Vec::new(), Vec::new()];
    for turn in 0..10 {
        let bytes = original.clone();
        world.gather(&[])?;
        world.agree("turn", "")?;
        let start = Instant::now();
        // Both into new memory, which a program needs once anyway.
        let copy =
            if turn % 2 == 0 { world.broadcast(bytes)? } else { world.bare_broadcast(bytes, count)? };
        world.gather(&[])?;
        times[turn % 2].push(start.elapsed().as_secs_f64());
        assert!(copy.len() == count && (0..count).step_by(4099).all(|byte| copy[byte] == pattern(byte)));
    }
    if world.rank() == 0 {
        let list =
            |times: &[f64]| times.iter().map(|time| format!("{time:.3}")).collect::<Vec<_>>().join(" ");
        let median = |times: &mut Vec<f64>| {
            times.sort_by(f64::total_cmp);
            times[times.len() / 2]
        };
        println!("{}: {megabytes} MB to {} ranks", world.library(), world.size());
        println!("  broadcast      {} s", list(&times[0]));
        println!("  bare MPI_Bcast {} s", list(&times[1]));
        let [ours, bare] = times.each_mut().map(median);
        println!("  medians {ours:.3} s and {bare:.3} s: {:.2} times", ours / bare);
    }
    Ok(())
}

/// Processor time of this process so far.
fn processor_seconds() -> f64 {
    let stat = std::fs::read_to_string("/proc/self/stat").unwrap_or_default();
    let fields: Vec<&str> = stat.rsplit(')').next().unwrap_or_default().split_whitespace().collect();
    let ticks = |at: usize| fields.get(at).and_then(|field| field.parse::<f64>().ok()).unwrap_or(0.0);
    (ticks(11) + ticks(12)) / 100.0
}
