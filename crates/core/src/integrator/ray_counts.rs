//! How many rays there were.

use super::RayKind;

/// Rays of a sample by kind.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[repr(C)]
pub struct RayCounts {
    /// From the camera.
    pub camera: u64,
    /// Mirrored.
    pub reflected: u64,
    /// Through surfaces.
    pub refracted: u64,
    /// Of glossy lobes.
    pub glossy: u64,
    /// Towards lights.
    pub shadow: u64,
}

impl RayCounts {
    /// Counts a ray.
    #[inline(always)]
    pub fn count(&mut self, kind: RayKind) {
        match kind {
            RayKind::Camera => self.camera += 1,
            RayKind::Reflected => self.reflected += 1,
            RayKind::Refracted => self.refracted += 1,
            RayKind::Glossy => self.glossy += 1,
        }
    }
}
