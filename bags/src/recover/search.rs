//! A damaged file: its bytes at any place, and the next record behind damage.

use std::fs::File;
use std::io::{self, BufReader, Read, Seek};
use std::path::{Path, PathBuf};

use mcap::records::{Record, op};

use super::sink::Sink;
use crate::BagError;
use crate::reader::ZSTD_MAGIC;
use crate::records::{self, HEAD_BYTES, MAX_CHUNK_HEAD_BYTES};

/// What is searched at a time.
const WINDOW_BYTES: u64 = 256 << 10;

/// What is looked for other bytes than zeros at a time.
const BLOCK_BYTES: u64 = 4 << 10;

/// Records other than chunks are not looked for beyond this size.
const MAX_RECORD: u64 = 16 << 20;

/// The representations of CDR that there are.
const MAX_ENCAPSULATION: u8 = 0x0b;

/// A file that can be read anywhere; fast where it is read in order.
pub struct DamagedFile {
    /// What the file is called where something about it is reported.
    pub path: PathBuf,
    pub n_bytes: u64,
    reader: BufReader<File>,
    position: u64,
}

impl DamagedFile {
    /// Takes a file that is open for reading.
    pub fn new(path: &Path, mut file: File) -> Result<Self, BagError> {
        let io = BagError::io("read", path);
        let n_bytes = file.metadata().map_err(&io)?.len();
        file.rewind().map_err(io)?;
        let reader = BufReader::with_capacity(1 << 20, file);
        Ok(Self { path: path.to_owned(), n_bytes, reader, position: 0 })
    }

    /// Reads what is from a place on, `n_bytes` of it at most.
    pub fn read(&mut self, at: u64, n_bytes: u64) -> Result<Vec<u8>, BagError> {
        let n_bytes = n_bytes.min(self.n_bytes.saturating_sub(at));
        self.read_within(at, n_bytes).map_err(BagError::io("read", &self.path))
    }

    fn read_within(&mut self, at: u64, n_bytes: u64) -> io::Result<Vec<u8>> {
        self.reader.seek_relative(at.wrapping_sub(self.position).cast_signed())?;
        self.position = at;
        let mut bytes = Vec::with_capacity(usize::try_from(n_bytes).unwrap_or(usize::MAX));
        self.reader.by_ref().take(n_bytes).read_to_end(&mut bytes)?;
        self.position += bytes.len() as u64;
        Ok(bytes)
    }

    /// Whether nothing but zeros, or nothing, follows from a place on.
    pub fn is_zero_from(&mut self, mut at: u64) -> Result<bool, BagError> {
        while at < self.n_bytes {
            if self.read(at, BLOCK_BYTES)?.iter().any(|byte| *byte != 0) {
                return Ok(false);
            }
            at += BLOCK_BYTES;
        }
        Ok(true)
    }

    /// Whether a record, the end mark or the end itself may be at a place.
    pub fn may_start(&mut self, at: u64) -> Result<bool, BagError> {
        if at >= self.n_bytes {
            return Ok(at == self.n_bytes);
        }
        let start = self.read(at, HEAD_BYTES as u64)?;
        let is_head = records::head(&start).is_some_and(|(opcode, length)| {
            let n_left = self.n_bytes - at - HEAD_BYTES as u64;
            records::is_known(opcode) && length <= n_left
        });
        Ok(is_head || start.starts_with(mcap::MAGIC))
    }

    /// The first place from here on at which a record starts beyond doubt; `end` or behind it if there is none before.
    ///
    /// Beyond doubt is a record with the length that its fields have, or a message of a known channel,
    /// and another record behind it; of a chunk its two lengths suffice. Messages and definitions are
    /// looked for only where they stand outside of chunks, with the sink that knows their channels:
    /// elsewhere they are part of a chunk whose head is lost, and with it the checksum that would show
    /// whether they are as they were sent.
    pub fn next_record(
        &mut self,
        from: u64,
        end: u64,
        loose: Option<&Sink>,
    ) -> Result<u64, BagError> {
        let mut at = from;
        while at < end {
            let window = self.read(at, WINDOW_BYTES + HEAD_BYTES as u64 - 1)?;
            for (start, place) in window.windows(HEAD_BYTES).zip(at..) {
                let Some((opcode, length)) = records::head(start) else { continue };
                let may_be_here = loose.is_some() || !records::may_be_in_chunks(opcode);
                let is_short = length <= MAX_RECORD.min(self.n_bytes - place);
                // A chunk may go on beyond the end.
                let is_sought =
                    opcode == op::CHUNK || (records::is_known(opcode) && may_be_here && is_short);
                if is_sought && self.is_record(place, opcode, length, loose)? {
                    return Ok(place);
                }
            }
            at += WINDOW_BYTES;
        }
        Ok(end)
    }

    fn is_record(
        &mut self,
        place: u64,
        opcode: u8,
        length: u64,
        loose: Option<&Sink>,
    ) -> Result<bool, BagError> {
        let body_at = place + HEAD_BYTES as u64;
        if opcode == op::CHUNK {
            let start = self.read(body_at, MAX_CHUNK_HEAD_BYTES)?;
            return Ok(records::chunk(&start).is_some_and(|(head, _)| {
                let is_supported = ["", "zstd", "lz4"].contains(&&*head.compression);
                let in_order = head.message_start_time <= head.message_end_time;
                records::chunk_length(&head) == length && is_supported && in_order
            }));
        }
        if !self.may_start(body_at + length)? {
            return Ok(false);
        }
        let body = self.read(body_at, length)?;
        Ok(match records::parse(opcode, &body) {
            Ok(Record::Message { header, data }) => {
                is_like_cdr(&data)
                    && loose.is_some_and(|sink| sink.topic(header.channel_id).is_some())
            }
            parsed => parsed.is_ok() && records::is_filled(opcode, &body),
        })
    }
}

/// Whether the data of a message starts as ROS 2 writes it, or is compressed by rosbag2.
fn is_like_cdr(data: &[u8]) -> bool {
    match data {
        [0, kind, _, _, ..] => *kind <= MAX_ENCAPSULATION,
        _ => data.starts_with(&ZSTD_MAGIC),
    }
}
