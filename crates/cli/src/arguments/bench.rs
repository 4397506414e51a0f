//! Flags of `eosphor bench`.

use super::camera::CameraFlags;
use super::values::{whole, within};
use super::{BackendChoice, DeviceFlags, Need, PictureFlags, SettingsFlags, TextureFlags, check, scene_help};
use crate::failure::Failure;
use clap::{Args, Subcommand};
use eosphor::{Accel, GpuScheduler, Traversal};
use std::ops::RangeInclusive;
use std::path::PathBuf;

/// How often something may be measured.
const REPEATS: RangeInclusive<u32> = 1..=10_000;

#[derive(Debug, Args)]
pub(crate) struct BenchFlags {
    #[command(subcommand)]
    pub(crate) what: Bench,
}

#[derive(Debug, Subcommand)]
pub(crate) enum Bench {
    /// Time closest-hit and any-hit queries, on the CPU unless --backend names GPUs
    ///
    /// The rays are camera rays, one bounce from each hit, and these bounces in random order. Prints the median time of each
    /// query and the number of answers that differ from the CPU's in any bit; exits with 1 if there are any.
    #[command(after_help = super::examples::BENCH_RAYS)]
    Rays(Box<BenchRaysFlags>),
    /// Time a whole picture, from a scene that is already on the device
    ///
    /// Prints the median time of rendering, on GPUs including the transfer back to the CPU. Writes nothing. The picture is the
    /// one that render makes of the same scene with the same flags.
    #[command(after_help = super::examples::BENCH_RENDER)]
    Render(Box<BenchRenderFlags>),
    /// Measure the noise of a picture
    ///
    /// Renders two pictures with seeds of their own, N times, and prints the root mean square of their difference over the root of
    /// two: the standard deviation of a channel of a pixel, in units of radiance.
    #[command(after_help = super::examples::BENCH_NOISE)]
    Noise(Box<BenchNoiseFlags>),
}

#[derive(Debug, Args)]
pub(crate) struct BenchNoiseFlags {
    #[arg(help = scene_help())]
    pub(crate) scene: PathBuf,
    /// How often the noise is measured, with other seeds each time, 1 to 10000
    #[arg(long, value_name = "N", default_value = "3", value_parser = whole::<usize>(REPEATS), allow_hyphen_values = true)]
    pub(crate) repeats: usize,
    /// Give each sample a seed of its own, as plain Monte Carlo has it; Eosphor spreads the samples of a pixel evenly
    #[arg(long)]
    pub(crate) independent: bool,
    /// Print a line for eosphor lab
    #[arg(long)]
    pub(crate) lines: bool,
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
}

#[derive(Debug, Args)]
pub(crate) struct BenchRenderFlags {
    #[arg(help = scene_help())]
    pub(crate) scene: PathBuf,
    /// How often the picture is rendered, 1 to 10000
    #[arg(long, value_name = "N", default_value = "20", value_parser = whole::<usize>(REPEATS), allow_hyphen_values = true)]
    pub(crate) repeats: usize,
    /// Repetitions before those that count, 0 to 100
    #[arg(long, value_name = "N", default_value = "1", value_parser = whole::<usize>(0..=100), allow_hyphen_values = true)]
    pub(crate) warm_up: usize,
    /// Time until the picture is bytes, as frames of videos are: developed by the GPU, or by the CPU after it has rendered
    #[arg(long)]
    pub(crate) developed: bool,
    /// Also time each stage of the picture on GPUs, once: its kernels, their launches, rays and bytes
    #[arg(long, conflicts_with_all = ["lines", "developed"])]
    pub(crate) phases: bool,
    /// Print the results as JSON
    #[arg(long)]
    pub(crate) json: bool,
    /// Print each time, and a hash of the picture, for eosphor lab
    #[arg(long, conflicts_with = "json")]
    pub(crate) lines: bool,
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
}

