//! The next record behind damage.

use std::fs::File;
use std::io;

use mcap::records::{Record, op};

use super::sink::Sink;
use crate::records::{self, ChunkHead, HEAD_BYTES, MAX_CHUNK_HEAD_BYTES, may_start, read_at};

/// What is searched at a time.
const WINDOW_BYTES: usize = 256 << 10;

/// Records other than chunks are not looked for beyond this size.
const MAX_RECORD: u64 = 16 << 20;

/// The representations of CDR that there are.
const MAX_ENCAPSULATION: u8 = 0x0b;

/// Zeros at the end of a file in such number are not data: the system had promised the space and
/// lost power before it kept the promise.
const MIN_ZERO_TAIL: u64 = 64;

/// Where the messages of a file are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Layout {
    /// In chunks. What looks like a message behind damage is part of a chunk whose head is lost, and
    /// with it the checksum that would show whether the message is as it was sent.
    Chunks,
    /// Outside of chunks.
    Loose,
}

/// A file that is searched for records.
pub struct Search<'a> {
    pub file: &'a File,
    pub n_bytes: u64,
    pub layout: Layout,
    pub sink: &'a Sink,
}

impl Search<'_> {
    /// The first place from here on at which a record starts beyond doubt; the end if there is none.
    ///
    /// Beyond doubt is what states its length twice and the same, or a message of a known channel
    /// that another record follows.
    pub fn next_record(&self, from: u64) -> io::Result<u64> {
        let mut window = vec![0; WINDOW_BYTES + HEAD_BYTES];
        let mut at = from;
        while at < self.n_bytes {
            let n_read = read_at(self.file, &mut window, at)?;
            for offset in 0..n_read.min(WINDOW_BYTES) {
                let place = at + offset as u64;
                let Some((opcode, length)) = records::head(&window[offset..n_read]) else { break };
                if self.is_sought(opcode, length) && self.is_record(place, opcode, length)? {
                    return Ok(place);
                }
            }
            at += WINDOW_BYTES as u64;
        }
        Ok(self.n_bytes)
    }

    /// Whether it is worth reading what may be a record.
    fn is_sought(&self, opcode: u8, length: u64) -> bool {
        let may_be_loose = self.layout == Layout::Loose || !records::may_be_in_chunks(opcode);
        // A chunk may go on beyond the end.
        opcode == op::CHUNK || (records::is_known(opcode) && may_be_loose && length <= MAX_RECORD)
    }

    fn is_record(&self, place: u64, opcode: u8, length: u64) -> io::Result<bool> {
        let body_at = place + HEAD_BYTES as u64;
        if opcode == op::CHUNK {
            let mut start = [0; MAX_CHUNK_HEAD_BYTES];
            let n_read = read_at(self.file, &mut start, body_at)?;
            return Ok(ChunkHead::parse(&start[..n_read]).is_some_and(|head| {
                let in_order = head.header.message_start_time <= head.header.message_end_time;
                head.fills(length) && head.is_supported() && in_order
            }));
        }
        let is_there = length <= self.n_bytes.saturating_sub(body_at);
        if !is_there || !may_start(self.file, body_at + length)? {
            return Ok(false);
        }
        let mut body = vec![0; usize::try_from(length).unwrap_or(usize::MAX)];
        read_at(self.file, &mut body, body_at)?;
        Ok(match records::parse(opcode, &body) {
            Ok(Record::Message { header, data }) => {
                self.sink.has_channel(header.channel_id) && is_like_cdr(&data)
            }
            Ok(_) => records::is_filled(opcode, &body),
            Err(_) => false,
        })
    }
}

/// Whether the data of a message starts as ROS 2 writes it, or is compressed by rosbag2.
pub fn is_like_cdr(data: &[u8]) -> bool {
    match data {
        [0, kind, _, _, ..] => *kind <= MAX_ENCAPSULATION,
        _ => data.starts_with(&crate::reader::ZSTD_MAGIC),
    }
}

/// Where nothing but a long run of zeros follows up to the end of a file; the end if there is none.
pub fn zero_tail(file: &File) -> io::Result<u64> {
    let n_bytes = file.metadata()?.len();
    let mut end = n_bytes;
    let mut block = vec![0; WINDOW_BYTES];
    while end > 0 {
        let start = end.saturating_sub(WINDOW_BYTES as u64);
        let n_read = read_at(file, &mut block, start)?;
        let n_read = n_read.min(usize::try_from(end - start).unwrap_or(usize::MAX));
        if let Some(last) = block[..n_read].iter().rposition(|byte| *byte != 0) {
            end = start + last as u64 + 1;
            break;
        }
        end = start;
    }
    Ok(if n_bytes - end >= MIN_ZERO_TAIL { end } else { n_bytes })
}

#[cfg(test)]
mod tests {
    use std::io::Write;

    use super::*;

    #[test]
    fn only_a_long_run_of_zeros_is_a_tail() {
        let with_zeros = |n_zeros| {
            let mut file = tempfile::tempfile().unwrap();
            file.write_all(&[vec![7; 10], vec![0; n_zeros]].concat()).unwrap();
            zero_tail(&file).unwrap()
        };

        assert_eq!(with_zeros(63), 73);
        assert_eq!(with_zeros(64), 10);
        assert_eq!(with_zeros(3 << 20), 10);
    }
}
