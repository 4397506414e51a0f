//! Flags of `eosphor course`.

use super::{BackendChoice, ClusterFlags, DeviceFlags, Need, TextureFlags, check};
use crate::failure::Failure;
use clap::Args;
use eosphor::{Accel, Solid};
use std::path::PathBuf;

#[derive(Debug, Args)]
pub(crate) struct CourseFlags {
    /// Render on the CPU
    #[arg(long, conflicts_with_all = ["gpu", "backend"])]
    pub(crate) cpu: bool,
    /// Render on the GPU, the default where there is one
    #[arg(long, conflicts_with = "backend")]
    pub(crate) gpu: bool,
    /// Print a colourful input that runs as it is, and exit; no other flag may be given with it
    #[arg(long, exclusive = true)]
    pub(crate) default: bool,
    /// The three bodies: tetrahedron, cube, octahedron, dodecahedron, icosahedron or none [default:
    /// tetrahedron,octahedron,dodecahedron]
    #[arg(long, value_name = "A,B,C", value_parser = bodies)]
    pub(crate) bodies: Option<Bodies>,
    /// Let the lights along the edges light the scene themselves; without this flag one light in the middle of each body stands
    /// for them
    #[arg(long)]
    pub(crate) edge_lights: bool,
    /// The output: numbered frames such as img_%d.png, or one .mp4. Missing folders are created [default: the path in the
    /// input]
    #[arg(short, long, value_name = "FILE")]
    pub(crate) output: Option<PathBuf>,
    /// Frames per second of an .mp4, over 0 and at most 240 [default: 24]
    #[arg(long, value_name = "X", value_parser = super::frames::video_rate(), allow_hyphen_values = true)]
    pub(crate) fps: Option<f32>,
    /// Quality of an .mp4, 1 to 100; losses are hard to see at 90 [default: 90]
    #[cfg(feature = "video")]
    #[arg(long, value_name = "N", value_parser = super::values::whole::<u8>(1..=100), allow_hyphen_values = true)]
    pub(crate) video_quality: Option<u8>,
    /// Encode an .mp4 with the program ffmpeg, which must be installed
    #[cfg(feature = "video")]
    #[arg(long, conflicts_with = "resume")]
    pub(crate) ffmpeg: bool,
    /// Continue an animation that was interrupted: keep the frames that are whole and belong to the same input
    #[arg(long)]
    pub(crate) resume: bool,
    /// The hierarchy (acceleration structure) that rays are traced through; changes no pixel [default: bvh8 on the CPU, bvh on
    /// GPUs]
    #[arg(long, value_name = "NAME", value_parser = super::device::accel())]
    pub(crate) accel: Option<Accel>,
    #[command(flatten)]
    pub(crate) textures: TextureFlags,
    #[command(flatten)]
    pub(crate) device: DeviceFlags,
    #[command(flatten)]
    pub(crate) cluster: ClusterFlags,
}

impl CourseFlags {
    /// Fails where one of these would do nothing.
    pub(crate) fn check(&self, is_video: bool) -> Result<(), Failure> {
        let need = |flag, is_given| Need { flag, is_given, is_met: is_video, needs: "an .mp4 (--output)" };
        check(&[
            need("--fps", self.fps.is_some()),
            #[cfg(feature = "video")]
            need("--video-quality", self.video_quality.is_some()),
            #[cfg(feature = "video")]
            need("--ffmpeg", self.ffmpeg),
        ])
    }

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
