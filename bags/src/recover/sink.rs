//! Where saved things go: a new bag, made when the first of them comes.

use std::collections::{BTreeMap, HashMap};
use std::path::PathBuf;

use mcap::Summary;
use mcap::records::{self, MessageHeader, Record};

use super::loss::Loss;
use crate::metadata;
use crate::reader::plain;
use crate::writer::ChannelDescription;
use crate::{BagError, BagOptions, BagSummary, BagWriter, ChannelId, Packing, Sample, qos};

/// Losses that the new bag itself tells of; all of them are in the report.
const MAX_DESCRIBED: usize = 100;

/// A new bag and what is known of the file whose content goes into it.
pub struct Sink {
    folder: PathBuf,
    writer: Option<BagWriter>,
    custom_data: BTreeMap<String, String>,
    schemas: HashMap<u16, Schema>,
    channels: HashMap<u16, records::Channel>,
    /// Definitions in the table of contents, for those that are lost elsewhere.
    fallback: Option<Summary>,
    ids: HashMap<u16, ChannelId>,
    /// Messages of the current file, by channel.
    counts: BTreeMap<u16, u64>,
    /// Attachments of all files.
    pub n_attachments: u64,
    /// Metadata records of all files, rosbag2's own aside.
    pub n_metadata: u64,
}

#[derive(Clone)]
struct Schema {
    name: String,
    encoding: String,
    data: Vec<u8>,
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
            writer: None,
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
    pub fn next_file(&mut self, fallback: Option<Summary>) {
        self.schemas.clear();
        self.channels.clear();
        self.ids.clear();
        self.counts.clear();
        self.fallback = fallback;
    }

    /// Keeps pairs for `metadata.yaml`.
    pub fn add_custom_data(&mut self, pairs: BTreeMap<String, String>) {
        self.custom_data.extend(pairs);
    }

    /// Takes a definition; of two with one number the first one counts.
    pub fn define(&mut self, record: Record) -> Result<(), BagError> {
        match record {
            Record::Schema { header, data } => {
                let records::SchemaHeader { id, name, encoding } = header;
                let schema = Schema { name, encoding, data: data.into_owned() };
                self.schemas.entry(id).or_insert(schema);
            }
            Record::Channel(channel) => {
                let id = channel.id;
                self.channels.entry(id).or_insert(channel);
                // A topic without messages is saved, too.
                self.id_of(id)?;
            }
            _ => {}
        }
        Ok(())
    }

