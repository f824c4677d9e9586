//! What a record of MCAP looks like, strictly: damaged bytes must not pass for one.
//!
//! # Source
//!
//! The MCAP specification, version 0. Every length that a record states twice is compared.

use mcap::records::op;

/// Opcode and length in front of each record.
pub const HEAD_BYTES: usize = 9;

/// Start, end, size, checksum, length of a name, that name, compressed size.
const CHUNK_FIXED_BYTES: usize = 8 + 8 + 8 + 4 + 4 + 8;

/// The longest name of a compression.
const MAX_COMPRESSION_NAME: usize = 4;

/// What must be read of a chunk to know its head.
pub const MAX_CHUNK_HEAD_BYTES: usize = CHUNK_FIXED_BYTES + MAX_COMPRESSION_NAME;

/// What stands in front of a message's data.
pub const MESSAGE_HEAD_BYTES: usize = 2 + 4 + 8 + 8;

/// The representations of CDR that there are.
const MAX_ENCAPSULATION: u8 = 0x0b;

/// Opcode and length of the record that starts here.
pub fn head(bytes: &[u8]) -> Option<(u8, u64)> {
    let (&opcode, rest) = bytes.split_first()?;
    let length = rest.first_chunk::<8>()?;
    Some((opcode, u64::from_le_bytes(*length)))
}

/// Whether records of this kind exist; private ones are not ours to keep.
pub fn is_known(opcode: u8) -> bool {
    (op::HEADER..=op::DATA_END).contains(&opcode)
}

/// Whether records of this kind stand in chunks, where there are any.
pub fn may_be_in_chunks(opcode: u8) -> bool {
    [op::SCHEMA, op::CHANNEL, op::MESSAGE].contains(&opcode)
}

/// What a chunk says of itself.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ChunkHead {
    /// First and last log time, in nanoseconds.
    pub bounds_ns: (u64, u64),
    /// Bytes of its content before compression.
    pub uncompressed_size: u64,
    /// Checksum of its content; 0 if the recorder made none.
    pub crc: u32,
    /// Empty, `zstd` or `lz4`.
    pub compression: String,
    /// Bytes of its content as it is in the file.
    pub compressed_size: u64,
    /// Bytes in front of the content, without opcode and length of the record.
    pub n_head_bytes: usize,
}

impl ChunkHead {
    /// Reads the head; `None` if it is none.
    pub fn parse(body: &[u8]) -> Option<Self> {
        let mut fields = Fields(body);
        let bounds_ns = (fields.u64()?, fields.u64()?);
        let uncompressed_size = fields.u64()?;
        let crc = fields.u32()?;
        let compression = fields.text()?;
        if !["", "zstd", "lz4"].contains(&compression) {
            return None;
        }
        let compressed_size = fields.u64()?;
        let n_head_bytes = CHUNK_FIXED_BYTES + compression.len();
        let compression = compression.to_owned();
        Some(Self { bounds_ns, uncompressed_size, crc, compression, compressed_size, n_head_bytes })
    }

    /// Whether the record's length and the chunk's own agree.
    pub fn fits(&self, length: u64) -> bool {
        self.compressed_size.checked_add(self.n_head_bytes as u64) == Some(length)
    }

    /// Whether the record holds the chunk; MCAP allows more bytes behind it.
    pub fn is_within(&self, length: u64) -> bool {
        let end = self.compressed_size.checked_add(self.n_head_bytes as u64);
        end.is_some_and(|end| end <= length)
    }

    /// Whether there is a content: a head out of zeros is none.
    pub fn is_filled(&self) -> bool {
        self.compressed_size > 0 && self.uncompressed_size > 0
    }

    /// Whether it was never filled in: some recorders write heads last.
    pub fn is_open(&self, length: u64) -> bool {
        length == u64::MAX && self.compressed_size == u64::MAX
    }
}

/// Whether a record other than a chunk is sound as far as its lengths tell.
pub fn is_sound(opcode: u8, body: &[u8]) -> bool {
    fields_of(opcode, body).is_some_and(|n_behind| n_behind == 0)
}

/// Whether a record other than a chunk has all of its fields; MCAP allows more bytes behind them.
pub fn is_readable(opcode: u8, body: &[u8]) -> bool {
    fields_of(opcode, body).is_some()
}

