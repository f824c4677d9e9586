//! The bytes of a file, whether rosbag2 compressed it or not.

use std::fs::File;
use std::io::{self, BufReader, ErrorKind, Read};
use std::path::Path;

use crate::BagError;

/// What is of this size or less, in bytes, is believed in any file: a damaged length, or one that was
/// made up, must not take all memory.
const ALWAYS_BELIEVED: usize = 64 << 20;

/// Text and numbers hardly compress better than this.
const MAX_COMPRESSION: usize = 64;

/// What a zstd frame starts with.
pub const ZSTD_MAGIC: [u8; 4] = [0x28, 0xb5, 0x2f, 0xfd];

/// What a database of `SQLite` starts with.
const SQLITE_MAGIC: &[u8] = b"SQLite format 3\0";

/// A file from front to back, without the compression that rosbag2 put around it.
pub enum Source {
    /// As it is on disk.
    Plain(BufReader<File>),
    /// A file that was compressed as a whole.
    Zstd(zstd::stream::read::Decoder<'static, BufReader<File>>),
}

impl Source {
    /// Opens a file at its start.
    pub fn open(path: &Path) -> Result<Self, BagError> {
        let io = BagError::io("read", path);
        let mut file = open(path)?;
        if starts_with_zstd(&mut file).map_err(&io)? {
            let decoder = zstd::stream::read::Decoder::new(open(path)?).map_err(io)?;
            return Ok(Self::Zstd(decoder));
        }
        Ok(Self::Plain(BufReader::new(open(path)?)))
    }

    /// Whether rosbag2 compressed the whole file.
    pub fn is_compressed(&self) -> bool {
        matches!(self, Self::Zstd(_))
    }

    /// The longest record or unpacked chunk that is believed, in bytes.
    pub fn record_limit(&self) -> io::Result<usize> {
        match self {
            Self::Plain(source) => record_limit(source.get_ref()),
            Self::Zstd(source) => {
                let n_packed = source.get_ref().get_ref().metadata()?.len();
                Ok(unpacked_limit(usize::try_from(n_packed).unwrap_or(usize::MAX)))
            }
        }
    }
}

impl Read for Source {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        match self {
            Self::Plain(source) => source.read(buffer),
            Self::Zstd(source) => source.read(buffer),
        }
    }
}

/// The longest record that a sound file of this size could hold.
pub fn record_limit(file: &File) -> io::Result<usize> {
    let n_bytes = usize::try_from(file.metadata()?.len()).unwrap_or(usize::MAX);
    Ok(n_bytes.max(ALWAYS_BELIEVED))
}

/// The longest content that so many compressed bytes are believed to hold, in bytes.
pub fn unpacked_limit(n_packed: usize) -> usize {
    n_packed.saturating_mul(MAX_COMPRESSION).max(ALWAYS_BELIEVED)
}

/// Opens a file to be read, which must not be a pipe or a device: those may have no end.
pub fn open(path: &Path) -> Result<File, BagError> {
    rsrs_files::open(path).map_err(BagError::io("open", path))
}

/// Reads some bytes; zero only at the end.
pub fn read_some(source: &mut impl Read, buffer: &mut [u8]) -> io::Result<usize> {
    loop {
        match source.read(buffer) {
            Err(error) if error.kind() == ErrorKind::Interrupted => {}
            outcome => return outcome,
        }
    }
}

fn starts_with_zstd(file: &mut File) -> io::Result<bool> {
    let mut head = Vec::new();
    file.take(ZSTD_MAGIC.len() as u64).read_to_end(&mut head)?;
    Ok(head == ZSTD_MAGIC)
}

/// Refuses what is not an MCAP file, by its first bytes.
pub fn check_magic(source: &mut Source, path: &Path) -> Result<(), BagError> {
    let mut head = Vec::new();
    let read = source.take(SQLITE_MAGIC.len() as u64).read_to_end(&mut head);
    read.map_err(BagError::io("read", path))?;
    let path = path.to_owned();
    if head.is_empty() {
        return Err(BagError::Empty { path });
    }
    if head == SQLITE_MAGIC {
        return Err(BagError::Sqlite { path });
    }
    if head.starts_with(mcap::MAGIC) { Ok(()) } else { Err(BagError::NotMcap { path }) }
}
