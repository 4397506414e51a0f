//! Frames of a segment to H.264.

use super::super::Developed;
use super::planes::Planes;
use super::settings::Settings;
use openh264::OpenH264API;
use openh264::encoder::{
    BitRate, Complexity, Encoder, EncoderConfig, FrameRate as Hertz, FrameType, IntraFramePeriod, Level,
    Profile, QpRange, RateControlMode, SpsPpsStrategy, UsageType, VuiConfig,
};
use openh264::formats::YUVSlices;
use shiguredo_mp4::bitstream::h264::{H264NalUnitType, parse_annexb_nal_units};
use std::io::Error;

/// What a decoder must know before the first sample: H.264's parameter sets. The same for all segments of a video.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(super) struct ParameterSets {
    pub(super) sequence: Vec<u8>,
    pub(super) picture: Vec<u8>,
}

/// Encodes one segment, whose first frame needs no other. There is nothing in it that depends on the segments before, on
/// time or on threads: the encoder itself has one.
pub(super) struct SegmentEncoder {
    encoder: Encoder,
    planes: Planes,
    parameters: ParameterSets,
    frames: u32,
}

impl SegmentEncoder {
    pub(super) fn new(settings: &Settings) -> Result<SegmentEncoder, Error> {
        let planes = Planes::new((settings.width, settings.height));
        let hertz = settings.rate()?.hertz();
        let pixels = (planes.width * planes.height) as f64 * hertz;
        // Nothing but the level that the file claims follows from it.
        let bits = BitRate::from_bps((pixels * 0.2).clamp(10_000.0, 200e6) as u32);
        let quantiser = settings.quantiser()?;
        let mut config = config(quantiser, bits)
            .profile(Profile::High)
            .max_frame_rate(Hertz::from_hz(hertz.clamp(1.0, 60.0) as f32));
        if hertz > 60.0 {
            // The encoder counts no more than 60 frames a second when it chooses the level.
            config = config.level(level_of(&planes, hertz));
        }
        let encoder = Encoder::with_api_config(OpenH264API::from_source(), config).map_err(encoding)?;
        Ok(SegmentEncoder { encoder, planes, parameters: ParameterSets::default(), frames: 0 })
    }

    /// The next frame as a sample of an MP4 file: each part has its length before it.
    pub(super) fn encode(&mut self, frame: &Developed) -> Result<Vec<u8>, Error> {
        self.planes.convert(frame);
        let Planes { width, height, y, u, v, .. } = &self.planes;
        let planes = YUVSlices::new((y, u, v), (*width, *height), (*width, width / 2, width / 2));
        let encoded = self.encoder.encode(&planes).map_err(encoding)?;
        let expected = if self.frames == 0 { FrameType::IDR } else { FrameType::P };
        if encoded.frame_type() != expected {
            return Err(encoding(format!("it made a frame of type {:?}", encoded.frame_type())));
        }
        let bytes = encoded.to_vec();
        let mut sample = Vec::with_capacity(bytes.len());
        for unit in parse_annexb_nal_units(&bytes).map_err(encoding)? {
            match unit.nal_unit_type {
                H264NalUnitType::Sps => self.parameters.sequence = unit.data.to_vec(),
                H264NalUnitType::Pps => self.parameters.picture = unit.data.to_vec(),
                _ => {
                    let length = u32::try_from(unit.data.len()).map_err(encoding)?;
                    sample.extend_from_slice(&length.to_be_bytes());
                    sample.extend_from_slice(unit.data);
                }
            }
        }
        if sample.is_empty() {
            return Err(encoding("it made an empty frame"));
        }
        self.frames += 1;
        Ok(sample)
    }

    /// After the last frame.
    pub(super) fn finish(self) -> ParameterSets {
        self.parameters
    }
}

/// What all encoders are set to: every frame has this quantiser, and but for the first one it needs the frame before.
pub(super) fn config(quantiser: u8, bits: BitRate) -> EncoderConfig {
    EncoderConfig::new()
        .bitrate(bits)
        // The one mode in which the range of quantisers is kept to and no bits are counted: with both ends equal
        // every frame has that quantiser. (`Off` takes no notice of the range.)
        .rate_control_mode(RateControlMode::Bufferbased)
        .qp(QpRange::new(quantiser, quantiser))
        .skip_frames(false)
        // It raises the quantiser by up to 2, and starts new groups of pictures.
        .scene_change_detect(false)
        // It leaves parts of the picture as they were in the frame before.
        .background_detection(false)
        .adaptive_quantization(false)
        .long_term_reference(false)
        .usage_type(UsageType::CameraVideoRealTime)
        // More of it took a fifth longer and made files no smaller: `examples/encode.rs`.
        .complexity(Complexity::Low)
        .intra_frame_period(IntraFramePeriod::auto())
        .sps_pps_strategy(SpsPpsStrategy::ConstantId)
        .num_threads(1)
        .vui(VuiConfig::bt709())
}

/// The level by blocks of 16 × 16 pixels a second: ITU-T H.264, table A-1.
fn level_of(planes: &Planes, hertz: f64) -> Level {
    let blocks = (planes.width.div_ceil(16) * planes.height.div_ceil(16)) as f64 * hertz;
    match blocks {
        ..=245_760.0 => Level::Level_4_0,
        ..=522_240.0 => Level::Level_4_2,
        ..=983_040.0 => Level::Level_5_1,
        _ => Level::Level_5_2,
    }
}

pub(super) fn encoding(error: impl ToString) -> Error {
    Error::other(format!("the H.264 encoder failed: {}", error.to_string()))
}
