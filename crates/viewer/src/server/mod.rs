//! The server: a page, and a WebSocket for each page that is open.

mod guard;
mod limited;
mod socket;

pub(crate) use guard::Guard;

use crate::client::Client;
use crate::export;
use crate::message::MAX_MESSAGE;
use crate::renderer::Shared;
use axum::Router;
use axum::extract::{Request, State, WebSocketUpgrade};
use axum::http::{HeaderName, HeaderValue, StatusCode, header};
use axum::middleware::{self, Next};
use axum::response::{IntoResponse, Redirect, Response};
use axum::routing::get;
use hyper::server::conn::http1;
use hyper_util::rt::TokioIo;
use hyper_util::service::TowerToHyperService;
use limited::Limited;
use std::net::TcpListener;
use std::sync::Arc;
use tokio::sync::oneshot;

const PAGE: &str = include_str!("../page/index.html");
const STYLE: &str = include_str!("../page/style.css");

/// Where the page names its scripts.
const PLACE_OF_SCRIPTS: &str = "<!-- scripts -->";

/// The page's scripts: modules, which load each other by these names; `viewer.js` is the first.
const SCRIPTS: [(&str, &str); 22] = [
    ("/camera.js", include_str!("../page/camera.js")),
    ("/changes.js", include_str!("../page/changes.js")),
    ("/device.js", include_str!("../page/device.js")),
    ("/elements.js", include_str!("../page/elements.js")),
    ("/export.js", include_str!("../page/export.js")),
    ("/focus.js", include_str!("../page/focus.js")),
    ("/frames.js", include_str!("../page/frames.js")),
    ("/keys.js", include_str!("../page/keys.js")),
    ("/memory.js", include_str!("../page/memory.js")),
    ("/messages.js", include_str!("../page/messages.js")),
    ("/page_state.js", include_str!("../page/page_state.js")),
    ("/picture.js", include_str!("../page/picture.js")),
    ("/pixel_value.js", include_str!("../page/pixel_value.js")),
    ("/pointer.js", include_str!("../page/pointer.js")),
    ("/problem.js", include_str!("../page/problem.js")),
    ("/settings.js", include_str!("../page/settings.js")),
    ("/socket.js", include_str!("../page/socket.js")),
    ("/statistics.js", include_str!("../page/statistics.js")),
    ("/time.js", include_str!("../page/time.js")),
    ("/vectors.js", include_str!("../page/vectors.js")),
    ("/video.js", include_str!("../page/video.js")),
    ("/viewer.js", include_str!("../page/viewer.js")),
];

/// What is said to who has no token.
const NO_TOKEN: &str = "open the address that `eosphor view` printed, with its token";

/// What a page may load and do: only what this server has.
const POLICY: &str = "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' blob:; connect-src 'self'; \
    base-uri 'none'; form-action 'none'; frame-ancestors 'none'";

/// Longest request without its body, in bytes. Those of browsers have about 1,000.
const MAX_REQUEST: usize = 16 * 1024;

/// What is read of a socket at a time, in bytes: a view has 500. The library's own buffer has 128 KiB.
const READ_BUFFER: usize = 4 * 1024;

#[derive(Clone)]
struct Site {
    shared: Arc<Shared>,
    guard: Arc<Guard>,
}

/// Serves pages until it is stopped.
pub(crate) async fn serve(
    listener: TcpListener,
    shared: Arc<Shared>,
    guard: Guard,
    stopped: oneshot::Receiver<()>,
) {
    let Ok(listener) = tokio::net::TcpListener::from_std(listener) else { return };
    let site = Site { shared, guard: Arc::new(guard) };
    let scripts = SCRIPTS.into_iter().fold(Router::new(), |router, (path, text)| {
        router.route(path, get(move || async move { file("text/javascript; charset=utf-8", text) }))
    });
    let router = Router::new()
        .route("/", get(page))
        .route("/style.css", get(|| async { file("text/css; charset=utf-8", STYLE) }))
        .merge(scripts)
        // Browsers ask for it; there is none.
        .route("/favicon.ico", get(|| async { StatusCode::NO_CONTENT }))
        .route("/socket", get(open_socket))
        .route("/scene.json", get(scene_file))
        .route("/picture.exr", get(exr_file))
        .layer(middleware::from_fn_with_state(site.clone(), check))
        .with_state(site);
    // Sockets that are open do not hold up the end.
    tokio::select! {
        () = accept(Limited::new(listener), router) => {}
        _ = stopped => {}
    }
}

/// Serves each connection on its own. `axum::serve` would, too, but takes 400 KiB of request before it refuses one as too long.
async fn accept(listener: Limited, router: Router) {
    let mut http = http1::Builder::new();
    http.max_buf_size(MAX_REQUEST);
    loop {
        let connection = TokioIo::new(listener.accept().await);
        let service = TowerToHyperService::new(router.clone());
        // What goes wrong with a connection ends that one alone.
        tokio::spawn(http.serve_connection(connection, service).with_upgrades());
    }
}

