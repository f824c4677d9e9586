//! The bytes of a file at any place, without holding the file in memory.

use std::fs::File;
use std::io::{self, BufReader, Read, Seek, SeekFrom};

/// What is read ahead.
const BUFFER_BYTES: usize = 1 << 20;

/// Zeros at the end of a file in such number are not data: the system had promised the space and
/// lost power before it kept the promise.
const MIN_ZERO_TAIL: u64 = 64;

/// A file that can be read anywhere; fast where it is read in order.
pub struct Bytes {
    reader: BufReader<File>,
    position: u64,
    end: u64,
    zero_tail: u64,
}

impl Bytes {
    /// Takes a file that is open for reading.
    pub fn new(mut file: File) -> io::Result<Self> {
        let n_bytes = file.metadata()?.len();
        let zero_tail = zero_tail(&mut file, n_bytes)?;
        file.seek(SeekFrom::Start(0))?;
        let reader = BufReader::with_capacity(BUFFER_BYTES, file);
        Ok(Self { reader, position: 0, end: n_bytes, zero_tail })
    }

    pub fn len(&self) -> u64 {
        self.end
    }

    /// Where nothing but a long run of zeros follows up to the end; the end if there is none.
    pub fn zero_tail(&self) -> u64 {
        self.zero_tail
    }

    /// Reads so many bytes at a place, or as many as there are before the end.
    pub fn read(&mut self, at: u64, n_bytes: usize) -> io::Result<Vec<u8>> {
        let available = usize::try_from(self.end.saturating_sub(at)).unwrap_or(usize::MAX);
        let mut bytes = vec![0; n_bytes.min(available)];
        let by = i64::try_from(i128::from(at) - i128::from(self.position))
            .map_err(|_too_far| io::ErrorKind::InvalidInput)?;
        self.reader.seek_relative(by)?;
        self.position = at;
        let mut n_read = 0;
        while n_read < bytes.len() {
            match self.reader.read(&mut bytes[n_read..]) {
                Ok(0) => break,
                Ok(n_more) => n_read += n_more,
                Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
                Err(error) => return Err(error),
            }
        }
        self.position += n_read as u64;
        bytes.truncate(n_read);
        Ok(bytes)
    }
}

/// Finds the long run of zeros at the end, backwards.
fn zero_tail(file: &mut File, n_bytes: u64) -> io::Result<u64> {
    let mut end = n_bytes;
    let mut block = Vec::new();
    while end > 0 {
        let start = end.saturating_sub(BUFFER_BYTES as u64);
        file.seek(SeekFrom::Start(start))?;
        block.clear();
        file.by_ref().take(end - start).read_to_end(&mut block)?;
        if let Some(last) = block.iter().rposition(|byte| *byte != 0) {
            end = start + last as u64 + 1;
            break;
        }
        end = start;
    }
    Ok(if n_bytes - end >= MIN_ZERO_TAIL { end } else { n_bytes })
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;

    fn bytes_of(content: &[u8]) -> Bytes {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("file");
        fs::write(&path, content).unwrap();
        Bytes::new(File::open(path).unwrap()).unwrap()
    }

    #[test]
    fn bytes_are_read_anywhere_and_never_beyond_the_end() {
        let content: Vec<u8> = (1..=200).collect();
        let mut bytes = bytes_of(&content);

        assert_eq!(bytes.read(10, 3).unwrap(), [11, 12, 13]);
        assert_eq!(bytes.read(0, 2).unwrap(), [1, 2]);
        assert_eq!(bytes.read(198, 9).unwrap(), [199, 200]);
        assert!(bytes.read(500, 9).unwrap().is_empty());
        assert_eq!(bytes.read(5, 1).unwrap(), [6]);
    }

    #[test]
    fn only_a_long_run_of_zeros_is_a_tail() {
        let with_zeros = |n_zeros| [vec![7; 10], vec![0; n_zeros]].concat();

        assert_eq!(bytes_of(&with_zeros(63)).zero_tail(), 73);
        assert_eq!(bytes_of(&with_zeros(64)).zero_tail(), 10);
        assert_eq!(bytes_of(&with_zeros(3 << 20)).zero_tail(), 10);
        assert_eq!(bytes_of(&[]).zero_tail(), 0);
    }
}
