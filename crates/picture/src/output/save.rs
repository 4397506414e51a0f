//! Saving a film under a name.

use super::{DevelopSettings, Developed, Format, Layer, Metadata, OutputError, PictureWriter, atomic};
use eosphor_core::math::Vec3;
use eosphor_render::{Film, Region};
use eosphor_scene::RenderSettings;
use serde::{Deserialize, Serialize};
use std::path::Path;

/// How a picture is saved.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SaveOptions {
    /// How linear colours become bytes; EXR and HDR files are linear and take no notice of it.
    pub develop: DevelopSettings,
    /// Quality of JPEG files, 1 to 100. Below 90, 2 × 2 pixels share their colour.
    pub jpeg_quality: u8,
    /// EXR files hold 16-bit floats; distances and numbers keep 32 bits.
    pub exr_half: bool,
    /// Layers besides the colours; EXR files only.
    pub layers: Vec<Layer>,
    /// Leaves out the background, which has this radiance: pixels have an alpha channel instead. PNG and EXR files only.
    #[serde(default)]
    pub alpha: Option<Vec3>,
    /// What PNG and EXR files say of themselves.
    pub metadata: Metadata,
    /// Set where the picture is a part of a larger one: where the part lies. The file has the size of the part; EXR files
    /// say where it lies.
    #[serde(default)]
    pub window: Option<Window>,
}

/// Where a picture lies in a larger one that it is a part of, in pixels.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Window {
    /// The part of the larger picture.
    pub region: Region,
    /// Width and height of the whole.
    pub whole: (u32, u32),
}

impl SaveOptions {
    /// Whether rows are written with what their camera rays find: for layers, and for alpha.
    pub fn needs_features(&self) -> bool {
        !self.layers.is_empty() || self.alpha.is_some()
    }
}

impl Default for SaveOptions {
    fn default() -> SaveOptions {
        SaveOptions {
            develop: DevelopSettings::default(),
            jpeg_quality: 90,
            exr_half: false,
            layers: Vec::new(),
            alpha: None,
            metadata: Metadata::default(),
            window: None,
        }
    }
}

impl From<&RenderSettings> for SaveOptions {
    fn from(settings: &RenderSettings) -> SaveOptions {
        SaveOptions { develop: settings.into(), ..SaveOptions::default() }
    }
}

/// Saves a film in the format of the file name's ending. The file is whole or not there: it is written beside its
/// final name, flushed to the disk, then renamed. For layers, alpha, partial pictures and those that do not fit in memory there
/// is [`PictureWriter`].
pub fn save(film: &Film, path: &Path, options: &SaveOptions) -> Result<(), OutputError> {
    let mut writer = PictureWriter::open(path, (film.width, film.height), options)?;
    writer.write_rows(film, None)?;
    writer.finish()
}

/// As [`save`], with the file in `folder`, which is on the same file system, until it is whole: what a program leaves that
/// is killed is found there, and nowhere else.
pub fn save_within(
    folder: &Path,
    film: &Film,
    path: &Path,
    options: &SaveOptions,
) -> Result<(), OutputError> {
    let mut writer = PictureWriter::open_within(folder, path, (film.width, film.height), options)?;
    writer.write_rows(film, None)?;
    writer.finish()
}

/// Writes a developed picture to a file, in the format that the path asks for. Linear formats (EXR, HDR) are refused.
pub fn save_developed(picture: &Developed, path: &Path, options: &SaveOptions) -> Result<(), OutputError> {
    let mut writer = PictureWriter::open(path, (picture.width, picture.height), options)?;
    writer.write_developed(picture)?;
    writer.finish()
}

/// As [`save_developed`], with the file in `folder` until it is whole, as [`save_within`] has it.
pub fn save_developed_within(
    folder: &Path,
    picture: &Developed,
    path: &Path,
    options: &SaveOptions,
) -> Result<(), OutputError> {
    let mut writer = PictureWriter::open_within(folder, path, (picture.width, picture.height), options)?;
    writer.write_developed(picture)?;
    writer.finish()
}

/// Whether [`save`] could write there: a known ending, a folder that exists and may be written to. It leaves nothing
/// behind. Call it before minutes of rendering.
pub fn check_writable(path: &Path) -> Result<(), OutputError> {
    Format::of(path)?;
    atomic::check(path).map_err(|error| OutputError::write(path, error))
}
