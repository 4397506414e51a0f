//! All processes of a job.

use crate::abort::Abort;
use crate::error::ClusterError;
use crate::idle::Idle;
use crate::launcher::Launcher;
use crate::library::MpiLibrary;
use crate::messages::{Channel, Letter, Mail};
use crate::mpi::Mpi;
use crate::time_outs::patiently;
use crate::watch::Watch;
use std::cell::{Cell, RefCell};
use std::marker::PhantomData;
use std::time::{Duration, Instant};

/// Pieces of long messages: so short that signs of life pass between them, so long that they cost nothing.
const PIECE: usize = 8 << 20;

/// All processes of a job. It is used on the thread that opened it; other threads may do what they like but call MPI.
///
/// A process that ends without [`World::finish`] ends the whole job.
pub struct World {
    pub(crate) mpi: Mpi,
    pub(crate) mail: RefCell<Mail>,
    abort: Abort,
    hosts: Vec<String>,
    local_rank: u32,
    local_size: u32,
    silence: Option<Duration>,
    /// Who has been heard.
    life: RefCell<Watch>,
    /// Nobody asks or answers any more.
    is_ending: Cell<bool>,
    /// MPI belongs to one thread.
    _of_this_thread: PhantomData<*const ()>,
}

impl World {
    /// Opens MPI and finds the other processes. `None` where no launcher started this process: MPI is not looked for
    /// then. The environment variable EOSPHOR_MPI names the library to open; else it is the first that fits the
    /// launcher, in the launcher's own folder and where the system looks.
    ///
    /// A rank that says nothing for longer than `silence` while another waits for it ends the job (`None`: never); at the
    /// start it has twice as long, since launchers start ranks one after the other. Ranks speak within the calls of this type,
    /// also while they compute a job's units, so `silence` must be far longer than what they do between them.
    ///
    /// # Errors
    ///
    /// There is no library, or one that does not understand the launcher. Every rank gets such an error by itself.
    pub fn open(silence: Option<Duration>) -> Result<Option<World>, ClusterError> {
        let Some(launcher) = Launcher::of_this_process() else { return Ok(None) };
        let library = MpiLibrary::open(&launcher)?;
        let (rank, who) = launcher.rank_in_words();
        let mpi = patiently("MPI_Init_thread", silence.map(|silence| 2 * silence), rank, who, || {
            Mpi::start(library, &launcher)
        })?;
        let abort = Abort::new(&mpi);
        let (local_rank, local_size) =
            patiently("MPI_Comm_split_type", silence, mpi.rank, abort.who(), || mpi.local())?;
        let mut world = World {
            abort,
            hosts: Vec::new(),
            mail: RefCell::new(Mail::new(PIECE)),
            local_rank,
            local_size,
            silence,
            life: RefCell::new(Watch::new(silence, mpi.size, Instant::now())),
            is_ending: Cell::new(false),
            mpi,
            _of_this_thread: PhantomData,
        };
        let names = world.gather(world.host().as_bytes())?.map(|names| names.join(&b'\n'));
        let names = world.announce(names.unwrap_or_default())?;
        world.hosts = String::from_utf8_lossy(&names).split('\n').map(str::to_string).collect();
        Ok(Some(world))
    }

    /// The number of this process, from 0.
    pub fn rank(&self) -> u32 {
        self.mpi.rank
    }

    /// The number of processes of the job.
    pub fn size(&self) -> u32 {
        self.mpi.size
    }

    /// The number of this process among those of its host, from 0.
    pub fn local_rank(&self) -> u32 {
        self.local_rank
    }

    /// The number of processes of the job on this process's host.
    pub fn local_size(&self) -> u32 {
        self.local_size
    }

    /// The name of this process's host.
    pub fn host(&self) -> &str {
        &self.mpi.host
    }

    /// The names of all ranks' hosts, by rank.
    pub fn hosts(&self) -> &[String] {
        &self.hosts
    }

    /// What the library of MPI is, in its own words.
    pub fn library(&self) -> &str {
        &self.mpi.version
    }

