//! The content of a chunk, whole or not.

use mcap::records::ChunkHeader;
use mcap::{McapError, McapResult};

use super::sound::ChunkHead;
use crate::records::{self, HEAD_BYTES};

/// A chunk of this size is believed, and a larger one only if the file has an amount of bytes for
/// it that compression could explain: a damaged length must not take all memory.
const MIN_CONTENT_LIMIT: usize = 64 << 20;

/// Compression seldom does better than this.
const MAX_COMPRESSION: usize = 256;

/// A chunk as the file has it.
pub struct Chunk<'a> {
    pub header: &'a ChunkHeader,
    /// As much of its content as there is.
    pub packed: &'a [u8],
    /// Whether its end is missing.
    pub is_cut: bool,
}

impl<'a> Chunk<'a> {
    /// A chunk with its head, and as much of its content as there is.
    pub fn new(head: &'a ChunkHead, body: &'a [u8], is_cut: bool) -> Self {
        let packed = body.get(head.n_bytes..).unwrap_or_default();
        let n_bytes = usize::try_from(head.header.compressed_size).unwrap_or(usize::MAX);
        Self { header: &head.header, packed: &packed[..n_bytes.min(packed.len())], is_cut }
    }

    /// Unpacks what may be taken of it.
    ///
    /// That is nothing of a chunk whose checksum fails, because nobody could tell which of its
    /// messages are wrong. Of a chunk whose end is missing it is the beginning, as far as it can be
    /// unpacked.
    ///
    /// # Errors
    ///
    /// What is wrong with the chunk; what may be taken is in `content` all the same.
    pub fn unpack(&self, content: &mut Vec<u8>) -> McapResult<()> {
        let ChunkHeader { compression, uncompressed_size, uncompressed_crc: saved, .. } =
            self.header;
        let limit = self.packed.len().saturating_mul(MAX_COMPRESSION).max(MIN_CONTENT_LIMIT);
        let size = usize::try_from(*uncompressed_size).unwrap_or(usize::MAX);
        content.clear();
        if self.is_cut {
            // That the end is missing is known.
            let _ = records::unpack((compression, self.packed), size.min(limit), content);
            return Err(McapError::UnexpectedEof);
        }
        if size > limit {
            return Err(McapError::ChunkTooLarge(*uncompressed_size));
        }
        let unpacked = records::unpack((compression, self.packed), size, content);
        if *saved == 0 {
            return unpacked;
        }
        let calculated = crc32fast::hash(content);
        let checked = unpacked.and(if calculated == *saved {
            Ok(())
        } else {
            Err(McapError::BadChunkCrc { saved: *saved, calculated })
        });
        if checked.is_err() {
            content.clear();
        }
        checked
    }
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
