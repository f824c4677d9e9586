//! One `.mcap` file that is being written.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::{BufWriter, IntoInnerError};
use std::path::{Path, PathBuf};

use mcap::Writer;
use mcap::records::{MessageHeader, Metadata};

use super::channel::ChannelDescription;
use super::{Packing, Sample};
use crate::BagError;
use crate::metadata::FileInformation;

/// What the system is given at once.
const BUFFER_BYTES: usize = 64 << 10;

/// One `.mcap` file that is being written.
pub struct Part {
    path: PathBuf,
    file_name: String,
    writer: Writer<BufWriter<File>>,
    /// The same file, to ask how long it is.
    file: File,
    n_messages: u64,
    bounds_ns: Option<(u64, u64)>,
}

impl Part {
    /// Starts a file that must not exist.
    pub fn create(folder: &Path, file_name: String, packing: &Packing) -> Result<Self, BagError> {
        let path = folder.join(&file_name);
        let cannot = || BagError::io("create", &path);
        let file = File::create_new(&path).map_err(cannot())?;
        let written = file.try_clone().map_err(cannot())?;
        let writer = packing
            .write_options()
            .create(BufWriter::with_capacity(BUFFER_BYTES, written))
            .map_err(|source| BagError::Write { path: path.clone(), source })?;
        Ok(Self { path, file_name, writer, file, n_messages: 0, bounds_ns: None })
    }

    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Its entry in `metadata.yaml`.
    pub fn information(&self) -> FileInformation {
        FileInformation::new(&self.file_name, self.bounds_ns, self.n_messages)
    }

    /// Bytes that the system was given so far.
    pub fn n_bytes(&self) -> u64 {
        self.file.metadata().map_or(0, |metadata| metadata.len())
    }

    /// Whether a message at this time, in nanoseconds, belongs into the next file.
    pub fn is_full(&self, packing: &Packing, time_ns: u64) -> bool {
        let Some((first_ns, _)) = self.bounds_ns else { return false };
        let too_large = packing.max_file_bytes.is_some_and(|most| self.n_bytes() >= most);
        let too_long = packing
            .max_file_duration_ns
            .is_some_and(|most_ns| time_ns.saturating_sub(first_ns) >= most_ns);
        too_large || too_long
    }

    /// Adds a channel and gives the number that the file has for it.
    pub fn add_channel(&mut self, channel: &ChannelDescription) -> Result<u16, BagError> {
        let ChannelDescription { type_name, schema_encoding, schema, .. } = channel;
        let schema_id = if type_name.is_empty() {
            Ok(0)
        } else {
            self.writer.add_schema(type_name, schema_encoding, schema)
        };
        let added = schema_id.and_then(|schema_id| {
            let ChannelDescription { topic, message_encoding, metadata, .. } = channel;
            self.writer.add_channel(schema_id, topic, message_encoding, metadata)
        });
        added.map_err(|source| self.error(source))
    }

    /// Records a message.
    pub fn write(&mut self, channel_id: u16, sample: &Sample) -> Result<(), BagError> {
        let time_ns = sample.log_time_ns;
        let header = MessageHeader {
            channel_id,
            sequence: sample.sequence,
            log_time: time_ns,
            publish_time: sample.publish_time_ns,
        };
        let written = self.writer.write_to_known_channel(&header, sample.data);
        written.map_err(|source| self.error(source))?;
        self.n_messages += 1;
        let (first_ns, last_ns) = self.bounds_ns.unwrap_or((time_ns, time_ns));
        self.bounds_ns = Some((first_ns.min(time_ns), last_ns.max(time_ns)));
        Ok(())
    }

    /// Records a file.
    pub fn attach(&mut self, attachment: &mcap::Attachment) -> Result<(), BagError> {
        self.writer.attach(attachment).map_err(|source| self.error(source))
    }

    /// Records pairs of strings.
    pub fn metadata(
        &mut self,
        name: &str,
        metadata: BTreeMap<String, String>,
    ) -> Result<(), BagError> {
        let record = Metadata { name: name.to_owned(), metadata };
        self.writer.write_metadata(&record).map_err(|source| self.error(source))
    }

    /// Hands everything so far to the system.
    pub fn flush(&mut self) -> Result<(), BagError> {
        self.writer.flush().map_err(|source| self.error(source))
    }

    /// Ends the file, and hands all of it to the system; it is not on the disk yet.
    pub fn finish(mut self) -> Result<(), BagError> {
        self.writer.finish().map_err(|source| self.error(source))?;
        let Self { path, writer, .. } = self;
        let written = writer.into_inner().into_inner().map_err(IntoInnerError::into_error);
        written.map(drop).map_err(BagError::io("close", &path))
    }

    fn error(&self, source: mcap::McapError) -> BagError {
        BagError::Write { path: self.path.clone(), source }
    }
}
