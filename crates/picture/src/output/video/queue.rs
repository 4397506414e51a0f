//! What encoding threads and callers share: which frames are there, which segments wait, what went wrong.

use super::folder::Found;
use super::settings::Settings;
use super::{SEGMENT_FRAMES, misuse};
use std::collections::VecDeque;
use std::io::Error;
use std::sync::{Condvar, Mutex, MutexGuard};

pub(super) struct Queue<E> {
    state: Mutex<State<E>>,
    changed: Condvar,
}

struct State<E> {
    /// Frames that are stored or encoded.
    frames: Vec<bool>,
    /// Frames that a segment lacks.
    lacking: Vec<u32>,
    /// Segments whose frames are all there and that nobody encodes yet.
    waiting: VecDeque<u32>,
    /// Segments that are not encoded.
    unfinished: u32,
    /// Frames of encoded segments.
    encoded: u32,
    failure: Option<E>,
    /// Threads are to end: something failed, or nobody needs them any more.
    stopped: bool,
}

impl<E> Queue<E> {
    pub(super) fn new(settings: &Settings, found: Found) -> Queue<E> {
        let Found { segments, frames } = found;
        let lacking = |segment| {
            let range = settings.frames_of(segment);
            frames[range.start as usize..range.end as usize].iter().filter(|there| !**there).count() as u32
        };
        let lacking: Vec<u32> = (0..settings.segments()).map(lacking).collect();
        let to_do = || (0..settings.segments()).filter(|&segment| !segments[segment as usize]);
        let state = State {
            waiting: to_do().filter(|&segment| lacking[segment as usize] == 0).collect(),
            unfinished: to_do().count() as u32,
            encoded: settings.frames - to_do().map(|s| settings.frames_of(s).len() as u32).sum::<u32>(),
            frames,
            lacking,
            failure: None,
            stopped: false,
        };
        Queue { state: Mutex::new(state), changed: Condvar::new() }
    }

    fn lock(&self) -> MutexGuard<'_, State<E>> {
        self.state.lock().unwrap_or_else(|poisoned| poisoned.into_inner())
    }

    pub(super) fn missing(&self) -> Vec<u32> {
        let state = self.lock();
        (0..).zip(&state.frames).filter(|(_, there)| !**there).map(|(number, _)| number).collect()
    }

    /// Whether that frame is still to be stored; an error where there is no such frame, or where it makes no sense
    /// to go on.
    pub(super) fn lacks(&self, number: u32) -> Result<bool, Refusal<E>> {
        let mut state = self.lock();
        if state.stopped {
            return Err(state.refusal());
        }
        match state.frames.get(number as usize) {
            Some(there) => Ok(!there),
            None => Err(Refusal::Misuse(misuse(format!(
                "there is no frame {number}; the video has {}",
                state.frames.len()
            )))),
        }
    }

    /// A frame is stored. The last one of a segment wakes a thread.
    pub(super) fn stored(&self, number: u32) {
        let mut state = self.lock();
        let segment = number / SEGMENT_FRAMES;
        if !std::mem::replace(&mut state.frames[number as usize], true) {
            state.lacking[segment as usize] -= 1;
            if state.lacking[segment as usize] == 0 {
                state.waiting.push_back(segment);
                self.changed.notify_all();
            }
        }
    }

    /// A segment to encode, as soon as there is one; `None` when there will be no more.
    pub(super) fn next(&self) -> Option<u32> {
        let mut state = self.lock();
        loop {
            if state.stopped || state.unfinished == 0 {
                return None;
            }
            match state.waiting.pop_front() {
                Some(segment) => return Some(segment),
                None => state = self.changed.wait(state).unwrap_or_else(|poisoned| poisoned.into_inner()),
            }
        }
    }

    pub(super) fn finished(&self, frames: u32) {
        let mut state = self.lock();
        state.unfinished -= 1;
        state.encoded += frames;
        self.changed.notify_all();
    }

    /// The first failure is the one that is reported.
    pub(super) fn fail(&self, failure: E) {
        let mut state = self.lock();
        if !state.stopped {
            state.failure = Some(failure);
        }
        state.stopped = true;
        self.changed.notify_all();
    }

    pub(super) fn stop(&self) {
        self.lock().stopped = true;
        self.changed.notify_all();
    }

    pub(super) fn is_stopped(&self) -> bool {
        self.lock().stopped
    }

    pub(super) fn encoded(&self) -> u32 {
        self.lock().encoded
    }

    /// Waits until all segments are encoded.
    pub(super) fn wait(&self) -> Result<(), Refusal<E>> {
        let mut state = self.lock();
        let missing = state.frames.iter().filter(|there| !**there).count();
        while !state.stopped && missing == 0 && state.unfinished > 0 {
            state = self.changed.wait(state).unwrap_or_else(|poisoned| poisoned.into_inner());
        }
        match state.stopped {
            true => Err(state.refusal()),
            false if missing > 0 => {
                Err(Refusal::Misuse(misuse(format!("{missing} of its frames are missing"))))
            }
            false => Ok(()),
        }
    }
}

/// Why the queue takes nothing.
pub(super) enum Refusal<E> {
    /// A thread failed.
    Failed(E),
    /// The caller asks for what cannot be.
    Misuse(Error),
}

impl<E> State<E> {
    fn refusal(&mut self) -> Refusal<E> {
        match self.failure.take() {
            Some(failure) => Refusal::Failed(failure),
            None => Refusal::Misuse(Error::other("it was given up after an error before")),
        }
    }
}
