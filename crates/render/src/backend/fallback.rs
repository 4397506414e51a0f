//! A backend with another one in reserve.

use super::{
    Backend, BackendError, PreparedScene, RenderControl, Rendered, RenderedBytes, Sampled, StageWork,
};
use crate::{DevelopSettings, Hierarchy, HierarchyStatistics, Region};
use eosphor_scene::SceneData;
use std::ops::Range;
use std::sync::{Arc, Mutex, MutexGuard, OnceLock, PoisonError};

/// Makes the backend in reserve.
type Reserve = dyn Fn() -> Result<Box<dyn Backend>, BackendError> + Send + Sync;

/// Told why the first backend is left.
type Tell = dyn Fn(&BackendError) + Send + Sync;

/// Renders with one backend, and with another from where that one fails: a device that is too small, or lost in the middle of
/// a picture. All give the same bits, so nobody sees it in the picture; `tell` is told.
pub struct Fallback {
    first: Box<dyn Backend>,
    reserve: Arc<Reserve>,
    tell: Arc<Tell>,
    /// What the reserve says that it is, once it is in use.
    went_over: Arc<OnceLock<String>>,
}

impl Fallback {
    /// The backend in reserve is made when it is needed.
    pub fn new(
        first: Box<dyn Backend>,
        reserve: impl Fn() -> Result<Box<dyn Backend>, BackendError> + Send + Sync + 'static,
        tell: impl Fn(&BackendError) + Send + Sync + 'static,
    ) -> Fallback {
        Fallback { first, reserve: Arc::new(reserve), tell: Arc::new(tell), went_over: Arc::default() }
    }
}

impl Backend for Fallback {
    fn describe(&self) -> String {
        match self.went_over.get() {
            Some(reserve) => format!("{}, then {reserve}", self.first.describe()),
            None => self.first.describe(),
        }
    }

    fn prepare(&self, scene: Arc<SceneData>) -> Result<Box<dyn PreparedScene>, BackendError> {
        let (prepared, in_use) = match self.first.prepare(Arc::clone(&scene)) {
            Ok(prepared) => (prepared, InUse::First),
            Err(error) => {
                (self.tell)(&error);
                (prepare_reserve(&*self.reserve, &scene, &self.went_over)?, InUse::Reserve)
            }
        };
        let (reserve, tell) = (Arc::clone(&self.reserve), Arc::clone(&self.tell));
        let went_over = Arc::clone(&self.went_over);
        let size = prepared.size();
        let state = Mutex::new(State { prepared: Arc::from(prepared), in_use });
        Ok(Box::new(PreparedFallback { scene, size, state, reserve, tell, went_over }))
    }
}

fn prepare_reserve(
    reserve: &Reserve,
    scene: &Arc<SceneData>,
    went_over: &OnceLock<String>,
) -> Result<Box<dyn PreparedScene>, BackendError> {
    let backend = reserve()?;
    went_over.get_or_init(|| backend.describe());
    backend.prepare(Arc::clone(scene))
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum InUse {
    First,
    Reserve,
}

struct State {
    prepared: Arc<dyn PreparedScene>,
    in_use: InUse,
}

struct PreparedFallback {
    scene: Arc<SceneData>,
    size: (u32, u32),
    state: Mutex<State>,
    reserve: Arc<Reserve>,
    tell: Arc<Tell>,
    went_over: Arc<OnceLock<String>>,
}

impl PreparedFallback {
    fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn prepared(&self) -> Arc<dyn PreparedScene> {
        Arc::clone(&self.state().prepared)
    }

    /// Does something, and again with the reserve where the first backend fails: rows that were lost are rendered again.
    fn with_reserve<T>(
        &self,
        work: impl Fn(&dyn PreparedScene) -> Result<T, BackendError>,
    ) -> Result<T, BackendError> {
        let (prepared, in_use) = {
            let state = self.state();
            (Arc::clone(&state.prepared), state.in_use)
        };
        match work(&*prepared) {
            Err(error) if in_use == InUse::First => work(&*self.go_over(&error)?),
            result => result,
        }
    }

    /// Goes over to the reserve; others who fail at the same time wait here and find it done.
    fn go_over(&self, error: &BackendError) -> Result<Arc<dyn PreparedScene>, BackendError> {
        let mut state = self.state();
        if state.in_use == InUse::First {
            (self.tell)(error);
            state.prepared = Arc::from(prepare_reserve(&*self.reserve, &self.scene, &self.went_over)?);
            state.in_use = InUse::Reserve;
        }
        Ok(Arc::clone(&state.prepared))
    }
}

impl PreparedScene for PreparedFallback {
    fn hierarchy_statistics(&self) -> HierarchyStatistics {
        self.prepared().hierarchy_statistics()
    }

    fn hierarchy(&self) -> Option<Arc<Hierarchy>> {
        self.prepared().hierarchy()
    }

    fn size(&self) -> (u32, u32) {
        self.size
    }

    fn samples(&self) -> u32 {
        self.scene.settings.samples
    }

    fn pixels_at_a_time(&self) -> u64 {
        self.prepared().pixels_at_a_time()
    }

    fn render_rows(&self, rows: Range<u32>, control: &RenderControl) -> Result<Rendered, BackendError> {
        self.with_reserve(|prepared| prepared.render_rows(rows.clone(), control))
    }

    fn stages(&self, control: &RenderControl) -> Result<Vec<StageWork>, BackendError> {
        self.with_reserve(|prepared| prepared.stages(control))
    }

    fn sample_rows(
        &self,
        rows: Range<u32>,
        samples: Range<u32>,
        control: &RenderControl,
    ) -> Result<Sampled, BackendError> {
        self.with_reserve(|prepared| prepared.sample_rows(rows.clone(), samples.clone(), control))
    }

    fn sample_region(
        &self,
        region: &Region,
        samples: Range<u32>,
        control: &RenderControl,
    ) -> Result<Sampled, BackendError> {
        self.with_reserve(|prepared| prepared.sample_region(region, samples.clone(), control))
    }

    fn render_developed(
        &self,
        develop: &DevelopSettings,
        control: &RenderControl,
    ) -> Result<RenderedBytes, BackendError> {
        self.with_reserve(|prepared| prepared.render_developed(develop, control))
    }
}
