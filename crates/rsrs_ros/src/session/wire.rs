//! What the middleware's decoder is given to decode into.

use std::fmt;
use std::marker::PhantomData;

use rsrs_msgs::cdr::MAX_PADDING;
use serde::de::{Deserialize, Deserializer, Error, SeqAccess, Visitor};
use serde::ser::{Serialize, SerializeTuple, Serializer};

/// A message, and no more than padding after it.
///
/// The middleware matches topics by name alone and would read a message of another type for what it
/// is not; most of them are longer or shorter, which this notices.
pub(super) struct Wire<M>(pub(super) M);

impl<'de, M: Deserialize<'de>> Deserialize<'de> for Wire<M> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_tuple(1 + MAX_PADDING + 1, WireVisitor(PhantomData))
    }
}

struct WireVisitor<M>(PhantomData<M>);

impl<'de, M: Deserialize<'de>> Visitor<'de> for WireVisitor<M> {
    type Value = Wire<M>;

    fn expecting(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str("a message with at most 3 bytes of padding")
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut sequence: A) -> Result<Wire<M>, A::Error> {
        let message =
            sequence.next_element::<M>()?.ok_or_else(|| A::Error::custom("no message"))?;
        for _ in 0..=MAX_PADDING {
            // The end of the input is the only error that reading a byte can meet.
            if !matches!(sequence.next_element::<u8>(), Ok(Some(_))) {
                return Ok(Wire(message));
            }
        }
        Err(A::Error::custom("more than 3 bytes after the message: another type?"))
    }
}

/// All bytes of a body as they are, padding included.
///
/// ros2-client decodes services itself; this lets it hand over what it would decode.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Bytes(pub(crate) Vec<u8>);

impl ros2_client::Message for Bytes {}

impl Serialize for Bytes {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut tuple = serializer.serialize_tuple(self.0.len())?;
        for byte in &self.0 {
            tuple.serialize_element(byte)?;
        }
        tuple.end()
    }
}

impl<'de> Deserialize<'de> for Bytes {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_tuple(usize::MAX, BytesVisitor)
    }
}

struct BytesVisitor;

impl<'de> Visitor<'de> for BytesVisitor {
    type Value = Bytes;

    fn expecting(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str("any bytes")
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut sequence: A) -> Result<Bytes, A::Error> {
        let mut bytes = Vec::new();
        // The end of the input is the only error that reading a byte can meet.
        while let Ok(Some(byte)) = sequence.next_element::<u8>() {
            bytes.push(byte);
        }
        Ok(Bytes(bytes))
    }
}

#[cfg(test)]
mod tests {
    use rsrs_msgs::cdr;
    use rsrs_msgs::std_msgs::Bool;
    use rustdds::RepresentationIdentifier;
    use rustdds::serialization::{deserialize_from_cdr_with_rep_id, to_writer_with_rep_id};

    use super::*;

    fn decode<T: serde::de::DeserializeOwned>(body: &[u8]) -> Option<T> {
        let decoded = deserialize_from_cdr_with_rep_id(body, RepresentationIdentifier::CDR_LE);
        decoded.ok().map(|(value, _)| value)
    }

    #[test]
    fn a_message_with_padding_decodes_and_one_with_more_does_not() {
        let mut body = cdr::encode_body(&Bool { data: true });
        for n_padding in 0..=4 {
            let message = decode::<Wire<Bool>>(&body).map(|wire| wire.0.data);

            assert_eq!(message, (n_padding <= 3).then_some(true), "{n_padding} bytes");
            body.push(0);
        }
        assert!(decode::<Wire<Bool>>(&[]).is_none());
    }

    #[test]
    fn bytes_go_through_the_middleware_unchanged() {
        let bytes = Bytes((0..=255).collect());

        let mut body = Vec::new();
        to_writer_with_rep_id(&mut body, &bytes, RepresentationIdentifier::CDR_LE).unwrap();

        assert_eq!(body, bytes.0);
        assert_eq!(decode(&body), Some(bytes));
        assert_eq!(decode(&[]), Some(Bytes(Vec::new())));
    }
}
