//! Topics of any type, as the bytes that a bag keeps.

use std::convert::Infallible;
use std::fmt;
use std::sync::Arc;

use futures::{Stream, StreamExt};
use rsrs_msgs::RosMessage;
use rsrs_msgs::cdr::ENCAPSULATION;
use rustdds::no_key::{
    DataWriter, Decode, DefaultDecoder, DeserializerAdapter, SerializerAdapter, SimpleDataReader,
};
use rustdds::serialization::deserialize_from_cdr_with_rep_id;
use rustdds::{
    DomainParticipant, QosPolicies, RTPSEntity, RepresentationIdentifier, Subscriber, Timestamp,
    Topic, TopicKind,
};

use super::endpoint::dds_type;
use super::local::{LocalDelivery, LocalPublisher};
use super::publisher::{TIMEOUT, within_timeout};
use super::subscription::{Failure, Received, ReceivedRaw};
use super::wire::Wire;
use super::{PublishError, SessionError, graph, ros_name};

/// What a topic and its type are called in DDS.
#[derive(Clone, Debug)]
pub(super) struct DdsNames {
    topic: String,
    type_name: String,
}

impl DdsNames {
    /// Of a ROS topic.
    pub(super) fn of_topic(topic: &str, type_name: &str) -> Result<Self, SessionError> {
        ros_name(topic)?;
        let type_name = dds_type(type_name).ok_or_else(|| SessionError::Name {
            name: type_name.to_owned(),
            reason: "a type is called package/msg/Name".to_owned(),
        })?;
        Ok(Self { topic: format!("rt{topic}"), type_name })
    }

    pub(super) fn topic(&self) -> &str {
        &self.topic
    }

    /// Of the topic on which participants announce their nodes.
    pub(super) fn of_graph() -> Self {
        Self { topic: graph::TOPIC.to_owned(), type_name: graph::DDS_TYPE.to_owned() }
    }

    fn topic_in(
        &self,
        participant: &DomainParticipant,
        qos: &QosPolicies,
    ) -> Result<Topic, SessionError> {
        participant
            .create_topic(self.topic.clone(), self.type_name.clone(), qos, TopicKind::NoKey)
            .map_err(|error| SessionError::endpoint(&self.topic, &error))
    }
}

impl fmt::Display for DdsNames {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(formatter, "`{}`", self.topic.strip_prefix("rt").unwrap_or(&self.topic))
    }
}

/// Bytes without encapsulation in, bytes with encapsulation out, and no look at what they mean.
pub(super) struct RawCdr;

pub(super) type RawReader = SimpleDataReader<Vec<u8>, RawCdr>;

/// Every encapsulation that ROS 2 programs send, and its first two bytes in a bag (RTPS 10.5).
const ENCODINGS: [(RepresentationIdentifier, [u8; 2]); 6] = [
    (RepresentationIdentifier::CDR_BE, [0, 0]),
    (RepresentationIdentifier::CDR_LE, [0, 1]),
    (RepresentationIdentifier::PL_CDR_BE, [0, 2]),
    (RepresentationIdentifier::PL_CDR_LE, [0, 3]),
    (RepresentationIdentifier::CDR2_BE, [0, 6]),
    (RepresentationIdentifier::CDR2_LE, [0, 7]),
];

static SUPPORTED: [RepresentationIdentifier; 6] = [
    ENCODINGS[0].0,
    ENCODINGS[1].0,
    ENCODINGS[2].0,
    ENCODINGS[3].0,
    ENCODINGS[4].0,
    ENCODINGS[5].0,
];

/// An encapsulation that is none of [`ENCODINGS`].
#[derive(Debug, thiserror::Error)]
#[error("encapsulation {found:?} is not one that ROS 2 sends")]
pub(super) struct UnknownEncoding {
    found: RepresentationIdentifier,
}

/// Puts the encapsulation back in front.
#[derive(Clone)]
pub(super) struct RawDecoder;

impl<'de> Decode<'de, Vec<u8>> for RawDecoder {
    type Error = UnknownEncoding;

    fn decode_bytes(
        self,
        body: &'de [u8],
        encoding: RepresentationIdentifier,
    ) -> Result<Vec<u8>, UnknownEncoding> {
        let (_, [high, low]) = ENCODINGS
            .into_iter()
            .find(|(known, _)| *known == encoding)
            .ok_or(UnknownEncoding { found: encoding })?;
        let mut bytes = Vec::with_capacity(ENCAPSULATION.len() + body.len());
        bytes.extend_from_slice(&[high, low, 0, 0]);
        bytes.extend_from_slice(body);
        Ok(bytes)
    }
}

