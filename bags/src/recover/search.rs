//! The next record behind damage.

use std::io;

use mcap::records::{Record, op};

use super::bytes::Bytes;
use super::sink::Sink;
use super::validity::{self, ChunkHead};
use crate::records::{self, HEAD_BYTES};

/// What is searched at a time.
const WINDOW_BYTES: usize = 256 << 10;

/// Records other than chunks are not looked for beyond this size.
const MAX_RECORD: u64 = 16 << 20;

/// Where the messages of a file are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Layout {
    /// In chunks. What looks like a message behind damage is part of a chunk whose head is lost, and
    /// with it the checksum that would show whether the message is as it was sent.
    Chunks,
    /// Outside of chunks, as far as is known.
    Loose,
}

/// The first place from here on at which a record starts beyond doubt; the end if there is none.
///
/// Beyond doubt is what states its length twice and the same, or a message of a known channel that
/// another record follows.
pub fn next_record(bytes: &mut Bytes, from: u64, sink: &Sink, layout: Layout) -> io::Result<u64> {
    let mut at = from;
    while at < bytes.len() {
        let window = bytes.read(at, WINDOW_BYTES + HEAD_BYTES)?;
        if window.len() < HEAD_BYTES {
            break;
        }
        let n_starts = (window.len() - HEAD_BYTES + 1).min(WINDOW_BYTES);
        for offset in 0..n_starts {
            let place = at + offset as u64;
            if window[offset..].starts_with(mcap::MAGIC) {
                return Ok(place);
            }
            let Some((opcode, length)) = records::head(&window[offset..]) else { break };
            let is_sought = layout == Layout::Loose || !records::may_be_in_chunks(opcode);
            if is_sought
                && is_candidate(opcode, length, bytes.len() - place)
                && is_record(bytes, place, opcode, length, sink)?
            {
                return Ok(place);
            }
        }
        at += n_starts as u64;
    }
    Ok(bytes.len())
}

/// Whether a record, the end mark or the end itself may be at a place.
pub fn is_plausible(bytes: &mut Bytes, at: u64) -> io::Result<bool> {
    if at >= bytes.len() {
        return Ok(at == bytes.len());
    }
    let start = bytes.read(at, HEAD_BYTES)?;
    let available = bytes.len() - at;
    let is_head = records::head(&start).is_some_and(|(opcode, length)| {
        let fits = length.checked_add(HEAD_BYTES as u64).is_some_and(|all| all <= available);
        validity::is_known(opcode) && fits
    });
    Ok(is_head || start.starts_with(mcap::MAGIC))
}

/// Whether it is worth reading what may be a record.
fn is_candidate(opcode: u8, length: u64, available: u64) -> bool {
    match opcode {
        // A chunk may go on beyond the end.
        op::CHUNK => (32..1 << 40).contains(&length),
        op::HEADER
        | op::SCHEMA
        | op::CHANNEL
        | op::MESSAGE
        | op::MESSAGE_INDEX
        | op::ATTACHMENT
        | op::METADATA => length <= MAX_RECORD && length + (HEAD_BYTES as u64) <= available,
        op::DATA_END => length == 4,
        op::FOOTER => length == 20,
        _ => false,
    }
}

fn is_record(bytes: &mut Bytes, at: u64, opcode: u8, length: u64, sink: &Sink) -> io::Result<bool> {
    let body_at = at + HEAD_BYTES as u64;
    if opcode == op::CHUNK {
        let start = bytes.read(body_at, validity::MAX_CHUNK_HEAD_BYTES)?;
        let head = ChunkHead::parse(&start);
        return Ok(head.is_some_and(|head| {
            let in_order = head.header.message_start_time <= head.header.message_end_time;
            head.fills_record(length) && in_order
        }));
    }
    let body = bytes.read(body_at, usize::try_from(length).unwrap_or(usize::MAX))?;
    if !validity::is_sound(opcode, &body) || !is_plausible(bytes, body_at + length)? {
        return Ok(false);
    }
    Ok(match records::parse(opcode, &body) {
        Ok(Record::Message { header, data }) => {
            sink.has_channel(header.channel_id) && validity::is_like_cdr(&data)
        }
        _ => true,
    })
}
