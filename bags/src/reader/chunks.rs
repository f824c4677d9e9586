//! The contents of chunks, one after the other, unpacked ahead of whoever reads them.

use std::collections::VecDeque;
use std::fs::File;
use std::io::{Read, Seek, SeekFrom};
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::thread;

use mcap::{McapError, McapResult};

use super::table::{ChunkPlace, Table};
use crate::unpack::Unpacker;

/// Fewer compressed chunks than this are not worth a thread.
const MIN_FOR_A_THREAD: usize = 16;

/// Chunks are handed over together until they have so many bytes: a chunk of one second is small.
const BATCH_BYTES: usize = 1 << 20;

/// Batches that wait to be read.
const N_WAITING: usize = 2;

/// The contents of some chunks, in the order in which they were asked for.
pub enum Contents {
    /// Each when it is asked for.
    Here(Box<Unpacking>),
    /// By a thread that ends when nobody listens any more.
    Ahead {
        /// From the thread.
        batches: Receiver<Batch>,
        /// What came and was not asked for yet.
        batch: VecDeque<McapResult<Vec<u8>>>,
    },
}

/// Some contents in a row; after an error comes nothing.
type Batch = VecDeque<McapResult<Vec<u8>>>;

/// What unpacks the chunks.
pub struct Unpacking {
    file: File,
    places: std::vec::IntoIter<ChunkPlace>,
    compressions: Vec<String>,
    unpacker: Unpacker,
    packed: Vec<u8>,
}

impl Contents {
    /// Prepares to read chunks.
    ///
    /// # Arguments
    ///
    /// * `places` — the chunks, in order; they were held against the size of the file.
    pub fn new(file: File, table: &Table, places: Vec<ChunkPlace>) -> Self {
        let is_packed =
            |place: &ChunkPlace| !table.compressions[usize::from(place.compression)].is_empty();
        let n_packed = places.iter().filter(|place| is_packed(place)).count();
        let unpacking = Unpacking {
            file,
            places: places.into_iter(),
            compressions: table.compressions.clone(),
            unpacker: Unpacker::new(),
            packed: Vec::new(),
        };
        if n_packed < MIN_FOR_A_THREAD {
            return Self::Here(Box::new(unpacking));
        }
        let (sender, batches) = sync_channel(N_WAITING);
        thread::spawn(move || unpacking.run(&sender));
        Self::Ahead { batches, batch: VecDeque::new() }
    }

    /// The content of the next chunk; `spent` is memory that may be used again.
    pub fn next(&mut self, spent: Vec<u8>) -> Option<McapResult<Vec<u8>>> {
        match self {
            Self::Here(unpacking) => unpacking.next(spent),
            Self::Ahead { batches, batch } => {
                if batch.is_empty() {
                    *batch = batches.recv().ok()?;
                }
                batch.pop_front()
            }
        }
    }
}

impl Unpacking {
    fn run(mut self, sender: &SyncSender<Batch>) {
        let mut batch = Batch::new();
        let mut n_bytes = 0;
        loop {
            let next = self.next(Vec::new());
            let is_last = !matches!(next, Some(Ok(_)));
            if let Some(content) = next {
                n_bytes += content.as_ref().map_or(0, Vec::len);
                batch.push_back(content);
            }
            if is_last || n_bytes >= BATCH_BYTES {
                n_bytes = 0;
                let is_received = sender.send(std::mem::take(&mut batch)).is_ok();
                if is_last || !is_received {
                    return;
                }
            }
        }
    }

    fn next(&mut self, mut content: Vec<u8>) -> Option<McapResult<Vec<u8>>> {
        let place = self.places.next()?;
        Some(self.unpack(&place, &mut content).map(|()| content))
    }

    fn unpack(&mut self, place: &ChunkPlace, content: &mut Vec<u8>) -> McapResult<()> {
        self.file.seek(SeekFrom::Start(place.content_at))?;
        self.packed.clear();
        (&self.file).take(place.packed_bytes).read_to_end(&mut self.packed)?;
        if self.packed.len() as u64 != place.packed_bytes {
            return Err(McapError::UnexpectedEof);
        }
        let compression = &*self.compressions[usize::from(place.compression)];
        let size = usize::try_from(place.content_bytes)
            .map_err(|_too_large| McapError::ChunkTooLarge(place.content_bytes))?;
        if compression.is_empty() && size == self.packed.len() {
            std::mem::swap(content, &mut self.packed);
            return Ok(());
        }
        let unpacked = self.unpacker.unpack((compression, &self.packed), size, content);
        unpacked.map_err(McapError::DecompressionError)
    }
}
