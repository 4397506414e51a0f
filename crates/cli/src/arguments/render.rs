//! Flags of `eosphor render`.

use super::camera::CameraFlags;
use super::settings::SettingsFlags;
use super::values::triple;
use super::{DeviceFlags, SCENE_HELP};
use crate::streams::Verbosity;
use clap::{ArgAction, Args};
use eosphor::Preset;
use eosphor::math::Vec3;
use std::path::PathBuf;

#[derive(Debug, Args)]
pub(crate) struct RenderFlags {
    #[arg(help = SCENE_HELP)]
    pub(crate) scene: String,
    /// The picture: .png, .ppm, .exr (linear) or .data
    #[arg(short, long, value_name = "OUT")]
    pub(crate) output: PathBuf,
    /// Render as a reference system does; other flags win over it
    #[arg(long, value_name = "NAME", value_parser = super::values::named([("eos", Preset::Eos), ("pg1", Preset::Pg1)]))]
    pub(crate) preset: Option<Preset>,
    /// Move all geometry; camera and lights stay
    #[arg(long, value_name = "X,Y,Z", value_parser = triple, allow_hyphen_values = true)]
    pub(crate) translate: Option<Vec3>,
    #[command(flatten)]
    pub(crate) settings: SettingsFlags,
    #[command(flatten)]
    pub(crate) camera: CameraFlags,
    #[command(flatten)]
    pub(crate) device: DeviceFlags,
    #[command(flatten)]
    pub(crate) report: ReportFlags,
}

#[derive(Debug, Args)]
#[command(next_help_heading = "Report")]
pub(crate) struct ReportFlags {
    /// Print the statistics as JSON to stdout
    #[arg(long)]
    pub(crate) json: bool,
    /// Count the hierarchy's nodes and the tests of each ray; up to four times slower, since packets are not used
    #[arg(long)]
    pub(crate) stats: bool,
    /// Say nothing but errors
    #[arg(short, long, conflicts_with = "verbose")]
    quiet: bool,
    /// Say more
    #[arg(short, long, action = ArgAction::SetTrue)]
    verbose: bool,
}

impl ReportFlags {
    pub(crate) fn verbosity(&self) -> Verbosity {
        match (self.quiet, self.verbose) {
            (true, _) => Verbosity::Quiet,
            (_, true) => Verbosity::Verbose,
            _ => Verbosity::Normal,
        }
    }
}
