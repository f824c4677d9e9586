//! Why a bag could not be written or read.

use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use mcap::McapError;
use rsrs_core::document::DocumentError;
use rsrs_core::help::Help;

/// Why a bag could not be written or read.
#[expect(missing_docs, reason = "fields are what the message names")]
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum BagError {
    /// There is something where the bag is to go.
    #[error("{} exists already", .path.display())]
    Exists { path: PathBuf },
    /// The path has no last part that could name the bag.
    #[error("{} does not name a folder for a bag", .path.display())]
    NoName { path: PathBuf },
    /// The system refused.
    #[error("cannot {action} {}", .path.display())]
    Io { action: &'static str, path: PathBuf, source: std::io::Error },
    /// A record could not be written.
    #[error("cannot record into {}", .path.display())]
    Write { path: PathBuf, source: McapError },
    /// The bag has the size that it may have.
    #[error(
        "{} is full: it has reached its limit of {max_bytes} bytes, and nothing more is recorded",
        .path.display()
    )]
    Full { path: PathBuf, max_bytes: u64 },
    /// No definition is known of the type, and a bag without it could not be opened.
    #[error("topic {topic} has type {type_name}, of which no definition is known")]
    UnknownType { topic: String, type_name: String },
    /// A topic was added twice.
    #[error("topic {topic} is recorded already")]
    DuplicateTopic { topic: String },
    /// A folder holds no recording.
    #[error("{} holds no .mcap file", .path.display())]
    NoFiles { path: PathBuf },
    /// A file without a byte.
    #[error("{} is empty", .path.display())]
    Empty { path: PathBuf },
    /// A file that was compressed as a whole, and unpacks to more than it is believed to hold.
    #[error(
        "{} holds more than {limit_bytes} bytes, {} times its size",
        .path.display(),
        .limit_bytes / (*.n_packed).max(1)
    )]
    TooLarge { path: PathBuf, n_packed: u64, limit_bytes: u64 },
    /// A file of another kind.
    #[error("{} is not an MCAP file", .path.display())]
    NotMcap { path: PathBuf },
    /// A bag in the format that ROS 2 used before MCAP.
    #[error("{} is in SQLite format, expected MCAP", .path.display())]
    Sqlite { path: PathBuf },
    /// An MCAP file of another world than ROS 2.
    #[error("{} has MCAP profile {found:?}, expected \"ros2\"", .path.display())]
    Profile { path: PathBuf, found: String },
    /// `metadata.yaml` does not list the files of the bag.
    #[error("{source}")]
    Metadata { path: PathBuf, source: Box<DocumentError> },
    /// Nothing of a damaged bag could be saved.
    #[error("{} holds nothing that could be saved", .path.display())]
    NothingSaved { path: PathBuf },
    /// The end of a file is missing or damaged; everything before it was read.
    #[error(
        "{} breaks off after {n_messages} messages{}",
        .path.display(),
        last_time(*.last_log_time_ns)
    )]
    Incomplete { path: PathBuf, n_messages: u64, last_log_time_ns: Option<u64>, source: McapError },
}

impl BagError {
    /// That a file or folder cannot be read, or whatever was to be done with it.
    pub(crate) fn io(action: &'static str, path: &Path) -> impl Fn(std::io::Error) -> Self {
        move |source| Self::Io { action, path: path.to_owned(), source }
    }
}

impl Help for BagError {
    fn help(&self) -> Option<String> {
        let help = match self {
            Self::Exists { .. } => "choose another folder, or move this one away",
            Self::NoFiles { .. } => {
                "give the folder that holds metadata.yaml, or the .mcap file itself"
            }
            Self::Sqlite { .. } => {
                "convert it: `echo 'output_bags: [{uri: BAG_mcap, storage_id: mcap, all: true}]' \
                 > convert.yaml && ros2 bag convert -i BAG -o convert.yaml`"
            }
            Self::Incomplete { .. } => "what was recorded before the break can be used as it is",
            Self::Full { .. } => "close it and raise the limit, or record into another one",
            Self::Empty { .. } => {
                "nothing was recorded: the recorder ended before it wrote anything, or has just begun"
            }
            Self::NotMcap { .. } => {
                "give a bag of ROS 2: a folder as `ros2 bag record --storage mcap` makes it, or a \
                 .mcap file"
            }
            Self::Profile { .. } => {
                "convert it into a bag of ROS 2 first: that of ROS 1 by `rosbags-convert`"
            }
            Self::Metadata { .. } => {
                "mend it or move it away: bags are read without it, too, and `rsrs bag recover BAG` \
                 writes it anew"
            }
            Self::TooLarge { .. } => {
                "if you trust where it comes from, give a larger `--unpack-limit` and the space"
            }
            Self::NothingSaved { .. } => "nothing was recorded, or the damage took all of it",
            Self::Io { source, .. } if source.kind() == ErrorKind::NotFound => {
                "give the folder that holds metadata.yaml, or the .mcap file itself"
            }
            Self::NoName { .. }
            | Self::Io { .. }
            | Self::Write { .. }
            | Self::UnknownType { .. }
            | Self::DuplicateTopic { .. } => return None,
        };
        Some(help.to_owned())
    }
}

/// Up to when, in seconds of log time.
fn last_time(last_log_time_ns: Option<u64>) -> String {
    match last_log_time_ns {
        Some(time_ns) => format!(", at {:.3} s", time_ns as f64 / 1e9),
        None => String::new(),
    }
}
