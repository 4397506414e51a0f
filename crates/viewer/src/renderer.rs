//! The thread that renders: for all pages in turn, always their newest input.

use crate::client::{Client, Next};
use crate::frames::{show_moving, show_resting};
use crate::message::{OnShow, ToPage};
use crate::page_view::frames_of;
use crate::source::{Device, DeviceChoice, SceneSource, SourceError};
use crate::stage::Stage;
use eosphor::Backend;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

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
    /// What a page has requested, and is not there yet.
    device_request: Option<(DeviceChoice, Arc<Client>)>,
    /// What is wrong with the files, where something is.
    error: Option<String>,
    clients: Vec<Arc<Client>>,
    /// Pages there have been.
    pages: u64,
    /// Whose turn it is.
    turn: usize,
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
        let (clients, device_request) = (Vec::new(), None);
        let board = Board { backend, stage, device_request, error: None, clients, pages: 0, turn: 0 };
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

    /// Notes that a page requests another device or hierarchy: one of those that it was offered.
    pub(crate) fn request_device(&self, choice: DeviceChoice, client: &Arc<Client>) {
        let devices = self.source.devices();
        let has = |device: &Device| device.backend == choice.backend && device.accels.contains(&choice.accel);
        match devices.iter().any(has) {
            true => self.board().device_request = Some((choice, Arc::clone(client))),
            false => client.tell(ToPage::Refused { text: "this device or hierarchy is not offered".into() }),
        }
    }

    /// Renders for all pages on the device that one of them has requested. Where that fails, that page is told why, and all stays
    /// as it is.
    pub(crate) fn switch_device(&self) {
        let request = self.board().device_request.take();
        let Some((choice, client)) = request else { return };
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
            // A scene clears what the page shows of errors; the files may still be wrong.
            if let Some(text) = board.error.clone() {
                client.tell(ToPage::Error { text });
            }
        }
    }

    fn describe(&self, board: &Board, client: &Client, take_camera: bool) -> ToPage {
        let stage = &board.stage;
        ToPage::Scene(Box::new(OnShow {
            version: stage.version,
            name: self.source.name(),
            backend: board.backend.describe(),
            integrator: stage.scene.settings.integrator,
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
