//! A page as a program, for machines without a browser: how long an input takes to become a decoded picture, and whether
//! what rests is the file that the copied command line writes.
//!
//! `page PROGRAM SECONDS PROCESSES VIEW_ARGUMENTS...`: starts `PROGRAM view VIEW_ARGUMENTS --no-open` so many times, orbits for so
//! long with 120 inputs a second, then rests. The same views are then rendered by their command lines.

use eosphor_viewer::PageView;
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::error::Error;
use std::io::{BufRead, BufReader};
use std::net::TcpStream;
use std::process::{Child, Command, Stdio};
use std::sync::mpsc::{Receiver, Sender, channel};
use std::time::{Duration, Instant};
use tungstenite::client::IntoClientRequest;
use tungstenite::{Message, WebSocket};
use zune_jpeg::JpegDecoder;
use zune_jpeg::zune_core::bytestream::ZCursor;

/// Between two inputs: those of a screen with 120 pictures a second.
const INPUT_PERIOD: Duration = Duration::from_micros(8_333);

type Result<T> = std::result::Result<T, Box<dyn Error>>;

struct Page {
    viewer: Child,
    socket: WebSocket<TcpStream>,
    input: u64,
    sent: BTreeMap<u64, Instant>,
}

impl Drop for Page {
    fn drop(&mut self) {
        let _ = self.viewer.kill();
        let _ = self.viewer.wait();
    }
}

/// What came in: a text, or a frame with its picture.
enum Heard {
    Nothing,
    Text(Value),
    Frame(Value, Vec<u8>),
}

impl Page {
    fn open(program: &str, arguments: &[String]) -> Result<Page> {
        let mut viewer = Command::new(program)
            .arg("view")
            .args(arguments)
            .arg("--no-open")
            .stdout(Stdio::piped())
            .spawn()?;
        let mut url = String::new();
        BufReader::new(viewer.stdout.take().ok_or("no output")?).read_line(&mut url)?;
        let (address, token) =
            url.trim().strip_prefix("http://").and_then(|u| u.split_once("/?token=")).ok_or("no address")?;
        let port = address.rsplit(':').next().unwrap_or_default();
        let mut request = format!("ws://{address}/socket").into_client_request()?;
        request.headers_mut().insert("cookie", format!("eosphor-{port}={token}").parse()?);
        request.headers_mut().insert("origin", format!("http://{address}").parse()?);
        let stream = TcpStream::connect(address)?;
        stream.set_nodelay(true)?;
        let (socket, _) = tungstenite::client(request, stream)?;
        Ok(Page { viewer, socket, input: 0, sent: BTreeMap::new() })
    }

    fn want(&mut self, view: &PageView, moving: bool) -> Result<u64> {
        self.input += 1;
        let message = json!({ "type": "view", "input": self.input, "moving": moving, "view": view });
        self.sent.insert(self.input, Instant::now());
        self.socket.send(Message::text(message.to_string()))?;
        Ok(self.input)
    }

    /// Waits until then for something to come in.
    fn hear(&mut self, until: Instant) -> Result<Heard> {
        let left = until.saturating_duration_since(Instant::now()).max(Duration::from_micros(100));
        self.socket.get_ref().set_read_timeout(Some(left))?;
        match self.socket.read() {
            Ok(Message::Text(text)) => Ok(Heard::Text(serde_json::from_str(&text)?)),
            Ok(Message::Binary(bytes)) => {
                let length = u32::from_le_bytes(bytes[..4].try_into()?) as usize;
                let header: Value = serde_json::from_slice(&bytes[4..4 + length])?;
                Ok(Heard::Frame(header, bytes[4 + length..].to_vec()))
            }
            Ok(_) => Ok(Heard::Nothing),
            Err(tungstenite::Error::Io(error))
                if matches!(error.kind(), std::io::ErrorKind::WouldBlock | std::io::ErrorKind::TimedOut) =>
            {
                Ok(Heard::Nothing)
            }
            Err(error) => Err(error.into()),
        }
    }

    /// Acknowledges a frame as drawn; how long ago its input was.
    fn drawn(&mut self, header: &Value) -> Result<Option<Duration>> {
        self.socket.send(Message::text(json!({ "type": "ack", "frame": header["frame"] }).to_string()))?;
        let input = header["input"].as_u64().unwrap_or_default();
        let took = self.sent.get(&input).map(Instant::elapsed);
        self.sent = self.sent.split_off(&(input + 1));
        Ok(took)
    }

    fn text(&mut self, kind: &str) -> Result<Value> {
        loop {
            match self.hear(Instant::now() + Duration::from_secs(60))? {
                Heard::Text(text) if text["type"] == kind => return Ok(text),
                Heard::Text(text) if text["type"] == "error" || text["type"] == "refused" => {
                    return Err(text["text"].to_string().into());
                }
                Heard::Frame(header, _) => drop(self.drawn(&header)?),
                _ => {}
            }
        }
    }

