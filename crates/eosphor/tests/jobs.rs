//! Jobs give the bytes of an undisturbed one, whatever ends them and however they are shared out.

use eosphor::job::{Cancel, Event, FrameNames, JobControl, JobError, Output, Sequence, Share, Still, merge};
use eosphor::{
    Backend, BackendError, CpuBackend, CpuOptions, DevelopSettings, Developed, Film, Format, Hierarchy,
    HierarchyStatistics, LoadOptions, PreparedScene, Region, RenderControl, Rendered, RenderedBytes, Sampled,
    Scene, SceneData, ToneCurve, load,
};
use std::fs;
use std::io::{self, Write};
use std::ops::Range;
use std::path::Path;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex};
use std::time::Duration;

fn scene() -> Scene {
    let mut scene = load("builtin:cornell", &LoadOptions::default()).unwrap().scene;
    (scene.settings.size, scene.settings.samples) = ([48, 32], 8);
    scene
}

fn backend() -> CpuBackend {
    CpuBackend::new(CpuOptions { threads: Some(2), ..CpuOptions::default() }).unwrap()
}

fn still<'a>(scene: &'a Scene, backend: &'a CpuBackend, path: &Path) -> Still<'a> {
    // Short pieces, so that there are several.
    Still {
        checkpoint_interval: Duration::from_millis(12),
        ..Still::new(scene, backend).to_file(path).unwrap()
    }
}

/// What an undisturbed job writes.
fn undisturbed(scene: &Scene, name: &str) -> Vec<u8> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(name);
    let outcome = still(scene, &backend(), &path).run(&JobControl::default()).unwrap();
    assert!(outcome.complete && outcome.done == 1.0 && outcome.written == [path.clone()]);
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1, "nothing else is left");
    fs::read(path).unwrap()
}

#[test]
fn a_still_that_is_cancelled_goes_on() {
    let (scene, backend, folder) = (scene(), backend(), tempfile::tempdir().unwrap());
    let path = folder.path().join("a.png");
    let cancel = Cancel::new();
    let control = JobControl { on_progress: &|_| cancel.ask(), cancel: &cancel, ..JobControl::default() };
    let outcome = still(&scene, &backend, &path).run(&control).unwrap();
    assert!(!outcome.complete && outcome.done > 0.0 && outcome.done < 1.0, "{}", outcome.done);
    assert_eq!(outcome.kept, Some(folder.path().join("a.png.part")));
    assert_eq!(outcome.written, [folder.path().join("a.partial.png")]);
    let events = Mutex::new(Vec::new());
    let on_event = |event: Event| events.lock().unwrap().push(format!("{event:?}"));
    let mut again = still(&scene, &backend, &path);
    again.resume = true;
    let resumed = again.run(&JobControl { on_event: &on_event, ..JobControl::default() }).unwrap();
    assert!(resumed.complete && resumed.resumed == outcome.done);
    assert!(events.lock().unwrap().iter().any(|event| event.starts_with("Resumed")));
    assert!(fs::read(&path).unwrap() == undisturbed(&scene, "a.png"), "byte for byte");
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1, "nothing else is left");
}

#[test]
fn a_job_that_is_cancelled_before_it_begins_writes_nothing() {
    let (scene, backend, folder) = (scene(), backend(), tempfile::tempdir().unwrap());
    let cancel = Cancel::new();
    cancel.ask();
    let control = JobControl { cancel: &cancel, ..JobControl::default() };
    let failed = still(&scene, &backend, &folder.path().join("a.png")).run(&control);
    assert!(matches!(failed, Err(JobError::Cancelled)));
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0);
}

