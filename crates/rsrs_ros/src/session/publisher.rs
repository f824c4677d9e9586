//! Sending messages, without losing one in silence.

use std::sync::Arc;
use std::time::Duration;

use ros2_client::ros2::WriteError;
use rsrs_msgs::{RosMessage, cdr};

use super::PublishError;
use super::local::LocalPublisher;

/// How long a publisher waits for a reliable subscriber that acknowledges nothing. A healthy one
/// acknowledges within milliseconds.
pub(super) const TIMEOUT: Duration = Duration::from_secs(5);

/// Sends messages of one type on one topic.
pub struct Publisher<M: RosMessage>(Arc<TypedWriter<M>>);

/// What publishers of one topic share in a secured session.
pub(super) struct TypedWriter<M: RosMessage> {
    pub(super) topic: String,
    pub(super) writer: ros2_client::Publisher<M>,
    /// In a secured session only.
    pub(super) local: Option<LocalPublisher>,
}

impl<M: RosMessage> Publisher<M> {
    pub(super) fn new(writer: Arc<TypedWriter<M>>) -> Self {
        Self(writer)
    }

    /// The topic, absolute.
    pub fn topic(&self) -> &str {
        &self.0.topic
    }

    /// Sends a message; waits while 8,192 of them are not acknowledged by a reliable subscriber.
    ///
    /// Usually ready at once. A subscriber that does not read fast enough still loses samples on
    /// its own side, reliable or not, once more than its depth are unread; its
    /// [`Counts::lost`](super::Counts::lost) counts them.
    ///
    /// # Errors
    ///
    /// [`PublishError::Full`] after 5 s.
    pub async fn publish(&self, message: M) -> Result<(), PublishError> {
        let TypedWriter { topic, writer, local } = &*self.0;
        let copy = local.as_ref().map(|local| (local, cdr::encode(&message)));
        let sent = tokio::time::timeout(TIMEOUT, writer.async_publish(message)).await;
        within_timeout(topic, sent)?;
        if let Some((local, bytes)) = copy {
            local.deliver(|| bytes);
        }
        Ok(())
    }
}

/// Names the topic in an error, and takes a timeout for a full window.
pub(super) fn within_timeout<T, D>(
    topic: &str,
    sent: Result<Result<T, WriteError<D>>, tokio::time::error::Elapsed>,
) -> Result<(), PublishError> {
    let topic = || topic.to_owned();
    match sent {
        Ok(Ok(_)) => Ok(()),
        Ok(Err(WriteError::WouldBlock { .. })) | Err(_) => {
            Err(PublishError::Full { topic: topic(), waited_s: TIMEOUT.as_secs_f64() })
        }
        Ok(Err(error)) => {
            Err(PublishError::Middleware { topic: topic(), reason: error.to_string() })
        }
    }
}
