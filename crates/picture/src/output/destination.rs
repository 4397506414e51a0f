//! Where encoders write to.

use std::fs::File;
use std::io::{BufWriter, Error, Result, Seek, SeekFrom, Write};
use std::sync::{Arc, Mutex, MutexGuard};

/// A buffered file that an encoder and the picture's writer share. Some encoders swallow errors when they are dropped:
/// the first one is remembered, and [`Destination::finish`] gives it out.
#[derive(Clone)]
pub(super) struct Destination(Arc<Mutex<State>>);

struct State {
    file: BufWriter<File>,
    failed: Option<Error>,
}

impl Destination {
    pub(super) fn new(file: File) -> Destination {
        let file = BufWriter::with_capacity(1 << 18, file);
        Destination(Arc::new(Mutex::new(State { file, failed: None })))
    }

    /// Empties the buffer. Fails where anything failed before.
    pub(super) fn finish(&self) -> Result<()> {
        let mut state = self.lock();
        match state.failed.take() {
            Some(error) => Err(error),
            None => state.file.flush(),
        }
    }

    /// Writes over what is at `offset`, and goes back to the end.
    pub(super) fn patch(&mut self, offset: u64, bytes: &[u8]) -> Result<()> {
        self.seek(SeekFrom::Start(offset))?;
        self.write_all(bytes)?;
        self.seek(SeekFrom::End(0)).map(|_| ())
    }

    fn lock(&self) -> MutexGuard<'_, State> {
        self.0.lock().unwrap_or_else(|poisoned| poisoned.into_inner())
    }

    fn attempt<T>(&self, action: impl FnOnce(&mut BufWriter<File>) -> Result<T>) -> Result<T> {
        let mut state = self.lock();
        let result = action(&mut state.file);
        if let (Err(error), None) = (&result, &state.failed) {
            let copy = error.raw_os_error().map_or_else(|| error.kind().into(), Error::from_raw_os_error);
            state.failed = Some(copy);
        }
        result
    }
}

impl Write for Destination {
    fn write(&mut self, bytes: &[u8]) -> Result<usize> {
        self.attempt(|file| file.write(bytes))
    }

    fn flush(&mut self) -> Result<()> {
        self.attempt(|file| file.flush())
    }
}

impl Seek for Destination {
    fn seek(&mut self, to: SeekFrom) -> Result<u64> {
        self.attempt(|file| file.seek(to))
    }
}
