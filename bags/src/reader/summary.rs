//! The summary section of a file: what is in the file, and where.

use std::fs::File;
use std::io::{Read, Seek, SeekFrom};

use mcap::records::{Record, op};
use mcap::sans_io::{SummaryReadEvent, SummaryReader, SummaryReaderOptions};
use mcap::{McapError, McapResult, Summary};

use super::source::read_some;
use crate::records::{self, HEAD_BYTES};

/// The footer at the end of a file: start of the summary, start of its offsets, checksum.
const FOOTER_BYTES: usize = HEAD_BYTES + 8 + 8 + 4;

/// The checksum at the end of the footer is over all of the section before it.
const CHECKSUM_BYTES: usize = 4;

/// No summary section is longer than this, but one whose start is damaged may seem to be.
const MAX_BYTES: u64 = 1 << 30;

/// Reads the summary section; `None` if the file has none, or one that fails its checksum or does not
/// read: names of topics that are wrong would be worse than none.
pub fn read(file: &mut File) -> Option<Summary> {
    if !is_sound(file).ok()? {
        return None;
    }
    read_sound(file).ok().flatten()
}

fn read_sound(file: &mut File) -> McapResult<Option<Summary>> {
    let options = SummaryReaderOptions::default().with_file_size(file.metadata()?.len());
    let mut reader = SummaryReader::new_with_options(options);
    file.rewind()?;
    while let Some(event) = reader.next_event() {
        match event? {
            SummaryReadEvent::SeekRequest(to) => reader.notify_seeked(file.seek(to)?),
            SummaryReadEvent::ReadRequest(n_bytes) => {
                let n_read = read_some(file, reader.insert(n_bytes))?;
                reader.notify_read(n_read);
            }
        }
    }
    Ok(reader.finish())
}

/// Whether there is a section, as its checksum has it, and all records in it may be there: `mcap`
/// would unpack chunks in it, and panics in a debug build at a damaged one.
fn is_sound(file: &mut File) -> McapResult<bool> {
    let tail_bytes = (FOOTER_BYTES + mcap::MAGIC.len()) as u64;
    let footer_at = file.metadata()?.len().checked_sub(tail_bytes);
    let footer_at = footer_at.ok_or(McapError::UnexpectedEof)?;
    file.seek(SeekFrom::Start(footer_at))?;
    let mut footer = [0; FOOTER_BYTES];
    file.read_exact(&mut footer)?;
    let Record::Footer(fields) = records::parse(op::FOOTER, &footer[HEAD_BYTES..])? else {
        return Ok(false);
    };
    let n_bytes = footer_at.checked_sub(fields.summary_start);
    let Some(n_bytes) = n_bytes.filter(|n_bytes| *n_bytes <= MAX_BYTES) else { return Ok(false) };
    if fields.summary_start == 0 {
        return Ok(false);
    }
    file.seek(SeekFrom::Start(fields.summary_start))?;
    let mut section = Vec::new();
    file.take(n_bytes).read_to_end(&mut section)?;
    let mut rest = &section[..];
    while let Some((opcode, body)) = records::first(rest) {
        // Room would be made for as much as a field claims to have.
        if opcode == op::CHUNK || records::behind_fields(opcode, body).is_none() {
            return Ok(false);
        }
        rest = &rest[HEAD_BYTES + body.len()..];
    }
    section.extend_from_slice(&footer[..FOOTER_BYTES - CHECKSUM_BYTES]);
    Ok(fields.summary_crc == 0 || crc32fast::hash(&section) == fields.summary_crc)
}