#[test]
fn shares_make_the_whole() {
    let (scene, backend) = (scene(), backend());
    let rows = [1, 2, 3].map(|number| Share::Rows { number, count: 3 });
    let samples = [0..3, 3..8].map(Share::Samples);
    for shares in [&rows[..], &samples] {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.png");
        for share in shares {
            let mut still = still(&scene, &backend, &path);
            still.share = Some(share.clone());
            assert!(still.run(&JobControl::default()).unwrap().complete);
        }
        assert_eq!(merge(&[], &path).unwrap(), shares.len());
        assert!(fs::read(&path).unwrap() == undisturbed(&scene, "a.png"), "{shares:?}");
    }
}

/// Where a stream ends.
#[derive(Clone, Default)]
struct Buffer(Arc<Mutex<Vec<u8>>>);

impl Write for Buffer {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.0.lock().unwrap().write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

#[test]
fn a_stream_gets_what_a_file_gets() {
    let (scene, backend, buffer) = (scene(), backend(), Buffer::default());
    let mut still = Still::new(&scene, &backend);
    let stream = Box::new(buffer.clone());
    still.outputs.push(Output::Stream { name: "a buffer".into(), format: Format::Ppm, stream });
    let outcome = still.run(&JobControl::default()).unwrap();
    assert!(outcome.complete && outcome.written.is_empty());
    assert!(*buffer.0.lock().unwrap() == undisturbed(&scene, "a.ppm"), "byte for byte");
}

#[test]
fn what_cannot_be_is_said_before_anything_is_done() {
    let (scene, backend, folder) = (scene(), backend(), tempfile::tempdir().unwrap());
    let path = folder.path().join("a.png");
    let fails = |change: &dyn Fn(&mut Still)| {
        let mut still = still(&scene, &backend, &path);
        change(&mut still);
        still.run(&JobControl::default()).unwrap_err().to_string()
    };
    let region = Region { x: 40, y: 0, width: 9, height: 1 };
    assert!(fails(&|still| still.region = Some(region)).contains("the picture has 48 x 32 pixels"));
    assert!(fails(&|still| still.outputs.clear()).contains("no name"));
    assert!(fails(&|still| still.outputs.push(Output::file(&path).unwrap())).contains("are the same"));
    let of_share = |share: Share| fails(&|still| still.share = Some(share.clone()));
    assert!(of_share(Share::Samples(4..9)).contains("a pixel has 8 samples"));
    for (number, count) in [(0, 2), (3, 2), (1, 501)] {
        assert!(of_share(Share::Rows { number, count }).contains("from 1 on"), "{number} of {count}");
    }
    let layered = |still: &mut Still| (still.share, still.file.alpha) = (Some(Share::Samples(0..1)), true);
    assert!(fails(&layered).contains("neither layers nor alpha"));
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0);
}

#[test]
fn frames_that_there_are_not_are_said() {
    let (mut scene, backend, folder) = (scene(), backend(), tempfile::tempdir().unwrap());
    let names = FrameNames::pattern(&folder.path().join("f_%d.png")).unwrap();
    let fails = |scene: &Scene, frames| {
        let sequence = Sequence { frames: Some(frames), ..Sequence::new(scene, &backend) };
        sequence.write_frames(&names, &JobControl::default()).unwrap_err().to_string()
    };
    assert!(fails(&scene, 0..1).contains("nothing moves in this scene"));
    scene.turntable(3).unwrap();
    for frames in [2..4, 1..1] {
        assert!(fails(&scene, frames.clone()).contains("the animation has 3 frames"), "{frames:?}");
    }
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0);
}

