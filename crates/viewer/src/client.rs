//! What the server knows of a page.

use crate::hover::Hover;
use crate::message::{Frame, FrameHeader, ToPage};
use crate::page_view::PageView;
use crate::progress::Progress;
use crate::quality::Quality;
use crate::video::Video;
use crate::video_quality::VideoQuality;
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
    pub(crate) video: Video,
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
    /// It decodes H.264.
    decodes_h264: bool,
    /// That of moving frames which go as video.
    video: Option<VideoQuality>,
    /// The picture at rest, as far as it is.
    pub(crate) progress: Option<Progress>,
    /// The newest frame that is still to be sent, or what is left of it.
    frame: Option<Frame>,
    texts: VecDeque<ToPage>,
    /// Frames that were sent and not acknowledged.
    under_way: VecDeque<UnderWay>,
    frames: u64,
}

/// A frame that was sent and not acknowledged.
struct UnderWay {
    number: u64,
    bytes: usize,
    /// When the pong to the ping before the frame came.
    began: Option<Instant>,
}

/// On which side of a frame a ping is sent. Browsers send pongs by themselves, however busy the page's script is: the time between
/// the two pongs is what the frame took on the line, without the round trip and without what was queued before it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Side {
    Before,
    After,
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
        Client {
            number,
            state: Mutex::default(),
            hover: Hover::default(),
            video: Video::default(),
            to_send,
            cancel,
        }
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
            // What is left of a picture at rest would only hold up what comes now.
            state.frame.take_if(|frame| frame.header.at_rest);
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

    /// Takes what the page says of its decoder.
    pub(crate) fn decodes_h264(&mut self, does: bool) {
        self.decodes_h264 = does && cfg!(feature = "video");
        self.video.take_if(|_| !does);
    }

    /// How the next moving frame is encoded as video, if it is. Where no encoder is running and the line has become quick enough,
    /// frames are JPEGs again.
    pub(crate) fn next_video(&mut self, is_running: bool) -> Option<VideoQuality> {
        let line = self.quality.line();
        if !is_running && self.video.is_some_and(|video| video.is_needless(line)) {
            self.video = None;
            self.quality = self.quality.restarted();
        }
        self.video
    }

    /// Learns from a moving frame that took so long to be made; `is_key` is `None` for JPEGs.
    pub(crate) fn made_moving(&mut self, took: Duration, bytes: usize, is_key: Option<bool>) {
        match (&mut self.video, is_key) {
            (Some(video), Some(is_key)) => video.encoded(took, bytes, is_key, self.quality.line()),
            (_, Some(_)) => {}
            (_, None) => {
                self.quality.rendered(took, bytes);
                if self.decodes_h264 && self.video.is_none() && self.quality.is_too_slow_for_jpegs() {
                    self.video = Some(VideoQuality::new(self.quality.scale()));
                }
            }
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

    /// The frame that is to be sent now, or a piece of one at rest.
    pub(crate) fn take_frame(&mut self) -> Option<Frame> {
        if self.under_way.len() >= FRAMES_UNDER_WAY {
            return None;
        }
        let mut frame = self.frame.take()?;
        let [piece, _] = frame.header.piece;
        let most = self.quality.piece_bytes();
        frame.header.piece[1] = piece + 1;
        if frame.header.at_rest && frame.bytes.len() > most {
            // What is known of the line changes: as many more as it looks now.
            frame.header.piece[1] = piece + frame.bytes.len().div_ceil(most) as u32;
            let rest = frame.bytes.split_off(most);
            let header = FrameHeader {
                frame: self.number(),
                piece: [piece + 1, frame.header.piece[1]],
                ..frame.header.clone()
            };
            self.frame = Some(Frame { header, bytes: rest });
        }
        let (number, bytes) = (frame.header.frame, frame.bytes.len());
        self.under_way.push_back(UnderWay { number, bytes, began: None });
        Some(frame)
    }

    /// The pong to the ping on this side of a frame has come. Pongs without a ping change nothing.
    pub(crate) fn ponged(&mut self, frame: u64, side: Side, now: Instant) {
        let Some(under_way) = self.under_way.iter_mut().find(|under_way| under_way.number == frame) else {
            return;
        };
        match (side, under_way.began) {
            (Side::Before, None) => under_way.began = Some(now),
            (Side::After, Some(began)) => {
                under_way.began = None;
                let bytes = under_way.bytes;
                self.quality.passed(bytes, now.duration_since(began));
            }
            _ => {}
        }
    }

    /// The page has drawn a frame.
    pub(crate) fn acknowledged(&mut self, frame: u64) {
        while self.under_way.front().is_some_and(|under_way| under_way.number <= frame) {
            self.under_way.pop_front();
        }
    }
}

impl Side {
    /// The payload of a ping, which its pong repeats.
    pub(crate) fn ping(self, frame: u64) -> Vec<u8> {
        let mut text = frame.to_le_bytes().to_vec();
        text.push(u8::from(self == Side::After));
        text
    }

    /// Which ping a pong is to.
    pub(crate) fn of_pong(payload: &[u8]) -> Option<(u64, Side)> {
        let (frame, side) = payload.split_first_chunk()?;
        let side = match side {
            [0] => Side::Before,
            [1] => Side::After,
            _ => return None,
        };
        Some((u64::from_le_bytes(*frame), side))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::message::{FrameHeader, Milliseconds};

    fn view() -> PageView {
        let scene = eosphor::load("builtin:cornell", &eosphor::LoadOptions::default()).unwrap().scene;
        PageView::of(&scene).unwrap()
    }

    fn frame(number: u64, bytes: usize) -> Frame {
        let header = FrameHeader {
            frame: number,
            input: 1,
            version: 1,
            size: [64, 36],
            full: [64, 36],
            samples: 1,
            all_samples: 1,
            at_rest: false,
            piece: [0, 1],
            key: true,
            format: "image/jpeg",
            milliseconds: Milliseconds::default(),
        };
        Frame { header, bytes: vec![0; bytes] }
    }

    #[test]
    fn pictures_at_rest_go_in_pieces_and_make_room_for_a_camera_that_moves() {
        let client = Client::new(1);
        let piece = Quality::default().piece_bytes();
        let at_rest = || {
            let mut frame = frame(client.state().number(), 3 * piece + 7);
            frame.header.at_rest = true;
            client.show(frame);
        };
        let take = || {
            client
                .state()
                .take_frame()
                .map(|frame| (frame.header.piece, frame.header.frame, frame.bytes.len()))
        };
        at_rest();
        assert_eq!((take(), take()), (Some(([0, 4], 1, piece)), Some(([1, 4], 2, piece))));
        // No more than two are under way.
        assert_eq!(take(), None);
        client.state().acknowledged(1);
        assert_eq!(take(), Some(([2, 4], 3, piece)));
        client.state().acknowledged(3);
        assert_eq!((take(), take()), (Some(([3, 4], 4, 7)), None));
        client.state().acknowledged(4);
        // Those that are left are not sent any more when the camera moves.
        at_rest();
        assert_eq!(take().map(|(piece, ..)| piece), Some([0, 4]));
        client.want(view(), 2, true);
        assert_eq!(take(), None);
        // A moving frame is one piece, whatever it has.
        client.show(frame(9, 100 * piece));
        assert_eq!(take(), Some(([0, 1], 9, 100 * piece)));
    }

    /// Only pages that decode H.264 get it, and only where the line is too slow for JPEGs.
    #[test]
    fn video_is_for_slow_lines() {
        let client = Client::new(1);
        let mut state = client.state();
        let took = Duration::from_millis(20);
        let slow = |state: &mut ClientState| {
            state.quality.passed(10_000, Duration::from_millis(40));
            state.made_moving(took, 10_000, None);
        };
        (0..50).for_each(|_| slow(&mut state));
        assert!(state.next_video(false).is_none());
        state.decodes_h264(true);
        slow(&mut state);
        assert_eq!(state.next_video(false).is_some(), cfg!(feature = "video"));
        if cfg!(feature = "video") {
            // While it runs it stays, and where none runs a quick line ends it.
            state.made_moving(took, 2_000, Some(true));
            state.made_moving(took, 2_000, Some(false));
            (0..100).for_each(|_| state.quality.passed(1_000_000, Duration::from_millis(10)));
            assert!(state.next_video(true).is_some());
            assert!(state.next_video(false).is_none());
            // JPEGs begin anew, on a line that is quick enough.
            state.made_moving(took, 10_000, None);
            assert!(state.next_video(false).is_none());
            // A page whose decoder fails gets none.
            (0..50).for_each(|_| slow(&mut state));
            assert!(state.next_video(false).is_some());
            state.decodes_h264(false);
            slow(&mut state);
            assert!(state.next_video(false).is_none());
        }
    }

    #[test]
    fn pongs_tell_how_long_a_frame_was_on_the_line() {
        let (client, start) = (Client::new(1), Instant::now());
        let at = |ms| start + Duration::from_millis(ms);
        for number in 1..=2 {
            client.show(frame(number, 100_000));
            assert!(client.state().take_frame().is_some());
        }
        let mut state = client.state();
        // Pongs that make no sense change nothing.
        assert_eq!(Side::of_pong(b"hello"), None);
        assert_eq!(Side::of_pong(&[0; 10]), None);
        state.ponged(1, Side::After, at(1));
        state.ponged(7, Side::Before, at(1));
        assert_eq!(state.quality.line(), None);
        // Half a second of round trip does not count, nor does the other frame.
        for (number, side, ms) in
            [(1, Side::Before, 500), (1, Side::After, 600), (2, Side::Before, 600), (2, Side::After, 700)]
        {
            let payload = side.ping(number);
            assert_eq!(Side::of_pong(&payload), Some((number, side)));
            state.ponged(number, side, at(ms));
        }
        assert!((state.quality.line().unwrap() / 1e6 - 1.0).abs() < 1e-3);
        // What was acknowledged is done.
        state.acknowledged(2);
        state.ponged(2, Side::Before, at(800));
        assert!(state.under_way.is_empty());
    }
}
