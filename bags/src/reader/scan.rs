//! What is learned of a file by reading it through.

use std::collections::{BTreeMap, BTreeSet};
use std::io::{Read, Seek, SeekFrom};

use mcap::read::ChannelAccumulator;
use mcap::records::{self, Record, op};
use mcap::sans_io::{LinearReadEvent, LinearReader, LinearReaderOptions};
use mcap::{McapError, McapResult};

use super::Attachment;
use super::source::read_some;
use crate::recover::frame::{self, ChunkHead};

/// What is learned by reading a file through.
#[derive(Default)]
pub struct Scan {
    /// The channels by their numbers.
    pub channels: ChannelAccumulator<'static>,
    /// Messages by channel.
    pub counts: BTreeMap<u16, u64>,
    /// In order.
    pub attachments: Vec<Attachment>,
    /// In order.
    pub metadata: Vec<records::Metadata>,
    /// First and last log time, in nanoseconds.
    pub bounds_ns: Option<(u64, u64)>,
}

/// How the chunks of a file are compressed, as far as they go; nothing else of it is read.
pub fn compressions(mut file: impl Read + Seek) -> BTreeSet<String> {
    let mut found = BTreeSet::new();
    let mut at = mcap::MAGIC.len() as u64;
    let mut head = [0; frame::HEAD_BYTES + frame::MAX_CHUNK_HEAD_BYTES];
    while file.seek(SeekFrom::Start(at)).is_ok() && file.read_exact(&mut head).is_ok() {
        let Some((opcode, length)) = frame::head(&head) else { break };
        if opcode == op::CHUNK {
            let chunk = ChunkHead::parse(&head[frame::HEAD_BYTES..]);
            found.extend(chunk.map(|chunk| chunk.compression));
        }
        let Some(next) = length.checked_add(frame::HEAD_BYTES as u64 + at) else { break };
        at = next;
    }
    found
}

impl Scan {
    /// Reads to the end, or to the error that comes before it.
    pub fn run(&mut self, mut source: impl Read, options: LinearReaderOptions) -> McapResult<()> {
        let mut reader = LinearReader::new_with_options(options);
        while let Some(event) = reader.next_event() {
            match event? {
                LinearReadEvent::ReadRequest(n_bytes) => {
                    let n_read = read_some(&mut source, reader.insert(n_bytes))?;
                    reader.notify_read(n_read);
                }
                LinearReadEvent::Record { data, opcode } => {
                    self.take(mcap::parse_record(opcode, data)?)?;
                }
            }
        }
        Ok(())
    }

    fn take(&mut self, record: Record) -> McapResult<()> {
        match record {
            Record::Schema { header, data } => self.channels.add_schema_from_slice(header, &data),
            Record::Channel(channel) => {
                self.counts.entry(channel.id).or_default();
                self.channels.add_channel(channel)
            }
            Record::Message { header, .. } => {
                let count = self.counts.get_mut(&header.channel_id);
                let unknown = McapError::UnknownChannel(header.sequence, header.channel_id);
                *count.ok_or(unknown)? += 1;
                let time_ns = header.log_time;
                let (first_ns, last_ns) = self.bounds_ns.unwrap_or((time_ns, time_ns));
                self.bounds_ns = Some((first_ns.min(time_ns), last_ns.max(time_ns)));
                Ok(())
            }
            Record::Attachment { header, data, .. } => {
                let records::AttachmentHeader { name, media_type, .. } = header;
                self.attachments.push(Attachment { name, media_type, data: data.into_owned() });
                Ok(())
            }
            Record::Metadata(record) => {
                self.metadata.push(record);
                Ok(())
            }
            _ => Ok(()),
        }
    }
}
