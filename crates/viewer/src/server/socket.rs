//! The socket of a page: its messages in, texts and frames out.

use crate::client::{Client, Side};
use crate::export::command_line;
use crate::message::{Frame, FromPage, ToPage};
use crate::pixel;
use crate::renderer::Shared;
use axum::extract::ws::{Message, WebSocket};
use futures_util::stream::{SplitSink, SplitStream};
use futures_util::{SinkExt, StreamExt};
use std::sync::Arc;
use std::time::{Duration, Instant};
use tokio::time::timeout;

/// A page that takes nothing for so long is gone.
const SEND_TIME: Duration = Duration::from_secs(20);

/// Serves a page until it leaves. What comes in does not wait for what goes out.
pub(super) async fn run(socket: WebSocket, shared: Arc<Shared>, client: Arc<Client>) {
    let (sink, stream) = socket.split();
    tokio::select! {
        () = hear_all(stream, &shared, &client) => {}
        () = send_all(sink, &client) => {}
    }
    shared.leave(&client);
}

async fn hear_all(mut stream: SplitStream<WebSocket>, shared: &Arc<Shared>, client: &Arc<Client>) {
    while let Some(Ok(message)) = stream.next().await {
        match message {
            Message::Text(text) => hear(shared, client, &text),
            Message::Binary(_) => client.tell(ToPage::Refused { text: "pages send texts".into() }),
            // Pings are answered by the library.
            Message::Ping(_) => {}
            Message::Pong(payload) => {
                if let Some((frame, side)) = Side::of_pong(&payload) {
                    client.state().ponged(frame, side, Instant::now());
                }
            }
            Message::Close(_) => break,
        }
    }
}

async fn send_all(mut sink: SplitSink<WebSocket, Message>, client: &Client) {
    loop {
        client.to_send.notified().await;
        if !send(&mut sink, client).await {
            break;
        }
    }
}

/// Takes a message of the page.
fn hear(shared: &Arc<Shared>, client: &Arc<Client>, text: &str) {
    let message = match FromPage::read(text) {
        Ok(message) => message,
        Err(text) => return client.tell(ToPage::Refused { text }),
    };
    match message {
        FromPage::View { input, moving, view } => {
            let stage = shared.stage();
            match view.check(&stage.scene, &stage.own) {
                Ok(()) => client.want(view, input, moving),
                Err(text) => return client.tell(ToPage::Refused { text }),
            }
        }
        FromPage::Ack { frame } => {
            client.state().acknowledged(frame);
            // The next piece may go.
            client.to_send.notify_one();
        }
        FromPage::Decodes { h264 } => return client.state().decodes_h264(h264),
        FromPage::Alive {} => return,
        FromPage::Pixel { x, y } => {
            return pixel::ask(shared, client, [x, y]);
        }
        FromPage::Command {} => {
            let wanted = client.state().wanted;
            if let Some(wanted) = wanted {
                client.tell(ToPage::Command { text: command_line(shared, &wanted.view) });
            }
            return;
        }
        FromPage::Device { choice } => return shared.request_device(choice, client),
    }
    shared.wake();
}

/// Sends what there is. Whether the page takes it.
async fn send(socket: &mut SplitSink<WebSocket, Message>, client: &Client) -> bool {
    loop {
        let text = client.state().take_text();
        let sent = match text {
            Some(text) => match serde_json::to_string(&text) {
                Ok(text) => timeout(SEND_TIME, socket.send(Message::Text(text.into()))).await,
                Err(_) => continue,
            },
            None => {
                let frame = client.state().take_frame();
                let Some(frame) = frame else { return true };
                timeout(SEND_TIME, send_frame(socket, &frame)).await
            }
        };
        if !matches!(sent, Ok(Ok(()))) {
            return false;
        }
    }
}

/// Sends a frame between two pings.
async fn send_frame(socket: &mut SplitSink<WebSocket, Message>, frame: &Frame) -> Result<(), axum::Error> {
    let ping = |side: Side| Message::Ping(side.ping(frame.header.frame).into());
    socket.feed(ping(Side::Before)).await?;
    socket.feed(Message::Binary(frame.to_message().into())).await?;
    socket.send(ping(Side::After)).await
}
