//! Backends: who turns a scene into a film. All give the same bits.

mod fallback;

pub use fallback::Fallback;

mod bytes;
mod region;
mod stages;

pub use bytes::RenderedBytes;
pub(crate) use region::check_region;
pub use region::{PreparedRegion, Region};
pub use stages::StageWork;

use crate::{DevelopSettings, Film, Hierarchy, HierarchyStatistics, RayStatistics, SampleSums};
use eosphor_scene::{FrameState, SceneData};
use region::sample_whole_rows;
use std::ops::Range;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

/// A device, or all cores of the CPU.
pub trait Backend: Send + Sync {
    /// For messages: what it runs on.
    fn describe(&self) -> String;

    /// How many frames of an animation to have in work at the same time, so that it never waits for one to be developed and
    /// written: one is rendered, one developed and written, one begun.
    fn frames_in_flight(&self) -> usize {
        3
    }

    /// Builds the hierarchy and whatever else the device needs.
    fn prepare(&self, scene: Arc<SceneData>) -> Result<Box<dyn PreparedScene>, BackendError>;
}

/// A scene that is ready to be rendered.
pub trait PreparedScene: Send + Sync {
    /// The hierarchy in numbers.
    fn hierarchy_statistics(&self) -> HierarchyStatistics;

    /// The hierarchy itself, where it is in the memory of the CPU.
    fn hierarchy(&self) -> Option<Arc<Hierarchy>>;

    /// Width and height of the picture in pixels, where a frame does not say otherwise ([`RenderControl::size_of`]).
    fn size(&self) -> (u32, u32);

    /// Samples of a pixel, where a frame does not say otherwise ([`RenderControl::samples_of`]).
    fn samples(&self) -> u32;

    /// How many pixels keep all of it busy: who asks for rows in pieces asks for no fewer.
    fn pixels_at_a_time(&self) -> u64;

    /// Told before a frame of an animation how many will be begun after it. Who shares out work can make the last shares small.
    fn frames_left(&self, _frames: usize) {}

    /// Renders some rows of the picture. The film is as high as there are rows, and its pixels are those of the whole
    /// picture, bit for bit. If [`RenderControl::cancel`] is raised, the call returns soon with what is done.
    ///
    /// Pictures that do not fit in memory are rendered band by band ([`crate::Bands`]).
    ///
    /// # Errors
    ///
    /// [`BackendError::Failed`] if there are no rows or some are not in the picture, and all errors of the device.
    fn render_rows(&self, rows: Range<u32>, control: &RenderControl) -> Result<Rendered, BackendError>;

    /// Takes some samples of each pixel of some rows. Sums of samples are exact, so those of several calls may be added in any
    /// order ([`SampleSums::add`]), and all samples of a picture, however they were shared out, make the film that
    /// [`PreparedScene::render_rows`] does ([`SampleSums::film`]).
    ///
    /// # Errors
    ///
    /// As of [`PreparedScene::render_rows`]; also where the samples are none or not among [`PreparedScene::samples`].
    fn sample_rows(
        &self,
        rows: Range<u32>,
        samples: Range<u32>,
        control: &RenderControl,
    ) -> Result<Sampled, BackendError>;

    /// As [`PreparedScene::sample_rows`], of a part of the picture. Devices that know rows only take samples of all pixels of
    /// its rows.
    ///
    /// # Errors
    ///
    /// As of [`PreparedScene::sample_rows`].
    fn sample_region(
        &self,
        region: &Region,
        samples: Range<u32>,
        control: &RenderControl,
    ) -> Result<Sampled, BackendError> {
        sample_whole_rows(self, region, samples, control)
    }

    /// Renders the whole picture, as [`PreparedScene::render_rows`] does.
    fn render(&self, control: &RenderControl) -> Result<Rendered, BackendError> {
        self.render_rows(0..control.size_of(self).1, control)
    }

