//! Whole jobs: from a scene to its files, with all that happens on the way.
//!
//! A [`Still`] is a picture, a part or a share of one, and [`merge`] makes a picture of shares. A [`Sequence`] is frames of an
//! animation, as numbered files or as one video. A [`CostPicture`] shows what the rays of each pixel cost. What is done of a
//! still or a sequence is kept, and the same goes on from there.
//!
//! A job renders on the [`crate::Backend`] that it is given, is watched and stopped by a [`JobControl`], fails with a
//! [`JobError`] and ends with an outcome. Nothing here prints, ends the process or waits for signals: who wants a line, a bar or
//! Ctrl-C has the callbacks and [`Cancel`].
//!
//! ```
//! use eosphor::job::{JobControl, Still};
//! use eosphor::{CpuBackend, CpuOptions, LoadOptions, load};
//!
//! let mut scene = load("builtin:cornell", &LoadOptions::default())?.scene;
//! scene.settings.size = [64, 48];
//! let backend = CpuBackend::new(CpuOptions::default())?;
//! let folder = tempfile::tempdir()?;
//! let mut still = Still::new(&scene, &backend).to_file(&folder.path().join("cornell.png"))?;
//! still.resume = true;
//! let outcome = still.run(&JobControl {
//!     on_progress: &|progress| println!("{} of {} pixels", progress.pixels_done, progress.pixels_total),
//!     ..JobControl::default()
//! })?;
//! assert!(outcome.complete && outcome.kept.is_none());
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod cancel;
mod control;
mod cost;
mod error;
mod file_options;
mod files;
mod frame_files;
mod frames;
mod memory;
mod merge;
mod output;
mod seconds;
mod sequence;
mod share;
mod still;
mod strips;
#[cfg(feature = "video")]
mod video;

pub use cancel::Cancel;
pub use control::{Event, JobControl};
pub use cost::{CostOutcome, CostPicture};
pub use error::JobError;
pub use file_options::FileOptions;
pub use files::{check_output, check_sources, make_folder, same_file};
pub use frame_files::FrameNames;
pub use frames::FrameDone;
pub use memory::{bytes_in_words, memory_for_textures};
pub use merge::merge;
pub use output::{Output, check_apart, check_writable};
pub use seconds::{StillSeconds, process_cpu_seconds};
pub use sequence::{MadeFrom, Sequence, SequenceOutcome};
pub use share::Share;
pub use still::{Still, StillOutcome};
#[cfg(feature = "video")]
pub use video::Video;
