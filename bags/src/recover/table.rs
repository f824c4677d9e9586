//! What a file's own table of contents says, if it can be trusted.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::{self, Read, Seek, SeekFrom};

use super::frame::HEAD_BYTES;
use crate::reader::{Table, read_some};

/// The footer: start of the summary, start of its offsets, checksum.
const FOOTER_BYTES: usize = 8 + 8 + 4;

/// What stands between the checksum of the summary and the end of the file.
const BEHIND_SUMMARY: u64 = 4 + mcap::MAGIC.len() as u64;

/// The file's table of contents; `None` if there is none, or if it does not read or fails its
/// checksum: names of topics that are wrong would be worse than none.
pub fn read(file: &mut File) -> Option<Table> {
    let table = Table::read(file)?;
    // Definitions are all that is asked of it, and the list of chunks may be long.
    is_sound(file).ok()?.then_some(table.without_chunks())
}

fn is_sound(file: &mut File) -> io::Result<bool> {
    let tail_bytes = HEAD_BYTES + FOOTER_BYTES + mcap::MAGIC.len();
    let n_bytes = file.seek(SeekFrom::End(0))?;
    let Some(footer_at) = n_bytes.checked_sub(tail_bytes as u64) else { return Ok(false) };
    file.seek(SeekFrom::Start(footer_at + HEAD_BYTES as u64))?;
    let mut footer = [0; FOOTER_BYTES];
    file.read_exact(&mut footer)?;
    let (summary_at, rest) = footer.split_first_chunk().expect("it is 20 bytes long");
    let summary_at = u64::from_le_bytes(*summary_at);
    let saved = u32::from_le_bytes(*rest.last_chunk().expect("12 bytes are left"));
    // Zero means that the recorder made no checksum.
    if saved == 0 {
        return Ok(true);
    }
    let Some(length) = (n_bytes - BEHIND_SUMMARY).checked_sub(summary_at) else {
        return Ok(false);
    };
    file.seek(SeekFrom::Start(summary_at))?;
    let mut summary = file.take(length);
    let mut hasher = crc32fast::Hasher::new();
    let mut buffer = vec![0; 64 << 10];
    loop {
        match read_some(&mut summary, &mut buffer)? {
            0 => return Ok(hasher.finalize() == saved),
            n_read => hasher.update(&buffer[..n_read]),
        }
    }
}

/// Messages by channel, as the recorder counted them; `None` if its counts disagree.
pub fn counted(table: &Table) -> Option<BTreeMap<u16, u64>> {
    let stats = table.stats.as_ref()?;
    let counts = &stats.channel_message_counts;
    let total = counts.values().try_fold(0_u64, |sum, count| sum.checked_add(*count));
    let is_known = counts.keys().all(|id| table.channels.contains_key(id));
    (total == Some(stats.message_count) && is_known).then(|| counts.clone())
}
