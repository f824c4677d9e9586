//! Which topics there are, who wants them, and the way of messages from one to the other.

use std::collections::BTreeMap;
use std::sync::{Mutex, MutexGuard, PoisonError};

use tokio::sync::mpsc::{Receiver, Sender, channel};
use tokio_tungstenite::tungstenite::Message;

use super::protocol::{self, Channel, ClientSubscription, FromServer};

/// Messages that wait for a client; a slower one misses what comes meanwhile.
const QUEUE: usize = 2_000;

/// Topics and clients.
pub(super) struct Hub {
    name: &'static str,
    capabilities: &'static [&'static str],
    state: Mutex<State>,
    is_wanted: tokio::sync::Notify,
}

#[derive(Default)]
struct State {
    channels: Vec<Channel>,
    /// Of latched topics, by channel: the last message.
    latched: BTreeMap<u32, (u64, Vec<u8>)>,
    clients: BTreeMap<u64, ClientState>,
    n_clients_ever: u64,
}

struct ClientState {
    queue: Sender<Message>,
    /// The client's numbers, by channel.
    subscriptions: BTreeMap<u32, u32>,
}

impl Hub {
    pub(super) fn new(name: &'static str, capabilities: &'static [&'static str]) -> Self {
        Self { name, capabilities, state: Mutex::default(), is_wanted: tokio::sync::Notify::new() }
    }

    /// The number of a topic that clients may subscribe from now on.
    pub(super) fn advertise(&self, topic: &str, type_name: &str, schema: String) -> u32 {
        let mut state = self.lock();
        let id = u32::try_from(state.channels.len() + 1).unwrap_or(u32::MAX);
        let channel = Channel::of_ros(id, topic.to_owned(), type_name.to_owned(), schema);
        let text = FromServer::Advertise { channels: std::slice::from_ref(&channel) }.to_json();
        for client in state.clients.values() {
            client.send(Message::text(text.clone()));
        }
        state.channels.push(channel);
        id
    }

    /// Hands a message to everybody who wants its topic.
    pub(super) fn publish(&self, channel: u32, time_ns: u64, message: &[u8]) {
        for client in self.lock().clients.values() {
            client.give(channel, time_ns, message);
        }
    }

    /// The same, and to everybody who wants it later.
    pub(super) fn publish_latched(&self, channel: u32, time_ns: u64, message: &[u8]) {
        self.publish(channel, time_ns, message);
        self.lock().latched.insert(channel, (time_ns, message.to_vec()));
    }

    /// Gives everybody the time.
    pub(super) fn publish_time(&self, time_ns: u64) {
        for client in self.lock().clients.values() {
            client.send(Message::binary(protocol::time(time_ns)));
        }
    }

    /// Waits until somebody wants a topic.
    pub(super) async fn wanted(&self) {
        self.is_wanted.notified().await;
    }

    /// The number of a client that comes, and what is to be sent to it.
    pub(super) fn add_client(&self) -> (u64, Receiver<Message>) {
        let (queue, messages) = channel(QUEUE);
        let mut state = self.lock();
        let client = ClientState { queue, subscriptions: BTreeMap::new() };
        let info = FromServer::ServerInfo { name: self.name, capabilities: self.capabilities };
        client.send(Message::text(info.to_json()));
        let advertised = FromServer::Advertise { channels: &state.channels };
        client.send(Message::text(advertised.to_json()));
        state.n_clients_ever += 1;
        let id = state.n_clients_ever;
        state.clients.insert(id, client);
        (id, messages)
    }

    pub(super) fn n_clients(&self) -> usize {
        self.lock().clients.len()
    }

    pub(super) fn remove_client(&self, id: u64) {
        self.lock().clients.remove(&id);
    }

    pub(super) fn subscribe(&self, id: u64, subscriptions: &[ClientSubscription]) {
        let mut state = self.lock();
        let State { clients, latched, channels, .. } = &mut *state;
        let Some(client) = clients.get_mut(&id) else { return };
        for ClientSubscription { id, channel_id } in subscriptions {
            if !channels.iter().any(|channel| channel.id == *channel_id) {
                continue;
            }
            client.subscriptions.insert(*channel_id, *id);
            if let Some((time_ns, message)) = latched.get(channel_id) {
                client.give(*channel_id, *time_ns, message);
            }
            self.is_wanted.notify_one();
        }
    }

    /// A client wants some no more, by its own numbers.
    pub(super) fn unsubscribe(&self, id: u64, subscriptions: &[u32]) {
        if let Some(client) = self.lock().clients.get_mut(&id) {
            client.subscriptions.retain(|_, id| !subscriptions.contains(id));
        }
    }

    fn lock(&self) -> MutexGuard<'_, State> {
        // No panic can leave it half-changed.
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl ClientState {
    fn give(&self, channel: u32, time_ns: u64, message: &[u8]) {
        if let Some(subscription) = self.subscriptions.get(&channel) {
            self.send(Message::binary(protocol::message_data(*subscription, time_ns, message)));
        }
    }

    fn send(&self, message: Message) {
        // A client that is too slow misses it, and one that has gone will soon be removed.
        drop(self.queue.try_send(message));
    }
}
