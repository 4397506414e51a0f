//! Connections that make no sense, say too much or too little, vanish, or take nothing: whoever behaves gets pictures as before,
//! and memory does not grow. A program of its own: it measures the memory of its process.

#[path = "../page.rs"]
#[allow(dead_code, reason = "the other tests take more of it")]
mod page;

use eosphor::{Backend, CpuBackend, CpuOptions, LoadOptions, load};
use eosphor_viewer::{DeviceChoice, PageView, SceneSource, SourceError, SourceScene, Viewer, ViewerOptions};
use page::{Heard, Page};
use serde_json::{Value, json};
use std::collections::VecDeque;
use std::io::{Read, Write};
use std::net::{SocketAddr, TcpStream};
use std::time::Duration;

/// Connections, unless `EOSPHOR_TEST_ABUSE` says more.
const CONNECTIONS: u32 = 400;

/// Those before them, whose own buffers are in this process, too.
const WARM: u32 = 200;

/// Pages at a time that ask and take nothing.
const SLOW: usize = 20;

/// What memory may have grown by, whatever the number of connections: a factor, and the kilobytes that glibc keeps of large blocks
/// that were freed, in each of its heaps.
const GROWTH: f64 = 1.1;
const KEPT: f64 = 4096.0;

struct Cornell;

impl SceneSource for Cornell {
    fn name(&self) -> String {
        "cornell".into()
    }

    fn read(&self) -> Result<SourceScene, SourceError> {
        let loaded = load("builtin:cornell", &LoadOptions::default());
        let mut scene = loaded.map_err(|error| SourceError(error.to_string()))?.scene;
        (scene.settings.size, scene.settings.samples, scene.settings.light_samples) = ([320, 180], 2, 1);
        Ok(SourceScene { scene, files: Vec::new() })
    }

    fn backend(&self, _: Option<&DeviceChoice>) -> Result<Box<dyn Backend>, SourceError> {
        let options = CpuOptions { threads: Some(2), ..CpuOptions::default() };
        Ok(Box::new(CpuBackend::new(options).map_err(|error| SourceError(error.to_string()))?))
    }

    fn command(&self, flags: Vec<String>) -> String {
        flags.join(" ")
    }
}

/// A page that behaves gets a frame of a new view: in motion, or the picture at rest.
fn gets_a_picture(page: &mut Page, view: &mut PageView, moving: bool) {
    view.camera.eye[0] += 1e-4;
    let input = page.want(view, moving);
    loop {
        if let Heard::Frame(header, _) = page.hear()
            && header["input"] == input
            && (moving || header["format"] == "image/png")
        {
            return;
        }
    }
}

/// Kilobytes that the process has in memory; `None` where that is not known.
fn memory() -> Option<f64> {
    let text = std::fs::read_to_string("/proc/self/statm").ok()?;
    Some(text.split(' ').nth(1)?.parse::<f64>().ok()? * 4.0)
}

struct Abuse {
    address: SocketAddr,
    token: String,
    random: u64,
    slow: VecDeque<TcpStream>,
    view: Value,
}

