//! The thread that renders: for all pages in turn, always their newest input.

use crate::client::{Client, Next, Wanted};
use crate::encode;
use crate::message::{Frame, FrameHeader, Milliseconds, ToPage};
use crate::page_view::PageView;
use crate::progress::Progress;
use crate::source::{SceneSource, SourceError};
use crate::stage::Stage;
use eosphor::{
    Backend, BackendError, DevelopSettings, Developed, FrameState, Metadata, OutputError, RenderControl,
    RenderSettings, SaveOptions, SceneError,
};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

/// JPEG quality of frames at rest that get sharper.
const REST_QUALITY: u8 = 92;

/// Pages that may be connected at a time.
pub(crate) const MAX_CLIENTS: usize = 64;

/// What the threads of a viewer share.
pub(crate) struct Shared {
    pub(crate) source: Box<dyn SceneSource>,
    pub(crate) backend: Box<dyn Backend>,
    board: Mutex<Board>,
    /// Told when a page says something, when the scene changes, and at the end.
    changed: Condvar,
    pub(crate) is_over: AtomicBool,
}

/// Who is there, and what is on show.
struct Board {
    stage: Arc<Stage>,
    /// What is wrong with the files, where something is.
    error: Option<String>,
    clients: Vec<Arc<Client>>,
    /// Whose turn it is.
    turn: usize,
}