impl DeserializerAdapter<Vec<u8>> for RawCdr {
    type Error = UnknownEncoding;
    type Decoded = Vec<u8>;

    fn supported_encodings() -> &'static [RepresentationIdentifier] {
        &SUPPORTED
    }

    fn transform_decoded(decoded: Vec<u8>) -> Vec<u8> {
        decoded
    }
}

impl DefaultDecoder<Vec<u8>> for RawCdr {
    type Decoder = RawDecoder;
    const DECODER: RawDecoder = RawDecoder;
}

impl SerializerAdapter<rustdds::bytes::Bytes> for RawCdr {
    type Error = Infallible;

    fn output_encoding() -> RepresentationIdentifier {
        RepresentationIdentifier::CDR_LE
    }

    fn to_bytes(body: &rustdds::bytes::Bytes) -> Result<rustdds::bytes::Bytes, Infallible> {
        Ok(body.clone())
    }
}

pub(super) fn reader(
    participant: &DomainParticipant,
    subscriber: &Subscriber,
    names: &DdsNames,
    qos: &QosPolicies,
) -> Result<RawReader, SessionError> {
    let topic = names.topic_in(participant, qos)?;
    subscriber
        .create_simple_datareader_no_key(&topic, Some(qos.clone()))
        .map_err(|error| SessionError::endpoint(&names.topic, &error))
}

/// What bytes with encapsulation mean.
pub(super) fn decode<M: RosMessage>(sample: ReceivedRaw) -> Result<Received<M>, Failure> {
    let undecodable = |reason: String| Failure::Undecodable(reason);
    let Received { message, source_time_ns, received_time_ns, sequence, writer } = sample;
    let (encapsulation, body) = message
        .split_first_chunk::<4>()
        .ok_or_else(|| undecodable(format!("{} bytes", message.len())))?;
    let [high, low, ..] = *encapsulation;
    let (encoding, _) = ENCODINGS
        .into_iter()
        .find(|(_, bytes)| *bytes == [high, low])
        .ok_or_else(|| undecodable(format!("encapsulation {encapsulation:02x?}")))?;
    let (Wire(message), _) = deserialize_from_cdr_with_rep_id::<Wire<M>>(body, encoding)
        .map_err(|error| undecodable(error.to_string()))?;
    Ok(Received { message, source_time_ns, received_time_ns, sequence, writer })
}

/// The samples of a reader of bytes.
pub(super) fn stream(reader: RawReader) -> impl Stream<Item = Result<ReceivedRaw, Failure>> {
    futures::stream::unfold(reader, async |reader| {
        let taken = {
            let mut samples = std::pin::pin!(reader.as_async_stream());
            samples.next().await
        };
        let sample = match taken? {
            Ok(sample) => Ok(Received {
                source_time_ns: sample.source_timestamp().and_then(nanoseconds),
                received_time_ns: nanoseconds(sample.receive_instant)
                    .expect("the middleware's clock has a valid time"),
                sequence: i64::from(sample.sequence_number).unsigned_abs(),
                writer: sample.writer_guid().to_bytes(),
                message: sample.into_value(),
            }),
            Err(rustdds::dds::ReadError::Deserialization { reason }) => {
                Err(Failure::Undecodable(reason))
            }
            Err(error) => Err(Failure::Broken(error.to_string())),
        };
        Some((sample, reader))
    })
}

/// Nanoseconds since 1970 of a DDS timestamp, in 2⁻³² s; `None` for "invalid" and "infinite".
fn nanoseconds(timestamp: Timestamp) -> Option<u64> {
    if timestamp == Timestamp::INVALID || timestamp == Timestamp::INFINITE {
        return None;
    }
    let nanoseconds = (u128::from(timestamp.to_ticks()) * 1_000_000_000 + (1 << 31)) >> 32;
    Some(u64::try_from(nanoseconds).expect("32 bits of seconds are 2^62 nanoseconds"))
}

/// Sends messages of any type on one topic, as the bytes that a bag keeps.
pub struct RawPublisher(Arc<RawWriter>);

