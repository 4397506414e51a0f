//! A listener that lets so many connections in at a time, and none that stays silent.

use std::io;
use std::pin::Pin;
use std::sync::Arc;
use std::task::{Context, Poll};
use std::time::Duration;
use tokio::io::{AsyncRead, AsyncWrite, ReadBuf};
use tokio::net::{TcpListener, TcpStream};
use tokio::sync::{OwnedSemaphorePermit, Semaphore};
use tokio::time::{Instant, Sleep, sleep_until};

/// Connections at a time; a page needs one for its socket, and some for a moment when it loads.
const MAX_CONNECTIONS: usize = 128;

/// A connection that sends nothing for so long is closed. Pages send a sign of life more often.
const SILENCE: Duration = Duration::from_secs(30);

/// The listener.
pub(super) struct Limited {
    listener: TcpListener,
    room: Arc<Semaphore>,
}

impl Limited {
    pub(super) fn new(listener: TcpListener) -> Limited {
        Limited { listener, room: Arc::new(Semaphore::new(MAX_CONNECTIONS)) }
    }

    /// The next connection.
    pub(super) async fn accept(&self) -> Connection {
        loop {
            let Ok((stream, _)) = self.listener.accept().await else {
                // Too many files are open, say: who waits a moment may find room.
                tokio::time::sleep(Duration::from_millis(50)).await;
                continue;
            };
            // Beyond the limit connections are closed at once: waiting for room would be waiting for whoever holds it.
            let Ok(permit) = Arc::clone(&self.room).try_acquire_owned() else { continue };
            // Frames are sent whole; input must not wait for more input.
            let _ = stream.set_nodelay(true);
            let silent = Box::pin(sleep_until(Instant::now() + SILENCE));
            return Connection { stream, silent, _permit: permit };
        }
    }
}

/// A connection that has its place among them.
pub(super) struct Connection {
    stream: TcpStream,
    /// Ends when it has been silent for too long.
    silent: Pin<Box<Sleep>>,
    _permit: OwnedSemaphorePermit,
}

impl AsyncRead for Connection {
    fn poll_read(
        mut self: Pin<&mut Self>,
        context: &mut Context<'_>,
        buffer: &mut ReadBuf<'_>,
    ) -> Poll<io::Result<()>> {
        match Pin::new(&mut self.stream).poll_read(context, buffer) {
            Poll::Ready(done) => {
                self.silent.as_mut().reset(Instant::now() + SILENCE);
                Poll::Ready(done)
            }
            Poll::Pending => match self.silent.as_mut().poll(context) {
                Poll::Ready(()) => Poll::Ready(Err(io::ErrorKind::TimedOut.into())),
                Poll::Pending => Poll::Pending,
            },
        }
    }
}

impl AsyncWrite for Connection {
    fn poll_write(
        mut self: Pin<&mut Self>,
        context: &mut Context<'_>,
        bytes: &[u8],
    ) -> Poll<io::Result<usize>> {
        Pin::new(&mut self.stream).poll_write(context, bytes)
    }

    fn poll_flush(mut self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<io::Result<()>> {
        Pin::new(&mut self.stream).poll_flush(context)
    }

    fn poll_shutdown(mut self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<io::Result<()>> {
        Pin::new(&mut self.stream).poll_shutdown(context)
    }
}
