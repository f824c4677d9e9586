//! Where saved things go: a new bag, made when the first of them comes.

use std::collections::{BTreeMap, HashMap};
use std::path::PathBuf;

use mcap::records::{self, AttachmentHeader, MessageHeader, Record};

use super::chunk::Chunk;
use super::copy::{Copier, schema_of};
use super::loss::{Loss, LostMessages, is_complete};
use super::parts::Schema;
use super::recovery;
use super::target::{PackedChunk, Target};
use crate::metadata::{self, FileInformation, Information};
use crate::reader::{Table, ZSTD_MAGIC, plain};
use crate::writer::{ChannelDescription, new_folder};
use crate::{BagError, BagSummary, Compression};

/// Losses that the new bag itself tells of; all of them are in the report.
const MAX_DESCRIBED: usize = 100;

/// A new bag and what is known of the file whose content goes into it.
pub struct Sink {
    folder: PathBuf,
    target: Option<Target>,
    copier: Copier,
    /// For what cannot be copied as it is; as the original, by and large.
    compression: Compression,
    custom_data: BTreeMap<String, String>,
    schemas: HashMap<u16, Schema>,
    channels: HashMap<u16, records::Channel>,
    /// Definitions in the table of contents, for those that are lost elsewhere.
    fallback: Option<Table>,
    /// The channels that were used so far, with the numbers that they have in the new file.
    ids: HashMap<u16, u16>,
    /// Messages of the current file, by channel.
    counts: BTreeMap<u16, u64>,
    /// Attachments of all files.
    pub n_attachments: u64,
    /// Metadata records of all files, rosbag2's own aside.
    pub n_metadata: u64,
}

/// What became of a message.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fate {
    /// It is in the new bag.
    Saved,
    /// Nothing says what it is.
    UnknownChannel,
    /// It is compressed and does not decompress.
    Unreadable,
}

impl Sink {
    /// A bag that will be in this folder.
    pub fn new(folder: PathBuf) -> Self {
        Self {
            folder,
            target: None,
            copier: Copier::new(),
            compression: Compression::None,
            custom_data: BTreeMap::new(),
            schemas: HashMap::new(),
            channels: HashMap::new(),
            fallback: None,
            ids: HashMap::new(),
            counts: BTreeMap::new(),
            n_attachments: 0,
            n_metadata: 0,
        }
    }

    /// Forgets the definitions of the file before: each file numbers its own.
    pub fn next_file(&mut self, fallback: Option<Table>) {
        self.schemas.clear();
        self.channels.clear();
        self.ids.clear();
        self.counts.clear();
        self.fallback = fallback;
    }

    /// Whether the current file's own table of contents lists chunks.
    pub fn expects_chunks(&self) -> bool {
        let stats = self.fallback.as_ref().and_then(|table| table.stats.as_ref());
        stats.is_some_and(|stats| stats.chunk_count > 0)
    }

    /// Keeps pairs for `metadata.yaml`.
    pub fn add_custom_data(&mut self, pairs: BTreeMap<String, String>) {
        self.custom_data.extend(pairs);
    }

    /// Takes a definition; of two with one number the first one counts.
    pub fn define(&mut self, record: Record) -> Result<(), BagError> {
        if let Some((id, schema)) = schema_of(&record) {
            self.schemas.entry(id).or_insert(schema);
        }
        if let Record::Channel(channel) = record {
            let id = channel.id;
            self.channels.entry(id).or_insert(channel);
            // A topic without messages is saved, too.
            self.id_of(id)?;
        }
        Ok(())
    }

    /// Whether messages of this channel can be saved.
    pub fn has_channel(&self, channel_id: u16) -> bool {
        self.topic(channel_id).is_some()
    }

    /// The topic of a channel.
    pub fn topic(&self, channel_id: u16) -> Option<String> {
        let own = self.channels.get(&channel_id).map(|channel| channel.topic.clone());
        own.or_else(|| {
            let channels = &self.fallback.as_ref()?.channels;
            Some(channels.get(&channel_id)?.topic.clone())
        })
    }

    /// Takes a message.
    pub fn message(&mut self, header: &MessageHeader, data: &[u8]) -> Result<Fate, BagError> {
        let Some(id) = self.id_of(header.channel_id)? else { return Ok(Fate::UnknownChannel) };
        let unpacked;
        let mut data = data;
        if data.starts_with(&ZSTD_MAGIC) {
            let Ok(bytes) = plain(data.to_vec()) else { return Ok(Fate::Unreadable) };
            unpacked = bytes;
            data = &unpacked;
            self.compression = Compression::Zstd;
        }
        let renumbered = MessageHeader { channel_id: id, ..*header };
        let compression = self.compression;
        let target = self.target()?;
        target.pack_as(compression);
        target.message(&renumbered, data)?;
        *self.counts.entry(header.channel_id).or_default() += 1;
        Ok(Fate::Saved)
    }

