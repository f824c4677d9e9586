//! A 64-bit digest of a sequence of words, the same on every machine.

/// Digest of a sequence of 64-bit words (FNV-1a over bytes, then mixed).
///
/// It names conditions, parameters and world states. It is not cryptographic: it tells
/// things apart that differ by accident, and does not withstand an adversary.
///
/// # Example
///
/// ```
/// use rsrs_core::digest::Digest;
///
/// let mut digest = Digest::new("example");
/// digest.number(0.15);
/// assert_ne!(digest.value(), Digest::new("example").value());
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Digest {
    state: u64,
}

const OFFSET: u64 = 0xcbf2_9ce4_8422_2325;
const PRIME: u64 = 0x0000_0100_0000_01b3;

impl Digest {
    /// Starts a digest in a domain of its own, so that equal words of different meaning differ.
    pub fn new(domain: &str) -> Self {
        let mut digest = Self { state: OFFSET };
        digest.text(domain);
        digest
    }

    /// Adds bytes, in order.
    pub fn bytes(&mut self, bytes: &[u8]) {
        for byte in bytes {
            self.state = (self.state ^ u64::from(*byte)).wrapping_mul(PRIME);
        }
    }

    /// Adds a text with its length, so that `("ab", "c")` and `("a", "bc")` differ.
    pub fn text(&mut self, text: &str) {
        self.word(text.len() as u64);
        self.bytes(text.as_bytes());
    }

    /// Adds one word, little-endian.
    pub fn word(&mut self, word: u64) {
        self.bytes(&word.to_le_bytes());
    }

    /// Adds the bits of a number.
    pub fn number(&mut self, number: f64) {
        self.word(number.to_bits());
    }

    /// The digest of all that was added so far.
    pub fn value(self) -> u64 {
        mix(self.state)
    }
}

/// Spreads every input bit over all output bits (the finaliser of `SplitMix64`).
///
/// # Source
///
/// Steele, Lea, Flood, "Fast splittable pseudorandom number generators", OOPSLA 2014, with Stafford's
/// variant 13 of the constants.
pub fn mix(word: u64) -> u64 {
    let word = (word ^ (word >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let word = (word ^ (word >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    word ^ (word >> 31)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_digest_of_known_words_is_known() {
        let mut digest = Digest::new("golden");
        digest.word(1);
        digest.number(-0.0);

        assert_eq!(digest.value(), 0x4b9b_b9a7_16f7_bea3);
    }

    #[test]
    fn texts_do_not_run_into_each_other() {
        let mut left = Digest::new("d");
        left.text("ab");
        left.text("c");
        let mut right = Digest::new("d");
        right.text("a");
        right.text("bc");

        assert_ne!(left.value(), right.value());
    }
}