#[test]
fn frames_that_are_done_are_kept() {
    let (mut scene, backend, folder) = (scene(), backend(), tempfile::tempdir().unwrap());
    scene.settings.samples = 1;
    scene.turntable(6).unwrap();
    let names = |folder: &Path| FrameNames::pattern(&folder.join("f_%02d.png")).unwrap();
    let (cancel, count) = (Cancel::new(), AtomicUsize::new(0));
    let on_event = |event: Event| {
        if let Event::FrameDone(_) = event
            && count.fetch_add(1, Ordering::Relaxed) == 1
        {
            cancel.ask();
        }
    };
    let control = JobControl { on_event: &on_event, cancel: &cancel, ..JobControl::default() };
    let mut sequence = Sequence { in_flight: Some(1), ..Sequence::new(&scene, &backend) };
    let outcome = sequence.write_frames(&names(folder.path()), &control).unwrap();
    assert!(!outcome.complete && (outcome.done, outcome.kept) == (2, 0));
    (sequence.resume, sequence.in_flight) = (true, None);
    let outcome = sequence.write_frames(&names(folder.path()), &JobControl::default()).unwrap();
    assert!(outcome.complete && (outcome.done, outcome.kept) == (4, 2));
    let other = tempfile::tempdir().unwrap();
    let outcome = sequence.write_frames(&names(other.path()), &JobControl::default()).unwrap();
    assert_eq!(outcome.frames.iter().map(|done| done.frame).collect::<Vec<u32>>(), [0, 1, 2, 3, 4, 5]);
    for entry in fs::read_dir(other.path()).unwrap() {
        let name = entry.unwrap().file_name();
        let bytes = [folder.path(), other.path()].map(|folder| fs::read(folder.join(&name)).unwrap());
        assert!(bytes[0] == bytes[1], "{}", name.display());
    }
}

#[cfg(feature = "video")]
#[test]
fn a_video_is_the_same_however_often_it_was_begun() {
    let (mut scene, backend, folder) = (scene(), backend(), tempfile::tempdir().unwrap());
    scene.settings.samples = 1;
    scene.turntable(5).unwrap();
    let video = |name: &str| eosphor::job::Video::new(&folder.path().join(name));
    let cancel = Cancel::new();
    let on_event = |event: Event| {
        if let Event::FrameDone(_) = event {
            cancel.ask();
        }
    };
    let control = JobControl { on_event: &on_event, cancel: &cancel, ..JobControl::default() };
    let mut sequence = Sequence { in_flight: Some(1), ..Sequence::new(&scene, &backend) };
    assert!(!sequence.write_video(&video("a.mp4"), &control).unwrap().complete);
    sequence.resume = true;
    let outcome = sequence.write_video(&video("a.mp4"), &JobControl::default()).unwrap();
    assert!(outcome.complete && (outcome.done, outcome.kept) == (4, 1));
    assert!(sequence.write_video(&video("a.mp4"), &JobControl::default()).unwrap().was_whole);
    assert!(sequence.write_video(&video("b.mp4"), &JobControl::default()).unwrap().complete);
    let bytes = ["a.mp4", "b.mp4"].map(|name| fs::read(folder.path().join(name)).unwrap());
    assert!(bytes[0] == bytes[1], "byte for byte");
}

/// A device that develops by itself, and tells how often.
struct Developing {
    cpu: CpuBackend,
    developed: Arc<AtomicUsize>,
}

struct PreparedDeveloping {
    scene: Box<dyn PreparedScene>,
    developed: Arc<AtomicUsize>,
}

impl Backend for Developing {
    fn describe(&self) -> String {
        "developing".into()
    }

    fn prepare(&self, scene: Arc<SceneData>) -> Result<Box<dyn PreparedScene>, BackendError> {
        let developed = Arc::clone(&self.developed);
        Ok(Box::new(PreparedDeveloping { scene: self.cpu.prepare(scene)?, developed }))
    }
}

impl PreparedScene for PreparedDeveloping {
    fn hierarchy_statistics(&self) -> HierarchyStatistics {
        self.scene.hierarchy_statistics()
    }

    fn hierarchy(&self) -> Option<Arc<Hierarchy>> {
        self.scene.hierarchy()
    }

    fn size(&self) -> (u32, u32) {
        self.scene.size()
    }

    fn samples(&self) -> u32 {
        self.scene.samples()
    }

    fn pixels_at_a_time(&self) -> u64 {
        self.scene.pixels_at_a_time()
    }

