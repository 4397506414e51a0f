//! A viewer and a page as programs.

use eosphor::{
    Backend, CpuBackend, CpuOptions, LoadOptions, Metadata, SaveOptions, Scene, load, render, save,
};
use eosphor_viewer::{
    Device, DeviceChoice, PageView, SceneSource, SourceError, SourceScene, Viewer, ViewerOptions,
};
use serde_json::{Value, json};
use std::io::{Read, Write};
use std::net::{SocketAddr, TcpStream};
use std::path::{Path, PathBuf};
use std::time::Duration;
use tungstenite::client::IntoClientRequest;
use tungstenite::{Message, WebSocket};

/// A scene file, or a built-in scene, of a size and samples that tests have time for.
pub(crate) struct Small(pub(crate) PathBuf);

impl SceneSource for Small {
    fn name(&self) -> String {
        self.0.display().to_string()
    }

    fn read(&self) -> Result<SourceScene, SourceError> {
        let loaded =
            load(&self.0, &LoadOptions::default()).map_err(|error| SourceError(error.to_string()))?;
        let mut scene = loaded.scene;
        (scene.settings.size, scene.settings.samples, scene.settings.light_samples) = ([64, 36], 5, 1);
        Ok(SourceScene { scene, files: loaded.files_read })
    }

    fn backend(&self, choice: Option<&DeviceChoice>) -> Result<Box<dyn Backend>, SourceError> {
        let mut options = CpuOptions { threads: Some(2), ..CpuOptions::default() };
        if let Some(choice) = choice {
            options.accel = choice.accel.parse().map_err(|_| SourceError("no such hierarchy".into()))?;
        }
        Ok(Box::new(CpuBackend::new(options).map_err(|error| SourceError(error.to_string()))?))
    }

    fn devices(&self) -> Vec<Device> {
        vec![Device { backend: "cpu".into(), accels: vec!["bvh8".into(), "octree".into()] }]
    }

    fn command(&self, flags: Vec<String>) -> String {
        format!("eosphor render a.json {}", flags.join(" "))
    }

    fn scene_file(&self, shown: &Scene) -> Result<String, SourceError> {
        let camera = shown.camera_at(0).ok_or_else(|| SourceError("no camera".into()))?;
        Ok(format!("{:?} {:?}", camera, shown.settings))
    }
}

pub(crate) fn start(scene: &Path) -> Viewer {
    Viewer::start(Box::new(Small(scene.to_owned())), &ViewerOptions::default()).unwrap()
}

/// A page, as a program.
pub(crate) struct Page {
    pub(crate) socket: WebSocket<TcpStream>,
    /// The pieces of a picture that have come.
    pieces: Vec<u8>,
    input: u64,
}

/// What came in.
pub(crate) enum Heard {
    Text(Value),
    Frame(Value, Vec<u8>),
}

pub(crate) fn token_of(viewer: &Viewer) -> String {
    viewer.url().split_once("token=").unwrap().1.to_owned()
}

pub(crate) fn connect(
    address: SocketAddr,
    token: &str,
    headers: &[(&'static str, &str)],
) -> Result<Page, String> {
    let mut request = format!("ws://{address}/socket").into_client_request().unwrap();
    let cookie = format!("eosphor-{}={token}", address.port());
    let origin = format!("http://{address}");
    let usual = [("cookie", cookie.as_str()), ("origin", origin.as_str())];
    for (name, value) in usual.iter().chain(headers) {
        request.headers_mut().insert(*name, value.parse().unwrap());
    }
    let stream = TcpStream::connect(address).map_err(|error| error.to_string())?;
    stream.set_read_timeout(Some(Duration::from_secs(60))).unwrap();
    let (socket, _) = tungstenite::client(request, stream).map_err(|error| error.to_string())?;
    Ok(Page { socket, pieces: Vec::new(), input: 0 })
}

impl Page {
    pub(crate) fn open(viewer: &Viewer) -> Page {
        connect(viewer.address(), &token_of(viewer), &[]).unwrap()
    }

    pub(crate) fn say(&mut self, message: Value) {
        self.socket.send(Message::text(message.to_string())).unwrap();
    }

    pub(crate) fn want(&mut self, view: &PageView, moving: bool) -> u64 {
        self.input += 1;
        let input = self.input;
        self.say(json!({ "type": "view", "input": input, "moving": moving, "view": view }));
        input
    }

    pub(crate) fn hear(&mut self) -> Heard {
        loop {
            match self.socket.read().unwrap() {
                Message::Text(text) => return Heard::Text(serde_json::from_str(&text).unwrap()),
                Message::Binary(bytes) => {
                    let length = u32::from_le_bytes(bytes[..4].try_into().unwrap()) as usize;
                    let header: Value = serde_json::from_slice(&bytes[4..4 + length]).unwrap();
                    self.say(json!({ "type": "ack", "frame": header["frame"] }));
                    if header["piece"][0] == 0 {
                        self.pieces.clear();
                    }
                    self.pieces.extend_from_slice(&bytes[4 + length..]);
                    if header["piece"][0].as_u64().unwrap() + 1 == header["piece"][1].as_u64().unwrap() {
                        return Heard::Frame(header, std::mem::take(&mut self.pieces));
                    }
                }
                _ => {}
            }
        }
    }

    /// The next text of a kind; frames pass by.
    pub(crate) fn text(&mut self, kind: &str) -> Value {
        loop {
            if let Heard::Text(text) = self.hear()
                && text["type"] == kind
            {
                return text;
            }
        }
    }

    /// The picture at rest that shows this input, and the sample counts of the frames before it.
    pub(crate) fn at_rest(&mut self, input: u64) -> (Vec<u8>, Vec<u64>) {
        let mut samples = Vec::new();
        loop {
            let Heard::Frame(header, bytes) = self.hear() else { continue };
            if header["input"] != input || header["at-rest"] != true {
                continue;
            }
            samples.push(header["samples"].as_u64().unwrap());
            if header["format"] == "image/png" {
                return (bytes, samples);
            }
        }
    }

    pub(crate) fn scene(&mut self) -> PageView {
        serde_json::from_value(self.text("scene")["view"].clone()).unwrap()
    }
}

/// The file of a scene as `render --no-metadata` writes it.
pub(crate) fn file_of(scene: &Scene) -> Vec<u8> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.png");
    let backend = CpuBackend::new(CpuOptions { threads: Some(2), ..CpuOptions::default() }).unwrap();
    let film = render(scene, &backend).unwrap().film;
    let options = SaveOptions { metadata: Metadata::default(), ..SaveOptions::from(&scene.settings) };
    save(&film, &path, &options).unwrap();
    std::fs::read(&path).unwrap()
}

/// What a server answers to a request of a page with its cookie: the head, and the contents.
pub(crate) fn get(viewer: &Viewer, path: &str) -> (String, Vec<u8>) {
    let address = viewer.address();
    let cookie = format!("eosphor-{}={}", address.port(), token_of(viewer));
    let mut stream = TcpStream::connect(address).unwrap();
    let head = format!("Host: {address}\r\nConnection: close\r\nCookie: {cookie}");
    write!(stream, "GET {path} HTTP/1.1\r\n{head}\r\n\r\n").unwrap();
    let mut answer = Vec::new();
    stream.read_to_end(&mut answer).unwrap();
    let end = answer.windows(4).position(|four| four == b"\r\n\r\n").unwrap();
    let contents = answer.split_off(end + 4);
    (String::from_utf8(answer).unwrap(), contents)
}
