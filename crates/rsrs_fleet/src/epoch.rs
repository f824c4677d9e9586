//! Epochs: runs are counted up, and a robot obeys none that is older than the newest it has
//! received.
//!
//! A runner takes the highest epoch that it has received, plus one. A number far beyond that was made
//! by no runner: obeyed, it would bind a robot for ever, or leave no number above it.

/// Two consecutive epochs of one robot are less than this apart, however many runs it has missed.
const MOST_MISSED: u64 = 1 << 32;

/// An epoch that no runner made.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "epoch {found} refused, expected at most {} after epoch {highest}: epochs count runs up from 1",
    highest.saturating_add(MOST_MISSED)
)]
pub struct ImplausibleEpoch {
    /// The epoch found.
    pub found: u64,
    /// The highest that was received before.
    pub highest: u64,
}

/// Whether a runner can have made this epoch, judged by the highest one that was received so far; 0
/// is none.
///
/// Lower epochs are not refused here: they are old, not impossible.
pub fn check(found: u64, highest: u64) -> Result<u64, ImplausibleEpoch> {
    // The upper half of all numbers stays free, so that there is always one above.
    if found > u64::MAX / 2 || found.saturating_sub(highest) > MOST_MISSED {
        return Err(ImplausibleEpoch { found, highest });
    }
    Ok(found)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_runners_count_is_taken_and_what_they_never_reach_is_refused() {
        assert_eq!(check(1, 0), Ok(1));
        assert_eq!(check(7, 9_000), Ok(7));
        assert_eq!(check(9_000 + MOST_MISSED, 9_000), Ok(9_000 + MOST_MISSED));
        for (found, highest) in
            [(u64::MAX, 0), (u64::MAX - 1, u64::MAX / 2), (9_001 + MOST_MISSED, 9_000)]
        {
            assert_eq!(check(found, highest), Err(ImplausibleEpoch { found, highest }));
        }
        let refused = check(u64::MAX, 3).unwrap_err().to_string();
        assert!(refused.starts_with("epoch 18446744073709551615 refused, expected at most"));
    }
}