    fn render_rows(&self, rows: Range<u32>, control: &RenderControl) -> Result<Rendered, BackendError> {
        self.scene.render_rows(rows, control)
    }

    fn sample_rows(
        &self,
        rows: Range<u32>,
        samples: Range<u32>,
        control: &RenderControl,
    ) -> Result<Sampled, BackendError> {
        self.scene.sample_rows(rows, samples, control)
    }

    fn render_developed(
        &self,
        develop: &DevelopSettings,
        control: &RenderControl,
    ) -> Result<RenderedBytes, BackendError> {
        self.developed.fetch_add(1, Ordering::Relaxed);
        let Rendered { film, complete, statistics } = self.scene.render(control)?;
        Ok(RenderedBytes::of_bytes(developed(&film, develop), complete, statistics))
    }
}

/// Pixel by pixel.
fn developed(film: &Film, develop: &DevelopSettings) -> Developed {
    let pixels = film.pixels.chunks(1).map(|pixel| Film { width: 1, height: 1, pixels: pixel.to_vec() });
    let rgb = pixels.flat_map(|pixel| Developed::new(&pixel, develop).rgb).collect();
    Developed { width: film.width, height: film.height, rgb, alpha: Vec::new() }
}

/// Frames of which bytes are wanted may be developed by the device; of linear formats the film is wanted.
#[test]
fn files_of_frames_are_the_same_whoever_develops() {
    let mut scene = scene();
    (scene.settings.samples, scene.settings.tone_curve) = (1, ToneCurve::Agx);
    scene.turntable(3).unwrap();
    let count = Arc::new(AtomicUsize::new(0));
    let developing = Developing { cpu: backend(), developed: Arc::clone(&count) };
    let (cpu, folder) = (backend(), tempfile::tempdir().unwrap());
    let control = JobControl::default();
    for (ending, expected) in [("png", 3), ("jpg", 3), ("ppm", 3), ("data", 3), ("exr", 0), ("hdr", 0)] {
        count.store(0, Ordering::Relaxed);
        let backends: [(&str, &dyn Backend); 2] = [("cpu", &cpu), ("developing", &developing)];
        for (name, backend) in backends {
            let pattern = folder.path().join(name).join(format!("%d.{ending}"));
            let outcome = Sequence::new(&scene, backend)
                .write_frames(&FrameNames::pattern(&pattern).unwrap(), &control)
                .unwrap();
            assert!(outcome.complete && outcome.frames.iter().all(|done| done.milliseconds > 0.0));
        }
        for frame in 0..3 {
            let path = |folder_name: &str| folder.path().join(folder_name).join(format!("{frame}.{ending}"));
            let [a, b] = ["cpu", "developing"].map(|name| fs::read(path(name)).unwrap());
            assert!(a == b, "{frame}.{ending}");
        }
        assert_eq!(count.load(Ordering::Relaxed), expected, "{ending}");
    }
}

#[cfg(feature = "video")]
#[test]
fn a_video_is_the_same_whoever_develops() {
    let mut scene = scene();
    scene.settings.samples = 1;
    scene.turntable(3).unwrap();
    let count = Arc::new(AtomicUsize::new(0));
    let developing = Developing { cpu: backend(), developed: Arc::clone(&count) };
    let (cpu, folder) = (backend(), tempfile::tempdir().unwrap());
    let backends: [(&str, &dyn Backend); 2] = [("a.mp4", &cpu), ("b.mp4", &developing)];
    let [a, b] = backends.map(|(name, backend)| {
        let path = folder.path().join(name);
        let video = eosphor::job::Video::new(&path);
        assert!(Sequence::new(&scene, backend).write_video(&video, &JobControl::default()).unwrap().complete);
        fs::read(path).unwrap()
    });
    assert!(a == b, "byte for byte");
    assert_eq!(count.load(Ordering::Relaxed), 3);
}
