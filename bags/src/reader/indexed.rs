//! Messages of a file by its table of contents, in order of log time.

use std::fs::File;

use mcap::records::{MessageHeader, op};
use mcap::{McapError, McapResult};

use super::chunks::Contents;
use super::table::{ChunkPlace, Table};

/// Opcode and length in front of each record.
const HEAD_BYTES: usize = 9;

/// What stands in front of a message's data: channel, sequence, log time, publish time.
const MESSAGE_HEAD_BYTES: usize = 2 + 4 + 8 + 8;

/// The messages of a file in order of log time, and of equal times in the order of the file.
pub struct Indexed {
    /// First log time and place of each chunk, in the order in which they are read.
    chunks: Vec<(u64, u64)>,
    n_read: usize,
    contents: Contents,
    wanted: Option<Vec<bool>>,
    /// Contents of which not all was received yet.
    open: Vec<OpenChunk>,
    /// The messages of open chunks, in order.
    entries: Vec<Entry>,
    next_entry: usize,
}

/// A chunk of which not all was received yet.
struct OpenChunk {
    content: Vec<u8>,
    content_at: u64,
    n_left: usize,
}

/// Where a message is.
#[derive(Clone, Copy)]
struct Entry {
    log_time_ns: u64,
    chunk: u32,
    n_bytes: u32,
    at: usize,
}

impl Indexed {
    /// Prepares to read a file.
    ///
    /// # Arguments
    ///
    /// * `table` — the file's own.
    /// * `wanted` — the channels whose messages are asked for; `None` for all.
    /// * `limit` — the longest chunk that is believed, in bytes.
    ///
    /// # Errors
    ///
    /// [`McapError::ChunkTooLarge`].
    pub fn new(
        file: File,
        table: &Table,
        wanted: Option<&[u16]>,
        limit: usize,
    ) -> McapResult<Self> {
        let is_wanted = |place: &&ChunkPlace| {
            let list = &table.channel_lists[place.channels as usize];
            list.is_empty()
                || wanted.is_none_or(|wanted| list.iter().any(|channel| wanted.contains(channel)))
        };
        let mut places: Vec<ChunkPlace> = table.chunks.iter().filter(is_wanted).copied().collect();
        places.sort_by_key(|place| (place.first_ns, place.content_at));
        let is_too_large =
            |place: &&ChunkPlace| place.packed_bytes.max(place.content_bytes) > limit as u64;
        if let Some(place) = places.iter().find(is_too_large) {
            return Err(McapError::ChunkTooLarge(place.content_bytes));
        }
        let flags = |wanted: &[u16]| {
            let mut flags = vec![false; wanted.iter().max().map_or(0, |id| usize::from(*id) + 1)];
            for id in wanted {
                flags[usize::from(*id)] = true;
            }
            flags
        };
        Ok(Self {
            chunks: places.iter().map(|place| (place.first_ns, place.content_at)).collect(),
            contents: Contents::new(file, table, places),
            n_read: 0,
            wanted: wanted.map(flags),
            open: Vec::new(),
            entries: Vec::new(),
            next_entry: 0,
        })
    }

    /// Goes to the next message.
    ///
    /// # Returns
    ///
    /// Whether there is one; it is what [`Indexed::received`] gives then.
    ///
    /// # Errors
    ///
    /// If a chunk does not unpack, or what is in it is no record.
    pub fn advance(&mut self) -> McapResult<bool> {
        self.forget_received();
        loop {
            let next = self.entries.get(self.next_entry).map(|entry| entry.log_time_ns);
            let chunk = self.chunks.get(self.n_read).map(|(first_ns, _)| *first_ns);
            match (next, chunk) {
                (None, None) => return Ok(false),
                (Some(next_ns), Some(first_ns)) if first_ns < next_ns => self.read_chunk()?,
                (None, Some(_)) => self.read_chunk()?,
                (Some(_), _) => break,
            }
        }
        self.next_entry += 1;
        Ok(true)
    }

