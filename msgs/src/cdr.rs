//! Messages to bytes and back: CDR version 1, as DDS sends it and bags keep it.
//!
//! A bag's message starts with four bytes of encapsulation, which [`encode`] and [`decode`] handle;
//! a DDS library strips them, which is why there is a pair for the body alone.
//!
//! # Example
//!
//! ```
//! use rsrs_msgs::cdr;
//! use rsrs_msgs::std_msgs::Bool;
//!
//! let bytes = cdr::encode(&Bool { data: true });
//! assert_eq!(bytes, [0, 1, 0, 0, 1]);
//! assert_eq!(cdr::decode::<Bool>(&bytes)?, Bool { data: true });
//! # Ok::<(), cdr::CdrError>(())
//! ```

use byteorder::{BigEndian, LittleEndian};

use crate::RosMessage;

/// What stands in front of a body that [`encode`] writes: plain CDR, little-endian, no options.
pub const ENCAPSULATION: [u8; 4] = [0, 1, 0, 0];

/// Bytes that RTPS may add to fill the last group of four.
pub const MAX_PADDING: usize = 3;

/// The order of the bytes of a number in a body.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ByteOrder {
    /// `CDR_LE`, encapsulation 00 01.
    Little,
    /// `CDR_BE`, encapsulation 00 00.
    Big,
}

/// Why bytes are not the message they should be.
#[derive(Debug, thiserror::Error)]
pub enum CdrError {
    /// The bytes end within the encapsulation.
    #[error("{type_name} of {n_bytes} bytes is too short for the 4 bytes of encapsulation")]
    NoEncapsulation {
        /// The type that was asked for.
        type_name: &'static str,
        /// How many bytes there are.
        n_bytes: usize,
    },
    /// The encapsulation names a representation that is not plain CDR.
    #[error(
        "{type_name} has encapsulation {found:#06x}, expected 0x0001 (CDR_LE) or 0x0000 (CDR_BE)"
    )]
    Encapsulation {
        /// The type that was asked for.
        type_name: &'static str,
        /// The first two bytes.
        found: u16,
    },
    /// The body is cut short or holds an impossible value.
    #[error("{type_name} does not decode from a body of {n_bytes} bytes")]
    Body {
        /// The type that was asked for.
        type_name: &'static str,
        /// Length of the body, without the encapsulation.
        n_bytes: usize,
        /// What the decoder met.
        #[source]
        source: cdr_encoding::Error,
    },
    /// More bytes follow than padding explains: most likely another type.
    #[error(
        "{type_name} ends after {used} of {n_bytes} bytes, more than 3 bytes of padding before the end"
    )]
    TrailingBytes {
        /// The type that was asked for.
        type_name: &'static str,
        /// Bytes of the body that the message took.
        used: usize,
        /// Length of the body, without the encapsulation.
        n_bytes: usize,
    },
}

/// Encodes a message with its encapsulation, as a bag keeps it.
pub fn encode<M: RosMessage>(message: &M) -> Vec<u8> {
    let body = encode_body(message);
    let mut bytes = Vec::with_capacity(ENCAPSULATION.len() + body.len());
    bytes.extend_from_slice(&ENCAPSULATION);
    bytes.extend_from_slice(&body);
    bytes
}

/// Encodes a message without encapsulation, little-endian, as a DDS library takes it.
///
/// # Panics
///
/// If a sequence has 2³² elements or more.
pub fn encode_body<M: RosMessage>(message: &M) -> Vec<u8> {
    cdr_encoding::to_vec::<M, LittleEndian>(message)
        .expect("a message in memory has only numbers, strings and shorter sequences")
}

/// Decodes a message with its encapsulation, as it comes out of a bag. Bytes of another type are
/// found out only if their length gives them away.
pub fn decode<M: RosMessage>(bytes: &[u8]) -> Result<M, CdrError> {
    let type_name = M::TYPE_NAME;
    let Some((&[high, low, _, _], body)) = bytes.split_first_chunk::<4>() else {
        return Err(CdrError::NoEncapsulation { type_name, n_bytes: bytes.len() });
    };
    match u16::from_be_bytes([high, low]) {
        0 => decode_body(body, ByteOrder::Big),
        1 => decode_body(body, ByteOrder::Little),
        found => Err(CdrError::Encapsulation { type_name, found }),
    }
}

/// Decodes a message without encapsulation, as a DDS library hands it over.
pub fn decode_body<M: RosMessage>(body: &[u8], byte_order: ByteOrder) -> Result<M, CdrError> {
    let type_name = M::TYPE_NAME;
    let n_bytes = body.len();
    let decoded = match byte_order {
        ByteOrder::Little => cdr_encoding::from_bytes::<M, LittleEndian>(body),
        ByteOrder::Big => cdr_encoding::from_bytes::<M, BigEndian>(body),
    };
    let (message, used) =
        decoded.map_err(|source| CdrError::Body { type_name, n_bytes, source })?;
    if n_bytes - used > MAX_PADDING {
        return Err(CdrError::TrailingBytes { type_name, used, n_bytes });
    }
    Ok(message)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rsrs::{LeaseState, RunLease};
    use crate::std_msgs::Bool;

    fn lease() -> RunLease {
        RunLease {
            run_id: "a run".into(),
            epoch: 7,
            state: u8::from(LeaseState::Running),
            robots: vec!["robot_1".into(), "robot_22".into()],
            echoed_counter: vec![1, u64::MAX],
            ..RunLease::default()
        }
    }

    #[test]
    fn both_byte_orders_decode() {
        let little = [0, 1, 0, 0, 2, 0, 0, 0, 5, 0, 0, 0];
        let big = [0, 0, 0, 0, 0, 0, 0, 2, 0, 0, 0, 5];

        let expected = crate::builtin_interfaces::Time { sec: 2, nanosec: 5 };
        assert_eq!(decode::<crate::builtin_interfaces::Time>(&little).unwrap(), expected);
        assert_eq!(decode::<crate::builtin_interfaces::Time>(&big).unwrap(), expected);
    }

    #[test]
    fn the_padding_that_rtps_adds_is_accepted_and_more_is_not() {
        assert!(decode::<Bool>(&[0, 1, 0, 0, 1, 0, 0, 0]).unwrap().data);

        let error = decode::<Bool>(&[0, 1, 0, 0, 1, 0, 0, 0, 0]).unwrap_err();

        assert!(matches!(error, CdrError::TrailingBytes { used: 1, n_bytes: 5, .. }), "{error}");
    }

    #[test]
    fn a_parameter_list_is_not_taken_for_plain_cdr() {
        let error = decode::<Bool>(&[0, 3, 0, 0, 1]).unwrap_err();

        assert_eq!(
            error.to_string(),
            "std_msgs/msg/Bool has encapsulation 0x0003, expected 0x0001 (CDR_LE) or 0x0000 (CDR_BE)"
        );
    }

    #[test]
    fn a_message_cut_anywhere_is_refused() {
        let bytes = encode(&lease());

        for n_bytes in 0..bytes.len() {
            assert!(decode::<RunLease>(&bytes[..n_bytes]).is_err(), "{n_bytes} bytes");
        }
        assert_eq!(decode::<RunLease>(&bytes).unwrap(), lease());
    }

    #[test]
    fn a_sequence_that_claims_four_billion_elements_costs_no_memory() {
        let mut body = encode_body(&RunLease::default());
        let length_at = body.len() - 4;
        body[length_at..].fill(0xff);

        let error = decode_body::<RunLease>(&body, ByteOrder::Little).unwrap_err();

        assert!(matches!(error, CdrError::Body { .. }), "{error}");
    }
}
