//! A live picture: frames as H.264, each of which can be shown as soon as it is there.

use super::super::Developed;
use super::encoder::{config, encoding};
use super::planes::Planes;
use openh264::OpenH264API;
use openh264::encoder::{BitRate, Encoder, FrameType, Profile};
use openh264::formats::YUVSlices;
use std::io::Error;

/// Encodes frames of one size and quantiser as they come.
pub struct LiveEncoder {
    encoder: Encoder,
    planes: Planes,
    quantiser: u8,
}

/// A frame of a live picture.
pub struct LiveFrame {
    /// H.264 in the form of annex B: each part begins with a start code.
    pub bytes: Vec<u8>,
    /// Whether it can be decoded without the frames before it; the parameter sets are then in it.
    pub is_key: bool,
}

impl LiveEncoder {
    /// An encoder for frames of this size ([`super::check_video_size`]). `quantiser` is H.264's, 12 to 51: 6 more are half the
    /// precision.
    ///
    /// # Errors
    ///
    /// What the encoder does not take.
    pub fn new(size: (u32, u32), quantiser: u8) -> Result<LiveEncoder, Error> {
        super::check_video_size(size).map_err(super::misuse)?;
        let quantiser = quantiser.clamp(12, 51);
        // Without what slow decoders lack.
        let config = config(quantiser, BitRate::from_bps(20_000_000)).profile(Profile::Baseline);
        let encoder = Encoder::with_api_config(OpenH264API::from_source(), config).map_err(encoding)?;
        Ok(LiveEncoder { encoder, planes: Planes::new(size), quantiser })
    }

    /// Whether it encodes frames of this size with this quantiser.
    pub fn is_for(&self, size: (u32, u32), quantiser: u8) -> bool {
        (self.planes.width as u32, self.planes.height as u32) == super::padded_size(size)
            && self.quantiser == quantiser
    }

    /// The next frame; the first one is a key frame.
    ///
    /// # Errors
    ///
    /// A picture of another size; what the encoder says.
    pub fn encode(&mut self, picture: &Developed) -> Result<LiveFrame, Error> {
        if !self.is_for((picture.width, picture.height), self.quantiser) {
            return Err(super::misuse("a frame of another size than the encoder's"));
        }
        self.planes.convert(picture);
        let Planes { width, height, y, u, v, .. } = &self.planes;
        let planes = YUVSlices::new((y, u, v), (*width, *height), (*width, width / 2, width / 2));
        let encoded = self.encoder.encode(&planes).map_err(encoding)?;
        let is_key = match encoded.frame_type() {
            FrameType::IDR => true,
            FrameType::P => false,
            other => return Err(encoding(format!("it made a frame of type {other:?}"))),
        };
        Ok(LiveFrame { bytes: encoded.to_vec(), is_key })
    }
}
