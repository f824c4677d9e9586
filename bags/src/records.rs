//! Records of MCAP out of bytes that may be damaged.

use std::io::{self, Cursor, Read};

use binrw::BinRead;
use mcap::records::{ChunkHeader, Record, op};
use mcap::{McapError, McapResult};
use zstd::stream::read::Decoder;
use zstd::zstd_safe::{DCtx, ResetDirective, SafeResult};

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

/// Whether records of this kind exist; private ones are not ours to keep.
pub fn is_known(opcode: u8) -> bool {
    (op::HEADER..=op::DATA_END).contains(&opcode)
}

/// Whether records of this kind stand in chunks, where there are any.
pub fn may_be_in_chunks(opcode: u8) -> bool {
    [op::SCHEMA, op::CHANNEL, op::MESSAGE].contains(&opcode)
}

/// Reads a record.
///
/// As [`mcap::parse_record`], which makes room for as much as the length of a text claims, up to 4 GiB,
/// before it looks whether so much is there, and panics at an attachment that ends within its
/// checksum.
pub fn parse(opcode: u8, body: &[u8]) -> McapResult<Record<'_>> {
    if behind_fields(opcode, body).is_none() {
        let message = "a field goes on beyond its record".to_owned();
        return Err(McapError::Parse(binrw::Error::AssertFail { pos: 0, message }));
    }
    mcap::parse_record(opcode, body)
}

/// What is behind the fields of a record whose length they give, and behind the compression of a chunk;
/// `None` if they do not end within it.
pub fn behind_fields(opcode: u8, body: &[u8]) -> Option<&[u8]> {
    let (n_before, n_sized) = match opcode {
        op::HEADER | op::METADATA => (0, 2),
        op::FOOTER => (20, 0),
        op::SCHEMA => (2, 3),
        op::CHANNEL => (4, 3),
        op::CHUNK => (28, 1),
        op::MESSAGE_INDEX => (2, 1),
        op::ATTACHMENT => (16, 2),
        op::DATA_END => (4, 0),
        _ => return Some(body),
    };
    let mut rest = body.get(n_before..)?;
    let mut last = rest;
    for _ in 0..n_sized {
        (last, rest) = sized(rest)?;
    }
    if [op::CHANNEL, op::METADATA].contains(&opcode) {
        while !last.is_empty() {
            (_, last) = sized(last)?;
        }
    }
    if opcode == op::ATTACHMENT {
        let (length, data) = rest.split_first_chunk()?;
        let n_bytes = usize::try_from(u64::from_le_bytes(*length)).ok()?;
        // The checksum is behind the data.
        rest = data.get(n_bytes.checked_add(4)?..)?;
    }
    Some(rest)
}

/// Whether a record other than a chunk or message has its fields and nothing behind them.
pub fn is_filled(opcode: u8, body: &[u8]) -> bool {
    behind_fields(opcode, body).is_some_and(<[u8]>::is_empty)
}

/// Bytes behind their length, and what is behind them.
fn sized(bytes: &[u8]) -> Option<(&[u8], &[u8])> {
    let (length, rest) = bytes.split_first_chunk()?;
    rest.split_at_checked(usize::try_from(u32::from_le_bytes(*length)).ok()?)
}

/// What must be read of a chunk for its head: start, end, size, checksum, the name of its compression behind
/// a length, compressed size.
pub const MAX_CHUNK_HEAD_BYTES: u64 = 8 + 8 + 8 + 4 + 4 + 16 + 8;

/// The head of a chunk, and what is there of its content and behind it; `None` if the head is none.
pub fn chunk(body: &[u8]) -> Option<(ChunkHeader, &[u8])> {
    behind_fields(op::CHUNK, body)?;
    let mut fields = Cursor::new(body);
    let head = ChunkHeader::read_le(&mut fields).ok()?;
    Some((head, &body[usize::try_from(fields.position()).ok()?..]))
}

/// How long the record of a chunk is by its head.
pub fn chunk_length(head: &ChunkHeader) -> u64 {
    let n_bytes = 8 + 8 + 8 + 4 + 4 + head.compression.len() + 8;
    head.compressed_size.saturating_add(n_bytes as u64)
}

