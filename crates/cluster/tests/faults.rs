//! Whatever happens to a rank, the job ends soon, on all ranks, with one clear line.

mod common;

use common::{KINDS, Outcome, signal, start};
use eosphor_cluster::{Coordinator, Job, World, launched_rank};
use std::sync::atomic::AtomicBool;
use std::time::Duration;

/// A job has ended by then. It takes a fraction of that: the rest is for slow machines.
const SOON: Duration = Duration::from_secs(10);

/// The ranks of a job are this program again, which runs this test alone.
#[test]
fn rank_of_a_job() {
    let Some(case) = common::case() else { return };
    let (stop_at, stopped) = case.split_once(" by rank ").unwrap_or((&case, ""));
    let stop = |at: &str| {
        if at == stop_at && launched_rank().unwrap().to_string() == stopped {
            // SAFETY: it takes a number only. This thread does not go on before the others are stopped.
            unsafe { libc::raise(libc::SIGSTOP) };
        }
    };
    if stop_at == "stop before the start" {
        common::say_process(launched_rank().unwrap());
        stop("stop before the start");
    }
    let silence = (case == "silence" || !stopped.is_empty()).then_some(Duration::from_secs(3));
    let world = World::open(silence).unwrap().unwrap();
    world.abort_handle().on_panic();
    // From now on a test may strike.
    common::say_process(world.rank());
    if stop_at == "stop in a broadcast" {
        std::thread::scope(|scope| {
            // At any moment of one.
            scope.spawn(|| {
                std::thread::sleep(Duration::from_millis(300));
                stop("stop in a broadcast");
            });
            let mut bytes = vec![7; 50_000_000];
            loop {
                bytes = world.broadcast(bytes).unwrap();
            }
        });
    }
    if stop_at == "stop before the end" {
        stop("stop before the end");
        world.finish().unwrap();
        std::process::exit(0);
    }
    let cancel = AtomicBool::new(false);
    let coordinator = Coordinator {
        describe: &mut |unit| match case.as_str() {
            "describe" if unit == 5 => Err("frame 5 cannot be".into()),
            _ => Ok(Some(vec![0; 2000])),
        },
        collect: &mut |unit, _| match case.as_str() {
            "collect" if unit == 5 => Err("/tmp/frame5.png: no space left on the disk".into()),
            _ => Ok(()),
        },
        in_order: true,
        progress: &mut |_| {},
        cancel: &cancel,
    };
    let report = world.run(Job {
        units: if case == "endless" || case == "silence" { 1_000_000 } else { 200 },
        in_flight: 2,
        coordinator: (world.rank() == 0).then_some(coordinator),
        compute: &|unit, _| {
            std::thread::sleep(Duration::from_millis(20));
            match case.as_str() {
                "compute" if unit == 7 => Err("unit 7 has no light".into()),
                "panic" if unit == 7 => panic!("index out of bounds"),
                _ => Ok(vec![1; 300_000]),
            }
        },
        threads: 1,
    });
    // All of these cases have to end before.
    println!("went on: {report:?}");
    std::process::exit(0);
}

/// Runs a case under every MPI, with three ranks.
fn each(case: &str, check: impl Fn(Outcome)) {
    for kind in KINDS {
        let Some(launcher) = kind.launcher() else { continue };
        let outcome = start(&launcher, 3, case, &[]).end_within(SOON * 6);
        assert!(!outcome.output.contains("went on"), "{kind:?}: {}", outcome.output);
        check(outcome);
    }
}

#[test]
fn an_error_of_a_unit_ends_the_job() {
    each("compute", |outcome| {
        outcome.assert_one_error(&["rank ", " of 3 on ", "unit 7: unit 7 has no light"])
    });
}

#[test]
fn a_panic_ends_the_job() {
    each("panic", |outcome| {
        outcome.assert_one_error(&["rank ", " of 3 on ", "faults.rs:", "index out of bounds"]);
        assert_eq!(outcome.errors.matches("index out of bounds").count(), 1, "{}", outcome.errors);
    });
}

#[test]
fn a_full_disk_on_rank_0_ends_the_job() {
    each("collect", |outcome| {
        outcome.assert_one_error(&["rank 0 of 3 on ", "collecting unit 5: /tmp/frame5.png: no space left"]);
    });
}

#[test]
fn a_unit_that_cannot_be_described_ends_the_job() {
    each("describe", |outcome| {
        outcome.assert_one_error(&["rank 0 of 3 on ", "describing unit 5: frame 5 cannot be"]);
    });
}

/// Sends a signal to a rank while all are at work.
fn struck(case: &str, rank: u32, with: i32, check: impl Fn(Outcome)) {
    for kind in KINDS {
        let Some(launcher) = kind.launcher() else { continue };
        let job = start(&launcher, 3, case, &[]);
        let process = job.wait_for_process(3, rank);
        std::thread::sleep(Duration::from_millis(300));
        signal(process, with);
        let outcome = job.end_within(SOON);
        assert!(!outcome.status.success() && !outcome.output.contains("went on"), "{kind:?}");
        check(outcome);
    }
}

#[test]
fn when_a_worker_is_killed_all_end() {
    struck("endless", 1, libc::SIGKILL, |_| {});
}

#[test]
fn when_rank_0_is_killed_all_end() {
    struck("endless", 0, libc::SIGKILL, |_| {});
}

#[test]
fn a_worker_that_is_stopped_is_named() {
    struck("silence", 2, libc::SIGSTOP, |outcome| {
        outcome.assert_one_error(&["rank 0 of 3 on ", "rank 2 on ", "has said nothing for "]);
    });
}

/// A rank that stops itself at a place.
fn stops(at: &str, ranks: &[u32], check: impl Fn(&str, Outcome)) {
    for rank in ranks {
        let case = format!("{at} by rank {rank}");
        each(&case, |outcome| check(&format!("rank {rank}"), outcome));
    }
}

#[test]
fn a_rank_that_is_stopped_while_mpi_starts_is_not_waited_for() {
    stops("stop before the start", &[2], |rank, outcome| {
        let lines = outcome.error_lines();
        // A launcher that is slow to end the others lets a second one speak.
        let is_clear = |line: &&str| line.contains(" of 3: MPI_Init_thread has waited for other ranks for ");
        assert!(!outcome.status.success() && !lines.is_empty() && lines.iter().all(is_clear), "{lines:?}");
        assert!(!lines.iter().any(|line| line.starts_with(&format!("error: {rank}"))), "{lines:?}");
    });
}

#[test]
fn a_rank_that_is_stopped_in_a_broadcast_is_named() {
    stops("stop in a broadcast", &[0, 2], |rank, outcome| {
        outcome.assert_one_error(&["rank ", " of 3 on ", &format!("{rank} on "), "has said nothing for "]);
    });
}

#[test]
fn a_rank_that_is_stopped_before_mpi_ends_is_named() {
    stops("stop before the end", &[0], |rank, outcome| {
        outcome.assert_one_error(&["rank ", " of 3 on ", &format!("{rank} on "), "has said nothing for "]);
    });
}

#[test]
fn when_rank_0_is_stopped_the_others_end_the_job() {
    struck("silence", 0, libc::SIGSTOP, |outcome| {
        outcome.assert_one_error(&["rank 1 of 3 on ", "rank 0 on ", "has said nothing for "]);
    });
}
