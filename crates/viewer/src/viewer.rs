//! A viewer that runs.

use crate::renderer::Shared;
use crate::server::{self, Guard};
use crate::source::{SceneSource, SourceError};
use crate::watch;
use std::net::{IpAddr, Ipv4Addr, SocketAddr, TcpListener};
use std::sync::Arc;
use std::thread::JoinHandle;

/// Where a viewer listens.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ViewerOptions {
    /// The address: 127.0.0.1 unless others are to see it. Nothing is encrypted.
    pub address: IpAddr,
    /// The port; 0 is any that is free.
    pub port: u16,
    /// The token of an earlier viewer at this port ([`Viewer::token`]), so that its pages find this one; `None`, or what is none:
    /// a new one.
    pub token: Option<String>,
}

impl Default for ViewerOptions {
    fn default() -> ViewerOptions {
        ViewerOptions { address: IpAddr::V4(Ipv4Addr::LOCALHOST), port: 0, token: None }
    }
}

/// Why a viewer cannot start.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ViewerError {
    /// There is nothing to show.
    #[error(transparent)]
    Source(#[from] SourceError),
    /// The port cannot be listened on.
    #[error("cannot listen on {address}: {error}; name another port, or none for any that is free")]
    Listen {
        /// The address and port.
        address: SocketAddr,
        /// Why not.
        error: std::io::Error,
    },
    /// The system gives no thread or no random numbers.
    #[error("cannot start the viewer: {0}")]
    System(String),
}

/// A viewer that runs until it is dropped or ended.
pub struct Viewer {
    shared: Arc<Shared>,
    address: SocketAddr,
    token: String,
    stop_server: Option<tokio::sync::oneshot::Sender<()>>,
    threads: Vec<JoinHandle<()>>,
}

impl Viewer {
    /// Reads the scene and serves it to browsers, on threads of its own.
    ///
    /// # Errors
    ///
    /// Where the scene cannot be read or rendered, or the port is taken.
    pub fn start(source: Box<dyn SceneSource>, options: &ViewerOptions) -> Result<Viewer, ViewerError> {
        let wanted = SocketAddr::new(options.address, options.port);
        let listen = |error| ViewerError::Listen { address: wanted, error };
        let listener = TcpListener::bind(wanted).map_err(listen)?;
        listener.set_nonblocking(true).map_err(listen)?;
        let address = listener.local_addr().map_err(listen)?;
        let system = |error: &dyn std::fmt::Display| ViewerError::System(error.to_string());
        let guard = Guard::new(address.ip(), options.token.as_deref()).map_err(|error| system(&error))?;
        let token = guard.token().to_owned();
        let shared = Arc::new(Shared::open(source)?);
        let (stop_server, stopped) = tokio::sync::oneshot::channel();
        let runtime = tokio::runtime::Builder::new_current_thread()
            .enable_io()
            .enable_time()
            .build()
            .map_err(|error| system(&error))?;
        let mut viewer =
            Viewer { shared, address, token, stop_server: Some(stop_server), threads: Vec::new() };
        let shared = &viewer.shared;
        let (of_server, of_renderer, of_watcher) =
            (Arc::clone(shared), Arc::clone(shared), Arc::clone(shared));
        let start = |name: &str, work: Box<dyn FnOnce() + Send>| {
            std::thread::Builder::new().name(name.into()).spawn(work).map_err(|error| system(&error))
        };
        viewer.threads.push(start("renderer", Box::new(move || of_renderer.render()))?);
        viewer.threads.push(start("watcher", Box::new(move || watch::watch(&of_watcher)))?);
        let serve = move || runtime.block_on(server::serve(listener, of_server, guard, stopped));
        viewer.threads.push(start("server", Box::new(serve))?);
        Ok(viewer)
    }

    /// The address and port that it listens on.
    pub fn address(&self) -> SocketAddr {
        self.address
    }

    /// What lets pages in. Whoever has it may see the scene.
    pub fn token(&self) -> &str {
        &self.token
    }

    /// The address to open in a browser. Whoever has it may see the scene, and change what is rendered.
    pub fn url(&self) -> String {
        format!("http://{}/?token={}", self.address, self.token)
    }

    /// Ends it: pages are told nothing more.
    pub fn end(mut self) {
        self.stop();
    }

    fn stop(&mut self) {
        self.shared.end();
        if let Some(stop) = self.stop_server.take() {
            // Whoever listens is gone where the server has ended.
            let _ = stop.send(());
        }
        for thread in self.threads.drain(..) {
            // A thread that has panicked has said so.
            let _ = thread.join();
        }
    }
}

impl Drop for Viewer {
    fn drop(&mut self) {
        self.stop();
    }
}
