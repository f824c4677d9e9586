//! One client of the server, from its handshake to its end.

use std::sync::Arc;

use futures::{SinkExt, StreamExt};
use tokio::net::TcpStream;
use tokio_tungstenite::WebSocketStream;
use tokio_tungstenite::tungstenite::handshake::server::{ErrorResponse, Request, Response};
use tokio_tungstenite::tungstenite::http::{HeaderValue, StatusCode};
use tokio_tungstenite::tungstenite::{Error, Message};

use super::hub::Hub;
use super::protocol::{FromClient, SUBPROTOCOLS};

/// The header in which client and server agree on a protocol.
const HEADER: &str = "sec-websocket-protocol";

/// Clients that are served at once, at most.
const MOST_CLIENTS: usize = 32;

/// Serves a client until it goes, or is gone.
pub(super) async fn serve(stream: TcpStream, hub: Arc<Hub>) {
    if hub.n_clients() >= MOST_CLIENTS {
        return log::warn!("a client was refused: {MOST_CLIENTS} are served already");
    }
    let accepted = tokio_tungstenite::accept_hdr_async(stream, agree).await;
    let socket = match accepted {
        Ok(socket) => socket,
        Err(error) => return log::info!("a client was refused: {error}"),
    };
    let (id, mut messages) = hub.add_client();
    let ended = exchange(socket, &hub, (id, &mut messages)).await;
    hub.remove_client(id);
    if let Err(error) = ended {
        log::info!("a client has gone: {error}");
    }
}

/// Agrees on a name of the protocol.
#[expect(clippy::result_large_err, reason = "it is the type of the handshake")]
fn agree(request: &Request, mut response: Response) -> Result<Response, ErrorResponse> {
    let origin = request.headers().get("origin").map(|value| value.to_str().unwrap_or_default());
    if origin.is_some_and(|origin| !is_viewer(origin)) {
        let text = "a web page of another origin than Foxglove's, or this machine's, is not served";
        return Err(refusal(StatusCode::FORBIDDEN, text.to_owned()));
    }
    let wanted = request.headers().get_all(HEADER).iter().filter_map(|value| value.to_str().ok());
    let wanted: Vec<&str> = wanted.flat_map(|value| value.split(',')).map(str::trim).collect();
    let Some(agreed) = SUBPROTOCOLS.into_iter().find(|name| wanted.contains(name)) else {
        let text = format!("expected one of the protocols {}", SUBPROTOCOLS.join(", "));
        return Err(refusal(StatusCode::BAD_REQUEST, text));
    };
    response.headers_mut().insert(HEADER, HeaderValue::from_static(agreed));
    Ok(response)
}

fn refusal(status: StatusCode, text: String) -> ErrorResponse {
    let mut refusal = ErrorResponse::new(Some(text));
    *refusal.status_mut() = status;
    refusal
}

/// Whether a page of this origin may read what robots publish: those of Foxglove, of an application on
/// this machine, and of a server on it, such as Lichtblick in a container. Any other page that somebody
/// opens in a browser on this machine reaches the port, too.
fn is_viewer(origin: &str) -> bool {
    let (scheme, host) = origin.split_once("://").unwrap_or((origin, ""));
    let host = if host.starts_with('[') { host } else { host.split(':').next().unwrap_or("") };
    match scheme {
        "https" if host == "app.foxglove.dev" => true,
        "http" | "https" => matches!(host, "localhost" | "127.0.0.1") || host.starts_with("[::1]"),
        "file" | "app" | "vscode-webview" => true,
        _ => false,
    }
}

async fn exchange(
    socket: WebSocketStream<TcpStream>,
    hub: &Hub,
    (id, messages): (u64, &mut tokio::sync::mpsc::Receiver<Message>),
) -> Result<(), Error> {
    let (mut to_client, mut from_client) = socket.split();
    loop {
        tokio::select! {
            Some(message) = messages.recv() => to_client.send(message).await?,
            request = from_client.next() => match request.transpose()? {
                None | Some(Message::Close(_)) => return Ok(()),
                Some(Message::Text(text)) => match FromClient::parse(&text) {
                    FromClient::Subscribe { subscriptions } => hub.subscribe(id, &subscriptions),
                    FromClient::Unsubscribe { subscription_ids } => {
                        hub.unsubscribe(id, &subscription_ids);
                    }
                    FromClient::Other => {}
                },
                Some(_) => {}
            },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn viewers_are_served_and_other_pages_are_not() {
        for viewer in [
            "https://app.foxglove.dev",
            "http://localhost:8080",
            "http://127.0.0.1:8080",
            "http://[::1]:8080",
            "file://",
        ] {
            assert!(is_viewer(viewer), "{viewer}");
        }
        for other in [
            "https://example.org",
            "https://app.foxglove.dev.example.org",
            "http://app.foxglove.dev",
            "http://localhost.example.org",
            "null",
            "",
        ] {
            assert!(!is_viewer(other), "{other}");
        }
    }
}
