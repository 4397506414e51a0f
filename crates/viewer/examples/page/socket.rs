//! What a page has: a socket to a viewer, and when it sent what.

use crate::Result;
use eosphor_viewer::PageView;
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::io::{Read, Write};
use std::net::TcpStream;
use std::time::{Duration, Instant};
use tungstenite::client::IntoClientRequest;
use tungstenite::{Message, WebSocket};

pub(crate) struct Page {
    pub(crate) socket: WebSocket<TcpStream>,
    address: String,
    cookie: String,
    /// The number that the viewer knows it by.
    number: Value,
    /// The pieces of a picture that have come.
    pieces: Vec<u8>,
    input: u64,
    sent: BTreeMap<u64, Instant>,
}

/// What came in: a text, or a frame with its picture.
pub(crate) enum Heard {
    Nothing,
    Text(Value),
    Frame(Value, Vec<u8>),
}

impl Page {
    /// Connects to the viewer at the address that it has printed.
    pub(crate) fn connect(url: &str) -> Result<Page> {
        let (address, token) =
            url.trim().strip_prefix("http://").and_then(|u| u.split_once("/?token=")).ok_or("no address")?;
        let port = address.rsplit(':').next().unwrap_or_default();
        let mut request = format!("ws://{address}/socket").into_client_request()?;
        let cookie = format!("eosphor-{port}={token}");
        request.headers_mut().insert("cookie", cookie.parse()?);
        request.headers_mut().insert("origin", format!("http://{address}").parse()?);
        let stream = TcpStream::connect(address)?;
        stream.set_nodelay(true)?;
        let (mut socket, _) = tungstenite::client(request, stream)?;
        // For measuring JPEGs on slow lines: without this they are what comes.
        let h264 = std::env::var_os("EOSPHOR_PAGE_JPEG").is_none();
        socket.send(Message::text(json!({ "type": "decodes", "h264": h264 }).to_string()))?;
        let address = address.to_owned();
        Ok(Page {
            socket,
            address,
            cookie,
            number: Value::Null,
            pieces: Vec::new(),
            input: 0,
            sent: BTreeMap::new(),
        })
    }

    pub(crate) fn want(&mut self, view: &PageView, moving: bool) -> Result<u64> {
        self.input += 1;
        let message = json!({ "type": "view", "input": self.input, "moving": moving, "view": view });
        self.sent.insert(self.input, Instant::now());
        self.socket.send(Message::text(message.to_string()))?;
        Ok(self.input)
    }

    /// Waits until then for something to come in.
    pub(crate) fn hear(&mut self, until: Instant) -> Result<Heard> {
        let left = until.saturating_duration_since(Instant::now()).max(Duration::from_micros(100));
        self.socket.get_ref().set_read_timeout(Some(left))?;
        match self.socket.read() {
            Ok(Message::Text(text)) => Ok(Heard::Text(serde_json::from_str(&text)?)),
            Ok(Message::Binary(bytes)) => {
                let length = u32::from_le_bytes(bytes[..4].try_into()?) as usize;
                let header: Value = serde_json::from_slice(&bytes[4..4 + length])?;
                if header["piece"][0] == 0 {
                    self.pieces.clear();
                }
                self.pieces.extend_from_slice(&bytes[4 + length..]);
                if header["piece"][0].as_u64().map(|piece| piece + 1) < header["piece"][1].as_u64() {
                    let answer = json!({ "type": "ack", "frame": header["frame"] });
                    self.socket.send(Message::text(answer.to_string()))?;
                    return Ok(Heard::Nothing);
                }
                Ok(Heard::Frame(header, std::mem::take(&mut self.pieces)))
            }
            // Browsers answer pings at once, whatever the page does.
            Ok(Message::Ping(_)) => {
                self.socket.flush()?;
                Ok(Heard::Nothing)
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
    pub(crate) fn drawn(&mut self, header: &Value) -> Result<Option<Duration>> {
        self.socket.send(Message::text(json!({ "type": "ack", "frame": header["frame"] }).to_string()))?;
        let input = header["input"].as_u64().unwrap_or_default();
        let took = self.sent.get(&input).map(Instant::elapsed);
        self.sent = self.sent.split_off(&(input + 1));
        Ok(took)
    }

    pub(crate) fn text(&mut self, kind: &str) -> Result<Value> {
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

    /// The scene on show: what the server says first.
    pub(crate) fn scene(&mut self) -> Result<(Value, PageView)> {
        let scene = self.text("scene")?;
        let own = serde_json::from_value(scene["view"].clone())?;
        self.number = scene["page"].clone();
        Ok((scene, own))
    }

    /// The file that is offered at a path for what this page shows.
    pub(crate) fn download(&self, path: &str) -> Result<Vec<u8>> {
        let (address, cookie, number) = (&self.address, &self.cookie, &self.number);
        let mut stream = TcpStream::connect(address)?;
        write!(
            stream,
            "GET {path}?page={number} HTTP/1.1\r\nHost: {address}\r\nCookie: {cookie}\r\nConnection: close\r\n\r\n"
        )?;
        let mut answer = Vec::new();
        stream.read_to_end(&mut answer)?;
        let end = answer.windows(4).position(|four| four == b"\r\n\r\n").ok_or("an answer without a body")?;
        let body = answer.split_off(end + 4);
        match answer.starts_with(b"HTTP/1.1 200 ") {
            true => Ok(body),
            false => Err(String::from_utf8_lossy(&body).into()),
        }
    }

    /// The picture at rest; and how long the first frame at rest took.
    pub(crate) fn at_rest(&mut self, view: &PageView) -> Result<(Vec<u8>, Duration)> {
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
