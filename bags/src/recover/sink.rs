//! Where saved things go: a new bag, made when the first of them comes.

use std::borrow::Cow;
use std::collections::{BTreeMap, HashMap};
use std::path::PathBuf;
use std::sync::Arc;

use mcap::read::ChannelAccumulator;
use mcap::records::{self, AttachmentHeader, MessageHeader, Record};
use mcap::{Channel, Summary};

use super::loss::{Loss, LostMessages, is_complete};
use super::recovery;
use crate::metadata;
use crate::reader::plain;
use crate::writer::ChannelDescription;
use crate::{BagError, BagOptions, BagSummary, BagWriter, ChannelId, Compression, Packing, Sample};

/// Losses that the new bag itself lists; all of them are in the report.
const MAX_DESCRIBED: usize = 100;

/// A new bag and what is known of the file whose content goes into it.
pub struct Sink {
    folder: PathBuf,
    writer: Option<BagWriter>,
    /// How the new bag is compressed: as the first chunk that was met.
    pub compression: Option<Compression>,
    custom_data: BTreeMap<String, String>,
    channels: ChannelAccumulator<'static>,
    /// The summary of the current file, for definitions that are lost elsewhere.
    fallback: Option<Summary>,
    /// The channels that were used so far.
    ids: HashMap<u16, ChannelId>,
    /// Messages of the current file, by channel.
    counts: BTreeMap<u16, u64>,
    /// Attachments of all files.
    pub n_attachments: u64,
    /// Metadata records of all files, rosbag2's own aside.
    pub n_metadata: u64,
}

impl Sink {
    pub fn new(folder: PathBuf) -> Self {
        Self {
            folder,
            writer: None,
            compression: None,
            custom_data: BTreeMap::new(),
            channels: ChannelAccumulator::default(),
            fallback: None,
            ids: HashMap::new(),
            counts: BTreeMap::new(),
            n_attachments: 0,
            n_metadata: 0,
        }
    }

    /// Forgets the definitions of the file before: each file numbers its own.
    pub fn next_file(&mut self, fallback: Option<Summary>) {
        self.channels = ChannelAccumulator::default();
        self.ids.clear();
        self.counts.clear();
        self.fallback = fallback;
    }

    /// How many chunks the current file's summary counts.
    pub fn n_chunks(&self) -> Option<u32> {
        Some(self.fallback.as_ref()?.stats.as_ref()?.chunk_count)
    }

    /// Whether the current file has defined a channel so far.
    pub fn has_channels(&self) -> bool {
        !self.ids.is_empty()
    }

    /// Keeps pairs for `metadata.yaml`.
    pub fn add_custom_data(&mut self, pairs: BTreeMap<String, String>) {
        self.custom_data.extend(pairs);
    }

    /// Takes a definition; of two with one number the first one counts.
    pub fn define(&mut self, record: Record) -> Result<(), BagError> {
        match record {
            Record::Schema { header, data } => {
                self.channels.add_schema_from_slice(header, &data).ok();
            }
            Record::Channel(channel) => {
                let id = channel.id;
                self.channels.add_channel(channel).ok();
                // A topic without messages is saved, too.
                self.id_of(id)?;
            }
            _ => {}
        }
        Ok(())
    }

    /// The topic of a channel; messages of others cannot be saved.
    pub fn topic(&self, channel_id: u16) -> Option<String> {
        self.channel(channel_id).map(|channel| channel.topic.clone())
    }

    /// Takes a message; `true` if it is in the new bag. One without a definition is not, nor is one
    /// that does not unpack.
    pub fn message(&mut self, header: &MessageHeader, data: Cow<[u8]>) -> Result<bool, BagError> {
        let Some(channel) = self.id_of(header.channel_id)? else { return Ok(false) };
        let Ok(data) = plain(data.into_owned()) else { return Ok(false) };
        let sample = Sample {
            log_time_ns: header.log_time,
            publish_time_ns: header.publish_time,
            sequence: header.sequence,
            data: &data,
        };
        self.writer()?.write(channel, sample)?;
        *self.counts.entry(header.channel_id).or_default() += 1;
        Ok(true)
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

    pub fn attach(&mut self, header: AttachmentHeader, data: Cow<[u8]>) -> Result<(), BagError> {
        self.n_attachments += 1;
        let AttachmentHeader { log_time, create_time, name, media_type } = header;
        let attachment = mcap::Attachment { log_time, create_time, name, media_type, data };
        self.writer()?.copy_attachment(&attachment)
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

    /// Messages in the new bag so far, by topic.
    pub fn n_messages_of_topic(&self) -> BTreeMap<String, u64> {
        self.writer.as_ref().map(BagWriter::n_messages_of_topic).unwrap_or_default()
    }

    /// Writes into the new bag, if there is one, what is missing in it.
    pub fn describe(&mut self, losses: &[Loss], lost: &LostMessages) -> Result<(), BagError> {
        let Some(writer) = &mut self.writer else { return Ok(()) };
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
        writer.metadata(recovery::RECORD, pairs)
    }

    /// Closes the new bag, if there was something to put into it.
    pub fn finish(self) -> Result<Option<BagSummary>, BagError> {
        let Some(mut writer) = self.writer else { return Ok(None) };
        writer.add_custom_data(self.custom_data);
        writer.finish().map(Some)
    }

    /// Makes the new bag, though there may be nothing to put into it.
    pub fn keep_empty(&mut self) -> Result<(), BagError> {
        self.writer().map(drop)
    }

    fn writer(&mut self) -> Result<&mut BagWriter, BagError> {
        if self.writer.is_none() {
            // What is in the old bag is safe.
            let compression = self.compression.unwrap_or_default();
            let packing = Packing { compression, flush_period_ns: None, ..Packing::default() };
            let options = BagOptions { custom_data: self.custom_data.clone() };
            self.writer = Some(BagWriter::create_packed(&self.folder, options, packing)?);
        }
        Ok(self.writer.as_mut().expect("it was just made"))
    }

    /// The channel in the new bag; `None` if its definition or that of its type is lost.
    fn id_of(&mut self, channel_id: u16) -> Result<Option<ChannelId>, BagError> {
        if let Some(id) = self.ids.get(&channel_id) {
            return Ok(Some(*id));
        }
        let Some(channel) = self.channel(channel_id) else { return Ok(None) };
        let id = self.writer()?.add_channel(ChannelDescription::from(&*channel))?;
        self.ids.insert(channel_id, id);
        Ok(Some(id))
    }

    /// A channel of the current file.
    fn channel(&self, channel_id: u16) -> Option<Arc<Channel<'static>>> {
        let fallback = || self.fallback.as_ref()?.channels.get(&channel_id).cloned();
        self.channels.get(channel_id).or_else(fallback)
    }
}
