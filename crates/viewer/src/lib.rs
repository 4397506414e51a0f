//! The viewer: a scene in a browser, rendered by the machine that this runs on.
//!
//! [`Viewer::start`] serves a page on a port of this machine. The page sends where its camera is and which settings it has;
//! frames come back over a WebSocket. While the camera moves they are JPEGs, or H.264 on slow lines, of a resolution that can be
//! rendered and sent in time; when it rests, samples are added up, and the last frame is a PNG: the same bytes as the file that
//! `eosphor render` writes for that view.
//!
//! The way of a frame: [`PageView`] (what the page wants) → `Stage` (the scene, prepared on a backend) → the renderer's thread →
//! JPEG, H.264 or PNG → `Client` → the page. The renderer has a thread of its own, and so has the server: neither a frame waits for
//! a socket, nor a socket for a frame.
#![warn(missing_docs)]

mod client;
mod encode;
mod export;
mod false_colors;
mod frames;
#[cfg(fuzzing)]
mod fuzzed;
mod hover;
mod message;
mod page_view;
mod pixel;
mod progress;
mod quality;
mod renderer;
mod server;
mod source;
mod stage;
mod video;
mod video_quality;
mod viewer;
mod watch;

#[cfg(fuzzing)]
pub use fuzzed::fuzz_message;
pub use page_view::{PageCamera, PageView, Show};
pub use source::{Device, DeviceChoice, SceneSource, SourceError, SourceScene};
pub use viewer::{Viewer, ViewerError, ViewerOptions};