    /// Whether messages of this channel can be saved.
    pub fn knows(&self, channel_id: u16) -> bool {
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
        let data = if data.starts_with(&[0x28, 0xb5, 0x2f, 0xfd]) {
            let Ok(bytes) = plain(data.to_vec()) else { return Ok(Fate::Unreadable) };
            unpacked = bytes;
            &unpacked
        } else {
            data
        };
        let sample = Sample {
            log_time_ns: header.log_time,
            publish_time_ns: header.publish_time,
            sequence: header.sequence,
            data,
        };
        self.writer()?.write(id, sample)?;
        *self.counts.entry(header.channel_id).or_default() += 1;
        Ok(Fate::Saved)
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
    pub fn attach(&mut self, name: &str, media_type: &str, data: &[u8]) -> Result<(), BagError> {
        self.n_attachments += 1;
        self.writer()?.attach(name, media_type, data)
    }

    /// Takes a metadata record; rosbag2's own is made anew, with the pairs in it.
    pub fn metadata(&mut self, record: records::Metadata) -> Result<(), BagError> {
        if record.name == metadata::RECORD {
            let contents = metadata::read_record(&record.metadata);
            let pairs = contents.and_then(|contents| contents.custom_data);
            self.add_custom_data(pairs.unwrap_or_default());
            return Ok(());
        }
        self.n_metadata += 1;
        self.writer()?.metadata(&record.name, record.metadata)
    }

    /// Writes into the new bag, if there is one, what is missing in it.
    pub fn describe(&mut self, name: &str, losses: &[Loss]) -> Result<(), BagError> {
        let Some(writer) = &mut self.writer else { return Ok(()) };
        let n_bytes: u64 = losses.iter().map(|loss| loss.n_bytes).sum();
        let mut pairs = BTreeMap::from([
            ("n_losses".to_owned(), losses.len().to_string()),
            ("n_bytes_lost".to_owned(), n_bytes.to_string()),
        ]);
        for (index, loss) in losses.iter().take(MAX_DESCRIBED).enumerate() {
            let file = loss.path.file_name().unwrap_or_default().to_string_lossy();
            let Loss { at_byte, n_bytes, reason, .. } = loss;
            let text = format!("{file}: {n_bytes} bytes at {at_byte}: {reason}");
            pairs.insert(format!("loss_{index}"), text);
        }
        writer.metadata(name, pairs)
    }

    /// Closes the new bag.
    ///
    /// # Returns
    ///
    /// `None` if there was nothing to put into it.
    pub fn finish(self) -> Result<Option<BagSummary>, BagError> {
        let Some(mut writer) = self.writer else { return Ok(None) };
        writer.add_custom_data(self.custom_data);
        writer.finish().map(Some)
    }

    fn writer(&mut self) -> Result<&mut BagWriter, BagError> {
        if self.writer.is_none() {
            let options = BagOptions { custom_data: self.custom_data.clone() };
            // The original is still there, so that nothing need be safe at once.
            let packing = Packing { flush_period_ns: None, ..Packing::default() };
            self.writer = Some(BagWriter::create_packed(&self.folder, options, packing)?);
        }
        Ok(self.writer.as_mut().expect("it was just made"))
    }

    /// The channel in the new bag; `None` if its definition or that of its type is lost.
    fn id_of(&mut self, channel_id: u16) -> Result<Option<ChannelId>, BagError> {
        if let Some(id) = self.ids.get(&channel_id) {
            return Ok(Some(*id));
        }
        let Some(description) = self.description(channel_id) else { return Ok(None) };
        let id = self.writer()?.add_channel(description)?;
        self.ids.insert(channel_id, id);
        Ok(Some(id))
    }

    fn description(&self, channel_id: u16) -> Option<ChannelDescription> {
        let Some(channel) = self.channels.get(&channel_id) else {
            let channel = self.fallback.as_ref()?.channels.get(&channel_id)?;
            let schema = channel.schema.as_ref().map(|schema| Schema {
                name: schema.name.clone(),
                encoding: schema.encoding.clone(),
                data: schema.data.to_vec(),
            });
            return Some(describe(
                (&channel.topic, &channel.message_encoding),
                &channel.metadata,
                schema.unwrap_or_else(Schema::none),
            ));
        };
        let schema = match channel.schema_id {
            0 => Schema::none(),
            id => match self.schemas.get(&id) {
                Some(schema) => schema.clone(),
                None => self.fallback_schema(id)?,
            },
        };
        Some(describe((&channel.topic, &channel.message_encoding), &channel.metadata, schema))
    }

    fn fallback_schema(&self, id: u16) -> Option<Schema> {
        let schema = self.fallback.as_ref()?.schemas.get(&id)?;
        let (name, encoding) = (schema.name.clone(), schema.encoding.clone());
        Some(Schema { name, encoding, data: schema.data.to_vec() })
    }
}

impl Schema {
    /// That of a channel which never had one.
    fn none() -> Self {
        Self { name: String::new(), encoding: String::new(), data: Vec::new() }
    }
}

fn describe(
    (topic, encoding): (&str, &str),
    pairs: &BTreeMap<String, String>,
    schema: Schema,
) -> ChannelDescription {
    let mut metadata = pairs.clone();
    if let Some(offered) = metadata.get_mut(qos::KEY) {
        *offered = qos::in_numbers(offered);
    }
    ChannelDescription {
        topic: topic.to_owned(),
        type_name: schema.name,
        schema_encoding: schema.encoding,
        schema: schema.data,
        message_encoding: encoding.to_owned(),
        metadata,
    }
}
