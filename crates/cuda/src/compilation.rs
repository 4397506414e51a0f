//! Loading texts that the driver may have to compile: side by side then.
//!
//! A driver compiles one text at a time for a context, whatever threads ask for. Of an H200, five kernels took 3.9 s like that, and
//! 1.3 s in contexts of their own. What it has compiled in one lies in its cache, from which all others load it in milliseconds. So
//! while a load takes long, texts that wait are compiled elsewhere, for the cache.

use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

/// A load that takes longer compiles.
const PATIENCE: Duration = Duration::from_millis(100);

/// How far a text is.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Stage {
    /// Nobody has it.
    Waiting,
    /// It is compiled elsewhere.
    Compiling,
    /// That is over.
    Compiled,
    /// It is being loaded, or was.
    Loaded,
}

/// How far all are.
struct Board {
    stages: Vec<Stage>,
    /// When the load that goes on has begun.
    loading_since: Option<Instant>,
    /// A load has failed: nothing is begun any more.
    has_failed: bool,
    /// How many may be compiled elsewhere at a time.
    at_once: usize,
}

/// What several threads know of it.
struct Shared {
    board: Mutex<Board>,
    changed: Condvar,
}

impl Shared {
    fn lock(&self) -> MutexGuard<'_, Board> {
        self.board.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn change(&self, change: impl FnOnce(&mut Board)) {
        change(&mut self.lock());
        self.changed.notify_all();
    }

    /// The number of a text to be loaded next, if there is one; waits for those that are compiled elsewhere.
    fn take(&self) -> Option<usize> {
        let mut board = self.lock();
        loop {
            let first = |wanted| board.stages.iter().position(|&stage| stage == wanted);
            if let Some(number) = first(Stage::Waiting).or(first(Stage::Compiled)) {
                board.stages[number] = Stage::Loaded;
                board.loading_since = Some(Instant::now());
                self.changed.notify_all();
                return Some(number);
            }
            first(Stage::Compiling)?;
            board = self.changed.wait(board).unwrap_or_else(PoisonError::into_inner);
        }
    }

    /// Waits until a load takes long. Whether this text still waits then; it does not any more.
    fn take_to_compile(&self, number: usize) -> bool {
        let mut board = self.lock();
        loop {
            if board.has_failed || board.stages[number] != Stage::Waiting {
                return false;
            }
            let loading = board.loading_since.map(|since| since.elapsed());
            let left = loading.map_or(PATIENCE, |loading| PATIENCE.saturating_sub(loading));
            let compiling = board.stages.iter().filter(|&&stage| stage == Stage::Compiling).count();
            if compiling >= board.at_once {
                board = self.changed.wait(board).unwrap_or_else(PoisonError::into_inner);
                continue;
            }
            if left.is_zero() {
                board.stages[number] = Stage::Compiling;
                return true;
            }
            board = self.changed.wait_timeout(board, left).unwrap_or_else(PoisonError::into_inner).0;
        }
    }
}

/// Sets a text's stage when it is over, also by a panic: the others would wait for ever.
struct Compiling<'a>(&'a Shared, usize);

impl Drop for Compiling<'_> {
    fn drop(&mut self) {
        self.0.change(|board| board.stages[self.1] = Stage::Compiled);
    }
}

