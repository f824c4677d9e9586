//! Folders of results and files that steps read: a person's, or one that goes with the last object that
//! needs it.

use std::path::PathBuf;

use tempfile::TempDir;

use crate::error::refused;

/// A folder of results, or a file that a step reads.
pub struct Folder {
    /// Where it is, the folder or the file.
    pub path: PathBuf,
    /// What removes it, where it is nobody's.
    _temporary: Option<TempDir>,
}

impl Folder {
    /// A person's.
    pub fn kept(path: PathBuf) -> Self {
        Self { path, _temporary: None }
    }

    /// One of this name that nobody keeps; it is not made.
    pub fn temporary(name: &str) -> pyo3::PyResult<Self> {
        let temporary = TempDir::with_prefix("rsrs_").map_err(refused)?;
        Ok(Self { path: temporary.path().join(name), _temporary: Some(temporary) })
    }

    /// A file of this name and text, likewise.
    pub fn holding(name: &str, text: &str) -> pyo3::PyResult<Self> {
        let file = Self::temporary(name)?;
        std::fs::write(&file.path, text).map_err(refused)?;
        Ok(file)
    }
}
