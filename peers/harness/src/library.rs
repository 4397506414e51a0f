//! What is asked of a library.

use crate::{Hit, Options, Ray, Triangle};

/// A ray tracing library with the mesh that it was built for.
///
/// Rays come as they lie in the file, and a library's own form of them is made within the measured time, for all
/// libraries alike.
pub trait Library: Sized + Send + Sync {
    /// The mesh in the form that the library builds from.
    type Mesh: Send;

    /// Puts the mesh into the library's form. Not measured.
    fn prepare(mesh: &[Triangle], options: &Options) -> Result<Self::Mesh, String>;

    /// Everything from there to a structure that is ready for rays.
    fn build(mesh: Self::Mesh, options: &Options) -> Result<Self, String>;

    /// Called on each thread before it traces.
    fn start_thread() {}

    /// The closest hit of each ray of a batch; `coherent` says that neighbours take similar ways. The slices are of one
    /// length.
    fn closest_hits(&self, rays: &[Ray], coherent: bool, hits: &mut [Hit]);

    /// Whether each ray of a batch hits anything.
    fn any_hits(&self, rays: &[Ray], coherent: bool, hits: &mut [bool]);
}
