//! Everything about a topic in a bag besides its messages.

use std::collections::BTreeMap;

use rsrs_msgs::topics::Qos;

use crate::definitions::Definition;
use crate::metadata::{TopicMetadata, TopicWithCount};
use crate::qos;

/// A channel as MCAP has it, with its schema.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ChannelDescription {
    pub topic: String,
    /// Such as `std_msgs/msg/Bool`; empty for a channel without schema.
    pub type_name: String,
    /// `ros2msg`, or `ros2idl`.
    pub schema_encoding: String,
    /// The definition of the type and of those in it.
    pub schema: Vec<u8>,
    /// `cdr`, unless another program than ROS wrote it.
    pub message_encoding: String,
    /// rosbag2's two: quality of service and hash of the type.
    pub metadata: BTreeMap<String, String>,
}

impl ChannelDescription {
    pub fn new(topic: &str, offered: Qos, definition: &Definition) -> Self {
        let hash = definition.type_hash.clone().unwrap_or_default();
        Self {
            topic: topic.to_owned(),
            type_name: definition.type_name.clone(),
            schema_encoding: "ros2msg".to_owned(),
            schema: definition.text.clone().into_bytes(),
            message_encoding: "cdr".to_owned(),
            metadata: BTreeMap::from([
                (qos::KEY.to_owned(), qos::offered_qos_profiles(offered)),
                (qos::HASH_KEY.to_owned(), hash),
            ]),
        }
    }

    /// The same in the words of `metadata.yaml`.
    pub fn with_count(&self, message_count: u64) -> TopicWithCount {
        let described = |key: &str| self.metadata.get(key).cloned().unwrap_or_default();
        let topic_metadata = TopicMetadata {
            name: self.topic.clone(),
            r#type: self.type_name.clone(),
            serialization_format: self.message_encoding.clone(),
            // The table of contents has version 8, whose readers take numbers only.
            offered_qos_profiles: qos::in_numbers(&described(qos::KEY)),
            type_description_hash: described(qos::HASH_KEY),
        };
        TopicWithCount { topic_metadata, message_count }
    }
}

impl From<&mcap::Channel<'_>> for ChannelDescription {
    fn from(channel: &mcap::Channel) -> Self {
        let schema = channel.schema.as_ref();
        Self {
            topic: channel.topic.clone(),
            type_name: schema.map(|schema| schema.name.clone()).unwrap_or_default(),
            schema_encoding: schema.map(|schema| schema.encoding.clone()).unwrap_or_default(),
            schema: schema.map(|schema| schema.data.to_vec()).unwrap_or_default(),
            message_encoding: channel.message_encoding.clone(),
            metadata: channel.metadata.clone(),
        }
    }
}
