//! What sums of samples are of.

use crate::output::{DevelopSettings, PICTURE_VERSION, SaveOptions, bands};
use crate::scene_hash::hash_with;
use eosphor_core::settings::PixelSampling;
use eosphor_render::PickedRows;
use eosphor_render::Region;
use eosphor_scene::SceneData;
use serde::{Deserialize, Serialize};
use std::ops::Range;

/// Which part of a picture sums are of.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Part {
    /// A rectangle; `None`: all of it.
    #[serde(default)]
    pub region: Option<Region>,
    /// The share of the rows: its number, from 1, and how many shares there are; `None`: all rows.
    #[serde(default)]
    pub rows: Option<(u32, u32)>,
}

impl Part {
    /// Width and height of it, of a scene's picture.
    pub(super) fn size(&self, scene: &SceneData) -> (u32, u32) {
        let whole = (scene.settings.width, scene.settings.height);
        let (width, height) = self.region.map_or(whole, |region| (region.width, region.height));
        (width, self.rows.map_or(height, |share| PickedRows::new(bands(height, share)).height()))
    }
}

/// What sums are of: all that a sample depends on. How many there are of a pixel is not among it, where a sample does not
/// depend on that, nor how colours become bytes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct SumsHeader {
    /// The version of the program's pictures.
    pub(super) picture: u32,
    /// Width and height in pixels.
    pub(super) size: (u32, u32),
    pub(super) scene: String,
    /// The part of the picture, which has the size above.
    pub(super) part: Part,
    /// Where they are some samples of a picture, to be merged with others.
    pub(super) share: Option<SampleShare>,
}

/// Some samples of each pixel of a picture, and what the whole of it is.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SampleShare {
    /// The samples of each pixel that the share has, by number.
    pub samples: Range<u32>,
    /// How many samples of a pixel the picture has.
    pub all: u32,
    /// What the pixels depend on: [`crate::scene_hash`].
    pub scene: String,
    /// How the whole picture is to be saved.
    pub options: SaveOptions,
}

impl SampleShare {
    /// This share without the command line, which may have differed in what changes no pixel.
    fn without_command_line(&self) -> SampleShare {
        let mut share = self.clone();
        share.options.metadata.command_line = None;
        share
    }

    /// Whether another one is of the same picture.
    pub(super) fn is_beside(&self, other: &SampleShare) -> bool {
        let (one, other) = (self.without_command_line(), other.without_command_line());
        SampleShare { samples: other.samples.clone(), ..one } == other
    }
}

impl SumsHeader {
    /// The header of the sums of a part of a scene's picture, or of a share of its samples.
    pub(super) fn of(scene: &SceneData, part: Part, share: Option<SampleShare>) -> SumsHeader {
        let mut settings = scene.settings;
        match settings.pixel_sampling {
            // One random sample is in the middle of its pixel.
            PixelSampling::Random => settings.samples = settings.samples.min(2),
            PixelSampling::Center => settings.samples = 1,
            PixelSampling::Grid => {}
        }
        let hash = hash_with(scene, &settings, &DevelopSettings::default());
        SumsHeader { picture: PICTURE_VERSION, size: part.size(scene), scene: hash, part, share }
    }

    /// In what another one differs, where its sums cannot be gone on with.
    pub(super) fn difference(&self, other: &SumsHeader) -> Option<String> {
        let SumsHeader { picture, size, scene, part, share } = other;
        let is_same_share = match (&self.share, share) {
            (Some(own), Some(share)) => own.samples == share.samples && own.is_beside(share),
            (own, share) => own.is_none() && share.is_none(),
        };
        match () {
            _ if *picture != self.picture => {
                Some("by a version of the program with other pictures".to_owned())
            }
            _ if *size != self.size => Some(format!("of {} x {} pixels", size.0, size.1)),
            _ if *part != self.part => Some("of another part of the picture".to_owned()),
            _ if *scene != self.scene => Some("of another scene, or with other settings".to_owned()),
            _ if !is_same_share => Some("of other samples, or with other settings of the file".to_owned()),
            _ => None,
        }
    }
}
