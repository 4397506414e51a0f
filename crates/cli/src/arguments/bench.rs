//! Flags of `eosphor bench`.

use super::camera::CameraFlags;
use super::{DeviceFlags, PictureFlags, SCENE_HELP, SettingsFlags, TextureFlags};
use clap::{Args, Subcommand};
use eosphor::Accel;

#[derive(Debug, Args)]
pub(crate) struct BenchFlags {
    #[command(subcommand)]
    pub(crate) what: Bench,
}

#[derive(Debug, Subcommand)]
pub(crate) enum Bench {
    /// Closest and any hits of camera rays, of one bounce from each, and of the bounces in random order
    ///
    /// Prints the median time of each query and the number of answers that are not the CPU's, bit for bit; exits with 1
    /// where there are any.
    Rays(Box<BenchRaysFlags>),
    /// A picture, once the scene is on the device
    ///
    /// Prints the median time of the whole picture, on GPUs with the way back to the CPU; nothing is written. It is the picture
    /// that render makes of the same scene and flags.
    Render(Box<BenchRenderFlags>),
}

#[derive(Debug, Args)]
pub(crate) struct BenchRenderFlags {
    #[arg(help = SCENE_HELP)]
    pub(crate) scene: String,
    /// How often the picture is rendered
    #[arg(long, value_name = "N", default_value = "20", value_parser = repeats)]
    pub(crate) repeats: usize,
    #[command(flatten)]
    pub(crate) picture: PictureFlags,
    #[command(flatten)]
    pub(crate) settings: SettingsFlags,
    #[command(flatten)]
    pub(crate) textures: TextureFlags,
    #[command(flatten)]
    pub(crate) camera: CameraFlags,
    #[command(flatten)]
    pub(crate) device: DeviceFlags,
    /// Print JSON
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Debug, Args)]
pub(crate) struct BenchRaysFlags {
    #[arg(help = SCENE_HELP)]
    pub(crate) scene: String,
    /// Camera rays
    #[arg(long, value_name = "WxH", default_value = "1920x1080", value_parser = super::values::size)]
    pub(crate) size: [u32; 2],
    /// The hierarchy that rays are traced through; otherwise bvh8 on the CPU. GPUs take a bvh
    #[arg(long, value_name = "NAME", value_parser = super::device::accel())]
    pub(crate) accel: Option<Accel>,
    /// How often each query is timed
    #[arg(long, value_name = "N", default_value = "30", value_parser = repeats)]
    pub(crate) repeats: usize,
    #[command(flatten)]
    pub(crate) textures: TextureFlags,
    #[command(flatten)]
    pub(crate) camera: CameraFlags,
    #[command(flatten)]
    pub(crate) device: DeviceFlags,
    /// Print JSON
    #[arg(long)]
    pub(crate) json: bool,
}

fn repeats(text: &str) -> Result<usize, String> {
    match text.parse() {
        Ok(number @ 1..=10_000) => Ok(number),
        _ => Err("it must be a number from 1 to 10000".into()),
    }
}
