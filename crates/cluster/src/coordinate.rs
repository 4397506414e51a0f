//! Rank 0's side of a job: hands units out, and takes results in.

use crate::error::ClusterError;
use crate::idle::Idle;
use crate::job::{Coordinator, Job, JobProgress, RankProgress, Report};
use crate::messages::{Channel, Letter};
use crate::thread_pool::{Crew, run_or_abort};
use crate::work::{Kind, or_abort};
use crate::world::World;
use std::collections::BTreeMap;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::{Receiver, Sender, TryRecvError, channel, sync_channel};
use std::time::{Duration, Instant};

/// How many times the units in flight may be ahead of the first that is not collected, so that memory is bounded.
const WINDOW: u64 = 3;
/// Descriptions that are made ahead.
const DESCRIBED_AHEAD: usize = 16;
const PROGRESS_EVERY: Duration = Duration::from_millis(100);

/// Runs a job from rank 0 to its end.
pub(crate) fn coordinate(world: &World, job: &Job, coordinator: Coordinator) -> Result<Report, ClusterError> {
    let Coordinator { describe, collect, in_order, progress, cancel } = coordinator;
    let abort = world.abort_handle();
    let crew = Crew::new(job.compute, abort.clone());
    let collected = AtomicU64::new(0);
    let messenger = std::thread::current();
    std::thread::scope(|scope| {
        let _closing = crew.closing();
        for _ in 0..job.threads {
            scope.spawn(|| crew.work());
        }
        let (described, descriptions) = sync_channel(DESCRIBED_AHEAD);
        let (results, arrived) = channel::<(u64, Vec<u8>)>();
        let (units, describe_abort, describe_messenger) = (job.units, abort.clone(), messenger.clone());
        scope.spawn(move || {
            for unit in 0..units {
                let doing = format!("describing unit {unit}");
                let Some(description) = run_or_abort(&describe_abort, &doing, || describe(unit)) else {
                    break;
                };
                if described.send((unit, description)).is_err() {
                    return; // cancelled
                }
                describe_messenger.unpark();
            }
            // There are no more: the messenger sees that the sender is gone.
            drop(described);
            describe_messenger.unpark();
        });
        let (collect_abort, collected) = (abort.clone(), &collected);
        scope.spawn(move || {
            for (unit, result) in arrived {
                let doing = format!("collecting unit {unit}");
                run_or_abort(&collect_abort, &doing, || collect(unit, result));
                collected.fetch_add(1, Ordering::Release);
                messenger.unpark();
            }
        });

        let now = Instant::now();
        let ranks = vec![RankProgress::default(); world.size() as usize];
        let mut farm = Farm {
            world,
            job,
            crew: &crew,
            descriptions: Some(descriptions),
            results,
            collected,
            in_order,
            waiting: BTreeMap::new(),
            passed_on: 0,
            handed_out: 0,
            progress: JobProgress { units_total: job.units, ranks, ..JobProgress::default() },
            start: now,
            bytes_before: world.mail.borrow().bytes_moved,
        };
        farm.progress.ranks[0].threads = job.threads;
        let (mut idle, mut shown) = (Idle::new(), now);
        while !farm.is_finished() {
            let now = Instant::now();
            if cancel.load(Ordering::Relaxed) {
                farm.descriptions = None;
            }
            let mut moved = farm.take_in();
            or_abort(world, world.live());
            moved |= farm.hand_out();
            if now - shown >= PROGRESS_EVERY {
                shown = now;
                progress(farm.progress_now());
            }
            idle.rest(moved, world.mail.borrow().is_moving());
        }
        progress(farm.progress_now());
        Ok(farm.dismiss())
    })
}

/// What rank 0 knows of a job.
struct Farm<'f, 'j, 'c> {
    world: &'f World,
    job: &'f Job<'j, 'c>,
    crew: &'f Crew<'j>,
    /// Units that can be handed out; `None` when nothing more is.
    descriptions: Option<Receiver<(u64, Vec<u8>)>>,
    results: Sender<(u64, Vec<u8>)>,
    /// How many the collecting thread has taken.
    collected: &'f AtomicU64,
    in_order: bool,
    /// Results whose turn has not come.
    waiting: BTreeMap<u64, Vec<u8>>,
    /// Results that were given to the collecting thread.
    passed_on: u64,
    handed_out: u64,
    progress: JobProgress,
    start: Instant,
    bytes_before: u64,
}

