//! A file that one process at a time holds locked, so that no two do the same work.

use std::fs::{File, TryLockError};
use std::io::ErrorKind;
use std::os::unix::fs::MetadataExt as _;
use std::path::Path;

use anyhow::Context;

/// Locks a file, which is made if it is not there; it stays locked while it is held open. `None` if
/// another process holds it.
pub fn try_lock(path: &Path) -> anyhow::Result<Option<File>> {
    loop {
        let file = File::options()
            .write(true)
            .create(true)
            .truncate(false)
            .open(path)
            .with_context(|| format!("cannot open {}", path.display()))?;
        match file.try_lock() {
            Ok(()) if is_at(&file, path) => return Ok(Some(file)),
            // Its last holder has moved or removed it meanwhile: this lock would protect nothing.
            Ok(()) => {}
            // Some network file systems have no locks; then two processes at work are not noticed.
            Err(TryLockError::Error(error)) if error.kind() == ErrorKind::Unsupported => {
                return Ok(Some(file));
            }
            Err(TryLockError::Error(error)) => {
                return Err(error).with_context(|| format!("cannot lock {}", path.display()));
            }
            Err(TryLockError::WouldBlock) => return Ok(None),
        }
    }
}

/// Whether an open file is the one at a path.
fn is_at(file: &File, path: &Path) -> bool {
    let number = |metadata: std::fs::Metadata| (metadata.dev(), metadata.ino());
    let there = std::fs::metadata(path).map(number);
    let open = file.metadata().map(number);
    matches!((there, open), (Ok(there), Ok(open)) if there == open)
}
