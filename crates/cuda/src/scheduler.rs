//! In which order a device traces the rays of a picture.

/// In which order a device traces the rays of a picture. No pixel depends on it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum GpuScheduler {
    /// Whichever was faster where it was measured (docs/gpu-speed.md): queues.
    #[default]
    Auto,
    /// One kernel, whose threads follow a sample with all that comes of it: for Whitted's integrator and a bounding volume
    /// hierarchy.
    Megakernel,
    /// Kernels for each stage, which work on queues of rays.
    Queues,
}

impl GpuScheduler {
    /// All there are.
    pub const ALL: [GpuScheduler; 3] = [GpuScheduler::Auto, GpuScheduler::Megakernel, GpuScheduler::Queues];

    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            GpuScheduler::Auto => "auto",
            GpuScheduler::Megakernel => "megakernel",
            GpuScheduler::Queues => "queues",
        }
    }
}