impl Farm<'_, '_, '_> {
    fn is_finished(&self) -> bool {
        let is_all_handed_out = self.descriptions.is_none() || self.handed_out == self.job.units;
        is_all_handed_out && self.collected.load(Ordering::Acquire) == self.handed_out
    }

    /// Takes messages and results: whether there were any.
    fn take_in(&mut self) -> bool {
        let mut mail = self.world.mail.borrow_mut();
        let mut moved = or_abort(self.world, mail.poll(&self.world.mpi));
        while let Some((rank, letter)) = mail.take_any(Channel::Job) {
            let of_rank = &mut self.progress.ranks[rank as usize];
            match Kind::of(&letter) {
                Kind::Hello => of_rank.threads = letter.number as u32,
                Kind::Computed => {
                    moved = true;
                    of_rank.in_flight -= 1;
                }
                Kind::Result => {
                    moved = true;
                    take_result(&mut self.progress, rank, letter.bytes.len(), letter.seconds);
                    self.waiting.insert(letter.number, letter.bytes);
                }
                _ => {}
            }
        }
        for done in self.crew.take_done() {
            moved = true;
            self.progress.ranks[0].in_flight -= 1;
            take_result(&mut self.progress, 0, done.result.len(), done.seconds);
            self.waiting.insert(done.unit, done.result);
        }
        while let Some(result) = match self.in_order {
            true => self.waiting.remove(&self.passed_on).map(|result| (self.passed_on, result)),
            false => self.waiting.pop_first(),
        } {
            // The collecting thread ends after this sender only, or with the process.
            let _ = self.results.send(result);
            self.passed_on += 1;
        }
        moved
    }

    /// Gives units to ranks that have few: whether to any.
    fn hand_out(&mut self) -> bool {
        let in_flight = u64::from(self.job.in_flight);
        let capacity: u64 = self.progress.ranks.iter().map(|rank| in_flight.max(rank.threads.into())).sum();
        let limit = self.collected.load(Ordering::Acquire) + WINDOW * capacity;
        let mut moved = false;
        while self.handed_out < self.job.units.min(limit) {
            let is_near_end = self.job.units - self.handed_out < capacity;
            let room = |rank: &RankProgress| {
                let threads = u64::from(rank.threads);
                let most = if is_near_end { threads } else { in_flight.max(threads) };
                threads > 0 && rank.in_flight < most
            };
            // To whom has the least work ahead, by its threads.
            let load =
                |rank: &RankProgress| (rank.in_flight * 1024 / u64::from(rank.threads), rank.in_flight);
            let ranks = self.progress.ranks.iter().enumerate().filter(|(_, rank)| room(rank));
            let Some(rank) = ranks.min_by_key(|(_, rank)| load(rank)).map(|(number, _)| number) else {
                break;
            };
            let (unit, bytes) = match self.descriptions.as_ref().map(Receiver::try_recv) {
                Some(Ok(described)) => described,
                Some(Err(TryRecvError::Disconnected)) => {
                    self.descriptions = None;
                    self.progress.units_total = self.handed_out;
                    moved = true;
                    break;
                }
                _ => break,
            };
            self.progress.ranks[rank].in_flight += 1;
            self.handed_out += 1;
            moved = true;
            if rank == 0 {
                self.crew.push(unit, bytes);
            } else {
                self.send(rank as u32, Kind::Unit, Letter { number: unit, bytes, ..Letter::default() });
            }
        }
        moved
    }

    fn send(&self, rank: u32, kind: Kind, letter: Letter) {
        let mut mail = self.world.mail.borrow_mut();
        let letter = Letter { kind: kind as u8, ..letter };
        or_abort(self.world, mail.send(&self.world.mpi, Channel::Job, rank, letter));
    }

    fn progress_now(&mut self) -> &JobProgress {
        self.progress.units_collected = self.collected.load(Ordering::Acquire);
        self.progress.elapsed = self.start.elapsed();
        self.progress.bytes_moved = self.world.mail.borrow().bytes_moved - self.bytes_before;
        &self.progress
    }

    /// Tells all that the job is over, and waits until they have left it.
    fn dismiss(mut self) -> Report {
        let report = Report::new(self.progress_now().clone());
        for rank in 1..self.world.size() {
            self.send(rank, Kind::Stop, Letter { bytes: report.to_bytes(), ..Letter::default() });
        }
        let mut staying: Vec<u32> = (1..self.world.size()).collect();
        let mut idle = Idle::new();
        while !staying.is_empty() || !self.world.mail.borrow().is_sent() {
            let mut mail = self.world.mail.borrow_mut();
            let moved = or_abort(self.world, mail.poll(&self.world.mpi));
            // What a rank says after it has left belongs to the next job.
            staying.retain(|&rank| {
                let mut letters = std::iter::from_fn(|| mail.take(Channel::Job, rank));
                !letters.any(|letter| Kind::of(&letter) == Kind::Bye)
            });
            let is_moving = mail.is_moving();
            drop(mail);
            or_abort(self.world, self.world.live());
            idle.rest(moved, is_moving);
        }
        report
    }
}

fn take_result(progress: &mut JobProgress, rank: u32, bytes: usize, seconds: f64) {
    let rank = &mut progress.ranks[rank as usize];
    rank.units_done += 1;
    rank.seconds_computing += seconds;
    rank.result_bytes += bytes as u64;
    progress.units_done += 1;
}
