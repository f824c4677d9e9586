//! The content of chunks, out of its compression.

use std::io::Read;

/// What unpacks one chunk after the other.
pub struct Unpacker {
    zstd: Option<zstd::bulk::Decompressor<'static>>,
}

impl Unpacker {
    /// An unpacker for any compression that there is.
    pub fn new() -> Self {
        // Without memory for it every zstd chunk is refused.
        Self { zstd: zstd::bulk::Decompressor::new().ok() }
    }

    /// Unpacks the content of a chunk.
    ///
    /// # Arguments
    ///
    /// * `compression` — empty, `zstd` or `lz4`.
    /// * `size` — how many bytes it must give.
    /// * `buffer` — what was in it is gone.
    ///
    /// # Errors
    ///
    /// What is wrong, in words.
    pub fn unpack(
        &mut self,
        (compression, packed): (&str, &[u8]),
        size: usize,
        buffer: &mut Vec<u8>,
    ) -> Result<(), String> {
        buffer.clear();
        match compression {
            "" => buffer.extend_from_slice(packed),
            "zstd" => {
                let zstd = self.zstd.as_mut().ok_or("there is no memory for zstd")?;
                buffer.reserve_exact(size);
                let unpacked = zstd.decompress_to_buffer(packed, buffer);
                unpacked.map_err(|error| error.to_string())?;
            }
            "lz4" => {
                buffer.reserve(size + 1);
                // One byte more than expected would show that the size is wrong.
                let decoder = lz4::Decoder::new(packed).map_err(|error| error.to_string())?;
                let read = decoder.take(size as u64 + 1).read_to_end(buffer);
                read.map_err(|error| error.to_string())?;
            }
            other => return Err(format!("its compression is {other}, expected zstd or lz4")),
        }
        if buffer.len() == size {
            Ok(())
        } else {
            Err(format!("it has {} bytes, expected {size}", buffer.len()))
        }
    }
}
