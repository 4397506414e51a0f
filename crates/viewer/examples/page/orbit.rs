//! An orbit: what it asks for, and how the frames come.

use crate::Result;
use crate::socket::{Heard, Page};
use eosphor_viewer::PageView;
use openh264::decoder::Decoder;
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::sync::mpsc::{Receiver, Sender, channel};
use std::time::{Duration, Instant};
use zune_jpeg::JpegDecoder;
use zune_jpeg::zune_core::bytestream::ZCursor;

/// Between two inputs: those of a screen with 120 pictures a second.
const INPUT_PERIOD: Duration = Duration::from_micros(8_333);

/// A frame that was shown.
pub(crate) struct Shown {
    /// Seconds since the orbit began.
    at: f64,
    /// Milliseconds since the newest input that it shows.
    latency: f64,
    bytes: usize,
    /// Its width and height.
    size: [f64; 2],
    /// Milliseconds of its steps.
    steps: Vec<(&'static str, f64)>,
}

/// Frames of an orbit, or of a part of it.
pub(crate) struct Frames {
    seconds: f64,
    /// When the last frame before them was shown.
    before: f64,
    shown: Vec<Shown>,
}

/// The value that this share of them does not reach.
fn quantile(values: impl Iterator<Item = f64>, share: f64) -> f64 {
    let mut values: Vec<f64> = values.collect();
    values.sort_by(f64::total_cmp);
    values.get((values.len() as f64 * share) as usize).copied().unwrap_or(f64::NAN)
}

/// A view that is turned about the point it looks at.
pub(crate) fn turned(own: &PageView, angle: f64) -> PageView {
    let mut view = *own;
    let (eye, aim) = (own.camera.eye, own.camera.look_at);
    let (x, z) = (eye[0] - aim[0], eye[2] - aim[2]);
    let (sin, cos) = angle.sin_cos();
    view.camera.eye = [aim[0] + x * cos + z * sin, eye[1], aim[2] - x * sin + z * cos];
    view
}

/// A frame that was decoded: its header, bytes, and how long that took in milliseconds.
type Decoded = (Value, usize, f64);

/// Decodes frames on a thread of its own, as browsers do.
fn decoder() -> (Sender<(Value, Vec<u8>)>, Receiver<Decoded>) {
    let ((frames, to_decode), (decoded, done)) = (channel::<(Value, Vec<u8>)>(), channel());
    std::thread::spawn(move || {
        let mut video: Option<Decoder> = None;
        for (header, bytes) in to_decode {
            let start = Instant::now();
            match header["format"].as_str() {
                Some("image/jpeg") => drop(JpegDecoder::new(ZCursor::new(&bytes)).decode().expect("a JPEG")),
                Some("video/h264") => {
                    if header["key"] == true {
                        video = Some(Decoder::new().expect("a decoder"));
                    }
                    let picture = video.as_mut().expect("a key frame comes first").decode(&bytes);
                    assert!(picture.expect("H.264").is_some(), "each frame can be shown when it is there");
                }
                _ => {}
            }
            let took = start.elapsed().as_secs_f64() * 1e3;
            if decoded.send((header, bytes.len(), took)).is_err() {
                return;
            }
        }
    });
    (frames, done)
}

/// Orbits for so long.
pub(crate) fn orbit(page: &mut Page, own: &PageView, seconds: f64) -> Result<Frames> {
    let (start, mut next) = (Instant::now(), Instant::now());
    let mut shown = Vec::new();
    let (frames, decoded) = decoder();
    while start.elapsed().as_secs_f64() < seconds {
        if Instant::now() >= next {
            page.want(&turned(own, 0.4 * (start.elapsed().as_secs_f64() * 1.5).sin()), true)?;
            next += INPUT_PERIOD;
        }
        if let Heard::Frame(header, bytes) = page.hear(next.min(Instant::now() + Duration::from_millis(1)))? {
            frames.send((header, bytes))?;
        }
        for (header, bytes, decoding) in decoded.try_iter() {
            let Some(took) = page.drawn(&header)? else { continue };
            let latency = took.as_secs_f64() * 1e3;
            let ms = |step: &str| header["milliseconds"][step].as_f64().unwrap_or_default();
            let mut steps: Vec<_> = ["render", "develop", "encode"].map(|step| (step, ms(step))).into();
            steps.push(("decode", decoding));
            let known: f64 = steps.iter().map(|step| step.1).sum();
            steps.push(("waiting and line", latency - known));
            let size = [0, 1].map(|axis| header["size"][axis].as_f64().unwrap_or_default());
            shown.push(Shown { at: start.elapsed().as_secs_f64(), latency, bytes, size, steps });
        }
    }
    Ok(Frames { seconds, before: 0.0, shown })
}

impl Frames {
    /// Those of equal parts of the time.
    pub(crate) fn parts(self, count: usize) -> Vec<Frames> {
        let seconds = self.seconds / count as f64;
        let mut parts: Vec<Frames> =
            (0..count).map(|_| Frames { seconds, before: 0.0, shown: Vec::new() }).collect();
        for shown in self.shown {
            let k = ((shown.at / seconds) as usize).min(count - 1);
            parts[k].shown.push(shown);
        }
        for k in 1..count {
            parts[k].before = parts[k - 1].shown.last().map_or(parts[k - 1].before, |shown| shown.at);
        }
        parts
    }

    fn latency(&self, share: f64) -> f64 {
        quantile(self.shown.iter().map(|shown| shown.latency), share)
    }

    fn width(&self, share: f64) -> f64 {
        quantile(self.shown.iter().map(|shown| shown.size[0]), share)
    }

    /// The longest time without a new frame, in milliseconds.
    fn longest_gap(&self) -> f64 {
        let times = || self.shown.iter().map(|shown| shown.at);
        let gaps = times().zip(std::iter::once(self.before).chain(times())).map(|(at, last)| at - last);
        gaps.fold(0.0, f64::max) * 1e3
    }

    /// For programs.
    pub(crate) fn to_json(&self) -> Value {
        let bytes: usize = self.shown.iter().map(|shown| shown.bytes).sum();
        json!({
            "frames": self.shown.len(),
            "frames-per-second": self.shown.len() as f64 / self.seconds,
            "median": self.latency(0.5),
            "p95": self.latency(0.95),
            "max": self.latency(0.9999),
            "longest-gap": self.longest_gap(),
            "bytes-per-second": bytes as f64 / self.seconds,
            "bytes-per-frame": quantile(self.shown.iter().map(|shown| shown.bytes as f64), 0.5),
            "widths": [self.width(0.0), self.width(0.5), self.width(0.9999)],
        })
    }

    /// For people.
    pub(crate) fn print(&self) {
        print!(
            "{:.1} frames/s; input to picture median {:.1} p95 {:.1} max {:.1} ms; width {:.0} to {:.0}, {:.0} kB;",
            self.shown.len() as f64 / self.seconds,
            self.latency(0.5),
            self.latency(0.95),
            self.latency(0.9999),
            self.width(0.0),
            self.width(0.9999),
            quantile(self.shown.iter().map(|shown| shown.bytes as f64 / 1e3), 0.5)
        );
        let mut steps: BTreeMap<&str, Vec<f64>> = BTreeMap::new();
        for (step, ms) in self.shown.iter().flat_map(|shown| &shown.steps) {
            steps.entry(step).or_default().push(*ms);
        }
        for (step, times) in steps {
            print!(" {step} {:.1}", quantile(times.into_iter(), 0.5));
        }
    }
}