#[derive(Debug, thiserror::Error)]
enum FrameError {
    #[error(transparent)]
    Backend(#[from] BackendError),
    #[error(transparent)]
    Scene(#[from] SceneError),
    #[error(transparent)]
    Output(#[from] OutputError),
}

impl Shared {
    /// With the scene on show.
    ///
    /// # Errors
    ///
    /// Where the scene cannot be read or prepared, or the device is not there.
    pub(crate) fn open(source: Box<dyn SceneSource>) -> Result<Shared, SourceError> {
        let backend = source.backend()?;
        let stage = Arc::new(Stage::open(&*source, &*backend, 1)?);
        let board = Board { stage, error: None, clients: Vec::new(), turn: 0 };
        let (board, changed, is_over) = (Mutex::new(board), Condvar::new(), AtomicBool::new(false));
        Ok(Shared { source, backend, board, changed, is_over })
    }

    fn board(&self) -> MutexGuard<'_, Board> {
        self.board.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The scene on show.
    pub(crate) fn stage(&self) -> Arc<Stage> {
        Arc::clone(&self.board().stage)
    }

    /// Lets a page in, if there is room for it.
    pub(crate) fn enter(&self) -> Option<Arc<Client>> {
        let client = Arc::new(Client::new());
        let mut board = self.board();
        if board.clients.len() >= MAX_CLIENTS {
            return None;
        }
        client.tell(self.describe(&board.stage, true));
        if let Some(text) = board.error.clone() {
            client.tell(ToPage::Error { text });
        }
        board.clients.push(Arc::clone(&client));
        Some(client)
    }

    /// A page has gone.
    pub(crate) fn leave(&self, client: &Arc<Client>) {
        client.cancel.store(true, Ordering::Relaxed);
        self.board().clients.retain(|other| !Arc::ptr_eq(other, client));
        self.wake();
    }

    /// Tells the renderer that there may be something to do.
    pub(crate) fn wake(&self) {
        // Whoever looks for work holds the lock until it waits: without it, the call could come in between.
        drop(self.board());
        self.changed.notify_all();
    }

    /// Ends all that is being rendered, for good.
    pub(crate) fn end(&self) {
        self.is_over.store(true, Ordering::Relaxed);
        self.board().clients.iter().for_each(|client| client.cancel.store(true, Ordering::Relaxed));
        self.wake();
    }

    /// Reads the scene again. Where it cannot be read, the last one stays on show.
    pub(crate) fn read_again(&self) {
        let before = self.stage();
        match Stage::open(&*self.source, &*self.backend, before.version + 1) {
            Ok(stage) => {
                let stage = Arc::new(stage);
                let takes_camera = stage.own.camera != before.own.camera;
                let mut board = self.board();
                (board.stage, board.error) = (Arc::clone(&stage), None);
                for client in &board.clients {
                    client.cancel.store(true, Ordering::Relaxed);
                    client.tell(self.describe(&stage, takes_camera));
                }
            }
            Err(SourceError(text)) => {
                let mut board = self.board();
                board.error = Some(text.clone());
                board.clients.iter().for_each(|client| client.tell(ToPage::Error { text: text.clone() }));
            }
        }
        self.wake();
    }

    fn describe(&self, stage: &Stage, take_camera: bool) -> ToPage {
        ToPage::Scene {
            version: stage.version,
            name: self.source.name(),
            backend: self.backend.describe(),
            view: stage.own,
            radius: stage.radius,
            center: stage.center,
            triangles: stage.triangles(),
            take_camera,
        }
    }

    /// Renders for pages until the viewer ends.
    pub(crate) fn render(&self) {
        while let Some((client, stage, next)) = self.next_work() {
            let done = match next {
                Next::Moving(wanted) => show_moving(&client, &stage, &wanted),
                Next::Resting(wanted) => show_resting(&client, &stage, &wanted),
                Next::Later(_) | Next::Nothing => Ok(()),
            };
            if let Err(error) = done {
                client.tell(ToPage::Error { text: error.to_string() });
                // Not again before the page wants something else.
                client.state().wanted = None;
            }
        }
    }

    /// Waits for something to do: for whom, and of which scene. `None` at the end.
    fn next_work(&self) -> Option<(Arc<Client>, Arc<Stage>, Next)> {
        let mut board = self.board();
        loop {
            if self.is_over.load(Ordering::Relaxed) {
                return None;
            }
            let (now, count) = (Instant::now(), board.clients.len());
            let mut wake_at: Option<Instant> = None;
            // Moving pages come first: nobody waits for them by looking at a picture that gets sharper.
            let mut resting = None;
            for k in 0..count {
                let at = (board.turn + k) % count;
                let client = &board.clients[at];
                let next = client.state().next(board.stage.version, now);
                match next {
                    Next::Moving(_) => {
                        let found = (Arc::clone(client), Arc::clone(&board.stage), next);
                        board.turn = at + 1;
                        return Some(found);
                    }
                    Next::Resting(_) if resting.is_none() => resting = Some((at, next)),
                    Next::Later(at) => wake_at = Some(wake_at.map_or(at, |other| other.min(at))),
                    Next::Resting(_) | Next::Nothing => {}
                }
            }
            if let Some((at, next)) = resting {
                let found = (Arc::clone(&board.clients[at]), Arc::clone(&board.stage), next);
                board.turn = at + 1;
                return Some(found);
            }
            let wait = wake_at.map_or(Duration::from_secs(3600), |at| at.saturating_duration_since(now));
            board = self.changed.wait_timeout(board, wait).unwrap_or_else(PoisonError::into_inner).0;
        }
    }
}

/// A frame of a camera that moves: of a size that is rendered in time.
fn show_moving(client: &Client, stage: &Stage, wanted: &Wanted) -> Result<(), FrameError> {
    let quality = client.state().quality;
    let (state, settings) = stage.moving(&wanted.view, quality.size(wanted.view.size))?;
    let start = Instant::now();
    // It is worth its time even if the camera has moved on: else nothing would be seen of a quick movement.
    let film = {
        let never = AtomicBool::new(false);
        stage.prepared.render(&control(&state, &never))?.film
    };
    let rendered = Instant::now();
    let picture = Developed::new(&film, &DevelopSettings::from(&settings));
    let developed = Instant::now();
    let bytes = encode::jpeg(&picture, quality.jpeg())?;
    let (milliseconds, took) = (steps(start, rendered, developed), start.elapsed());
    let mut client_state = client.state();
    client_state.quality.rendered(took, bytes.len());
    if let Some(now) = &mut client_state.wanted
        && now.input == wanted.input
    {
        now.is_shown = true;
    }
    let header = FrameHeader {
        frame: client_state.number(),
        input: wanted.input,
        version: stage.version,
        size: [film.width, film.height],
        full: wanted.view.size,
        samples: 1,
        all_samples: state.settings.samples,
        at_rest: false,
        format: "image/jpeg",
        milliseconds,
    };
    drop(client_state);
    client.show(Frame { header, bytes });
    Ok(())
}

/// More samples of a camera that rests; with the last ones, the picture itself.
fn show_resting(client: &Client, stage: &Stage, wanted: &Wanted) -> Result<(), FrameError> {
    let (state, settings) = stage.at_rest(&wanted.view)?;
    client.cancel.store(false, Ordering::Relaxed);
    let before = {
        let mut client_state = client.state();
        // What came in since is asked for at the next turn.
        if client_state.wanted.is_none_or(|now| now.view != wanted.view) {
            return Ok(());
        }
        client_state.progress.take().filter(|progress| progress.version == stage.version)
    };
    let start = Instant::now();
    let mut progress =
        before.unwrap_or_else(|| Progress::new(stage.version, wanted.view.size, state.settings.samples));
    let samples = progress.next_samples();
    if !samples.is_empty() {
        let rows = 0..wanted.view.size[1];
        let sampled = stage.prepared.sample_rows(rows, samples.clone(), &control(&state, &client.cancel))?;
        if !sampled.complete {
            // Given up for something newer; if it was not, the samples that there are stay.
            keep(client, wanted, progress);
            return Ok(());
        }
        progress.sums.add(&sampled.sums);
        progress.samples = samples.end;
    }
    let film = progress.sums.film(progress.samples);
    let rendered = Instant::now();
    let picture = Developed::new(&film, &DevelopSettings::from(&settings));
    let developed = Instant::now();
    let (bytes, format) = match progress.is_whole() {
        true => (encode::png(&picture, &file_options(&settings))?, "image/png"),
        false => (encode::jpeg(&picture, REST_QUALITY)?, "image/jpeg"),
    };
    progress.is_sent = progress.is_whole();
    let header = FrameHeader {
        frame: client.state().number(),
        input: wanted.input,
        version: stage.version,
        size: wanted.view.size,
        full: wanted.view.size,
        samples: progress.samples,
        all_samples: progress.all_samples,
        at_rest: true,
        format,
        milliseconds: steps(start, rendered, developed),
    };
    if keep(client, wanted, progress) {
        client.show(Frame { header, bytes });
    }
    Ok(())
}

/// Keeps samples for the next turn, if the page still wants this view.
fn keep(client: &Client, wanted: &Wanted, mut progress: Progress) -> bool {
    let mut client_state = client.state();
    let Some(now) = client_state.wanted else { return false };
    let is_wanted = now.view == wanted.view;
    // The same view under the number of a newer input is sent once more.
    progress.is_sent &= now.input == wanted.input;
    if is_wanted {
        client_state.progress = Some(progress);
    }
    is_wanted
}

fn control<'a>(state: &'a FrameState, cancel: &'a AtomicBool) -> RenderControl<'a> {
    RenderControl { on_progress: &|_| {}, cancel, count_work: false, frame: Some(state) }
}

/// What the file of the picture at rest is like: that of `eosphor render --no-metadata`.
fn file_options(settings: &RenderSettings) -> SaveOptions {
    SaveOptions { metadata: Metadata::default(), ..SaveOptions::from(settings) }
}

fn steps(start: Instant, rendered: Instant, developed: Instant) -> Milliseconds {
    let ms = |from: Instant, to: Instant| (to - from).as_secs_f64() * 1e3;
    Milliseconds {
        render: ms(start, rendered),
        develop: ms(rendered, developed),
        encode: ms(developed, Instant::now()),
    }
}

/// Linear colours of a pixel of the picture at rest, with the samples taken so far.
pub(crate) fn pixel(client: &Client, x: u32, y: u32) -> Option<([f32; 3], u32)> {
    let state = client.state();
    let progress = state.progress.as_ref()?;
    let (width, height) = (progress.sums.width, progress.sums.height);
    if x >= width || y >= height || progress.samples == 0 {
        return None;
    }
    let mean = progress.sums.sums[y as usize * width as usize + x as usize].mean(progress.samples);
    Some(([mean.x, mean.y, mean.z], progress.samples))
}

/// The command line that renders a page's view.
pub(crate) fn command_line(shared: &Shared, stage: &Stage, view: &PageView) -> String {
    let mut flags = view.flags(&stage.scene, &stage.own);
    flags.extend(["--no-metadata", "-o", "picture.png"].map(str::to_owned));
    shared.source.command(flags)
}
