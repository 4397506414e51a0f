//! Counting what traversals do, or not.

use core::cell::Cell;

/// Told by traversals what they do.
pub trait Work {
    /// Whether it counts. If so, rays go one by one: of nodes that they share, nobody could tell how many a ray takes.
    const COUNTS: bool = true;

    /// This many node boxes are tested.
    fn nodes(&self, count: u32);
    /// This many primitives are tested.
    fn primitives(&self, count: u32);
}

/// Counts nothing and costs nothing.
#[derive(Clone, Copy, Debug, Default)]
pub struct IgnoreWork;

impl Work for IgnoreWork {
    const COUNTS: bool = false;

    #[inline(always)]
    fn nodes(&self, _count: u32) {}
    #[inline(always)]
    fn primitives(&self, _count: u32) {}
}

/// Counts.
#[derive(Clone, Debug, Default)]
pub struct CountWork {
    /// Node boxes tested.
    pub nodes: Cell<u64>,
    /// Primitives tested.
    pub primitives: Cell<u64>,
}

impl Work for CountWork {
    #[inline(always)]
    fn nodes(&self, count: u32) {
        self.nodes.set(self.nodes.get() + count as u64);
    }
    #[inline(always)]
    fn primitives(&self, count: u32) {
        self.primitives.set(self.primitives.get() + count as u64);
    }
}
