//! A file on its way from the system to the disk, piece by piece, so that somebody can watch.

use std::fs::File;
use std::io;
use std::path::Path;

/// What is waited for at once: a disk that writes less than this in 10 s is none.
const PIECE_BYTES: u64 = 4 << 20;

/// Puts a file on its disk. Now and then, `goes_on` gets the number of bytes that may not be on the
/// disk yet; when it returns `false`, the rest is left to the system.
pub fn onto_disk(path: &Path, mut goes_on: impl FnMut(u64) -> bool) -> io::Result<()> {
    let file = File::open(path)?;
    let n_bytes = file.metadata()?.len();
    let mut begin = 0;
    while begin < n_bytes {
        if !goes_on(n_bytes - begin) {
            return Ok(());
        }
        let end = n_bytes.min(begin + PIECE_BYTES);
        write_back(&file, begin, end - begin);
        begin = end;
    }
    // Also what is not content: length, times, the directory's journal.
    file.sync_all()?;
    goes_on(0);
    Ok(())
}

/// Has a part of a file written, and waits for it. Where that fails, the whole file is waited for at
/// the end, and reports the error.
#[cfg(target_os = "linux")]
#[expect(unsafe_code, reason = "a system call without a safe wrapper")]
fn write_back(file: &File, begin: u64, n_bytes: u64) {
    use std::os::fd::AsRawFd;

    let (Ok(begin), Ok(n_bytes)) = (begin.try_into(), n_bytes.try_into()) else { return };
    let all = libc::SYNC_FILE_RANGE_WAIT_BEFORE
        | libc::SYNC_FILE_RANGE_WRITE
        | libc::SYNC_FILE_RANGE_WAIT_AFTER;
    // SAFETY: it takes no pointers, and the file stays open meanwhile.
    unsafe { libc::sync_file_range(file.as_raw_fd(), begin, n_bytes, all) };
}

#[cfg(not(target_os = "linux"))]
fn write_back(_file: &File, _begin: u64, _n_bytes: u64) {}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_left_falls_piece_by_piece_to_nothing() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("file");
        std::fs::write(&path, vec![1; 9 << 20]).unwrap();
        let mut left = Vec::new();

        let take = |n_bytes| {
            left.push(n_bytes);
            true
        };
        onto_disk(&path, take).unwrap();

        assert_eq!(left, [9 << 20, 5 << 20, 1 << 20, 0]);
        assert!(onto_disk(&folder.path().join("none"), |_| true).is_err());
    }
}
