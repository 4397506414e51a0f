//! The coordinator, which is rank 0: a thread runs the command, and this one has MPI.

use super::RankOptions;
use super::backend::{ClusterBackend, Crew, Request, Submission};
use super::wire::{self, Order, Ready};
use super::worker::{LOOK_INTERVAL, Local, Prepared, meanwhile, meet, together};
use crate::failure::Failure;
use crate::interrupt;
use crate::streams::Verbosity;
use crate::text::{bytes, duration};
use eosphor::{Backend, BackendError};
use eosphor_cluster::{Coordinator, JobProgress, RankProgress, Report, World};
use std::collections::{BTreeMap, HashMap};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

/// Between two lines about the ranks.
const LINE_INTERVAL: Duration = Duration::from_secs(10);

/// Runs a command with all ranks as its backend.
pub(super) fn run(
    world: &World,
    options: &RankOptions,
    command: impl FnOnce(Option<&dyn Backend>) -> Result<(), Failure> + Send,
) -> Result<(), Failure> {
    let sharers = meet(world)?;
    let (requests, receiver) = channel();
    let backend = ClusterBackend::new(requests, world.size());
    let abort = world.abort_handle();
    std::thread::scope(|scope| {
        let running = scope.spawn(move || command(Some(&backend)));
        // Devices take a while to open, and so do scenes to load.
        let local = Local::open(world, options, sharers)?;
        // Until the command, which has the backend, has ended.
        loop {
            let served = match receiver.recv_timeout(LOOK_INTERVAL) {
                Ok(request) => serve(world, options, &local, request),
                Err(RecvTimeoutError::Timeout) => together(world, world.attend()),
                Err(RecvTimeoutError::Disconnected) => break,
            };
            if let Err(failure) = served {
                abort.now(&failure.line().unwrap_or_default());
            }
        }
        together(world, world.broadcast(Order::Leave.to_bytes()))?;
        // Its panic has ended all ranks.
        running.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic))
    })
}

/// Gets all ranks ready for a scene, and lets them render it.
fn serve(
    world: &World,
    options: &RankOptions,
    local: &Result<Local, String>,
    request: Request,
) -> Result<(), Failure> {
    let Request { scene, units, reply } = request;
    let order = meanwhile(world, || Order::prepare(&scene))??;
    together(world, world.broadcast(order))?;
    let mine = local.as_ref().map(|local| local.ready.clone()).map_err(String::clone);
    let mine = wire::encode(&mine).map_err(Failure::Failed)?;
    let gathered = together(world, world.gather(&mine))?;
    let gathered: Vec<Result<Ready, String>> = gathered
        .unwrap_or_default()
        .iter()
        .map(|ready| wire::decode(ready).and_then(|ready| ready))
        .collect();
    let wrong = gathered.iter().zip(0..).find_map(|(ready, rank)| Some((rank, ready.as_ref().err()?)));
    let (Ok(local), None) = (local, wrong) else {
        together(world, world.broadcast(Order::Wait.to_bytes()))?;
        let (rank, reason) = wrong.map_or((0, "not ready"), |(rank, reason)| (rank, reason));
        let host = &world.hosts()[rank as usize];
        let _ = reply.send(Err(BackendError::Unavailable(format!("rank {rank} on {host}: {reason}"))));
        return Ok(());
    };
    let all: Vec<Ready> = gathered.into_iter().flatten().collect();
    warn_of_few_processors(world, options.verbosity, &all);
    together(world, world.broadcast(Order::Work.to_bytes()))?;
    let prepared = Arc::new(Prepared::new());
    let crew = Crew {
        local: Arc::clone(&prepared),
        size: (scene.settings.width, scene.settings.height),
        samples: scene.settings.samples,
        description: describe(world, &all),
        ranks: world.size(),
        are_gpus: all.iter().all(|ready| ready.is_gpu),
    };
    // Where nobody waits for it any more, nothing is rendered.
    let _ = reply.send(Ok(crew));

    let slots = Mutex::new(HashMap::new());
    let slots = &slots;
    let lock = || slots.lock().unwrap_or_else(PoisonError::into_inner);
    let mut describe = move |unit: u64| {
        Ok(next(&units).map(|Submission { unit: bytes, reply, first_row }| {
            lock().insert(unit, (reply, first_row));
            bytes
        }))
    };
    let mut collect = |unit: u64, result: Vec<u8>| {
        if let Some((reply, first_row)) = lock().remove(&unit) {
            // Who has failed does not wait any more.
            let _ = reply.send((first_row, result));
        }
        Ok(())
    };
    let (mut shown, verbosity) = (Duration::ZERO, options.verbosity);
    let mut progress = |progress: &JobProgress| {
        if progress.elapsed >= shown + LINE_INTERVAL {
            shown = progress.elapsed;
            let &JobProgress { units_done, bytes_moved, elapsed, ref ranks, .. } = progress;
            verbosity.say(Verbosity::Normal, &summary(units_done, bytes_moved, elapsed, ranks));
        }
    };
    // What was handed out is rendered to its end, or given up by the ranks themselves.
    let cancel = AtomicBool::new(false);
    let coordinator = Coordinator {
        describe: &mut describe,
        collect: &mut collect,
        in_order: false,
        progress: &mut progress,
        cancel: &cancel,
    };
    let report = local.work(world, scene, Some(coordinator), &prepared)?;
    let Report { units_done, bytes_moved, elapsed, ref ranks, .. } = report;
    verbosity.say(Verbosity::Normal, &summary(units_done, bytes_moved, elapsed, ranks));
    Ok(())
}