    /// The picture at rest; and how long the first frame at rest took.
    fn at_rest(&mut self, view: &PageView) -> Result<(Vec<u8>, Duration)> {
        let (input, start) = (self.want(view, false)?, Instant::now());
        let mut first = None;
        loop {
            let Heard::Frame(header, bytes) = self.hear(start + Duration::from_secs(300))? else { continue };
            self.drawn(&header)?;
            if header["input"] == input && header["at-rest"] == true {
                first.get_or_insert_with(|| start.elapsed());
                if header["format"] == "image/png" {
                    return Ok((bytes, first.unwrap_or_default()));
                }
            }
        }
    }
}

fn median(values: &mut [f64], share: f64) -> f64 {
    values.sort_by(f64::total_cmp);
    values.get((values.len() as f64 * share) as usize).copied().unwrap_or(f64::NAN)
}

fn turned(own: &PageView, angle: f64) -> PageView {
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
        for (header, bytes) in to_decode {
            let start = Instant::now();
            if header["format"] == "image/jpeg" {
                JpegDecoder::new(ZCursor::new(&bytes)).decode().expect("a JPEG");
            }
            let took = start.elapsed().as_secs_f64() * 1e3;
            if decoded.send((header, bytes.len(), took)).is_err() {
                return;
            }
        }
    });
    (frames, done)
}

fn orbit(page: &mut Page, own: &PageView, seconds: f64) -> Result<()> {
    let (start, mut next) = (Instant::now(), Instant::now());
    let (mut latencies, mut widths) = (Vec::new(), Vec::new());
    let mut steps: BTreeMap<&str, Vec<f64>> = BTreeMap::new();
    let mut bytes_of_frames = Vec::new();
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
            let took = took.as_secs_f64() * 1e3;
            latencies.push(took);
            widths.push(header["size"][0].as_f64().unwrap_or_default());
            bytes_of_frames.push(bytes as f64 / 1e3);
            let mut rest = took - decoding;
            for step in ["render", "develop", "encode"] {
                let ms = header["milliseconds"][step].as_f64().unwrap_or_default();
                steps.entry(step).or_default().push(ms);
                rest -= ms;
            }
            steps.entry("decode").or_default().push(decoding);
            steps.entry("waiting and line").or_default().push(rest);
        }
    }
    print!(
        "{:.1} frames/s; input to picture median {:.1} p95 {:.1} max {:.1} ms; width {:.0} to {:.0}, {:.0} kB;",
        latencies.len() as f64 / seconds,
        median(&mut latencies.clone(), 0.5),
        median(&mut latencies.clone(), 0.95),
        median(&mut latencies, 0.9999),
        median(&mut widths.clone(), 0.0),
        median(&mut widths, 0.9999),
        median(&mut bytes_of_frames, 0.5)
    );
    for (step, times) in &mut steps {
        print!(" {step} {:.1}", median(times, 0.5));
    }
    Ok(())
}

fn main() -> Result<()> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [program, seconds, processes, arguments @ ..] = arguments.as_slice() else {
        return Err("usage: page PROGRAM SECONDS PROCESSES VIEW_ARGUMENTS...".into());
    };
    let (mut same, mut all) = (0, 0);
    for _ in 0..processes.parse()? {
        let mut page = Page::open(program, arguments)?;
        let scene = page.text("scene")?;
        let own: PageView = serde_json::from_value(scene["view"].clone())?;
        page.at_rest(&own)?;
        orbit(&mut page, &own, seconds.parse()?)?;
        for angle in [0.1, 0.5] {
            let view = turned(&own, angle);
            let (picture, first) = page.at_rest(&view)?;
            print!(" at rest after {:.1} ms;", first.as_secs_f64() * 1e3);
            page.socket.send(Message::text(r#"{"type":"command"}"#))?;
            let command = page.text("command")?["text"].as_str().unwrap_or_default().to_owned();
            let file = std::env::temp_dir().join(format!("page-{}.png", std::process::id()));
            let command =
                command.replacen("eosphor", program, 1).replace("picture.png", &file.to_string_lossy());
            let is_done = Command::new("sh").args(["-c", &format!("{command} -q")]).status()?.success();
            all += 1;
            same += u32::from(is_done && std::fs::read(&file)? == picture);
            let _ = std::fs::remove_file(&file);
        }
        println!(" {}", scene["backend"].as_str().unwrap_or_default());
    }
    println!("{same} of {all} pictures at rest are the same bytes as those of their command lines");
    Ok(())
}
