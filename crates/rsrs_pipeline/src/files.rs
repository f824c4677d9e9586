//! Files, named where they cannot be read or written.

pub mod lock_file;

use std::path::Path;

use anyhow::Context;

use crate::wording::size;

/// Writes one file.
///
/// # Errors
///
/// If the file cannot be written.
pub fn write_file(path: &Path, bytes: &[u8]) -> anyhow::Result<()> {
    write_draft(path, bytes)?;
    wrote(path);
    Ok(())
}

/// Writes one file that is still to take its place, so that it is not logged.
///
/// # Errors
///
/// If the file cannot be written.
pub fn write_draft(path: &Path, bytes: &[u8]) -> anyhow::Result<()> {
    std::fs::write(path, bytes).with_context(|| format!("cannot write {}", path.display()))
}

/// Reads one file of text.
///
/// # Errors
///
/// If the file cannot be read or is no text.
pub fn read_text(path: &Path) -> anyhow::Result<String> {
    let text =
        std::fs::read_to_string(path).with_context(|| format!("cannot read {}", path.display()))?;
    log::info!("read {}: {}", path.display(), size(text.len() as u64));
    Ok(text)
}

/// Logs that a file was written, with its size.
pub fn wrote(path: &Path) {
    let n_bytes = path.metadata().map_or(0, |metadata| metadata.len());
    log::info!("wrote {}: {}", path.display(), size(n_bytes));
}
