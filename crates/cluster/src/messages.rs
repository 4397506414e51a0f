//! Messages between ranks, of any length, sent and received while the program goes on.
//!
//! A message is a head, which has its bytes with it where they are few, and else is followed by them in pieces. Heads
//! overtake pieces. Within a job, and as signs of life, short messages do so too, so that a sign of life does not wait for a
//! large picture; else messages from one rank to another stay in order.

use crate::error::ClusterError;
use crate::mpi::Mpi;
use crate::transfer::{Transfer, zeros};
use std::collections::{BTreeMap, BTreeSet, VecDeque};
use std::ffi::c_int;

const TAG_HEAD: c_int = 7001;
const TAG_PIECE: c_int = 7002;
/// The most bytes that go with the head: every library sends so few at once, whether they are awaited or not.
const MAX_EAGER_BYTES: usize = 1024;
const HEAD_LENGTH: usize = 40;

/// What a message belongs to, so that a rank that is ahead does not confuse those that are behind.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
#[repr(u8)]
pub(crate) enum Channel {
    /// To rank 0, one from each.
    Gather = 1,
    /// From rank 0, one to each.
    Announce = 2,
    /// Within a job.
    Job = 3,
    /// Signs of life.
    Life = 4,
}

impl Channel {
    /// Whether messages arrive in the order in which they were sent, also short ones after long ones.
    fn is_ordered(self) -> bool {
        matches!(self, Channel::Gather | Channel::Announce)
    }
}

/// A message.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Letter {
    /// What it says; numbers mean something to the channel alone.
    pub(crate) kind: u8,
    /// A unit or a count.
    pub(crate) number: u64,
    /// A time.
    pub(crate) seconds: f64,
    pub(crate) bytes: Vec<u8>,
}

/// What is on its way, and what has come.
pub(crate) struct Mail {
    /// How long pieces of messages to others are.
    pub(crate) piece: usize,
    heads: Vec<Transfer>,
    /// By rank, in order; the first is on its way.
    to: BTreeMap<u32, VecDeque<Transfer>>,
    from: BTreeMap<u32, VecDeque<(Channel, Letter, Transfer)>>,
    arrived: BTreeMap<(Channel, u32), VecDeque<Letter>>,
    /// Ranks that anything has come from since they were last taken.
    heard: BTreeSet<u32>,
    /// Bytes of messages that were sent or have come.
    pub(crate) bytes_moved: u64,
}

impl Mail {
    pub(crate) fn new(piece: usize) -> Mail {
        Mail {
            piece,
            heads: Vec::new(),
            to: BTreeMap::new(),
            from: BTreeMap::new(),
            arrived: BTreeMap::new(),
            heard: BTreeSet::new(),
            bytes_moved: 0,
        }
    }

    /// Sends a message, as far as it goes at once; `poll` sends the rest.
    pub(crate) fn send(
        &mut self,
        mpi: &Mpi,
        channel: Channel,
        rank: u32,
        mut letter: Letter,
    ) -> Result<(), ClusterError> {
        let bytes = std::mem::take(&mut letter.bytes);
        let mut head = encode(channel, &letter, bytes.len(), self.piece);
        self.bytes_moved += (head.len() + bytes.len()) as u64;
        let is_whole = bytes.len() <= MAX_EAGER_BYTES;
        if is_whole {
            head.extend_from_slice(&bytes);
        }
        let length = head.len();
        let mut head = Transfer::to(rank, TAG_HEAD, head, length);
        if !head.advance(mpi)?.1 {
            self.heads.push(head);
        }
        if !is_whole {
            let pieces = Transfer::to(rank, TAG_PIECE, bytes, self.piece);
            self.to.entry(rank).or_default().push_back(pieces);
        }
        Ok(())
    }

