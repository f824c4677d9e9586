//! A node: its name, its log, and the names of what it publishes and subscribes.

use std::fmt;
use std::sync::Arc;

use ros2_client::builtin_interfaces::Time;
use ros2_client::log::LogLevel;
use ros2_client::rosout::{NodeLoggingHandle, RosoutRaw};
use ros2_client::{MessageTypeName, Name};
use rsrs_msgs::RosMessage;

use super::SessionError;
use crate::logging::Level;

/// A node of a [`Session`](super::Session).
#[derive(Clone)]
pub struct NodeHandle {
    full_name: String,
    rosout: Arc<NodeLoggingHandle>,
}

impl NodeHandle {
    pub(super) fn new(full_name: String, node: &ros2_client::Node) -> Self {
        Self { full_name, rosout: Arc::new(node.logging_handle()) }
    }

    /// A node of another name that logs to `/rosout` through this one.
    pub(super) fn called(self, full_name: String) -> Self {
        Self { full_name, ..self }
    }

    /// Namespace and name, such as `/robot_3/controller`.
    pub fn full_name(&self) -> &str {
        &self.full_name
    }

    /// Logs a text on stderr and on `/rosout`.
    pub fn log(&self, level: Level, text: &str) {
        // The name of a logger in ROS 2: `robot_3.controller`.
        let logger = self.full_name.trim_start_matches('/').replace('/', ".");
        log::log!(level.as_log(), "[{logger}] {text}");
        let level = match level {
            Level::Debug => LogLevel::Debug,
            Level::Info => LogLevel::Info,
            Level::Warn => LogLevel::Warn,
            Level::Error => LogLevel::Error,
            Level::Fatal => LogLevel::Fatal,
        };
        self.rosout.rosout_raw(Time::now(), level, &logger, text, "", "", 0);
    }
}

impl fmt::Debug for NodeHandle {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.debug_tuple("NodeHandle").field(&self.full_name).finish()
    }
}

/// A topic's name as ros2-client wants it.
pub(super) fn ros_name(topic: &str) -> Result<Name, SessionError> {
    let refused = |reason: String| SessionError::Name { name: topic.to_owned(), reason };
    if !topic.starts_with('/') {
        return Err(refused("it must be absolute, with a slash in front".to_owned()));
    }
    Name::parse(topic).map_err(|error| refused(error.to_string()))
}

/// The type of a message as ros2-client wants it.
pub(super) fn message_type<M: RosMessage>() -> MessageTypeName {
    let (package, name) = M::TYPE_NAME
        .split_once("/msg/")
        .expect("only messages are published, and their types are called package/msg/Name");
    MessageTypeName::new(package, name)
}
