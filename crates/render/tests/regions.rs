//! Parts of pictures have the bits of the whole, whoever renders them and however.

use eosphor_core::develop::ToneCurve;
use eosphor_core::sums::ExactSum;
use eosphor_render::{
    Accel, Backend, BackendError, CpuBackend, CpuOptions, DevelopSettings, Developed, Hierarchy,
    HierarchyStatistics, PreparedRegion, PreparedScene, Progress, Region, RenderControl, Rendered,
    SampleSums, Sampled, Scheduler,
};
use eosphor_scene::{Lens, LoadOptions, SceneData, load};
use std::ops::Range;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

const SIZE: (u32, u32) = (37, 29);
const SAMPLES: u32 = 3;

/// A scene with a lens, glossy rays and glass.
fn scene(name: &str) -> Arc<SceneData> {
    let mut scene = load(name, &LoadOptions::default()).unwrap().scene;
    (scene.settings.size, scene.settings.samples) = (SIZE.into(), SAMPLES);
    scene.settings.light_samples = 1;
    if let Some(camera) = &mut scene.camera {
        camera.lens = Some(Lens { aperture_radius: 0.05, focus_distance: Some(4.6) });
    }
    Arc::new(SceneData::flatten(&scene).unwrap().0)
}

fn regions() -> [Region; 5] {
    let region = |x, y, width, height| Region { x, y, width, height };
    [
        region(0, 0, 37, 29),
        region(36, 28, 1, 1),
        region(5, 3, 17, 19),
        region(0, 7, 9, 1),
        region(33, 0, 1, 29),
    ]
}

fn part(sums: &SampleSums, region: &Region) -> Vec<ExactSum> {
    let row = |y: u32| &sums.sums[(y * sums.width + region.x) as usize..][..region.width as usize];
    region.picture_rows().flat_map(|y| row(y).iter().copied()).collect()
}

/// A device that knows rows only.
struct RowsOnly(Box<dyn PreparedScene>);

impl PreparedScene for RowsOnly {
    fn hierarchy_statistics(&self) -> HierarchyStatistics {
        self.0.hierarchy_statistics()
    }

    fn hierarchy(&self) -> Option<Arc<Hierarchy>> {
        self.0.hierarchy()
    }

    fn size(&self) -> (u32, u32) {
        self.0.size()
    }

    fn samples(&self) -> u32 {
        self.0.samples()
    }

    fn pixels_at_a_time(&self) -> u64 {
        self.0.pixels_at_a_time()
    }

    fn render_rows(&self, rows: Range<u32>, control: &RenderControl) -> Result<Rendered, BackendError> {
        self.0.render_rows(rows, control)
    }

    fn sample_rows(
        &self,
        rows: Range<u32>,
        samples: Range<u32>,
        control: &RenderControl,
    ) -> Result<Sampled, BackendError> {
        self.0.sample_rows(rows, samples, control)
    }
}

fn prepare(scene: &Arc<SceneData>, options: CpuOptions) -> Box<dyn PreparedScene> {
    CpuBackend::new(options).unwrap().prepare(Arc::clone(scene)).unwrap()
}

#[test]
fn a_part_is_the_part_of_the_whole() {
    let never = AtomicBool::new(false);
    for name in ["builtin:cornell", "builtin:solids"] {
        let scene = scene(name);
        let control = RenderControl { on_progress: &|_| {}, cancel: &never, count_work: false, frame: None };
        let whole = prepare(&scene, CpuOptions::default());
        let film = whole.render(&control).unwrap().film;
        let sums = whole.sample_rows(0..SIZE.1, 1..SAMPLES, &control).unwrap().sums;
        let scalar = CpuOptions { scheduler: Scheduler::Scalar, tile: Some(5), ..CpuOptions::default() };
        let of_structure = |accel| CpuOptions { accel, ..CpuOptions::default() };
        let mut ways: Vec<Box<dyn PreparedScene>> =
            [Accel::Bvh, Accel::Bvh8, Accel::Octree, Accel::Grid, Accel::KdTree]
                .map(|accel| prepare(&scene, of_structure(accel)))
                .into();
        ways.push(prepare(&scene, scalar));
        ways.push(Box::new(RowsOnly(prepare(&scene, CpuOptions::default()))));
        for (number, way) in ways.iter().enumerate() {
            for region in regions() {
                let done = way.sample_region(&region, 1..SAMPLES, &control).unwrap();
                assert!(
                    done.complete && (done.sums.width, done.sums.height) == (region.width, region.height)
                );
                assert!(done.sums.sums == part(&sums, &region), "{name}, way {number}, {region:?}");
            }
        }
        for region in regions() {
            let of_region = PreparedRegion::new(prepare(&scene, CpuOptions::default()), region).unwrap();
            assert_eq!(of_region.size(), (region.width, region.height));
            let rendered = of_region.render(&control).unwrap().film;
            let y = |row: u32| ((region.y + row) * SIZE.0 + region.x) as usize;
            for row in 0..region.height {
                let own = &rendered.pixels[(row * region.width) as usize..][..region.width as usize];
                assert!(own == &film.pixels[y(row)..][..region.width as usize], "{name}, {region:?}");
            }
        }
    }
}

