//! Ranks do together what they should, under every MPI of this machine and with several numbers of ranks.

mod common;

use common::{KINDS, Kind, start, start_alone};
use eosphor_cluster::{ClusterError, Coordinator, Job, Report, World};
use std::io::Write;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

const RANKS: [u32; 5] = [1, 2, 3, 4, 8];

/// The ranks of a job are this program again, which runs this test alone.
#[test]
fn rank_of_a_job() {
    let Some(case) = common::case() else { return };
    let code = match be_a_rank(&case) {
        Ok(()) => 0,
        Err(()) => 1,
    };
    std::process::exit(code);
}

/// Errors that all ranks get are printed by rank 0.
fn be_a_rank(case: &str) -> Result<(), ()> {
    let Some(world) = World::open(Some(Duration::from_secs(60))).map_err(|error| print(&error))? else {
        println!("no launcher");
        assert_no_mpi_is_mapped();
        return Ok(());
    };
    world.abort_handle().on_panic();
    let rank = world.rank();
    let result = match case {
        "open" => Ok(()),
        "all" => broadcast(&world)
            .and_then(|()| gather(&world))
            .and_then(|()| run(&world))
            .and_then(|()| cancel(&world)),
        "differ" => world.agree("program version", if rank == 1 { "0.2.0" } else { "0.1.0" }),
        "damage" => {
            let bytes = if rank == 0 { vec![7; 100_000] } else { Vec::new() };
            world.broadcast_with(bytes, 1 << 12, Some(world.size() - 1)).map(drop)
        }
        _ => panic!("unknown case {case}"),
    };
    match &result {
        Ok(()) if rank == 0 => println!("good under {} on {}", world.library(), world.host()),
        Err(error) if rank == 0 => print(error),
        _ => {}
    }
    world.finish().map_err(|error| print(&error))?;
    result.map_err(drop)
}

/// In one write, so that the launcher's own lines do not mix with it.
fn print(error: &ClusterError) {
    std::io::stderr().write_all(format!("error: {error}\n").as_bytes()).unwrap();
}

fn assert_no_mpi_is_mapped() {
    let maps = std::fs::read_to_string("/proc/self/maps").unwrap();
    assert!(maps.contains("libc"), "{maps}");
    assert!(!maps.contains("libmpi") && !maps.contains("libopen-"), "{maps}");
}

/// Bytes that differ everywhere, so that none can be in the place of another.
fn pattern(seed: u64, count: usize) -> Vec<u8> {
    let mut state = seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1;
    let mut next = || {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        state as u8
    };
    (0..count).map(|_| next()).collect()
}

/// Says where bytes differ, not what they all are.
fn assert_same(bytes: &[u8], expected: &[u8], what: &str) {
    let differing = || bytes.iter().zip(expected).enumerate().filter(|(_, (one, other))| one != other);
    let (first, count) = (differing().next().map(|(at, _)| at), differing().count());
    let last = differing().next_back().map(|(at, _)| at);
    let lengths = (bytes.len(), expected.len());
    assert!(bytes == expected, "{what}: lengths {lengths:?}, {count} differ, from {first:?} to {last:?}");
}

fn broadcast(world: &World) -> Result<(), ClusterError> {
    assert_eq!(world.hosts().len(), world.size() as usize);
    assert_eq!(world.hosts()[world.rank() as usize], world.host());
    // All ranks of these tests are on one host.
    assert_eq!((world.local_rank(), world.local_size()), (world.rank(), world.size()));
    for (seed, count, piece) in
        [(1, 0, 16), (2, 1, 16), (3, 1001, 16), (4, 3_000_001, 1 << 20), (5, 999, 0), (6, 5_000_000, 1 << 30)]
    {
        let bytes = if world.rank() == 0 { pattern(seed, count) } else { vec![1] };
        assert_same(&world.broadcast_with(bytes, piece, None)?, &pattern(seed, count), "broadcast");
    }
    assert!(world.broadcast(pattern(9, 77))? == pattern(9, 77));
    Ok(())
}