    /// Takes a chunk as it is, if nothing is wrong with it.
    ///
    /// # Returns
    ///
    /// Its messages by channel; `None` if it must be taken message by message.
    pub fn copy(&mut self, chunk: &Chunk) -> Result<Option<BTreeMap<u16, u64>>, BagError> {
        self.compression = match chunk.head.compression.as_str() {
            "" => Compression::None,
            _ => Compression::Zstd,
        };
        let Some(content) = self.copier.read(chunk) else { return Ok(None) };
        for definition in content.definitions {
            if !self.define_the_same(definition)? {
                return Ok(None);
            }
        }
        let in_chunk = self.copier.entries.iter().filter(|(_, entries)| !entries.is_empty());
        let n_of_channel: BTreeMap<u16, u64> =
            in_chunk.map(|(id, entries)| (*id, entries.len() as u64)).collect();
        if n_of_channel.is_empty() {
            return Ok(Some(n_of_channel));
        }
        for channel_id in n_of_channel.keys() {
            if self.id_of(*channel_id)? != Some(*channel_id) {
                return Ok(None);
            }
        }
        let packed = PackedChunk {
            uncompressed_size: content.n_bytes,
            crc: content.crc,
            compression: &chunk.head.compression,
            packed: chunk.content(),
            entries: &self.copier.entries,
        };
        self.target.as_mut().expect("channels were added to it").chunk(&packed)?;
        for (channel_id, n_messages) in &n_of_channel {
            *self.counts.entry(*channel_id).or_default() += n_messages;
        }
        Ok(Some(n_of_channel))
    }

    /// Takes a definition out of a chunk that is to be copied.
    ///
    /// # Returns
    ///
    /// Whether the new file says the same under the same number.
    fn define_the_same(&mut self, record: Record) -> Result<bool, BagError> {
        if let Some((id, schema)) = schema_of(&record) {
            self.define(record)?;
            let is_first = self.schemas.get(&id) == Some(&schema);
            return Ok(is_first && self.target()?.add_schema(id, schema)? == id);
        }
        let Record::Channel(channel) = record else { return Ok(true) };
        self.define(Record::Channel(channel.clone()))?;
        let is_first = self.channels.get(&channel.id) == Some(&channel);
        let known = self.target()?.definitions().channels.get(&channel.id);
        let is_same = known.is_some_and(|(schema_id, description)| {
            *schema_id == channel.schema_id
                && description.topic == channel.topic
                && description.message_encoding == channel.message_encoding
                && description.metadata == channel.metadata
        });
        Ok(is_first && is_same && self.id_of(channel.id)? == Some(channel.id))
    }

    /// Messages saved of the current file, by topic.
    pub fn saved(&self) -> BTreeMap<String, u64> {
        self.by_topic(&self.counts)
    }

    /// Counts of channels of the current file, by topic.
    pub fn by_topic(&self, counts: &BTreeMap<u16, u64>) -> BTreeMap<String, u64> {
        let mut of_topic = BTreeMap::new();
        for (channel_id, n_messages) in counts {
            *of_topic.entry(self.topic(*channel_id).unwrap_or_default()).or_default() += n_messages;
        }
        of_topic
    }

    /// Takes an attachment.
    pub fn attach(&mut self, header: &AttachmentHeader, data: &[u8]) -> Result<(), BagError> {
        self.n_attachments += 1;
        self.target()?.attach(header, data)
    }

    /// Takes a metadata record; rosbag2's own is made anew, with the pairs in it.
    pub fn metadata(&mut self, record: &records::Metadata) -> Result<(), BagError> {
        if record.name == metadata::RECORD {
            let contents = metadata::read_record(&record.metadata);
            let pairs = contents.and_then(|contents| contents.custom_data);
            self.add_custom_data(pairs.unwrap_or_default());
            return Ok(());
        }
        self.n_metadata += 1;
        self.target()?.metadata(&record.name, &record.metadata)
    }

    /// Messages in the new bag so far, by topic.
    pub fn n_messages_of_topic(&self) -> BTreeMap<String, u64> {
        let Some(target) = &self.target else { return BTreeMap::new() };
        let mut of_topic: BTreeMap<String, u64> = BTreeMap::new();
        for (id, (_, known)) in &target.definitions().channels {
            *of_topic.entry(known.topic.clone()).or_default() +=
                target.counts.get(id).copied().unwrap_or(0);
        }
        of_topic
    }