    /// Renders the whole picture, and says what each stage of that took. Each is waited for, so all together take longer than they
    /// do otherwise. None where pictures are not made in stages.
    ///
    /// # Errors
    ///
    /// As of [`PreparedScene::render_rows`].
    fn stages(&self, _control: &RenderControl) -> Result<Vec<StageWork>, BackendError> {
        Ok(Vec::new())
    }

    /// Renders the whole picture where only its bytes are wanted, and the linear film is not: devices with a memory of their own
    /// may develop it there and send back a quarter. The bytes are those of the film, whoever makes them.
    ///
    /// # Errors
    ///
    /// As of [`PreparedScene::render_rows`].
    fn render_developed(
        &self,
        develop: &DevelopSettings,
        control: &RenderControl,
    ) -> Result<RenderedBytes, BackendError> {
        Ok(RenderedBytes::of_film(self.render(control)?, *develop))
    }
}

/// What every backend asks before it renders some rows.
pub fn check_rows(rows: &Range<u32>, height: u32) -> Result<(), BackendError> {
    match rows.start < rows.end && rows.end <= height {
        true => Ok(()),
        false => Err(BackendError::Failed(format!(
            "rows {} to {} are asked for, and the picture has {height}",
            rows.start, rows.end
        ))),
    }
}

/// What every backend asks before it takes some samples.
pub fn check_samples(samples: &Range<u32>, all: u32) -> Result<(), BackendError> {
    match samples.start < samples.end && samples.end <= all {
        true => Ok(()),
        false => Err(BackendError::Failed(format!(
            "samples {} to {} are asked for, and a pixel has {all}",
            samples.start, samples.end
        ))),
    }
}

/// How far a render is. All numbers are of the rows that were asked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Progress {
    /// Pixels finished.
    pub pixels_done: u64,
    /// Pixels to be rendered.
    pub pixels_total: u64,
    /// Rays traced so far.
    pub rays: u64,
}

/// How a render is watched and stopped.
pub struct RenderControl<'a> {
    /// Called now and then, from any thread.
    pub on_progress: &'a (dyn Fn(Progress) + Sync),
    /// When raised, the render ends early.
    pub cancel: &'a AtomicBool,
    /// Count what queries do and time it ([`RayStatistics`]). Rays are then traced one by one and clocks are read often, which
    /// takes a few times as long and changes no pixel. A GPU has kernels of their own for that: its backend is made for it.
    pub count_work: bool,
    /// State of the frame to render; `None`: the scene as it was prepared. It may have another size and other samples.
    pub frame: Option<&'a FrameState>,
}

impl RenderControl<'_> {
    /// Width and height in pixels of what is rendered.
    pub fn size_of<P: PreparedScene + ?Sized>(&self, prepared: &P) -> (u32, u32) {
        self.frame.map_or_else(|| prepared.size(), |frame| (frame.settings.width, frame.settings.height))
    }

    /// Samples of each pixel of what is rendered.
    pub fn samples_of<P: PreparedScene + ?Sized>(&self, prepared: &P) -> u32 {
        self.frame.map_or_else(|| prepared.samples(), |frame| frame.settings.samples)
    }
}

/// What a render gives back.
#[derive(Clone, Debug)]
pub struct Rendered {
    /// The picture, or the rows of it that were asked for; pixels that were not reached are black.
    pub film: Film,
    /// False where the render was cancelled before its end.
    pub complete: bool,
    /// Rays traced, and the work on them where it was counted.
    pub statistics: RayStatistics,
}

/// Some samples of some rows.
#[derive(Clone, Debug)]
pub struct Sampled {
    /// Their sums; where it is not complete, pixels that were not reached are 0.
    pub sums: SampleSums,
    /// False where it was cancelled before its end.
    pub complete: bool,
    /// Rays traced, and the work on them where it was counted.
    pub statistics: RayStatistics,
}

/// Why a backend failed.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum BackendError {
    /// The device is not there, or its driver.
    #[error("{0}")]
    Unavailable(String),
    /// The scene or the film does not fit.
    #[error("{0}")]
    OutOfMemory(String),
    /// Anything else.
    #[error("{0}")]
    Failed(String),
}