/// What unpacks chunks, one after the other: a context of zstd for each would take longer than most of
/// them.
pub struct Unpacker(DCtx<'static>);

impl Unpacker {
    /// An unpacker for any compression that there is.
    pub fn new() -> Self {
        Self(DCtx::create())
    }

    /// Unpacks a chunk as [`Unpacker::unpack`] does, to `limit` bytes at most, and compares the checksum
    /// in its head.
    pub fn unpack_chunk(
        &mut self,
        header: &ChunkHeader,
        packed: &[u8],
        limit: usize,
        content: &mut Vec<u8>,
    ) -> McapResult<()> {
        let size = usize::try_from(header.uncompressed_size).ok();
        let size = size.filter(|size| *size <= limit);
        let size = size.ok_or(McapError::ChunkTooLarge(header.uncompressed_size))?;
        self.unpack((&header.compression, packed), size, content)?;
        let (saved, calculated) = (header.uncompressed_crc, crc32fast::hash(content));
        if saved != 0 && saved != calculated {
            return Err(McapError::BadChunkCrc { saved, calculated });
        }
        Ok(())
    }

    /// Unpacks a chunk, of `zstd`, `lz4` or no compression, which must give `size` bytes. They
    /// replace the `content`; if unpacking fails, that is as much as could be unpacked.
    pub fn unpack(
        &mut self,
        (compression, packed): (&str, &[u8]),
        size: usize,
        content: &mut Vec<u8>,
    ) -> McapResult<()> {
        // One byte more than expected would show that the size is wrong.
        content.resize(size + 1, 0);
        let outcome = match compression {
            "" => fill(content, packed),
            "zstd" => {
                // Ends what an incomplete chunk has begun; nothing else can go wrong with it.
                let _before: SafeResult = self.0.reset(ResetDirective::SessionOnly);
                fill(content, Decoder::with_context(packed, &mut self.0))
            }
            "lz4" => lz4::Decoder::new(packed)
                .map_or_else(|error| (0, Err(error)), |decoder| fill(content, decoder)),
            other => return Err(McapError::UnsupportedCompression(other.to_owned())),
        };
        let (n_bytes, read) = outcome;
        content.truncate(n_bytes.min(size));
        read.map_err(|error| McapError::DecompressionError(error.to_string()))?;
        if n_bytes == size {
            return Ok(());
        }
        let text = format!("it has {n_bytes} bytes, expected {size}");
        Err(McapError::DecompressionError(text))
    }
}

/// Reads until the buffer is full or nothing is left, and counts what was read.
fn fill(buffer: &mut [u8], mut source: impl Read) -> (usize, io::Result<()>) {
    let mut n_bytes = 0;
    while n_bytes < buffer.len() {
        match source.read(&mut buffer[n_bytes..]) {
            Ok(0) => break,
            Ok(n_read) => n_bytes += n_read,
            Err(error) => return (n_bytes, Err(error)),
        }
    }
    (n_bytes, Ok(()))
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
    fn a_text_that_claims_gigabytes_is_refused_before_there_is_room_for_it() {
        assert_eq!(behind_fields(op::SCHEMA, &[1, 0, 0xff, 0xff, 0xff, 0xff, b'a']), None);
        assert_eq!(behind_fields(op::METADATA, &[0, 0, 0, 0, 4, 0, 0, 0, 9, 0, 0, 0]), None);
        assert_eq!(behind_fields(op::METADATA, &[0, 0, 0, 0, 0, 0, 0, 0, 9]), Some(&[9][..]));
    }

    #[test]
    fn a_record_with_a_byte_too_many_or_too_few_is_not_filled() {
        let mut channel = vec![1, 0, 1, 0];
        for text in ["/a", "cdr", ""] {
            channel.extend(u32::try_from(text.len()).unwrap().to_le_bytes());
            channel.extend(text.as_bytes());
        }

        assert!(is_filled(op::CHANNEL, &channel));
        assert!(!is_filled(op::CHANNEL, &channel[1..]));
        assert!(!is_filled(op::CHANNEL, &[channel, vec![0]].concat()));
        assert!(!is_filled(op::MESSAGE_INDEX, &[1, 0, 15, 0, 0, 0]));
        assert!(is_filled(op::MESSAGE_INDEX, &[1, 0, 0, 0, 0, 0]));
        assert!(is_filled(op::DATA_END, &[0; 4]));
        assert!(!is_filled(op::FOOTER, &[0; 19]));
    }

    #[test]
    fn what_can_be_unpacked_of_a_cut_chunk_is_there() {
        let content: Vec<u8> = (0..600_000_u32).flat_map(u32::to_le_bytes).collect();
        let packed = zstd::bulk::compress(&content, 1).unwrap();
        let mut unpacked = Vec::new();
        let mut unpacker = Unpacker::new();
        let mut unpack = |packed: &[u8], size: usize, into: &mut Vec<u8>| {
            unpacker.unpack(("zstd", packed), size, into)
        };

        let whole = unpack(&packed, content.len(), &mut unpacked);
        assert!(whole.is_ok() && unpacked == content);
        let cut = unpack(&packed[..packed.len() / 2], content.len(), &mut unpacked);
        assert!(cut.is_err() && unpacked.len() > content.len() / 4);
        assert_eq!(unpacked, content[..unpacked.len()]);
        assert!(unpack(&packed, content.len() - 1, &mut unpacked).is_err());
    }
}