/// What every request has to pass, and what every answer says.
async fn check(State(site): State<Site>, request: Request, next: Next) -> Response {
    let mut response = match site.guard.check_host(request.headers()) {
        true => next.run(request).await,
        false => refuse("this server is not called so"),
    };
    let headers = response.headers_mut();
    let mut say = |name: HeaderName, value: &'static str| {
        headers.insert(name, HeaderValue::from_static(value));
    };
    say(header::CONTENT_SECURITY_POLICY, POLICY);
    say(header::X_CONTENT_TYPE_OPTIONS, "nosniff");
    say(header::REFERRER_POLICY, "no-referrer");
    say(header::CACHE_CONTROL, "no-store");
    response
}

/// Names all scripts, so that browsers load them at once and not one after the other, as they import each other.
fn preloaded_scripts() -> String {
    let link = |(path, _)| format!("<link rel=\"modulepreload\" href=\"{path}\">\n");
    SCRIPTS.map(link).concat()
}

/// The page; who comes with the token gets a cookie, and the token leaves the address bar.
async fn page(State(site): State<Site>, request: Request) -> Response {
    // A token is of letters and digits, which nothing is escaped in.
    let mut pairs = request.uri().query().unwrap_or_default().split('&');
    let token = pairs.find_map(|pair| pair.strip_prefix("token="));
    if token.is_some_and(|token| site.guard.is_token(token)) {
        let mut response = Redirect::to("/").into_response();
        if let Ok(cookie) = HeaderValue::from_str(&site.guard.cookie(request.headers())) {
            response.headers_mut().insert(header::SET_COOKIE, cookie);
        }
        return response;
    }
    match site.guard.is_known(request.headers()) {
        true => {
            let page = PAGE.replacen(PLACE_OF_SCRIPTS, &preloaded_scripts(), 1);
            ([(header::CONTENT_TYPE, "text/html; charset=utf-8")], page).into_response()
        }
        false => refuse(NO_TOKEN),
    }
}

async fn open_socket(State(site): State<Site>, socket: WebSocketUpgrade, request: Request) -> Response {
    if !site.guard.is_known(request.headers()) {
        return refuse(NO_TOKEN);
    }
    if !site.guard.is_own_page(request.headers()) {
        return refuse("pages of other sites may not see this");
    }
    let Some(client) = site.shared.enter() else {
        return (StatusCode::SERVICE_UNAVAILABLE, "too many pages are open\n").into_response();
    };
    let shared = Arc::clone(&site.shared);
    let failed = (Arc::clone(&site.shared), Arc::clone(&client));
    socket
        .max_message_size(MAX_MESSAGE)
        .max_frame_size(MAX_MESSAGE)
        .read_buffer_size(READ_BUFFER)
        .on_failed_upgrade(move |_| failed.0.leave(&failed.1))
        .on_upgrade(move |socket| socket::run(socket, shared, client))
}

/// The scene file of a page's view.
async fn scene_file(State(site): State<Site>, request: Request) -> Response {
    let make = |shared: &Shared, client: &Client| export::scene_file(shared, client).map(String::into_bytes);
    made_file(asking_page(&site, &request), site, "application/json", make).await
}

/// The picture of a page in linear colours.
async fn exr_file(State(site): State<Site>, request: Request) -> Response {
    made_file(asking_page(&site, &request), site, "image/x-exr", export::exr).await
}

/// The page whose number a request names (`?page=7`), or what the request is told.
fn asking_page(site: &Site, request: &Request) -> Result<Arc<Client>, (StatusCode, &'static str)> {
    if !site.guard.is_known(request.headers()) {
        return Err((StatusCode::FORBIDDEN, NO_TOKEN));
    }
    let mut pairs = request.uri().query().unwrap_or_default().split('&');
    let number = pairs.find_map(|pair| pair.strip_prefix("page=")?.parse().ok());
    let page = number.and_then(|number| site.shared.page(number));
    page.ok_or((StatusCode::NOT_FOUND, "there is no such page; load it again"))
}

/// A file for a page, made on another thread: it takes its time.
async fn made_file(
    page: Result<Arc<Client>, (StatusCode, &'static str)>,
    site: Site,
    kind: &'static str,
    make: impl FnOnce(&Shared, &Client) -> Result<Vec<u8>, String> + Send + 'static,
) -> Response {
    let client = match page {
        Ok(client) => client,
        Err(refusal) => return refusal.into_response(),
    };
    let shared = site.shared;
    match tokio::task::spawn_blocking(move || make(&shared, &client)).await {
        Ok(Ok(bytes)) => ([(header::CONTENT_TYPE, kind)], bytes).into_response(),
        Ok(Err(text)) => (StatusCode::CONFLICT, format!("{text}\n")).into_response(),
        Err(_) => (StatusCode::INTERNAL_SERVER_ERROR, "the file could not be made\n").into_response(),
    }
}

fn file(kind: &'static str, text: &'static str) -> Response {
    ([(header::CONTENT_TYPE, kind)], text).into_response()
}

fn refuse(why: &str) -> Response {
    (StatusCode::FORBIDDEN, format!("{why}\n")).into_response()
}
