//! What can be said on the command line.

mod bench;
mod camera;
mod cluster;
mod course;
mod device;
mod examples;
mod frames;
mod keep;
mod lab;
mod lights;
mod needs;
mod render;
mod settings;
mod sky;
#[cfg(test)]
mod tests;
mod textures;
mod values;
#[cfg(feature = "view")]
mod view;

pub(crate) use bench::{Bench, BenchFlags, BenchNoiseFlags, BenchRaysFlags, BenchRenderFlags};
pub(crate) use camera::CameraFlags;
pub(crate) use cluster::ClusterFlags;
pub(crate) use course::CourseFlags;
pub(crate) use device::{AccelChoice, BackendChoice, DeviceFlags};
pub(crate) use frames::{FrameFlags, OutputKind};
pub(crate) use keep::KeepFlags;
pub(crate) use lab::{Lab, LabCompareFlags, LabFlags, LabReportFlags, LabRunFlags};
pub(crate) use lights::LightFlags;
pub(crate) use needs::{Need, check, would_do_nothing};
pub(crate) use render::{FileFlags, PictureFlags, RenderFlags, ReportFlags, SampleRange, Share, Show};
pub(crate) use settings::SettingsFlags;
pub(crate) use textures::TextureFlags;
#[cfg(feature = "view")]
pub(crate) use view::ViewFlags;

use crate::failure::Failure;
use clap::parser::ValueSource;
use clap::{ArgMatches, Args, CommandFactory, FromArgMatches, Parser, Subcommand};
use eosphor::{Accel, BUILTINS, GpuScheduler, Traversal};
use std::path::PathBuf;

/// A ray tracer that gives the same picture on every device, bit for bit
// A flag that is given twice counts the second time, so that scripts can add to a common line; but each -o is a file more.
#[derive(Debug, Parser)]
#[command(name = "eosphor", version, max_term_width = 110, args_override_self = true, after_help = examples::PROGRAM)]
pub(crate) struct Arguments {
    #[command(subcommand)]
    pub(crate) command: Command,
}

/// Flags about devices that only commands which render take; others refuse them with a reason, and do not list them.
const FLAGS_OF_PICTURES: [&str; 6] =
    ["tile", "scheduler", "block_size", "gpu_paths", "gpu_memory", "gpu_scheduler"];

impl Arguments {
    /// All commands with their flags, as help and completions list them.
    pub(crate) fn described() -> clap::Command {
        let hidden = |command: clap::Command, flags: &[&str]| {
            let hide = |command: clap::Command, flag: &&str| command.mut_arg(*flag, |arg| arg.hide(true));
            flags.iter().fold(command, hide)
        };
        Arguments::command()
            .mut_subcommand("info", |info| hidden(hidden(info, &FLAGS_OF_PICTURES), &["gpu_traversal"]))
            .mut_subcommand("bench", |bench| {
                bench.mut_subcommand("rays", |rays| hidden(rays, &FLAGS_OF_PICTURES))
            })
    }

    /// Those of this process.
    pub(crate) fn read() -> Result<Arguments, clap::Error> {
        let mut command = Arguments::described();
        let matches = command.try_get_matches_from_mut(std::env::args_os())?;
        let mut arguments =
            Arguments::from_arg_matches(&matches).map_err(|error| error.format(&mut command))?;
        if let (Command::Render(flags), Some((_, matches))) = (&mut arguments.command, matches.subcommand()) {
            flags.given = given(&command, matches);
        }
        Ok(arguments)
    }
}

/// Long names of the flags of `render` that the command line has.
fn given(command: &clap::Command, matches: &ArgMatches) -> Vec<String> {
    let render = command.find_subcommand("render");
    let flags = render.into_iter().flat_map(clap::Command::get_arguments);
    let is_given =
        |arg: &&clap::Arg| matches.value_source(arg.get_id().as_str()) == Some(ValueSource::CommandLine);
    flags.filter(is_given).filter_map(|arg| arg.get_long().map(str::to_owned)).collect()
}

#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    /// Render a scene to a picture
    #[command(after_help = examples::RENDER)]
    Render(Box<RenderFlags>),
    /// Show a scene in a browser, rendered by this machine
    ///
    /// Prints the address of the page and opens it. What rests on the screen is the picture that render makes of the same view,
    /// byte for byte; the page has the command line for it. On a machine without a screen, make a tunnel to the port
    /// (ssh -L 8080:127.0.0.1:8080 HOST) and open the address here.
    #[cfg(feature = "view")]
    #[command(after_help = examples::VIEW)]
    View(Box<ViewFlags>),
    /// Render a flight around Platonic solids (PLATO's course)
    ///
    /// Reads the input text of PLATO's course from standard input. Writes one frame after another to the path in the input, and
    /// prints one line per frame: its number, milliseconds and rays.
    #[command(after_help = examples::COURSE)]
    Course(Box<CourseFlags>),
    /// Show what a scene contains and the statistics of its hierarchy
    #[command(after_help = examples::INFO)]
    Info(InfoFlags),
    /// Compare two pictures: identical, or where and by how much they differ
    ///
    /// Exits with 0 where every pixel is identical, with 1 where any differs.
    #[command(after_help = examples::COMPARE)]
    Compare(CompareFlags),
    /// Join the shares of a picture that render --tiles or --sample-range has written
    #[command(after_help = examples::MERGE)]
    Merge(MergeFlags),
    /// Measure the speed of a device, and compare its answers with the CPU's
    Bench(BenchFlags),
    /// Run experiments about speed, and say what may be trusted of them
    Lab(LabFlags),
    /// List the devices that can render
    Devices(DevicesFlags),
    /// Print the JSON schema of scene files, for editors
    Schema(SchemaFlags),
    /// Print a completion script for a shell
    Completions(CompletionsFlags),
}