fn gather(world: &World) -> Result<(), ClusterError> {
    // Twice at once, so that a rank that is ahead sends the second before rank 0 has all of the first.
    for seed in [10, 20] {
        let of_rank =
            |rank: u32| pattern(seed + u64::from(rank), [3, 1024, 1025, 2_000_003][rank as usize % 4]);
        let all = world.gather(&of_rank(world.rank()))?;
        assert_eq!(all.is_some(), world.rank() == 0);
        for (rank, bytes) in all.into_iter().flatten().enumerate() {
            assert_same(&bytes, &of_rank(rank as u32), &format!("gathered from rank {rank}"));
        }
    }
    world.agree("program version", "0.1.0")
}

/// What a unit is and gives: a few of them are long.
fn description(unit: u64) -> Vec<u8> {
    pattern(unit, [1, 40, 1024, 1025, 20_000][unit as usize % 5])
}

fn result(unit: u64, description: &[u8]) -> Vec<u8> {
    let count = if unit % 11 == 3 { 9_000_000 + unit as usize } else { unit as usize * 37 % 5000 };
    let mut bytes = pattern(unit + 1000, count);
    bytes.extend_from_slice(description);
    bytes
}

/// A job whose results are compared with those computed without MPI.
fn farm(world: &World, job: (u64, u32, u32), cancel_at: Option<u64>) -> Result<(Report, u64), ClusterError> {
    let (units, in_flight, threads) = job;
    let (mut collected, mut shown) = (0, 0);
    let cancel = AtomicBool::new(false);
    let mut collect = |unit, bytes: Vec<u8>| {
        assert_eq!(unit, collected, "units come in order, each once");
        assert_same(&bytes, &result(unit, &description(unit)), &format!("unit {unit}"));
        collected += 1;
        cancel.fetch_or(cancel_at == Some(unit), Ordering::Relaxed);
        Ok(())
    };
    let mut progress = |progress: &eosphor_cluster::JobProgress| {
        assert!(progress.units_done >= progress.units_collected && progress.units_total == units);
        assert_eq!(progress.ranks.iter().map(|rank| rank.units_done).sum::<u64>(), progress.units_done);
        shown += 1;
    };
    let coordinator = Coordinator {
        describe: &mut |unit| Ok(Some(description(unit))),
        collect: &mut collect,
        in_order: true,
        progress: &mut progress,
        cancel: &cancel,
    };
    let report = world.run(Job {
        units,
        in_flight,
        coordinator: (world.rank() == 0).then_some(coordinator),
        compute: &|unit, bytes| {
            std::thread::sleep(Duration::from_millis(unit * 7 % 5));
            Ok(result(unit, bytes))
        },
        threads,
    })?;
    assert!(world.rank() != 0 || (collected == report.units_done && shown >= 1));
    assert_eq!((report.units_total, report.ranks.len()), (units, world.size() as usize));
    Ok((report, collected))
}

fn run(world: &World) -> Result<(), ClusterError> {
    for job in [(40, 2, 1), (0, 2, 1), (1, 3, 2), (57, 4, 2), (23, 1, 3), (9, 0, 1)] {
        let (report, _) = farm(world, job, None)?;
        assert!(report.complete && report.units_done == job.0, "{report:?}");
        assert_eq!(report.ranks.iter().map(|rank| rank.units_done).sum::<u64>(), job.0);
        // All ranks have the same report.
        world.agree("report", &format!("{report:?}"))?;
    }
    open_ended(world)
}

/// A job of which nobody knows beforehand how many units it has, and whose results are taken as they come.
fn open_ended(world: &World) -> Result<(), ClusterError> {
    const UNITS: u64 = 43;
    let (mut seen, cancel) = (vec![false; UNITS as usize], AtomicBool::new(false));
    let mut describe = |unit: u64| {
        std::thread::sleep(Duration::from_millis(unit % 3));
        Ok((unit < UNITS).then(|| description(unit)))
    };
    let mut collect = |unit: u64, bytes: Vec<u8>| {
        assert_same(&bytes, &result(unit, &description(unit)), &format!("unit {unit}"));
        assert!(!std::mem::replace(&mut seen[unit as usize], true), "each once");
        Ok(())
    };
    let coordinator = Coordinator {
        describe: &mut describe,
        collect: &mut collect,
        in_order: false,
        progress: &mut |_| (),
        cancel: &cancel,
    };
    let report = world.run(Job {
        units: u64::MAX,
        in_flight: 2,
        coordinator: (world.rank() == 0).then_some(coordinator),
        compute: &|unit, bytes| {
            // The first ones last.
            std::thread::sleep(Duration::from_millis(if unit < 3 { 60 } else { 1 }));
            Ok(result(unit, bytes))
        },
        threads: 1,
    })?;
    assert!(report.complete && report.units_done == UNITS && report.units_total == UNITS, "{report:?}");
    assert!(world.rank() != 0 || seen.iter().all(|&seen| seen));
    Ok(())
}

