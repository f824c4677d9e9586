//! The content of a chunk, whole or not.

use mcap::records::ChunkHeader;
use mcap::{McapError, McapResult};

use super::validity::ChunkHead;
use crate::reader::unpacked_limit;
use crate::records::{self, HEAD_BYTES, Unpacker};

/// What is used again for each chunk.
pub struct Room {
    pub unpacker: Unpacker,
    /// What may be taken of the chunk.
    pub content: Vec<u8>,
}

/// Unpacks a chunk.
///
/// Nothing is taken of a chunk whose checksum fails, because it cannot be determined which of its
/// messages are wrong.
///
/// # Errors
///
/// What is wrong with the chunk; what may be taken is in its room all the same.
pub fn unpack(head: &ChunkHead, body: &[u8], room: &mut Room) -> McapResult<()> {
    let Room { unpacker, content } = room;
    let ChunkHeader { uncompressed_size, uncompressed_crc: saved, .. } = head.header;
    let packed = packed(head, body);
    let size = usize::try_from(uncompressed_size).unwrap_or(usize::MAX);
    content.clear();
    if size > unpacked_limit(packed.len()) {
        return Err(McapError::ChunkTooLarge(uncompressed_size));
    }
    let mut unpacked = unpacker.unpack((&head.header.compression, packed), size, content);
    if saved == 0 {
        return unpacked;
    }
    let calculated = crc32fast::hash(content);
    if unpacked.is_ok() && calculated != saved {
        unpacked = Err(McapError::BadChunkCrc { saved, calculated });
    }
    if unpacked.is_err() {
        content.clear();
    }
    unpacked
}

/// Unpacks the beginning of a chunk whose end is missing, as far as it goes, and says what is wrong
/// with it.
pub fn unpack_beginning(head: &ChunkHead, body: &[u8], room: &mut Room) -> McapError {
    let Room { unpacker, content } = room;
    let packed = packed(head, body);
    let size = usize::try_from(head.header.uncompressed_size).unwrap_or(usize::MAX);
    let size = size.min(unpacked_limit(packed.len()));
    let _cut: McapResult<()> = unpacker.unpack((&head.header.compression, packed), size, content);
    McapError::UnexpectedEof
}

/// As much of the content as there is.
fn packed<'a>(head: &ChunkHead, body: &'a [u8]) -> &'a [u8] {
    let packed = body.get(head.n_bytes..).unwrap_or_default();
    let n_bytes = usize::try_from(head.header.compressed_size).unwrap_or(usize::MAX);
    &packed[..n_bytes.min(packed.len())]
}

/// The record at the start of what is left of a content; `None` if it is not sound.
pub fn first_record(rest: &[u8]) -> Option<(u8, &[u8])> {
    let (opcode, body) = records::first(rest)?;
    let behind = &rest[HEAD_BYTES + body.len()..];
    // Its last bytes were never written if it runs into zeros that go on to the end.
    let is_half_written =
        body.last() == Some(&0) && !behind.is_empty() && behind.iter().all(|byte| *byte == 0);
    (records::may_be_in_chunks(opcode) && !is_half_written).then_some((opcode, body))
}