    /// Moves what can be moved: whether anything could.
    pub(crate) fn poll(&mut self, mpi: &Mpi) -> Result<bool, ClusterError> {
        let mut moved = false;
        while let Some((rank, count)) = mpi.probe(TAG_HEAD)? {
            moved = true;
            self.heard.insert(rank);
            let (channel, mut letter, length, piece) = decode(&mpi.receive(rank, TAG_HEAD, count)?);
            self.bytes_moved += (HEAD_LENGTH + length) as u64;
            let is_long = length > MAX_EAGER_BYTES;
            let pieces = if is_long {
                let room = zeros(length).ok_or_else(|| ClusterError::Misuse {
                    rank: mpi.rank,
                    reason: format!(
                        "not enough memory for {length} bytes from rank {rank}: use smaller units"
                    ),
                })?;
                Transfer::from(rank, TAG_PIECE, room, piece)
            } else {
                Transfer::ended(std::mem::take(&mut letter.bytes))
            };
            let before = self.from.get(&rank).into_iter().flatten();
            if is_long || channel.is_ordered() && before.into_iter().any(|(other, ..)| *other == channel) {
                self.from.entry(rank).or_default().push_back((channel, letter, pieces));
            } else {
                letter.bytes = pieces.into_bytes();
                self.arrived.entry((channel, rank)).or_default().push_back(letter);
            }
        }
        let mut at = 0;
        while at < self.heads.len() {
            if self.heads[at].advance(mpi)?.1 {
                self.heads.swap_remove(at);
                moved = true;
            } else {
                at += 1;
            }
        }
        for transfers in self.to.values_mut() {
            while let Some(first) = transfers.front_mut() {
                let (some, all) = first.advance(mpi)?;
                moved |= some;
                if !all {
                    break;
                }
                transfers.pop_front();
            }
        }
        self.to.retain(|_, transfers| !transfers.is_empty());
        for (rank, transfers) in &mut self.from {
            while let Some((_, _, first)) = transfers.front_mut() {
                let (some, all) = first.advance(mpi)?;
                if some {
                    moved = true;
                    self.heard.insert(*rank);
                }
                if !all {
                    break;
                }
                if let Some((channel, mut letter, bytes)) = transfers.pop_front() {
                    letter.bytes = bytes.into_bytes();
                    self.arrived.entry((channel, *rank)).or_default().push_back(letter);
                }
            }
        }
        self.from.retain(|_, transfers| !transfers.is_empty());
        Ok(moved)
    }

    /// The next message from a rank.
    pub(crate) fn take(&mut self, channel: Channel, rank: u32) -> Option<Letter> {
        let letters = self.arrived.get_mut(&(channel, rank))?;
        let letter = letters.pop_front();
        if letters.is_empty() {
            self.arrived.remove(&(channel, rank));
        }
        letter
    }

    /// Ranks that anything has come from since this was last asked.
    pub(crate) fn take_heard(&mut self) -> BTreeSet<u32> {
        std::mem::take(&mut self.heard)
    }

    /// The next message from any rank, with the rank.
    pub(crate) fn take_any(&mut self, channel: Channel) -> Option<(u32, Letter)> {
        let (&(_, rank), _) = self.arrived.range((channel, 0)..=(channel, u32::MAX)).next()?;
        self.take(channel, rank).map(|letter| (rank, letter))
    }

    /// Whether long messages are on their way.
    pub(crate) fn is_moving(&self) -> bool {
        !self.to.is_empty() || !self.from.is_empty()
    }

    /// Whether all that was sent has gone.
    pub(crate) fn is_sent(&self) -> bool {
        self.heads.is_empty() && self.to.is_empty()
    }
}

fn encode(channel: Channel, letter: &Letter, length: usize, piece: usize) -> Vec<u8> {
    let mut head = vec![channel as u8, letter.kind, 0, 0, 0, 0, 0, 0];
    head.extend_from_slice(&letter.number.to_le_bytes());
    head.extend_from_slice(&letter.seconds.to_le_bytes());
    head.extend_from_slice(&(length as u64).to_le_bytes());
    head.extend_from_slice(&(piece as u64).to_le_bytes());
    head
}

/// Whose message it is, the message with the bytes that came with its head, how many it has, and how long pieces are.
fn decode(head: &[u8]) -> (Channel, Letter, usize, usize) {
    let number = |at: usize| u64::from_le_bytes(head[at..at + 8].try_into().unwrap());
    let channel = [Channel::Gather, Channel::Announce, Channel::Job, Channel::Life][usize::from(head[0]) - 1];
    let bytes = head[HEAD_LENGTH..].to_vec();
    let letter = Letter { kind: head[1], number: number(8), seconds: f64::from_bits(number(16)), bytes };
    (channel, letter, number(24) as usize, number(32) as usize)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn heads_come_back_as_they_were() {
        let letter = Letter { kind: 9, number: u64::MAX - 1, seconds: 0.25, bytes: Vec::new() };
        let mut head = encode(Channel::Job, &letter, 5_000_000_000, 8 << 20);
        assert_eq!(head.len(), HEAD_LENGTH);
        head.extend_from_slice(&[1, 2]);
        let whole = Letter { bytes: vec![1, 2], ..letter };
        assert_eq!(decode(&head), (Channel::Job, whole, 5_000_000_000, 8 << 20));
    }
}
