//! What is recorded besides the topics of every run, resolved.

use std::path::{Path, PathBuf};

use anyhow::bail;
use rsrs_bags::definitions::Definitions;
use rsrs_bags::{Compression, Packing};
use rsrs_fleet::experiment::{BagCompression, RecordOptions, bytes};

/// The variable in which ROS 2 lists where packages are installed.
const PREFIXES: &str = "AMENT_PREFIX_PATH";

/// What is recorded besides the topics of every run, and how.
#[derive(Clone, Debug)]
pub struct Recording {
    /// Full names of topics of any type, each once.
    pub topics: Vec<String>,
    /// Where their types are defined.
    pub definitions: Definitions,
    /// How the bag is laid out on disk.
    pub packing: Packing,
}

impl Default for Recording {
    fn default() -> Self {
        let definitions = Definitions::new(Vec::new());
        Self { topics: Vec::new(), definitions, packing: Packing::default() }
    }
}

impl Recording {
    /// Resolves that part of an experiment file, whose folder is `beside`.
    pub(super) fn read(
        options: &RecordOptions,
        beside: &Path,
        robots: &[String],
    ) -> anyhow::Result<Self> {
        let mut folders: Vec<PathBuf> =
            options.definitions.iter().map(|folder| beside.join(folder)).collect();
        if let Some(missing) = folders.iter().find(|folder| !folder.is_dir()) {
            bail!("record.definitions: there is no folder {}", missing.display());
        }
        let prefixes = std::env::var_os(PREFIXES).unwrap_or_default();
        // ROS 2 itself passes over prefixes that have gone.
        folders.extend(std::env::split_paths(&prefixes).filter(|prefix| prefix.is_dir()));
        let packing = Packing {
            compression: match options.compression {
                BagCompression::None => Compression::None,
                BagCompression::Zstd => Compression::Zstd,
                BagCompression::Lz4 => Compression::Lz4,
            },
            max_file_bytes: options.split_gib.map(bytes),
            max_bag_bytes: options.max_bag_gib.map(bytes),
            ..Packing::default()
        };
        let topics = options.topics_of(robots);
        Ok(Self { topics, definitions: Definitions::new(folders), packing })
    }
}