    /// Writes into the new bag, if there is one, what is missing in it.
    pub fn describe(&mut self, losses: &[Loss], lost: &LostMessages) -> Result<(), BagError> {
        let Some(target) = &mut self.target else { return Ok(()) };
        let n_bytes: u64 = losses.iter().map(|loss| loss.n_bytes).sum();
        let mut pairs = BTreeMap::from([
            ("n_losses".to_owned(), losses.len().to_string()),
            ("n_bytes_lost".to_owned(), n_bytes.to_string()),
            (recovery::IS_COMPLETE.to_owned(), is_complete(losses, lost).to_string()),
            (recovery::N_MESSAGES_LOST.to_owned(), lost.total().to_string()),
            (recovery::IS_EXACT.to_owned(), lost.is_exact.to_string()),
            (recovery::LACKS_END.to_owned(), losses.iter().any(Loss::is_of_the_end).to_string()),
        ]);
        for (index, loss) in losses.iter().take(MAX_DESCRIBED).enumerate() {
            let file = loss.path.file_name().unwrap_or_default().to_string_lossy();
            let Loss { at_byte, n_bytes, reason, .. } = loss;
            let text = format!("{file}: {n_bytes} bytes at {at_byte}: {reason}");
            pairs.insert(format!("{}{index}", recovery::LOSS), text);
        }
        target.metadata(recovery::RECORD, &pairs)
    }

    /// Closes the new bag.
    ///
    /// # Returns
    ///
    /// `None` if there was nothing to put into it.
    pub fn finish(self) -> Result<Option<BagSummary>, BagError> {
        let n_messages_of_topic = self.n_messages_of_topic();
        let Some(mut target) = self.target else { return Ok(None) };
        target.close_chunk()?;
        let counted = target.definitions().channels.iter();
        let topics: Vec<_> = counted
            .map(|(id, (_, known))| known.with_count(target.counts.get(id).copied().unwrap_or(0)))
            .collect();
        let n_messages = n_messages_of_topic.values().sum();
        let (file, bounds_ns) = (target.path().to_owned(), target.bounds_ns);
        let name = file.file_name().unwrap_or_default().to_string_lossy().into_owned();
        let files = vec![FileInformation::new(&name, bounds_ns, n_messages)];
        let information = Information::new(files, topics, self.custom_data);
        target.metadata(metadata::RECORD, &information.to_record())?;
        target.finish()?;
        information.write_into(&self.folder)?;
        let files = vec![file.clone()];
        let folder = self.folder;
        Ok(Some(BagSummary { folder, file, files, n_messages, n_messages_of_topic, bounds_ns }))
    }

    /// Makes the new bag, though there may be nothing to put into it.
    ///
    /// # Errors
    ///
    /// If it cannot be made.
    pub fn keep_empty(&mut self) -> Result<(), BagError> {
        self.target().map(drop)
    }

    fn target(&mut self) -> Result<&mut Target, BagError> {
        if self.target.is_none() {
            let name = new_folder(&self.folder)?;
            self.target = Some(Target::create(self.folder.join(format!("{name}_0.mcap")))?);
        }
        Ok(self.target.as_mut().expect("it was just made"))
    }

    /// The channel in the new file; `None` if its definition or that of its type is lost.
    fn id_of(&mut self, channel_id: u16) -> Result<Option<u16>, BagError> {
        if let Some(id) = self.ids.get(&channel_id) {
            return Ok(Some(*id));
        }
        let Some((schema_id, description)) = self.description(channel_id) else {
            return Ok(None);
        };
        let id = self.target()?.add_channel((channel_id, schema_id), description)?;
        self.ids.insert(channel_id, id);
        Ok(Some(id))
    }

    /// What is known of a channel, with the number of its type.
    fn description(&self, channel_id: u16) -> Option<(u16, ChannelDescription)> {
        let fallback = || self.fallback.as_ref()?.channels.get(&channel_id);
        let Some(channel) = self.channels.get(&channel_id) else {
            let channel = fallback()?;
            let (schema_id, schema) = channel
                .schema
                .as_ref()
                .map_or((0, Schema::default()), |schema| (schema.id, Schema::of_table(schema)));
            let named = (&*channel.topic, &*channel.message_encoding);
            return Some((schema_id, describe(named, &channel.metadata, schema)));
        };
        let schema = match channel.schema_id {
            0 => Schema::default(),
            id => match self.schemas.get(&id) {
                Some(schema) => schema.clone(),
                None => Schema::of_table(self.fallback.as_ref()?.schemas.get(&id)?),
            },
        };
        let named = (&*channel.topic, &*channel.message_encoding);
        Some((channel.schema_id, describe(named, &channel.metadata, schema)))
    }
}

impl Schema {
    /// A type in a table of contents.
    fn of_table(schema: &mcap::Schema) -> Self {
        let (name, encoding) = (schema.name.clone(), schema.encoding.clone());
        Self { name, encoding, data: schema.data.to_vec() }
    }
}

fn describe(
    (topic, encoding): (&str, &str),
    pairs: &BTreeMap<String, String>,
    schema: Schema,
) -> ChannelDescription {
    ChannelDescription {
        topic: topic.to_owned(),
        type_name: schema.name,
        schema_encoding: schema.encoding,
        schema: schema.data,
        message_encoding: encoding.to_owned(),
        metadata: pairs.clone(),
    }
}
