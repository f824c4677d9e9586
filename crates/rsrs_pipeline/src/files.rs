//! Files, named where they cannot be read or written.

pub mod lock_file;

use std::path::Path;

use anyhow::Context;

/// Writes one file.
///
/// # Errors
///
/// If the file cannot be written.
pub fn write_file(path: &Path, bytes: &[u8]) -> anyhow::Result<()> {
    std::fs::write(path, bytes).with_context(|| format!("cannot write {}", path.display()))
}

/// Reads one file of text.
///
/// # Errors
///
/// If the file cannot be read or is no text.
pub fn read_text(path: &Path) -> anyhow::Result<String> {
    std::fs::read_to_string(path).with_context(|| format!("cannot read {}", path.display()))
}
