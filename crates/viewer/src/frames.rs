//! The frames of a page: while the camera moves, at rest, and of what is shown instead of the picture.

use crate::client::{Client, Wanted};
use crate::encode;
use crate::false_colors;
use crate::message::{Frame, FrameHeader, Milliseconds};
use crate::page_view::Show;
use crate::progress::Progress;
use crate::stage::Stage;
use eosphor::{
    BackendError, DevelopSettings, Developed, FrameState, Metadata, OutputError, RenderControl,
    RenderSettings, SaveOptions, SceneError,
};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

/// Of frames in one piece.
const WHOLE: [u32; 2] = [0, 1];

/// JPEG quality of frames at rest that get sharper.
const REST_QUALITY: u8 = 92;

/// Media types of frames.
const JPEG: &str = "image/jpeg";
const PNG: &str = "image/png";
const H264: &str = "video/h264";

/// Why a frame cannot be made.
#[derive(Debug, thiserror::Error)]
pub(crate) enum FrameError {
    #[error(transparent)]
    Backend(#[from] BackendError),
    #[error(transparent)]
    Scene(#[from] SceneError),
    #[error(transparent)]
    Output(#[from] OutputError),
}

/// A frame of a camera that moves: of a size that is rendered in time.
pub(crate) fn show_moving(client: &Client, stage: &Stage, wanted: &Wanted) -> Result<(), FrameError> {
    let (quality, video) = {
        let mut client_state = client.state();
        (client_state.quality, client_state.next_video(client.video.is_running()))
    };
    let full = wanted.view.size;
    let size = video.map_or_else(|| quality.size(full), |video| video.size(full));
    let (state, settings) = stage.moving(&wanted.view, size)?;
    let start = Instant::now();
    // It is worth its time even if the camera has moved on: else nothing would be seen of a quick movement.
    let never = AtomicBool::new(false);
    let (picture, rendered) = match wanted.view.show {
        Show::Picture => {
            let develop = DevelopSettings::from(&settings);
            let picture = stage.prepared.render_developed(&develop, &control(&state, &never))?;
            let rendered = Instant::now();
            (picture.developed(), rendered)
        }
        show => {
            let features = stage.features()?.rows(0..state.settings.height, Some(&state), &never)?;
            let rendered = Instant::now();
            (false_colors::draw(show, &features), rendered)
        }
    };
    let developed = Instant::now();
    let video_frame = video.and_then(|video| client.video.encode(&picture, video.quantiser()).ok());
    if video.is_some() && video_frame.is_none() {
        // There are too many, or the picture is too small for one: this page gets JPEGs from now on.
        client.state().decodes_h264(false);
    }
    let is_key = video_frame.as_ref().map(|frame| frame.is_key);
    let (bytes, format) = match video_frame {
        Some(frame) => (frame.bytes, H264),
        None => (encode::jpeg(&picture, quality.jpeg())?, JPEG),
    };
    let (milliseconds, took) = (steps(start, rendered, developed), start.elapsed());
    let mut client_state = client.state();
    client_state.made_moving(took, bytes.len(), is_key);
    if let Some(now) = &mut client_state.wanted
        && now.input == wanted.input
    {
        now.is_shown = true;
    }
    let header = FrameHeader {
        frame: client_state.number(),
        input: wanted.input,
        version: stage.version,
        size: [picture.width, picture.height],
        full: wanted.view.size,
        samples: 1,
        all_samples: state.settings.samples,
        at_rest: false,
        piece: WHOLE,
        key: is_key.unwrap_or(true),
        format,
        milliseconds,
    };
    drop(client_state);
    client.show(Frame { header, bytes });
    Ok(())
}

/// More samples of a camera that rests; with the last ones, the picture itself.
pub(crate) fn show_resting(client: &Client, stage: &Stage, wanted: &Wanted) -> Result<(), FrameError> {
    if wanted.view.show != Show::Picture {
        return show_features(client, stage, wanted);
    }
    let (state, settings) = stage.at_rest(&wanted.view)?;
    client.cancel.store(false, Ordering::Relaxed);
    let before = {
        let mut client_state = client.state();
        // What came in since is asked for at the next turn.
        if client_state.wanted.is_none_or(|now| now.view != wanted.view) {
            return Ok(());
        }
        client_state.progress.take().filter(|progress| progress.version == stage.version)
    };
    let start = Instant::now();
    let mut progress =
        before.unwrap_or_else(|| Progress::new(stage.version, wanted.view.size, state.settings.samples));
    let samples = progress.next_samples();
    if !samples.is_empty() {
        let rows = 0..wanted.view.size[1];
        let sampled = stage.prepared.sample_rows(rows, samples.clone(), &control(&state, &client.cancel))?;
        if !sampled.complete {
            // Given up for something newer; if it was not, the samples that there are stay.
            keep(client, wanted, progress);
            return Ok(());
        }
        progress.sums.add(&sampled.sums);
        progress.samples = samples.end;
    }
    let film = progress.sums.film(progress.samples);
    let rendered = Instant::now();
    let picture = Developed::new(&film, &DevelopSettings::from(&settings));
    let developed = Instant::now();
    let (bytes, format) = match progress.is_whole() {
        true => (encode::png(&picture, &file_options(&settings))?, PNG),
        false => (encode::jpeg(&picture, REST_QUALITY)?, JPEG),
    };
    progress.is_sent = progress.is_whole();
    send_at_rest(client, wanted, progress, (bytes, format), steps(start, rendered, developed));
    Ok(())
}

/// What is shown instead of the picture: of all samples at once, as a file would have it.
fn show_features(client: &Client, stage: &Stage, wanted: &Wanted) -> Result<(), FrameError> {
    let (state, settings) = stage.at_rest(&wanted.view)?;
    client.cancel.store(false, Ordering::Relaxed);
    if client.state().wanted.is_none_or(|now| now.view != wanted.view) {
        return Ok(());
    }
    let start = Instant::now();
    let features = stage.features()?.rows(0..state.settings.height, Some(&state), &client.cancel)?;
    if client.cancel.load(Ordering::Relaxed) {
        return Ok(());
    }
    let rendered = Instant::now();
    let picture = false_colors::draw(wanted.view.show, &features);
    let developed = Instant::now();
    let bytes = encode::png(&picture, &file_options(&settings))?;
    let progress = Progress { is_sent: true, ..Progress::at_once(stage.version, state.settings.samples) };
    send_at_rest(client, wanted, progress, (bytes, PNG), steps(start, rendered, developed));
    Ok(())
}

/// Sends a frame of a camera that rests, unless the page wants another view by now.
fn send_at_rest(
    client: &Client,
    wanted: &Wanted,
    progress: Progress,
    (bytes, format): (Vec<u8>, &'static str),
    milliseconds: Milliseconds,
) {
    let header = FrameHeader {
        frame: client.state().number(),
        input: wanted.input,
        version: progress.version,
        size: wanted.view.size,
        full: wanted.view.size,
        samples: progress.samples,
        all_samples: progress.all_samples,
        at_rest: true,
        piece: WHOLE,
        key: true,
        format,
        milliseconds,
    };
    if format == PNG {
        client.video.end();
    }
    if keep(client, wanted, progress) {
        client.show(Frame { header, bytes });
    }
}

/// Keeps samples for the next turn, if the page still wants this view.
fn keep(client: &Client, wanted: &Wanted, mut progress: Progress) -> bool {
    let mut client_state = client.state();
    let Some(now) = client_state.wanted else { return false };
    let is_wanted = now.view == wanted.view;
    // The same view under the number of a newer input is sent once more.
    progress.is_sent &= now.input == wanted.input;
    if is_wanted {
        client_state.progress = Some(progress);
    }
    is_wanted
}

fn control<'a>(state: &'a FrameState, cancel: &'a AtomicBool) -> RenderControl<'a> {
    RenderControl { on_progress: &|_| {}, cancel, count_work: false, frame: Some(state) }
}

/// What the file of the picture at rest is like: that of `eosphor render --no-metadata`.
pub(crate) fn file_options(settings: &RenderSettings) -> SaveOptions {
    SaveOptions { metadata: Metadata::default(), ..SaveOptions::from(settings) }
}

fn steps(start: Instant, rendered: Instant, developed: Instant) -> Milliseconds {
    let ms = |from: Instant, to: Instant| (to - from).as_secs_f64() * 1e3;
    Milliseconds {
        render: ms(start, rendered),
        develop: ms(rendered, developed),
        encode: ms(developed, Instant::now()),
    }
}