/// What is told of the way is of the pixels that were asked for.
#[test]
fn progress_is_of_the_part() {
    let never = AtomicBool::new(false);
    let scene = scene("builtin:cornell");
    for rows_only in [false, true] {
        let prepared = prepare(&scene, CpuOptions::default());
        let prepared = if rows_only { Box::new(RowsOnly(prepared)) } else { prepared };
        let (done, region) = (AtomicU64::new(0), regions()[2]);
        let on_progress = |progress: Progress| {
            assert_eq!(progress.pixels_total, region.pixels());
            done.fetch_max(progress.pixels_done, Ordering::Relaxed);
        };
        let control =
            RenderControl { on_progress: &on_progress, cancel: &never, count_work: false, frame: None };
        prepared.sample_region(&region, 0..1, &control).unwrap();
        assert_eq!(done.into_inner(), region.pixels());
    }
}

#[test]
fn layers_of_a_part_are_those_of_the_whole() {
    let never = AtomicBool::new(false);
    let scene = scene("builtin:cornell");
    let pass =
        || CpuBackend::new(CpuOptions::default()).unwrap().feature_pass(Arc::clone(&scene), None).unwrap();
    let whole = pass().rows(0..SIZE.1, None, &never).unwrap();
    for region in regions() {
        let of_region = pass().of_region(region).unwrap();
        let rows = region.height / 2..region.height;
        let part = of_region.rows(rows.clone(), None, &never).unwrap();
        assert_eq!((part.width, part.height), (region.width, rows.end - rows.start));
        for (number, pixel) in (0u32..).zip(&part.pixels) {
            let (x, y) = (region.x + number % region.width, region.y + rows.start + number / region.width);
            assert!(*pixel == whole.pixels[(y * SIZE.0 + x) as usize], "{x} {y}");
        }
    }
}

#[test]
fn what_the_picture_lacks_is_refused() {
    let never = AtomicBool::new(false);
    let scene = scene("builtin:cornell");
    let control = RenderControl { on_progress: &|_| {}, cancel: &never, count_work: false, frame: None };
    for (x, y, width, height) in
        [(0, 0, 38, 1), (37, 0, 1, 1), (0, 28, 1, 2), (0, 0, 0, 1), (u32::MAX, 0, 2, 1)]
    {
        let region = Region { x, y, width, height };
        let prepared = prepare(&scene, CpuOptions::default());
        assert!(prepared.sample_region(&region, 0..1, &control).is_err());
        assert!(RowsOnly(prepared).sample_region(&region, 0..1, &control).is_err());
        assert!(PreparedRegion::new(prepare(&scene, CpuOptions::default()), region).is_err());
        let pass =
            CpuBackend::new(CpuOptions::default()).unwrap().feature_pass(Arc::clone(&scene), None).unwrap();
        assert!(pass.of_region(region).is_err());
    }
}

/// Bytes are those of the film, of a whole picture and of parts.
#[test]
fn developed_parts_are_those_of_their_films() {
    let data = scene("builtin:cornell");
    let backend = CpuBackend::new(CpuOptions::default()).unwrap();
    let control = RenderControl {
        on_progress: &|_| {},
        cancel: &AtomicBool::new(false),
        count_work: false,
        frame: None,
    };
    let develop = DevelopSettings { exposure: 1.0, tone_curve: ToneCurve::Agx, ..DevelopSettings::default() };
    let part = |region| PreparedRegion::new(backend.prepare(Arc::clone(&data)).unwrap(), region).unwrap();
    for region in regions() {
        let part = part(region);
        let bytes = part.render_developed(&develop, &control).unwrap();
        let film = part.render(&control).unwrap();
        assert!(bytes.complete && bytes.statistics == film.statistics);
        let bytes = bytes.developed();
        assert_eq!((bytes.width, bytes.height), (region.width, region.height));
        assert!(bytes == Developed::new(&film.film, &develop), "{region:?}");
    }
}
