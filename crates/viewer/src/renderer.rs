//! The thread that renders: for all pages in turn, always their newest input.

use crate::client::{Client, Next, Wanted};
use crate::encode;
use crate::false_colors;
use crate::message::{Frame, FrameHeader, Milliseconds, OnShow, ToPage};
use crate::page_view::{Show, frames_of};
use crate::progress::Progress;
use crate::source::{Device, DeviceChoice, SceneSource, SourceError};
use crate::stage::Stage;
use eosphor::{
    Backend, BackendError, DevelopSettings, Developed, FrameState, Metadata, OutputError, RenderControl,
    RenderSettings, SaveOptions, SceneError,
};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

/// Of frames in one piece.
const WHOLE: [u32; 2] = [0, 1];

/// JPEG quality of frames at rest that get sharper.
const REST_QUALITY: u8 = 92;

/// Pages that may be connected at a time.
pub(crate) const MAX_CLIENTS: usize = 64;

/// What the threads of a viewer share.
pub(crate) struct Shared {
    pub(crate) source: Box<dyn SceneSource>,
    board: Mutex<Board>,
    /// Told when a page says something, when the scene changes, and at the end.
    changed: Condvar,
    pub(crate) is_over: AtomicBool,
}

/// Who is there, and what is on show.
struct Board {
    backend: Arc<dyn Backend>,
    stage: Arc<Stage>,
    /// What a page has asked for, and is not there yet.
    device_wish: Option<(DeviceChoice, Arc<Client>)>,
    /// What is wrong with the files, where something is.
    error: Option<String>,
    clients: Vec<Arc<Client>>,
    /// Pages there have been.
    pages: u64,
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
        let backend: Arc<dyn Backend> = source.backend(None)?.into();
        let stage = Arc::new(Stage::open(&*source, None, &*backend, 1)?);
        let (clients, device_wish) = (Vec::new(), None);
        let board = Board { backend, stage, device_wish, error: None, clients, pages: 0, turn: 0 };
        let (board, changed, is_over) = (Mutex::new(board), Condvar::new(), AtomicBool::new(false));
        Ok(Shared { source, board, changed, is_over })
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
        let mut board = self.board();
        if board.clients.len() >= MAX_CLIENTS {
            return None;
        }
        board.pages += 1;
        let client = Arc::new(Client::new(board.pages));
        client.tell(self.describe(&board, &client, true));
        if let Some(text) = board.error.clone() {
            client.tell(ToPage::Error { text });
        }
        board.clients.push(Arc::clone(&client));
        Some(client)
    }

    /// The page of a number, while it is connected.
    pub(crate) fn page(&self, number: u64) -> Option<Arc<Client>> {
        self.board().clients.iter().find(|client| client.number == number).cloned()
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
        let (before, backend) = {
            let board = self.board();
            (Arc::clone(&board.stage), Arc::clone(&board.backend))
        };
        match Stage::open(&*self.source, before.device.clone(), &*backend, before.version + 1) {
            Ok(stage) => {
                let takes_camera = stage.own.camera != before.own.camera;
                let mut board = self.board();
                (board.stage, board.error) = (Arc::new(stage), None);
                self.show_board(&board, takes_camera);
            }
            Err(SourceError(text)) => {
                let mut board = self.board();
                board.error = Some(text.clone());
                board.clients.iter().for_each(|client| client.tell(ToPage::Error { text: text.clone() }));
            }
        }
        self.wake();
    }

    /// Notes that a page wants another device or hierarchy: one of those that it was told of.
    pub(crate) fn wish_device(&self, choice: DeviceChoice, client: &Arc<Client>) {
        let devices = self.source.devices();
        let has = |device: &Device| device.backend == choice.backend && device.accels.contains(&choice.accel);
        match devices.iter().any(has) {
            true => self.board().device_wish = Some((choice, Arc::clone(client))),
            false => {
                client.tell(ToPage::Refused { text: "there is no such device or hierarchy to choose".into() })
            }
        }
    }

    /// Gives all pages the device that one of them has asked for. Where that fails, it is told why, and all stays as it is.
    pub(crate) fn grant_device(&self) {
        let wish = self.board().device_wish.take();
        let Some((choice, client)) = wish else { return };
        let before = self.stage();
        let opened = self.source.backend(Some(&choice)).and_then(|backend| {
            let stage = before.on(&*self.source, choice, &*backend)?;
            Ok((backend, stage))
        });
        match opened {
            Ok((backend, stage)) => {
                let mut board = self.board();
                (board.backend, board.stage) = (backend.into(), Arc::new(stage));
                self.show_board(&board, false);
            }
            Err(SourceError(text)) => client.tell(ToPage::Refused { text }),
        }
        self.wake();
    }

    /// Tells all pages what is on show now.
    fn show_board(&self, board: &Board, take_camera: bool) {
        for client in &board.clients {
            client.cancel.store(true, Ordering::Relaxed);
            client.tell(self.describe(board, client, take_camera));
        }
    }

    fn describe(&self, board: &Board, client: &Client, take_camera: bool) -> ToPage {
        let stage = &board.stage;
        ToPage::Scene(Box::new(OnShow {
            version: stage.version,
            name: self.source.name(),
            backend: board.backend.describe(),
            view: stage.own,
            radius: stage.radius,
            center: stage.center,
            triangles: stage.triangles(),
            frames: frames_of(&stage.scene),
            fps: stage.scene.animation.as_ref().map_or(24.0, |animation| animation.fps),
            devices: self.source.devices(),
            device: stage.device.clone(),
            page: client.number,
            take_camera,
        }))
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
    let never = AtomicBool::new(false);
    let (picture, rendered) = match wanted.view.show {
        Show::Picture => {
            let film = stage.prepared.render(&control(&state, &never))?.film;
            let rendered = Instant::now();
            (Developed::new(&film, &DevelopSettings::from(&settings)), rendered)
        }
        show => {
            let features = stage.features()?.rows(0..state.settings.height, Some(&state), &never)?;
            let rendered = Instant::now();
            (false_colors::draw(show, &features), rendered)
        }
    };
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
        size: [picture.width, picture.height],
        full: wanted.view.size,
        samples: 1,
        all_samples: state.settings.samples,
        at_rest: false,
        piece: WHOLE,
        format: "image/jpeg",
        milliseconds,
    };
    drop(client_state);
    client.show(Frame { header, bytes });
    Ok(())
}