/// What a scene may be.
fn scene_help() -> String {
    let names: Vec<String> = BUILTINS.iter().map(|scene| format!("builtin:{}", scene.name)).collect();
    format!("An OBJ, glTF, PLY or JSON file, or a built-in scene: {}", names.join(", "))
}

#[derive(Debug, Args)]
pub(crate) struct InfoFlags {
    #[arg(help = scene_help())]
    pub(crate) scene: PathBuf,
    /// The hierarchy to build over the primitives [default: bvh8]. all: a table of every hierarchy with its work and speed on
    /// camera rays; builders: the same table for bvh and bvh8 with every builder
    #[arg(long, value_name = "NAME", value_parser = device::accels())]
    pub(crate) accel: Option<AccelChoice>,
    /// Print the results as JSON
    #[arg(long)]
    pub(crate) json: bool,
    #[command(flatten)]
    pub(crate) textures: TextureFlags,
    #[command(flatten)]
    pub(crate) device: DeviceFlags,
}

impl InfoFlags {
    /// The one structure that is looked at, where the flags name one.
    pub(crate) fn one(&self) -> Option<Accel> {
        match self.accel {
            Some(AccelChoice::One(accel)) => Some(accel),
            _ => None,
        }
    }

    /// Whether a table is made of several ones.
    pub(crate) fn is_table(&self) -> bool {
        matches!(self.accel, Some(AccelChoice::All | AccelChoice::Builders))
    }

    /// Fails where one of the flags about devices would do nothing, as nothing is rendered.
    pub(crate) fn check(&self) -> Result<(), Failure> {
        let device = &self.device;
        let (is_table, by_builder) = (self.is_table(), self.accel == Some(AccelChoice::Builders));
        let need = |flag, is_given, is_met, needs| Need { flag, is_given, is_met, needs };
        let render = "a picture to be rendered (render, bench render)";
        let options = "one structure, or --accel all: --accel builders takes each builder as it usually is";
        check(&[
            need("--tile", device.tile.is_some(), false, render),
            need("--block-size", device.block_size.is_some(), false, render),
            need("--gpu-paths", device.gpu_paths.is_some(), false, render),
            need("--gpu-memory", device.gpu_memory.is_some(), false, render),
            need("--gpu-scheduler", device.gpu_scheduler != GpuScheduler::default(), false, render),
            need("--scheduler", device.scheduler.is_some(), false, render),
            need("--gpu-traversal", device.gpu_traversal != Traversal::default(), false, render),
            need("--simd", device.simd.0.is_some(), is_table, "rays to be traced (--accel all or builders)"),
            need(
                "--backend",
                matches!(device.backend, Some(BackendChoice::Cuda(_))),
                !is_table,
                "one structure: tables are made on the CPU",
            ),
            need("--builder", device.builder.is_some(), !by_builder, options),
            need("--leaf-size", device.leaf_size.is_some(), !by_builder, options),
            need("--tree-depth", device.tree_depth.is_some(), !by_builder, options),
            need("--sah-costs", device.sah_costs.is_some(), !by_builder, options),
        ])
    }
}

#[derive(Debug, Args)]
pub(crate) struct MergeFlags {
    /// The shares, in any order [default: all files beside OUT that are named as its shares]
    #[arg(value_name = "SHARE")]
    pub(crate) shares: Vec<PathBuf>,
    /// The picture, the same file that one run would have written
    #[arg(short, long, value_name = "OUT")]
    pub(crate) output: PathBuf,
    /// Print errors only
    #[arg(short, long)]
    pub(crate) quiet: bool,
}

#[derive(Debug, Args)]
pub(crate) struct CompareFlags {
    /// A picture: .png, .ppm, .jpg or .data, or a linear one: .exr or .hdr
    pub(crate) a: PathBuf,
    /// Another picture of the same size. .exr and .hdr are compared with each other only, and so are .png, .ppm, .jpg and .data
    pub(crate) b: PathBuf,
    /// Write a picture of the absolute difference, amplified so that the largest difference is white
    #[arg(long, value_name = "OUT.png")]
    pub(crate) diff: Option<PathBuf>,
    /// Print the results as JSON
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Debug, Args)]
pub(crate) struct DevicesFlags {
    /// Print the results as JSON
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Debug, Args)]
pub(crate) struct SchemaFlags {
    /// Print the documentation of the format instead, in Markdown
    #[arg(long)]
    pub(crate) markdown: bool,
}

#[derive(Debug, Args)]
pub(crate) struct CompletionsFlags {
    /// The shell that the script is for
    pub(crate) shell: clap_complete::Shell,
}
