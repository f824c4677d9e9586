//! `metadata.yaml`, the table of contents of a bag, as it is written.

mod contents;

use std::collections::BTreeMap;
use std::fs;
use std::io::Write;
use std::os::unix::fs::PermissionsExt;
use std::path::Path;

use serde::{Deserialize, Serialize};

use crate::BagError;

pub use contents::{Contents, read, read_record};

/// The name of the file, fixed by rosbag2.
pub const METADATA: &str = "metadata.yaml";

/// The record that rosbag2 keeps the same contents in, inside the `.mcap` file.
pub const RECORD: &str = "rosbag2";

/// The key of the contents in that record.
const RECORD_KEY: &str = "serialized_metadata";

/// The version whose quality of service every ROS 2 since Humble reads.
const VERSION: u32 = 8;

/// What rosbag2 writes as the start of a file without messages: its largest time.
const NEVER_NS: u64 = i64::MAX as u64;

/// The file as a whole.
#[derive(Serialize)]
struct Document<'a> {
    rosbag2_bagfile_information: &'a Information,
}

/// `metadata.yaml`: what rosbag2 records about a bag.
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

/// A topic and how often it was received.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct TopicWithCount {
    pub topic_metadata: TopicMetadata,
    pub message_count: u64,
}

/// A topic in the words of rosbag2, of which its name alone is read.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct TopicMetadata {
    pub name: String,
    /// Its type, such as `std_msgs/msg/Bool`.
    #[serde(skip_deserializing)]
    pub r#type: String,
    /// `cdr`, unless another program than ROS wrote it.
    #[serde(skip_deserializing)]
    pub serialization_format: String,
    /// YAML within YAML.
    #[serde(skip_deserializing)]
    pub offered_qos_profiles: String,
    /// RIHS01.
    #[serde(skip_deserializing)]
    pub type_description_hash: String,
}

/// One file of a bag.
#[derive(Clone, Debug, Serialize)]
pub struct FileInformation {
    path: String,
    starting_time: StartingTime,
    duration: Duration,
    message_count: u64,
    #[serde(skip)]
    bounds_ns: Option<(u64, u64)>,
}

impl FileInformation {
    /// Describes a file by its name in the folder, with the first and last log time in it, in
    /// nanoseconds; `None` without messages.
    pub fn new(path: &str, bounds_ns: Option<(u64, u64)>, message_count: u64) -> Self {
        let (starting_time, duration) = span(bounds_ns);
        Self { path: path.to_owned(), starting_time, duration, message_count, bounds_ns }
    }
}

/// Start and length of what lies between two times, in nanoseconds.
fn span(bounds_ns: Option<(u64, u64)>) -> (StartingTime, Duration) {
    let (first_ns, last_ns) = bounds_ns.unwrap_or((NEVER_NS, NEVER_NS));
    let starting_time = StartingTime { nanoseconds_since_epoch: first_ns };
    (starting_time, Duration { nanoseconds: last_ns - first_ns })
}

impl Information {
    /// Describes a bag of these files, in order, and of these topics: none while it is being
    /// opened, as rosbag2 has it.
    pub fn new(
        files: Vec<FileInformation>,
        topics: Vec<TopicWithCount>,
        custom_data: BTreeMap<String, String>,
    ) -> Self {
        let bounds_ns = files.iter().filter_map(|file| file.bounds_ns).reduce(|all, file| {
            let (first_ns, last_ns) = file;
            (all.0.min(first_ns), all.1.max(last_ns))
        });
        let (starting_time, duration) = span(bounds_ns);
        Self {
            version: VERSION,
            storage_identifier: "mcap",
            duration,
            starting_time,
            message_count: topics.iter().map(|topic| topic.message_count).sum(),
            topics_with_message_count: topics,
            // Chunks are compressed, which is MCAP's own business; these two mean whole files.
            compression_format: "",
            compression_mode: "",
            relative_file_paths: files.iter().map(|file| file.path.clone()).collect(),
            files,
            custom_data,
            ros_distro: "jazzy",
        }
    }

    /// The pairs of the record that rosbag2 keeps inside the `.mcap` file.
    pub fn to_record(&self) -> BTreeMap<String, String> {
        let yaml = serde_saphyr::to_string(self).expect("strings and numbers have a YAML form");
        BTreeMap::from([(RECORD_KEY.to_owned(), yaml)])
    }

    /// Writes `metadata.yaml` into the folder, whole or not at all.
    pub fn write_into(&self, folder: &Path) -> Result<(), BagError> {
        let document = Document { rosbag2_bagfile_information: self };
        let yaml = serde_saphyr::to_string(&document).expect("it has a YAML form");
        let path = folder.join(METADATA);
        let write = || {
            let mut draft = tempfile::Builder::new()
                .permissions(fs::Permissions::from_mode(0o666))
                .tempfile_in(folder)?;
            draft.write_all(yaml.as_bytes())?;
            draft.persist(&path)?;
            Ok(())
        };
        write().map_err(BagError::io("write", &path))
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
        let files = vec![FileInformation::new("run_0.mcap", Some((5, 9)), 2)];
        let information = Information::new(files, Vec::new(), awkward.clone());

        information.write_into(folder.path()).unwrap();

        let contents = read(folder.path()).unwrap().unwrap();
        assert_eq!(contents.relative_file_paths, ["run_0.mcap"]);
        assert_eq!(contents.custom_data, Some(awkward));
        let in_record = read_record(&information.to_record()).unwrap();
        assert_eq!(in_record.custom_data, contents.custom_data);
    }

    #[test]
    fn a_bag_lasts_from_its_first_to_its_last_file() {
        let files = [("a_0.mcap", Some((5, 9))), ("a_1.mcap", None), ("a_2.mcap", Some((9, 30)))];
        let files = files.map(|(path, bounds_ns)| FileInformation::new(path, bounds_ns, 0));

        let information = Information::new(files.to_vec(), Vec::new(), BTreeMap::new());

        assert_eq!(information.starting_time.nanoseconds_since_epoch, 5);
        assert_eq!(information.duration.nanoseconds, 25);
    }
}
