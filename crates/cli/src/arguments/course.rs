//! Flags of `eosphor course`.

use super::DeviceFlags;
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
    /// The three bodies: tetrahedron, cube, octahedron, dodecahedron or icosahedron
    #[arg(long, value_name = "A,B,C", value_parser = bodies)]
    pub(crate) bodies: Option<Bodies>,
    /// The lights along the edges light the scene themselves, instead of one in the middle of each body
    #[arg(long)]
    pub(crate) edge_lights: bool,
    /// The hierarchy over the primitives; changes no pixel
    #[arg(long, value_name = "NAME", value_parser = super::device::accel())]
    pub(crate) accel: Option<Accel>,
    #[command(flatten)]
    pub(crate) device: DeviceFlags,
}

/// Three solids. (A type of its own, as clap takes lists to mean other things.)
#[derive(Clone, Copy, Debug)]
pub(crate) struct Bodies(pub(crate) [Solid; 3]);

fn bodies(text: &str) -> Result<Bodies, String> {
    let names = text.split(',').map(|name| name.trim().parse::<Solid>());
    let solids: Vec<Solid> = names.collect::<Result<_, _>>().map_err(|error| error.to_string())?;
    let three = <[Solid; 3]>::try_from(solids);
    three.map(Bodies).map_err(|_| "there are three bodies, as in tetrahedron,octahedron,dodecahedron".into())
}