    /// The message that was gone to.
    pub fn received(&self) -> (MessageHeader, &[u8]) {
        let entry = self.entries[self.next_entry - 1];
        let content = &self.open[entry.chunk as usize].content;
        let body = &content[entry.at..entry.at + entry.n_bytes as usize];
        let (channel_id, rest) = body.split_first_chunk().expect(WHOLE);
        let (sequence, rest) = rest.split_first_chunk().expect(WHOLE);
        let (log_time, rest) = rest.split_first_chunk().expect(WHOLE);
        let (publish_time, data) = rest.split_first_chunk().expect(WHOLE);
        let header = MessageHeader {
            channel_id: u16::from_le_bytes(*channel_id),
            sequence: u32::from_le_bytes(*sequence),
            log_time: u64::from_le_bytes(*log_time),
            publish_time: u64::from_le_bytes(*publish_time),
        };
        (header, data)
    }

    /// Counts the last message as received, so that the room of its chunk can be used again.
    fn forget_received(&mut self) {
        if let Some(entry) = self.next_entry.checked_sub(1).map(|last| self.entries[last]) {
            self.open[entry.chunk as usize].n_left -= 1;
        }
        if self.next_entry == self.entries.len() {
            self.entries.clear();
            self.next_entry = 0;
        }
    }

    fn read_chunk(&mut self) -> McapResult<()> {
        let (_, content_at) = self.chunks[self.n_read];
        self.n_read += 1;
        let slot = self.open.iter().position(|open| open.n_left == 0).unwrap_or_else(|| {
            self.open.push(OpenChunk { content: Vec::new(), content_at: 0, n_left: 0 });
            self.open.len() - 1
        });
        let spent = std::mem::take(&mut self.open[slot].content);
        let content = self.contents.next(spent).ok_or(McapError::UnexpectedEof)??;
        // What was received goes before new entries come: a chunk may overlap many others.
        if self.next_entry > 1 {
            self.entries.drain(..self.next_entry - 1);
            self.next_entry = 1;
        }
        let n_before = self.entries.len();
        let chunk = u32::try_from(slot).map_err(|_too_many| McapError::BadIndex)?;
        let is_in_order = self.list(&content, chunk)?;
        let n_left = self.entries.len() - n_before;
        self.open[slot] = OpenChunk { content, content_at, n_left };
        if !is_in_order || n_before > self.next_entry {
            let open = &self.open;
            self.entries[self.next_entry..].sort_by_key(|entry| {
                (entry.log_time_ns, open[entry.chunk as usize].content_at, entry.at)
            });
        }
        Ok(())
    }

    /// Lists the wanted messages of a chunk.
    ///
    /// # Returns
    ///
    /// Whether they are in order of log time.
    fn list(&mut self, content: &[u8], chunk: u32) -> McapResult<bool> {
        let mut is_in_order = true;
        let mut latest_ns = 0;
        let mut rest = content;
        while let Some((&[opcode], after)) = rest.split_first_chunk() {
            let (length, after) = after.split_first_chunk().ok_or(McapError::UnexpectedEoc)?;
            let length = usize::try_from(u64::from_le_bytes(*length))
                .map_err(|_too_long| McapError::UnexpectedEoc)?;
            let (body, after) = after.split_at_checked(length).ok_or(McapError::UnexpectedEoc)?;
            let at = content.len() - rest.len() + HEAD_BYTES;
            rest = after;
            if opcode != op::MESSAGE {
                continue;
            }
            let head = body.first_chunk::<MESSAGE_HEAD_BYTES>().ok_or(McapError::UnexpectedEoc)?;
            let channel_id = usize::from(u16::from_le_bytes([head[0], head[1]]));
            if self.wanted.as_ref().is_some_and(|flags| flags.get(channel_id) != Some(&true)) {
                continue;
            }
            let log_time_ns =
                u64::from_le_bytes(*head[6..].first_chunk().expect("it has 22 bytes"));
            is_in_order &= log_time_ns >= latest_ns;
            latest_ns = latest_ns.max(log_time_ns);
            let n_bytes = u32::try_from(length).map_err(|_too_long| McapError::UnexpectedEoc)?;
            self.entries.push(Entry { log_time_ns, chunk, n_bytes, at });
        }
        Ok(is_in_order)
    }
}

/// Why a message has all of its head.
const WHOLE: &str = "messages without a whole head are not listed";