#[derive(Debug, Args)]
pub(crate) struct BenchRaysFlags {
    #[arg(help = scene_help())]
    pub(crate) scene: PathBuf,
    /// Number of camera rays, in width and height, each side 1 to 65535
    #[arg(long, value_name = "WxH", default_value = "1920x1080", value_parser = super::values::size, allow_hyphen_values = true)]
    pub(crate) size: [u32; 2],
    /// The hierarchy that rays are traced through [default: bvh8 on the CPU, bvh on GPUs, where this is the only choice]
    #[arg(long, value_name = "NAME", value_parser = super::device::accel())]
    pub(crate) accel: Option<Accel>,
    /// How often each query is timed, 1 to 10000
    #[arg(long, value_name = "N", default_value = "30", value_parser = whole::<usize>(REPEATS), allow_hyphen_values = true)]
    pub(crate) repeats: usize,
    /// Repetitions before those that count, 0 to 100
    #[arg(long, value_name = "N", default_value = "1", value_parser = whole::<usize>(0..=100), allow_hyphen_values = true)]
    pub(crate) warm_up: usize,
    /// Print the results as JSON
    #[arg(long)]
    pub(crate) json: bool,
    /// Rays of each call, 1 to 100000000 [default: all]
    #[arg(long, value_name = "N", value_parser = whole::<usize>(1..=100_000_000), allow_hyphen_values = true)]
    pub(crate) batch: Option<usize>,
    /// Move the origins of the camera rays back by so many diagonals of the scene, 0 to 1e9
    #[arg(long, value_name = "X", value_parser = within(0.0..=1e9), allow_hyphen_values = true)]
    pub(crate) distance: Option<f32>,
    /// Write triangles, rays and hits into this folder, for programs that measure other libraries
    #[arg(long, value_name = "FOLDER")]
    pub(crate) export: Option<PathBuf>,
    /// Print each time, and a hash of the answers, for eosphor lab
    #[arg(long, conflicts_with = "json")]
    pub(crate) lines: bool,
    #[command(flatten)]
    pub(crate) textures: TextureFlags,
    #[command(flatten)]
    pub(crate) camera: CameraFlags,
    #[command(flatten)]
    pub(crate) device: DeviceFlags,
}

impl BenchRenderFlags {
    /// Fails where a flag would do nothing.
    pub(crate) fn check(&self) -> Result<(), Failure> {
        let is_cuda = matches!(self.device.backend(), BackendChoice::Cuda(_));
        let is_in_stages = self.device.gpu_scheduler != GpuScheduler::Megakernel;
        let need = |is_met, needs| Need { flag: "--phases", is_given: self.phases, is_met, needs };
        check(&[need(is_cuda, "--backend cuda"), need(is_in_stages, "--gpu-scheduler queues or auto")])
    }
}

impl BenchRaysFlags {
    /// Fails where one of the flags about devices would do nothing.
    pub(crate) fn check(&self) -> Result<(), Failure> {
        let DeviceFlags {
            tile,
            scheduler,
            block_size,
            gpu_paths,
            gpu_memory,
            gpu_scheduler,
            gpu_traversal,
            ..
        } = self.device;
        let is_cuda = matches!(self.device.backend(), BackendChoice::Cuda(_));
        let need = |flag, is_given, is_met, needs| Need { flag, is_given, is_met, needs };
        let picture = "a picture to be rendered (bench render)";
        check(&[
            need("--tile", tile.is_some(), false, picture),
            need("--scheduler", scheduler.is_some(), false, picture),
            need("--block-size", block_size.is_some(), false, picture),
            need("--gpu-paths", gpu_paths.is_some(), false, picture),
            need("--gpu-memory", gpu_memory.is_some(), false, picture),
            need("--gpu-scheduler", gpu_scheduler != GpuScheduler::default(), false, picture),
            need("--warm-up", self.warm_up != 1, !is_cuda, "--backend cpu"),
            need("--batch", self.batch.is_some(), !is_cuda, "--backend cpu"),
            need("--gpu-traversal", gpu_traversal != Traversal::default(), is_cuda, "--backend cuda"),
        ])
    }
}