fn cancel(world: &World) -> Result<(), ClusterError> {
    let (report, _) = farm(world, (100_000, 2, 1), Some(30))?;
    assert!(!report.complete && report.units_done > 30 && report.units_done < 100_000, "{report:?}");
    // The next job is a whole one again.
    let (report, _) = farm(world, (10, 2, 1), None)?;
    assert!(report.complete);
    Ok(())
}

/// Broadcasts, gathers, runs jobs and cancels one, with all numbers of ranks.
fn check(kind: Kind) {
    let Some(launcher) = kind.launcher() else { return };
    for ranks in RANKS {
        let outcome = start(&launcher, ranks, "all", &[]).end();
        outcome.assert_success();
        let good: Vec<&str> = outcome.output.lines().filter(|line| line.contains("good under")).collect();
        assert!(good.len() == 1 && good[0].contains(kind.library()), "{ranks} ranks: {}", outcome.output);
    }
}

#[test]
fn all_is_as_in_one_process_under_mpich() {
    check(Kind::Mpich);
}

#[test]
fn all_is_as_in_one_process_under_open_mpi() {
    check(Kind::OpenMpi);
}

#[test]
fn all_is_as_in_one_process_under_the_standard_abi() {
    check(Kind::Mpich5);
}

#[test]
fn ranks_that_differ_are_named_with_both_texts() {
    for kind in KINDS {
        let Some(launcher) = kind.launcher() else { continue };
        let outcome = start(&launcher, 3, "differ", &[]).end();
        outcome.assert_one_error(&["program version", "rank 0 on ", "\"0.1.0\"", "rank 1 on ", "\"0.2.0\""]);
        assert!(!outcome.errors.contains("rank 2 on"), "{}", outcome.errors);
    }
}

#[test]
fn a_broadcast_that_came_otherwise_names_the_rank() {
    for kind in KINDS {
        let Some(launcher) = kind.launcher() else { continue };
        let outcome = start(&launcher, 3, "damage", &[]).end();
        outcome.assert_one_error(&["100000 bytes", "rank 2 on ", "check sum "]);
    }
}

#[test]
fn without_a_launcher_mpi_is_not_opened() {
    // Not even where a library is named.
    let outcome = start_alone("open", &[("EOSPHOR_MPI", "/nowhere/libmpi.so")]).end();
    outcome.assert_success();
    assert!(outcome.output.contains("no launcher") && outcome.errors.is_empty(), "{}", outcome.errors);
}

#[test]
fn a_library_that_is_not_there_is_named() {
    let outcome = start_alone("open", &[("PMI_SIZE", "2"), ("EOSPHOR_MPI", "/nowhere/libmpi.so")]).end();
    outcome.assert_one_error(&["/nowhere/libmpi.so", "cannot be opened"]);
}

#[test]
fn a_library_of_another_kind_than_the_launcher_is_refused() {
    let [Some(mpich), Some(open_mpi)] = [Kind::Mpich, Kind::OpenMpi].map(Kind::launcher) else { return };
    for (launcher, library, parts) in [
        (&mpich, "libmpi.so.40", ["mpirun of MPICH", "is Open MPI v"]),
        (&open_mpi, "libmpich.so.12", ["mpirun of Open MPI", "is MPICH Version"]),
    ] {
        let outcome = start(launcher, 1, "open", &[("EOSPHOR_MPI", library)]).end();
        outcome.assert_one_error(&parts);
        assert!(outcome.errors.contains(library));
    }
}

#[test]
fn a_library_that_sees_another_number_of_processes_is_refused() {
    if Kind::Mpich.launcher().is_none() {
        return;
    }
    // What a launcher's variables say, without that launcher.
    let outcome = start_alone("open", &[("PMI_SIZE", "2"), ("EOSPHOR_MPI", "libmpich.so.12")]).end();
    outcome.assert_one_error(&["mpirun of MPICH", "started 2 processes", "sees 1", "libmpich.so.12"]);
}