/// How many bytes stand behind the fields of a record; `None` if not all of these are there.
fn fields_of(opcode: u8, body: &[u8]) -> Option<usize> {
    let mut fields = Fields(body);
    let read = match opcode {
        op::HEADER => fields.text().and_then(|_| fields.text()).map(|_| ()),
        op::FOOTER => fields.skip(20),
        op::SCHEMA => fields.schema(),
        op::CHANNEL => fields.channel(),
        op::MESSAGE => return (body.len() >= MESSAGE_HEAD_BYTES).then_some(0),
        op::MESSAGE_INDEX => fields.message_index(),
        op::ATTACHMENT => fields.attachment(),
        op::METADATA => fields.text().and_then(|_| fields.sized()).map(|_| ()),
        op::DATA_END => fields.skip(4),
        // The rest stands behind the data, where nothing is to be saved.
        _ => return mcap::parse_record(opcode, body).is_ok().then_some(0),
    };
    read.map(|()| fields.0.len())
}

/// Whether the data of a message starts as ROS 2 writes it, or is compressed by rosbag2.
pub fn is_like_cdr(data: &[u8]) -> bool {
    match data {
        [0, kind, _, _, ..] => *kind <= MAX_ENCAPSULATION,
        _ => data.starts_with(&[0x28, 0xb5, 0x2f, 0xfd]),
    }
}

/// Fields that are taken from the front.
struct Fields<'a>(&'a [u8]);

impl<'a> Fields<'a> {
    fn take(&mut self, n_bytes: usize) -> Option<&'a [u8]> {
        let (taken, rest) = self.0.split_at_checked(n_bytes)?;
        self.0 = rest;
        Some(taken)
    }

    fn skip(&mut self, n_bytes: usize) -> Option<()> {
        self.take(n_bytes).map(|_| ())
    }

    fn u32(&mut self) -> Option<u32> {
        Some(u32::from_le_bytes(*self.take(4)?.first_chunk()?))
    }

    fn u64(&mut self) -> Option<u64> {
        Some(u64::from_le_bytes(*self.take(8)?.first_chunk()?))
    }

    /// Bytes behind their length.
    fn sized(&mut self) -> Option<&'a [u8]> {
        let length = usize::try_from(self.u32()?).ok()?;
        self.take(length)
    }

    fn text(&mut self) -> Option<&'a str> {
        std::str::from_utf8(self.sized()?).ok()
    }

    /// Number, name, encoding, text.
    fn schema(&mut self) -> Option<()> {
        self.skip(2)?;
        self.text()?;
        self.text()?;
        self.sized().map(|_| ())
    }

    /// Two numbers, topic, encoding, pairs.
    fn channel(&mut self) -> Option<()> {
        self.skip(4)?;
        self.text()?;
        self.text()?;
        let mut pairs = Fields(self.sized()?);
        while !pairs.0.is_empty() {
            pairs.text()?;
            pairs.text()?;
        }
        Some(())
    }

    /// Channel, then pairs of time and offset.
    fn message_index(&mut self) -> Option<()> {
        self.skip(2)?;
        let entries = self.sized()?;
        entries.len().is_multiple_of(16).then_some(())
    }

    /// Two times, name, kind, data behind a length of 8 bytes, checksum.
    fn attachment(&mut self) -> Option<()> {
        self.skip(16)?;
        self.text()?;
        self.text()?;
        let length = usize::try_from(self.u64()?).ok()?;
        self.skip(length)?;
        self.skip(4)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn chunk(compression: &str, compressed_size: u64) -> Vec<u8> {
        let mut body = [5_u64, 9, 100].map(u64::to_le_bytes).concat();
        body.extend(77_u32.to_le_bytes());
        body.extend(u32::try_from(compression.len()).unwrap().to_le_bytes());
        body.extend(compression.as_bytes());
        body.extend(compressed_size.to_le_bytes());
        body
    }

    #[test]
    fn a_chunk_is_known_by_its_two_lengths() {
        let head = ChunkHead::parse(&chunk("zstd", 30)).unwrap();

        assert_eq!((head.bounds_ns, head.crc, head.n_head_bytes), ((5, 9), 77, 44));
        assert!(head.fits(74));
        assert!(!head.fits(75));
        assert_eq!(ChunkHead::parse(&chunk("gzip", 30)), None);
        assert_eq!(ChunkHead::parse(&chunk("zstd", 30)[..40]), None);
    }

    #[test]
    fn a_record_with_a_byte_too_many_or_too_few_is_not_sound() {
        let mut channel = vec![1, 0, 1, 0];
        for text in ["/a", "cdr", ""] {
            channel.extend(u32::try_from(text.len()).unwrap().to_le_bytes());
            channel.extend(text.as_bytes());
        }

        assert!(is_sound(op::CHANNEL, &channel));
        assert!(!is_sound(op::CHANNEL, &channel[1..]));
        assert!(!is_sound(op::CHANNEL, &[channel, vec![0]].concat()));
        assert!(!is_sound(op::MESSAGE_INDEX, &[1, 0, 15, 0, 0, 0]));
        assert!(is_sound(op::DATA_END, &[0; 4]));
    }
}
