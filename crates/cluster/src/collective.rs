//! What all ranks do together. While some are late the others wait without spinning.

use crate::chain::Chain;
use crate::error::ClusterError;
use crate::idle::Idle;
use crate::messages::{Channel, Letter};
use crate::transfer::zeros;
use crate::world::World;
use std::time::{Duration, Instant};

/// So long that a piece costs far more than a message, so short that the last of many ranks begins soon.
const PIECE: usize = 1 << 20;
/// The most bytes that go in one call: MPI counts in 31 bits.
const LONGEST_PIECE: usize = 1 << 30;
/// Bytes between two looks for signs of life in a check sum,
const SUMMED_AT_A_TIME: usize = 64 << 20;
/// and the time between two in a broadcast.
const ATTEND_EVERY: Duration = Duration::from_millis(10);

impl World {
    /// Gives rank 0's bytes to all. What other ranks pass does not matter.
    ///
    /// Nothing is sent until all ranks are there and have the memory; then a check sum tells whether the bytes have come
    /// as they were.
    ///
    /// # Errors
    ///
    /// A rank has not enough memory, or got other bytes: the same error on all ranks. MPI failed.
    pub fn broadcast(&self, bytes: Vec<u8>) -> Result<Vec<u8>, ClusterError> {
        self.broadcast_with(bytes, PIECE, None)
    }

    /// [`World::broadcast`] for tests: in pieces of a given length, with the bytes of one rank damaged before they are
    /// checked.
    #[doc(hidden)]
    pub fn broadcast_with(
        &self,
        bytes: Vec<u8>,
        piece: usize,
        damaged: Option<u32>,
    ) -> Result<Vec<u8>, ClusterError> {
        // What comes: how many bytes, in what pieces, and their check sum.
        let head = if self.rank() == 0 {
            [bytes.len() as u64, piece as u64, self.check_sum(&bytes)?]
        } else {
            [0; 3]
        };
        let head = self.announce(head.into_iter().flat_map(u64::to_le_bytes).collect())?;
        let number = |at: usize| u64::from_le_bytes(head[8 * at..][..8].try_into().unwrap());
        let (length, piece, sum) = (number(0), number(1) as usize, number(2));

        let memory = if self.rank() == 0 { Some(bytes) } else { zeros(length as usize) };
        let lacking = if memory.is_some() { "" } else { "not enough memory" };
        self.consent(lacking).map_err(|reason| broadcast_error(length, reason))?;
        let mut bytes = self.pass_on(memory.unwrap_or_default(), piece)?;

        if let (true, Some(first)) = (damaged == Some(self.rank()), bytes.first_mut()) {
            *first ^= 1;
        }
        let own = if self.rank() == 0 { sum } else { self.check_sum(&bytes)? };
        let differing =
            if own == sum { String::new() } else { format!("check sum {own:08x} instead of {sum:08x}") };
        self.consent(&differing).map_err(|reason| broadcast_error(length, reason))?;
        Ok(bytes)
    }

    /// CRC-32. Of many gigabytes it takes a while.
    fn check_sum(&self, bytes: &[u8]) -> Result<u64, ClusterError> {
        let mut hasher = crc32fast::Hasher::new();
        for part in bytes.chunks(SUMMED_AT_A_TIME) {
            hasher.update(part);
            self.attend()?;
        }
        Ok(hasher.finalize().into())
    }

    /// Rank 0's bytes, at all, who have the memory for them.
    fn pass_on(&self, bytes: Vec<u8>, piece: usize) -> Result<Vec<u8>, ClusterError> {
        let mut chain = Chain::new(bytes, piece.max(1), self.rank(), self.hosts());
        let (mut idle, mut attended) = (Idle::new(), Instant::now());
        while !chain.is_over() {
            let moved = chain.advance(&self.mpi)?;
            if attended.elapsed() > ATTEND_EVERY {
                self.attend()?;
                attended = Instant::now();
            }
            idle.rest(moved, true);
        }
        Ok(chain.into_bytes())
    }

    /// Broadcasts `count` bytes of rank 0 by MPI_Bcast and nothing else, for measurements.
    #[doc(hidden)]
    pub fn bare_broadcast(&self, bytes: Vec<u8>, count: usize) -> Result<Vec<u8>, ClusterError> {
        let mut bytes = if self.rank() == 0 { bytes } else { zeros(count).unwrap_or_default() };
        for piece in bytes.chunks_mut(LONGEST_PIECE) {
            self.mpi.broadcast(piece)?;
        }
        Ok(bytes)
    }

