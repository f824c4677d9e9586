//! The messages of the Foxglove WebSocket protocol that a server of topics needs, as text and bytes.
//!
//! # Source
//!
//! <https://github.com/foxglove/ws-protocol/blob/main/docs/spec.md>; the servers of Foxglove's newer
//! SDK call the same messages `foxglove.sdk.v1`.

use serde::{Deserialize, Serialize};

/// Names of the protocol, the first choice first: Lichtblick asks for the older one only, and newer
/// versions of Foxglove for the newer one.
pub const SUBPROTOCOLS: [&str; 2] = ["foxglove.websocket.v1", "foxglove.sdk.v1"];

/// Opcodes of messages in bytes.
const MESSAGE_DATA: u8 = 1;
const TIME: u8 = 2;

/// A topic that a client may subscribe.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "camelCase")]
pub struct Channel {
    /// Its number.
    pub id: u32,
    /// Its name.
    pub topic: String,
    /// How its messages are encoded.
    pub encoding: &'static str,
    /// The name of its type.
    pub schema_name: String,
    /// The definition of its type, with those of the types in it.
    pub schema: String,
    /// How that is written.
    pub schema_encoding: &'static str,
}

impl Channel {
    /// A topic of ROS 2.
    pub fn of_ros(id: u32, topic: String, schema_name: String, schema: String) -> Self {
        Self { id, topic, encoding: "cdr", schema_name, schema, schema_encoding: "ros2msg" }
    }
}

/// What a server sends as text.
#[derive(Serialize)]
#[serde(tag = "op", rename_all = "camelCase")]
pub enum FromServer<'a> {
    /// Who it is and what it can do, first of all.
    #[serde(rename_all = "camelCase")]
    ServerInfo {
        /// Its name.
        name: &'a str,
        /// `time`, if it has a time of its own.
        capabilities: &'a [&'a str],
    },
    /// Topics that are new.
    Advertise {
        /// The topics.
        channels: &'a [Channel],
    },
}

impl FromServer<'_> {
    /// As JSON.
    pub fn to_json(&self) -> String {
        serde_json::to_string(self).expect("it is plain data")
    }
}

/// What a client asks for; what is not listed here is left alone.
#[derive(Debug, PartialEq, Eq, Deserialize)]
#[serde(tag = "op", rename_all = "camelCase")]
pub enum FromClient {
    /// To receive topics.
    Subscribe {
        /// Each with the number that the client gives to it.
        subscriptions: Vec<ClientSubscription>,
    },
    /// To receive some of them no more.
    #[serde(rename_all = "camelCase")]
    Unsubscribe {
        /// The client's numbers.
        subscription_ids: Vec<u32>,
    },
    /// Something else.
    #[serde(other)]
    Other,
}

/// A topic that a client wants.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct ClientSubscription {
    /// The client's number of it.
    pub id: u32,
    /// The server's.
    pub channel_id: u32,
}

impl FromClient {
    /// Understands the text of a client; what is no request is another one.
    pub fn parse(text: &str) -> Self {
        serde_json::from_str(text).unwrap_or(Self::Other)
    }
}

/// A message of a topic, for one subscription.
pub fn message_data(subscription: u32, time_ns: u64, message: &[u8]) -> Vec<u8> {
    let mut bytes = vec![MESSAGE_DATA];
    bytes.extend(subscription.to_le_bytes());
    bytes.extend(time_ns.to_le_bytes());
    bytes.extend(message);
    bytes
}

/// The time of the server.
pub fn time(time_ns: u64) -> Vec<u8> {
    let mut bytes = vec![TIME];
    bytes.extend(time_ns.to_le_bytes());
    bytes
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn requests_are_understood_and_nonsense_is_another_request() {
        let text = r#"{"op":"subscribe","subscriptions":[{"id":7,"channelId":2}]}"#;
        let subscriptions = vec![ClientSubscription { id: 7, channel_id: 2 }];
        assert_eq!(FromClient::parse(text), FromClient::Subscribe { subscriptions });

        let text = r#"{"op":"unsubscribe","subscriptionIds":[7]}"#;
        let subscription_ids = vec![7];
        assert_eq!(FromClient::parse(text), FromClient::Unsubscribe { subscription_ids });

        for text in [r#"{"op":"getParameters"}"#, "", "[]", r#"{"op":"subscribe"}"#] {
            assert_eq!(FromClient::parse(text), FromClient::Other, "{text}");
        }
    }

    #[test]
    fn topics_are_advertised_as_the_specification_has_it() {
        let channel =
            Channel::of_ros(3, "/a".into(), "std_msgs/msg/Bool".into(), "bool data".into());

        let text = FromServer::Advertise { channels: &[channel] }.to_json();

        let expected = serde_json::json!({"op": "advertise", "channels": [{
            "id": 3, "topic": "/a", "encoding": "cdr", "schemaName": "std_msgs/msg/Bool",
            "schema": "bool data", "schemaEncoding": "ros2msg",
        }]});
        assert_eq!(serde_json::from_str::<serde_json::Value>(&text).unwrap(), expected);
    }

    #[test]
    fn a_message_has_thirteen_bytes_in_front() {
        let bytes = message_data(0x0102, 0x03, &[9, 8]);

        assert_eq!(bytes, [1, 2, 1, 0, 0, 3, 0, 0, 0, 0, 0, 0, 0, 9, 8]);
        assert_eq!(time(1), [2, 1, 0, 0, 0, 0, 0, 0, 0]);
    }
}
