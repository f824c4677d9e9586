//! How a bag is laid out on disk.

use mcap::WriteOptions;

/// After so much recorded time everything so far is handed to the system.
const FLUSH_PERIOD_NS: u64 = 1_000_000_000;

/// How the chunks of a file are compressed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Compression {
    /// Not at all, as `ros2 bag record` does by default.
    None,
    /// Small.
    #[default]
    Zstd,
    /// Fast.
    Lz4,
}

/// How a bag is laid out on disk.
///
/// By default: one file, zstd, and everything but the last second of recorded time is safe.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Packing {
    /// How chunks are compressed.
    pub compression: Compression,
    /// A file of this size is closed and another one opened; a chunk (1 MiB before compression) may
    /// still come on top. `None` never splits by size.
    pub max_file_bytes: Option<u64>,
    /// A file with so much recorded time in it, in nanoseconds, is closed and another one opened.
    /// `None` never splits by time.
    pub max_file_duration_ns: Option<u64>,
    /// A bag of this size, all of its files together, takes no more messages; a chunk may still come
    /// on top. `None` goes on until the disk is full.
    pub max_bag_bytes: Option<u64>,
    /// After so much recorded time, in nanoseconds, everything so far is handed to the system.
    /// `None` leaves it to chunks being full, for copies of what is safe elsewhere.
    pub flush_period_ns: Option<u64>,
}

impl Default for Packing {
    fn default() -> Self {
        Self {
            compression: Compression::Zstd,
            max_file_bytes: None,
            max_file_duration_ns: None,
            max_bag_bytes: None,
            flush_period_ns: Some(FLUSH_PERIOD_NS),
        }
    }
}

impl Packing {
    /// The same in the words of the MCAP library.
    pub(super) fn write_options(&self) -> WriteOptions {
        let compression = match self.compression {
            Compression::None => None,
            Compression::Zstd => Some(mcap::Compression::Zstd),
            Compression::Lz4 => Some(mcap::Compression::Lz4),
        };
        WriteOptions::new()
            .profile("ros2")
            .library(concat!("rsrs ", env!("CARGO_PKG_VERSION")))
            .compression(compression)
            // A copy is to keep pace with its original; 0 is what the compression itself prefers.
            .compression_level(u32::from(self.flush_period_ns.is_none()))
            // Chunks of a second are small; threads of their own would cost more than they save.
            .compression_threads(0)
            // A chunk is written whole or not at all: a file that breaks off has no half-filled
            // heads of chunks in it.
            .disable_seeking(true)
    }
}