    /// Compares a value of all ranks, such as the version of the program.
    ///
    /// # Errors
    ///
    /// Ranks differ from rank 0: the same error on all ranks, which names those and their values. MPI failed.
    pub fn agree(&self, what: &str, value: &str) -> Result<(), ClusterError> {
        let differences = self.gather(value.as_bytes())?.map(|values| self.differences(&values));
        let differences = self.announce(differences.unwrap_or_default().into_bytes())?;
        if differences.is_empty() {
            return Ok(());
        }
        let differences = String::from_utf8_lossy(&differences).into_owned();
        Err(ClusterError::Disagreement { what: what.into(), differences })
    }

    /// Which ranks say something else than rank 0, and what.
    fn differences(&self, values: &[Vec<u8>]) -> String {
        let mut others: Vec<(&[u8], Vec<usize>)> = Vec::new();
        for (rank, value) in values.iter().enumerate().filter(|(_, value)| **value != values[0]) {
            match others.iter_mut().find(|(known, _)| known == value) {
                Some((_, ranks)) => ranks.push(rank),
                None => others.push((value, vec![rank])),
            }
        }
        let text = |value: &[u8]| String::from_utf8_lossy(value).into_owned();
        let mut parts = Vec::new();
        if !others.is_empty() {
            parts.push(format!("rank 0 on {} says \"{}\"", self.hosts()[0], text(&values[0])));
        }
        parts.extend(others.iter().map(|(value, ranks)| {
            // As many as are of use in a line.
            let named = ranks.iter().take(8).map(|rank| format!("{rank} on {}", self.hosts()[*rank]));
            let named = named.collect::<Vec<_>>().join(", ");
            let more = if ranks.len() > 8 { format!(" and {} more", ranks.len() - 8) } else { String::new() };
            format!("rank {named}{more} \"{}\"", text(value))
        }));
        parts.join(", ")
    }

    /// Every rank's bytes, at rank 0, by rank; `None` elsewhere. For small things.
    ///
    /// # Errors
    ///
    /// MPI failed.
    pub fn gather(&self, bytes: &[u8]) -> Result<Option<Vec<Vec<u8>>>, ClusterError> {
        if self.rank() != 0 {
            let letter = Letter { bytes: bytes.to_vec(), ..Letter::default() };
            self.mail.borrow_mut().send(&self.mpi, Channel::Gather, 0, letter)?;
            return self.flush().map(|()| None);
        }
        let mut all = vec![bytes.to_vec()];
        for rank in 1..self.size() {
            all.push(self.wait_for(Channel::Gather, rank)?.bytes);
        }
        Ok(Some(all))
    }

    /// Rank 0's bytes, at all. For small things.
    pub(crate) fn announce(&self, bytes: Vec<u8>) -> Result<Vec<u8>, ClusterError> {
        if self.rank() != 0 {
            return Ok(self.wait_for(Channel::Announce, 0)?.bytes);
        }
        for rank in 1..self.size() {
            let letter = Letter { bytes: bytes.clone(), ..Letter::default() };
            self.mail.borrow_mut().send(&self.mpi, Channel::Announce, rank, letter)?;
        }
        self.flush()?;
        Ok(bytes)
    }

    /// Goes on only where no rank objects. The error is the objections of all, or that of MPI.
    fn consent(&self, objection: &str) -> Result<(), Consent> {
        let objections = self.gather(objection.as_bytes()).map_err(Consent::Failed)?.map(|objections| {
            let of_rank = |(rank, text): (usize, &Vec<u8>)| {
                let text = String::from_utf8_lossy(text);
                (!text.is_empty()).then(|| format!("rank {rank} on {}: {text}", self.hosts()[rank]))
            };
            objections.iter().enumerate().filter_map(of_rank).collect::<Vec<_>>().join(", ")
        });
        let objections =
            self.announce(objections.unwrap_or_default().into_bytes()).map_err(Consent::Failed)?;
        if objections.is_empty() {
            return Ok(());
        }
        Err(Consent::Objections(String::from_utf8_lossy(&objections).into_owned()))
    }
}

/// Why ranks do not go on.
enum Consent {
    Objections(String),
    Failed(ClusterError),
}

fn broadcast_error(bytes: u64, reason: Consent) -> ClusterError {
    match reason {
        Consent::Objections(reason) => ClusterError::Broadcast { bytes, reason },
        Consent::Failed(error) => error,
    }
}
