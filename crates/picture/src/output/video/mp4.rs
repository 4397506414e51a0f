//! Segments to an MP4 file that begins with its table of contents, so that players can start before they have all.

use super::super::OutputError;
use super::super::atomic::TemporaryFile;
use super::encoder::ParameterSets;
use super::folder::Folder;
use super::{damaged, padded_size};
use shiguredo_mp4::bitstream::h264::{H264SampleEntryConfig, LengthSize, build_avc1_box};
use shiguredo_mp4::boxes::{SampleEntry, UnknownBox};
use shiguredo_mp4::mux::{Mp4FileMuxer, Mp4FileMuxerOptions, Sample, estimate_maximum_moov_box_size};
use shiguredo_mp4::{BoxSize, BoxType, TrackKind};
use std::io::{BufWriter, Error, Seek, SeekFrom, Write};
use std::path::Path;
use std::slice::from_ref;

/// Joins all segments of the folder. The file is whole or not there; until it is whole, it is in the folder.
pub(super) fn write(path: &Path, folder: &Folder) -> Result<(), OutputError> {
    let failed = |error| OutputError::video(path, error);
    let settings = folder.settings();
    let options = Mp4FileMuxerOptions {
        reserved_moov_box_size: estimate_maximum_moov_box_size(&[settings.frames as usize]),
        ..Mp4FileMuxerOptions::default()
    };
    let mut muxer = Mp4FileMuxer::with_options(options).map_err(muxing).map_err(failed)?;
    let file = TemporaryFile::within(folder.path(), path).map_err(failed)?;
    let mut to = BufWriter::with_capacity(1 << 18, file.handle().map_err(failed)?);
    to.write_all(muxer.initial_boxes_bytes()).map_err(failed)?;
    let mut offset = muxer.initial_boxes_bytes().len() as u64;
    let rate = settings.rate().map_err(failed)?;
    let mut parameters = None;
    for number in 0..settings.segments() {
        let mut segment = folder.open_segment(number)?;
        let mut entry = None;
        match &parameters {
            None => {
                entry =
                    Some(sample_entry(&segment.parameters, settings.width, settings.height).map_err(failed)?)
            }
            Some(parameters) if *parameters == segment.parameters => {}
            Some(_) => return Err(OutputError::video(&folder.segment(number), not_like_the_first())),
        }
        for (index, &length) in segment.lengths.iter().enumerate() {
            let sample = Sample {
                track_kind: TrackKind::Video,
                sample_entry: entry.take(),
                keyframe: index == 0,
                timescale: rate.time_scale(),
                duration: rate.denominator(),
                composition_time_offset: None,
                data_offset: offset,
                data_size: length as usize,
            };
            muxer.append_sample(&sample).map_err(muxing).map_err(failed)?;
            offset += length as u64;
        }
        segment.copy_samples(&mut to).map_err(failed)?;
        parameters = Some(segment.parameters);
    }
    let boxes = muxer.finalize().map_err(muxing).map_err(failed)?;
    for (offset, bytes) in boxes.offset_and_bytes_pairs() {
        to.seek(SeekFrom::Start(offset)).and_then(|_| to.write_all(bytes)).map_err(failed)?;
    }
    to.flush().map_err(failed)?;
    drop(to);
    file.keep().map_err(failed)
}

/// What the table of contents says of the samples.
fn sample_entry(parameters: &ParameterSets, width: u32, height: u32) -> Result<SampleEntry, Error> {
    let config = H264SampleEntryConfig { length_size: LengthSize::FourBytes };
    let mut entry = build_avc1_box(from_ref(&parameters.sequence), from_ref(&parameters.picture), &config)
        .map_err(muxing)?;
    let (width, height) = padded_size((width, height));
    if (entry.visual.width as u32, entry.visual.height as u32) != (width, height) {
        return Err(muxing("the encoder made pictures of another size"));
    }
    entry.unknown_boxes.push(colours());
    Ok(SampleEntry::Avc1(entry))
}

/// Says what [`super::planes`] does: primaries, curve and matrix of BT.709 (ISO/IEC 23091-2: 1, 1, 1), limited range.
fn colours() -> UnknownBox {
    let payload = [&b"nclx"[..], &[0, 1, 0, 1, 0, 1, 0]].concat();
    let box_size = BoxSize::U32(8 + payload.len() as u32);
    UnknownBox { box_type: BoxType::Normal(*b"colr"), box_size, payload }
}

fn not_like_the_first() -> Error {
    damaged("the segment was encoded by another version of the program; remove the folder to start anew")
}

fn muxing(error: impl ToString) -> Error {
    Error::other(format!("the MP4 file cannot be put together: {}", error.to_string()))
}
