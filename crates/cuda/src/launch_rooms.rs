//! Room for launches of several frames at the same time: for as many as there is memory, and others wait.

use std::ops::{Deref, DerefMut};
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};

/// Rooms of a scene on a device.
pub(crate) struct LaunchRooms<T> {
    state: Mutex<State<T>>,
    given_back: Condvar,
    /// How many there may be, at least 1.
    most: u64,
}

struct State<T> {
    free: Vec<T>,
    /// How many there are, free or not.
    made: u64,
}

impl<T> LaunchRooms<T> {
    /// At most so many.
    pub(crate) fn new(most: u64) -> LaunchRooms<T> {
        let state = Mutex::new(State { free: Vec::new(), made: 0 });
        LaunchRooms { state, given_back: Condvar::new(), most: most.max(1) }
    }

    fn lock(&self) -> MutexGuard<'_, State<T>> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// One that was given back, if it suits, or else one that is made. Waits where there may be no more.
    ///
    /// # Errors
    ///
    /// Those of `make`.
    pub(crate) fn take<E>(
        &self,
        suits: impl Fn(&T) -> bool,
        make: impl FnOnce() -> Result<T, E>,
    ) -> Result<TakenRoom<'_, T>, E> {
        let mut state = self.lock();
        loop {
            // Those of smaller frames are dropped.
            while let Some(room) = state.free.pop() {
                if suits(&room) {
                    return Ok(TakenRoom { rooms: self, room: Some(room) });
                }
                state.made -= 1;
            }
            if state.made < self.most {
                break;
            }
            state = self.given_back.wait(state).unwrap_or_else(PoisonError::into_inner);
        }
        state.made += 1;
        drop(state);
        // If that fails, there is one less again.
        let mut taken = TakenRoom { rooms: self, room: None };
        taken.room = Some(make()?);
        Ok(taken)
    }
}

/// A room that is in use. Where something goes wrong with it, it is dropped.
pub(crate) struct TakenRoom<'a, T> {
    rooms: &'a LaunchRooms<T>,
    room: Option<T>,
}

impl<T> TakenRoom<'_, T> {
    /// For whoever needs it next.
    pub(crate) fn give_back(mut self) {
        let mut state = self.rooms.lock();
        // What is dropped after this counts as one that is gone.
        state.made += 1;
        state.free.extend(self.room.take());
    }
}

impl<T> Drop for TakenRoom<'_, T> {
    fn drop(&mut self) {
        drop(self.room.take());
        self.rooms.lock().made -= 1;
        self.rooms.given_back.notify_one();
    }
}

impl<T> Deref for TakenRoom<'_, T> {
    type Target = T;

    fn deref(&self) -> &T {
        self.room.as_ref().expect("it is there until it is given back")
    }
}

impl<T> DerefMut for TakenRoom<'_, T> {
    fn deref_mut(&mut self) -> &mut T {
        self.room.as_mut().expect("it is there until it is given back")
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::atomic::{AtomicU32, Ordering};

    fn take(rooms: &LaunchRooms<u32>, size: u32) -> TakenRoom<'_, u32> {
        rooms.take(|&room| room >= size, || Ok::<_, ()>(size)).unwrap()
    }

    /// How many there are, and how many of them are free.
    fn counts(rooms: &LaunchRooms<u32>) -> (u64, usize) {
        let state = rooms.lock();
        (state.made, state.free.len())
    }

    #[test]
    fn what_was_given_back_is_taken_again() {
        let rooms = LaunchRooms::new(2);
        take(&rooms, 5).give_back();
        let large = take(&rooms, 3);
        assert_eq!(*large, 5);
        let small = take(&rooms, 3);
        assert_eq!(*small, 3);
        small.give_back();
        // Too small: dropped, so that there may be another.
        assert_eq!(*take(&rooms, 4), 4);
        assert_eq!(counts(&rooms), (1, 0));
        large.give_back();
        assert_eq!(counts(&rooms), (1, 1));
    }

    #[test]
    fn one_that_cannot_be_made_does_not_count() {
        let rooms = LaunchRooms::<u32>::new(0);
        assert!(rooms.take(|_| true, || Err(())).is_err());
        assert_eq!(*take(&rooms, 1), 1);
    }

    #[test]
    fn there_are_never_more_than_may_be() {
        let (rooms, in_use, most) = (LaunchRooms::new(2), AtomicU32::new(0), AtomicU32::new(0));
        std::thread::scope(|scope| {
            for thread in 0..8 {
                let (rooms, in_use, most) = (&rooms, &in_use, &most);
                scope.spawn(move || {
                    for _ in 0..50 {
                        let room = take(rooms, 1);
                        most.fetch_max(in_use.fetch_add(1, Ordering::SeqCst) + 1, Ordering::SeqCst);
                        in_use.fetch_sub(1, Ordering::SeqCst);
                        // Some are lost.
                        if thread % 2 == 0 { room.give_back() } else { drop(room) }
                    }
                });
            }
        });
        assert!((1..=2).contains(&most.into_inner()));
        assert!(rooms.lock().made <= 2);
    }
}
