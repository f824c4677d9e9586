//! The file of a recovered bag, written record by record, so that sound chunks can go into it as
//! they are.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::{BufWriter, IntoInnerError, Write};
use std::path::{Path, PathBuf};

use mcap::McapError;
use mcap::records::{AttachmentHeader, MessageHeader, op};

use super::encode::{self, RecordBytes};
use super::new_chunk::NewChunk;
use super::parts::{Definitions, Entries, Schema, Span};
use crate::writer::ChannelDescription;
use crate::{BagError, Compression};

/// What the system is given at once.
const BUFFER_BYTES: usize = 256 << 10;

/// A chunk that is ready to be written.
pub struct PackedChunk<'a> {
    /// Bytes of its content before compression.
    pub uncompressed_size: u64,
    /// Checksum of that.
    pub crc: u32,
    /// Empty, `zstd` or `lz4`.
    pub compression: &'a str,
    /// Its content.
    pub packed: &'a [u8],
    /// Its messages.
    pub entries: &'a Entries,
}

/// The file of a recovered bag.
pub struct Target {
    path: PathBuf,
    file: BufWriter<File>,
    at: u64,
    data_crc: crc32fast::Hasher,
    definitions: Definitions,
    chunk: NewChunk,
    /// Messages by channel.
    pub counts: BTreeMap<u16, u64>,
    /// First and last log time, in nanoseconds.
    pub bounds_ns: Option<(u64, u64)>,
    n_chunks: u32,
    n_attachments: u32,
    n_metadata: u32,
    chunk_indexes: Vec<u8>,
    attachment_indexes: Vec<u8>,
    metadata_indexes: Vec<u8>,
}

impl Target {
    /// Starts a file that must not exist.
    pub fn create(path: PathBuf) -> Result<Self, BagError> {
        let file = File::create_new(&path).map_err(|source| BagError::Io {
            action: "create",
            path: path.clone(),
            source,
        })?;
        let mut target = Self {
            path,
            file: BufWriter::with_capacity(BUFFER_BYTES, file),
            at: 0,
            data_crc: crc32fast::Hasher::new(),
            definitions: Definitions::default(),
            chunk: NewChunk::default(),
            counts: BTreeMap::new(),
            bounds_ns: None,
            n_chunks: 0,
            n_attachments: 0,
            n_metadata: 0,
            chunk_indexes: Vec::new(),
            attachment_indexes: Vec::new(),
            metadata_indexes: Vec::new(),
        };
        target.put(mcap::MAGIC)?;
        let library = concat!("rsrs ", env!("CARGO_PKG_VERSION"));
        let header = RecordBytes::new(op::HEADER).sized(b"ros2").sized(library.as_bytes());
        target.put(&header.finish())?;
        Ok(target)
    }

    /// Where it is.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// What it says of types and channels.
    pub fn definitions(&self) -> &Definitions {
        &self.definitions
    }

    /// Compresses single messages so from now on, with zstd if at all.
    pub fn pack_as(&mut self, compression: Compression) {
        self.chunk.is_compressed = compression != Compression::None;
    }

    /// Adds a type, under this number if it is free; the same type twice is one.
    pub fn add_schema(&mut self, wanted_id: u16, schema: Schema) -> Result<u16, BagError> {
        let schemas = &self.definitions.schemas;
        if schemas.get(&wanted_id) == Some(&schema) {
            return Ok(wanted_id);
        }
        if let Some((id, _)) = schemas.iter().find(|(_, known)| **known == schema) {
            return Ok(*id);
        }
        // Zero means that a channel has no type.
        let id = free_id(wanted_id.max(1), |id| schemas.contains_key(&id));
        let id = id.ok_or_else(|| self.full())?;
        self.close_chunk()?;
        self.put(&encode::schema(id, &schema))?;
        self.definitions.schemas.insert(id, schema);
        Ok(id)
    }

