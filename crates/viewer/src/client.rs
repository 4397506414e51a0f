//! What the server knows of a page.

use crate::hover::Hover;
use crate::message::{Frame, ToPage};
use crate::page_view::PageView;
use crate::progress::Progress;
use crate::quality::Quality;
use std::collections::VecDeque;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};
use tokio::sync::Notify;

/// Frames that may be on their way to a page.
const FRAMES_UNDER_WAY: usize = 2;

/// After so long without input the camera rests, whatever the page says.
const REST_AFTER: Duration = Duration::from_millis(150);

/// Texts that wait for a page which does not read; older ones are dropped.
const MAX_TEXTS: usize = 32;

/// A page that is connected.
pub(crate) struct Client {
    /// Counts the pages of a viewer.
    pub(crate) number: u64,
    state: Mutex<ClientState>,
    pub(crate) hover: Hover,
    /// Told when there is something to send.
    pub(crate) to_send: Notify,
    /// Ends what is being rendered for it.
    pub(crate) cancel: AtomicBool,
}

/// What it wants, and what it has.
#[derive(Default)]
pub(crate) struct ClientState {
    /// What it wants to see.
    pub(crate) wanted: Option<Wanted>,
    pub(crate) quality: Quality,
    /// The picture at rest, as far as it is.
    pub(crate) progress: Option<Progress>,
    /// The newest frame that is still to be sent.
    frame: Option<Frame>,
    texts: VecDeque<ToPage>,
    /// Frames that were sent and not acknowledged: number, bytes, when.
    under_way: VecDeque<(u64, usize, Instant)>,
    frames: u64,
}

/// The newest input of a page.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Wanted {
    pub(crate) view: PageView,
    pub(crate) input: u64,
    moving: bool,
    since: Instant,
    /// A moving frame shows it.
    pub(crate) is_shown: bool,
}

/// What is to be rendered for a page.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Next {
    /// A frame of this view, while the camera moves.
    Moving(Wanted),
    /// More samples of this view.
    Resting(Wanted),
    /// Nothing before then.
    Later(Instant),
    /// Nothing before it says something.
    Nothing,
}

impl Client {
    pub(crate) fn new(number: u64) -> Client {
        let (to_send, cancel) = (Notify::new(), AtomicBool::new(false));
        Client { number, state: Mutex::default(), hover: Hover::default(), to_send, cancel }
    }

    pub(crate) fn state(&self) -> MutexGuard<'_, ClientState> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Takes what the page wants to see. What is rendered for it is given up.
    pub(crate) fn want(&self, view: PageView, input: u64, moving: bool) {
        let mut state = self.state();
        let is_same = state.wanted.is_some_and(|wanted| wanted.view == view);
        let is_shown = is_same && state.wanted.is_some_and(|wanted| wanted.is_shown);
        state.wanted = Some(Wanted { view, input, moving, since: Instant::now(), is_shown });
        if is_same {
            // Who has all of it asks for the last frame again, under the number of the new input.
            state.progress.iter_mut().for_each(|progress| progress.is_sent = false);
        } else {
            state.progress = None;
            self.cancel.store(true, Ordering::Relaxed);
        }
    }

    /// Puts a text on its way.
    pub(crate) fn tell(&self, text: ToPage) {
        let mut state = self.state();
        if state.texts.len() == MAX_TEXTS {
            state.texts.pop_front();
        }
        state.texts.push_back(text);
        drop(state);
        self.to_send.notify_one();
    }

    /// Puts a frame on its way; one that was not sent yet is dropped for it.
    pub(crate) fn show(&self, frame: Frame) {
        self.state().frame = Some(frame);
        self.to_send.notify_one();
    }
}

impl ClientState {
    /// What is to be rendered next, for the scene of this version.
    pub(crate) fn next(&self, version: u64, now: Instant) -> Next {
        let Some(wanted) = self.wanted else { return Next::Nothing };
        if self.frame.is_some() || self.under_way.len() >= FRAMES_UNDER_WAY {
            return Next::Nothing;
        }
        let rests_at = wanted.since + REST_AFTER;
        if wanted.moving && now < rests_at {
            return if wanted.is_shown { Next::Later(rests_at) } else { Next::Moving(wanted) };
        }
        match &self.progress {
            Some(progress) if progress.version == version && progress.is_complete() => Next::Nothing,
            _ => Next::Resting(wanted),
        }
    }

    /// The number of the next frame.
    pub(crate) fn number(&mut self) -> u64 {
        self.frames += 1;
        self.frames
    }

    /// What is to be sent now: texts first.
    pub(crate) fn take_text(&mut self) -> Option<ToPage> {
        self.texts.pop_front()
    }

    /// The frame that is to be sent now.
    pub(crate) fn take_frame(&mut self, now: Instant) -> Option<Frame> {
        let frame = self.frame.take()?;
        self.under_way.push_back((frame.header.frame, frame.bytes.len(), now));
        Some(frame)
    }

    /// The page has drawn a frame.
    pub(crate) fn acknowledged(&mut self, frame: u64, now: Instant) {
        while let Some(&(number, bytes, sent)) = self.under_way.front() {
            if number > frame {
                break;
            }
            self.under_way.pop_front();
            if number == frame {
                self.quality.arrived(bytes, sent, now);
            }
        }
    }
}
