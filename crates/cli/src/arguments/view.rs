//! Flags of `eosphor view`.

use super::{CameraFlags, DeviceFlags, PictureFlags, SettingsFlags, TextureFlags, scene_help};
use clap::Args;
use std::net::{IpAddr, Ipv4Addr};
use std::path::PathBuf;

#[derive(Clone, Debug, Args)]
pub(crate) struct ViewFlags {
    #[arg(help = scene_help())]
    pub(crate) scene: PathBuf,
    /// The port of the page, 0 to 65535; 0 is any that is free
    #[arg(long, value_name = "PORT", default_value = "0", value_parser = super::values::whole::<u16>(0..=65_535), allow_hyphen_values = true)]
    pub(crate) port: u16,
    /// The address that the page can be reached at. Nothing is encrypted: others on the network can read what is sent, the
    /// address of the page with its token too
    #[arg(long, value_name = "ADDRESS", default_value_t = IpAddr::V4(Ipv4Addr::LOCALHOST), allow_hyphen_values = true)]
    pub(crate) listen: IpAddr,
    /// Do not open the page in a browser
    #[arg(long)]
    pub(crate) no_open: bool,
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
