//! Messages between a page and the server: JSON texts, and frames as bytes behind a header.

use crate::page_view::PageView;
use crate::source::{Device, DeviceChoice};
use eosphor::settings::Integrator;
use serde::{Deserialize, Serialize};

/// Longest message of a page, in bytes.
pub(crate) const MAX_MESSAGE: usize = 16 * 1024;

/// What a page says.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(tag = "type", rename_all = "kebab-case", deny_unknown_fields)]
pub(crate) enum FromPage {
    /// What it wants to see.
    View {
        /// Counts what its user did.
        input: u64,
        /// Whether more will follow soon.
        moving: bool,
        view: PageView,
    },
    /// It has drawn this frame.
    Ack { frame: u64 },
    /// Whether it decodes H.264.
    Decodes { h264: bool },
    /// It is still there.
    Alive {},
    /// It wants to know what is at a pixel of the picture at rest.
    Pixel { x: u32, y: u32 },
    /// It wants the command line of its view.
    Command {},
    /// All pages are to be rendered on this device.
    Device { choice: DeviceChoice },
}

impl FromPage {
    /// Reads a message.
    ///
    /// # Errors
    ///
    /// What is wrong with it.
    pub(crate) fn read(text: &str) -> Result<FromPage, String> {
        serde_json::from_str(text).map_err(|error| format!("no message: {error}"))
    }
}

/// What the server says.
#[derive(Clone, Debug, Serialize)]
#[serde(tag = "type", rename_all = "kebab-case", rename_all_fields = "kebab-case")]
pub(crate) enum ToPage {
    /// A scene is on show: the first, or one that has changed.
    Scene(Box<OnShow>),
    /// The files of the scene cannot be read; the last scene stays.
    Error { text: String },
    /// A message of the page was refused.
    Refused { text: String },
    /// The command line of the page's view.
    Command { text: String },
    /// What is at a pixel of the picture at rest: linear colours, with the samples taken so far, and what is seen there.
    Pixel { x: u32, y: u32, linear: Option<[f32; 3]>, samples: u32, surface: Option<Surface> },
}

/// The scene on show, as a page is told of it.
#[derive(Clone, Debug, Serialize)]
#[serde(rename_all = "kebab-case")]
pub(crate) struct OnShow {
    pub(crate) version: u64,
    pub(crate) name: String,
    /// Where it is rendered.
    pub(crate) backend: String,
    /// How its rays go on: settings of the other integrator change nothing.
    pub(crate) integrator: Integrator,
    /// That of the file.
    pub(crate) view: PageView,
    /// Half the diagonal of the scene's box, in world units.
    pub(crate) radius: f32,
    /// The middle of that box, in coordinates of the file.
    pub(crate) center: [f64; 3],
    pub(crate) triangles: usize,
    /// How many frames there are.
    pub(crate) frames: u32,
    /// Frames a second.
    pub(crate) fps: f32,
    /// What pages may choose from.
    pub(crate) devices: Vec<Device>,
    /// What was chosen.
    pub(crate) device: Option<DeviceChoice>,
    /// The number of the page, for files that it asks for.
    pub(crate) page: u64,
    /// Whether the page takes the file's camera: the first time, and where that has changed.
    pub(crate) take_camera: bool,
}

/// What the first camera ray of a pixel finds.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub(crate) struct Surface {
    /// Distance along the ray, in world units.
    pub(crate) depth: f32,
    /// In world space, on the viewer's side.
    pub(crate) normal: [f32; 3],
    /// Numbers, as in layers of EXR files, and names, where there are any.
    pub(crate) object: u32,
    pub(crate) object_name: Option<String>,
    pub(crate) material: u32,
    pub(crate) material_name: Option<String>,
}

/// What a frame is.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub(crate) struct FrameHeader {
    /// Counts the frames of a page.
    pub(crate) frame: u64,
    /// The newest input that it shows.
    pub(crate) input: u64,
    /// The scene that it shows.
    pub(crate) version: u64,
    /// Its width and height.
    pub(crate) size: [u32; 2],
    /// Those of the picture at rest.
    pub(crate) full: [u32; 2],
    /// Samples of each pixel.
    pub(crate) samples: u32,
    /// Samples of each pixel at rest.
    pub(crate) all_samples: u32,
    /// Whether the camera rests.
    pub(crate) at_rest: bool,
    /// Pictures of many bytes come in pieces: which one this is, and how many there are.
    pub(crate) piece: [u32; 2],
    /// Whether it can be decoded without the frames before it.
    pub(crate) key: bool,
    /// The media type.
    pub(crate) format: &'static str,
    pub(crate) milliseconds: Milliseconds,
}

/// How long the steps of a frame took.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub(crate) struct Milliseconds {
    /// Rendering, with the way back from the device.
    pub(crate) render: f64,
    pub(crate) develop: f64,
    pub(crate) encode: f64,
}

/// A frame on its way to a page.
#[derive(Clone, Debug)]
pub(crate) struct Frame {
    pub(crate) header: FrameHeader,
    pub(crate) bytes: Vec<u8>,
}

impl Frame {
    /// The length of the header in 4 bytes, little endian, the header as JSON, the picture.
    pub(crate) fn to_message(&self) -> Vec<u8> {
        let header = serde_json::to_vec(&self.header).unwrap_or_default();
        let mut message = Vec::with_capacity(4 + header.len() + self.bytes.len());
        message.extend_from_slice(&(header.len() as u32).to_le_bytes());
        message.extend_from_slice(&header);
        message.extend_from_slice(&self.bytes);
        message
    }
}
