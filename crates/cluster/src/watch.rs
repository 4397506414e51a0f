//! Who has been silent for too long.

use std::time::{Duration, Instant};

/// When the others were last heard. At first, all of them just now.
pub(crate) struct Watch {
    silence: Option<Duration>,
    heard: Vec<Instant>,
    looked: Instant,
    spoke: Instant,
}

impl Watch {
    pub(crate) fn new(silence: Option<Duration>, ranks: u32, now: Instant) -> Watch {
        Watch { silence, heard: vec![now; ranks as usize], looked: now, spoke: now }
    }

    pub(crate) fn hear(&mut self, rank: u32, now: Instant) {
        self.heard[rank as usize] = now;
    }

    /// Whether it is time to give a sign of life, or to ask for one.
    pub(crate) fn is_time_to_speak(&mut self, now: Instant) -> bool {
        let is_time = self.silence.is_some_and(|silence| now - self.spoke >= silence / 4);
        if is_time {
            self.spoke = now;
        }
        is_time
    }

    /// A rank among these that has been silent for longer than it may, and `patience` more, and for how long it has. Is to
    /// be asked often: time in which this process itself was stopped is nobody's silence.
    pub(crate) fn silent(
        &mut self,
        ranks: std::ops::Range<u32>,
        patience: Duration,
        now: Instant,
    ) -> Option<(u32, Duration)> {
        let silence = self.silence?;
        let gap = now - self.looked;
        self.looked = now;
        if gap > silence / 4 {
            self.heard.iter_mut().for_each(|heard| *heard = (*heard + gap).min(now));
        }
        ranks.into_iter().find_map(|rank| {
            let quiet = now.saturating_duration_since(self.heard[rank as usize]);
            (quiet > silence + patience).then_some((rank, quiet))
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_rank_is_silent_when_it_was_not_heard_for_longer_than_it_may() {
        let start = Instant::now();
        let at = |seconds: f64| start + Duration::from_secs_f64(seconds);
        let mut watch = Watch::new(Some(Duration::from_secs(2)), 3, start);
        watch.hear(1, at(0.1));
        watch.hear(2, at(1.0));
        let mut silent =
            |patience, to| watch.silent(1..3, Duration::from_secs(patience), to).map(|silent| silent.0);
        for tenth in 0..=21 {
            assert_eq!(silent(0, at(f64::from(tenth) / 10.0)), None);
        }
        assert_eq!(silent(0, at(2.2)), Some(1));
        assert_eq!(silent(1, at(2.3)), None);
    }

    #[test]
    fn own_stops_are_nobodys_silence() {
        let start = Instant::now();
        let at = |seconds: u64| start + Duration::from_secs(seconds);
        let mut watch = Watch::new(Some(Duration::from_secs(4)), 2, start);
        watch.hear(1, start);
        assert_eq!(watch.silent(1..2, Duration::ZERO, at(60)), None);
        assert!((61..=64).all(|second| watch.silent(1..2, Duration::ZERO, at(second)).is_none()));
        assert!(watch.silent(1..2, Duration::ZERO, at(65)).is_some());
    }

    #[test]
    fn for_ever_is_for_ever() {
        let start = Instant::now();
        let mut watch = Watch::new(None, 2, start);
        assert_eq!(watch.silent(0..2, Duration::ZERO, start + Duration::from_secs(1 << 20)), None);
        assert!(!watch.is_time_to_speak(start + Duration::from_secs(1 << 20)));
    }
}
