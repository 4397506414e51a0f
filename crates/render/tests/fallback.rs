//! A backend with another one in reserve. (Inside the crate, tests that render have all that renders compiled once more.)

use eosphor_render::{
    Backend, BackendError, CpuBackend, CpuOptions, DevelopSettings, Developed, Fallback, Hierarchy,
    HierarchyStatistics, PreparedScene, RenderControl, Rendered, Sampled,
};
use eosphor_scene::{LoadOptions, SceneData, load};
use std::ops::Range;
use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};
use std::sync::{Arc, Mutex};

/// Works until it has rendered some rows, if it ever does.
struct Failing {
    prepares: bool,
    rows_left: u32,
}

struct PreparedFailing {
    cpu: Box<dyn PreparedScene>,
    rows_left: AtomicU32,
}

impl Backend for Failing {
    fn describe(&self) -> String {
        "failing".into()
    }

    fn prepare(&self, scene: Arc<SceneData>) -> Result<Box<dyn PreparedScene>, BackendError> {
        if !self.prepares {
            return Err(BackendError::OutOfMemory("too large".into()));
        }
        let cpu = cpu()?.prepare(scene)?;
        Ok(Box::new(PreparedFailing { cpu, rows_left: AtomicU32::new(self.rows_left) }))
    }
}

impl PreparedScene for PreparedFailing {
    fn hierarchy_statistics(&self) -> HierarchyStatistics {
        self.cpu.hierarchy_statistics()
    }
    fn hierarchy(&self) -> Option<Arc<Hierarchy>> {
        None
    }
    fn size(&self) -> (u32, u32) {
        self.cpu.size()
    }
    fn render_rows(&self, rows: Range<u32>, control: &RenderControl) -> Result<Rendered, BackendError> {
        if self.rows_left.fetch_sub(1, Ordering::Relaxed) == 0 {
            return Err(BackendError::Failed("the device was lost".into()));
        }
        self.cpu.render_rows(rows, control)
    }
    fn samples(&self) -> u32 {
        self.cpu.samples()
    }
    fn pixels_at_a_time(&self) -> u64 {
        self.cpu.pixels_at_a_time()
    }
    fn sample_rows(
        &self,
        rows: Range<u32>,
        samples: Range<u32>,
        control: &RenderControl,
    ) -> Result<Sampled, BackendError> {
        if self.rows_left.fetch_sub(1, Ordering::Relaxed) == 0 {
            return Err(BackendError::Failed("the device was lost".into()));
        }
        self.cpu.sample_rows(rows, samples, control)
    }
}

fn cpu() -> Result<Box<dyn Backend>, BackendError> {
    Ok(Box::new(CpuBackend::new(CpuOptions::default())?))
}

#[test]
fn what_one_backend_cannot_the_other_goes_on_with() {
    let mut scene = load("builtin:cornell", &LoadOptions::default()).unwrap().scene;
    (scene.settings.size, scene.settings.samples, scene.settings.light_samples) = ([24, 16], 1, 1);
    let data = Arc::new(SceneData::flatten(&scene).unwrap().0);
    let expected = cpu().unwrap().prepare(Arc::clone(&data)).unwrap();
    for (prepares, rows_left, what) in [(false, 0, "too large"), (true, 0, "lost"), (true, 2, "lost")] {
        let told = Arc::new(Mutex::new(Vec::new()));
        let tell = {
            let told = Arc::clone(&told);
            move |error: &BackendError| told.lock().unwrap().push(error.to_string())
        };
        let backend = Fallback::new(Box::new(Failing { prepares, rows_left }), cpu, tell);
        let prepared = backend.prepare(Arc::clone(&data)).unwrap();
        let cancel = AtomicBool::new(false);
        let control = RenderControl { on_progress: &|_| {}, cancel: &cancel, count_work: false, frame: None };
        for rows in [0..4, 4..8, 8..12, 12..16] {
            let got = prepared.render_rows(rows.clone(), &control).unwrap();
            let want = expected.render_rows(rows.clone(), &control).unwrap();
            assert!(got.complete && got.film == want.film, "{what} {rows:?}");
            let got = prepared.sample_rows(rows.clone(), 0..1, &control).unwrap();
            assert!(got.complete && got.sums.film(1) == want.film, "{what} {rows:?}");
        }
        let develop = DevelopSettings { exposure: 0.5, ..DevelopSettings::default() };
        let got = prepared.render_developed(&develop, &control).unwrap();
        let want = Developed::new(&expected.render(&control).unwrap().film, &develop);
        assert!(got.complete && got.developed() == want, "{what}");
        assert!(backend.describe().starts_with("failing, then CPU"), "{}", backend.describe());
        let told = told.lock().unwrap();
        assert!(told.len() == 1 && told[0].contains(what), "{told:?}");
    }
}