/// What publishers of one topic share in a secured session.
pub(super) struct RawWriter {
    topic: String,
    writer: DataWriter<rustdds::bytes::Bytes, RawCdr>,
    /// In a secured session only.
    local: Option<LocalPublisher>,
}

impl RawWriter {
    pub(super) fn new(
        topic: &str,
        participant: &DomainParticipant,
        publisher: &rustdds::Publisher,
        names: &DdsNames,
        qos: &QosPolicies,
    ) -> Result<Self, SessionError> {
        let dds_topic = names.topic_in(participant, qos)?;
        let writer = publisher
            .create_datawriter_no_key(&dds_topic, Some(qos.clone()))
            .map_err(|error| SessionError::endpoint(topic, &error))?;
        Ok(Self { topic: topic.to_owned(), writer, local: None })
    }

    /// Hands what it publishes to subscriptions of its own session, too.
    pub(super) fn delivering_to(self, topics: &Arc<LocalDelivery>) -> Self {
        let dds_topic = format!("rt{}", self.topic);
        let local = LocalPublisher::new(topics, dds_topic, self.writer.guid().to_bytes());
        Self { local: Some(local), ..self }
    }
}

impl RawPublisher {
    pub(super) fn new(writer: Arc<RawWriter>) -> Self {
        Self(writer)
    }

    /// The topic, absolute.
    pub fn topic(&self) -> &str {
        &self.0.topic
    }

    /// Sends a message, with 4 bytes of little-endian encapsulation in front; waits while 8,192 of
    /// them are not acknowledged by a reliable subscriber.
    ///
    /// # Errors
    ///
    /// [`PublishError::Full`] after 5 s, and [`PublishError::Encapsulation`].
    pub async fn publish(&self, message: &[u8]) -> Result<(), PublishError> {
        let Some(body) = message.strip_prefix(&ENCAPSULATION) else {
            let found = message.iter().take(ENCAPSULATION.len()).copied().collect();
            return Err(PublishError::Encapsulation { topic: self.0.topic.clone(), found });
        };
        let body = rustdds::bytes::Bytes::copy_from_slice(body);
        let sending = async {
            self.0
                .writer
                .async_write(body, Some(Timestamp::now()))
                .await
                .map_err(ros2_client::ros2::WriteError::from)
        };
        within_timeout(&self.0.topic, tokio::time::timeout(TIMEOUT, sending).await)?;
        if let Some(local) = &self.0.local {
            local.deliver(|| message.to_vec());
        }
        Ok(())
    }

    /// Waits until every reliable subscriber has all that was sent: what is still under way when a
    /// publisher is dropped is lost.
    ///
    /// # Errors
    ///
    /// [`PublishError::Full`] after 5 s.
    pub async fn acknowledged(&self) -> Result<(), PublishError> {
        let waiting = async {
            let waited = self.0.writer.async_wait_for_acknowledgments().await;
            waited.map_err(ros2_client::ros2::WriteError::from)
        };
        within_timeout(&self.0.topic, tokio::time::timeout(TIMEOUT, waiting).await)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sample_gets_its_encapsulation_back_if_a_bag_can_hold_it() {
        let little = RawDecoder.decode_bytes(&[5], RepresentationIdentifier::CDR_LE).unwrap();
        let xcdr2 = RawDecoder.decode_bytes(&[5], RepresentationIdentifier::CDR2_LE).unwrap();

        assert_eq!(little, [0, 1, 0, 0, 5]);
        assert_eq!(xcdr2, [0, 7, 0, 0, 5]);
        let error = RawDecoder.decode_bytes(&[5], RepresentationIdentifier::XML).unwrap_err();
        assert_eq!(error.found, RepresentationIdentifier::XML);
    }

    #[test]
    fn timestamps_are_nanoseconds_since_1970() {
        let half_past_two_seconds = Timestamp::from_ticks((2 << 32) + (1 << 31));

        assert_eq!(nanoseconds(half_past_two_seconds), Some(2_500_000_000));
        assert_eq!(nanoseconds(Timestamp::INVALID), None);
    }

    #[test]
    fn relative_topics_and_incomplete_types_are_refused() {
        assert!(DdsNames::of_topic("detection", "std_msgs/msg/Bool").is_err());
        assert!(DdsNames::of_topic("/detection", "std_msgs/Bool").is_err());
        assert!(DdsNames::of_topic("/detection", "std_msgs/msg/Bool").is_ok());
    }
}
