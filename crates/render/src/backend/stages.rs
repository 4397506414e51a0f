//! What the stages of a picture take, on devices that make it in stages.

use std::ops::AddAssign;

/// What one stage took: all launches of a kernel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StageWork {
    /// The kernel's name.
    pub kernel: &'static str,
    /// How often it was launched.
    pub launches: u64,
    /// By the device's clock.
    pub milliseconds: f64,
    /// What it did, one by one: rays, points, pixels.
    pub items: u64,
    /// Threads of the warps that had an item. With fewer items than these, some idled.
    pub lanes: u64,
    /// Of queues and sums, read and written, at most; what the scene takes is not counted.
    pub bytes: u64,
}

impl AddAssign for StageWork {
    /// Of the same kernel.
    fn add_assign(&mut self, more: StageWork) {
        self.launches += more.launches;
        self.milliseconds += more.milliseconds;
        self.items += more.items;
        self.lanes += more.lanes;
        self.bytes += more.bytes;
    }
}