impl Abuse {
    fn random(&mut self) -> usize {
        self.random =
            self.random.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.random >> 33) as usize
    }

    fn junk(&mut self, most: usize) -> Vec<u8> {
        (0..1 + self.random() % most).map(|_| self.random() as u8).collect()
    }

    /// A connection that has become a WebSocket.
    fn upgraded(&self) -> std::io::Result<TcpStream> {
        let mut stream = TcpStream::connect(self.address)?;
        stream.set_read_timeout(Some(Duration::from_secs(5)))?;
        let (address, port, token) = (self.address, self.address.port(), &self.token);
        write!(
            stream,
            "GET /socket HTTP/1.1\r\nHost: {address}\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n\
             Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\nSec-WebSocket-Version: 13\r\nOrigin: http://{address}\r\n\
             Cookie: eosphor-{port}={token}\r\n\r\n"
        )?;
        let mut byte = [0];
        let mut answer = Vec::new();
        while !answer.ends_with(b"\r\n\r\n") {
            stream.read_exact(&mut byte)?;
            answer.push(byte[0]);
        }
        Ok(stream)
    }

    /// One connection. That the server ends it is an error of no interest.
    fn connection(&mut self) -> std::io::Result<()> {
        let kind = self.random() % 12;
        if kind < 5 {
            let mut stream = TcpStream::connect(self.address)?;
            let address = self.address;
            return match kind {
                0 => stream.write_all(&self.junk(2000)),
                1 => stream.write_all(b"GET / HTTP/1.1\r\nHos"),
                2 => write!(stream, "GET /?token=0123 HTTP/1.1\r\nHost: {address}\r\n\r\n"),
                3 => {
                    write!(
                        stream,
                        "POST /socket HTTP/1.1\r\nHost: {address}\r\nContent-Length: 99999999\r\n\r\n"
                    )?;
                    stream.write_all(&[b'x'; 1000])
                }
                _ => {
                    let length = [9_000, 70_000, 500_000][self.random() % 3];
                    write!(stream, "GET /{} HTTP/1.1\r\n", "a".repeat(length))
                }
            };
        }
        let mut stream = self.upgraded()?;
        match kind {
            5 => stream.write_all(&framed(1, &self.junk(200))),
            6 => stream.write_all(&framed(1, &vec![b'{'; [20_000, 100_000][self.random() % 2]])),
            7 => stream.write_all(&framed(2, &self.junk(50))),
            // Pongs without a ping.
            8 => (0..20).try_for_each(|k| stream.write_all(&framed(10, &[k, 0, 0, 0, 0, 0, 0, 0, k % 2]))),
            9 => stream.write_all(&framed(1, &vec![b'{'; 10_000])[..200]),
            10 => {
                let ask = json!({ "type": "view", "input": 1, "moving": true, "view": self.view });
                stream.write_all(&framed(1, ask.to_string().as_bytes()))?;
                self.slow.push_back(stream);
                if self.slow.len() > SLOW {
                    self.slow.pop_front();
                }
                Ok(())
            }
            _ => Ok(()),
        }
    }
}

/// A message of a page, whose mask is 0.
fn framed(kind: u8, bytes: &[u8]) -> Vec<u8> {
    let mut message = vec![0x80 | kind];
    match bytes.len() {
        length @ ..126 => message.push(0x80 | length as u8),
        length @ ..65_536 => {
            message.push(0x80 | 126);
            message.extend_from_slice(&(length as u16).to_be_bytes());
        }
        length => {
            message.push(0x80 | 127);
            message.extend_from_slice(&(length as u64).to_be_bytes());
        }
    }
    message.extend_from_slice(&[0; 4]);
    message.extend_from_slice(bytes);
    message
}

#[test]
fn abuse_leaves_pictures_and_memory_as_they_were() {
    let count = std::env::var("EOSPHOR_TEST_ABUSE").ok().map_or(CONNECTIONS, |text| text.parse().unwrap());
    let viewer = Viewer::start(Box::new(Cornell), &ViewerOptions::default()).unwrap();
    let (address, token) = (viewer.address(), viewer.token().to_owned());
    let mut page = Page::open(&viewer);
    let mut view = page.scene();
    let asked = serde_json::to_value(view).unwrap();
    let mut gets_a_picture = |moving| gets_a_picture(&mut page, &mut view, moving);
    // As if someone had looked at it for a while.
    (0..60).for_each(|_| gets_a_picture(true));
    (0..5).for_each(|_| gets_a_picture(false));
    let mut abuse = Abuse { address, token, random: 1, slow: VecDeque::new(), view: asked };
    let mut before = None;
    for k in 1..=WARM + count {
        if k == WARM {
            before = memory();
        }
        let _ = abuse.connection();
        if k % 200 == 0 {
            gets_a_picture(false);
        }
    }
    abuse.slow.clear();
    // The server hears of the last ones.
    std::thread::sleep(Duration::from_secs(1));
    gets_a_picture(false);
    if let (Some(before), Some(after)) = (before, memory()) {
        println!("{count} connections: {before:.0} kB before, {after:.0} kB after");
        assert!(after < before * GROWTH + KEPT, "{before} kB before, {after} kB after");
    }
}