    /// Adds a channel, under this number if it is free; the same channel twice is one.
    ///
    /// # Arguments
    ///
    /// * `wanted` — the number that it had and that of its type.
    pub fn add_channel(
        &mut self,
        wanted: (u16, u16),
        description: ChannelDescription,
    ) -> Result<u16, BagError> {
        let schema_id = if description.type_name.is_empty() {
            0
        } else {
            let ChannelDescription { type_name, schema_encoding, schema, .. } = &description;
            let (name, encoding) = (type_name.clone(), schema_encoding.clone());
            self.add_schema(wanted.1, Schema { name, encoding, data: schema.clone() })?
        };
        let channels = &self.definitions.channels;
        let known = channels.iter().find(|(_, known)| known.1 == description);
        if let Some((id, _)) = known {
            return Ok(*id);
        }
        let id = free_id(wanted.0, |id| channels.contains_key(&id));
        let id = id.ok_or_else(|| self.full())?;
        self.close_chunk()?;
        self.put(&encode::channel(id, schema_id, &description))?;
        self.definitions.channels.insert(id, (schema_id, description));
        self.counts.entry(id).or_default();
        Ok(id)
    }

    /// Adds a message of a channel that was added.
    pub fn message(&mut self, header: &MessageHeader, data: &[u8]) -> Result<(), BagError> {
        self.chunk.add(header, data);
        if self.chunk.is_full() { self.close_chunk() } else { Ok(()) }
    }

    /// Adds a chunk whose messages are of channels that were added under the same numbers.
    pub fn chunk(&mut self, chunk: &PackedChunk) -> Result<(), BagError> {
        self.close_chunk()?;
        self.put_chunk(chunk)
    }

    /// Adds an attachment.
    pub fn attach(&mut self, header: &AttachmentHeader, data: &[u8]) -> Result<(), BagError> {
        self.close_chunk()?;
        let span = self.put(&encode::attachment(header, data))?;
        let index = encode::attachment_index(span, header, data.len() as u64);
        self.attachment_indexes.extend(index);
        self.n_attachments += 1;
        Ok(())
    }

    /// Adds pairs of texts.
    pub fn metadata(
        &mut self,
        name: &str,
        pairs: &BTreeMap<String, String>,
    ) -> Result<(), BagError> {
        self.close_chunk()?;
        let span = self.put(&encode::metadata(name, pairs))?;
        self.metadata_indexes.extend(encode::metadata_index(span, name));
        self.n_metadata += 1;
        Ok(())
    }

    /// Ends the messages, so that counts and times are final.
    pub fn close_chunk(&mut self) -> Result<(), BagError> {
        if self.chunk.is_empty() {
            return Ok(());
        }
        let chunk = std::mem::take(&mut self.chunk);
        let packed = chunk.pack().map_err(|source| self.io("write", source))?;
        self.put_chunk(&PackedChunk {
            uncompressed_size: chunk.content.len() as u64,
            crc: crc32fast::hash(&chunk.content),
            compression: if chunk.is_compressed { "zstd" } else { "" },
            packed: packed.as_deref().unwrap_or(&chunk.content),
            entries: &chunk.entries,
        })?;
        self.chunk = chunk.emptied();
        Ok(())
    }

    fn put_chunk(&mut self, chunk: &PackedChunk) -> Result<(), BagError> {
        let times_ns = || chunk.entries.values().flatten().map(|(time_ns, _)| *time_ns);
        let bounds_ns = times_ns().min().zip(times_ns().max());
        let n_packed = chunk.packed.len() as u64;
        let head = RecordBytes::new(op::CHUNK).span(bounds_ns).u64(chunk.uncompressed_size);
        let head = head.u32(chunk.crc).sized(chunk.compression.as_bytes()).u64(n_packed);
        let Span { at, n_bytes } = self.put(&head.finish_before(chunk.packed.len()))?;
        self.put(chunk.packed)?;

        let indexes_at = self.at;
        let mut offsets = Vec::new();
        for (channel_id, entries) in chunk.entries.iter().filter(|(_, all)| !all.is_empty()) {
            let span = self.put(&encode::message_index(*channel_id, entries))?;
            offsets.push((*channel_id, span.at));
            *self.counts.entry(*channel_id).or_default() += entries.len() as u64;
        }
        let index =
            RecordBytes::new(op::CHUNK_INDEX).span(bounds_ns).u64(at).u64(n_bytes + n_packed);
        let index = index.by_channel(offsets.iter().map(|(channel_id, at)| (channel_id, at)));
        let index = index.u64(self.at - indexes_at).sized(chunk.compression.as_bytes());
        let index = index.u64(n_packed).u64(chunk.uncompressed_size);
        self.chunk_indexes.extend(index.finish());
        self.n_chunks += 1;
        self.bounds_ns = match (self.bounds_ns, bounds_ns) {
            (Some(all), Some(new)) => Some((all.0.min(new.0), all.1.max(new.1))),
            (all, new) => all.or(new),
        };
        Ok(())
    }

