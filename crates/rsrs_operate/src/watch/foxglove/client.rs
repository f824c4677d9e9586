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

/// Serves a client until it goes, or is gone.
pub(super) async fn serve(stream: TcpStream, hub: Arc<Hub>) {
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
    let wanted = request.headers().get_all(HEADER).iter().filter_map(|value| value.to_str().ok());
    let wanted: Vec<&str> = wanted.flat_map(|value| value.split(',')).map(str::trim).collect();
    let Some(agreed) = SUBPROTOCOLS.into_iter().find(|name| wanted.contains(name)) else {
        let text = format!("expected one of the protocols {}", SUBPROTOCOLS.join(", "));
        let mut refusal = ErrorResponse::new(Some(text));
        *refusal.status_mut() = StatusCode::BAD_REQUEST;
        return Err(refusal);
    };
    response.headers_mut().insert(HEADER, HeaderValue::from_static(agreed));
    Ok(response)
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
