//! Bytes on their way, in pieces, while the program goes on.

use crate::error::ClusterError;
use crate::mpi::{Handle, Mpi};
use std::alloc::Layout;
use std::collections::VecDeque;
use std::ffi::c_int;

/// Pieces of a transfer that are under way at a time: while one is copied the next is there already.
const PIECES_AT_A_TIME: usize = 2;

/// Which way bytes go.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Way {
    To,
    From,
}

/// Bytes that go to a rank or come from it. It owns them until the last piece has arrived.
pub(crate) struct Transfer {
    bytes: Vec<u8>,
    way: Way,
    rank: u32,
    tag: c_int,
    /// How long pieces are; the last may be shorter.
    piece: usize,
    /// Bytes of all pieces that were begun.
    begun: usize,
    under_way: VecDeque<Handle>,
}

impl Transfer {
    /// Bytes for a rank.
    pub(crate) fn to(rank: u32, tag: c_int, bytes: Vec<u8>, piece: usize) -> Transfer {
        Transfer { bytes, way: Way::To, rank, tag, piece, begun: 0, under_way: VecDeque::new() }
    }

    /// Bytes from a rank, into these.
    pub(crate) fn from(rank: u32, tag: c_int, bytes: Vec<u8>, piece: usize) -> Transfer {
        Transfer { bytes, way: Way::From, rank, tag, piece, begun: 0, under_way: VecDeque::new() }
    }

    /// Bytes that are there already.
    pub(crate) fn ended(bytes: Vec<u8>) -> Transfer {
        let begun = bytes.len();
        Transfer { bytes, way: Way::From, rank: 0, tag: 0, piece: 1, begun, under_way: VecDeque::new() }
    }

    /// Begins pieces and ends those that have arrived: whether any has, and whether all have.
    pub(crate) fn advance(&mut self, mpi: &Mpi) -> Result<(bool, bool), ClusterError> {
        let mut moved = false;
        loop {
            while self.under_way.len() < PIECES_AT_A_TIME && self.begun < self.bytes.len() {
                self.begin(mpi)?;
            }
            let Some(request) = self.under_way.front_mut() else { return Ok((moved, true)) };
            if !mpi.is_done(request)? {
                return Ok((moved, false));
            }
            self.under_way.pop_front();
            moved = true;
        }
    }

    fn begin(&mut self, mpi: &Mpi) -> Result<(), ClusterError> {
        let count = self.piece.min(self.bytes.len() - self.begun);
        let piece = &mut self.bytes[self.begun..][..count];
        // SAFETY: the bytes are in a vector whose memory stays where it is, and which this transfer keeps unchanged
        // until the request is complete: it gives them away only then, and forgets them when it is dropped before.
        let request = unsafe {
            match self.way {
                Way::To => mpi.begin_sending(piece, self.rank, self.tag),
                Way::From => mpi.begin_receiving(piece, self.rank, self.tag),
            }
        }?;
        self.begun += piece.len();
        self.under_way.push_back(request);
        Ok(())
    }

    /// The bytes of a transfer that has ended.
    pub(crate) fn into_bytes(mut self) -> Vec<u8> {
        assert!(self.under_way.is_empty(), "the library may still write these bytes");
        std::mem::take(&mut self.bytes)
    }
}

impl Drop for Transfer {
    fn drop(&mut self) {
        if !self.under_way.is_empty() {
            // The library may still read or write them.
            std::mem::forget(std::mem::take(&mut self.bytes));
        }
    }
}

/// Memory for as many bytes, of zeros that cost nothing until they are touched; `None` where there is not enough.
pub(crate) fn zeros(count: usize) -> Option<Vec<u8>> {
    if count == 0 {
        return Some(Vec::new());
    }
    let layout = Layout::array::<u8>(count).ok()?;
    // SAFETY: `layout` is not of size zero, the condition of `alloc_zeroed`.
    let memory = unsafe { std::alloc::alloc_zeroed(layout) };
    if memory.is_null() {
        return None;
    }
    // SAFETY: the global allocator has just given this memory, of this size and of bytes that are all set.
    Some(unsafe { Vec::from_raw_parts(memory, count, count) })
}
