//! The scene on show: read, flattened, prepared on the backend. When files change it is replaced as a whole.

use crate::page_view::PageView;
use crate::source::{SceneSource, SourceError};
use eosphor::{
    Backend, FrameBounds, FrameState, FrameStates, PreparedScene, RenderSettings, Scene, SceneData,
    SceneError,
};
use std::path::PathBuf;
use std::sync::Arc;

/// A scene that is ready to be rendered.
pub(crate) struct Stage {
    /// Counts the scenes that were put on show, from 1.
    pub(crate) version: u64,
    pub(crate) scene: Scene,
    /// The view of the file.
    pub(crate) own: PageView,
    /// For how far the camera moves: half the diagonal of the scene's box, in world units.
    pub(crate) radius: f32,
    /// The middle of that box, in coordinates of the file.
    pub(crate) center: [f64; 3],
    pub(crate) files: Vec<PathBuf>,
    data: Arc<SceneData>,
    bounds: FrameBounds,
    pub(crate) prepared: Box<dyn PreparedScene>,
}

/// Light samples of frames while the camera moves: enough to see where shadows are.
const MOVING_LIGHT_SAMPLES: u32 = 2;

impl Stage {
    /// Reads the scene and prepares it.
    ///
    /// # Errors
    ///
    /// What is wrong with the files, or with the device.
    pub(crate) fn open(
        source: &dyn SceneSource,
        backend: &dyn Backend,
        version: u64,
    ) -> Result<Stage, SourceError> {
        let read = source.read()?;
        let said = |error: SceneError| SourceError(error.to_string());
        let (data, _) = SceneData::flatten(&read.scene).map_err(said)?;
        let data = Arc::new(data);
        let prepared = backend.prepare(Arc::clone(&data)).map_err(|error| SourceError(error.to_string()))?;
        let own = PageView::of(&read.scene).map_err(said)?;
        let bounds = FrameBounds::new(&read.scene, &data);
        let radius = bounds.radius();
        let radius = if radius > 0.0 { radius } else { 1.0 };
        let center = read.scene.point_in_file(bounds.center());
        Ok(Stage {
            version,
            scene: read.scene,
            own,
            radius,
            center,
            files: read.files,
            data,
            bounds,
            prepared,
        })
    }

    /// The number of triangles that were read.
    pub(crate) fn triangles(&self) -> usize {
        self.data.triangles.len()
    }

    /// The frame of a view at rest, and the settings that it is developed with.
    ///
    /// # Errors
    ///
    /// Where the camera spans no view.
    pub(crate) fn at_rest(&self, view: &PageView) -> Result<(FrameState, RenderSettings), SceneError> {
        let (camera, settings) = view.applied(&self.scene, &self.own);
        let states = FrameStates::with_bounds(&self.scene, &self.data, &self.bounds);
        Ok((states.seen_by(0, Some(&camera), &settings)?, settings))
    }

    /// The same for a frame while the camera moves, of this size, with one sample a pixel.
    ///
    /// # Errors
    ///
    /// Where the camera spans no view.
    pub(crate) fn moving(
        &self,
        view: &PageView,
        size: [u32; 2],
    ) -> Result<(FrameState, RenderSettings), SceneError> {
        let (camera, mut settings) = view.applied(&self.scene, &self.own);
        (settings.size, settings.samples) = (size, 1);
        settings.pixel_sampling = eosphor::PixelSampling::Random;
        settings.light_samples = settings.light_samples.min(MOVING_LIGHT_SAMPLES);
        let states = FrameStates::with_bounds(&self.scene, &self.data, &self.bounds);
        Ok((states.seen_by(0, Some(&camera), &settings)?, settings))
    }
}