    /// Ends the file with its table of contents; it is on the disk on return.
    pub fn finish(mut self) -> Result<(), BagError> {
        self.close_chunk()?;
        let data_crc = std::mem::take(&mut self.data_crc).finalize();
        self.put(&RecordBytes::new(op::DATA_END).u32(data_crc).finish())?;

        let summary_at = self.at;
        let mut groups = encode::definitions(&self.definitions).to_vec();
        groups.extend([
            (op::STATISTICS, self.statistics()),
            (op::CHUNK_INDEX, std::mem::take(&mut self.chunk_indexes)),
            (op::ATTACHMENT_INDEX, std::mem::take(&mut self.attachment_indexes)),
            (op::METADATA_INDEX, std::mem::take(&mut self.metadata_indexes)),
        ]);
        // From here on the checksum is that of the summary.
        self.data_crc = crc32fast::Hasher::new();
        let mut offsets = Vec::new();
        for (opcode, records) in groups.iter().filter(|(_, records)| !records.is_empty()) {
            let Span { at, n_bytes } = self.put(records)?;
            let offset = RecordBytes::new(op::SUMMARY_OFFSET).raw(&[*opcode]).u64(at).u64(n_bytes);
            offsets.extend(offset.finish());
        }
        let offsets_at = self.put(&offsets)?.at;
        let footer = RecordBytes::new(op::FOOTER).u64(summary_at).u64(offsets_at);
        self.put(&footer.finish_before(4))?;
        let summary_crc = std::mem::take(&mut self.data_crc).finalize();
        self.put(&summary_crc.to_le_bytes())?;
        self.put(mcap::MAGIC)?;

        let Self { path, file, .. } = self;
        let synced =
            file.into_inner().map_err(IntoInnerError::into_error).and_then(|file| file.sync_all());
        synced.map_err(|source| BagError::Io { action: "close", path, source })
    }

    fn statistics(&self) -> Vec<u8> {
        let count = |n_things: usize| u32::try_from(n_things).expect("their numbers have 16 bits");
        let n_schemas = self.definitions.schemas.len();
        let n_schemas = u16::try_from(n_schemas).expect("zero is not a number of a type");
        let record = RecordBytes::new(op::STATISTICS).u64(self.counts.values().sum());
        let record = record.u16(n_schemas).u32(count(self.definitions.channels.len()));
        let record = record.u32(self.n_attachments).u32(self.n_metadata).u32(self.n_chunks);
        record.span(self.bounds_ns).by_channel(self.counts.iter()).finish()
    }

    /// Writes bytes and says where they are.
    fn put(&mut self, bytes: &[u8]) -> Result<Span, BagError> {
        self.file.write_all(bytes).map_err(|source| self.io("write", source))?;
        self.data_crc.update(bytes);
        let span = Span { at: self.at, n_bytes: bytes.len() as u64 };
        self.at += span.n_bytes;
        Ok(span)
    }

    fn io(&self, action: &'static str, source: std::io::Error) -> BagError {
        BagError::Io { action, path: self.path.clone(), source }
    }

    fn full(&self) -> BagError {
        BagError::Write { path: self.path.clone(), source: McapError::TooManyChannels }
    }
}

/// The wanted number, or the smallest above it that is free, or the smallest of all.
fn free_id(wanted: u16, is_taken: impl Fn(u16) -> bool) -> Option<u16> {
    (wanted..=u16::MAX).chain(1..wanted).find(|id| !is_taken(*id))
}
