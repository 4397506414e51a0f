//! Bytes of rank 0 for all: each rank passes pieces on to the next while more come in, so that each sends all bytes once and
//! receives them once, whatever the number of ranks. Ranks of a host follow each other: a host gets the bytes once.
//!
//! MPI_Bcast would wait for ever for a rank that is stopped, and MPI_Ibcast takes 2.5 times as long in Open MPI.

use crate::error::ClusterError;
use crate::mpi::{Handle, Mpi};
use std::collections::VecDeque;
use std::ffi::c_int;

const TAG: c_int = 7003;
/// Pieces that are under way at a time from one rank to the next.
const PIECES_AT_A_TIME: usize = 3;

/// Bytes on their way from the rank before this one to the rank behind it. It owns them until all have come and gone.
pub(crate) struct Chain {
    bytes: Vec<u8>,
    piece: usize,
    from: Option<u32>,
    to: Option<u32>,
    /// Bytes of all pieces that were asked for, that have come, and that were passed on.
    asked_for: usize,
    arrived: usize,
    passed_on: usize,
    coming: VecDeque<Handle>,
    going: VecDeque<Handle>,
}

impl Chain {
    /// In pieces of so many bytes.
    pub(crate) fn new(bytes: Vec<u8>, piece: usize, rank: u32, hosts: &[String]) -> Chain {
        let (from, to) = neighbours(rank, hosts);
        let arrived = if from.is_some() { 0 } else { bytes.len() };
        let (coming, going) = (VecDeque::new(), VecDeque::new());
        Chain { bytes, piece, from, to, asked_for: 0, arrived, passed_on: 0, coming, going }
    }

    /// Begins pieces, and ends those that have come or gone: whether there were any.
    pub(crate) fn advance(&mut self, mpi: &Mpi) -> Result<bool, ClusterError> {
        let mut moved = false;
        if let Some(from) = self.from {
            while self.coming.len() < PIECES_AT_A_TIME && self.asked_for < self.bytes.len() {
                let count = self.piece.min(self.bytes.len() - self.asked_for);
                let to = &mut self.bytes[self.asked_for..][..count];
                // SAFETY: the bytes stay where they are, and nobody looks at them, until the request is complete.
                self.coming.push_back(unsafe { mpi.begin_receiving(to, from, TAG) }?);
                self.asked_for += count;
            }
            while let Some(first) = self.coming.front_mut() {
                if !mpi.is_done(first)? {
                    break;
                }
                self.coming.pop_front();
                self.arrived = self.bytes.len().min(self.arrived + self.piece);
                moved = true;
            }
        }
        if let Some(to) = self.to {
            while self.going.len() < PIECES_AT_A_TIME && self.passed_on < self.arrived {
                let count = self.piece.min(self.arrived - self.passed_on);
                let from = &self.bytes[self.passed_on..][..count];
                // SAFETY: the bytes stay where they are, and nobody changes them, until the request is complete.
                self.going.push_back(unsafe { mpi.begin_sending(from, to, TAG) }?);
                self.passed_on += count;
            }
            while let Some(first) = self.going.front_mut() {
                if !mpi.is_done(first)? {
                    break;
                }
                self.going.pop_front();
                moved = true;
            }
        }
        Ok(moved)
    }

    /// Whether all bytes have come and gone.
    pub(crate) fn is_over(&self) -> bool {
        let is_passed_on = self.to.is_none() || self.passed_on == self.bytes.len();
        self.arrived == self.bytes.len() && is_passed_on && self.going.is_empty()
    }

    /// The bytes of a chain that is over.
    pub(crate) fn into_bytes(mut self) -> Vec<u8> {
        assert!(self.is_over(), "the library may still read or write these bytes");
        std::mem::take(&mut self.bytes)
    }
}

impl Drop for Chain {
    fn drop(&mut self) {
        if !self.coming.is_empty() || !self.going.is_empty() {
            // The library may still read or write them.
            std::mem::forget(std::mem::take(&mut self.bytes));
        }
    }
}

/// The ranks before and behind this one, where ranks go host by host, in the order in which hosts first come.
fn neighbours(rank: u32, hosts: &[String]) -> (Option<u32>, Option<u32>) {
    let first = |rank: u32| hosts.iter().position(|host| *host == hosts[rank as usize]);
    let mut order: Vec<u32> = (0..hosts.len() as u32).collect();
    order.sort_by_cached_key(|&rank| first(rank));
    let at = order.iter().position(|&other| other == rank).unwrap_or(0);
    (at.checked_sub(1).map(|before| order[before]), order.get(at + 1).copied())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranks_of_a_host_follow_each_other() {
        let hosts = ["b", "a", "b", "c", "a"].map(str::to_string);
        let neighbours = [0, 1, 2, 3, 4].map(|rank| neighbours(rank, &hosts));
        // 0, 2, 1, 4, 3
        let (from, to) = ([None, Some(2), Some(0), Some(4), Some(1)], [2, 4, 1, 5, 3]);
        for rank in 0..5 {
            assert_eq!(neighbours[rank], (from[rank], Some(to[rank]).filter(|&to| to < 5)));
        }
    }

    #[test]
    fn one_rank_alone_has_nothing_to_do() {
        let chain = Chain::new(vec![1, 2, 3], 2, 0, &["here".to_string()]);
        assert!(chain.is_over());
        assert_eq!(chain.into_bytes(), [1, 2, 3]);
    }
}
