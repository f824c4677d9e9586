//! `metadata.yaml` of any recorder, as it is read.

use std::collections::BTreeMap;
use std::io::ErrorKind;
use std::path::Path;

use rsrs_core::document;
use serde::Deserialize;

use super::{METADATA, RECORD_KEY, TopicWithCount};
use crate::BagError;

/// What the reader needs of a bag's table of contents; versions 4 to 9 have all of it but for the
/// fields that have a default.
#[derive(Clone, Debug, Deserialize)]
pub struct Contents {
    /// The layout, 9 at most so far.
    pub version: Option<u32>,
    /// `mcap` or `sqlite3`.
    #[serde(default)]
    pub storage_identifier: String,
    /// The files of the bag, in order, relative to the folder.
    pub relative_file_paths: Vec<String>,
    /// What the recorder counted.
    #[serde(default)]
    pub topics_with_message_count: Vec<TopicWithCount>,
    /// `file`, `message`, or none; since Jazzy in small letters.
    #[serde(default)]
    pub compression_mode: Option<String>,
    /// Pairs that the recorder was given; since version 6.
    #[serde(default)]
    pub custom_data: Option<BTreeMap<String, String>>,
    /// The distribution of the recorder; since version 8.
    #[serde(default)]
    pub ros_distro: Option<String>,
}

impl Contents {
    /// Whether rosbag2 compressed single messages.
    pub fn compresses_messages(&self) -> bool {
        let mode = self.compression_mode.as_deref().unwrap_or_default();
        mode.eq_ignore_ascii_case("message")
    }
}

#[derive(Deserialize)]
struct ReadDocument {
    rosbag2_bagfile_information: Contents,
}

/// Reads a folder's `metadata.yaml`, if there is one.
pub fn read(folder: &Path) -> Result<Option<Contents>, BagError> {
    let path = folder.join(METADATA);
    let text = match rsrs_files::read_text(&path) {
        Ok(text) => text,
        Err(error) if error.kind() == ErrorKind::NotFound => return Ok(None),
        Err(source) => return Err(BagError::io("read", &path)(source)),
    };
    match document::parse::<ReadDocument>(&path.display().to_string(), &text) {
        Ok(document) => Ok(Some(document.rosbag2_bagfile_information)),
        Err(source) => Err(BagError::Metadata { path, source: Box::new(source) }),
    }
}

/// The contents that rosbag2 keeps inside an `.mcap` file, if they make sense.
pub fn read_record(pairs: &BTreeMap<String, String>) -> Option<Contents> {
    serde_saphyr::from_str(pairs.get(RECORD_KEY)?).ok()
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;

    #[test]
    fn a_file_without_the_list_of_files_is_refused() {
        let folder = tempfile::tempdir().unwrap();
        fs::write(folder.path().join(METADATA), "rosbag2_bagfile_information:\n  version: 9\n")
            .unwrap();

        let error = read(folder.path()).unwrap_err();

        assert!(matches!(error, BagError::Metadata { .. }), "{error}");
    }
}
