//! `metadata.yaml` of any recorder, as it is read.

use std::collections::BTreeMap;
use std::fs;
use std::io::ErrorKind;
use std::path::Path;

use rsrs_core::document;
use serde::Deserialize;

use super::{FILE_NAME, RECORD_KEY};
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
    pub topics_with_message_count: Vec<CountedTopic>,
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

/// A topic and how often the recorder received it.
#[derive(Clone, Debug, Deserialize)]
pub struct CountedTopic {
    /// The topic.
    pub topic_metadata: NamedTopic,
    /// Messages on it.
    pub message_count: u64,
}

/// What matters of a topic.
#[derive(Clone, Debug, Deserialize)]
pub struct NamedTopic {
    /// Its full name.
    pub name: String,
}

#[derive(Deserialize)]
struct ReadDocument {
    rosbag2_bagfile_information: Contents,
}

/// Reads a folder's `metadata.yaml`.
///
/// # Returns
///
/// `None` if there is none.
///
/// # Errors
///
/// [`BagError::Io`] and [`BagError::Metadata`].
pub fn read(folder: &Path) -> Result<Option<Contents>, BagError> {
    let path = folder.join(FILE_NAME);
    let text = match fs::read_to_string(&path) {
        Ok(text) => text,
        Err(error) if error.kind() == ErrorKind::NotFound => return Ok(None),
        Err(source) => return Err(BagError::Io { action: "read", path, source }),
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
    use super::*;

    /// A table of contents as some version of rosbag2 writes it.
    fn of_version(version: u32) -> String {
        let optional = [
            (6, "  custom_data: ~\n"),
            (8, "  ros_distro: jazzy\n"),
            (5, "  files:\n    - path: talk_0.mcap\n      message_count: 3\n"),
        ];
        let qos = if version < 9 { "\"- history: 1\\n  depth: 10\"" } else { "[]" };
        let hash = if version < 7 { "" } else { "        type_description_hash: RIHS01_00\n" };
        let mut text = format!(
            "rosbag2_bagfile_information:
  version: {version}
  storage_identifier: mcap
  duration:
    nanoseconds: 5
  starting_time:
    nanoseconds_since_epoch: 1
  message_count: 3
  topics_with_message_count:
    - topic_metadata:
        name: /chatter
        type: std_msgs/msg/String
        serialization_format: cdr
        offered_qos_profiles: {qos}
{hash}      message_count: 3
  compression_format: \"\"
  compression_mode: \"\"
  relative_file_paths:
    - talk_0.mcap
    - talk_1.mcap
"
        );
        for (since, field) in optional {
            if version >= since {
                text.push_str(field);
            }
        }
        text
    }

    #[test]
    fn every_version_from_4_to_9_reads() {
        let folder = tempfile::tempdir().unwrap();
        for version in 4..=9 {
            fs::write(folder.path().join(FILE_NAME), of_version(version)).unwrap();

            let contents = read(folder.path()).unwrap().unwrap();

            assert_eq!(contents.version, Some(version));
            assert_eq!(contents.relative_file_paths, ["talk_0.mcap", "talk_1.mcap"]);
            let counted = &contents.topics_with_message_count[0];
            assert_eq!((&*counted.topic_metadata.name, counted.message_count), ("/chatter", 3));
            assert_eq!(contents.custom_data, None);
            assert_eq!(contents.ros_distro.is_some(), version >= 8);
        }
    }

    #[test]
    fn a_file_without_the_list_of_files_is_refused() {
        let folder = tempfile::tempdir().unwrap();
        fs::write(folder.path().join(FILE_NAME), "rosbag2_bagfile_information:\n  version: 9\n")
            .unwrap();

        let error = read(folder.path()).unwrap_err();

        assert!(matches!(error, BagError::Metadata { .. }), "{error}");
    }
}
