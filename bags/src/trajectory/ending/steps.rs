//! Times between messages, counted in little memory, and how many are above a limit: exactly, or not
//! at all.

use std::collections::BTreeMap;

/// Bits of a number that tell its bucket: numbers in one differ by at most one in 512.
const PRECISION_BITS: u32 = 10;

/// Numbers that are nearly the same.
#[derive(Clone, Copy)]
struct Bucket {
    n: u64,
    sum: u64,
    least: u64,
    most: u64,
}

/// Counted times between messages, in nanoseconds.
#[derive(Default)]
pub struct Steps {
    buckets: BTreeMap<(u32, u64), Bucket>,
    /// Those up to here are not counted.
    pub uncounted_ns: u64,
}

/// What is above a limit.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Above {
    /// How many.
    pub n: u64,
    /// Their sum, in nanoseconds.
    pub sum_ns: u64,
}

impl Steps {
    /// Counts a time.
    pub fn add(&mut self, step_ns: u64) {
        if step_ns <= self.uncounted_ns {
            return;
        }
        let shift = (u64::BITS - step_ns.leading_zeros()).saturating_sub(PRECISION_BITS);
        let none = Bucket { n: 0, sum: 0, least: u64::MAX, most: 0 };
        let bucket = self.buckets.entry((shift, step_ns >> shift)).or_insert(none);
        bucket.n += 1;
        bucket.sum = bucket.sum.saturating_add(step_ns);
        bucket.least = bucket.least.min(step_ns);
        bucket.most = bucket.most.max(step_ns);
    }

    /// What is above a limit; `None` where that was not counted finely enough to tell.
    pub fn above(&self, limit_ns: u64) -> Option<Above> {
        if limit_ns < self.uncounted_ns {
            return None;
        }
        let mut above = Above::default();
        for bucket in self.buckets.values().filter(|bucket| bucket.most > limit_ns) {
            if bucket.least <= limit_ns {
                return None;
            }
            above.n += bucket.n;
            above.sum_ns = above.sum_ns.saturating_add(bucket.sum);
        }
        Some(above)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_above_a_limit_is_counted_exactly_or_not_told() {
        let mut steps = Steps::default();
        for step_ns in [130_000_000, 130_000_001, 260_000_000, 390_000_017] {
            steps.add(step_ns);
        }

        assert_eq!(steps.above(195_000_000), Some(Above { n: 2, sum_ns: 650_000_017 }));
        assert_eq!(steps.above(390_000_017), Some(Above::default()));
        assert_eq!(steps.above(0), Some(Above { n: 4, sum_ns: 910_000_018 }));
        // Two times in one bucket, of which one is above.
        assert_eq!(steps.above(130_000_000), None);
    }

    #[test]
    fn what_was_not_counted_is_not_told() {
        let mut steps = Steps { uncounted_ns: 150, ..Steps::default() };
        steps.add(130);
        steps.add(260);

        assert_eq!(steps.above(195), Some(Above { n: 1, sum_ns: 260 }));
        assert_eq!(steps.above(100), None);
    }
}
