//! Whether a file is as it was written, by the checksums in it.

use std::io::{self, Read};

use mcap::McapResult;
use mcap::records::{Record, op};
use mcap::sans_io::{LinearReadEvent, LinearReader, LinearReaderOptions};

use super::source::read_some;

/// Opcode and length in front of each record.
pub const HEAD_BYTES: u64 = 9;

/// What a checksum says of a part of a file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Part {
    /// There is a checksum, and the bytes agree with it.
    Sound,
    /// Its writer has left the checksum out: MCAP has a zero for that.
    WithoutChecksum,
    /// It ends early, or is not what was written.
    Damaged(Fault),
}

impl Part {
    /// Whether it is not as it was written.
    pub fn is_damaged(&self) -> bool {
        matches!(self, Self::Damaged(_))
    }
}

/// Where a file is not as it was written, and how that shows.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Fault {
    /// The record, by its place in the file.
    pub at_byte: u64,
    /// What is wrong with it.
    pub reason: String,
    /// Whether the file ends there, as that of a recorder that was killed.
    pub is_end: bool,
}

/// What the checksums of a file say.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Checksums {
    /// Everything that was recorded.
    pub data: Part,
    /// The summary section behind it.
    pub summary: Part,
}

impl Checksums {
    /// Reads a file through, without looking into its chunks.
    ///
    /// # Errors
    ///
    /// What the system says, where it cannot read the file.
    pub fn of(mut source: impl Read, options: LinearReaderOptions) -> io::Result<Self> {
        let options = options
            .with_emit_chunks(true)
            .with_validate_data_section_crc(true)
            .with_validate_summary_section_crc(true);
        let mut reader = LinearReader::new_with_options(options);
        let mut at_byte = mcap::MAGIC.len() as u64;
        // Until a record says otherwise: a file that ends before is damaged.
        let (mut data, mut summary) = (None, None);
        while let Some(event) = reader.next_event() {
            let fault = match event {
                Ok(LinearReadEvent::ReadRequest(n_bytes)) => {
                    match feed(&mut reader, &mut source, n_bytes)? {
                        Ok(()) => continue,
                        Err(error) => Fault::new(at_byte, &error),
                    }
                }
                Ok(LinearReadEvent::Record { data: body, opcode }) => {
                    let is_last = [op::DATA_END, op::FOOTER].contains(&opcode);
                    match is_last.then(|| mcap::parse_record(opcode, body)) {
                        Some(Ok(Record::DataEnd(end))) => data = Some(part(end.data_section_crc)),
                        Some(Ok(Record::Footer(end))) => summary = Some(part(end.summary_crc)),
                        _ => {}
                    }
                    at_byte += HEAD_BYTES + body.len() as u64;
                    continue;
                }
                Err(error) => Fault::new(at_byte, &error),
            };
            return Ok(match data {
                None => Self { data: Part::Damaged(fault.clone()), summary: Part::Damaged(fault) },
                Some(data) => Self { data, summary: Part::Damaged(fault) },
            });
        }
        let missing = || {
            let reason = "the record that ends its data is missing".to_owned();
            Part::Damaged(Fault { at_byte, reason, is_end: false })
        };
        Ok(Self { data: data.unwrap_or_else(missing), summary: summary.unwrap_or_else(missing) })
    }
}

impl Fault {
    /// What a reader met.
    pub fn new(at_byte: u64, error: &mcap::McapError) -> Self {
        let is_end = match error {
            mcap::McapError::UnexpectedEof => true,
            mcap::McapError::Io(error) => error.kind() == io::ErrorKind::UnexpectedEof,
            _ => false,
        };
        Self { at_byte, reason: reason(error), is_end }
    }
}

/// What is wrong, with what the system says of it.
pub fn reason(error: &mcap::McapError) -> String {
    match error {
        mcap::McapError::Io(cause) => cause.to_string(),
        error => error.to_string(),
    }
}

/// Gives a reader the bytes that it asks for.
///
/// # Returns
///
/// What a decompressor makes of them, if it fails.
///
/// # Errors
///
/// What the system says, where it cannot read the file.
pub fn feed(
    reader: &mut LinearReader,
    source: &mut impl Read,
    n_bytes: usize,
) -> io::Result<McapResult<()>> {
    match read_some(source, reader.insert(n_bytes)) {
        Ok(n_read) => {
            reader.notify_read(n_read);
            Ok(Ok(()))
        }
        Err(error) if error.raw_os_error().is_some() => Err(error),
        Err(error) => Ok(Err(error.into())),
    }
}

fn part(checksum: u32) -> Part {
    if checksum == 0 { Part::WithoutChecksum } else { Part::Sound }
}
