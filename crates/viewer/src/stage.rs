//! The scene on show: read, flattened, prepared on the backend. When files change it is replaced as a whole.

use crate::page_view::PageView;
use crate::source::{DeviceChoice, SceneSource, SourceError};
use eosphor::{
    Backend, BackendError, Camera, CpuBackend, CpuOptions, FeaturePass, FrameBounds, FrameState, FrameStates,
    PreparedScene, RenderSettings, Scene, SceneData, SceneError,
};
use std::path::PathBuf;
use std::sync::{Arc, Mutex, PoisonError};

/// A scene that is ready to be rendered.
pub(crate) struct Stage {
    /// Counts the scenes that were put on show, from 1.
    pub(crate) version: u64,
    pub(crate) scene: Arc<Scene>,
    /// The view of the file.
    pub(crate) own: PageView,
    /// For how far the camera moves: half the diagonal of the scene's box, in world units.
    pub(crate) radius: f32,
    /// The middle of that box, in coordinates of the file.
    pub(crate) center: [f64; 3],
    pub(crate) files: Vec<PathBuf>,
    /// Which device and hierarchy were chosen for it; `None`: those of the start.
    pub(crate) device: Option<DeviceChoice>,
    data: Arc<SceneData>,
    bounds: FrameBounds,
    pub(crate) prepared: Box<dyn PreparedScene>,
    cpu_options: CpuOptions,
    /// Made when it is first asked for.
    features: Mutex<Option<Arc<FeaturePass>>>,
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
        device: Option<DeviceChoice>,
        backend: &dyn Backend,
        version: u64,
    ) -> Result<Stage, SourceError> {
        let read = source.read()?;
        let said = |error: SceneError| SourceError(error.to_string());
        let (data, _) = SceneData::flatten(&read.scene).map_err(said)?;
        let data = Arc::new(data);
        let prepared = prepare(backend, &data)?;
        let own = PageView::of(&read.scene).map_err(said)?;
        let bounds = FrameBounds::new(&read.scene, &data);
        let radius = bounds.radius();
        let radius = if radius > 0.0 { radius } else { 1.0 };
        let center = read.scene.point_in_file(bounds.center());
        Ok(Stage {
            version,
            scene: Arc::new(read.scene),
            own,
            radius,
            center,
            files: read.files,
            cpu_options: source.cpu_options(device.as_ref()),
            device,
            data,
            bounds,
            prepared,
            features: Mutex::default(),
        })
    }

    /// The same scene on another device, or through another hierarchy.
    ///
    /// # Errors
    ///
    /// Where the device has no room for it.
    pub(crate) fn on(
        &self,
        source: &dyn SceneSource,
        device: DeviceChoice,
        backend: &dyn Backend,
    ) -> Result<Stage, SourceError> {
        Ok(Stage {
            version: self.version + 1,
            scene: Arc::clone(&self.scene),
            files: self.files.clone(),
            cpu_options: source.cpu_options(Some(&device)),
            device: Some(device),
            data: Arc::clone(&self.data),
            bounds: self.bounds.clone(),
            prepared: prepare(backend, &self.data)?,
            features: Mutex::default(),
            ..*self
        })
    }

    /// What finds the first hits of camera rays. On another device than the CPU a hierarchy is built for it.
    ///
    /// # Errors
    ///
    /// Where the CPU's threads cannot be started.
    pub(crate) fn features(&self) -> Result<Arc<FeaturePass>, BackendError> {
        let mut features = self.features.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(pass) = &*features {
            return Ok(Arc::clone(pass));
        }
        let options = self.cpu_options;
        // Costs are those of the CPU's hierarchy.
        let is_same = self.prepared.hierarchy_statistics().structure == options.accel.name();
        let hierarchy = self.prepared.hierarchy().filter(|_| is_same);
        let pass = Arc::new(CpuBackend::new(options)?.feature_pass(Arc::clone(&self.data), hierarchy)?);
        *features = Some(Arc::clone(&pass));
        Ok(pass)
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
        Ok((self.state(view, &camera, &settings)?, settings))
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
        Ok((self.state(view, &camera, &settings)?, settings))
    }

    fn state(
        &self,
        view: &PageView,
        camera: &Camera,
        settings: &RenderSettings,
    ) -> Result<FrameState, SceneError> {
        let states = FrameStates::with_bounds(&self.scene, &self.data, &self.bounds);
        states.seen_by(view.frame, Some(camera), settings)
    }

    /// Names of an object and a material, where they have any.
    pub(crate) fn names(&self, object: u32, material: u32) -> [Option<String>; 2] {
        let mesh =
            self.scene.instances.get(object as usize).and_then(|i| self.scene.meshes.get(i.mesh as usize));
        let material = self.scene.materials.get(material as usize);
        let named = |name: &String| (!name.is_empty()).then(|| name.clone());
        [mesh.and_then(|mesh| named(&mesh.name)), material.and_then(|material| named(&material.name))]
    }
}

fn prepare(backend: &dyn Backend, data: &Arc<SceneData>) -> Result<Box<dyn PreparedScene>, SourceError> {
    backend.prepare(Arc::clone(data)).map_err(|error| SourceError(error.to_string()))
}
