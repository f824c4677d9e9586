//! `metadata.yaml`, the table of contents of a bag.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use serde::{Deserialize, Serialize};

use crate::BagError;

/// The name of the file, fixed by rosbag2.
pub const FILE_NAME: &str = "metadata.yaml";

/// The version whose quality of service every ROS 2 since Humble reads.
const VERSION: u32 = 8;

/// The file as a whole.
#[derive(Serialize)]
struct Document<'a> {
    rosbag2_bagfile_information: &'a Information,
}

/// What rosbag2 says of a bag.
#[derive(Clone, Debug, Serialize)]
pub struct Information {
    version: u32,
    storage_identifier: &'static str,
    duration: Duration,
    starting_time: StartingTime,
    message_count: u64,
    topics_with_message_count: Vec<TopicWithCount>,
    compression_format: &'static str,
    compression_mode: &'static str,
    relative_file_paths: Vec<String>,
    files: Vec<FileInformation>,
    custom_data: BTreeMap<String, String>,
    ros_distro: &'static str,
}

#[derive(Clone, Copy, Debug, Serialize)]
struct Duration {
    nanoseconds: u64,
}

#[derive(Clone, Copy, Debug, Serialize)]
struct StartingTime {
    nanoseconds_since_epoch: u64,
}

/// A topic and how often it was heard.
#[derive(Clone, Debug, Serialize)]
pub struct TopicWithCount {
    /// The topic.
    pub topic_metadata: TopicMetadata,
    /// Messages on it.
    pub message_count: u64,
}

/// A topic in the words of rosbag2.
#[derive(Clone, Debug, Serialize)]
pub struct TopicMetadata {
    /// Its full name.
    pub name: String,
    /// Its type, such as `std_msgs/msg/Bool`.
    pub r#type: String,
    /// Always `cdr`.
    pub serialization_format: &'static str,
    /// YAML within YAML.
    pub offered_qos_profiles: String,
    /// RIHS01.
    pub type_description_hash: String,
}

#[derive(Clone, Debug, Serialize)]
struct FileInformation {
    path: String,
    starting_time: StartingTime,
    duration: Duration,
    message_count: u64,
}

impl Information {
    /// Describes a bag of one file.
    ///
    /// # Arguments
    ///
    /// * `file_name` — of the `.mcap` file.
    /// * `bounds_ns` — first and last log time, in nanoseconds; `None` for a bag without messages.
    pub fn new(
        file_name: &str,
        bounds_ns: Option<(u64, u64)>,
        topics: Vec<TopicWithCount>,
        custom_data: BTreeMap<String, String>,
    ) -> Self {
        let (first_ns, last_ns) = bounds_ns.unwrap_or((0, 0));
        let duration = Duration { nanoseconds: last_ns - first_ns };
        let starting_time = StartingTime { nanoseconds_since_epoch: first_ns };
        let message_count = topics.iter().map(|topic| topic.message_count).sum();
        Self {
            version: VERSION,
            storage_identifier: "mcap",
            duration,
            starting_time,
            message_count,
            topics_with_message_count: topics,
            // Chunks are compressed, which is MCAP's own business; these two mean whole files.
            compression_format: "",
            compression_mode: "",
            relative_file_paths: vec![file_name.to_owned()],
            files: vec![FileInformation {
                path: file_name.to_owned(),
                starting_time,
                duration,
                message_count,
            }],
            custom_data,
            ros_distro: "jazzy",
        }
    }

    /// The YAML that rosbag2 also keeps inside the `.mcap` file.
    pub fn to_yaml(&self) -> String {
        serde_saphyr::to_string(self).expect("strings and numbers have a YAML form")
    }

    /// Writes `metadata.yaml` into the folder, whole or not at all.
    ///
    /// # Errors
    ///
    /// [`BagError::Io`].
    pub fn write_into(&self, folder: &Path) -> Result<(), BagError> {
        let document = Document { rosbag2_bagfile_information: self };
        let yaml = serde_saphyr::to_string(&document).expect("it has a YAML form");
        let temporary = folder.join(".metadata.yaml.part");
        let path = folder.join(FILE_NAME);
        fs::write(&temporary, yaml)
            .and_then(|()| fs::rename(&temporary, &path))
            .map_err(|source| BagError::Io { action: "write", path, source })
    }
}

/// What the reader needs of a bag's `metadata.yaml`, of any version.
#[derive(Debug, Deserialize)]
pub struct Contents {
    /// The files of the bag, in order, relative to the folder.
    pub relative_file_paths: Vec<String>,
    /// Pairs that the recorder was given.
    pub custom_data: Option<BTreeMap<String, String>>,
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
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => return Ok(None),
        Err(source) => return Err(BagError::Io { action: "read", path, source }),
    };
    match serde_saphyr::from_str::<ReadDocument>(&text) {
        Ok(document) => Ok(Some(document.rosbag2_bagfile_information)),
        Err(source) => Err(BagError::Metadata { path, source: Box::new(source) }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_written_reads_back_with_awkward_strings() {
        let folder = tempfile::tempdir().unwrap();
        let awkward = BTreeMap::from([
            ("seed".to_owned(), "42".to_owned()),
            ("note: \"quoted\"".to_owned(), "two\nlines # no comment".to_owned()),
        ]);
        let information = Information::new("run_0.mcap", Some((5, 9)), Vec::new(), awkward.clone());

        information.write_into(folder.path()).unwrap();

        let contents = read(folder.path()).unwrap().unwrap();
        assert_eq!(contents.relative_file_paths, ["run_0.mcap"]);
        assert_eq!(contents.custom_data, Some(awkward));
    }

    #[test]
    fn the_file_of_a_real_recorder_reads() {
        let folder = tempfile::tempdir().unwrap();
        let text = "\
rosbag2_bagfile_information:
  version: 9
  storage_identifier: mcap
  relative_file_paths:
    - talk_0.mcap
    - talk_1.mcap
  custom_data: ~
  ros_distro: jazzy
";
        fs::write(folder.path().join(FILE_NAME), text).unwrap();

        let contents = read(folder.path()).unwrap().unwrap();

        assert_eq!(contents.relative_file_paths, ["talk_0.mcap", "talk_1.mcap"]);
        assert_eq!(contents.custom_data, None);
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