    /// Ends all processes, from any thread.
    pub fn abort_handle(&self) -> Abort {
        self.abort.clone()
    }

    /// Gives signs of life, and looks for those of others. For ranks that wait for something else than other ranks: to be called
    /// often.
    ///
    /// # Errors
    ///
    /// MPI failed.
    pub fn attend(&self) -> Result<(), ClusterError> {
        self.mail.borrow_mut().poll(&self.mpi)?;
        self.live()
    }

    /// Asks others whether they live, answers who asks that of this rank, and ends the job where one does not answer.
    pub(crate) fn live(&self) -> Result<(), ClusterError> {
        if self.is_ending.get() {
            return Ok(());
        }
        let (now, mut life) = (Instant::now(), self.life.borrow_mut());
        let mut mail = self.mail.borrow_mut();
        let sign = |question: bool| Letter { kind: question.into(), ..Letter::default() };
        // Also pieces of a long message are signs of life, behind which others may have to wait.
        mail.take_heard().into_iter().for_each(|rank| life.hear(rank, now));
        while let Some((rank, letter)) = mail.take_any(Channel::Life) {
            if letter == sign(true) {
                mail.send(&self.mpi, Channel::Life, rank, sign(false))?;
            }
        }
        let others = if self.rank() == 0 { 1..self.size() } else { 0..1 };
        if life.is_time_to_speak(now) {
            for rank in others.clone() {
                mail.send(&self.mpi, Channel::Life, rank, sign(true))?;
            }
        }
        // When rank 0 falls silent rank 1 says so, usually: the others have more patience.
        let patience = if self.rank() < 2 { Duration::ZERO } else { Duration::from_secs(1) };
        if let Some((rank, quiet)) = life.silent(others, patience, now) {
            // At the very start hosts are not known.
            let on = self.hosts.get(rank as usize).map_or_else(String::new, |host| format!(" on {host}"));
            let quiet = quiet.as_secs_f64();
            self.abort_handle().now(&format!(
                "rank {rank}{on} has said nothing for {quiet:.1} s: is it stopped, or its host gone?"
            ));
        }
        Ok(())
    }

    /// Waits for all ranks, and ends MPI. Nothing may end the job after it but the process itself.
    ///
    /// # Errors
    ///
    /// MPI failed.
    pub fn finish(self) -> Result<(), ClusterError> {
        // MPI itself would wait by spinning.
        self.gather(&[])?;
        self.announce(Vec::new())?;
        self.is_ending.set(true);
        patiently("MPI_Finalize", self.silence, self.rank(), self.abort.who(), || {
            // Behind these come no signs of life: MPI must not end while any is on its way.
            self.gather(&[])?;
            self.abort.set_over();
            self.mpi.finalize()
        })
    }

    /// The next message from a rank, if it has come.
    pub(crate) fn take(&self, channel: Channel, rank: u32) -> Option<Letter> {
        self.mail.borrow_mut().take(channel, rank)
    }

    /// Waits for a message from a rank.
    pub(crate) fn wait_for(&self, channel: Channel, rank: u32) -> Result<Letter, ClusterError> {
        let mut idle = Idle::new();
        loop {
            if let Some(letter) = self.take(channel, rank) {
                return Ok(letter);
            }
            self.poll(&mut idle)?;
        }
    }

    /// Waits until all that was sent has gone.
    pub(crate) fn flush(&self) -> Result<(), ClusterError> {
        let mut idle = Idle::new();
        while !self.mail.borrow().is_sent() {
            self.poll(&mut idle)?;
        }
        Ok(())
    }

    /// Moves messages, and rests where there are none.
    fn poll(&self, idle: &mut Idle) -> Result<(), ClusterError> {
        let (moved, is_moving) = {
            let mut mail = self.mail.borrow_mut();
            (mail.poll(&self.mpi)?, mail.is_moving())
        };
        self.live()?;
        idle.rest(moved, is_moving);
        Ok(())
    }
}
