//! The enclave of a process.

use std::path::{Path, PathBuf};

/// A folder with which a session can be secured. It was looked at, and nothing was wrong with it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Enclave {
    name: String,
    folder: PathBuf,
}

impl Enclave {
    pub(super) fn new(name: String, folder: PathBuf) -> Self {
        Self { name, folder }
    }

    /// Its name in ROS 2, such as `/robot_3`.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Where its files are.
    pub fn folder(&self) -> &Path {
        &self.folder
    }
}