/// The next unit to be handed out, which may take its time; `None` when there will be none. A while after a signal units are
/// dropped.
fn next(units: &Receiver<Submission>) -> Option<Submission> {
    loop {
        let submission = units.recv().ok()?;
        if !interrupt::cancel().overdue().load(Ordering::Relaxed) {
            return Some(submission);
        }
    }
}

/// `4 ranks on 2 hosts: 3 x CPU, 2 threads, AVX2 + FMA; 1 x CUDA, ...`
fn describe(world: &World, all: &[Ready]) -> String {
    let mut backends = BTreeMap::<&str, u32>::new();
    all.iter().for_each(|ready| *backends.entry(&ready.backend).or_default() += 1);
    let backends: Vec<String> = backends.iter().map(|(name, count)| format!("{count} x {name}")).collect();
    let mut hosts = world.hosts().to_vec();
    hosts.sort();
    hosts.dedup();
    let hosts = if hosts.len() == 1 { "1 host".into() } else { format!("{} hosts", hosts.len()) };
    format!("{} ranks on {hosts}: {}", world.size(), backends.join("; "))
}

/// Launchers that bind each process to a core leave the others idle.
fn warn_of_few_processors(world: &World, verbosity: Verbosity, all: &[Ready]) {
    let on_host = |rank: usize| world.hosts().iter().filter(|host| **host == world.hosts()[rank]).count();
    let is_tied = |(rank, ready): &(usize, &Ready)| {
        let (mine, of_host) = ready.processors;
        !ready.is_gpu && mine == 1 && of_host as usize > on_host(*rank)
    };
    let tied: Vec<usize> = all.iter().enumerate().filter(is_tied).map(|(rank, _)| rank).collect();
    let Some(&first) = tied.first() else { return };
    verbosity.say(
        Verbosity::Normal,
        &format!(
            "eosphor: note: {} of {} ranks may use one processor only: rank {first} on {} has 1 of {}; start with \
             mpirun --bind-to none, or srun --cpu-bind=none",
            tied.len(),
            all.len(),
            world.hosts()[first],
            all[first].processors.1
        ),
    );
}

/// `ranks: 120 units, 45.1 MB moved in 12 s; units a second: 0: 2.5, 1: 2.4`
fn summary(units: u64, bytes_moved: u64, elapsed: Duration, ranks: &[RankProgress]) -> String {
    const SHOWN: usize = 16;
    let seconds = elapsed.as_secs_f64();
    let rate = |units: u64| if seconds > 0.0 { units as f64 / seconds } else { 0.0 };
    let each = ranks.iter().enumerate().take(SHOWN);
    let each: Vec<String> = each.map(|(rank, of)| format!("{rank}: {:.2}", rate(of.units_done))).collect();
    let more = if ranks.len() > SHOWN { ", ..." } else { "" };
    format!(
        "ranks: {units} units and {} moved in {}; units a second: {}{more}",
        bytes(bytes_moved),
        duration(seconds),
        each.join(", ")
    )
}
