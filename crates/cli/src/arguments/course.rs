//! Flags of `eosphor course`.

use super::{BackendChoice, ClusterFlags, DeviceFlags};
use clap::Args;
use eosphor::{Accel, Solid};

#[derive(Debug, Args)]
pub(crate) struct CourseFlags {
    /// Render on the CPU
    #[arg(long, conflicts_with_all = ["gpu", "backend"])]
    pub(crate) cpu: bool,
    /// Render on the GPU; this is usual where there is one
    #[arg(long, conflicts_with = "backend")]
    pub(crate) gpu: bool,
    /// Print a colourful input, which runs as it is, and exit
    #[arg(long)]
    pub(crate) default: bool,
    /// The three bodies: tetrahedron, cube, octahedron, dodecahedron, icosahedron or none
    #[arg(long, value_name = "A,B,C", value_parser = bodies)]
    pub(crate) bodies: Option<Bodies>,
    /// The lights along the edges light the scene themselves, instead of one in the middle of each body
    #[arg(long)]
    pub(crate) edge_lights: bool,
    /// Go on with an animation that was interrupted: frames that are whole and of the same input are kept
    #[arg(long)]
    pub(crate) resume: bool,
    /// The hierarchy over the primitives; changes no pixel
    #[arg(long, value_name = "NAME", value_parser = super::device::accel())]
    pub(crate) accel: Option<Accel>,
    #[command(flatten)]
    pub(crate) device: DeviceFlags,
    #[command(flatten)]
    pub(crate) cluster: ClusterFlags,
}

impl CourseFlags {
    /// Where to render, as the course's flags say it.
    pub(crate) fn device(&self) -> DeviceFlags {
        let mut device = self.device.clone();
        if self.cpu {
            device.backend = Some(BackendChoice::Cpu);
        } else if self.gpu {
            device.backend = Some(BackendChoice::Cuda(Vec::new()));
        }
        device
    }
}

/// Three solids, or fewer. (A type of its own, as clap takes lists to mean other things.)
#[derive(Clone, Copy, Debug)]
pub(crate) struct Bodies(pub(crate) [Option<Solid>; 3]);

fn bodies(text: &str) -> Result<Bodies, String> {
    let solid = |name: &str| match name.trim() {
        "none" => Ok(None),
        name => name.parse::<Solid>().map(Some).map_err(|error| format!("{error}, or none")),
    };
    let solids: Vec<Option<Solid>> = text.split(',').map(solid).collect::<Result<_, _>>()?;
    let three = <[Option<Solid>; 3]>::try_from(solids);
    three.map(Bodies).map_err(|_| "there are three bodies, as in tetrahedron,octahedron,dodecahedron".into())
}
