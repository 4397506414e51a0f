//! Flags of `eosphor bench`.

use super::camera::CameraFlags;
use super::{DeviceFlags, SCENE_HELP};
use clap::{Args, Subcommand};

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
}

#[derive(Debug, Args)]
pub(crate) struct BenchRaysFlags {
    #[arg(help = SCENE_HELP)]
    pub(crate) scene: String,
    /// Camera rays
    #[arg(long, value_name = "WxH", default_value = "1920x1080", value_parser = super::values::size)]
    pub(crate) size: [u32; 2],
    /// How often each query is timed
    #[arg(long, value_name = "N", default_value = "30", value_parser = repeats)]
    pub(crate) repeats: usize,
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
