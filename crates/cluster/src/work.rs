//! The other ranks' side of a job: they compute what rank 0 hands out.

use crate::error::ClusterError;
use crate::idle::Idle;
use crate::job::{Job, Report};
use crate::messages::{Channel, Letter};
use crate::thread_pool::Crew;
use crate::world::World;

/// Messages of a job.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub(crate) enum Kind {
    /// To rank 0: here I am, with as many threads.
    Hello = 1,
    /// To rank 0: a unit is computed, so that another may come; its result follows, which takes longer.
    Computed,
    /// To rank 0: a unit's result and the seconds it took.
    Result,
    /// To rank 0, the last of a job: nothing more will come.
    Bye,
    /// From rank 0: a unit and its description.
    Unit,
    /// From rank 0, the last of a job: its report.
    Stop,
}

impl Kind {
    pub(crate) fn of(letter: &Letter) -> Kind {
        use Kind::*;
        [Hello, Computed, Result, Bye, Unit, Stop][usize::from(letter.kind) - 1]
    }
}

/// Within a job other threads compute, so that an error of MPI cannot wait for them: it ends the job.
pub(crate) fn or_abort<T>(world: &World, result: Result<T, ClusterError>) -> T {
    result.unwrap_or_else(|error| world.abort_handle().now(&error.to_string()))
}

/// Works for rank 0 until the job's end.
pub(crate) fn work(world: &World, job: &Job) -> Result<Report, ClusterError> {
    let crew = Crew::new(job.compute, world.abort_handle());
    std::thread::scope(|scope| {
        let _closing = crew.closing();
        for _ in 0..job.threads {
            scope.spawn(|| crew.work());
        }
        let send = |kind: Kind, letter: Letter| {
            let letter = Letter { kind: kind as u8, ..letter };
            or_abort(world, world.mail.borrow_mut().send(&world.mpi, Channel::Job, 0, letter));
        };
        let (mut idle, mut report) = (Idle::new(), None);
        send(Kind::Hello, Letter { number: job.threads.into(), ..Letter::default() });
        // Rank 0 says that the job is over when it has all results, so nothing is on its way then but signs of life.
        while report.is_none() {
            let mut moved = or_abort(world, world.mail.borrow_mut().poll(&world.mpi));
            or_abort(world, world.live());
            while let Some(letter) = world.take(Channel::Job, 0) {
                match Kind::of(&letter) {
                    Kind::Unit => crew.push(letter.number, letter.bytes),
                    Kind::Stop => report = Report::from_bytes(&letter.bytes),
                    _ => {}
                }
            }
            for done in crew.take_done() {
                moved = true;
                let (number, seconds, bytes) = (done.unit, done.seconds, done.result);
                send(Kind::Computed, Letter { number, ..Letter::default() });
                send(Kind::Result, Letter { number, seconds, bytes, ..Letter::default() });
            }
            idle.rest(moved, world.mail.borrow().is_moving());
        }
        send(Kind::Bye, Letter::default());
        world.flush()?;
        report.ok_or_else(|| unreachable!("the loop ends with a report"))
    })
}
