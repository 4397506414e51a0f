//! What the file of a picture is like.

use eosphor_picture::output::{DevelopSettings, Format, Layer, Metadata, SaveOptions, Window};
use eosphor_picture::scene_hash;
use eosphor_render::Region;
use eosphor_scene::{Scene, SceneData};

/// What the file of a picture is like. None of it changes the picture; what a format has no room for is left out of its files.
#[derive(Clone, Debug, PartialEq)]
pub struct FileOptions {
    /// Layers besides the colours, of what each pixel shows first; EXR files only.
    pub layers: Vec<Layer>,
    /// Leave the background out, and say by an alpha channel how much of a pixel is covered; PNG and EXR files only.
    pub alpha: bool,
    /// EXR files hold 16-bit floats; distances and numbers keep 32 bits.
    pub exr_half: bool,
    /// Quality of JPEG files, 1 to 100. Below 90, 2 × 2 pixels share their colour.
    pub jpeg_quality: u8,
    /// PNG and EXR files name the hash of the scene, and the command line, where there is one.
    pub metadata: bool,
    /// The command line that made the picture.
    pub command_line: Option<String>,
}

impl Default for FileOptions {
    fn default() -> FileOptions {
        let SaveOptions { jpeg_quality, .. } = SaveOptions::default();
        FileOptions {
            layers: Vec::new(),
            alpha: false,
            exr_half: false,
            jpeg_quality,
            metadata: true,
            command_line: None,
        }
    }
}

impl FileOptions {
    /// Whether rows are written with what their camera rays find.
    pub(super) fn needs_features(&self) -> bool {
        !self.layers.is_empty() || self.alpha
    }

    /// The options for saving a scene's picture, or a part of it, in these formats.
    pub(super) fn save_options(
        &self,
        (scene, data): (&Scene, &SceneData),
        formats: &[Format],
        region: Option<Region>,
    ) -> SaveOptions {
        let develop = DevelopSettings::from(&scene.settings);
        let metadata = match self.metadata && formats.iter().any(|format| format.has_metadata()) {
            true => Metadata {
                scene_hash: Some(scene_hash(data, &develop)),
                command_line: self.command_line.clone(),
            },
            false => Metadata::default(),
        };
        SaveOptions {
            develop,
            jpeg_quality: self.jpeg_quality,
            exr_half: self.exr_half,
            layers: self.layers.clone(),
            alpha: self.alpha.then_some(data.settings.background),
            metadata,
            window: region.map(|region| Window { region, whole: scene.settings.size.into() }),
        }
    }
}

/// What is of use in a format.
pub(super) fn of_format(options: &SaveOptions, format: Format) -> SaveOptions {
    let mut options = options.clone();
    if !format.has_layers() {
        options.layers.clear();
    }
    if !format.has_alpha() {
        options.alpha = None;
    }
    if !format.has_metadata() {
        options.metadata = Metadata::default();
    }
    options
}