/// Loads all texts of a number below `count` by `load`, one at a time. While one takes long, others are compiled by `compile`,
/// each on a thread of its own, before they are loaded.
///
/// # Errors
///
/// The first of `load`.
pub(crate) fn load_all<E>(
    count: usize,
    at_once: usize,
    compile: impl Fn(usize) + Sync,
    mut load: impl FnMut(usize) -> Result<(), E>,
) -> Result<(), E> {
    let board =
        Board { stages: vec![Stage::Waiting; count], loading_since: None, has_failed: false, at_once };
    let shared = Shared { board: Mutex::new(board), changed: Condvar::new() };
    std::thread::scope(|scope| {
        let (shared, compile) = (&shared, &compile);
        // Nobody is left to wait where none may compile, even if a load panics.
        let end = if at_once > 0 { count } else { 0 };
        for number in 1..end {
            scope.spawn(move || {
                if shared.take_to_compile(number) {
                    let _compiling = Compiling(shared, number);
                    compile(number);
                }
            });
        }
        while let Some(number) = shared.take() {
            let loaded = load(number);
            shared.change(|board| (board.loading_since, board.has_failed) = (None, loaded.is_err()));
            loaded?;
        }
        Ok(())
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::atomic::{AtomicU32, Ordering};

    /// Loads so many, of which the first takes so long. How often each was compiled, and the order of loads.
    fn load_slowly(count: usize, at_once: usize, first: Duration) -> (Vec<u32>, Vec<usize>) {
        let compiled: Vec<AtomicU32> = (0..count).map(|_| AtomicU32::new(0)).collect();
        let mut loaded = Vec::new();
        let compiling = AtomicU32::new(0);
        let compile = |number: usize| {
            assert!(compiling.fetch_add(1, Ordering::Relaxed) < at_once as u32);
            compiled[number].fetch_add(1, Ordering::Relaxed);
            compiling.fetch_sub(1, Ordering::Relaxed);
        };
        let load = |number: usize| {
            loaded.push(number);
            std::thread::sleep(if number == 0 { first } else { Duration::ZERO });
            Ok::<(), ()>(())
        };
        load_all(count, at_once, compile, load).unwrap();
        (compiled.into_iter().map(AtomicU32::into_inner).collect(), loaded)
    }

    #[test]
    fn each_is_loaded_once() {
        for count in [0, 1, 2, 7] {
            for (at_once, first) in
                [(7, Duration::ZERO), (7, 3 * PATIENCE), (1, 3 * PATIENCE), (0, 3 * PATIENCE)]
            {
                let (compiled, mut loaded) = load_slowly(count, at_once, first);
                loaded.sort_unstable();
                assert_eq!(loaded, (0..count).collect::<Vec<_>>());
                assert!(compiled.iter().all(|&times| times <= u32::from(at_once > 0)), "{compiled:?}");
            }
        }
    }

    #[test]
    fn a_load_waits_for_the_compilation() {
        let is_compiled = AtomicU32::new(0);
        let compile = |_: usize| {
            is_compiled.fetch_add(1, Ordering::Relaxed);
            std::thread::sleep(2 * PATIENCE);
            is_compiled.fetch_add(1, Ordering::Relaxed);
        };
        let load = |number: usize| {
            // The first does not go on before another text has been taken.
            while number == 0 && is_compiled.load(Ordering::Relaxed) == 0 {
                std::thread::sleep(Duration::from_millis(1));
            }
            if number == 1 {
                assert_eq!(is_compiled.load(Ordering::Relaxed), 2);
            }
            Ok::<(), ()>(())
        };
        load_all(2, 1, compile, load).unwrap();
    }

    #[test]
    fn nothing_follows_a_load_that_fails() {
        let mut loaded = Vec::new();
        let load = |number: usize| {
            loaded.push(number);
            if number == 1 { Err("no") } else { Ok(()) }
        };
        assert_eq!(load_all(4, 4, |_| (), load), Err("no"));
        assert_eq!(loaded.last(), Some(&1));
    }

    #[test]
    fn a_panic_elsewhere_ends_nothing_for_ever() {
        let started = AtomicU32::new(0);
        let compile = |_: usize| {
            started.fetch_add(1, Ordering::Relaxed);
            panic!("compiling");
        };
        let load = |number: usize| {
            while number == 0 && started.load(Ordering::Relaxed) == 0 {
                std::thread::sleep(Duration::from_millis(1));
            }
            Ok::<(), ()>(())
        };
        let all = || load_all(2, 1, compile, load);
        assert!(std::panic::catch_unwind(std::panic::AssertUnwindSafe(all)).is_err());
    }
}
