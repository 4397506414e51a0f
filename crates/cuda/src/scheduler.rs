//! In which order a device traces the rays of a picture.

use eosphor_core::view::SceneView;

/// In which order a device traces the rays of a picture. No pixel depends on it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum GpuScheduler {
    /// Whichever was faster where scenes of that kind were measured.
    #[default]
    Auto,
    /// One kernel, whose threads follow a sample with all that comes of it: for Whitted's integrator and a bounding volume hierarchy.
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

    /// The one that a scene gets. [`GpuScheduler::Auto`] becomes queues where these are faster; else it stays, for the megakernel where
    /// there is one.
    ///
    /// By measurement (docs/gpu-speed.md), queues pay where rays of one sample part, at glass: threads of a warp then have different
    /// things to do.
    pub(crate) fn of_scene(self, view: &SceneView) -> GpuScheduler {
        let parts = || view.materials.iter().any(|material| material.transmission.max_component() > 0.0);
        if self == GpuScheduler::Auto && parts() { GpuScheduler::Queues } else { self }
    }
}
