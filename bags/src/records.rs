//! Records of MCAP out of bytes that may be damaged.

use std::io::{Cursor, Read};

use binrw::BinRead;
use mcap::records::{AttachmentHeader, Record, op};
use mcap::{McapError, McapResult};

/// Opcode and length in front of each record.
pub const HEAD_BYTES: usize = 9;

/// Opcode and length of the record that starts here.
pub fn head(bytes: &[u8]) -> Option<(u8, u64)> {
    let (&opcode, rest) = bytes.split_first()?;
    Some((opcode, u64::from_le_bytes(*rest.first_chunk()?)))
}

/// The record at the start of some bytes, as its opcode and its body; `None` if it is not all there.
pub fn first(bytes: &[u8]) -> Option<(u8, &[u8])> {
    let (opcode, length) = head(bytes)?;
    let body = bytes[HEAD_BYTES..].get(..usize::try_from(length).ok()?)?;
    Some((opcode, body))
}

/// Whether records of this kind stand in chunks, where there are any.
pub fn may_be_in_chunks(opcode: u8) -> bool {
    [op::SCHEMA, op::CHANNEL, op::MESSAGE].contains(&opcode)
}

/// Reads a record.
///
/// As [`mcap::parse_record`], which panics at an attachment that ends within its checksum.
///
/// # Errors
///
/// If some of its fields are missing or make no sense.
pub fn parse(opcode: u8, body: &[u8]) -> McapResult<Record<'_>> {
    if opcode == op::ATTACHMENT {
        let mut fields = Cursor::new(body);
        AttachmentHeader::read_le(&mut fields)?;
        // The length of the data, and the checksum behind them.
        if fields.position() + 8 + 4 > body.len() as u64 {
            return Err(McapError::UnexpectedEof);
        }
    }
    mcap::parse_record(opcode, body)
}

/// Unpacks the content of a chunk.
///
/// # Arguments
///
/// * `compression` — empty, `zstd` or `lz4`.
/// * `size` — how many bytes it must give.
/// * `content` — what was in it is gone; if unpacking fails, as much as could be unpacked.
///
/// # Errors
///
/// [`McapError::DecompressionError`].
pub fn unpack(
    (compression, packed): (&str, &[u8]),
    size: usize,
    content: &mut Vec<u8>,
) -> McapResult<()> {
    content.clear();
    // One byte more than expected would show that the size is wrong.
    content.reserve(size + 1);
    let limit = size as u64 + 1;
    let read = match compression {
        "" => packed.take(limit).read_to_end(content),
        "zstd" => zstd::stream::read::Decoder::with_buffer(packed)
            .and_then(|decoder| decoder.take(limit).read_to_end(content)),
        "lz4" => {
            lz4::Decoder::new(packed).and_then(|decoder| decoder.take(limit).read_to_end(content))
        }
        other => return Err(McapError::UnsupportedCompression(other.to_owned())),
    };
    read.map_err(|error| McapError::DecompressionError(error.to_string()))?;
    if content.len() == size {
        return Ok(());
    }
    let n_bytes = content.len();
    content.truncate(size);
    Err(McapError::DecompressionError(format!("it has {n_bytes} bytes, expected {size}")))
}

/// What is wrong, with what the system reports of it.
pub fn reason(error: &McapError) -> String {
    match error {
        McapError::Io(cause) => cause.to_string(),
        McapError::Parse(_) => "a record lacks some of its fields".to_owned(),
        error => error.to_string(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_attachment_that_ends_anywhere_is_refused_without_panic() {
        // Two times, two empty names, no data and no checksum.
        let whole = [0; 16 + 4 + 4 + 8 + 4];

        assert!(parse(op::ATTACHMENT, &whole).is_ok());
        for n_bytes in 0..whole.len() {
            assert!(parse(op::ATTACHMENT, &whole[..n_bytes]).is_err(), "{n_bytes} bytes");
        }
    }

    #[test]
    fn what_can_be_unpacked_of_a_cut_chunk_is_there() {
        let content: Vec<u8> = (0..600_000_u32).flat_map(u32::to_le_bytes).collect();
        let packed = zstd::bulk::compress(&content, 1).unwrap();
        let mut unpacked = Vec::new();

        let whole = unpack(("zstd", &packed), content.len(), &mut unpacked);
        assert!(whole.is_ok() && unpacked == content);
        let cut = unpack(("zstd", &packed[..packed.len() / 2]), content.len(), &mut unpacked);
        assert!(cut.is_err() && unpacked.len() > content.len() / 4);
        assert_eq!(unpacked, content[..unpacked.len()]);
        assert!(unpack(("zstd", &packed), content.len() - 1, &mut unpacked).is_err());
    }
}