/// More samples of a camera that rests; with the last ones, the picture itself.
fn show_resting(client: &Client, stage: &Stage, wanted: &Wanted) -> Result<(), FrameError> {
    if wanted.view.show != Show::Picture {
        return show_features(client, stage, wanted);
    }
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
        piece: WHOLE,
        format,
        milliseconds: steps(start, rendered, developed),
    };
    if keep(client, wanted, progress) {
        client.show(Frame { header, bytes });
    }
    Ok(())
}

/// What is shown instead of the picture: of all samples at once, as a file would have it.
fn show_features(client: &Client, stage: &Stage, wanted: &Wanted) -> Result<(), FrameError> {
    let (state, settings) = stage.at_rest(&wanted.view)?;
    client.cancel.store(false, Ordering::Relaxed);
    if client.state().wanted.is_none_or(|now| now.view != wanted.view) {
        return Ok(());
    }
    let start = Instant::now();
    let features = stage.features()?.rows(0..state.settings.height, Some(&state), &client.cancel)?;
    if client.cancel.load(Ordering::Relaxed) {
        return Ok(());
    }
    let rendered = Instant::now();
    let picture = false_colors::draw(wanted.view.show, &features);
    let developed = Instant::now();
    let bytes = encode::png(&picture, &file_options(&settings))?;
    let samples = state.settings.samples;
    let header = FrameHeader {
        frame: client.state().number(),
        input: wanted.input,
        version: stage.version,
        size: wanted.view.size,
        full: wanted.view.size,
        samples,
        all_samples: samples,
        at_rest: true,
        piece: WHOLE,
        format: "image/png",
        milliseconds: steps(start, rendered, developed),
    };
    let progress = Progress { is_sent: true, ..Progress::at_once(stage.version, samples) };
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
pub(crate) fn file_options(settings: &RenderSettings) -> SaveOptions {
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
